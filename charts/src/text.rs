//! The figures' font: its bytes, its family name, and how wide a text is in it.

use std::borrow::Cow;
use std::fmt::Write;

use skrifa::{FontRef, MetadataProvider};

use crate::letters;

/// Font families of the SVG files; the first one is embedded for the PNG files.
pub const FAMILIES: &str = "Noto Sans, Helvetica Neue, Arial, sans-serif";
/// The embedded family.
pub const EMBEDDED_FAMILY: &str = "Noto Sans";
/// The embedded faces, regular and bold.
pub const FACES: [&[u8]; 2] = [notosans::REGULAR_TTF, notosans::BOLD_TTF];

/// Width of a text in px at a font size in px. PNGs show boxes for letters that the font lacks, and browsers letters of other fonts, which
/// are wider: up to one em.
#[must_use]
pub fn width(text: &str, size: f64, bold: bool) -> f64 {
    pieces(text).map(|(letters, relative)| relative * size * letters::width(&letters, bold)).sum()
}

/// A text that is no wider than this: the beginning with an ellipsis, if it has to be.
#[must_use]
pub fn shortened(text: &str, size: f64, bold: bool, width: f64) -> Cow<'_, str> {
    // Letters are not so narrow: what comes later need not be looked at.
    const NARROWEST: f64 = 0.1;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // thousands at most
    let most = (width / (NARROWEST * size)).clamp(1.0, 1e4) as usize;
    // Where letters begin; a text that is not longer ends there, too.
    let mut ends: Vec<usize> = text.char_indices().map(|(place, _)| place).take(most + 1).collect();
    if ends.len() <= most {
        if self::width(text, size, bold) <= width {
            return Cow::Borrowed(text);
        }
        ends.push(text.len());
    }
    let beginning = |end: &usize| format!("{}\u{2026}", text[..*end].trim_end());
    // A text with more letters is wider.
    let fits = ends.partition_point(|end| self::width(&beginning(end), size, bold) <= width);
    Cow::Owned(beginning(&ends[fits.saturating_sub(1)]))
}

/// The pieces of a text that are shaped by themselves, and their sizes: as [`with_shifts`] writes them.
fn pieces(text: &str) -> impl Iterator<Item = (String, f64)> {
    let mut letters = text.chars().peekable();
    // What follows shifted letters is a piece of one letter.
    let mut was_shifted = false;
    std::iter::from_fn(move || {
        let first = letters.next()?;
        let Some((plain, _)) = shifted(first) else {
            let mut piece = String::from(first);
            if !std::mem::take(&mut was_shifted) {
                while let Some(next) = letters.next_if(|next| shifted(*next).is_none()) {
                    piece.push(next);
                }
            }
            return Some((piece, 1.0));
        };
        let mut piece = String::from(plain);
        while let Some((plain, _)) = letters.peek().and_then(|next| shifted(*next)) {
            piece.push(plain);
            letters.next();
        }
        was_shifted = true;
        Some((piece, SMALL))
    })
}

/// Size of raised and lowered letters relative to their text.
const SMALL: f64 = 0.7;

/// The plain letter of a subscript or superscript that the embedded font lacks, and the offset by which to lower it, in em.
fn shifted(letter: char) -> Option<(char, f64)> {
    let digit = |zero: u32| char::from_u32(u32::from(letter) - zero + u32::from('0'));
    match letter {
        '₀'..='₉' => Some((digit(0x2080)?, 0.25)),
        '⁴'..='⁹' => Some((digit(0x2070)?, -0.5)),
        '⁻' => Some(('\u{2212}', -0.5)),
        _ => None,
    }
}

/// Writes subscripts and superscripts of an SVG document as small shifted letters.
#[must_use]
pub fn with_shifts(svg: &str) -> String {
    let mut result = String::with_capacity(svg.len());
    let mut letters = svg.chars().peekable();
    while let Some(letter) = letters.next() {
        let Some((plain, shift)) = shifted(letter) else {
            result.push(letter);
            continue;
        };
        let _ = write!(result, "<tspan dy=\"{shift}em\" font-size=\"{}%\">{plain}", 100.0 * SMALL);
        while let Some((plain, _)) = letters.peek().and_then(|next| shifted(*next)) {
            result.push(plain);
            letters.next();
        }
        result.push_str("</tspan>");
        // The shift holds for everything after it, so the next letter takes it back.
        if let Some(next) = letters.next_if(|next| *next != '\n' && *next != '<') {
            let _ = write!(result, "<tspan dy=\"{}em\">{next}</tspan>", -SMALL * shift);
        }
    }
    result
}

/// Letters of a text that the embedded font lacks.
#[must_use]
pub fn missing(text: &str) -> Vec<char> {
    let glyphs = face(false).charmap();
    text.chars().filter(|letter| shifted(*letter).is_none() && glyphs.map(*letter).is_none()).collect()
}

pub(crate) fn face(bold: bool) -> FontRef<'static> {
    FontRef::new(FACES[usize::from(bold)]).expect("the embedded fonts are sound")
}

/// A number with `decimals` digits after the point and a proper minus sign.
#[must_use]
pub fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|digit| matches!(digit, '0' | '.')) => digits.to_owned(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_real_minus_and_no_negative_zero() {
        assert_eq!(number(-0.25, 1), "\u{2212}0.2");
        assert_eq!(number(-0.01, 1), "0.0");
        assert_eq!(number(3.0, 0), "3");
    }

    #[test]
    fn the_font_has_the_symbols_of_the_figures() {
        assert_eq!(missing("τθελμπ₁₂·‖±°−–—×≤ÊŴÛĴ̂ᵈ"), Vec::<char>::new());
        assert!(width("mm", 10.0, true) > width("mm", 10.0, false));
        assert!(width("f₁", 10.0, false) < width("f1", 10.0, false));
    }

    #[test]
    fn a_text_is_as_wide_as_what_is_drawn() {
        for text in ["漢字 To", "AV", "τ₁ (N·m)", "f₁₂A VAT₃", "10⁻⁶ kg", "", "😀 m̂", "₁", "a\u{200d}b"]
        {
            let svg = format!("<svg><text font-size='20'>{}</text></svg>", with_shifts(text));
            let document = roxmltree::Document::parse(&svg).unwrap();
            let drawn =
                letters::placed(document.descendants().find(|node| node.has_tag_name("text")).unwrap()).unwrap();
            let end = drawn.last().map_or(0.0, |last| last.x + last.outline.width() * last.scale);
            let beyond = width(text, 20.0, false) - end;
            let most = 20.0 * missing(text).len() as f64;
            assert!((-1e-9..=most + 1e-9).contains(&beyond), "{beyond} {text}");
        }
        assert!((width("漢字", 10.0, false) - 20.0).abs() < 1e-9, "as wide as in other fonts");
    }

    #[test]
    fn long_texts_end_with_an_ellipsis_and_fit() {
        for text in ["A title of words ".repeat(30), "漢".repeat(500), "i".repeat(100_000), "é₁".repeat(400)] {
            for bold in [false, true] {
                let short = shortened(&text, 15.0, bold, 600.0);
                let wide = width(&short, 15.0, bold);
                assert!(short.ends_with('…') && (550.0..=600.0).contains(&wide), "{wide} {short}");
                assert!(text.starts_with(short.trim_end_matches('…')));
            }
        }
        assert_eq!(shortened("short", 15.0, true, 600.0), "short");
        assert_eq!((shortened("none", 15.0, true, 1.0), shortened("", 15.0, true, 0.0)), ("…".into(), "".into()));
    }

    #[test]
    fn shifted_letters_are_small_and_what_follows_is_as_before() {
        assert_eq!(
            with_shifts("<text>\nτ₁ (N)</text><text>\nf₂\n</text>"),
            "<text>\nτ<tspan dy=\"0.25em\" font-size=\"70%\">1</tspan><tspan dy=\"-0.175em\"> </tspan>(N)</text>\
             <text>\nf<tspan dy=\"0.25em\" font-size=\"70%\">2</tspan>\n</text>"
        );
        let label = "10<tspan dy=\"-0.5em\" font-size=\"70%\">\u{2212}6</tspan><tspan dy=\"0.35em\"> </tspan>kg";
        assert_eq!(with_shifts("10⁻⁶ kg"), label);
    }
}

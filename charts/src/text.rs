//! The figures' font: its bytes, its family name, and how wide a text is in it.

use std::fmt::Write;

use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, MetadataProvider};

/// Font families of the SVG files; the first one is embedded for the PNG files.
pub const FAMILIES: &str = "Noto Sans, Helvetica Neue, Arial, sans-serif";
/// The embedded family.
pub const EMBEDDED_FAMILY: &str = "Noto Sans";
/// The embedded faces, regular and bold.
pub const FACES: [&[u8]; 2] = [notosans::REGULAR_TTF, notosans::BOLD_TTF];

/// Width of a text in px at a font size in px.
#[must_use]
pub fn width(text: &str, size: f64, bold: bool) -> f64 {
    let font = face(bold);
    #[allow(clippy::cast_possible_truncation)] // font sizes are small numbers
    let metrics = font.glyph_metrics(Size::new(size as f32), LocationRef::default());
    let glyphs = font.charmap();
    let advance = |letter: char| metrics.advance_width(glyphs.map(letter)?).map(f64::from);
    text.chars()
        .filter_map(|letter| {
            shifted(letter).map_or_else(|| advance(letter), |(plain, _)| Some(SMALL * advance(plain)?))
        })
        .sum()
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

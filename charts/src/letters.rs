//! The letters of an SVG as paths of the embedded font, for pixels and PDF.
//!
//! What draws the SVG draws no texts: it would read the font's tables anew for each of them, which was a quarter of the time for a
//! comparison. Most labels come again, if not in the same figure, then in the next one: here each is shaped once.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt::Write;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use harfrust::{Direction, Script, ShapeOptions, ShapePlan, ShaperData, UnicodeBuffer};
use resvg::tiny_skia::{Path, PathBuilder, PathSegment, Transform};
use roxmltree::Node;
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlineGlyphCollection, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};

use crate::text::{EMBEDDED_FAMILY, face};

/// The same document with texts as paths.
///
/// # Errors
/// When it is not well-formed, or the looks of a text depend on anything else than this module knows.
pub(crate) fn outlined(svg: &str) -> Result<String, String> {
    let document = roxmltree::Document::parse(svg).map_err(|error| error.to_string())?;
    let mut drawn = String::with_capacity(2 * svg.len());
    let mut done = 0;
    let has_style = document.descendants().any(|node| node.tag_name().name() == "style");
    for node in document.descendants().filter(|node| node.tag_name().name() == "text") {
        let range = node.range();
        let Some(paths) = paths(node).filter(|_| !has_style) else {
            return Err(format!("no letters for {}", &svg[range]));
        };
        drawn += &svg[done..range.start];
        drawn += &paths;
        done = range.end;
    }
    Ok(drawn + &svg[done..])
}

/// Attributes of a text that say the same of a path.
const KEPT: [&str; 4] = ["fill", "fill-opacity", "stroke-opacity", "opacity"];
/// Further ones of a text, which this module understands.
const KNOWN: [&str; 8] = ["x", "y", "dy", "text-anchor", "font-family", "font-size", "font-weight", "transform"];
/// Attributes of elements around a text that do not change its letters, or change a path in the same way.
const AROUND: [&str; 10] = [
    "width",
    "height",
    "viewBox",
    "role",
    "font-family",
    "fill",
    "fill-opacity",
    "stroke-linejoin",
    "opacity",
    "transform",
];

/// Letters of one size, and where they are: `scale` times the units of their font, upwards from this point.
pub(crate) struct Placed {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) scale: f64,
    pub(crate) outline: Arc<Outline>,
}

/// A text as paths, if its looks are known.
fn paths(text: Node) -> Option<String> {
    let plain = |name: &str| match text.attribute(name) {
        Some(value) if value.contains(['"', '&', '<']) => None,
        value => Some(value),
    };
    let mut looks = String::new();
    for name in KEPT {
        if let Some(value) = plain(name)? {
            let _ = write!(looks, " {name}=\"{value}\"");
        }
    }
    let around = plain("transform")?.unwrap_or_default();
    let mut paths = String::new();
    for Placed { x, y, scale, outline } in placed(text)? {
        let _ = write!(
            paths,
            "<path{looks} transform=\"{around} translate({x:.3} {y:.3}) scale({scale:.7} -{scale:.7})\" d=\"{}\"/>",
            outline.path.as_ref().map(commands).unwrap_or_default()
        );
    }
    Some(paths)
}

/// A path as SVG has it.
fn commands(path: &Path) -> String {
    let mut text = String::new();
    for segment in path.segments() {
        let _ = match segment {
            PathSegment::MoveTo(p) => write!(text, "M{} {} ", p.x, p.y),
            PathSegment::LineTo(p) => write!(text, "L{} {} ", p.x, p.y),
            PathSegment::QuadTo(c, p) => write!(text, "Q{} {} {} {} ", c.x, c.y, p.x, p.y),
            PathSegment::CubicTo(c, d, p) => write!(text, "C{} {} {} {} {} {} ", c.x, c.y, d.x, d.y, p.x, p.y),
            PathSegment::Close => write!(text, "Z"),
        };
    }
    text
}

/// The letters of a text, if its looks are known; its `transform`, colour and opacity are not in them.
pub(crate) fn placed(text: Node) -> Option<Vec<Placed>> {
    let is_ours = |families: &str| families.split(',').next().is_some_and(|first| first.trim() == EMBEDDED_FAMILY);
    let has_family = |node: Node| node.attribute("font-family").is_none_or(is_ours);
    let is_known = |node: Node, known: &[&str]| {
        node.attributes().all(|attribute| known.contains(&attribute.name()) || KEPT.contains(&attribute.name()))
            && has_family(node)
    };
    if !is_known(text, &KNOWN) || !text.ancestors().skip(1).all(|node| is_known(node, &AROUND)) {
        return None;
    }
    let bold = match text.attribute("font-weight") {
        None | Some("normal") => false,
        Some("bold") => true,
        Some(_) => return None,
    };
    let size: f64 = text.attribute("font-size")?.parse().ok()?;
    let place = |name: &str| text.attribute(name).map_or(Some(0.0), |value| value.parse::<f64>().ok());
    let (x, y) = (place("x")?, place("y")? + length(text.attribute("dy"), size)?);

    // Along the line from its beginning.
    let (mut along, mut down) = (0.0, y);
    let mut pieces = Vec::new();
    for piece in pieces_of(text)? {
        let size = size * piece.size;
        down += length(piece.down, size)?;
        let outline = outline(&piece.letters, bold)?;
        let scale = size / outline.units;
        pieces.push((along, down, scale, Arc::clone(&outline)));
        along += outline.width * scale;
    }
    let left = match text.attribute("text-anchor") {
        None | Some("start") => x,
        Some("middle") => x - 0.5 * along,
        Some("end") => x - along,
        Some(_) => return None,
    };
    let placed = |(along, y, scale, outline)| Placed { x: left + along, y, scale, outline };
    Some(pieces.into_iter().map(placed).collect())
}

/// Letters of one size on one line.
struct Piece<'a> {
    letters: String,
    /// Relative to the size of the text.
    size: f64,
    /// By how much it and all that follows are lower than what is before.
    down: Option<&'a str>,
}

/// The pieces of a text, if there are none but those of [`crate::text::with_shifts`].
fn pieces_of<'a>(text: Node<'a, '_>) -> Option<Vec<Piece<'a>>> {
    let mut pieces = Vec::new();
    for child in text.children().filter(|child| !child.is_comment()) {
        let (words, size, down) = if child.is_text() {
            (child.text()?, 1.0, None)
        } else {
            let inside = child.first_child().filter(|inside| inside.is_text() && inside.next_sibling().is_none());
            if child.tag_name().name() != "tspan"
                || !child.attributes().all(|a| ["dy", "font-size"].contains(&a.name()))
            {
                return None;
            }
            let percent = |size: &str| size.strip_suffix('%')?.parse::<f64>().ok().map(|percent| percent / 100.0);
            let size = child.attribute("font-size").map_or(Some(1.0), percent)?;
            (inside?.text()?, size, child.attribute("dy"))
        };
        // Ends of lines count nothing, other white space once.
        let mut letters = words.replace(['\n', '\r'], "").replace('\t', " ");
        while letters.contains("  ") {
            letters = letters.replace("  ", " ");
        }
        pieces.push(Piece { letters, size, down });
    }
    // White space at both ends counts nothing.
    if let Some(first) = pieces.first_mut() {
        first.letters = first.letters.trim_start_matches(' ').to_owned();
    }
    while let Some(last) = pieces.last_mut() {
        last.letters.truncate(last.letters.trim_end_matches(' ').len());
        if !last.letters.is_empty() {
            break;
        }
        pieces.pop();
    }
    Some(pieces)
}

/// A length in the units of the drawing, for letters of this size.
fn length(text: Option<&str>, size: f64) -> Option<f64> {
    let Some(text) = text else { return Some(0.0) };
    let unit = [("em", size), ("ex", 0.5 * size), ("", 1.0)].into_iter().find(|(unit, _)| text.ends_with(unit));
    unit.and_then(|(unit, length)| Some(text.strip_suffix(unit)?.parse::<f64>().ok()? * length))
}

/// Shaped letters, in the units of their font.
pub(crate) struct Outline {
    /// Upwards; nothing if all are blank.
    pub(crate) path: Option<Path>,
    width: f64,
    /// How much wider it is where other fonts have the letters that this one lacks: up to one em each.
    wider: f64,
    /// Units per em.
    units: f64,
}

/// A face with what is the same for all texts.
struct Shaped {
    font: FontRef<'static>,
    data: ShaperData,
    outlines: OutlineGlyphCollection<'static>,
    units: f64,
    /// Glyphs that were drawn before.
    glyphs: Mutex<HashMap<GlyphId, Option<Path>>>,
    /// What the font does with texts of a script: to find that out takes ten times as long as to shape one.
    plans: Mutex<HashMap<Script, Arc<ShapePlan>>>,
}

impl Shaped {
    fn new(bold: bool) -> Self {
        let font = face(bold);
        Self {
            data: ShaperData::new(&font),
            outlines: font.outline_glyphs(),
            units: f64::from(font.metrics(Size::unscaled(), LocationRef::default()).units_per_em),
            font,
            glyphs: Mutex::default(),
            plans: Mutex::default(),
        }
    }

    /// Adds a glyph at a place to a path. Nothing if the font cannot draw it.
    fn draw(&self, glyph: GlyphId, (x, y): (i32, i32), path: &mut PathBuilder) -> Option<()> {
        let mut glyphs = self.glyphs.lock().unwrap_or_else(PoisonError::into_inner);
        let drawn = match glyphs.entry(glyph) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let mut pen = Pen(PathBuilder::new());
                let settings = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
                self.outlines.get(glyph)?.draw(settings, &mut pen).ok()?;
                new.insert(pen.0.finish())
            }
        };
        if let Some(drawn) = drawn {
            #[allow(clippy::cast_precision_loss)] // some thousands
            path.push_path(&drawn.clone().transform(Transform::from_translate(x as f32, y as f32))?);
        }
        Some(())
    }
}

/// Outlines of texts, by their boldness and letters.
type Known = Mutex<HashMap<(bool, String), Arc<Outline>>>;

/// The outline of a text; the font has a box for letters that it lacks.
fn outline(letters: &str, bold: bool) -> Option<Arc<Outline>> {
    static KNOWN: LazyLock<Known> = LazyLock::new(Mutex::default);
    let key = (bold, letters.to_owned());
    if let Some(known) = KNOWN.lock().unwrap_or_else(PoisonError::into_inner).get(&key) {
        return Some(Arc::clone(known));
    }
    let outline = Arc::new(shape(letters, bold)?);
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner).insert(key, Arc::clone(&outline));
    Some(outline)
}

fn shape(letters: &str, bold: bool) -> Option<Outline> {
    static FACES: LazyLock<[Shaped; 2]> = LazyLock::new(|| [false, true].map(Shaped::new));
    let face = &FACES[usize::from(bold)];
    let mut buffer = UnicodeBuffer::new();
    buffer.push_str(letters);
    buffer.set_direction(Direction::LeftToRight);
    buffer.guess_segment_properties();
    let shaper = face.data.shaper(&face.font).build();
    let (direction, script) = (buffer.direction(), buffer.script());
    let plan = || Arc::new(ShapePlan::new(&shaper, direction, Some(script), None, &[]));
    let plan = Arc::clone(face.plans.lock().unwrap_or_else(PoisonError::into_inner).entry(script).or_insert_with(plan));
    let shaped = shaper.shape(buffer, ShapeOptions::new().plan(Some(&plan)));
    let mut path = PathBuilder::new();
    let (mut width, mut wider) = (0, 0.0);
    for (info, position) in shaped.glyph_infos().iter().zip(shaped.glyph_positions()) {
        face.draw(GlyphId::new(info.glyph_id), (width + position.x_offset, position.y_offset), &mut path)?;
        width += position.x_advance;
        if info.glyph_id == GlyphId::NOTDEF.to_u32() {
            wider += (face.units - f64::from(position.x_advance)).max(0.0);
        }
    }
    Some(Outline { path: path.finish(), width: f64::from(width), wider, units: face.units })
}

impl Outline {
    /// In the units of the font.
    #[cfg(test)]
    pub(crate) fn width(&self) -> f64 {
        self.width
    }
}

/// How wide letters are at most, here and in a browser, in em; nothing if the font cannot draw them.
pub(crate) fn width(letters: &str, bold: bool) -> f64 {
    outline(letters, bold).map_or(0.0, |outline| (outline.width + outline.wider) / outline.units)
}

/// Takes the outline of a glyph.
struct Pen(PathBuilder);

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, y);
    }
    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        self.0.quad_to(cx, cy, x, y);
    }
    fn curve_to(&mut self, cx: f32, cy: f32, dx: f32, dy: f32, x: f32, y: f32) {
        self.0.cubic_to(cx, cy, dx, dy, x, y);
    }
    fn close(&mut self) {
        self.0.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::with_shifts;

    fn document(text: &str) -> String {
        with_shifts(&format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='300' height='100' fill='#123456'>{text}</svg>"
        ))
    }

    #[test]
    fn known_texts_are_paths_and_others_are_refused() {
        for text in [
            "<text x=\"9\" y=\"30\" dy=\"0.76em\" font-size=\"12\" fill=\"#22262E\">\nm̂ (10⁻³ kg), To\n</text>",
            "<text font-size='12' text-anchor='middle' font-weight='bold' transform='translate(16 30) rotate(-90)'>τ₁</text>",
            "<text x='9' y='30' font-size='12' font-family='Noto Sans, sans-serif'>漢\tof  others<!-- ! --></text>",
            "<text x='9' y='30' font-size='12'></text>",
        ] {
            let outlined = outlined(&document(text)).unwrap();
            assert!(!outlined.contains("<text") && roxmltree::Document::parse(&outlined).is_ok(), "{outlined}");
            assert_eq!(outlined.contains("d=\"M"), !text.contains("'></text>"));
        }
        for text in [
            "<text x='9' y='30'>no size</text>",
            "<text x='9' y='30' font-size='12' letter-spacing='2'>a</text>",
            "<text x='9' y='30' font-size='12' font-family='Serif'>a</text>",
            "<g font-weight='bold'><text x='9' y='30' font-size='12'>a</text></g>",
            "<style>text { fill: red }</style><text x='9' y='30' font-size='12'>a</text>",
        ] {
            assert!(outlined(&document(text)).unwrap_err().starts_with("no letters for <text"));
        }
        assert!(outlined("<svg").is_err());
    }

    #[test]
    fn lines_are_as_long_as_the_letters_and_their_kerning_say() {
        let width =
            |letters: &str| outline(letters, false).map(|outline| 10.0 * outline.width / outline.units).unwrap();
        // Without pairs that are closer to each other than others.
        assert!((width("mm") - crate::text::width("mm", 10.0, false)).abs() < 1e-6);
        assert!(width("To") < width("T") + width("o"));
        assert_eq!(length(Some("0.5ex"), 12.0), Some(3.0));
        assert_eq!(
            (length(Some("-2em"), 12.0), length(Some("7"), 12.0), length(Some("1pt"), 12.0)),
            (Some(-24.0), Some(7.0), None)
        );
    }
}

//! The very same SVG as PNG, with the embedded font.

use std::cell::RefCell;
use std::fmt::Write as _;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, Tree};
use roxmltree::Document;

use crate::indexed::Indexed;
use crate::{direct, flat, letters};

/// Pixels of the PNG per px of the SVG.
pub const SCALE: f32 = 2.0;

/// Renders an SVG document to the bytes of a PNG file.
///
/// # Errors
/// When the SVG is not valid, or too large for memory.
pub fn to_png(svg: &str) -> Result<Vec<u8>, String> {
    let document = Document::parse(svg).map_err(|error| error.to_string())?;
    if let Some(png) = MEMORY.with_borrow_mut(|memory| of_chart(&document, memory)) {
        return png.map_err(|error| error.to_string());
    }
    drop(document);
    let tree = parse(&without_layers(svg))?;
    let size = tree.size().to_int_size().scale_by(SCALE).ok_or("the figure has no size")?;
    let mut pixmap = Pixmap::new(size.width(), size.height()).ok_or("the figure is too large")?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixmap.as_mut());
    drop(tree);
    encode(pixmap).map_err(|error| error.to_string())
}

/// The same picture without `opacity`: what is pale by that is drawn on a layer of its own, as large as the picture. The colour
/// itself may be pale instead, where an element has one, a fill or a stroke.
fn without_layers(svg: &str) -> String {
    let mut plain = String::with_capacity(svg.len() + 4096);
    let mut rest = svg;
    while let Some((before, after)) = rest.split_once(" opacity=\"") {
        let (value, after) = after.split_once('"').unwrap_or((after, ""));
        plain.push_str(before);
        if value != "1" {
            for attribute in ["fill-opacity", "stroke-opacity"] {
                let _ = write!(plain, " {attribute}=\"{value}\"");
            }
        }
        rest = after;
    }
    plain + rest
}

/// Memory for pixels, and for rows of a PNG.
type Memory = (Vec<u16>, Vec<u8>);

thread_local! {
    /// A comparison draws a dozen figures on each thread. If each had new memory, the system would have to clear it.
    static MEMORY: RefCell<Memory> = const { RefCell::new((Vec::new(), Vec::new())) };
}

/// A document that consists of what charts consist of.
fn of_chart(document: &Document, (pixels, rows): &mut Memory) -> Option<Result<Vec<u8>, png::EncodingError>> {
    let picture = direct::draw(document, SCALE, std::mem::take(pixels))?;
    let (columns, height) = (picture.columns, picture.rows);
    let indexed;
    (indexed, *pixels) = picture.indexed(std::mem::take(rows));
    let indexed = indexed?;
    let png = file(columns, height, &indexed);
    *rows = indexed.rows;
    Some(png)
}

/// The pixels as PNG: with a palette, if one can stand for their colours.
fn encode(pixmap: Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
    let Some(indexed) = Indexed::of_pixels(width, pixmap.data().as_chunks().0) else { return pixmap.encode_png() };
    drop(pixmap);
    file(width, height, &indexed)
}

fn file(width: usize, height: usize, indexed: &Indexed) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let length = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    let mut encoder = png::Encoder::new(&mut file, length(width), length(height));
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(&indexed.palette);
    let mut writer = encoder.write_header()?;
    writer.write_chunk(png::chunk::IDAT, &flat::compressed(&indexed.rows, width + 1))?;
    writer.finish()?;
    Ok(file)
}

/// An SVG document, its texts with the embedded font.
///
/// # Errors
/// When it is not valid.
pub(crate) fn parse(svg: &str) -> Result<Tree, String> {
    Tree::from_str(&letters::outlined(svg)?, &usvg::Options::default()).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text;

    #[test]
    fn text_is_rendered_with_the_embedded_font() {
        let svg = |text: &str| {
            format!(
                "<svg xmlns='http://www.w3.org/2000/svg' width='40' height='20'>\
                 <text x='2' y='15' font-family='{}' font-size='14'>{text}</text></svg>",
                text::FAMILIES
            )
        };
        let (with, without) = (to_png(&svg("θ₁")).unwrap(), to_png(&svg("")).unwrap());
        assert!(with.starts_with(b"\x89PNG") && with.len() > without.len());
        assert!(to_png("<svg").is_err());
    }

    /// The pixels of a PNG as red, green and blue.
    fn pixels(png: &[u8]) -> Vec<u8> {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut data).unwrap();
        data
    }

    #[test]
    fn pale_colours_are_those_of_pale_layers_and_palettes_lose_nothing() {
        let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='64' height='48'><rect width='64' height='48' fill='white'/>\
                   <polyline fill=\"none\" opacity=\"0.45\" stroke=\"#D55E00\" stroke-width='6' points='4,40 30,4 34,40 60,4'/>\
                   <polygon opacity=\"0.28\" fill=\"#0072B2\" points='4,30 60,20 60,44'/></svg>";
        let tree = parse(svg).unwrap();
        let mut pixmap = Pixmap::new(128, 96).unwrap();
        resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixmap.as_mut());
        let layered: Vec<u8> = pixmap.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
        let plain = pixels(&to_png(svg).unwrap());
        assert_eq!(plain.len(), layered.len());
        // Colours of eight bits are rounded in another order.
        assert!(plain.iter().zip(&layered).all(|(a, b)| a.abs_diff(*b) <= 2));
        // More colours than any palette stands for.
        let color = |x: u32| [1, 16, 256].map(|step| (x / step % 16 * 17).to_string()).join(",");
        let cell =
            |x: u32| format!("<rect x='{}' y='{}' width='1' height='1' fill='rgb({})'/>", x % 64, x / 64, color(x));
        let cells: String = (0..4096).map(cell).collect();
        let svg = format!("<svg xmlns='http://www.w3.org/2000/svg' width='64' height='64'>{cells}</svg>");
        let pixels = pixels(&to_png(&svg).unwrap());
        let first = &pixels[..pixels.len() / 128];
        assert_eq!((first[0], &first[first.len() / 64..][..3]), (0, &[17, 0, 0][..]));
    }
}

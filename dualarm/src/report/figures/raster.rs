//! The very same SVG as PNG, with the embedded font.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, Tree, fontdb};

use super::text;

/// Pixels of the PNG per px of the SVG.
pub const SCALE: f32 = 2.0;

/// Renders an SVG document to the bytes of a PNG file.
///
/// # Errors
/// When the SVG is not valid, or too large for memory.
pub fn to_png(svg: &str) -> Result<Vec<u8>, String> {
    let tree = parse(svg)?;
    let size = tree.size().to_int_size().scale_by(SCALE).ok_or("the figure has no size")?;
    let mut pixmap = Pixmap::new(size.width(), size.height()).ok_or("the figure is too large")?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixmap.as_mut());
    pixmap.encode_png().map_err(|error| error.to_string())
}

/// An SVG document with the embedded font.
///
/// # Errors
/// When it is not valid.
pub(super) fn parse(svg: &str) -> Result<Tree, String> {
    let options =
        usvg::Options { fontdb: fonts(), font_family: text::EMBEDDED_FAMILY.into(), ..usvg::Options::default() };
    Tree::from_str(svg, &options).map_err(|error| error.to_string())
}

fn fonts() -> Arc<fontdb::Database> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        for face in text::FACES {
            fonts.load_font_data(face.to_vec());
        }
        fonts.set_sans_serif_family(text::EMBEDDED_FAMILY);
        Arc::new(fonts)
    });
    Arc::clone(fonts)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}

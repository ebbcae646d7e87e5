//! Converts an SVG to a PDF of one page, for LaTeX: vectors, with letters as outlines of the embedded font, so that a
//! reader needs no font.
//!
//! Figures consist of filled and stroked paths; groups have no clips or masks, and colours are plain.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use resvg::tiny_skia::{PathSegment, Transform};
use resvg::usvg::{FillRule, Group, LineCap, LineJoin, Node, Opacity, Paint, Path, Stroke};

use crate::raster;

/// Points of the PDF per px of the SVG: 72 and 96 per inch.
const POINTS: f32 = 0.75;

/// Turns an SVG document into the bytes of a PDF file.
///
/// # Errors
/// When the SVG is not valid.
pub fn to_pdf(svg: &str) -> Result<Vec<u8>, String> {
    let tree = raster::parse(svg)?;
    let (width, height) = (tree.size().width() * POINTS, tree.size().height() * POINTS);
    // PDF counts upwards.
    let page = Transform::from_row(POINTS, 0.0, 0.0, -POINTS, 0.0, height);
    let mut content = Content::default();
    content.group(tree.root(), page, 1.0);
    let mut states = String::new();
    for state in &content.opacities {
        let opacity = f32::from(*state) / 255.0;
        let _ = write!(states, "/O{state} << /ca {opacity:.3} /CA {opacity:.3} >> ");
    }
    let page = format!(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width:.2} {height:.2}] /Contents 4 0 R \
         /Resources << /ExtGState << {states}>> >> >>"
    );
    let stream = deflated(content.operators.as_bytes()).map_err(|error| error.to_string())?;
    let head = format!("<< /Length {} /Filter /FlateDecode >>\nstream\n", stream.len());
    let objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>".to_vec(),
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>".to_vec(),
        page.into_bytes(),
        [head.as_bytes(), &stream, b"\nendstream"].concat(),
    ];
    Ok(file(&objects))
}

/// Objects with the table of their positions.
fn file(objects: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"%PDF-1.5\n%\xE2\xE3\xCF\xD3\n".to_vec();
    let mut table = format!("xref\n0 {}\n0000000000 65535 f \n", objects.len() + 1);
    for (index, object) in objects.iter().enumerate() {
        let _ = writeln!(table, "{:010} 00000 n ", bytes.len());
        bytes.extend(format!("{} 0 obj\n", index + 1).bytes());
        bytes.extend(object);
        bytes.extend(b"\nendobj\n");
    }
    let start = bytes.len();
    let _ = write!(table, "trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{start}\n%%EOF\n", objects.len() + 1);
    bytes.extend(table.bytes());
    bytes
}

fn deflated(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// The page's operators, and the opacities that they name, in 255ths.
#[derive(Default)]
struct Content {
    operators: String,
    opacities: BTreeSet<u8>,
}

impl Content {
    fn group(&mut self, group: &Group, page: Transform, opacity: f32) {
        let opacity = opacity * group.opacity().get();
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group, page, opacity),
                Node::Path(path) => self.path(path, page, opacity),
                Node::Image(_) | Node::Text(_) => {} // figures have none, and letters are paths
            }
        }
    }

    fn path(&mut self, path: &Path, page: Transform, opacity: f32) {
        if !path.is_visible() {
            return;
        }
        let transform = page.pre_concat(path.abs_transform());
        if let Some(fill) = path.fill() {
            self.opacity(fill.opacity(), opacity);
            self.colour(fill.paint(), "rg");
            self.outline(path, transform);
            self.operators += if fill.rule() == FillRule::EvenOdd { "f*\n" } else { "f\n" };
        }
        if let Some(stroke) = path.stroke() {
            self.opacity(stroke.opacity(), opacity);
            self.colour(stroke.paint(), "RG");
            self.pen(stroke, transform);
            self.outline(path, transform);
            self.operators += "S\n";
        }
    }

    fn opacity(&mut self, own: Opacity, group: f32) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 255
        let state = (255.0 * own.get() * group).round() as u8;
        self.opacities.insert(state);
        let _ = writeln!(self.operators, "/O{state} gs");
    }

    fn colour(&mut self, paint: &Paint, operator: &str) {
        // Figures use no gradients and no patterns.
        let Paint::Color(colour) = paint else { return };
        let [red, green, blue] = [colour.red, colour.green, colour.blue].map(|part| f32::from(part) / 255.0);
        let _ = writeln!(self.operators, "{red:.3} {green:.3} {blue:.3} {operator}");
    }

    fn pen(&mut self, stroke: &Stroke, transform: Transform) {
        let scale = (transform.sx * transform.sy - transform.kx * transform.ky).abs().sqrt();
        let cap = match stroke.linecap() {
            LineCap::Butt => 0,
            LineCap::Round => 1,
            LineCap::Square => 2,
        };
        let join = match stroke.linejoin() {
            LineJoin::Miter | LineJoin::MiterClip => 0,
            LineJoin::Round => 1,
            LineJoin::Bevel => 2,
        };
        let dashes = stroke.dasharray().unwrap_or_default().iter().map(|dash| format!("{:.3}", dash * scale));
        let dashes = dashes.collect::<Vec<_>>().join(" ");
        let _ = writeln!(
            self.operators,
            "{:.3} w {cap} J {join} j [{dashes}] {:.3} d",
            stroke.width().get() * scale,
            stroke.dashoffset() * scale
        );
    }

    fn outline(&mut self, path: &Path, transform: Transform) {
        let Some(data) = path.data().clone().transform(transform) else { return };
        let mut at = (0.0, 0.0);
        for segment in data.segments() {
            let _ = match segment {
                PathSegment::MoveTo(p) => {
                    at = (p.x, p.y);
                    writeln!(self.operators, "{:.2} {:.2} m", p.x, p.y)
                }
                PathSegment::LineTo(p) => {
                    at = (p.x, p.y);
                    writeln!(self.operators, "{:.2} {:.2} l", p.x, p.y)
                }
                PathSegment::QuadTo(c, p) => {
                    // PDF has only cubic curves.
                    let towards = |from: f32, to: f32| from + 2.0 / 3.0 * (to - from);
                    let (x1, y1) = (towards(at.0, c.x), towards(at.1, c.y));
                    let (x2, y2) = (towards(p.x, c.x), towards(p.y, c.y));
                    at = (p.x, p.y);
                    writeln!(self.operators, "{x1:.2} {y1:.2} {x2:.2} {y2:.2} {:.2} {:.2} c", p.x, p.y)
                }
                PathSegment::CubicTo(c, d, p) => {
                    at = (p.x, p.y);
                    writeln!(self.operators, "{:.2} {:.2} {:.2} {:.2} {:.2} {:.2} c", c.x, c.y, d.x, d.y, p.x, p.y)
                }
                PathSegment::Close => writeln!(self.operators, "h"),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn a_pdf_has_the_page_and_its_paths_where_its_table_says() {
        let svg = "<svg xmlns='http://www.w3.org/2000/svg' width='40' height='20'><rect width='4' height='2' fill='red'/>\
                   <path d='M0 0 Q10 0 10 10' stroke='#0000ff' stroke-opacity='0.5' fill='none' stroke-width='2'/>\
                   <text x='2' y='15' font-size='14'>x</text></svg>";
        let pdf = to_pdf(svg).unwrap();
        let text = String::from_utf8_lossy(&pdf);
        assert!(text.starts_with("%PDF-1.5") && text.ends_with("%%EOF\n"));
        assert!(text.contains("/MediaBox [0 0 30.00 15.00]") && text.contains("/O128 << /ca 0.502"), "{text}");
        let find = |wanted: &[u8]| pdf.windows(wanted.len()).position(|window| window == wanted).unwrap();
        let offset = format!("{:010} 00000 n", find(b"3 0 obj"));
        assert!(text.contains(&offset), "{offset}");
        let stream = &pdf[find(b"stream\n") + 7..find(b"\nendstream")];
        let mut operators = String::new();
        flate2::read::ZlibDecoder::new(stream).read_to_string(&mut operators).unwrap();
        assert!(operators.contains("1.000 0.000 0.000 rg\n0.00 15.00 m\n3.00 15.00 l"), "{operators}");
        assert!(operators.contains("1.500 w 0 J 0 j [] 0.000 d\n0.00 15.00 m\n5.00 15.00 7.50 12.50 7.50 7.50 c\nS"));
        assert!(operators.matches("f\n").count() >= 2, "the letter is an outline");
        assert!(to_pdf("<svg").is_err());
    }
}

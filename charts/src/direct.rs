//! Pixels of an SVG that consists of what charts consist of: rectangles, lines, areas, circles and texts of plain colours, without
//! groups.
//!
//! What draws any SVG takes its time to understand it, and fills a line of a grid as it fills any other shape: together that was half
//! of the time for a chart's pixels. Here an axis-parallel line is a rectangle, whose edges are as dark as the part of each pixel that
//! they cover.

use resvg::tiny_skia::{Color, FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, PremultipliedColorU8};
use resvg::tiny_skia::{Rect, Stroke, Transform};
use roxmltree::{Document, Node};

use crate::letters::{self, Placed};

/// Draws a document with so many pixels per px, unless it contains something else.
pub(crate) fn draw(document: &Document, scale: f32) -> Option<Pixmap> {
    let root = document.root_element();
    let known = ["width", "height", "viewBox", "role", "stroke-linejoin"];
    let is_known = root.attributes().all(|attribute| known.contains(&attribute.name()));
    if !is_known || root.tag_name().name() != "svg" || root.attribute("stroke-linejoin") != Some("round") {
        return None;
    }
    let [width, height] = ["width", "height"].map(|name| number(root, name));
    let (width, height) = (width?, height?);
    let shown: Vec<f32> =
        root.attribute("viewBox")?.split(' ').map(|number| number.parse().ok()).collect::<Option<_>>()?;
    let [0.0, 0.0, units, _] = shown[..] else { return None };
    // Units are squares.
    let zoom = scale * width / units;
    if shown[3] * zoom != height * scale {
        return None;
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    // a conversion that is not possible gives an end of u32
    let [columns, rows] = [width, height].map(|length| (length * scale).ceil() as u32);
    let mut picture = Picture { pixels: Pixmap::new(columns, rows)?, zoom };
    for shape in root.children().filter(Node::is_element) {
        picture.draw(shape)?;
    }
    Some(picture.pixels)
}

/// Attributes of shapes that this module understands.
const KNOWN: [&str; 12] =
    ["x", "y", "width", "height", "cx", "cy", "r", "points", "fill", "stroke", "stroke-width", "opacity"];

struct Picture {
    pixels: Pixmap,
    /// Pixels per unit.
    zoom: f32,
}

impl Picture {
    fn draw(&mut self, shape: Node) -> Option<()> {
        let name = shape.tag_name().name();
        if name == "title" {
            return Some(());
        }
        if name == "text" {
            return self.letters(shape);
        }
        if !shape.attributes().all(|attribute| KNOWN.contains(&attribute.name())) {
            return None;
        }
        let value = |name| number(shape, name);
        match name {
            "rect" => {
                let (x, y) = (value("x")?, value("y")?);
                let rect = Rect::from_xywh(x, y, value("width")?, value("height")?)?;
                let color = filled(shape)?;
                let whole = Rect::from_xywh(0.0, 0.0, self.pixels.width() as f32, self.pixels.height() as f32);
                if color.is_opaque() && rect.transform(Transform::from_scale(self.zoom, self.zoom)) == whole {
                    self.pixels.fill(color);
                } else {
                    self.rectangle(rect, color);
                }
            }
            "circle" => {
                let circle = PathBuilder::from_circle(value("cx")?, value("cy")?, value("r")?)?;
                self.fill(&circle, filled(shape)?, Transform::identity());
            }
            "polygon" => {
                if let Some(area) = path(&points(shape)?, true) {
                    self.fill(&area, filled(shape)?, Transform::identity());
                }
            }
            "polyline" => self.line(&points(shape)?, value("stroke-width")?, stroked(shape)?),
            _ => return None,
        }
        Some(())
    }

    /// Fills a rectangle, each pixel as far as it is covered.
    fn rectangle(&mut self, rect: Rect, color: Color) {
        let (width, height) = (self.pixels.width(), self.pixels.height());
        let across = covered(rect.left() * self.zoom, rect.right() * self.zoom, width);
        let down = covered(rect.top() * self.zoom, rect.bottom() * self.zoom, height);
        let rows = self.pixels.pixels_mut().chunks_exact_mut(width as usize);
        for (row, (_, vertical)) in rows.skip(down.first().map_or(0, |(row, _)| *row)).zip(&down) {
            // Most pixels are like the one before, and covered as far.
            let mut last = (PremultipliedColorU8::TRANSPARENT, 0.0, PremultipliedColorU8::TRANSPARENT);
            for (column, horizontal) in &across {
                let (pixel, part) = (&mut row[*column], vertical * horizontal);
                if (*pixel, part) != (last.0, last.1) {
                    last = (*pixel, part, covered_by(*pixel, color, part));
                }
                *pixel = last.2;
            }
        }
    }

    fn fill(&mut self, path: &Path, color: Color, transform: Transform) {
        let transform = transform.post_scale(self.zoom, self.zoom);
        self.pixels.fill_path(path, &paint(color), FillRule::Winding, transform, None);
    }

    fn line(&mut self, points: &[(f32, f32)], width: f32, color: Color) {
        if let [(x0, y0), (x1, y1)] = *points
            && (x0 == x1) != (y0 == y1)
        {
            // Without caps.
            let (along, across) = if x0 == x1 { (0.0, 0.5 * width) } else { (0.5 * width, 0.0) };
            let (low, high) = ((x0.min(x1) - across, y0.min(y1) - along), (x0.max(x1) + across, y0.max(y1) + along));
            if let Some(rect) = Rect::from_ltrb(low.0, low.1, high.0, high.1) {
                self.rectangle(rect, color);
            }
        } else if let Some(path) = path(points, false) {
            let pen = Stroke { width, line_join: LineJoin::Round, ..Stroke::default() };
            let transform = Transform::from_scale(self.zoom, self.zoom);
            self.pixels.stroke_path(&path, &paint(color), &pen, transform, None);
        }
    }

    fn letters(&mut self, text: Node) -> Option<()> {
        let turned = match text.attribute("transform") {
            None => Transform::identity(),
            Some(turn) => {
                let numbers = turn.strip_prefix("rotate(")?.strip_suffix(')')?.split(',');
                let numbers: Vec<f32> = numbers.map(|number| number.trim().parse().ok()).collect::<Option<_>>()?;
                let [angle, x, y] = numbers[..] else { return None };
                Transform::from_rotate_at(angle, x, y)
            }
        };
        let color = filled(text)?;
        for Placed { x, y, scale, outline } in letters::placed(text)? {
            if let Some(path) = &outline.path {
                let [x, y, scale] = [x, y, scale].map(single);
                self.fill(path, color, turned.pre_translate(x, y).pre_scale(scale, -scale));
            }
        }
        Some(())
    }
}

/// Which of so many pixels in a line lie between two places, and how much of each.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between zero and a count of pixels
fn covered(from: f32, to: f32, count: u32) -> Vec<(usize, f32)> {
    let (from, to) = (from.clamp(0.0, count as f32), to.clamp(0.0, count as f32));
    let pixels = from.floor() as usize..to.ceil() as usize;
    pixels.map(|pixel| (pixel, to.min(pixel as f32 + 1.0) - from.max(pixel as f32))).collect()
}

/// A pixel after a colour was laid over this part of it.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 255
fn covered_by(pixel: PremultipliedColorU8, color: Color, part: f32) -> PremultipliedColorU8 {
    let part = part * color.alpha();
    let mixed = |before: u8, with: f32| (f32::from(before) * (1.0 - part) + 255.0 * with * part + 0.5) as u8;
    let alpha = mixed(pixel.alpha(), 1.0);
    // Where the picture is transparent, colours are multiplied by their opacity: none is more than it.
    let [red, green, blue] = [(pixel.red(), color.red()), (pixel.green(), color.green()), (pixel.blue(), color.blue())]
        .map(|(before, with)| mixed(before, with).min(alpha));
    PremultipliedColorU8::from_rgba(red, green, blue, alpha).unwrap_or(pixel)
}

fn paint(color: Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(color);
    paint
}

/// The colour of an area, which has no edge.
fn filled(shape: Node) -> Option<Color> {
    color(shape, "fill").filter(|_| matches!(shape.attribute("stroke"), None | Some("none")))
}

/// The colour of a line, which has no area.
fn stroked(shape: Node) -> Option<Color> {
    color(shape, "stroke").filter(|_| shape.attribute("fill") == Some("none"))
}

/// A colour as `#RRGGBB`, with the opacity of the shape.
fn color(shape: Node, name: &str) -> Option<Color> {
    let digits = shape.attribute(name)?.strip_prefix('#').filter(|digits| digits.len() == 6)?;
    let [_, red, green, blue] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    let opacity = shape.attribute("opacity").map_or(Some(1.0), |opacity| opacity.parse::<f32>().ok())?;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 255
    let opacity = (opacity.clamp(0.0, 1.0) * 255.0).round() as u8;
    Some(Color::from_rgba8(red, green, blue, opacity))
}

fn number(shape: Node, name: &str) -> Option<f32> {
    shape.attribute(name)?.parse().ok()
}

#[allow(clippy::cast_possible_truncation)] // pictures are no more precise
fn single(number: f64) -> f32 {
    number as f32
}

fn points(shape: Node) -> Option<Vec<(f32, f32)>> {
    let point = |point: &str| {
        let (x, y) = point.split_once(',')?;
        Some((x.parse().ok()?, y.parse().ok()?))
    };
    shape.attribute("points")?.split_ascii_whitespace().map(point).collect()
}

fn path(points: &[(f32, f32)], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::with_capacity(points.len() + 1, points.len());
    let (first, others) = points.split_first()?;
    builder.move_to(first.0, first.1);
    for (x, y) in others {
        builder.line_to(*x, *y);
    }
    if closed {
        builder.close();
    }
    builder.finish()
}

#[cfg(test)]
mod tests {
    use resvg::{tiny_skia, usvg};

    use super::*;

    fn svg(shapes: &str) -> String {
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='120' height='80' viewBox='0 0 1200 800' stroke-linejoin='round' \
             role='img'><title>T</title><rect x='0' y='0' width='1200' height='800' fill='#FFFFFF' stroke='none'/>{shapes}</svg>"
        )
    }

    fn directly(svg: &str) -> Option<Pixmap> {
        draw(&Document::parse(svg).unwrap(), 2.0)
    }

    #[test]
    fn shapes_are_those_of_any_other_program() {
        let font = "font-family='Noto Sans, sans-serif' fill='#22262E'";
        // A pixel has sixteen samples; a rectangle has none.
        for (shapes, most) in [
            ("<rect x='101' y='203' width='417' height='108' opacity='1' fill='#E3E8EE' stroke='none'/>", 16),
            ("<polyline fill='none' opacity='1' stroke='#000000' stroke-width='9' points='100,107 900,107 '/>", 64),
            (
                "<polyline fill='none' opacity='0.45' stroke='#D55E00' stroke-width='60' points='90,790 300,10 333,400'/>",
                2,
            ),
            ("<polygon opacity='0.28' fill='#0072B2' points='50,300 600,200 601,444 '/>", 2),
            ("<circle cx='600' cy='400' r='46' opacity='1' fill='#0072B2' stroke='none' stroke-width='1'/>", 16),
        ] {
            let svg = svg(shapes);
            // Without a layer of its own a pale shape has a pale colour.
            let plain = svg
                .replace(" opacity='0.45'", " stroke-opacity='0.45'")
                .replace(" opacity='0.28'", " fill-opacity='0.28'");
            let tree = usvg::Tree::from_str(&plain, &usvg::Options::default()).unwrap();
            let mut other = Pixmap::new(240, 160).unwrap();
            resvg::render(&tree, Transform::from_scale(2.0, 2.0), &mut other.as_mut());
            let difference = difference(&directly(&svg).unwrap(), &other);
            assert!(difference <= most, "{difference} {shapes}");
        }
        for text in [
            format!("<text x='180' y='140' dy='0.76em' text-anchor='middle' font-size='150' {font}>τ₁ (N·m)</text>"),
            format!("<text x='180' y='140' font-size='150' transform='rotate(270, 180, 240)' {font}>To</text>"),
        ] {
            let svg = crate::text::with_shifts(&svg(&text));
            let outlined = letters::outlined(&svg).unwrap();
            let tree = usvg::Tree::from_str(&outlined, &usvg::Options::default()).unwrap();
            let mut other = Pixmap::new(240, 160).unwrap();
            resvg::render(&tree, Transform::from_scale(2.0, 2.0), &mut other.as_mut());
            let directly = directly(&svg).unwrap();
            assert!(difference(&directly, &other) <= 32 && directly.pixels().iter().any(|pixel| pixel.red() < 99));
        }
    }

    /// The largest one of a colour.
    fn difference(one: &Pixmap, other: &tiny_skia::Pixmap) -> u8 {
        one.data().iter().zip(other.data()).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
    }

    #[test]
    fn lines_are_as_dark_as_what_they_cover() {
        let line = "<polyline fill='none' stroke='#000000' stroke-width='10' points='100,400 900,400'/>";
        let pixels = directly(&svg(line)).unwrap();
        // 2 pixels wide around y = 80.
        let column: Vec<u8> = (77..83).map(|row| pixels.pixel(100, row).unwrap().red()).collect();
        assert_eq!(column, [255, 255, 0, 0, 255, 255]);
        let line = line.replace("400", "402");
        let pixels = directly(&svg(&line)).unwrap();
        let column: Vec<u8> = (77..83).map(|row| pixels.pixel(100, row).unwrap().red()).collect();
        assert!(column[2].abs_diff(102) < 3 && column[3] == 0 && column[4].abs_diff(153) < 3, "{column:?}");
    }

    #[test]
    fn what_it_does_not_know_it_leaves_to_others() {
        for shapes in [
            "<g/>",
            "<rect x='1' y='2' width='3' height='4' rx='2' fill='#FFFFFF'/>",
            "<rect x='1' y='2' width='3' height='4' fill='white'/>",
            "<rect x='1' y='2' width='3' height='4' fill='#FFFFFF' stroke='#000000'/>",
            "<polyline stroke='#000000' stroke-width='2' points='1,2 3,4'/>",
            "<polyline fill='none' stroke='#000000' stroke-width='2' points='1 2'/>",
            "<text x='9' y='9' font-size='9' fill='#000000' transform='scale(2)'>a</text>",
            "<text x='9' y='9' font-size='9' fill='#000000' letter-spacing='2'>a</text>",
        ] {
            assert!(directly(&svg(shapes)).is_none(), "{shapes}");
        }
        assert!(directly(&svg("").replace("1200 800", "1200 900")).is_none());
        assert!(directly(&svg("").replace(" role=", " fill='#000000' role=")).is_none());
    }
}

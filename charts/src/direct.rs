//! Pixels of an SVG that consists of what charts consist of: rectangles, lines, areas, circles and texts of plain colours, without
//! groups.
//!
//! What draws any SVG takes its time to understand it, and fills a line of a grid as it fills any other shape: together that was half
//! of the time for a chart's pixels. Here an axis-parallel line is a rectangle, whose edges are as dark as the part of each pixel that
//! they cover.

use resvg::tiny_skia::{Path, PathBuilder, Transform};
use roxmltree::{Document, Node};

use crate::cells::{Cells, Point};
use crate::letters::{self, Placed};
use crate::picture::{Color, Picture};
use crate::stroke;

/// Draws a document with so many pixels per px, unless it contains something else; in memory that may have been used before.
pub(crate) fn draw(document: &Document, scale: f32, memory: Vec<u16>) -> Option<Picture> {
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
    let mut shapes = root.children().filter(Node::is_element).filter(|shape| shape.tag_name().name() != "title");
    // The first one is the background of all.
    let ground = shapes.next().filter(|shape| is_known_shape(*shape) && shape.tag_name().name() == "rect")?;
    let side = |name| number(ground, name);
    let (color, u8::MAX) = filled(ground)? else { return None };
    if (side("x")?, side("y")?) != (0.0, 0.0) || (side("width")?, side("height")?) != (units, shown[3]) {
        return None;
    }
    let picture = Picture::new(columns, rows, color, memory)?;
    let mut canvas = Canvas { picture, cells: Cells::new(columns, rows), zoom };
    for shape in shapes {
        canvas.draw(shape)?;
    }
    Some(canvas.picture)
}

/// Attributes of shapes that this module understands.
const KNOWN: [&str; 12] =
    ["x", "y", "width", "height", "cx", "cy", "r", "points", "fill", "stroke", "stroke-width", "opacity"];

struct Canvas {
    picture: Picture,
    cells: Cells,
    /// Pixels per unit.
    zoom: f32,
}

/// A colour and its opacity of 255.
type Paint = (Color, u8);

impl Canvas {
    fn draw(&mut self, shape: Node) -> Option<()> {
        let name = shape.tag_name().name();
        if name == "text" {
            return self.letters(shape);
        }
        if !is_known_shape(shape) {
            return None;
        }
        let value = |name| number(shape, name);
        match name {
            "rect" => {
                let (x, y, width, height) = (value("x")?, value("y")?, value("width")?, value("height")?);
                let paint = filled(shape)?;
                if width < 0.0 || height < 0.0 {
                    return None;
                }
                self.rectangle((x, y), (x + width, y + height), paint);
            }
            "circle" => {
                let circle = PathBuilder::from_circle(value("cx")?, value("cy")?, value("r")?)?;
                self.outline(&circle, Transform::identity());
                self.fill(filled(shape)?);
            }
            "polygon" => {
                self.area(&points(shape)?);
                self.fill(filled(shape)?);
            }
            "polyline" => {
                self.line(&points(shape)?, 0.5 * value("stroke-width")?, stroked(shape)?);
            }
            _ => return None,
        }
        Some(())
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
        let paint = filled(text)?;
        for Placed { x, y, scale, outline } in letters::placed(text)? {
            if let Some(path) = &outline.path {
                let [x, y, scale] = [x, y, scale].map(single);
                self.outline(path, turned.pre_translate(x, y).pre_scale(scale, -scale));
                self.fill(paint);
            }
        }
        Some(())
    }

    fn line(&mut self, points: &[Point], half: f32, paint: Paint) {
        if let [(x0, y0), (x1, y1)] = *points
            && (x0 == x1) != (y0 == y1)
        {
            // Without caps.
            let (across, along) = if x0 == x1 { (half, 0.0) } else { (0.0, half) };
            let (low, high) = ((x0.min(x1) - across, y0.min(y1) - along), (x0.max(x1) + across, y0.max(y1) + along));
            return self.rectangle(low, high, paint);
        }
        let zoom = self.zoom;
        stroke::line(&mut self.cells, points.iter().map(|(x, y)| (x * zoom, y * zoom)), half * zoom);
        self.fill(paint);
    }

    fn rectangle(&mut self, low: Point, high: Point, (color, opacity): Paint) {
        let brush = self.picture.brush(color, opacity);
        let [low, high] = [low, high].map(|(x, y)| (x * self.zoom, y * self.zoom));
        let Self { picture, cells, .. } = self;
        let lay = |row, column, count, level| picture.lay(brush, row, column..column + count, level);
        cells.cover_rectangle(low, high, lay);
    }

    /// Adds a polygon to the shape that is filled next.
    fn area(&mut self, corners: &[Point]) {
        let at = |(x, y): Point| (x * self.zoom, y * self.zoom);
        for pair in corners.windows(2) {
            self.cells.edge(at(pair[0]), at(pair[1]));
        }
        if let (Some(last), Some(first)) = (corners.last(), corners.first()) {
            self.cells.edge(at(*last), at(*first));
        }
    }

    /// Adds a path to it.
    fn outline(&mut self, path: &Path, transform: Transform) {
        self.cells.path(path, transform.post_scale(self.zoom, self.zoom));
    }

    /// Fills the shape.
    fn fill(&mut self, (color, opacity): Paint) {
        let brush = self.picture.brush(color, opacity);
        let Self { picture, cells, .. } = self;
        cells.cover(|row, column, count, level| match count {
            1 => picture.lay_one(brush, row, column, level),
            _ => picture.lay(brush, row, column..column + count, level),
        });
    }
}

fn is_known_shape(shape: Node) -> bool {
    shape.attributes().all(|attribute| KNOWN.contains(&attribute.name()))
}

/// The colour of an area, which has no edge.
fn filled(shape: Node) -> Option<Paint> {
    color(shape, "fill").filter(|_| matches!(shape.attribute("stroke"), None | Some("none")))
}

/// The colour of a line, which has no area.
fn stroked(shape: Node) -> Option<Paint> {
    color(shape, "stroke").filter(|_| shape.attribute("fill") == Some("none"))
}

/// A colour as `#RRGGBB`, with the opacity of the shape.
fn color(shape: Node, name: &str) -> Option<Paint> {
    let digits = shape.attribute(name)?.strip_prefix('#').filter(|digits| digits.len() == 6)?;
    let [_, color @ ..] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    let opacity = shape.attribute("opacity").map_or(Some(1.0), |opacity| opacity.parse::<f32>().ok())?;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 255
    let opacity = (opacity.clamp(0.0, 1.0) * 255.0).round() as u8;
    Some((color, opacity))
}

fn number(shape: Node, name: &str) -> Option<f32> {
    shape.attribute(name)?.parse().ok().filter(|number: &f32| number.is_finite())
}

#[allow(clippy::cast_possible_truncation)] // pictures are no more precise
fn single(number: f64) -> f32 {
    number as f32
}

fn points(shape: Node) -> Option<Vec<Point>> {
    let point = |point: &str| {
        let (x, y) = point.split_once(',')?;
        Some((coordinate(x)?, coordinate(y)?))
    };
    shape.attribute("points")?.split_ascii_whitespace().map(point).collect()
}

/// A number; most are whole and short.
fn coordinate(text: &str) -> Option<f32> {
    const SHORT: usize = 6;
    if (1..=SHORT).contains(&text.len()) && text.bytes().all(|digit| digit.is_ascii_digit()) {
        let whole = text.bytes().fold(0, |whole, digit| 10 * whole + u32::from(digit - b'0'));
        return Some(whole as f32);
    }
    text.parse().ok().filter(|number: &f32| number.is_finite())
}

#[cfg(test)]
mod tests {
    use resvg::tiny_skia::Pixmap;
    use resvg::usvg;

    use super::*;
    use crate::cells::LEVELS;

    fn svg(shapes: &str) -> String {
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='120' height='80' viewBox='0 0 1200 800' stroke-linejoin='round' \
             role='img'><title>T</title><rect x='0' y='0' width='1200' height='800' fill='#FFFFFF' stroke='none'/>{shapes}</svg>"
        )
    }

    fn directly(svg: &str) -> Option<Picture> {
        draw(&Document::parse(svg).unwrap(), 2.0, vec![7; 99])
    }

    /// The largest difference of a colour from what another program draws with 64 times as many pixels.
    fn difference(picture: &Picture, svg: &str) -> f64 {
        const FINE: usize = 8;
        let tree = usvg::Tree::from_str(svg, &usvg::Options::default()).unwrap();
        let (columns, rows) = (picture.columns * FINE, picture.rows * FINE);
        let mut fine = Pixmap::new(u32::try_from(columns).unwrap(), u32::try_from(rows).unwrap()).unwrap();
        resvg::render(&tree, Transform::from_scale(16.0, 16.0), &mut fine.as_mut());
        let mut largest = 0.0_f64;
        for (row, column) in (0..picture.rows).flat_map(|row| (0..picture.columns).map(move |column| (row, column))) {
            let mut sums = [0_u32; 3];
            for (down, right) in (0..FINE).flat_map(|down| (0..FINE).map(move |right| (down, right))) {
                let pixel = fine.pixels()[(row * FINE + down) * columns + column * FINE + right];
                for (sum, part) in sums.iter_mut().zip([pixel.red(), pixel.green(), pixel.blue()]) {
                    *sum += u32::from(part);
                }
            }
            for (sum, part) in sums.into_iter().zip(picture.color(column, row)) {
                largest = largest.max((f64::from(sum) / 64.0 - f64::from(part)).abs());
            }
        }
        largest
    }

    #[test]
    fn shapes_are_those_of_any_other_program() {
        let font = "font-family='Noto Sans, sans-serif' fill='#22262E'";
        // Half a level, and rounding.
        let level = 255.0 / f64::from(LEVELS) / 2.0 + 1.0;
        // Corners and letters may be a twentieth of a pixel beside their curves.
        let close = level + 255.0 / 20.0;
        for (shapes, most) in [
            ("<rect x='101' y='203' width='417' height='108' opacity='1' fill='#E3E8EE' stroke='none'/>", level),
            ("<polyline fill='none' opacity='1' stroke='#000000' stroke-width='9' points='100,107 900,107 '/>", level),
            ("<polyline fill='none' opacity='1' stroke='#000000' stroke-width='9' points='107,100 107,900 '/>", level),
            (
                "<polyline fill='none' opacity='0.45' stroke='#D55E00' stroke-width='60' points='90,790 300,10 333,400'/>",
                close,
            ),
            (
                "<polyline fill='none' stroke='#000000' stroke-width='60' points='90,290 300,210 500,300 900,280 600,700'/>",
                close,
            ),
            ("<polygon opacity='0.28' fill='#0072B2' points='50,300 600,200 601,444 '/>", level),
            ("<circle cx='600' cy='400' r='46' opacity='1' fill='#0072B2' stroke='none' stroke-width='1'/>", close),
        ] {
            let svg = svg(shapes);
            // Without a layer of its own a pale shape has a pale colour.
            let plain = svg
                .replace(" opacity='0.45'", " stroke-opacity='0.45'")
                .replace(" opacity='0.28'", " fill-opacity='0.28'");
            let difference = difference(&directly(&svg).unwrap(), &plain);
            assert!(difference <= most, "{difference} {shapes}");
        }
        for text in [
            format!("<text x='180' y='140' dy='0.76em' text-anchor='middle' font-size='150' {font}>τ₁ (N·m)</text>"),
            format!("<text x='180' y='140' font-size='150' transform='rotate(270, 180, 240)' {font}>To</text>"),
        ] {
            let svg = crate::text::with_shifts(&svg(&text));
            let directly = directly(&svg).unwrap();
            let difference = difference(&directly, &letters::outlined(&svg).unwrap());
            let is_drawn = (0..240).any(|column| (0..160).any(|row| directly.color(column, row)[0] < 99));
            assert!(difference <= close && is_drawn, "{difference} {text}");
        }
    }

    #[test]
    fn lines_are_as_dark_as_what_they_cover() {
        let line = "<polyline fill='none' stroke='#000000' stroke-width='10' points='100,400 900,400'/>";
        // 2 pixels wide around y = 80.
        let column = |line: &str| {
            let picture = directly(&svg(line)).unwrap();
            (77..83).map(|row| picture.color(100, row)[0]).collect::<Vec<u8>>()
        };
        assert_eq!(column(line), [255, 255, 0, 0, 255, 255]);
        let column = column(&line.replace("400", "402"));
        assert!(column[2].abs_diff(102) < 3 && column[3] == 0 && column[4].abs_diff(153) < 3, "{column:?}");
    }

    #[test]
    fn lines_have_round_corners_flat_ends_and_no_holes() {
        // To and fro, turns of all angles, and points that are the same.
        let star = (0..40).map(|index| {
            let angle = f64::from(index * index) * 0.7;
            format!("{:.0},{:.0}", 600.0 + 300.0 * angle.cos(), 400.0 + 300.0 * angle.sin())
        });
        for points in [
            star.collect::<Vec<_>>().join(" "),
            "100,400 900,400 500,400 700,400".into(),
            "300,300 300,300 400,300 400,300 400,400".into(),
            "200,600 210,200 220,600 230,200 240,600".into(),
            "500,500 501,500 501,501 500,501 502,503 499,500".into(),
        ] {
            let line = format!("<polyline fill='none' stroke='#000000' stroke-width='60' points='{points}'/>");
            let svg = svg(&line);
            let difference = difference(&directly(&svg).unwrap(), &svg);
            // Half of a pixel may be covered twice, and counts as all of it.
            assert!(difference <= 140.0, "{difference} {points}");
        }
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

//! Line charts as SVG, drawn with plotters.
//!
//! Plotters rounds all coordinates to whole units. So a chart is drawn on a canvas of ten units per px and scaled down by
//! the SVG's own size.

mod bands;
mod chatter;
mod cut;
mod heights;
mod panel;
mod pen;
mod points;
mod signals;
mod thinned;
mod ticks;

use plotters::prelude::*;
use quick_xml::escape::partial_escape;

use crate::text;
pub use chatter::{Chatter, chatter};
use pen::{
    CURVE, Canvas, DrawResult, LABEL_SIZE, TITLE_SIZE, TextLook, WIDE, WIDE_OPACITY, draw_line, pen, units, write,
};
pub use plotters::style::RGBColor;
pub use points::Points;
pub use signals::Signals;

/// Dark text.
pub const INK: RGBColor = RGBColor(0x22, 0x26, 0x2E);

/// Colours that stay apart for colour-blind readers (Okabe and Ito 2008).
pub mod palette {
    use plotters::style::RGBColor;

    /// Blue.
    pub const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xB2);
    /// Vermilion.
    pub const VERMILION: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
    /// Bluish green.
    pub const GREEN: RGBColor = RGBColor(0x00, 0x9E, 0x73);
    /// Reddish purple.
    pub const PURPLE: RGBColor = RGBColor(0xCC, 0x79, 0xA7);
    /// All of them.
    pub const ALL: [RGBColor; 4] = [BLUE, VERMILION, GREEN, PURPLE];
}

/// Left of titles and names, in px.
const MARGIN: f64 = 18.0;

/// Room for the line before a name and for what is between names, in px.
const BESIDE_NAME: f64 = 57.0;

/// By how many px a figure is lower without its title.
const UNTITLED: u32 = 28;

/// One figure: panels below each other, each row holding one or more side by side.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Title.
    pub title: String,
    /// Width and height in px.
    pub size: (u32, u32),
    /// Rows of panels.
    pub rows: Vec<Vec<Panel>>,
}

/// One pair of axes.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// Heading inside the panel, for figures with several.
    pub heading: Option<String>,
    /// Label of the horizontal axis; none for panels above another one with the same axis.
    pub x_label: Option<String>,
    /// Label of the vertical axis.
    pub y_label: String,
    /// Shown range of the horizontal axis.
    pub x_range: (f64, f64),
    /// Values that the vertical axis must include; it grows with the curves.
    pub y_include: Vec<f64>,
    /// The vertical axis fits the curves from this time on; earlier parts beyond it are cut off.
    pub y_from: Option<f64>,
    /// Width relative to the other panels of the row; 0 counts as 1.
    pub weight: f64,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Draw the first curve above the others instead of below them.
    pub first_on_top: bool,
    /// Values the curves shall reach.
    pub targets: Vec<Target>,
    /// Marked points.
    pub marks: Vec<Mark>,
}

/// One curve.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Its name in the legend; curves without one are not in it.
    pub name: String,
    /// Colour.
    pub color: RGBColor,
    /// Wide, pale and below the others, so that both show where another curve coincides with it.
    pub wide: bool,
    /// Points from left to right.
    pub points: Points,
}

/// A horizontal line to be reached, with a band around it.
#[derive(Debug, Clone)]
pub struct Target {
    /// Its value.
    pub value: f64,
    /// Half width of the band; 0 for none.
    pub band: f64,
    /// Text at the right end; further lines follow below.
    pub labels: Vec<String>,
}

/// A marked point with a label above the panel's curves.
#[derive(Debug, Clone)]
pub struct Mark {
    /// The point.
    pub point: (f64, f64),
    /// Colour of point and label.
    pub color: RGBColor,
    /// The label's first line, bold.
    pub name: String,
    /// The label's second line.
    pub text: String,
}

/// A plot's rectangle in px, and where its outer left margin begins.
#[derive(Clone, Copy)]
struct Frame {
    outer: f64,
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Figure {
    /// The figure as an SVG document.
    ///
    /// # Panics
    /// Never: drawing into a string cannot fail.
    #[must_use]
    pub fn to_svg(&self) -> String {
        self.svg(true)
    }

    /// The same without the title, for papers whose captions contain it.
    ///
    /// # Panics
    /// Never: drawing into a string cannot fail.
    #[must_use]
    pub fn to_untitled_svg(&self) -> String {
        let (width, height) = self.size;
        Self { size: (width, height - UNTITLED), ..self.clone() }.svg(false)
    }

    fn svg(&self, titled: bool) -> String {
        let (width, height) = self.size;
        let mut svg = String::new();
        let canvas_size = (units(f64::from(width)).unsigned_abs(), units(f64::from(height)).unsigned_abs());
        {
            let canvas = SVGBackend::with_string(&mut svg, canvas_size).into_drawing_area();
            self.draw(&canvas, titled).expect("drawing into a string cannot fail");
            canvas.present().expect("drawing into a string cannot fail");
        }
        self.polish(&svg)
    }

    fn draw(&self, canvas: &Canvas, titled: bool) -> DrawResult {
        canvas.fill(&WHITE)?;
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let mut frame = Frame { outer: 0.0, left: 0.0, top: 14.0, right: width, bottom: height - 6.0 };
        if titled {
            let title = text::shortened(&self.title, TITLE_SIZE, true, width - 2.0 * MARGIN);
            write(canvas, &title, (MARGIN, frame.top), &TextLook::new(TITLE_SIZE, INK).bold())?;
            frame.top += f64::from(UNTITLED);
        }
        if self.draw_legend(canvas, frame.top)? {
            frame.top += 26.0;
        }

        let labelled = |row: &[Panel]| row.iter().any(|panel| panel.x_label.is_some());
        let chrome = |row: &[Panel]| if labelled(row) { 42.0 } else { 12.0 };
        let chromes: f64 = self.rows.iter().map(|row| chrome(row)).sum();
        let plot_height = (frame.bottom - frame.top - chromes) / self.rows.len() as f64;
        // To find the range of an axis means to look at all points.
        let rows: Vec<Vec<_>> =
            self.rows.iter().map(|row| row.iter().map(|panel| (panel, panel.y_range())).collect()).collect();
        // Panels below each other begin and end at the same place.
        let widest = |column: usize, margin: &dyn Fn(&Panel, (f64, f64)) -> f64| {
            let panels = rows.iter().filter_map(|row| row.get(column));
            panels.map(|(panel, y_range)| margin(panel, *y_range)).fold(0.0, f64::max)
        };
        for (row, panels) in self.rows.iter().zip(&rows) {
            let bottom = frame.top + plot_height;
            let weights: f64 = row.iter().map(Panel::weight).sum();
            let mut left = 0.0;
            for (column, (panel, y_range)) in panels.iter().enumerate() {
                let right = left + (width - 8.0) * panel.weight() / weights;
                let inner = Frame {
                    outer: left,
                    left: left + widest(column, &|panel, y_range| panel.left_margin(y_range, plot_height)),
                    top: frame.top,
                    right: right - widest(column, &|panel, _| panel.right_margin()),
                    bottom,
                };
                panel.draw(canvas, inner, *y_range)?;
                left = right;
            }
            frame.top = bottom + chrome(row);
        }
        Ok(())
    }

    /// Draws every name once, in one line above the panels, where it covers nothing. False if there is only one curve, or
    /// marks identify all curves.
    fn draw_legend(&self, canvas: &Canvas, top: f64) -> Result<bool, DrawingAreaErrorKind<std::io::Error>> {
        let mut entries: Vec<&Curve> = Vec::new();
        let mut all_marked = true;
        for panel in self.rows.iter().flatten() {
            for curve in panel.curves.iter().filter(|curve| !curve.name.is_empty()) {
                all_marked &= panel.marks.iter().any(|mark| mark.name == curve.name);
                if !entries.iter().any(|known| known.name == curve.name) {
                    entries.push(curve);
                }
            }
        }
        if entries.len() < 2 || all_marked {
            return Ok(false);
        }
        let mut left = MARGIN;
        // Names share the line.
        let room = (f64::from(self.size.0) - 2.0 * MARGIN) / entries.len() as f64 - BESIDE_NAME;
        let widths = || entries.iter().map(|curve| text::width(&curve.name, LABEL_SIZE, false) + BESIDE_NAME);
        let is_long = widths().sum::<f64>() > f64::from(self.size.0) - MARGIN;
        for curve in entries {
            let room = if is_long { room } else { f64::INFINITY };
            let name = text::shortened(&curve.name, LABEL_SIZE, false, room);
            let line = [(left, top + 8.0), (left + 26.0, top + 8.0)];
            draw_line(canvas, line, curve.style())?;
            write(canvas, &name, (left + 33.0, top + 8.0), &TextLook::new(LABEL_SIZE, INK).centered())?;
            left += text::width(&name, LABEL_SIZE, false) + BESIDE_NAME;
        }
        Ok(true)
    }

    /// Adds features that plotters lacks: size in px, round joins, a description for screen readers.
    fn polish(&self, svg: &str) -> String {
        let (width, height) = self.size;
        let start = svg.find("<svg").map_or(0, |at| at + 4);
        let end = start + svg[start..].find('>').unwrap_or(0);
        let title = partial_escape(self.title.as_str());
        let polished = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {} {}\" stroke-linejoin=\"round\" role=\"img\">\n<title>{title}</title>{}",
            units(f64::from(width)),
            units(f64::from(height)),
            &svg[end + 1..]
        );
        text::with_shifts(&polished)
    }
}

impl Panel {
    /// How far its curves go up and down around zero, from a time on.
    #[must_use]
    pub fn span(&self, from: f64) -> f64 {
        let curves = self.curves.iter().filter_map(|curve| curve.points.all().shown((from, f64::INFINITY)));
        let (low, high) = curves.fold((0.0_f64, 0.0_f64), |(low, high), (l, h)| (low.min(l), high.max(h)));
        high - low
    }
}

impl Curve {
    fn style(&self) -> ShapeStyle {
        if self.wide { pen(self.color.mix(WIDE_OPACITY), WIDE) } else { pen(self.color, CURVE) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(curves: Vec<Curve>) -> Figure {
        let panel = Panel {
            x_label: Some("Time (s)".into()),
            y_label: "Force (N)".into(),
            x_range: (0.0, 5.0),
            curves,
            ..Panel::default()
        };
        Figure { title: "A & B".into(), size: (720, 400), rows: vec![vec![panel]] }
    }

    #[test]
    fn svg_files_are_small_valid_and_show_coinciding_curves() {
        let noise: Points =
            (0..50_000).map(|index| (f64::from(index) * 1e-4, (f64::from(index) * 0.7).sin())).collect();
        let curve = |name: &str, wide| Curve { name: name.into(), color: palette::BLUE, wide, points: noise.clone() };
        let svg = figure(vec![curve("one", false), curve("two", true)]).to_svg();
        assert!(svg.len() < 200_000, "{} bytes", svg.len());
        let document = roxmltree::Document::parse(&svg).unwrap();
        assert_eq!(document.root_element().attribute("width"), Some("720"));
        let curves: Vec<_> =
            document.descendants().filter(|node| node.attribute("stroke") == Some("#0072B2")).collect();
        assert_eq!(curves.len(), 6, "both edges of two curves that swing too fast, and two legend samples");
        let width = |index: usize| curves[index].attribute("stroke-width").unwrap().parse::<u32>().unwrap();
        // The legend's samples in its order; of the curves the wide one first, or it would hide the other.
        assert!(width(1) > 2 * width(0) && width(2) > 2 * width(4));
        assert!(document.descendants().any(|node| node.text() == Some("A & B")));
    }

    #[test]
    fn long_names_stay_inside() {
        let long = "A name with many letters ".repeat(20);
        let curve = |name: &str| Curve {
            name: name.into(),
            color: palette::BLUE,
            wide: false,
            points: Points::from_iter([(0.0, 0.0), (1.0, 1.0)]),
        };
        let mut figure = figure(vec![curve(&long), curve("short"), curve(&long[1..])]);
        figure.title.clone_from(&long);
        figure.rows[0][0].heading = Some(long.clone());
        let svg = figure.to_svg();
        let document = roxmltree::Document::parse(&svg).unwrap();
        assert!(document.descendants().any(|node| node.has_tag_name("title") && node.text() == Some(&long)));
        for text in document.descendants().filter(|node| node.has_tag_name("text")) {
            let placed = crate::letters::placed(text).unwrap();
            let ends = placed.iter().flat_map(|one| [one.x, one.x + one.outline.width() * one.scale]);
            assert!(text.has_attribute("transform") || ends.into_iter().all(|x| (0.0..=7200.0).contains(&x)));
        }
        assert_eq!(svg.matches('…').count(), 4);
        assert!(svg.contains(">\nshort\n<"));
    }

    #[test]
    fn empty_and_constant_curves_do_not_break_the_axes() {
        for points in [vec![], vec![(0.0, 0.0), (5.0, 0.0)], vec![(0.0, f64::NAN)], vec![(1.0, 7.0)]] {
            let points = points.into_iter().collect();
            let svg = figure(vec![Curve { name: String::new(), color: palette::GREEN, wide: false, points }]).to_svg();
            assert!(!svg.contains("NaN") && roxmltree::Document::parse(&svg).is_ok());
        }
    }
}

//! Lines and texts in px on the canvas.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::text;

/// Canvas units per px.
pub(super) const UNITS: f64 = 10.0;
/// Width of curves in px.
pub(super) const CURVE: f64 = 1.8;
/// Width in px and opacity of curves that others may lie on.
pub(super) const WIDE: f64 = 6.0;
pub(super) const WIDE_OPACITY: f64 = 0.45;
pub(super) const TITLE_SIZE: f64 = 15.0;
pub(super) const LABEL_SIZE: f64 = 12.5;
pub(super) const TICK_SIZE: f64 = 11.5;

pub(super) type Canvas<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
pub(super) type PlotArea<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
pub(super) type DrawResult = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// px to canvas units.
#[allow(clippy::cast_possible_truncation)] // far below the limits of i32
pub(super) fn units(pixels: f64) -> i32 {
    (pixels * UNITS).round() as i32
}

/// Strokes of a width in px.
pub(super) fn pen(color: impl Color, width: f64) -> ShapeStyle {
    color.stroke_width(units(width).unsigned_abs())
}

pub(super) fn draw_line(canvas: &Canvas, ends: [(f64, f64); 2], style: ShapeStyle) -> DrawResult {
    let path = ends.map(|(x, y)| (units(x), units(y)));
    canvas.draw(&PathElement::new(path, style))
}

/// How a text looks and which of its points lies where it is written.
#[derive(Clone)]
pub(super) struct TextLook {
    size: f64,
    color: RGBColor,
    bold: bool,
    upwards: bool,
    horizontal: HPos,
    vertical: VPos,
}

impl TextLook {
    pub(super) fn new(size: f64, color: RGBColor) -> Self {
        Self { size, color, bold: false, upwards: false, horizontal: HPos::Left, vertical: VPos::Top }
    }
    pub(super) fn bold(self) -> Self {
        Self { bold: true, ..self }
    }
    pub(super) fn upwards(self) -> Self {
        Self { upwards: true, ..self }
    }
    pub(super) fn in_middle(self) -> Self {
        Self { horizontal: HPos::Center, ..self }
    }
    pub(super) fn at_end(self) -> Self {
        Self { horizontal: HPos::Right, ..self }
    }
    /// Vertically.
    pub(super) fn centered(self) -> Self {
        Self { vertical: VPos::Center, ..self }
    }
}

pub(super) fn write(canvas: &Canvas, text: &str, at: (f64, f64), look: &TextLook) -> DrawResult {
    // The SVG backend takes font sizes for heights of lines, 1.24 times as large.
    let style = if look.bold { FontStyle::Bold } else { FontStyle::Normal };
    let font = FontDesc::new(FontFamily::Name(text::FAMILIES), look.size * UNITS * 1.24, style);
    let font = if look.upwards { font.transform(FontTransform::Rotate270) } else { font };
    let style = TextStyle::from(font).color(&look.color).pos(Pos::new(look.horizontal, look.vertical));
    canvas.draw_text(text, &style, (units(at.0), units(at.1)))
}

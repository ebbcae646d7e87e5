//! Line charts as SVG, drawn with plotters.
//!
//! Plotters places everything on whole units. So a chart is drawn on a canvas of ten units per px and scaled down by the
//! SVG's own size.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::text;

/// Canvas units per px.
const UNITS: f64 = 10.0;
/// Width of curves in px.
const CURVE: f64 = 1.8;
/// Width in px and opacity of curves that others may lie on.
const WIDE: f64 = 6.0;
const WIDE_OPACITY: f64 = 0.45;
const TITLE_SIZE: f64 = 15.0;
const LABEL_SIZE: f64 = 12.5;
const TICK_SIZE: f64 = 11.5;

/// Dark text.
pub const INK: RGBColor = RGBColor(0x22, 0x26, 0x2E);
const SOFT_INK: RGBColor = RGBColor(0x5B, 0x63, 0x70);
const GRID: RGBColor = RGBColor(0xE6, 0xE9, 0xEE);
const AXIS: RGBColor = RGBColor(0x9A, 0xA2, 0xAE);
const BAND: RGBColor = RGBColor(0xE3, 0xE8, 0xEE);

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
    /// What the vertical axis must at least show; it grows with the curves.
    pub y_include: Vec<f64>,
    /// The vertical axis follows the curves from this time on; what leaves it before is cut off.
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
    pub points: Vec<(f64, f64)>,
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

type Canvas<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type PlotArea<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type DrawResult = Result<(), DrawingAreaErrorKind<std::io::Error>>;

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
        let (width, height) = self.size;
        let mut svg = String::new();
        let canvas_size = (units(f64::from(width)).unsigned_abs(), units(f64::from(height)).unsigned_abs());
        {
            let canvas = SVGBackend::with_string(&mut svg, canvas_size).into_drawing_area();
            self.draw(&canvas).expect("drawing into a string cannot fail");
            canvas.present().expect("drawing into a string cannot fail");
        }
        self.polish(&svg)
    }

    fn draw(&self, canvas: &Canvas) -> DrawResult {
        canvas.fill(&WHITE)?;
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let mut frame = Frame { outer: 0.0, left: 0.0, top: 14.0, right: width, bottom: height - 6.0 };
        write(canvas, &self.title, (18.0, frame.top), &TextLook::new(TITLE_SIZE, INK).bold())?;
        frame.top += 28.0;
        if self.draw_legend(canvas, frame.top)? {
            frame.top += 26.0;
        }

        let labelled = |row: &[Panel]| row.iter().any(|panel| panel.x_label.is_some());
        let chrome = |row: &[Panel]| if labelled(row) { 42.0 } else { 12.0 };
        let chromes: f64 = self.rows.iter().map(|row| chrome(row)).sum();
        let plot_height = (frame.bottom - frame.top - chromes) / self.rows.len() as f64;
        // Panels below each other begin and end at the same place.
        let widest = |column: usize, margin: &dyn Fn(&Panel) -> f64| {
            self.rows.iter().filter_map(|row| row.get(column)).map(margin).fold(0.0, f64::max)
        };
        for row in &self.rows {
            let bottom = frame.top + plot_height;
            let weights: f64 = row.iter().map(Panel::weight).sum();
            let mut left = 0.0;
            for (column, panel) in row.iter().enumerate() {
                let right = left + (width - 8.0) * panel.weight() / weights;
                let inner = Frame {
                    outer: left,
                    left: left + widest(column, &|panel| panel.left_margin(plot_height)),
                    top: frame.top,
                    right: right - widest(column, &Panel::right_margin),
                    bottom,
                };
                panel.draw(canvas, inner)?;
                left = right;
            }
            frame.top = bottom + chrome(row);
        }
        Ok(())
    }

    /// Every name once, in one line above the panels, where it covers nothing. False if there is nothing to tell apart,
    /// or marks tell all curves apart.
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
        let mut left = 18.0;
        for curve in entries {
            let line = [(left, top + 8.0), (left + 26.0, top + 8.0)];
            draw_line(canvas, line, curve.style())?;
            write(canvas, &curve.name, (left + 33.0, top + 8.0), &TextLook::new(LABEL_SIZE, INK).centered())?;
            left += 33.0 + text::width(&curve.name, LABEL_SIZE, false) + 24.0;
        }
        Ok(true)
    }

    /// What plotters cannot say: size in px, round joins, a description for screen readers.
    fn polish(&self, svg: &str) -> String {
        let (width, height) = self.size;
        let start = svg.find("<svg").map_or(0, |at| at + 4);
        let end = start + svg[start..].find('>').unwrap_or(0);
        let title = self.title.replace('&', "&amp;").replace('<', "&lt;");
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

impl Curve {
    fn style(&self) -> ShapeStyle {
        if self.wide { pen(self.color.mix(WIDE_OPACITY), WIDE) } else { pen(self.color, CURVE) }
    }
}

impl Panel {
    fn weight(&self) -> f64 {
        if self.weight > 0.0 { self.weight } else { 1.0 }
    }

    /// Round values of the vertical axis, written out, and the power of ten that is left out of them.
    fn y_ticks(&self, plot_height: f64) -> (Vec<(f64, String)>, i32) {
        const MAX_DECIMALS: usize = 3;
        let (values, decimals) = ticks(self.y_range(), (plot_height / 44.0).max(2.5));
        let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        #[allow(clippy::cast_possible_truncation)] // within ±308
        let power = if decimals > MAX_DECIMALS && largest > 0.0 && !self.y_label.is_empty() {
            3 * (largest.log10() / 3.0 + 1e-9).floor() as i32
        } else {
            0
        };
        let decimals = decimals.saturating_sub(power.unsigned_abs() as usize);
        let written = |value: f64| text::number(value / 10_f64.powi(power), decimals);
        (values.into_iter().map(|value| (value, written(value))).collect(), power)
    }

    /// The vertical axis's label, with the power of ten that its numbers lack in front of the unit.
    fn y_label(&self, power: i32) -> String {
        let factor = match power {
            0 => return self.y_label.clone(),
            -3 => "10⁻³".into(),
            -6 => "10⁻⁶".into(),
            -9 => "10⁻⁹".into(),
            _ => format!("1e{power}"),
        };
        match self.y_label.rsplit_once('(') {
            Some((name, unit)) => format!("{name}({factor} {unit}"),
            None => format!("{} ({factor})", self.y_label),
        }
    }

    /// Room for the vertical axis's numbers and label.
    fn left_margin(&self, plot_height: f64) -> f64 {
        let (ticks, _) = self.y_ticks(plot_height);
        let numbers = ticks.into_iter().map(|(_, number)| text::width(&number, TICK_SIZE, false));
        // The label's subscripts hang below its line.
        let label = if self.y_label.is_empty() { 10.0 } else { 41.0 };
        numbers.fold(0.0, f64::max) + label
    }

    /// Room for the labels at the right end of target lines.
    fn right_margin(&self) -> f64 {
        let labels = self.targets.iter().flat_map(|target| &target.labels);
        let widest = labels.map(|label| text::width(label, TICK_SIZE, false)).fold(0.0, f64::max);
        if widest > 0.0 { widest + 10.0 } else { 14.0 }
    }

    fn draw(&self, canvas: &Canvas, frame: Frame) -> DrawResult {
        let y_range = self.y_range();
        let plot: PlotArea = canvas
            .clone()
            .shrink(
                (units(frame.left), units(frame.top)),
                (units(frame.right - frame.left), units(frame.bottom - frame.top)),
            )
            .apply_coord_spec(Cartesian2d::<RangedCoordf64, RangedCoordf64>::new(
                self.x_range.0..self.x_range.1,
                y_range.0..y_range.1,
                (units(frame.left)..units(frame.right), units(frame.bottom)..units(frame.top)),
            ));
        let at = |point: (f64, f64)| {
            let (x, y) = plot.map_coordinate(&point);
            (f64::from(x) / UNITS, f64::from(y) / UNITS)
        };

        for target in self.targets.iter().filter(|target| target.band > 0.0) {
            let (left, low) = at((self.x_range.0, target.value - target.band));
            let (right, high) = at((self.x_range.1, target.value + target.band));
            let corners = [(units(left), units(high)), (units(right), units(low))];
            canvas.draw(&Rectangle::new(corners, BAND.filled()))?;
        }
        self.draw_axes(canvas, frame, y_range, &at)?;
        for target in &self.targets {
            let (_, y) = at((self.x_range.0, target.value));
            draw_line(canvas, [(frame.left, y), (frame.right, y)], pen(SOFT_INK, 0.9))?;
            for (line, label) in target.labels.iter().enumerate() {
                let place = (frame.right + 6.0, y + 14.0 * line as f64);
                write(canvas, label, place, &TextLook::new(TICK_SIZE, SOFT_INK).centered())?;
            }
        }
        let mut curves: Vec<_> = self.curves.iter().collect();
        if self.first_on_top {
            curves.reverse();
        }
        curves.sort_by_key(|curve| !curve.wide);
        for curve in curves {
            // Five columns for four px.
            let points = decimate(&curve.points, self.x_range, (frame.right - frame.left) * 1.25);
            for piece in cut(&points, y_range) {
                let pixels: Vec<_> = piece
                    .into_iter()
                    .map(|point| {
                        let (x, y) = at(point);
                        (units(x), units(y))
                    })
                    .collect();
                canvas.draw(&PathElement::new(pixels, curve.style()))?;
            }
        }
        for mark in &self.marks {
            mark.draw(canvas, frame, &at)?;
        }
        if let Some(heading) = &self.heading {
            let look = TextLook::new(LABEL_SIZE, INK).bold().at_end();
            write(canvas, heading, (frame.right - 8.0, frame.bottom - 22.0), &look)?;
        }
        Ok(())
    }

    fn draw_axes(
        &self,
        canvas: &Canvas,
        frame: Frame,
        y_range: (f64, f64),
        at: &impl Fn((f64, f64)) -> (f64, f64),
    ) -> DrawResult {
        let tick = TextLook::new(TICK_SIZE, SOFT_INK);
        let (x_ticks, x_decimals) = ticks(self.x_range, (frame.right - frame.left) / 75.0);
        for value in x_ticks {
            let (x, _) = at((value, y_range.0));
            draw_line(canvas, [(x, frame.top), (x, frame.bottom)], pen(GRID, 0.9))?;
            if self.x_label.is_some() {
                write(canvas, &text::number(value, x_decimals), (x, frame.bottom + 5.0), &tick.clone().in_middle())?;
            }
        }
        let (y_ticks, power) = self.y_ticks(frame.bottom - frame.top);
        for (value, label) in y_ticks {
            let (_, y) = at((self.x_range.0, value));
            draw_line(canvas, [(frame.left, y), (frame.right, y)], pen(GRID, 0.9))?;
            write(canvas, &label, (frame.left - 7.0, y), &tick.clone().at_end().centered())?;
        }
        draw_line(canvas, [(frame.left, frame.bottom), (frame.right, frame.bottom)], pen(AXIS, 1.0))?;
        draw_line(canvas, [(frame.left, frame.top), (frame.left, frame.bottom)], pen(AXIS, 1.0))?;
        let label = TextLook::new(LABEL_SIZE, INK).in_middle();
        let middle = f64::midpoint(frame.top, frame.bottom);
        write(canvas, &self.y_label(power), (frame.outer + 12.0, middle), &label.clone().upwards())?;
        if let Some(x_label) = &self.x_label {
            write(canvas, x_label, (f64::midpoint(frame.left, frame.right), frame.bottom + 22.0), &label)?;
        }
        Ok(())
    }

    /// The shown vertical range: all curves, targets and wanted values, and a little air.
    fn y_range(&self) -> (f64, f64) {
        let from = self.y_from.map_or(self.x_range.0, |from| from.max(self.x_range.0));
        let curves = self.curves.iter().flat_map(|curve| {
            curve.points.iter().filter(|(x, _)| (from..=self.x_range.1).contains(x)).map(|(_, y)| *y)
        });
        let targets = self.targets.iter().flat_map(|target| [target.value - target.band, target.value + target.band]);
        let values = curves.chain(targets).chain(self.y_include.iter().copied()).filter(|value| value.is_finite());
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            return (-1.0, 1.0);
        }
        if low == 0.0 && high == 0.0 {
            return (-0.06, 1.0);
        }
        let span = high - low;
        // A constant deserves an axis around it, too.
        let air = if span > 1e-12 * high.abs().max(low.abs()) { 0.06 * span } else { (0.1 * high.abs()).max(1e-3) };
        (low - air, high + air)
    }
}

impl Mark {
    fn draw(&self, canvas: &Canvas, frame: Frame, at: &impl Fn((f64, f64)) -> (f64, f64)) -> DrawResult {
        let (x, y) = at(self.point);
        let label_top = frame.top + 6.0;
        draw_line(canvas, [(x, label_top + 30.0), (x, y)], pen(self.color, 1.0))?;
        let center = (units(x), units(y));
        canvas.draw(&Circle::new(center, units(4.6), WHITE.filled()))?;
        canvas.draw(&Circle::new(center, units(3.4), self.color.filled()))?;
        let wide = text::width(&self.name, LABEL_SIZE, true).max(text::width(&self.text, LABEL_SIZE, false));
        let x = x.clamp(frame.left + wide / 2.0 + 3.0, frame.right - wide / 2.0 - 3.0);
        let look = TextLook::new(LABEL_SIZE, self.color).in_middle();
        write(canvas, &self.name, (x, label_top - 2.0), &look.clone().bold())?;
        write(canvas, &self.text, (x, label_top + 13.0), &look)
    }
}

/// Round values inside a range, about `wanted` of them, and the decimals they need.
fn ticks(range: (f64, f64), wanted: f64) -> (Vec<f64>, usize) {
    let raw = (range.1 - range.0) / wanted.max(1.0);
    let power = 10_f64.powf(raw.log10().floor());
    let distance = |step: &f64| (step / raw).ln().abs();
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let step = steps.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(power);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a handful
    let decimals = (-step.log10() - 1e-9).ceil().max(0.0) as usize;
    let mut ticks = Vec::new();
    let mut index = (range.0 / step - 1e-9).ceil();
    while index * step <= range.1 + 1e-9 * step {
        ticks.push(index * step);
        index += 1.0;
    }
    (ticks, decimals)
}

/// Two points per column of pixels, the smallest and the largest, and both ends: what the eye could see of the curve
/// stays.
fn decimate(points: &[(f64, f64)], range: (f64, f64), columns: f64) -> Vec<(f64, f64)> {
    let width = (range.1 - range.0) / columns;
    #[allow(clippy::cast_possible_truncation)] // thousands at most
    let column = |x: f64| ((x - range.0) / width).floor() as i64;
    let inside: Vec<_> =
        points.iter().copied().filter(|(x, y)| *x >= range.0 && *x <= range.1 && y.is_finite()).collect();
    let mut kept: Vec<(f64, f64)> = inside.first().copied().into_iter().collect();
    for group in inside.chunk_by(|a, b| column(a.0) == column(b.0)) {
        let by_y = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let mut extremes: Vec<_> =
            [group.iter().min_by(by_y), group.iter().max_by(by_y)].into_iter().flatten().copied().collect();
        extremes.sort_by(|a, b| a.0.total_cmp(&b.0));
        kept.extend(extremes);
    }
    kept.extend(inside.last());
    kept.dedup();
    without_collinear(kept)
}

/// The pieces of a curve between two heights; each ends where the curve leaves.
fn cut(points: &[(f64, f64)], (low, high): (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let is_inside = |y: f64| (low..=high).contains(&y);
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = Vec::new();
    for (index, &(x, y)) in points.iter().enumerate() {
        if let Some(&(x0, y0)) = index.checked_sub(1).and_then(|before| points.get(before)) {
            // Where the way from the point before crosses the heights, in its order.
            let mut crossings: Vec<(f64, f64)> = [low, high]
                .into_iter()
                .filter(|edge| (y0 < *edge) != (y < *edge) && (y0 - y).abs() > 0.0)
                .map(|edge| (x0 + (edge - y0) / (y - y0) * (x - x0), edge))
                .collect();
            if y < y0 {
                crossings.reverse();
            }
            for crossing in crossings {
                piece.push(crossing);
                if piece.len() > 1 && !is_inside(f64::midpoint(crossing.1, y)) {
                    pieces.push(std::mem::take(&mut piece));
                }
            }
        }
        if is_inside(y) {
            piece.push((x, y));
        } else {
            piece.clear();
        }
    }
    pieces.push(piece);
    pieces.retain(|piece| !piece.is_empty());
    pieces
}

/// Leaves out points on a horizontal line between their neighbours: settled curves are long and flat.
fn without_collinear(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::with_capacity(points.len());
    for point in points {
        if let [.., before, last] = kept.as_slice()
            && before.1.to_bits() == last.1.to_bits()
            && last.1.to_bits() == point.1.to_bits()
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept
}

/// px to canvas units.
#[allow(clippy::cast_possible_truncation)] // far below the limits of i32
fn units(pixels: f64) -> i32 {
    (pixels * UNITS).round() as i32
}

/// Strokes of a width in px.
fn pen(color: impl Color, width: f64) -> ShapeStyle {
    color.stroke_width(units(width).unsigned_abs())
}

fn draw_line(canvas: &Canvas, ends: [(f64, f64); 2], style: ShapeStyle) -> DrawResult {
    let path = ends.map(|(x, y)| (units(x), units(y)));
    canvas.draw(&PathElement::new(path, style))
}

/// How a text looks and which of its points lies where it is written.
#[derive(Clone)]
struct TextLook {
    size: f64,
    color: RGBColor,
    bold: bool,
    upwards: bool,
    horizontal: HPos,
    vertical: VPos,
}

impl TextLook {
    fn new(size: f64, color: RGBColor) -> Self {
        Self { size, color, bold: false, upwards: false, horizontal: HPos::Left, vertical: VPos::Top }
    }
    fn bold(self) -> Self {
        Self { bold: true, ..self }
    }
    fn upwards(self) -> Self {
        Self { upwards: true, ..self }
    }
    fn in_middle(self) -> Self {
        Self { horizontal: HPos::Center, ..self }
    }
    fn at_end(self) -> Self {
        Self { horizontal: HPos::Right, ..self }
    }
    /// Vertically.
    fn centered(self) -> Self {
        Self { vertical: VPos::Center, ..self }
    }
}

fn write(canvas: &Canvas, text: &str, at: (f64, f64), look: &TextLook) -> DrawResult {
    // The SVG backend takes font sizes for heights of lines, 1.24 times as large.
    let style = if look.bold { FontStyle::Bold } else { FontStyle::Normal };
    let font = FontDesc::new(FontFamily::Name(text::FAMILIES), look.size * UNITS * 1.24, style);
    let font = if look.upwards { font.transform(FontTransform::Rotate270) } else { font };
    let style = TextStyle::from(font).color(&look.color).pos(Pos::new(look.horizontal, look.vertical));
    canvas.draw_text(text, &style, (units(at.0), units(at.1)))
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
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((0.0, 5.0), 5.0), (vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 0));
        let (values, decimals) = ticks((-0.012, 0.53), 6.0);
        assert_eq!((values.len(), decimals), (6, 1));
        assert_eq!(ticks((0.0, 0.003), 3.0).1, 3);
    }

    #[test]
    fn small_values_leave_their_power_of_ten_to_the_label() {
        let panel = |top: f64, y_label: &str| Panel {
            y_label: y_label.into(),
            x_range: (0.0, 1.0),
            y_include: vec![0.0, top],
            ..Panel::default()
        };
        let shown = |panel: &Panel| {
            let (ticks, power) = panel.y_ticks(120.0);
            (ticks.last().map(|(_, number)| number.clone()).unwrap_or_default(), panel.y_label(power))
        };
        assert_eq!(shown(&panel(0.0017, "m (kg)")), ("1.5".into(), "m (10⁻³ kg)".into()));
        assert_eq!(shown(&panel(1.7e-5, "‖W‖")), ("15".into(), "‖W‖ (10⁻⁶)".into()));
        assert_eq!(shown(&panel(0.017, "m (kg)")), ("0.015".into(), "m (kg)".into()));
    }

    #[test]
    fn decimation_keeps_every_peak_and_drops_flat_stretches() {
        let spike = |index: u32| if index == 31_234 { 9.0 } else { f64::from(index % 2) };
        let points: Vec<_> = (0..50_000).map(|index| (f64::from(index) * 1e-4, spike(index))).collect();
        let kept = decimate(&points, (0.0, 5.0), 600.0);
        assert!(kept.len() <= 2 * 601 && kept.iter().any(|(_, y)| *y > 8.0));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[49_999]));
        let flat: Vec<_> = (0..50_000).map(|index| (f64::from(index) * 1e-4, 0.5)).collect();
        assert_eq!(decimate(&flat, (0.0, 5.0), 600.0).len(), 2);
    }

    #[test]
    fn curves_are_cut_where_they_leave_the_axis() {
        let points = [(0.0, 4.0), (1.0, 0.0), (2.0, 0.0), (4.0, -4.0), (5.0, -4.0), (6.0, 4.0), (8.0, 0.0)];
        assert_eq!(
            cut(&points, (-1.0, 2.0)),
            [
                vec![(0.5, 2.0), (1.0, 0.0), (2.0, 0.0), (2.5, -1.0)],
                vec![(5.375, -1.0), (5.75, 2.0)],
                vec![(7.0, 2.0), (8.0, 0.0)],
            ]
        );
        assert_eq!(cut(&points[..3], (-9.0, 9.0)), [points[..3].to_vec()]);
    }

    #[test]
    fn svg_files_are_small_valid_and_show_coinciding_curves() {
        let noise: Vec<_> =
            (0..50_000).map(|index| (f64::from(index) * 1e-4, (f64::from(index) * 0.7).sin())).collect();
        let curve = |name: &str, wide| Curve { name: name.into(), color: palette::BLUE, wide, points: noise.clone() };
        let svg = figure(vec![curve("one", false), curve("two", true)]).to_svg();
        assert!(svg.len() < 200_000, "{} bytes", svg.len());
        let document = roxmltree::Document::parse(&svg).unwrap();
        assert_eq!(document.root_element().attribute("width"), Some("720"));
        let curves: Vec<_> =
            document.descendants().filter(|node| node.attribute("stroke") == Some("#0072B2")).collect();
        assert_eq!(curves.len(), 4, "two curves and two legend samples");
        let width = |index: usize| curves[index].attribute("stroke-width").unwrap().parse::<u32>().unwrap();
        // The legend's samples in its order; of the curves the wide one first, or it would hide the other.
        assert!(width(1) > 2 * width(0) && width(2) > 2 * width(3));
        assert!(document.descendants().any(|node| node.text() == Some("A & B")));
    }

    #[test]
    fn empty_and_constant_curves_do_not_break_the_axes() {
        for points in [vec![], vec![(0.0, 0.0), (5.0, 0.0)], vec![(0.0, f64::NAN)], vec![(1.0, 7.0)]] {
            let svg = figure(vec![Curve { name: String::new(), color: palette::GREEN, wide: false, points }]).to_svg();
            assert!(!svg.contains("NaN") && roxmltree::Document::parse(&svg).is_ok());
        }
    }
}

//! Line charts as SVG elements of the page. Colours and fonts come from the page's style sheet, so that a chart follows the
//! reader's choice of light or dark. For this reason, and for short build times in every model crate, no plotting library
//! is used.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

/// Size of the drawing, in px at a scale of one.
const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 232.0;
/// Margins around the axes: on the left for the labels of values, below for those of times.
const LEFT: f64 = 46.0;
const RIGHT: f64 = 8.0;
const TOP: f64 = 8.0;
const BOTTOM: f64 = 34.0;
/// The approximate number of grid lines along each axis.
const LINES: f64 = 5.0;

/// Curves over time, all in one unit.
pub struct Chart<'a> {
    /// Time of each value (s), ascending.
    pub times: &'a [f64],
    /// Values of each curve.
    pub curves: &'a [Vec<f64>],
    /// A description of the chart for readers who cannot see it.
    pub label: &'a str,
}

impl Chart<'_> {
    /// The `<svg>` element.
    pub fn to_svg(&self) -> String {
        let x = Axis::over(self.times.iter().copied(), LEFT..=WIDTH - RIGHT);
        let y = Axis::over(self.curves.iter().flatten().copied(), HEIGHT - BOTTOM..=TOP);
        let mut svg = format!(
            "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">\n",
            quick_xml::escape::escape(self.label)
        );
        let (left, right, bottom) = (LEFT, WIDTH - RIGHT, HEIGHT - BOTTOM);
        for (value, label) in y.ticks() {
            let (at, class) = (y.place(value), if value == 0.0 { "zero" } else { "grid" });
            let _ = writeln!(
                svg,
                "<path class=\"{class}\" d=\"M{left} {at:.1}H{right}\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                left - 6.0,
                at + 3.5
            );
        }
        for (value, label) in x.ticks() {
            let at = x.place(value);
            let _ = writeln!(
                svg,
                "<path class=\"grid\" d=\"M{at:.1} {TOP}V{bottom}\"/>\
                 <text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
                bottom + 14.0
            );
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">time (s)</text>",
            f64::midpoint(left, right),
            HEIGHT - 4.0
        );
        for (i, values) in self.curves.iter().enumerate() {
            let _ = write!(svg, "<path class=\"curve c{}\" d=\"", i + 1);
            for (n, (time, value)) in self.times.iter().zip(values).enumerate() {
                let command = if n == 0 { 'M' } else { 'L' };
                let _ = write!(svg, "{command}{:.1} {:.1}", x.place(*time), y.place(*value));
            }
            svg.push_str("\"/>\n");
        }
        svg.push_str("</svg>\n");
        svg
    }
}

/// The mapping of values to coordinates, from one grid line to another.
struct Axis {
    least: f64,
    greatest: f64,
    spacing: f64,
    places: RangeInclusive<f64>,
}

impl Axis {
    /// An axis from the first to the last of `places` over all values.
    fn over(values: impl Iterator<Item = f64> + Clone, places: RangeInclusive<f64>) -> Self {
        let least = values.clone().fold(f64::INFINITY, f64::min);
        let greatest = values.fold(f64::NEG_INFINITY, f64::max);
        // A constant, up to rounding, still needs an axis with some height.
        let size = least.abs().max(greatest.abs()).max(f64::MIN_POSITIVE / f64::EPSILON);
        let range = if greatest - least > 1e-9 * size { greatest - least } else { size };
        let spacing = round_spacing(range / LINES);
        Self {
            least: (least / spacing + 1e-9).floor() * spacing,
            greatest: (greatest / spacing - 1e-9).ceil() * spacing,
            spacing,
            places,
        }
        .not_empty()
    }

    fn not_empty(mut self) -> Self {
        if self.greatest <= self.least {
            self.greatest = self.least + self.spacing;
        }
        self
    }

    fn place(&self, value: f64) -> f64 {
        let share = (value - self.least) / (self.greatest - self.least);
        self.places.start() + share * (self.places.end() - self.places.start())
    }

    /// Values of the grid with their labels.
    fn ticks(&self) -> impl Iterator<Item = (f64, String)> {
        let (first, last) = ((self.least / self.spacing).round(), (self.greatest / self.spacing).round());
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // A handful.
        let count = (last - first) as usize + 1;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // Between 0 and 9.
        let decimals = (-self.spacing.log10().floor()).clamp(0.0, 9.0) as usize;
        (0..count).map(move |i| {
            let value = (first + i as f64) * self.spacing;
            let plain = self.spacing >= 1e-4 && self.greatest.abs().max(self.least.abs()) < 1e5;
            let label = if plain { format!("{value:.decimals$}") } else { scientific(value) };
            (value, label.replace('-', "\u{2212}"))
        })
    }
}

/// A round number with a power of ten: `2e-5`, `1.5e6`, `0`.
fn scientific(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}").replace(".0e", "e") }
}

/// The least of 1, 2 and 5 times a power of ten that is not below `spacing`.
fn round_spacing(spacing: f64) -> f64 {
    let power = 10_f64.powf(spacing.log10().floor());
    let digit = [1.0, 2.0, 5.0].into_iter().find(|digit| spacing <= digit * power * (1.0 + 1e-9));
    digit.unwrap_or(10.0) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: &[f64]) -> Vec<String> {
        Axis::over(values.iter().copied(), 0.0..=1.0).ticks().map(|(_, label)| label).collect()
    }

    #[test]
    fn grids_have_round_values_that_enclose_the_curve() {
        assert_eq!(labels(&[0.0, 1.0]), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&[-0.013, 0.021]), ["−0.02", "−0.01", "0.00", "0.01", "0.02", "0.03"]);
        assert_eq!(labels(&[0.0, -2.1e-5]), ["−2.5e−5", "−2e−5", "−1.5e−5", "−1e−5", "−5e−6", "0"]);
        assert_eq!(labels(&[0.0, 12_345.0]), ["0", "5000", "10000", "15000"]);
    }

    #[test]
    fn constants_have_an_axis() {
        for constant in [0.0, 1.0, -3e-12, 1e300, 0.1 + 0.2] {
            let axis = Axis::over([constant; 3].into_iter(), 0.0..=1.0);
            assert!((0.0..=1.0).contains(&axis.place(constant)), "{constant}");
            assert!((2..12).contains(&axis.ticks().count()), "{constant}");
        }
    }

    #[test]
    fn curves_stay_inside_the_axes() {
        let times: Vec<f64> = (0..=20).map(|i| f64::from(i) * 0.05).collect();
        let curves = [times.iter().map(|t| 3.7 * (9.0 * t).sin() - 1.0).collect()];
        let svg = Chart { times: &times, curves: &curves, label: "a < b" }.to_svg();
        assert!(svg.contains("aria-label=\"a &lt; b\""));
        let path = svg.split("class=\"curve c1\" d=\"M").nth(1).unwrap().split('"').next().unwrap();
        let points: Vec<f64> = path.split(['L', ' ']).map(|number| number.parse().unwrap()).collect();
        assert_eq!(points.len(), 2 * times.len());
        for point in points.chunks(2) {
            assert!((LEFT..=WIDTH - RIGHT).contains(&point[0]) && (TOP..=HEIGHT - BOTTOM).contains(&point[1]));
        }
        assert_eq!((points[0], points[2 * times.len() - 2]), (LEFT, WIDTH - RIGHT));
    }
}

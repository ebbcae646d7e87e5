//! One pair of axes with its curves, targets and marks.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::bands::{Piece, pieces};
use super::cut::cut;
use super::pen::{Canvas, DrawResult, LABEL_SIZE, PlotArea, TICK_SIZE, TextLook, UNITS, draw_line, pen, units, write};
use super::ticks::ticks;
use super::{Frame, INK, Mark, Panel};
use crate::text;

const SOFT_INK: RGBColor = RGBColor(0x5B, 0x63, 0x70);
const GRID: RGBColor = RGBColor(0xE6, 0xE9, 0xEE);
const AXIS: RGBColor = RGBColor(0x9A, 0xA2, 0xAE);
const BAND: RGBColor = RGBColor(0xE3, 0xE8, 0xEE);

/// Opacity of the area between the edges of a band.
const BAND_OPACITY: f64 = 0.28;

impl Panel {
    pub(super) fn weight(&self) -> f64 {
        if self.weight > 0.0 { self.weight } else { 1.0 }
    }

    /// Round values of the vertical axis, written out, and the power of ten that is left out of them.
    pub(super) fn y_ticks(&self, y_range: (f64, f64), plot_height: f64) -> (Vec<(f64, String)>, i32) {
        const MAX_DECIMALS: usize = 3;
        let (values, decimals) = ticks(y_range, (plot_height / 44.0).max(2.5));
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
    pub(super) fn y_label(&self, power: i32) -> String {
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
    pub(super) fn left_margin(&self, y_range: (f64, f64), plot_height: f64) -> f64 {
        let (ticks, _) = self.y_ticks(y_range, plot_height);
        let numbers = ticks.into_iter().map(|(_, number)| text::width(&number, TICK_SIZE, false));
        // The label's subscripts hang below its line.
        let label = if self.y_label.is_empty() { 10.0 } else { 41.0 };
        numbers.fold(0.0, f64::max) + label
    }

    /// Room for the labels at the right end of target lines.
    pub(super) fn right_margin(&self) -> f64 {
        let labels = self.targets.iter().flat_map(|target| &target.labels);
        let widest = labels.map(|label| text::width(label, TICK_SIZE, false)).fold(0.0, f64::max);
        if widest > 0.0 { widest + 10.0 } else { 14.0 }
    }

    /// Draws it with this [range](Self::y_range) of its vertical axis.
    pub(super) fn draw(&self, canvas: &Canvas, frame: Frame, y_range: (f64, f64)) -> DrawResult {
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
            let size = (frame.right - frame.left, frame.bottom - frame.top);
            let in_units = |point: (f64, f64)| {
                let (x, y) = at(point);
                (units(x), units(y))
            };
            for piece in pieces(&curve.points, self.x_range, y_range.1 - y_range.0, size) {
                let lines = match piece {
                    Piece::Line(points) => cut(&points, y_range),
                    Piece::Band(upper, lower) => {
                        let within = |points: Vec<(f64, f64)>| -> Vec<_> {
                            points.into_iter().map(|(x, y)| (x, y.clamp(y_range.0, y_range.1))).collect()
                        };
                        let (upper, lower) = (within(upper), within(lower));
                        let area = upper.iter().chain(lower.iter().rev()).copied().map(in_units);
                        canvas.draw(&Polygon::new(area.collect::<Vec<_>>(), curve.color.mix(BAND_OPACITY).filled()))?;
                        vec![upper, lower]
                    }
                };
                for line in lines {
                    let pixels: Vec<_> = line.into_iter().map(in_units).collect();
                    canvas.draw(&PathElement::new(pixels, curve.style()))?;
                }
            }
        }
        for mark in &self.marks {
            mark.draw(canvas, frame, &at)?;
        }
        if let Some(heading) = &self.heading {
            let look = TextLook::new(LABEL_SIZE, INK).bold().at_end();
            let heading = text::shortened(heading, LABEL_SIZE, true, frame.right - frame.left - 16.0);
            write(canvas, &heading, (frame.right - 8.0, frame.bottom - 22.0), &look)?;
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
        let (y_ticks, power) = self.y_ticks(y_range, frame.bottom - frame.top);
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
    pub(super) fn y_range(&self) -> (f64, f64) {
        let from = self.y_from.map_or(self.x_range.0, |from| from.max(self.x_range.0));
        let curves = self.curves.iter().filter_map(|curve| curve.points.all().shown((from, self.x_range.1)));
        let curves = curves.flat_map(|(low, high)| [low, high]);
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
    pub(super) fn draw(&self, canvas: &Canvas, frame: Frame, at: &impl Fn((f64, f64)) -> (f64, f64)) -> DrawResult {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_values_leave_their_power_of_ten_to_the_label() {
        let panel = |top: f64, y_label: &str| Panel {
            y_label: y_label.into(),
            x_range: (0.0, 1.0),
            y_include: vec![0.0, top],
            ..Panel::default()
        };
        let shown = |panel: &Panel| {
            let (ticks, power) = panel.y_ticks(panel.y_range(), 120.0);
            (ticks.last().map(|(_, number)| number.clone()).unwrap_or_default(), panel.y_label(power))
        };
        assert_eq!(shown(&panel(0.0017, "m (kg)")), ("1.5".into(), "m (10⁻³ kg)".into()));
        assert_eq!(shown(&panel(1.7e-5, "‖W‖")), ("15".into(), "‖W‖ (10⁻⁶)".into()));
        assert_eq!(shown(&panel(0.017, "m (kg)")), ("0.015".into(), "m (kg)".into()));
    }
}

//! A derivative as the limit of difference quotients, extrapolated to a width of zero (Richardson; Ridders' choice among the
//! extrapolations by how much they still change).
//!
//! For linear functions the quotients are exact up to rounding, and so is the result. For smooth ones it has ten digits or
//! more.

/// How often the width is halved at most.
const LEVELS: usize = 18;
/// How often a quotient is extrapolated: beyond, rounding gains more than truncation loses.
const ORDERS: usize = 6;
/// Change between extrapolations that ends the search, relative to the value.
const GOOD: f64 = 1e-13;

/// Derivatives at 0 of the components of a function.
///
/// `function` is asked only between `-below` and `above` (both ≥ 0); it may have no value somewhere. On `scale` it changes
/// notably. `None` if it has no value on either side of 0.
pub(crate) fn derivative(
    mut function: impl FnMut(f64) -> Option<Vec<f64>>,
    below: f64,
    above: f64,
    scale: f64,
) -> Option<Vec<f64>> {
    let widest = scale / 64.0;
    let both = below.min(above);
    // Towards one side only where the other has no room.
    let (room, side) = match (both >= widest / 4.0, above >= below) {
        (true, _) => (both, None),
        (false, true) => (above, Some(1.0)),
        (false, false) => (below, Some(-1.0)),
    };
    let first = power_of_two_below(widest.min(room))?;
    let here = if side.is_some() { Some(function(0.0)?) } else { None };
    let ratio: f64 = if side.is_some() { 2.0 } else { 4.0 };
    let mut table: Vec<Extrapolation> = Vec::new();
    for level in 0..LEVELS {
        let width = first * 0.5_f64.powi(i32::try_from(level).unwrap_or(0));
        let quotients: Option<Vec<f64>> = match (side, &here) {
            (Some(side), Some(here)) => function(side * width).map(|there| quotients(&there, here, side * width)),
            _ => function(width).zip(function(-width)).map(|(right, left)| quotients(&right, &left, 2.0 * width)),
        };
        let Some(quotients) = quotients else {
            // No value there: begin anew nearer to 0.
            table.clear();
            continue;
        };
        table.resize_with(quotients.len(), Extrapolation::default);
        for (column, quotient) in table.iter_mut().zip(quotients) {
            column.add(quotient, ratio);
        }
        if table.iter().all(Extrapolation::is_good) {
            break;
        }
    }
    let best: Vec<f64> = table.iter().map(|column| column.best).collect();
    (!table.is_empty() && best.iter().all(|value| value.is_finite())).then_some(best)
}

fn quotients(right: &[f64], left: &[f64], width: f64) -> Vec<f64> {
    right.iter().zip(left).map(|(right, left)| (right - left) / width).collect()
}

/// Widths are powers of two, so that dividing by them does not round.
fn power_of_two_below(value: f64) -> Option<f64> {
    (value.is_finite() && value >= f64::MIN_POSITIVE).then(|| f64::from_bits(value.to_bits() & 0x7ff0_0000_0000_0000))
}

/// The extrapolations of one component.
#[derive(Default)]
struct Extrapolation {
    /// Those that end with the last quotient, by order.
    row: Vec<f64>,
    best: f64,
    /// How much the best one changed last; infinite before there are two.
    change: f64,
    count: usize,
}

impl Extrapolation {
    fn add(&mut self, quotient: f64, ratio: f64) {
        let mut row = vec![quotient];
        if self.count == 0 {
            (self.best, self.change) = (quotient, f64::INFINITY);
        }
        let mut power = 1.0;
        for (order, before) in self.row.iter().take(ORDERS).enumerate() {
            power *= ratio;
            let value = row[order] + (row[order] - before) / (power - 1.0);
            let change = (value - row[order]).abs().max((value - before).abs());
            if change < self.change {
                (self.best, self.change) = (value, change);
            }
            row.push(value);
        }
        self.row = row;
        self.count += 1;
    }

    fn is_good(&self) -> bool {
        self.count >= 4 && self.change <= GOOD * self.best.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(function: impl Fn(f64) -> f64, below: f64, above: f64) -> f64 {
        derivative(|s| Some(vec![function(s)]), below, above, 1.0).unwrap()[0]
    }

    #[test]
    fn linear_functions_have_their_slope() {
        // Rounding of the values, divided by the least width that is used.
        assert!((of(|s| 3.0 + 0.7 * s, 9.0, 9.0) - 0.7).abs() < 1e-12);
        assert!((of(|s| 3.0 + 0.7 * s, 0.0, 9.0) - 0.7).abs() < 1e-12);
        assert_eq!(of(|_| 3.0, 9.0, 9.0), 0.0);
    }

    #[test]
    fn smooth_functions_have_ten_digits() {
        for (below, above) in [(9.0, 9.0), (0.0, 9.0), (9.0, 0.0)] {
            assert!((of(|s| (2.0 * s + 1.0).exp(), below, above) / (2.0 * 1.0_f64.exp()) - 1.0).abs() < 1e-10);
            assert!(
                (of(|s| (40.0 * s + 0.1).tanh(), below, above) / (40.0 / 0.1_f64.cosh().powi(2)) - 1.0).abs() < 1e-9
            );
        }
        // A kink that is not here.
        assert!((of(|s| (s - 1e-3).max(0.0) + s, 9.0, 9.0) - 1.0).abs() < 1e-10);
    }

    #[test]
    fn values_that_are_missing_are_done_without() {
        let function = |s: f64| (s.abs() < 1e-3).then(|| vec![s.sin(), 1.0]);
        let found = derivative(function, 9.0, 9.0, 1.0).unwrap();
        assert!((found[0] - 1.0).abs() < 1e-10 && found[1] == 0.0);
        assert!(derivative(|s| (s == 0.0).then(|| vec![s]), 9.0, 9.0, 1.0).is_none());
        assert!(derivative(|s| Some(vec![s]), 0.0, 0.0, 1.0).is_none());
    }
}

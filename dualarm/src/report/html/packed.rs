//! The rows of a run as a page holds them: packed to a short text, with what its scripts need to know of them.

use charts::pack::{self, Packer, Scale};
use serde_json::{Value, json};

use crate::report::parameters::ModelParameters;
use fmi2_cosim::record::Table;

/// Rows of a run, packed.
#[derive(Debug, Clone)]
pub struct Packed {
    /// For the page's scripts: number of rows, columns, and their text.
    pub(super) data: Value,
    /// When the target took its last value, in s: settling counts from there.
    pub(super) last_change: f64,
    /// The lengths of the picture, if the page draws the run in motion.
    pub(super) geometry: Option<Geometry>,
}

/// Lengths of the picture in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Geometry {
    pub(super) arm: f64,
    pub(super) object: f64,
}

/// The signals that an animation of the grasp needs.
const POSE: [&str; 3] = ["theta1", "theta2", "y_object"];

/// No rows.
impl Default for Packed {
    fn default() -> Self {
        Self::of(&Table::default(), &[])
    }
}

impl Packed {
    /// Packs the rows of a run of these models, see [`super::rows`].
    #[must_use]
    pub fn of(rows: &Table, models: &[ModelParameters]) -> Self {
        Self { data: data(rows), last_change: last_change(rows), geometry: geometry(rows, models) }
    }
}

fn data(rows: &Table) -> Value {
    let times = rows.times();
    let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
    let shortest = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
    // A thousandth of a step, unless that would be too many of them.
    let quantum = (1e-3 * shortest.fold(last - first, f64::min)).max((last - first) / f64::from(1 << 29));
    let mut packer = Packer::new();
    let mut columns = vec![column("time", Some("s"), packer.add_with(first, quantum, times))];
    let values: Vec<&[f64]> = (0..rows.columns().len()).map(|index| rows.column_at(index)).collect();
    for (index, signal) in rows.columns().iter().enumerate() {
        let unit = signal.unit.as_deref();
        columns.push(match pack::same(&values, index) {
            Some(earlier) => json!({ "name": signal.name, "unit": unit, "same": rows.columns()[earlier].name }),
            None => column(&signal.name, unit, packer.add(values[index])),
        });
    }
    // Long texts are moved, not copied.
    let mut data = json!({ "rows": times.len() });
    data["columns"] = Value::Array(columns);
    data["packed"] = Value::String(packer.finish());
    data
}

fn last_change(rows: &Table) -> f64 {
    let targets = rows.column("lambda2_d").unwrap_or_default();
    let before = targets.iter().rposition(|value| Some(value) != targets.last());
    rows.times().get(before.map_or(0, |before| before + 1)).copied().unwrap_or(0.0)
}

/// Lengths of arms and object: from the plant's parameters, or from the constraint (12), which every row satisfies
/// except for gaps.
fn geometry(rows: &Table, models: &[ModelParameters]) -> Option<Geometry> {
    let [theta, _, object] = POSE.map(|name| rows.column(name));
    let (theta, object) = (theta?, object?);
    rows.column(POSE[1])?;
    let of_model = |model: &ModelParameters| {
        model.real("theta1_0")?; // controllers know lengths, too, which need not be true
        Some(Geometry { arm: model.real("l")?, object: model.real("L")? })
    };
    models
        .iter()
        .find_map(of_model)
        .or_else(|| {
            // The last node of the arm is its tip.
            let tip = rows.column("tip_deflection1").or_else(|| rows.column("deflection1[11]"))?;
            // l θ₁ + L/2 = y_M + w₁(l), minus the gap if the tip does not touch, plus the indentation of a compliant
            // face.
            let of_contact = ["gap1", "indentation1"].map(|name| rows.column(name));
            let right = |row: usize| {
                let [gap, pressed] = of_contact.map(|values| values.map_or(0.0, |values| values[row]));
                object[row] + tip[row] - gap + pressed
            };
            line(theta, &(0..tip.len()).map(right).collect::<Vec<f64>>())
                .map(|(slope, offset)| Geometry { arm: slope, object: 2.0 * offset })
        })
        .filter(|geometry| geometry.arm > 0.0 && geometry.object > 0.0)
}

/// Slope and offset of the straight line through collinear points; `None` if they are not collinear, or all equal.
fn line(x: &[f64], y: &[f64]) -> Option<(f64, f64)> {
    let count = x.len() as f64;
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / count, y.iter().sum::<f64>() / count);
    let moment = |a: &[f64], mean_a: f64, b: &[f64], mean_b: f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b)).sum()
    };
    let (xx, xy) = (moment(x, mean_x, x, mean_x), moment(x, mean_x, y, mean_y));
    let slope = xy / xx;
    let offset = mean_y - slope * mean_x;
    let worst = x.iter().zip(y).map(|(x, y)| (y - slope * x - offset).abs()).fold(0.0, f64::max);
    (slope.is_finite() && worst <= 1e-4 * (slope.abs() + offset.abs())).then_some((slope, offset))
}

fn column(name: &str, unit: Option<&str>, scale: Scale) -> Value {
    json!({ "name": name, "unit": unit, "low": scale.low, "quantum": scale.quantum, "order": scale.order })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi2_cosim::record::{Column, Sink};

    /// The pose of a plant of these lengths that turns by these angles.
    fn turned(arm: f64, object: f64, angles: &[f64]) -> Table {
        let names = ["theta1", "theta2", "y_object", "tip_deflection1"];
        let columns = names.map(|name| Column { name: name.into(), ..Column::default() }).to_vec();
        let mut rows = Table::new(columns);
        for (index, angle) in angles.iter().enumerate() {
            let tip = 1e-3 * (index as f64).sin();
            rows.row(index as f64, &[*angle, 0.1, arm * angle + object / 2.0 - tip, tip]).unwrap();
        }
        rows
    }

    #[test]
    fn lengths_follow_from_the_constraint() {
        let geometry = |rows: &Table| Packed::of(rows, &[]).geometry;
        let found = geometry(&turned(0.3, 0.08, &[0.0, 0.02, 0.05, 0.03])).unwrap();
        assert!((found.arm - 0.3).abs() < 1e-12 && (found.object - 0.08).abs() < 1e-12, "{found:?}");
        assert_eq!(geometry(&turned(0.3, 0.08, &[0.0, 0.0, 0.0])), None, "nothing turns");
        let mut foreign = turned(0.3, 0.08, &[0.0, 0.02, 0.05]);
        foreign.row(3.0, &[0.0, 0.1, 1.0, 0.0]).unwrap();
        assert_eq!(geometry(&foreign), None, "another system");
    }
}

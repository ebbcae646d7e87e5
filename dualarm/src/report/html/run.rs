//! One run as the page shows it, wherever it comes from: a simulation or a file of results.

use charts::pack::{Packer, Scale};
use serde_json::{Value, json};

use crate::report::parameters::ModelParameters;
use fmi2_cosim::record::Table;
use grasp_merit::metrics::Metrics;

/// A run for the page.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Names files that are made of it.
    pub key: String,
    /// The title on the page.
    pub title: String,
    /// The settling time that the paper states, or an empty text.
    pub paper: String,
    /// The rows that the page gets, see [`super::rows`].
    pub rows: Table,
    /// How good it was, if it was a grasp with a target.
    pub metrics: Option<Metrics>,
    /// Notes beside its parameters, in sentences: the command, the settings.
    pub notes: Vec<String>,
    /// Its known models.
    pub models: Vec<ModelParameters>,
}

/// Lengths of the picture in m.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Geometry {
    arm: f64,
    object: f64,
}

/// The signals that an animation of the grasp needs.
const POSE: [&str; 3] = ["theta1", "theta2", "y_object"];

impl Run {
    /// For the page's scripts.
    pub(super) fn data(&self) -> Value {
        let times = self.rows.times();
        let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
        let shortest = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
        // A thousandth of a step, unless that would be too many of them.
        let quantum = (1e-3 * shortest.fold(last - first, f64::min)).max((last - first) / f64::from(1 << 30));
        let time_scale = Scale { low: first, quantum };
        let mut packer = Packer::new();
        packer.add_with(time_scale, times);
        let mut columns = vec![column("time", Some("s"), time_scale)];
        for (index, signal) in self.rows.columns().iter().enumerate() {
            let scale = packer.add(self.rows.column_at(index));
            columns.push(column(&signal.name, signal.unit.as_deref(), scale));
        }
        let geometry = self.geometry().map(|Geometry { arm, object }| json!({ "arm": arm, "object": object }));
        json!({
            "key": self.key,
            "title": self.title,
            "settling": self.metrics.as_ref().and_then(Metrics::settling_2),
            "since": self.last_change(),
            "judged": self.metrics.is_some(),
            "geometry": geometry,
            "data": { "rows": times.len(), "columns": columns, "packed": packer.finish() },
        })
    }

    /// When the target took its last value, in s: settling counts from there.
    fn last_change(&self) -> f64 {
        let times = self.rows.times();
        let targets = self.rows.column("lambda2_d").unwrap_or_default();
        let before = targets.iter().rposition(|value| Some(value) != targets.last());
        times.get(before.map_or(0, |before| before + 1)).copied().unwrap_or(0.0)
    }

    /// Whether the page draws it in motion.
    pub(super) fn is_grasp(&self) -> bool {
        self.geometry().is_some()
    }

    /// Lengths of arms and object: from the plant's parameters, or from the constraint (12), which every row satisfies
    /// except for gaps.
    fn geometry(&self) -> Option<Geometry> {
        let [theta, _, object] = POSE.map(|name| self.rows.column(name));
        let (theta, object) = (theta?, object?);
        self.rows.column(POSE[1])?;
        let of_model = |model: &ModelParameters| {
            model.real("theta1_0")?; // controllers know lengths, too, which need not be true
            Some(Geometry { arm: model.real("l")?, object: model.real("L")? })
        };
        self.models
            .iter()
            .find_map(of_model)
            .or_else(|| {
                // The last node of the arm is its tip.
                let tip = self.rows.column("tip_deflection1").or_else(|| self.rows.column("deflection1[11]"))?;
                // l θ₁ + L/2 = y_M + w₁(l), minus the gap if the tip does not touch, plus the indentation of a compliant
                // face.
                let of_contact = ["gap1", "indentation1"].map(|name| self.rows.column(name));
                let right = |row: usize| {
                    let [gap, pressed] = of_contact.map(|values| values.map_or(0.0, |values| values[row]));
                    object[row] + tip[row] - gap + pressed
                };
                line(theta, &(0..tip.len()).map(right).collect::<Vec<f64>>())
                    .map(|(slope, offset)| Geometry { arm: slope, object: 2.0 * offset })
            })
            .filter(|geometry| geometry.arm > 0.0 && geometry.object > 0.0)
    }
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
    json!({ "name": name, "unit": unit, "low": scale.low, "quantum": scale.quantum })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi2_cosim::record::{Column, Sink};

    /// A run with the pose of a plant of these lengths that turns by these angles.
    fn turned(arm: f64, object: f64, angles: &[f64]) -> Run {
        let names = ["theta1", "theta2", "y_object", "tip_deflection1"];
        let columns = names.map(|name| Column { name: name.into(), ..Column::default() }).to_vec();
        let mut rows = Table::new(columns);
        for (index, angle) in angles.iter().enumerate() {
            let tip = 1e-3 * (index as f64).sin();
            rows.row(index as f64, &[*angle, 0.1, arm * angle + object / 2.0 - tip, tip]).unwrap();
        }
        Run { rows, ..Run::default() }
    }

    #[test]
    fn lengths_follow_from_the_constraint() {
        let geometry = turned(0.3, 0.08, &[0.0, 0.02, 0.05, 0.03]).geometry().unwrap();
        assert!((geometry.arm - 0.3).abs() < 1e-12 && (geometry.object - 0.08).abs() < 1e-12, "{geometry:?}");
        assert_eq!(turned(0.3, 0.08, &[0.0, 0.0, 0.0]).geometry(), None, "nothing turns");
        let mut foreign = turned(0.3, 0.08, &[0.0, 0.02, 0.05]);
        foreign.rows.row(3.0, &[0.0, 0.1, 1.0, 0.0]).unwrap();
        assert_eq!(foreign.geometry(), None, "another system");
    }
}

//! Figures of merit of a run: how fast and how accurately the contact forces settle, and the effort of the actuators.

use serde::Serialize;

use crate::running::{Effort, Force, Running};
use fmi2_cosim::record::Table;

/// The output that distinguishes a grasp from other systems.
pub const CONTACT_FORCE: &str = "contact_force1";

/// The recorded signals the metrics need.
pub const SIGNALS: [&str; 6] = ["contact_force1", "contact_force2", "lambda2_d", "tau1", "tau2", "u"];

/// Share of the run during which a settled signal must have stayed within its band: a signal that has just entered the band
/// may be about to leave it again.
pub const REST: f64 = 0.05;

/// Why there are no metrics.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MetricsObstacle {
    /// Outputs that no FMU has, or more than one.
    #[error("no single FMU has the output {}", .0.iter().map(|name| described(name)).collect::<Vec<_>>().join(" or "))]
    Missing(Vec<&'static str>),
    /// Nothing was recorded.
    #[error("the run has no rows")]
    Empty,
}

impl MetricsObstacle {
    /// Whether it was a grasp, so that the user may miss its metrics.
    #[must_use]
    pub fn is_grasp(&self) -> bool {
        !matches!(self, Self::Missing(names) if names.contains(&CONTACT_FORCE))
    }
}

/// A signal and, if its name alone is not clear, its meaning.
fn described(name: &str) -> String {
    match name {
        "lambda2_d" => "lambda2_d (the force in N that both contact forces shall reach)".into(),
        _ => name.into(),
    }
}

/// Metrics of one contact force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ForceMetrics {
    /// Force it shall reach, in N.
    pub target: f64,
    /// Time in s after which it stays within ±2 % of the target; `None` if it is outside within the last [`REST`] of the
    /// time since the target's last change.
    pub settling_2: Option<f64>,
    /// The same with ±5 %.
    pub settling_5: Option<f64>,
    /// By how much it exceeds the target, in % of the way from its first value to the target.
    pub overshoot: f64,
    /// Mean error over the last twentieth of the run, in N.
    pub steady_error: f64,
}

/// Metrics of one actuator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EffortMetrics {
    /// Largest absolute output.
    pub peak: f64,
    /// Root mean square of the output over the whole run.
    pub rms: f64,
    /// Time in s at the actuator's limits; `None` if it has none.
    pub saturated: Option<f64>,
}

/// All metrics of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Metrics {
    /// Contact forces of arms 1 and 2.
    pub forces: [ForceMetrics; 2],
    /// τ₁ and τ₂ in N·m, u in N.
    pub efforts: [EffortMetrics; 3],
}

/// Smallest and largest output of an actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Smallest output.
    pub low: f64,
    /// Largest output.
    pub high: f64,
}

impl Metrics {
    /// Metrics of a recorded run; `limits` are those of the two motors and of the actuator at the object. If the target
    /// changes during the run, those of the forces count from its last change.
    ///
    /// # Errors
    /// When one of the [`SIGNALS`] was not recorded or there are no rows.
    pub fn of(table: &Table, limits: [Option<Limits>; 3]) -> Result<Self, MetricsObstacle> {
        let missing: Vec<_> = SIGNALS.into_iter().filter(|name| table.column(name).is_none()).collect();
        if !missing.is_empty() {
            return Err(MetricsObstacle::Missing(missing));
        }
        Self::if_recorded(table, limits).ok_or(MetricsObstacle::Empty)
    }

    fn if_recorded(table: &Table, limits: [Option<Limits>; 3]) -> Option<Self> {
        let mut running = Running::new(limits);
        let [force1, force2, target, tau1, tau2, u] = SIGNALS.map(|name| table.column(name));
        running.extend(table.times(), [force1?, force2?, target?, tau1?, tau2?, u?]);
        running.metrics()
    }

    /// The longer one of the two 2 % settling times.
    #[must_use]
    pub fn settling_2(&self) -> Option<f64> {
        Some(self.forces[0].settling_2?.max(self.forces[1].settling_2?))
    }
}

impl ForceMetrics {
    /// Metrics of one force over time.
    ///
    /// # Panics
    /// When there are no samples.
    #[must_use]
    pub fn of(times: &[f64], values: &[f64], target: f64) -> Self {
        let mut force = Force::new(times[0], values[0], target);
        force.extend(&times[1..], &values[1..]);
        force.metrics(target)
    }
}

impl EffortMetrics {
    /// Metrics of one actuator's output over time.
    ///
    /// # Panics
    /// When there are no samples.
    #[must_use]
    pub fn of(times: &[f64], values: &[f64], limits: Option<Limits>) -> Self {
        let mut effort = Effort::new(limits);
        effort.extend(times, values);
        let Some(metrics) = effort.metrics() else { panic!("an actuator's output without samples") };
        metrics
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi2_cosim::record::{Column, Sink};
    use std::f64::consts::PI;

    fn samples(stop: f64, count: u32, signal: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        (0..=count)
            .map(|index| {
                let time = stop * f64::from(index) / f64::from(count);
                (time, signal(time))
            })
            .unzip()
    }

    #[test]
    fn a_first_order_lag_settles_after_its_logarithms() {
        let (times, values) = samples(10.0, 10_000, |t| 0.5 * (1.0 - (-t).exp()));
        let metrics = ForceMetrics::of(&times, &values, 0.5);
        // Chords of 1 ms of an exponential: an error of the order (1 ms)².
        assert!((metrics.settling_2.unwrap() - 50_f64.ln()).abs() < 1e-6);
        assert!((metrics.settling_5.unwrap() - 20_f64.ln()).abs() < 1e-6);
        assert!(metrics.overshoot.abs() < 1e-12);
        // Mean of −0.5·exp(−t) over the last half second.
        assert!((metrics.steady_error + ((-9.5_f64).exp() - (-10_f64).exp())).abs() < 1e-7);
    }

    #[test]
    fn a_second_order_lag_overshoots_as_its_damping_says() {
        let damping: f64 = 0.4;
        let ringing = (1.0 - damping * damping).sqrt();
        let (times, values) = samples(30.0, 30_000, |t| {
            let decay = (-damping * t).exp();
            -2.0 * (1.0 - decay * ((ringing * t).cos() + damping / ringing * (ringing * t).sin()))
        });
        let metrics = ForceMetrics::of(&times, &values, -2.0);
        let exact = 100.0 * (-PI * damping / ringing).exp();
        assert!((metrics.overshoot - exact).abs() < 1e-4, "{} instead of {exact}", metrics.overshoot);
        // The 5 % band is left for the last time downwards or upwards between two extrema.
        let settling = metrics.settling_5.unwrap();
        assert!(settling > PI / ringing && settling < 3.0 * PI / ringing);
    }

    #[test]
    fn after_a_change_of_the_target_everything_counts_from_there() {
        let columns = SIGNALS.iter().map(|name| Column { name: (*name).into(), ..Column::default() }).collect();
        let mut table = Table::new(columns);
        for index in 0..=2000_u32 {
            let t = f64::from(index) * 1e-2;
            let target = if t < 5.0 { 0.5 } else { 0.25 };
            let force = if t < 5.0 { 0.5 } else { 0.25 + 0.25 * (5.0 - t).exp() };
            table
                .row(
                    t,
                    &SIGNALS.map(|name| match name {
                        "lambda2_d" => target,
                        "contact_force1" | "contact_force2" => force,
                        _ => 0.0,
                    }),
                )
                .unwrap();
        }
        let metrics = Metrics::of(&table, [None; 3]).unwrap();
        // exp(−t) is below 2 % after ln 50; chords of 10 ms cost up to (10 ms)²/8 of its curvature over its slope.
        assert!((metrics.settling_2().unwrap() - 50_f64.ln()).abs() < 2e-5);
        assert_eq!((metrics.forces[0].target, metrics.forces[0].overshoot), (0.25, 0.0));
    }

    #[test]
    fn a_target_that_is_not_a_number_is_never_reached() {
        let columns = SIGNALS.iter().map(|name| Column { name: (*name).into(), ..Column::default() }).collect();
        let mut table = Table::new(columns);
        for (t, target) in [(0.0, 0.5), (1.0, 0.5), (2.0, f64::NAN)] {
            table.row(t, &SIGNALS.map(|name| if name == "lambda2_d" { target } else { 0.5 })).unwrap();
        }
        assert_eq!(Metrics::of(&table, [None; 3]).unwrap().settling_2(), None);
    }

    fn settling_time(times: &[f64], values: &[f64], target: f64) -> Option<f64> {
        ForceMetrics::of(times, values, target).settling_2
    }

    #[test]
    fn what_never_settles_has_no_settling_time() {
        let (times, values) = samples(1.0, 100, |t| 0.5 + 0.1 * (40.0 * t).cos());
        assert_eq!(settling_time(&times, &values, 0.5), None);
        assert_eq!(settling_time(&times, &[0.5; 101], 0.5), Some(0.0));
        assert_eq!(settling_time(&times, &[f64::NAN; 101], 0.5), None);
        // Noise leaves the band again and again; that the last few samples are within it is chance.
        let leaves =
            |last: u32| samples(1.0, 100, move |t| if t * 100.0 < f64::from(last) + 0.5 { 0.6 } else { 0.5 }).1;
        for (last, settles) in [(99, false), (96, false), (94, true)] {
            assert_eq!(settling_time(&times, &leaves(last), 0.5).is_some(), settles, "{last}");
        }
    }

    #[test]
    fn effort_of_a_clipped_sine() {
        let limits = Some(Limits { low: -1.0, high: 1.0 });
        let (times, values) = samples(2.0 * PI, 100_000, |t| (2.0 * t.sin()).clamp(-1.0, 1.0));
        let metrics = EffortMetrics::of(&times, &values, limits);
        // At the limits while |sin t| > 1/2: two thirds of the time.
        assert!((metrics.saturated.unwrap() - 4.0 * PI / 3.0).abs() < 1e-3);
        assert!((metrics.peak - 1.0).abs() < 1e-15);
        // 4π/3 at the limits and four times ∫₀^{π/6} (2 sin t)² dt = π/3 − √3/2 between them.
        let energy = 4.0 * PI / 3.0 + 4.0 * (PI / 3.0 - 3_f64.sqrt() / 2.0);
        assert!((metrics.rms - (energy / (2.0 * PI)).sqrt()).abs() < 1e-6);
        assert_eq!(EffortMetrics::of(&times, &values, None).saturated, None);
    }
}

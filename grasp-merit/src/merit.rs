//! Figures of merit of one cell: all of (17), not only the forces.
//!
//! The target (16) is a pose, and (17) demands forces, angles and the object's position there. Forces alone can settle in a
//! few hundredths of a second while angles take seconds. So *settled* means that all five are within 2 % of their travel.
//! The travel is the way from the first value to the target; for forces, which are zero at rest, it is the target.

use serde::Serialize;

use crate::limit::BAND;
use crate::metrics::{EffortMetrics, Limits, REST};
use fmi2_cosim::record::Table;

/// The signals that have to be recorded.
pub const SIGNALS: [&str; 12] = [
    "contact_force1",
    "contact_force2",
    "lambda2_d",
    "theta1",
    "theta2",
    "theta1_d",
    "theta2_d",
    "y_object",
    "y_object_d",
    "tau1",
    "tau2",
    "u",
];

/// Figures of merit of a run. Forces in N, torques in N·m, times in s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Merit {
    /// Time after which forces, angles and position stay within 2 % of their travel; `None` if they never do.
    pub settling: Option<f64>,
    /// The same of both forces alone.
    pub settling_forces: Option<f64>,
    /// Of both angles alone.
    pub settling_angles: Option<f64>,
    /// Of the object's position alone.
    pub settling_position: Option<f64>,
    /// By how much the forces exceed their target, in % of their travel; the larger one.
    pub overshoot: f64,
    /// Absolute mean error over the last twentieth of the run; the larger one of both forces.
    pub steady_error: f64,
    /// Root mean square of the force error over the second half of the run; the larger one.
    pub error_rms: f64,
    /// Largest torque of a hub.
    pub peak_torque: f64,
    /// Largest force of the actuator at the object.
    pub peak_force: f64,
    /// Time at its limits of the actuator that is there longest.
    pub saturated: f64,
    /// Largest tension: by how much a contact force pulls.
    pub tension: f64,
    /// The state of the contacts over time.
    pub grip: Grip,
}

/// The state of the contacts, as seen at communication points. Times in s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Grip {
    /// When both forces first press; `None` if they never do.
    pub held_from: Option<f64>,
    /// For how long after it not both of them do.
    pub lost: f64,
    /// How often that begins.
    pub drops: u32,
    /// Largest contact force in N, without the impulses of rigid impacts.
    pub peak: f64,
}

impl Grip {
    fn of(times: &[f64], forces: [&[f64]; 2]) -> Self {
        let presses = |index: &usize| forces.iter().all(|force| force[*index] > 0.0);
        let peak = forces.iter().flat_map(|force| force.iter()).fold(0.0, |most: f64, force| most.max(*force));
        let Some(first) = (0..times.len()).find(presses) else {
            return Self { held_from: None, lost: 0.0, drops: 0, peak };
        };
        let open = (first + 1..times.len()).filter(|index| !presses(index));
        // An empty sum is −0.
        let lost = open.clone().map(|index| times[index] - times[index - 1]).sum::<f64>() + 0.0;
        let drops = open.filter(|index| presses(&(index - 1))).count();
        Self { held_from: Some(times[first] - times[0]), lost, drops: u32::try_from(drops).unwrap_or(u32::MAX), peak }
    }
}

/// One signal on its way.
struct Track<'a> {
    values: &'a [f64],
    first: f64,
    target: f64,
    /// Half of the band's width.
    band: f64,
}

impl<'a> Track<'a> {
    fn of(table: &'a Table, signal: &str, target: &str) -> Option<Self> {
        let values = table.column(signal)?;
        let (first, target) = (*values.first()?, *table.column(target)?.last()?);
        Some(Self { values, first, target, band: BAND * (target - first).abs() })
    }

    /// A contact force. Its travel is the whole target, because its value at the start is only due to the object's inertia.
    fn of_force(table: &'a Table, signal: &str) -> Option<Self> {
        let track = Self::of(table, signal, "lambda2_d")?;
        Some(Self { band: BAND * track.target.abs(), ..track })
    }

    fn travel(&self) -> f64 {
        self.target - self.first
    }

    /// Time from which on it stays in the band, for [`REST`] of the run at least; `None` if it does not.
    fn settled(&self, times: &[f64]) -> Option<f64> {
        let band = self.band;
        let error = |index: usize| self.values[index] - self.target;
        let is_outside = |index: &usize| error(*index).abs() > band || error(*index).is_nan();
        let Some(last) = (0..self.values.len()).rev().find(is_outside) else { return Some(0.0) };
        let end = times[times.len() - 1];
        if last + 1 == self.values.len() || times[last] > end - REST * (end - times[0]) {
            return None;
        }
        let edge = band.copysign(error(last));
        let share = (error(last) - edge) / (error(last) - error(last + 1));
        Some(times[last] + share * (times[last + 1] - times[last]) - times[0])
    }

    fn overshoot(&self) -> f64 {
        let way = self.travel();
        if way == 0.0 {
            return 0.0;
        }
        let beyond = self.values.iter().map(|value| (value - self.target) * way.signum()).fold(0.0, f64::max);
        100.0 * beyond / way.abs()
    }

    fn mean_error(&self) -> f64 {
        let tail = &self.values[self.values.len() - self.values.len().div_ceil(20)..];
        tail.iter().map(|value| value - self.target).sum::<f64>() / tail.len() as f64
    }

    fn error_rms(&self) -> f64 {
        let tail = &self.values[self.values.len() / 2..];
        (tail.iter().map(|value| (value - self.target).powi(2)).sum::<f64>() / tail.len() as f64).sqrt()
    }
}

/// The later one; `None` if one never comes.
fn later(one: Option<f64>, other: Option<f64>) -> Option<f64> {
    Some(one?.max(other?))
}

/// The larger figure of both forces.
fn larger<'a>(forces: &[Track<'a>; 2], figure: impl Fn(&Track<'a>) -> f64) -> f64 {
    figure(&forces[0]).max(figure(&forces[1]))
}

impl Merit {
    /// Figures of merit of a recorded run; `limits` are those of the two motors and the actuator at the object. `None`
    /// when one of [`SIGNALS`] is missing or there are no rows.
    #[must_use]
    pub fn of(table: &Table, limits: [Option<Limits>; 3]) -> Option<Self> {
        let times = table.times();
        let forces = [Track::of_force(table, "contact_force1")?, Track::of_force(table, "contact_force2")?];
        let angles = [Track::of(table, "theta1", "theta1_d")?, Track::of(table, "theta2", "theta2_d")?];
        let position = Track::of(table, "y_object", "y_object_d")?;
        let effort = |name: &str, limits| Some(EffortMetrics::of(times, table.column(name)?, limits));
        let efforts = [effort("tau1", limits[0])?, effort("tau2", limits[1])?, effort("u", limits[2])?];
        let settling = |tracks: &[Track; 2]| later(tracks[0].settled(times), tracks[1].settled(times));
        let [settling_forces, settling_angles] = [settling(&forces), settling(&angles)];
        let settling_position = position.settled(times);
        Some(Self {
            settling: later(later(settling_forces, settling_angles), settling_position),
            settling_forces,
            settling_angles,
            settling_position,
            overshoot: larger(&forces, Track::overshoot),
            steady_error: larger(&forces, |force| force.mean_error().abs()),
            error_rms: larger(&forces, Track::error_rms),
            peak_torque: efforts[0].peak.max(efforts[1].peak),
            peak_force: efforts[2].peak,
            saturated: efforts.iter().filter_map(|effort| effort.saturated).fold(0.0, f64::max),
            tension: forces.iter().flat_map(|force| force.values).fold(0.0, |most, value| (-value).max(most)),
            grip: Grip::of(times, forces.each_ref().map(|force| force.values)),
        })
    }

    /// The time in s that a search uses: the settling time, or if the run never settles, `stop` times one plus the error in
    /// units of the band, so that a smaller error is still better.
    #[must_use]
    pub fn time_or_worse(&self, stop: f64, target: f64) -> f64 {
        self.settling.unwrap_or_else(|| stop * (1.0 + (self.error_rms / (BAND * target.abs())).min(1e3)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi2_cosim::record::{Column, Sink};

    /// Every signal is a first-order lag to its target with a time constant of its own.
    fn run(constants: [f64; 5], stop: f64) -> Table {
        let columns = SIGNALS.iter().map(|name| Column { name: (*name).into(), ..Column::default() }).collect();
        let mut table = Table::new(columns);
        for t in (0..).map(|index| f64::from(index) * 1e-3).take_while(|t| *t <= stop) {
            let lag = |constant: f64, first: f64, target: f64| target + (first - target) * (-t / constant).exp();
            let row = SIGNALS.map(|name| match name {
                "contact_force1" => lag(constants[0], 0.0, 0.5),
                "contact_force2" => lag(constants[1], 0.0, 0.5),
                "lambda2_d" => 0.5,
                "theta1" => lag(constants[2], 0.0, 0.05),
                "theta2" => lag(constants[3], 0.0, -0.06),
                "theta1_d" => 0.05,
                "theta2_d" => -0.06,
                "y_object" => lag(constants[4], 0.05, 0.049),
                "y_object_d" => 0.049,
                "u" => 0.3,
                _ => -0.5,
            });
            table.row(t, &row).unwrap();
        }
        table
    }

    #[test]
    fn a_grasp_is_held_while_both_forces_press() {
        let times = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let held = Grip::of(&times, [&[0.0, 0.5, 0.5, 0.0, 0.7, 0.5], &[0.1, 0.5, 0.5, 0.5, 0.5, 0.5]]);
        assert_eq!(held, Grip { held_from: Some(1.0), lost: 1.0, drops: 1, peak: 0.7 });
        let never = Grip::of(&times, [&[0.0; 6], &[1.0; 6]]);
        assert_eq!(never, Grip { held_from: None, lost: 0.0, drops: 0, peak: 1.0 });
    }

    #[test]
    fn the_slowest_of_all_five_counts() {
        let limits = [None, None, Some(Limits { low: -0.3, high: 0.3 })];
        let merit = Merit::of(&run([0.1, 0.2, 0.05, 0.3, 0.4], 4.0), limits).unwrap();
        // 2 % of an exponential's travel remain after ln 50 time constants; chords of 1 ms cost less than 1 µs here.
        let exact = 50_f64.ln();
        let close = |value: Option<f64>, constant: f64| (value.unwrap() - exact * constant).abs() < 1e-5;
        assert!(close(merit.settling_forces, 0.2) && close(merit.settling_angles, 0.3));
        assert!(close(merit.settling_position, 0.4) && close(merit.settling, 0.4));
        assert_eq!((merit.peak_torque, merit.peak_force, merit.tension), (0.5, 0.3, 0.0));
        assert!((merit.saturated - 4.0).abs() < 1e-12);
        assert_eq!(merit.overshoot, 0.0);
        // Just in time is too late: 0.6·ln 50 = 2.35 s of 2.4 s.
        assert_eq!(Merit::of(&run([0.6, 0.2, 0.05, 0.3, 0.4], 2.4), limits).unwrap().settling_forces, None);
        // Settled beats not settled; of two that did not settle, the smaller error wins.
        let slow = Merit::of(&run([0.1, 0.2, 0.05, 0.3, 40.0], 4.0), limits).unwrap();
        assert_eq!(slow.settling, None);
        assert!(slow.time_or_worse(4.0, 0.5) > merit.time_or_worse(4.0, 0.5));
    }
}

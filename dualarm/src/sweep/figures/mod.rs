//! Figures of a run: for any system statistics of selected outputs, for a grasp its quality.
//!
//! | figure of an output `y` | |
//! |:--|:--|
//! | `y_last`, `y_min`, `y_max` | its last, smallest and largest value |
//! | `y_mean`, `y_rms` | mean and root mean square over time, straight lines between the steps |
//!
//! Those of a grasp are in [`GRASP`].

use std::io;

use crate::grasp::actuator_limits;
use fmi2_cosim::master::Master;
use fmi2_cosim::record::{Column, Follow, Points, Sink};
use fmi2_cosim::run::Observer;
use fmi2_import::Instance;
use grasp_merit::limit::BAND;
use grasp_merit::merit::Merit;
use grasp_merit::merit::SIGNALS;
use grasp_merit::metrics::Limits;
use grasp_merit::spans::{pulling, quiet};
use grasp_merit::tally::{OF_OUTPUT, Tally};

/// The figures of a grasp: names, units, and descriptions. [`Merit`] defines those that it contains.
pub const GRASP: [(&str, &str, &str); 13] = [
    ("settling", "s", "all of (17): forces, angles and position stay within 2 % of their travel"),
    ("settling_forces", "s", "of both contact forces alone"),
    ("settling_angles", "s", "of both angles alone"),
    ("settling_position", "s", "of the object's position alone"),
    (
        "settling_rms",
        "s",
        "from when on the rms errors of the next 50 ms of all five stay within 2 %, of the tip's way for the position",
    ),
    ("overshoot", "%", "of the forces"),
    ("steady_error", "N", "mean force error at the end"),
    ("error_rms", "N", "rms force error of the second half"),
    ("contact_loss", "s", "how long a contact force pulls with more than 1 % of the target"),
    ("tension", "N", "by how much at most"),
    ("peak_torque", "N.m", "of the hubs"),
    ("peak_force", "N", "of the actuator at the object"),
    ("saturated", "s", "time at its limits of the actuator that is there longest"),
];

/// Share of the target force from which on tension counts as loss of contact.
const PULL: f64 = 0.01;

/// Which figures a system has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wanted {
    /// Whether it is a grasp.
    pub grasp: bool,
    /// The outputs, as columns of rows are called.
    pub outputs: Vec<String>,
}

impl Wanted {
    /// Names of the figures, in the order of [`Gauge::figures`].
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        let grasp = GRASP.iter().filter(|_| self.grasp).map(|(name, _, _)| (*name).to_owned());
        let of_output = |output: &String| OF_OUTPUT.map(|figure| format!("{output}_{figure}"));
        grasp.chain(self.outputs.iter().flat_map(of_output)).collect()
    }

    /// Whether the output of this name, without its component, has to be recorded.
    #[must_use]
    pub fn needs(&self, name: &str) -> bool {
        let is = |output: &String| output.strip_suffix(name).is_some_and(|rest| rest.is_empty() || rest.ends_with('.'));
        (self.grasp && SIGNALS.contains(&name)) || self.outputs.iter().any(is)
    }
}

/// Follows a run and makes its figures.
#[derive(Debug)]
pub struct Gauge<'a> {
    wanted: &'a Wanted,
    grasp: Follow,
    limits: [Option<Limits>; 3],
    /// Length of the arms in m.
    length: Option<f64>,
    places: Vec<usize>,
    tallies: Vec<Tally>,
    /// What is followed, at the places of a row.
    row: Vec<f64>,
}

impl<'a> Gauge<'a> {
    /// For one run.
    #[must_use]
    pub fn new(wanted: &'a Wanted) -> Self {
        let grasp = Follow::new(&[], |_| false);
        Self {
            wanted,
            grasp,
            limits: [None; 3],
            length: None,
            places: Vec::new(),
            tallies: Vec::new(),
            row: Vec::new(),
        }
    }

    /// The figures, in the order of [`Wanted::names`].
    #[must_use]
    pub fn figures(&self) -> Vec<Option<f64>> {
        let mut figures = Vec::new();
        if self.wanted.grasp {
            figures.extend(self.of_grasp().unwrap_or([None; GRASP.len()]));
        }
        for index in 0..self.places.len() {
            figures.extend(self.tallies.get(index).map_or([None; OF_OUTPUT.len()], |tally| tally.figures().map(Some)));
        }
        figures
    }

    fn of_grasp(&self) -> Option<[Option<f64>; GRASP.len()]> {
        let table = self.grasp.table();
        let merit = Merit::of(table, self.limits)?;
        let target = *table.column("lambda2_d")?.last()?;
        let forces = [table.column("contact_force1")?, table.column("contact_force2")?];
        Some([
            merit.settling,
            merit.settling_forces,
            merit.settling_angles,
            merit.settling_position,
            self.settling_rms(target, forces),
            Some(merit.overshoot),
            Some(merit.steady_error),
            Some(merit.error_rms),
            Some(forces.iter().map(|force| pulling(table.times(), force, PULL * target.abs())).fold(0.0, f64::max)),
            Some(merit.tension),
            Some(merit.peak_torque),
            Some(merit.peak_force),
            Some(merit.saturated),
        ])
    }

    fn settling_rms(&self, target: f64, forces: [&[f64]; 2]) -> Option<f64> {
        let table = self.grasp.table();
        let times = table.times();
        let mut latest: f64 = 0.0;
        for force in forces {
            latest = latest.max(quiet(times, force, target, BAND * target.abs())?);
        }
        let mut way: f64 = 0.0;
        for name in ["theta1", "theta2"] {
            let (angle, aim) = (table.column(name)?, *table.column(&format!("{name}_d"))?.last()?);
            let travel = (aim - angle.first()?).abs();
            way = way.max(travel);
            latest = latest.max(quiet(times, angle, aim, BAND * travel)?);
        }
        let (position, aim) = (table.column("y_object")?, *table.column("y_object_d")?.last()?);
        // If both tips meet again half-way, the object's own travel is too small to be a reference.
        let travel = (aim - position.first()?).abs().max(self.length.unwrap_or_default() * way);
        Some(latest.max(quiet(times, position, aim, BAND * travel)?))
    }
}

impl Observer for Gauge<'_> {
    fn begin(&mut self, master: &mut Master, columns: &[Column]) -> Vec<String> {
        let place = |output: &String| columns.iter().position(|column| column.name == *output);
        self.places = self.wanted.outputs.iter().filter_map(place).collect();
        self.row = vec![0.0; columns.len()];
        if self.wanted.grasp {
            self.grasp = Follow::new(columns, |name| SIGNALS.contains(&name));
            for index in 0..master.names().count() {
                let plant = master.instance(index);
                let limits = actuator_limits(plant);
                if limits != [None; 3] || plant.description().variable("contact_force1").is_some() {
                    self.limits = limits;
                    self.length = real(plant, "l");
                    break;
                }
            }
        }
        Vec::new()
    }

    fn follows(&self, column: &Column) -> bool {
        (self.wanted.grasp && SIGNALS.contains(&column.name.as_str())) || self.wanted.outputs.contains(&column.name)
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        if self.wanted.grasp {
            self.grasp.points(points)?;
        }
        for (point, time) in points.times().iter().enumerate() {
            points.put(point, &mut self.row);
            self.take(*time);
        }
        Ok(())
    }

    fn conclude(&mut self) -> Vec<String> {
        Vec::new()
    }
}

fn real(instance: &mut Instance, name: &str) -> Option<f64> {
    let reference = instance.description().variable(name)?.value_reference;
    let mut value = [0.0];
    instance.get_real(&[reference], &mut value).ok()?;
    Some(value[0])
}

impl Gauge<'_> {
    /// Goes on to the next communication point, whose values are in `row`.
    fn take(&mut self, time: f64) {
        let values = &self.row;
        if self.tallies.is_empty() {
            self.tallies = self.places.iter().map(|place| Tally::new(time, values[*place])).collect();
            return;
        }
        for (tally, place) in self.tallies.iter_mut().zip(&self.places) {
            tally.add(time, values[*place]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_order_of_figures() {
        let wanted = Wanted { grasp: false, outputs: vec!["A.y".into()] };
        assert_eq!(wanted.names(), ["A.y_last", "A.y_min", "A.y_max", "A.y_mean", "A.y_rms"]);
        assert!(wanted.needs("y") && !wanted.needs("A") && !wanted.needs("z"));
    }
}

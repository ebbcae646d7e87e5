//! `dualarm linearise`

pub mod law;
mod mat;
mod npz;

use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;
use fmi2_cosim::files::FileSet;
use grasp_certify::sampled::{Reduced, SIGNALS};
use grasp_certify::settings::Settings;
use grasp_plant::Plant;
use grasp_plant::nalgebra::DMatrix;
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::certify::assignment;
use super::{Failure, json, numbers, print};
use crate::grasp::{CONTROLLERS, Controller};

/// What a reader has to know.
const AFTER_HELP: &str = "\
The plant is linear while no actuator is at a limit, so its matrices are the same at every operating point:
  dx/dt = A x + B u,  y = C x + D u,  in deviations from any equilibrium

Inputs are the torques on the hubs and the force on the object, outputs the signals that controllers measure. States are \
energy coordinates and the object's position; hub angles follow from the constraint (12). With --step also Ad, Bd of \
x(t+h) = Ad x(t) + Bd u(t) for inputs held over the step, exact.

A controller (--controller) is a sampled system near an operating point, as its FMU steps:
  x(t+h) = Ad x(t) + Bd y(t),  u(t) = C x(t) + D y(t)

Inputs are the FMU's sixteen, outputs its three commands. The operating point is at rest in the target; --at moves inputs \
away from it. The law is in its initial state there; states that its inputs do not move are in it too. Sensors and \
actuators (GraspInstruments, GraspActuators) delay, round and add noise: they have no such system.

The ending of --out says the format: .mat (MATLAB 5: MATLAB, Octave, scipy), .npz (NumPy), .json.

Examples:
  dualarm linearise --out grasp.mat --step 1e-3 --set M=0.5
  >> load grasp.mat; sys = ss(A, B, C, D)
  dualarm linearise --controller nabfc-r --step 1e-3 --out law.mat
  >> load law.mat; law = ss(Ad, Bd, C, D, h)";

/// Arguments of `dualarm linearise`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// A controller instead of the plant
    #[arg(long, short, value_name = "NAME",
          value_parser = PossibleValuesParser::new(CONTROLLERS.iter().map(|controller| controller.key)))]
    controller: Option<String>,
    /// File to write: .mat, .npz or .json; without it, JSON on standard output
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Sampling time in s for the discrete matrices Ad, Bd [default for controllers: 1e-4]
    #[arg(long, value_name = "SECONDS", value_parser = numbers::seconds, allow_hyphen_values = true)]
    step: Option<f64>,
    /// Polynomial degree of the beams' moments, 4 to 24
    #[arg(long, default_value_t = 8, value_name = "ORDER", value_parser = numbers::order)]
    order: u8,
    /// An input of the controller at the operating point
    #[arg(long = "at", value_name = "NAME=VALUE", value_parser = assignment, requires = "controller")]
    inputs: Vec<(String, f64)>,
    /// Gives a parameter of the plant, or a gain, its value; the built-in uncertainties are those of the paper unless set
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    settings: Vec<(String, f64)>,
}

/// A linear system with names and units. Serialised, matrices are lists of rows.
pub struct Linear {
    matrices: Vec<(&'static str, DMatrix<f64>)>,
    /// Sampling time in s.
    h: Option<f64>,
    names: [(&'static str, Vec<String>); 5],
}

impl Serialize for Linear {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, matrix) in &self.matrices {
            let rows: Vec<Vec<f64>> = matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
            map.serialize_entry(name, &rows)?;
        }
        if let Some(h) = self.h {
            map.serialize_entry("h", &h)?;
        }
        for (name, values) in &self.names {
            map.serialize_entry(name, values)?;
        }
        map.end()
    }
}

/// Units of [`SIGNALS`].
const UNITS: [&str; 14] =
    ["rad", "rad", "rad/s", "rad/s", "m", "m/s", "N.m", "N.m", "N", "N", "N/s", "N/s", "N.m/s", "N.m/s"];

/// Texts that outlive their list.
fn owned(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|text| (*text).to_owned()).collect()
}

impl Linear {
    fn plant(plant: &Plant, step: Option<f64>) -> Self {
        let reduced = Reduced::new(plant);
        let sampled = step.map(|h| reduced.step(h));
        let Reduced { a, b, c } = reduced;
        let energy = a.nrows() - 1;
        let states = (1..=energy).map(|i| format!("x{i}")).chain(["y_object".to_owned()]).collect();
        let d = DMatrix::zeros(c.nrows(), b.ncols());
        let mut matrices = vec![("A", a), ("B", b), ("C", c), ("D", d)];
        if let Some((a, b)) = sampled {
            matrices.extend([("Ad", a), ("Bd", b)]);
        }
        Self {
            matrices,
            h: step,
            names: [
                ("states", states),
                ("inputs", owned(&["tau1", "tau2", "u"])),
                ("input_units", owned(&["N.m", "N.m", "N"])),
                ("outputs", owned(&SIGNALS)),
                ("output_units", owned(&UNITS)),
            ],
        }
    }

    /// Everything that a file holds as a matrix.
    fn matrices(&self) -> Vec<(&'static str, DMatrix<f64>)> {
        let h = self.h.map(|h| ("h", DMatrix::from_element(1, 1, h)));
        self.matrices.iter().cloned().chain(h).collect()
    }

    fn names(&self) -> Vec<(&'static str, Vec<&str>)> {
        self.names.iter().map(|(name, values)| (*name, values.iter().map(String::as_str).collect())).collect()
    }

    fn size(&self, name: &str) -> usize {
        self.names.iter().find(|(known, _)| *known == name).map_or(0, |(_, values)| values.len())
    }
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    let mut settings = Settings::default();
    let paper = grasp_plant::Parameters::default();
    settings.plant.root_uncertainty = paper.root_uncertainty;
    settings.plant.tip_uncertainty = paper.tip_uncertainty;
    settings.plant.order = usize::from(arguments.order);
    for (name, value) in &arguments.settings {
        settings.set(name, *value).map_err(Failure::usage)?;
    }
    if let Some(step) = arguments.step
        && !(step > 0.0 && step <= grasp_plant::LONGEST_STEP)
    {
        return Err(Failure::usage(format!("--step must be above 0 and at most {} s", grasp_plant::LONGEST_STEP)));
    }
    let system = match arguments.controller.as_deref().and_then(Controller::find) {
        Some(controller) => law::linear(controller, &settings, &arguments.inputs, arguments.step.unwrap_or(1e-4))?,
        None => Linear::plant(&Plant::new(settings.plant).map_err(Failure::usage)?, arguments.step),
    };
    let Some(out) = &arguments.out else { return json::print(&system) };
    let content = match out.extension().and_then(|ending| ending.to_str()) {
        Some("mat") => mat::file(&system.matrices(), &system.names()),
        Some("npz") => npz::file(&system.matrices(), &system.names())?,
        Some("json") => serde_json::to_vec_pretty(&system).map_err(Failure::failed)?,
        _ => return Err(Failure::usage(format!("{} must end in .mat, .npz or .json", out.display()))),
    };
    let written = FileSet::new();
    written.write(out, content)?;
    written.appear()?;
    if !quiet {
        let sizes = ["states", "inputs", "outputs"].map(|name| format!("{} {name}", system.size(name)));
        print(&format!("{}; {}\n", sizes.join(", "), out.display()));
    }
    Ok(())
}

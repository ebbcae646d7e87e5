//! `dualarm linearise`

mod mat;
mod npz;

use std::path::PathBuf;

use clap::Args;
use fmi2_cosim::files::FileSet;
use grasp_certify::sampled::{Reduced, SIGNALS};
use grasp_certify::settings::Settings;
use grasp_plant::Plant;
use grasp_plant::nalgebra::DMatrix;
use serde::Serialize;

use super::certify::assignment;
use super::{Failure, json, print};

/// What a reader has to know.
const AFTER_HELP: &str = "\
The plant is linear while no actuator is at a limit, so its matrices are the same at every operating point:
  dx/dt = A x + B u,  y = C x + D u,  in deviations from any equilibrium;
inputs are the torques on the hubs and the force on the object, outputs the signals that controllers measure.
States are energy coordinates and the object's position; hub angles follow from the constraint (12).
With --step also Ad, Bd of x(t+h) = Ad x(t) + Bd u(t) for inputs held over the step, exact.

The ending of --out says the format: .mat (MATLAB 5: MATLAB, Octave, scipy), .npz (NumPy), .json.
  dualarm linearise --out grasp.mat --step 1e-3 --set M=0.5
  >> load grasp.mat; sys = ss(A, B, C, D)";

/// Arguments of `dualarm linearise`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// File to write: .mat, .npz or .json; without it, JSON on standard output
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Sampling time in s for the discrete matrices Ad, Bd
    #[arg(long, value_name = "SECONDS")]
    step: Option<f64>,
    /// Polynomial degree of the beams' moments, 4 to 24
    #[arg(long, default_value_t = 8)]
    order: usize,
    /// Gives a plant parameter its value; the built-in uncertainties are those of the paper unless set
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    settings: Vec<(String, f64)>,
}

/// A linear system with names and units. Matrices are lists of rows.
#[derive(Serialize)]
struct Linear {
    #[serde(rename = "A", serialize_with = "rows")]
    a: DMatrix<f64>,
    #[serde(rename = "B", serialize_with = "rows")]
    b: DMatrix<f64>,
    #[serde(rename = "C", serialize_with = "rows")]
    c: DMatrix<f64>,
    #[serde(rename = "D", serialize_with = "rows")]
    d: DMatrix<f64>,
    #[serde(flatten)]
    sampled: Option<Sampled>,
    states: Vec<String>,
    inputs: [&'static str; 3],
    input_units: [&'static str; 3],
    outputs: [&'static str; 14],
    output_units: [&'static str; 14],
}

#[derive(Serialize)]
struct Sampled {
    /// Sampling time in s.
    h: f64,
    #[serde(rename = "Ad", serialize_with = "rows")]
    a: DMatrix<f64>,
    #[serde(rename = "Bd", serialize_with = "rows")]
    b: DMatrix<f64>,
}

fn rows<S: serde::Serializer>(matrix: &DMatrix<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(matrix.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>()))
}

/// Units of [`SIGNALS`].
const UNITS: [&str; 14] =
    ["rad", "rad", "rad/s", "rad/s", "m", "m/s", "N.m", "N.m", "N", "N", "N/s", "N/s", "N.m/s", "N.m/s"];

impl Linear {
    fn new(plant: &Plant, step: Option<f64>) -> Self {
        let reduced = Reduced::new(plant);
        let sampled = step.map(|h| {
            let (a, b) = reduced.step(h);
            Sampled { h, a, b }
        });
        let Reduced { a, b, c } = reduced;
        let energy = a.nrows() - 1;
        let states = (1..=energy).map(|i| format!("x{i}")).chain(["y_object".to_owned()]).collect();
        let d = DMatrix::zeros(c.nrows(), b.ncols());
        let inputs = ["tau1", "tau2", "u"];
        Self {
            a,
            b,
            c,
            d,
            sampled,
            states,
            inputs,
            input_units: ["N.m", "N.m", "N"],
            outputs: SIGNALS,
            output_units: UNITS,
        }
    }

    fn matrices(&self) -> Vec<(&'static str, DMatrix<f64>)> {
        let mut all = vec![("A", self.a.clone()), ("B", self.b.clone()), ("C", self.c.clone()), ("D", self.d.clone())];
        if let Some(sampled) = &self.sampled {
            all.extend([
                ("Ad", sampled.a.clone()),
                ("Bd", sampled.b.clone()),
                ("h", DMatrix::from_element(1, 1, sampled.h)),
            ]);
        }
        all
    }

    fn names(&self) -> [(&'static str, Vec<&str>); 5] {
        [
            ("states", self.states.iter().map(String::as_str).collect()),
            ("inputs", self.inputs.to_vec()),
            ("input_units", self.input_units.to_vec()),
            ("outputs", self.outputs.to_vec()),
            ("output_units", self.output_units.to_vec()),
        ]
    }
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    let mut settings = Settings::default();
    let paper = grasp_plant::Parameters::default();
    settings.plant.root_uncertainty = paper.root_uncertainty;
    settings.plant.tip_uncertainty = paper.tip_uncertainty;
    settings.plant.order = arguments.order;
    for (name, value) in &arguments.settings {
        settings.set(name, *value).map_err(Failure::usage)?;
    }
    if let Some(step) = arguments.step
        && !(step > 0.0 && step <= grasp_plant::LONGEST_STEP)
    {
        return Err(Failure::usage(format!("--step must be above 0 and at most {} s", grasp_plant::LONGEST_STEP)));
    }
    let plant = Plant::new(settings.plant).map_err(Failure::usage)?;
    let system = Linear::new(&plant, arguments.step);
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
        print(&format!("{} states, 3 inputs, 14 outputs; {}\n", system.states.len(), out.display()));
    }
    Ok(())
}

//! `dualarm certify`

mod map;
mod report;
mod root_strain;

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use grasp_certify::settings::Settings;

use super::{Failure, json, print};
use report::{Corrected, Printed};
use root_strain::RootStrain;

/// What a reader has to know of the modes.
const AFTER_HELP: &str = "\
Modes:
  printed      whether constants exist that satisfy (71), (82)-(88) for the
               gains, by exact elimination
  corrected    what is left of them with the signs put right, and the motion
               that refutes Theorem 3
  root-strain  a decay rate and ultimate bounds for the root-strain law,
               checked in interval arithmetic

Maps (--map):
  steps        longest stable steps, the table of README
  gains        spectral radius over step, delay and gains
  spectrum     exact eigenvalues
  rates        certified, exact and measured decay

Parameters have the names of the FMUs: those of the plant, the gains of NabfcController, r_... for the root-strain law; \
delta_f1, delta_f2, delta_F are bounds of disturbances of any shape, delta_f1_dot, delta_f2_dot, delta_F_dot of the rates \
of those that observers learn. The plant's built-in uncertainties are off unless set.

Examples:
  dualarm certify --preset certified --set root_uncertainty=0.1 \\
    --set tip_uncertainty=0.05
  dualarm certify --set r_strain1=4 --set r_strain2=4 --set delta_F=0.01
  dualarm certify --map gains --out stability.svg

docs/certificates.md has the derivations.";

/// Arguments of `dualarm certify`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// What to prove
    #[arg(long, value_enum, default_value_t = Mode::RootStrain)]
    mode: Mode,
    /// Take the gains of this preset of the neuro-adaptive controller
    #[arg(long, value_name = "NAME", default_value = "parameters",
          value_parser = ["parameters", "fast", "certified"])]
    preset: String,
    /// Gives a parameter, gain or disturbance its value
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    settings: Vec<(String, f64)>,
    /// Map what is stable and how fast it decays, instead of a proof; sampled loops have the plant's uncertainties
    #[arg(long, value_enum, conflicts_with_all = ["mode", "preset"])]
    map: Option<map::Map>,
    /// Controller of the maps steps and gains; repeatable [default: pd, pds, nabfc, nabfc-r]
    #[arg(long, short, value_name = "NAME", requires = "map", value_parser = PossibleValuesParser::new(map::keys()))]
    controller: Vec<String>,
    /// Write the map's figure to this file (.svg)
    #[arg(long, short, value_name = "FILE", requires = "map")]
    out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// What to prove.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Mode {
    Printed,
    Corrected,
    RootStrain,
}

/// NAME=VALUE with a finite number.
pub(super) fn assignment(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("write NAME=VALUE")?;
    let value: f64 = value.parse().map_err(|_| format!("\"{value}\" is no number"))?;
    if !value.is_finite() {
        return Err(format!("\"{value}\" is no finite number"));
    }
    Ok((name.to_owned(), value))
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut settings = Settings::default();
    settings.set_preset(&arguments.preset).map_err(Failure::usage)?;
    if matches!(arguments.map, Some(map::Map::Steps | map::Map::Gains)) {
        let paper = grasp_plant::Parameters::default();
        settings.plant.root_uncertainty = paper.root_uncertainty;
        settings.plant.tip_uncertainty = paper.tip_uncertainty;
    }
    for (name, value) in &arguments.settings {
        settings.set(name, *value).map_err(Failure::usage)?;
    }
    settings.plant.validate().map_err(Failure::usage)?;
    if let Some(map) = arguments.map {
        let (controllers, out) = (&arguments.controller, arguments.out.as_deref());
        return map::run(&map::Request { map, controllers, settings, out, as_json: arguments.json });
    }
    match arguments.mode {
        Mode::Printed => show(&Printed::new(&settings), arguments.json),
        Mode::Corrected => show(&Corrected::new(&settings), arguments.json),
        Mode::RootStrain => show(&RootStrain::new(&settings).map_err(Failure::usage)?, arguments.json),
    }
}

fn show(document: &(impl serde::Serialize + std::fmt::Display), as_json: bool) -> Result<(), Failure> {
    if as_json {
        return json::print(document);
    }
    print(&document.to_string());
    Ok(())
}

//! `dualarm certify`

mod report;

use clap::{Args, ValueEnum};
use grasp_certify::settings::Settings;

use super::{Failure, json, print};
use report::{Corrected, Printed, RootStrain};

/// What a reader has to know of the modes.
const AFTER_HELP: &str = "\
Modes:
  printed      whether constants exist that satisfy (71), (82)-(88) for the gains, by exact elimination
  corrected    what is left of them with the signs put right, and the motion that refutes Theorem 3
  root-strain  a decay rate and ultimate bounds for the root-strain law, checked in interval arithmetic

Parameters have the names of the FMUs: those of the plant, the gains of NabfcController, r_... for the
root-strain law; delta_f1, delta_f2, delta_F are bounds of lasting disturbances. The plant's built-in
uncertainties are off unless set. Example:
  dualarm certify --mode root-strain --set r_strain1=60 --set r_strain2=60 --set delta_F=0.01

docs/certificates.md has the derivations.";

/// Arguments of `dualarm certify`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// What to prove
    #[arg(long, value_enum, default_value_t = Mode::RootStrain)]
    mode: Mode,
    /// Gives a parameter, gain or disturbance its value
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    settings: Vec<(String, f64)>,
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
    for (name, value) in &arguments.settings {
        settings.set(name, *value).map_err(Failure::usage)?;
    }
    settings.plant.validate().map_err(Failure::usage)?;
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

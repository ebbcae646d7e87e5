//! `dualarm certify --map`: figures and tables of what is stable, and how fast.

mod draw;
mod rates;
mod spectra;
mod stability;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use fmi2_cosim::files::{FileSet, has_extension};
use grasp_certify::settings::Settings;
use serde::Serialize;

use crate::cli::{Failure, json, print};
use crate::grasp::{CONTROLLERS, Controller, NABFC, NABFC_R, PD, PDS};

/// What is mapped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Map {
    /// The longest stable steps, with commands at once and one to three steps late
    Steps,
    /// Spectral radius over step, delay and gains
    Gains,
    /// Exact eigenvalues, counted
    Spectrum,
    /// Certified, exact and measured decay
    Rates,
}

/// The input of a map.
pub struct Request<'a> {
    pub map: Map,
    /// Keys of the controllers; empty for those of the paper and NABFC-R.
    pub controllers: &'a [String],
    pub settings: Settings,
    /// The path of the figure.
    pub out: Option<&'a Path>,
    pub as_json: bool,
}

/// A figure and a table.
trait Chart: Serialize + std::fmt::Display {
    /// The figure, if it has one.
    fn svg(&self) -> Option<String>;
}

fn controllers(keys: &[String]) -> Vec<Controller> {
    if keys.is_empty() {
        return vec![PD, PDS, NABFC, NABFC_R];
    }
    keys.iter().filter_map(|key| Controller::find(key)).copied().collect()
}

/// Names that `--controller` takes.
pub fn keys() -> impl Iterator<Item = &'static str> {
    CONTROLLERS.iter().map(|controller| controller.key)
}

pub fn run(request: &Request<'_>) -> Result<(), Failure> {
    let controllers = controllers(request.controllers);
    match request.map {
        Map::Steps => finish(request, &stability::Steps::new(&controllers, &request.settings)?),
        Map::Gains => finish(request, &stability::Gains::new(&controllers, &request.settings)?),
        Map::Spectrum => finish(request, &spectra::Spectra::new(&request.settings)?),
        Map::Rates => finish(request, &rates::Rates::new(&request.settings)?),
    }
}

fn finish(request: &Request<'_>, chart: &impl Chart) -> Result<(), Failure> {
    if let Some(out) = request.out {
        let svg = chart.svg().ok_or_else(|| Failure::usage("--out: this map is a table, it has no figure"))?;
        let out: PathBuf = out.to_owned();
        if !has_extension(&out, "svg") {
            return Err(Failure::usage(format!(
                "--out {}: the figure is an SVG, so its name ends in .svg",
                out.display()
            )));
        }
        let written = FileSet::new();
        written.write(out, svg)?;
        written.appear()?;
    }
    if request.as_json {
        return json::print(chart);
    }
    print(&chart.to_string());
    Ok(())
}

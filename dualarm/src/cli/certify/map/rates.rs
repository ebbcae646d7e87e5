//! Certified, exact and measured decay side by side.

use std::fmt;

use grasp_certify::decay::measured;
use grasp_certify::root_strain::{Port, certify};
use grasp_certify::settings::Settings;
use serde::Serialize;

use super::super::root_strain::abscissa;
use super::Chart;
use crate::cli::Failure;

/// `--map rates`: rates at which amplitudes fall \[1/s\], of NABFC-R.
#[derive(Serialize)]
pub struct Rates {
    command: &'static str,
    map: &'static str,
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    preset: &'static str,
    /// Whether the plant has the uncertainties of Section IV.
    uncertainties: bool,
    /// φ/2 without observers, and with them.
    certified: [Option<f64>; 2],
    /// Slowest exact eigenvalue without observers.
    exact: Option<f64>,
    /// In runs of the law as it is shipped: as good as continuous, 0.1 ms, 1 ms.
    measured: [f64; 3],
}

/// Steps of the runs \[s\].
const STEPS: [f64; 3] = [1e-6, 1e-4, 1e-3];
/// Length of the runs \[s\].
const DURATION: f64 = 2.0;

impl Rates {
    pub fn new(settings: &Settings) -> Result<Self, Failure> {
        let paper = grasp_plant::Parameters::default();
        let mut rows = Vec::new();
        for preset in ["certified", "parameters", "fast"] {
            for uncertainties in [false, true] {
                let mut settings = settings.clone();
                settings.set_preset(preset).map_err(Failure::failed)?;
                (settings.plant.root_uncertainty, settings.plant.tip_uncertainty) =
                    if uncertainties { (paper.root_uncertainty, paper.tip_uncertainty) } else { (0.0, 0.0) };
                let grasp = settings.grasp();
                let Some(ports) = settings.ports() else { continue };
                let bare = ports.map(Port::without_observer);
                let half = |ports| certify(&grasp, ports).map(|certificate| 0.5 * certificate.phi);
                let choices = [("law", "root_strain"), ("preset", preset)];
                let choices = choices.map(|(name, value)| (name.to_owned(), value.to_owned()));
                let mut runs = [0.0; STEPS.len()];
                for (run, h) in runs.iter_mut().zip(STEPS) {
                    *run = measured("NabfcController", &choices, &settings, h, DURATION).map_err(Failure::failed)?;
                }
                rows.push(Row {
                    preset,
                    uncertainties,
                    certified: [half(&bare), half(&ports)],
                    exact: abscissa(&grasp, &bare).0.map(|re| -re),
                    measured: runs,
                });
            }
        }
        Ok(Self { command: "certify", map: "rates", rows })
    }
}

impl fmt::Display for Rates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| format!("{value:.2}"));
        writeln!(f, "Rates in 1/s at which amplitudes fall, NABFC-R (a minus: they grow):")?;
        writeln!(
            f,
            "{:<12}{:>14}{:>11}{:>11}{:>9}{:>12}{:>9}{:>9}",
            "preset", "uncertainties", "certified", "observers", "exact", "measured", "0.1 ms", "1 ms"
        )?;
        for row in &self.rows {
            writeln!(
                f,
                "{:<12}{:>14}{:>11}{:>11}{:>9}{:>12.2}{:>9.2}{:>9.2}",
                row.preset,
                if row.uncertainties { "Section IV" } else { "none" },
                number(row.certified[0]),
                number(row.certified[1]),
                number(row.exact),
                row.measured[0],
                row.measured[1],
                row.measured[2]
            )?;
        }
        writeln!(
            f,
            "certified: without observers, and with them; exact: slowest eigenvalue without observers; measured: runs of the whole law, \
             linear at the target"
        )
    }
}

impl Chart for Rates {
    fn svg(&self) -> Option<String> {
        None
    }
}

//! `--json`: one document on standard output, with the same keys in every version; `docs/tool.md` lists them.

use serde::Serialize;

use super::printable::printable_json;
use super::{Failure, print_result};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::Coupling;
use grasp_merit::metrics::{EffortMetrics, ForceMetrics, Metrics};

/// Prints a document.
pub fn print(document: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(document).map_err(Failure::failed)?;
    print_result(&(printable_json(&text) + "\n"));
    Ok(())
}

/// How something was run.
#[derive(Serialize)]
pub struct ExperimentDocument {
    /// In s.
    pub start: f64,
    /// In s.
    pub stop: f64,
    /// In s.
    pub step: f64,
    /// Number of steps.
    pub steps: u64,
    coupling: Coupling,
    /// In s.
    interval: f64,
}

impl ExperimentDocument {
    pub fn new(grid: &TimeGrid, coupling: Coupling, interval: f64) -> Self {
        Self { start: grid.start(), stop: grid.stop(), step: grid.step(), steps: grid.steps(), coupling, interval }
    }

    /// The same after a run that did so many steps.
    pub fn after(self, steps: u64) -> Self {
        Self { steps, ..self }
    }
}

/// Metrics under the names of their signals.
#[derive(Serialize)]
pub struct MetricsDocument {
    contact_force1: ForceMetrics,
    contact_force2: ForceMetrics,
    tau1: EffortMetrics,
    tau2: EffortMetrics,
    u: EffortMetrics,
}

impl From<&Metrics> for MetricsDocument {
    fn from(metrics: &Metrics) -> Self {
        let [contact_force1, contact_force2] = metrics.forces;
        let [tau1, tau2, u] = metrics.efforts;
        Self { contact_force1, contact_force2, tau1, tau2, u }
    }
}

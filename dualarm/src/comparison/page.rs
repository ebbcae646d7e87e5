//! `report.html` of a comparison.

use super::Setup;
use crate::grasp;
use crate::grasp::instruments;
use crate::grasp::matrix::Matrices;
use crate::report::figures::{Drawn, PaperRun};
use crate::report::html::{Packed, Page, Run, rows};
use fmi2_cosim::grid::TimeGrid;

/// The introduction of the page.
const LEAD: &str = "Two elastic arms squeeze an object between their tips, and no sensor measures the force. Three controllers try \
                    to hold it at its target: watch them, scrub through time, zoom into the first milliseconds.";

/// The page of the paper's runs; `has_files`: beside the other results.
pub(super) fn page<'a>(
    runs: &'a [Run],
    figures: &'a [Drawn],
    grid: &TimeGrid,
    setup: String,
    matrix: Option<&'a Matrices>,
    has_files: bool,
) -> Page<'a> {
    Page {
        title: "Grasping with two flexible arms".into(),
        lead: LEAD.into(),
        runs,
        setup,
        rows: rows::sentence(grid),
        matrix,
        figures,
        files: if has_files { files(matrix) } else { Vec::new() },
        ..Page::default()
    }
}

/// The page of the matrix alone.
#[must_use]
pub fn of_matrix(matrix: &Matrices) -> Page<'_> {
    Page {
        title: "Controllers in many cases".into(),
        lead: "Each controller FMU with the plant in each case: who settles, and when.".into(),
        matrix: Some(matrix),
        ..Page::default()
    }
}

/// A result as the page shows it.
pub(super) fn shown(run: &PaperRun, rows: Packed) -> Run {
    Run {
        key: run.scenario.key.into(),
        title: run.scenario.title.into(),
        paper: run.scenario.paper.into(),
        rows,
        metrics: Some(run.metrics.clone()),
        notes: Vec::new(),
        models: run.models.clone(),
    }
}

/// The files beside the page.
fn files(matrix: Option<&Matrices>) -> Vec<(String, String)> {
    let mut files = vec![("report.md", "the same as Markdown"), ("metrics.csv", "the metrics in all digits")];
    if matrix.is_some() {
        files.extend([("matrix.md", "controllers and cases as a table"), ("matrix.csv", "every cell in all digits")]);
    }
    if matrix.is_some_and(|matrix| matrix.contact.is_some()) {
        files
            .extend([("contact.md", "the same of grasps that can open"), ("contact.csv", "their cells in all digits")]);
    }
    let data = grasp::PAPER.map(|controller| (format!("{}.csv", controller.key), "all outputs of that run".to_owned()));
    files.into_iter().map(|(file, what)| (file.to_owned(), what.to_owned())).chain(data).collect()
}

/// How the runs were made, in sentences.
pub(super) fn setup(setup: &Setup) -> String {
    format!(
        "DualArmPlant.fmu with each of the three controller FMUs, co-simulated by dualarm {} through their FMI 2.0 \
         interface: step {} ms, {} coupling, {} s. Plant, PDS and PD have the parameters of the paper (Section IV); \
         the gains of NABFC are this project\u{2019}s own, for the paper gives none. NABFC is the paper\u{2019}s law (law = paper); the \
         default law of NabfcController, also in DualArmGrasp-NABFC.ssp, is NABFC-R.{}",
        env!("CARGO_PKG_VERSION"),
        setup.grid.step() * 1e3,
        setup.coupling.title(),
        setup.grid.stop(),
        instruments::sentence(&setup.instruments)
    )
}

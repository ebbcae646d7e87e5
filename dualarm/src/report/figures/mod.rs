//! Figures: the paper's Figs. 2 to 18, overlays of the three controllers, and the picture of the README.
//!
//! [`chart`] draws, [`paper`] and [`overlay`] define the figures, [`raster`] converts SVG to PNG, [`pdf`] to PDF.

pub mod chart;
pub mod overlay;
pub mod paper;
pub mod pdf;
pub mod raster;
pub mod text;

use crate::grasp::Controller;
use crate::grasp::metrics::Metrics;
use crate::report::parameters::ModelParameters;
use chart::Figure;
use fmi2_cosim::record::Table;

/// One of the paper's runs, as figures and the report need it.
#[derive(Debug, Clone)]
pub struct PaperRun {
    /// The controller of the run.
    pub scenario: Controller,
    /// The recorded rows.
    pub table: Table,
    /// How good it was.
    pub metrics: Metrics,
    /// Parameters of plant and controller, in this order.
    pub models: Vec<ModelParameters>,
}

/// A figure with the name of its files.
#[derive(Debug, Clone)]
pub struct NamedFigure {
    /// File name without extension.
    pub name: String,
    /// Its caption, in one line.
    pub caption: String,
    /// How to read it: the meaning of lines and shades, in sentences.
    pub note: String,
    /// The figure.
    pub figure: Figure,
}

/// The signals in figures; a run that lacks some of them has fewer figures.
pub const SIGNALS: &[&str] = &[
    "contact_force1",
    "contact_force2",
    "theta1",
    "theta2",
    "theta1_d",
    "theta2_d",
    "lambda2_d",
    "tau1",
    "tau2",
    "u",
    "tau1_cmd",
    "tau2_cmd",
    "u_cmd",
    "m_hat",
    "J1_hat",
    "J2_hat",
    "epsilon_hat",
    "pi1_hat",
    "pi2_hat",
    "W_norm",
    "U1_norm",
    "U2_norm",
];

/// All figures of a comparison, in the order of the report.
#[must_use]
pub fn all(runs: &[PaperRun]) -> Vec<NamedFigure> {
    let mut figures = overlay::figures(runs);
    figures.extend(paper::figures(runs));
    figures
}

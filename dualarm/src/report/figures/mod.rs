//! Figures: the paper's Figs. 2 to 18, overlays of the three controllers, and the picture of the README.
//!
//! The crate [`charts`] draws, [`paper`] and [`overlay`] define the figures.

pub mod overlay;
pub mod paper;

use crate::grasp::Controller;
use crate::report::parameters::ModelParameters;
use charts::chart::{Figure, Signals};
use grasp_merit::metrics::Metrics;

/// One of the paper's runs, as figures and the report need it.
#[derive(Debug, Clone)]
pub struct PaperRun {
    /// The controller of the run.
    pub scenario: Controller,
    /// The recorded signals.
    pub signals: Signals,
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

/// A drawn figure.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// File name without extension.
    pub name: String,
    /// What it shows, in one line.
    pub caption: String,
    /// How to read it, in sentences.
    pub note: String,
    /// The picture.
    pub svg: String,
}

impl NamedFigure {
    /// Draws it.
    #[must_use]
    pub fn draw(self) -> Drawn {
        let Self { name, caption, note, figure } = self;
        Drawn { name, caption, note, svg: figure.to_svg() }
    }
}

/// Makes a figure. The curves of a figure hold every step, so figures are made and drawn one after the other.
pub type Sketch<'a> = Box<dyn Fn() -> NamedFigure + Send + Sync + 'a>;

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

/// Those of them of which figures show the last value only.
pub const TARGETS: &[&str] = &["theta1_d", "theta2_d", "lambda2_d"];

/// All figures of a comparison, in the order of the report.
#[must_use]
pub fn all(runs: &[PaperRun]) -> Vec<Sketch<'_>> {
    let mut figures = overlay::figures(runs);
    figures.extend(paper::figures(runs));
    figures
}

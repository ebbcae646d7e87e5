//! What is to be co-simulated, wherever it was described: on the command line, in a scenario file, in an archive.
//!
//! A [`System`] is the seam between descriptions and the master: whoever reads a description makes one, and
//! [`System::master`] makes it run.

use crate::master::{self, Coupling, Master, MasterError};
use crate::settings::{Setting, SettingError};
use crate::signal::Signal;
use crate::wiring::{Wire, Wiring};
use fmi2_import::{Fmu, Variable};

/// Components, what connects them, what is set, and how to run them.
#[derive(Clone)]
pub struct System {
    /// What it is, in a few words.
    pub title: Option<String>,
    /// The FMUs under unique names, in the order in which they run.
    pub components: Vec<(String, Fmu)>,
    /// How they are connected.
    pub connections: Connections,
    /// Values for parameters and free inputs; the later of two for one variable holds.
    pub settings: Vec<Located<Setting>>,
    /// Free inputs (`name` or `Component.name`) that change over time.
    pub inputs: Vec<Located<(String, Signal)>>,
    /// Remarks of the description's reader, for the user.
    pub remarks: Vec<String>,
    /// How the author suggests to run it.
    pub experiment: RunOptions,
}

/// How components are connected.
#[derive(Debug, Clone, PartialEq)]
pub enum Connections {
    /// Every input to the output of the same name of another component.
    ByName,
    /// These, and no others.
    Explicit(Vec<Wire>),
}

/// A part of a description, and where it stands there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Located<T> {
    /// The part.
    pub item: T,
    /// For messages, such as `grasp.toml:12`; `None` if there is nothing to point at.
    pub place: Option<String>,
}

/// How to run a system. What is `None` is left to the first FMU's default experiment, or the tool.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RunOptions {
    /// Start time in s.
    pub start: Option<f64>,
    /// Stop time in s.
    pub stop: Option<f64>,
    /// Communication step size in s.
    pub step: Option<f64>,
    /// Relative tolerance for FMUs that solve equations numerically; otherwise each has its own.
    pub tolerance: Option<f64>,
    /// How signals are exchanged.
    pub coupling: Option<Coupling>,
    /// Time in s between two recorded rows; 0 for every step.
    pub interval: Option<f64>,
}

/// Whether an FMU can be asked for this relative tolerance.
#[must_use]
pub fn is_tolerance(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

/// Why a system cannot be set up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SystemError {
    /// An FMU refuses to be instantiated, or connections are ambiguous.
    #[error(transparent)]
    Master(#[from] MasterError),
    /// A value cannot be set.
    #[error("{}{source}", .place.as_ref().map(|place| format!("{place}: ")).unwrap_or_default())]
    Setting {
        /// Where it stands.
        place: Option<String>,
        /// What is wrong with it.
        source: Box<SettingError>,
    },
}

impl System {
    /// These FMUs, connected by equal names, under their models' names.
    #[must_use]
    pub fn of_fmus(fmus: &[Fmu]) -> Self {
        Self {
            title: None,
            components: master::named(fmus),
            connections: Connections::ByName,
            settings: Vec::new(),
            inputs: Vec::new(),
            remarks: Vec::new(),
            experiment: RunOptions::default(),
        }
    }

    /// Every variable that is meant by `name` or `Component.name`.
    pub(crate) fn variables(&self, wanted: &str) -> impl Iterator<Item = &Variable> {
        self.components.iter().filter_map(move |(component, fmu)| {
            let description = fmu.description();
            let local = || description.variable(wanted.strip_prefix(component.as_str())?.strip_prefix('.')?);
            description.variable(wanted).or_else(local)
        })
    }

    /// Instantiates and connects the components, sets what is to be set; next comes [`Master::initialize`].
    ///
    /// # Errors
    /// When an FMU refuses, connections are ambiguous, or there is no such variable.
    pub fn master(&self, coupling: Coupling) -> Result<Master, SystemError> {
        let Wiring { wires, remarks } = match &self.connections {
            Connections::ByName => master::wires_by_name(&self.components)?,
            Connections::Explicit(wires) => Wiring { wires: wires.clone(), remarks: Vec::new() },
        };
        let mut master = Master::with_wires(&self.components, wires, coupling)?;
        master.remark(remarks);
        if let Some(tolerance) = self.experiment.tolerance {
            master.set_tolerance(tolerance);
        }
        for Located { item, place } in &self.settings {
            let failure = |source| SystemError::Setting { place: place.clone(), source: Box::new(source) };
            master.apply(item).map_err(failure)?;
        }
        for Located { item: (target, signal), place } in &self.inputs {
            let failure = |source| SystemError::Setting { place: place.clone(), source: Box::new(source) };
            master.drive(target, signal).map_err(failure)?;
        }
        Ok(master)
    }
}

impl<T> Located<T> {
    /// A part without a place to point at.
    pub fn nowhere(item: T) -> Self {
        Self { item, place: None }
    }
}

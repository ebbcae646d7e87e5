//! A system to be co-simulated, whether it is described on the command line, in a scenario file or in an archive.
//!
//! A [`System`] is the interface between descriptions and the master: every reader of a description makes one, and
//! [`System::master`] makes the master that runs it.

use std::fmt;
use std::sync::Arc;

use crate::master::{self, Coupling, Draft, Master, MasterError, drafts};
use crate::settings::{self, Setting, SettingError};
use crate::signal::Signal;
use crate::wiring::{Terminal, Wire, Wiring};
use fmi2_import::{Fmu, Value, Variable};

/// Components, their connections, settings, and the options of a run.
#[derive(Clone)]
pub struct System {
    /// A short title.
    pub title: Option<String>,
    /// A description in sentences, or an empty text.
    pub description: String,
    /// The FMUs under unique names, in the order in which they run.
    pub components: Vec<(String, Fmu)>,
    /// How they are connected.
    pub connections: Connections,
    /// Values for single variables. Every other setting of the same variable takes precedence.
    pub values: Vec<Located<(Terminal, Value)>>,
    /// Values for parameters and free inputs; of two values for one variable the later one applies.
    pub settings: Vec<Located<Setting>>,
    /// Free inputs (`name` or `Component.name`) that change over time.
    pub inputs: Vec<Located<(String, Signal)>>,
    /// Settings of the user, which override all others.
    pub overrides: Vec<Setting>,
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

/// A part of a description, and its place there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Located<T> {
    /// The part.
    pub item: T,
    /// For messages; `None` if there is nothing to point at.
    pub place: Option<SourceLine>,
}

/// A line of a file, such as `grasp.toml:12`. All lines of a file share its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceLine {
    /// The file, as messages name it.
    pub file: Arc<str>,
    /// The line, from 1.
    pub line: usize,
}

impl fmt::Display for SourceLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.file, self.line)
    }
}

/// The options of a run. If one is `None`, it is taken from the first FMU's default experiment, or from the tool's
/// defaults.
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

/// Whether this value can be passed to an FMU as relative tolerance.
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
        /// Its place.
        place: Option<SourceLine>,
        /// The fault.
        source: Box<SettingError>,
    },
}

impl System {
    /// These FMUs, connected by equal names, under their models' names.
    #[must_use]
    pub fn of_fmus(fmus: &[Fmu]) -> Self {
        Self {
            title: None,
            description: String::new(),
            components: master::named(fmus),
            connections: Connections::ByName,
            values: Vec::new(),
            settings: Vec::new(),
            inputs: Vec::new(),
            overrides: Vec::new(),
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

    /// Instantiates and connects the components, and applies the settings; [`Master::initialize`] comes next. Everything in
    /// the descriptions is checked before any code of an FMU runs.
    ///
    /// # Errors
    /// When an FMU refuses, connections are ambiguous, or there is no such variable.
    pub fn master(&self, coupling: Coupling) -> Result<Master, SystemError> {
        let Wiring { wires, remarks } = self.wiring()?;
        self.check_with(&wires)?;
        let mut master = Master::with_wires(&self.components, wires, coupling)?;
        master.remark(remarks);
        if let Some(tolerance) = self.experiment.tolerance {
            master.set_tolerance(tolerance);
        }
        for Located { item: (terminal, value), place } in &self.values {
            master.assign(*terminal, value).map_err(failure(place.as_ref()))?;
        }
        for Located { item, place } in &self.settings {
            master.apply(item).map_err(failure(place.as_ref()))?;
        }
        for Located { item: (target, signal), place } in &self.inputs {
            master.drive(target, signal).map_err(failure(place.as_ref()))?;
        }
        for setting in &self.overrides {
            master.apply(setting).map_err(failure(None))?;
        }
        Ok(master)
    }

    /// Checks, from the descriptions alone, what [`System::master`] checks before any code of an FMU runs.
    ///
    /// # Errors
    /// When connections are ambiguous, or a setting cannot be applied.
    pub fn check(&self) -> Result<(), SystemError> {
        self.check_with(&self.wiring()?.wires)
    }

    fn wiring(&self) -> Result<Wiring, SystemError> {
        Ok(match &self.connections {
            Connections::ByName => master::wires_by_name(&self.components)?,
            Connections::Explicit(wires) => Wiring { wires: wires.clone(), remarks: Vec::new() },
        })
    }

    fn check_with(&self, wires: &[Wire]) -> Result<(), SystemError> {
        let drafts = &drafts(&self.components, wires)[..];
        for Located { item: (Terminal { component, variable }, value), place } in &self.values {
            settings::check_one((*component, *variable), value, drafts).map_err(failure(place.as_ref()))?;
        }
        for Located { item, place } in &self.settings {
            settings::check(item, drafts).map_err(failure(place.as_ref()))?;
        }
        for Located { item: (target, signal), place } in &self.inputs {
            let obstacle = |draft: &Draft, index| settings::obstacle_to_driving(draft, index, signal);
            settings::meant(target, drafts, obstacle).map_err(failure(place.as_ref()))?;
        }
        for setting in &self.overrides {
            settings::check(setting, drafts).map_err(failure(None))?;
        }
        Ok(())
    }
}

/// Makes an error of a setting at this place.
fn failure(place: Option<&SourceLine>) -> impl FnOnce(SettingError) -> SystemError {
    move |source| SystemError::Setting { place: place.cloned(), source: Box::new(source) }
}

impl<T> Located<T> {
    /// A part without a place to point at.
    pub fn nowhere(item: T) -> Self {
        Self { item, place: None }
    }
}

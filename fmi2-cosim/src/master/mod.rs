//! The co-simulation master: steps any set of FMUs together and exchanges their signals.
//!
//! Components are connected by equal names ([`wire_by_name`](crate::wiring::wire_by_name)). There are two ways to exchange
//! signals:
//!
//! * [`Coupling::Jacobi`]: read all outputs, set all inputs, step all components. No component receives another one's new
//!   outputs before the next communication point: the commands of a controller reach the plant one step late.
//! * [`Coupling::GaussSeidel`]: one component after the other receives the newest outputs, steps and publishes its own. A
//!   controller after its plant computes its commands from the plant's outputs at the same instant, without delay.
//!
//! ```no_run
//! use fmi2_import::Fmu;
//! use fmi2_cosim::grid::TimeGrid;
//! use fmi2_cosim::master::{Coupling, Master};
//! use fmi2_cosim::record::Table;
//! use fmi2_cosim::settings::Setting;
//!
//! let fmus = [Fmu::open("dist/DualArmPlant.fmu")?, Fmu::open("dist/PdController.fmu")?];
//! let mut master = Master::new(&fmus, Coupling::GaussSeidel)?;
//! master.apply(&Setting::new("kp", 12.0))?;
//! let grid = TimeGrid::new(0.0, 5.0, 1e-4)?;
//! master.initialize(&grid)?;
//! let mut table = Table::new(master.record(|name| name == "contact_force1"));
//! master.run(&grid, 1e-3, &mut table, &mut |_| ())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod batches;
mod bus;
mod buses;
mod components;
mod coupling;
mod drive;
mod error;
mod followed;
mod recording;
mod run;
mod steps;
mod turns;

use std::collections::HashSet;

use crate::record::{Column, Kind};
use crate::settings::{self, Place, Setting, SettingError};
use crate::signal::Signal;
use crate::wiring::{Terminal, Wire, Wiring};
use buses::Buses;
pub use components::check_steps;
pub(crate) use components::{Draft, drafts, named, wires_by_name};
use components::{Slave, check_instances};
pub use coupling::Coupling;
use drive::Drive;
pub use error::MasterError;
use fmi2_import::{CallError, Causality, Fmu, Instance, LogMessage, ModelDescription, Value, Variable};
use followed::Followed;
use recording::{Recording, column_name};

/// A value that was set.
#[derive(Debug, Clone, Copy)]
pub struct Applied<'a> {
    /// The component.
    pub component: &'a str,
    /// Its model.
    pub model: &'a str,
    /// The variable.
    pub variable: &'a Variable,
    /// The value it got.
    pub value: &'a Value,
}

/// FMUs that run together.
pub struct Master {
    components: Vec<Slave>,
    wires: Vec<Wire>,
    coupling: Coupling,
    buses: Buses,
    drives: Vec<Drive>,
    settings: Vec<(Place, Value)>,
    /// Remarks about the connections, for the user.
    remarks: Vec<String>,
    warnings: Vec<String>,
    /// Relative tolerance for every component, instead of its own.
    tolerance: Option<f64>,
    recording: Recording,
    followed: Option<Followed>,
    /// Steps of the run that are done.
    steps: u64,
    /// Inputs already belong to the current communication point. A second exchange would give a Jacobi coupling the
    /// commands that it must receive one step later.
    exchanged: bool,
    /// Nothing has happened to the components since the last step, in which one came after the other.
    is_current: bool,
}

impl Master {
    /// Instantiates the FMUs under their model's names and connects equal names. The order matters for
    /// [`Coupling::GaussSeidel`].
    ///
    /// # Errors
    /// When an FMU refuses to be instantiated, is given twice although it can be instantiated only once, or equal names do
    /// not determine the connections.
    pub fn new(fmus: &[Fmu], coupling: Coupling) -> Result<Self, MasterError> {
        let named = named(fmus);
        let Wiring { wires, remarks } = wires_by_name(&named)?;
        Ok(Self { remarks, ..Self::with_wires(&named, wires, coupling)? })
    }

    /// Instantiates the FMUs under these names and connects them by `wires`. The order matters for
    /// [`Coupling::GaussSeidel`].
    ///
    /// # Errors
    /// When an FMU refuses to be instantiated, or is given twice although it can be instantiated only once.
    ///
    /// # Panics
    /// When a wire names a component or a variable that does not exist.
    pub fn with_wires(named: &[(String, Fmu)], wires: Vec<Wire>, coupling: Coupling) -> Result<Self, MasterError> {
        check_instances(named)?;
        // All libraries are loaded before the first instance is made: a library that cannot be loaded is reported before
        // any FMU has begun to work.
        for (_, fmu) in named {
            fmu.load().map_err(|source| CallError::Load(Box::new(source)))?;
        }
        let mut components: Vec<Slave> = Vec::with_capacity(named.len());
        for Draft { name, fmu, drivers } in drafts(named, &wires) {
            components.push(Slave { name: name.to_owned(), instance: fmu.instantiate(name)?, drivers });
        }
        let descriptions: Vec<_> = named.iter().map(|(_, fmu)| fmu.description()).collect();
        let buses = Buses::new(&descriptions, &wires);
        Ok(Self {
            components,
            wires,
            coupling,
            buses,
            drives: Vec::new(),
            settings: Vec::new(),
            remarks: Vec::new(),
            warnings: Vec::new(),
            tolerance: None,
            recording: Recording::default(),
            followed: None,
            steps: 0,
            exchanged: false,
            is_current: false,
        })
    }

    /// Names of the components, in their order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.components.iter().map(|component| component.name.as_str())
    }

    /// All connections.
    #[must_use]
    pub fn wires(&self) -> &[Wire] {
        &self.wires
    }

    /// The inputs that follow signals over time.
    pub fn driven(&self) -> impl Iterator<Item = Terminal> {
        self.drives.iter().map(|drive| Terminal { component: drive.component, variable: drive.variable })
    }

    /// One component's instance.
    ///
    /// # Panics
    /// When there are not that many components.
    pub fn instance(&mut self, component: usize) -> &mut Instance {
        self.buses.forget(component);
        self.is_current = false;
        &mut self.components[component].instance
    }

    /// Sets a variable before initialisation. An input that was set to follow a signal keeps this value instead.
    ///
    /// # Errors
    /// When there is no such variable, it must not be set by the user, the value does not fit or the FMU refuses it.
    pub fn apply(&mut self, setting: &Setting) -> Result<(), SettingError> {
        for (place, value) in settings::check(setting, &self.components)? {
            self.set(place, value)?;
        }
        Ok(())
    }

    /// Whether [`Master::apply`] could set it, as far as the descriptions say. No code of an FMU runs.
    ///
    /// # Errors
    /// When there is no such variable, it must not be set by the user, or the value does not fit.
    pub fn check(&self, setting: &Setting) -> Result<(), SettingError> {
        settings::check(setting, &self.components).map(drop)
    }

    /// Sets one variable before initialisation, as [`Master::apply`] does.
    ///
    /// # Errors
    /// When it must not be set by the user, the value does not fit or the FMU refuses it.
    ///
    /// # Panics
    /// When there is no such component or variable.
    pub fn assign(&mut self, Terminal { component, variable }: Terminal, value: &Value) -> Result<(), SettingError> {
        let place = (component, variable);
        let value = settings::check_one(place, value, &self.components)?;
        self.set(place, value)
    }

    fn set(&mut self, place: Place, value: Value) -> Result<(), SettingError> {
        let Slave { name, instance, .. } = &mut self.components[place.0];
        let description = instance.shared_description();
        let variable = &description.variables[place.1];
        if let Err(source) = instance.set(variable, &value) {
            let setting = Setting::new(format!("{name}.{}", variable.name), value);
            return Err(SettingError::Refused { setting, source: Box::new(source) });
        }
        self.drives.retain(|drive| (drive.component, drive.variable) != place);
        self.settings.push((place, value));
        Ok(())
    }

    /// The settings that [`Master::apply`] has made, in their order.
    pub fn settings(&self) -> impl Iterator<Item = Applied<'_>> {
        self.settings.iter().map(|((component, variable), value)| {
            let Slave { name: component, instance, .. } = &self.components[*component];
            let description = instance.description();
            Applied { component, model: &description.model_name, variable: &description.variables[*variable], value }
        })
    }

    /// Makes an input (`name`, in every component where it is free, or `Component.name`) follow a signal over time, from
    /// [`Master::initialize`] on. It has the signal's value at every communication point. Between them it is held. On
    /// a straight line it follows the line instead, if the FMU can interpolate inputs.
    ///
    /// # Errors
    /// When there is no such variable or it is not a free input.
    pub fn drive(&mut self, target: &str, signal: &Signal) -> Result<(), SettingError> {
        for place in settings::meant(target, &self.components, |component, index| {
            settings::obstacle_to_driving(component, index, signal)
        })? {
            self.drives.retain(|drive| (drive.component, drive.variable) != place);
            let description = self.components[place.0].instance.description();
            // A signal that has no values for this variable was refused above.
            let Ok(signal) = signal.of(&description.variables[place.1]) else { continue };
            self.drives.push(Drive::new(place, description, signal));
        }
        Ok(())
    }

    /// Sets this relative tolerance in every component, from [`Master::initialize`] on, instead of that of its
    /// default experiment.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.tolerance = Some(tolerance);
    }

    /// Adds remarks for the user to the warnings of the run.
    pub fn remark(&mut self, remarks: impl IntoIterator<Item = String>) {
        self.remarks.extend(remarks);
    }

    /// How many steps [`Master::run`] has completed.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Warnings of the run for the user; available after [`Master::initialize`], and more of them after
    /// [`Master::run`].
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Chooses what is recorded: the outputs whose names `wanted` accepts. Returns the columns of a row.
    pub fn record(&mut self, wanted: impl Fn(&str) -> bool) -> Vec<Column> {
        let (recording, columns) = Recording::of(&self.described(), wanted);
        self.recording = recording;
        if self.followed.take().is_some() {
            self.fetch_followed();
        }
        columns
    }

    /// Reads these recorded columns at every communication point, however few rows there are, and passes them to
    /// [`Sink::points`](crate::record::Sink::points). [`Master::record`] resets this selection.
    ///
    /// # Panics
    /// When their number is not that of the columns.
    pub fn follow(&mut self, columns: &[bool]) {
        let is_new = self.followed.is_none();
        self.followed = self.recording.followed(columns);
        if !(is_new && self.followed.is_none()) {
            self.fetch_followed();
        }
    }

    /// Fetches what is followed together with what has wires, as far as it is the same when it is needed.
    fn fetch_followed(&mut self) {
        self.is_current = false;
        let is_usual = self.coupling == Coupling::GaussSeidel && self.buses.only_reals().is_some();
        let followed = self.followed.as_mut().filter(|_| is_usual);
        let mut reals = followed.as_ref().and_then(|followed| followed.reals()).unwrap_or_default();
        reals.resize(self.components.len(), Vec::new());
        // A component whose inputs are not set again before the communication point has its values there after its step.
        let is_settled = |index: usize| self.buses.sources(index).iter().all(|source| *source < index);
        let (mut settled, mut others) = (reals.clone(), reals);
        for index in 0..self.components.len() {
            let other = if is_settled(index) { &mut others } else { &mut settled };
            other[index].clear();
        }
        let watched = (0..others.len()).filter(|index| !others[*index].is_empty()).collect();
        let descriptions: Vec<_> = self.components.iter().map(|component| component.instance.description()).collect();
        self.buses.fetch(&descriptions, &self.wires, &settled, others);
        if let Some(followed) = followed {
            followed.take_from(&self.buses, watched);
        }
    }

    /// The messages that the components have logged since the last call: component and message.
    pub fn take_log(&mut self) -> Vec<(String, LogMessage)> {
        let log = self.components.iter_mut().flat_map(|component| {
            let messages = component.instance.take_log().into_iter();
            messages.map(|message| (component.name.clone(), message))
        });
        log.collect()
    }

    /// The string outputs, which rows omit: names, like those of the columns, and present values.
    ///
    /// # Errors
    /// When an FMU refuses.
    pub fn texts(&mut self) -> Result<Vec<(String, String)>, CallError> {
        let mut wanted = Vec::new();
        let mut names = HashSet::new();
        for (index, component) in self.components.iter().enumerate() {
            let description = component.instance.description();
            for variable in description.with_causality(Causality::Output) {
                if Kind::of(variable.base_type()).is_none() {
                    let name = column_name(&self.described(), index, &variable.name);
                    let name = self.recording.free_name(&name, &names);
                    names.insert(name.clone());
                    wanted.push((index, name, variable.value_reference));
                }
            }
        }
        let instances = &mut self.components;
        let read =
            |(index, name, reference): (usize, String, _)| Ok((name, instances[index].instance.get_string(reference)?));
        wanted.into_iter().map(read).collect()
    }

    /// The components with their descriptions.
    fn described(&self) -> Vec<(&str, &ModelDescription)> {
        let components = self.components.iter();
        components.map(|component| (component.name.as_str(), component.instance.description())).collect()
    }

    /// Ends the simulation and returns the log of the components: name and message.
    ///
    /// # Errors
    /// When an FMU refuses to terminate.
    pub fn finish(mut self) -> Result<Vec<(String, LogMessage)>, MasterError> {
        for component in &mut self.components {
            component.instance.terminate()?;
        }
        Ok(self.take_log())
    }
}

//! The co-simulation master: steps any set of FMUs together and exchanges their signals.
//!
//! Components are connected by equal names ([`wire_by_name`]). Two ways to exchange:
//!
//! * [`Coupling::Jacobi`]: read every output, set every input, step everybody. No component sees another one's new
//!   outputs before the next communication point: the commands of a controller reach the plant one step late.
//! * [`Coupling::GaussSeidel`]: one component after the other gets the newest outputs, steps and publishes its own. A
//!   controller after its plant computes its commands from the plant's outputs at the same instant: no delay.
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

use std::collections::{HashMap, HashSet};
use std::io;

use crate::bus::Buses;
use crate::drive::Drive;
use crate::grid::TimeGrid;
use crate::names::free_name;
use crate::record::{Column, Schedule, Sink};
use crate::recording::{Recording, column_name};
use crate::settings::{self, Place, Setting, SettingError};
use crate::signal::Signal;
use crate::system::is_tolerance;
use crate::wiring::{Terminal, Wire, Wiring, WiringError, wire_by_name};
use fmi2_import::description::BaseType;
use fmi2_import::{
    CallError, Causality, Experiment, Fmu, Instance, LogMessage, ModelDescription, Status, Value, Variable,
};

/// How components exchange their signals.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Coupling {
    /// All at once: signals arrive one step late.
    Jacobi,
    /// One after the other: each gets the newest signals.
    #[default]
    GaussSeidel,
}

/// Why a co-simulation stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MasterError {
    /// Equal names do not say what to connect.
    #[error(transparent)]
    Wiring(#[from] WiringError),
    /// A call before the first step failed.
    #[error("{0}")]
    Setup(#[from] CallError),
    /// A call at a communication point failed.
    #[error("at t = {} s: {source}", seconds(*.time))]
    Step {
        /// The communication point in s.
        time: f64,
        /// What the FMU says.
        source: CallError,
    },
    /// A component asks for the end of the simulation.
    #[error("at t = {} s: {component} asks to end the simulation: {source}", seconds(*.time))]
    Ended {
        /// How far it got, in s.
        time: f64,
        /// The component.
        component: String,
        /// What the FMU says.
        source: CallError,
    },
    /// An FMU that one process can have only one instance of is there more than once.
    #[error(
        "{first} and {second} are the same FMU, which says that one process can have only one instance of it \
         (canBeInstantiatedOnlyOncePerProcess); run them in processes of their own"
    )]
    OnlyOnce {
        /// One component.
        first: String,
        /// Another one.
        second: String,
    },
    /// The signals at the start do not settle.
    #[error(
        "the initial values do not settle after {sweeps} exchanges: the components form an algebraic loop that plain \
         iteration does not solve"
    )]
    AlgebraicLoop {
        /// How many exchanges were tried.
        sweeps: usize,
    },
    /// A component cannot do a last step of another size.
    #[error(
        "{component} can only do steps of equal size, but {duration} s is no multiple of the step size {step} s; \
         choose a stop time that is"
    )]
    UnequalSteps {
        /// The component.
        component: String,
        /// Duration of the run in s.
        duration: f64,
        /// Step size in s.
        step: f64,
    },
    /// A recorded value cannot be kept.
    #[error(transparent)]
    Record(io::Error),
}

/// A time without the digits that only rounding puts there.
fn seconds(time: f64) -> String {
    let digits = format!("{time:.9}");
    digits.trim_end_matches('0').trim_end_matches('.').to_owned()
}

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
    components: Vec<Component>,
    wires: Vec<Wire>,
    coupling: Coupling,
    buses: Buses,
    drives: Vec<Drive>,
    settings: Vec<(Place, Value)>,
    /// What whoever connected the components noticed.
    remarks: Vec<String>,
    warnings: Vec<String>,
    /// Relative tolerance for every component, instead of its own.
    tolerance: Option<f64>,
    recording: Recording,
    /// Inputs are already those of the current communication point. Exchanging a second time would give a Jacobi
    /// coupling the commands it must see one step later.
    exchanged: bool,
}

struct Component {
    name: String,
    instance: Instance,
    drivers: HashMap<usize, String>,
}

impl Master {
    /// Exchanges at most this often to find consistent initial values.
    const MAX_SWEEPS: usize = 100;

    /// Instantiates the FMUs under their model's names and connects equal names. The order counts for
    /// [`Coupling::GaussSeidel`].
    ///
    /// # Errors
    /// When an FMU refuses to be instantiated, can be only once and is there twice, or equal names do not say what to
    /// connect.
    pub fn new(fmus: &[Fmu], coupling: Coupling) -> Result<Self, MasterError> {
        let named = named(fmus);
        let Wiring { wires, remarks } = wires_by_name(&named)?;
        Ok(Self { remarks, ..Self::with_wires(&named, wires, coupling)? })
    }

    /// Instantiates the FMUs under these names and connects them as `wires` says. The order counts for
    /// [`Coupling::GaussSeidel`].
    ///
    /// # Errors
    /// When an FMU refuses to be instantiated, or can be only once and is there twice.
    ///
    /// # Panics
    /// When a wire names a component or a variable that is not there.
    pub fn with_wires(named: &[(String, Fmu)], wires: Vec<Wire>, coupling: Coupling) -> Result<Self, MasterError> {
        check_instances(named)?;
        let variable = |terminal: Terminal| &named[terminal.component].1.description().variables[terminal.variable];
        let mut drivers: Vec<HashMap<usize, String>> = vec![HashMap::new(); named.len()];
        for wire in &wires {
            let driver = format!("{}.{}", named[wire.from.component].0, variable(wire.from).name);
            drivers[wire.to.component].insert(wire.to.variable, driver);
        }
        let mut components: Vec<Component> = Vec::with_capacity(named.len());
        for ((name, fmu), drivers) in named.iter().zip(drivers) {
            components.push(Component { name: name.clone(), instance: fmu.instantiate(name)?, drivers });
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
            exchanged: false,
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
        &mut self.components[component].instance
    }

    /// Sets a variable before initialisation. An input that was to follow a signal keeps this value instead.
    ///
    /// # Errors
    /// When there is no such variable, it is not the user's to set, the value does not fit or the FMU refuses it.
    pub fn apply(&mut self, setting: &Setting) -> Result<(), SettingError> {
        let set = settings::apply(setting, &mut self.components)?;
        self.drives.retain(|drive| !set.iter().any(|(place, _)| *place == (drive.component, drive.variable)));
        self.settings.extend(set);
        Ok(())
    }

    /// What [`Master::apply`] has set, in its order.
    pub fn settings(&self) -> impl Iterator<Item = Applied<'_>> {
        self.settings.iter().map(|((component, variable), value)| {
            let Component { name: component, instance, .. } = &self.components[*component];
            let description = instance.description();
            Applied { component, model: &description.model_name, variable: &description.variables[*variable], value }
        })
    }

    /// Lets an input (`name`, in every component where it is free, or `Component.name`) follow a signal over time, from
    /// [`Master::initialize`] on. It has the signal's value at every communication point; between them it is held or, on
    /// a straight line and if the FMU can interpolate inputs, follows the line.
    ///
    /// # Errors
    /// When there is no such variable or it is no free input.
    pub fn drive(&mut self, target: &str, signal: &Signal) -> Result<(), SettingError> {
        for place in settings::meant(target, &self.components, |component, index| {
            settings::obstacle_to_driving(component, index, signal)
        })? {
            self.drives.retain(|drive| (drive.component, drive.variable) != place);
            let description = self.components[place.0].instance.description();
            // What has no values here was an obstacle before.
            let Ok(signal) = signal.of(&description.variables[place.1]) else { continue };
            self.drives.push(Drive::new(place, description, signal));
        }
        Ok(())
    }

    /// Gives every component this relative tolerance, from [`Master::initialize`] on, instead of the one of its own
    /// default experiment.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        self.tolerance = Some(tolerance);
    }

    /// Adds what a user should hear with the warnings of the run.
    pub fn remark(&mut self, remarks: impl IntoIterator<Item = String>) {
        self.remarks.extend(remarks);
    }

    /// What a user should know about the run, apart from errors; known after [`Master::initialize`].
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Initialises all components with consistent signals: they are exchanged in initialisation mode until nothing
    /// changes any more, which also follows chains of direct feedthrough.
    ///
    /// # Errors
    /// When an FMU refuses, or the signals do not settle.
    pub fn initialize(&mut self, grid: &TimeGrid) -> Result<(), MasterError> {
        for component in &self.components {
            let interface = component.instance.description().co_simulation.as_ref();
            if grid.has_shorter_last_step()
                && interface.is_some_and(|interface| !interface.can_handle_variable_communication_step_size)
            {
                return Err(MasterError::UnequalSteps {
                    component: component.name.clone(),
                    duration: grid.stop() - grid.start(),
                    step: grid.step(),
                });
            }
        }
        self.warnings.clone_from(&self.remarks);
        for drive in &mut self.drives {
            let component = &self.components[drive.component];
            let variable = &component.instance.description().variables[drive.variable];
            self.warnings.extend(drive.fit(grid, &format!("{}.{}", component.name, variable.name)));
        }
        for component in &mut self.components {
            let own = component.instance.description().default_experiment.tolerance;
            let tolerance = self.tolerance.or(own).filter(|tolerance| is_tolerance(*tolerance));
            let experiment = Experiment { start: grid.start(), stop: Some(grid.stop()), tolerance };
            component.instance.setup_experiment(experiment)?;
            component.instance.enter_initialization_mode()?;
        }
        for drive in &mut self.drives {
            drive.apply(&mut self.components[drive.component].instance, grid.start(), None)?;
        }
        self.read_all()?;
        let mut sweeps = 0;
        while !self.sweep()? {
            sweeps += 1;
            if sweeps == Self::MAX_SWEEPS {
                return Err(MasterError::AlgebraicLoop { sweeps });
            }
        }
        for component in &mut self.components {
            component.instance.exit_initialization_mode()?;
        }
        self.read_all()?;
        self.exchanged = false;
        Ok(())
    }

    /// Hands every component its inputs and fetches its outputs, one after the other. True when nothing changed.
    fn sweep(&mut self) -> Result<bool, CallError> {
        let before = self.buses.snapshot();
        for (index, component) in self.components.iter_mut().enumerate() {
            self.buses.write(index, &mut component.instance)?;
            self.buses.read(index, &mut component.instance)?;
        }
        Ok(self.buses.agree_with(&before))
    }

    fn read_all(&mut self) -> Result<(), CallError> {
        for (index, component) in self.components.iter_mut().enumerate() {
            self.buses.read(index, &mut component.instance)?;
        }
        Ok(())
    }

    /// Chooses what is recorded: the outputs whose names `wanted` accepts. Returns the columns of a row.
    pub fn record(&mut self, wanted: impl Fn(&str) -> bool) -> Vec<Column> {
        let (recording, columns) = Recording::of(&self.described(), wanted);
        self.recording = recording;
        columns
    }

    /// Steps over the whole grid. Rows go to `sink` at the start, then every `interval` s, and at the end; `progress`
    /// hears from time to time how many steps are done.
    ///
    /// # Errors
    /// When an FMU does not complete a step, or a row cannot be kept. After [`MasterError::Ended`] the rows are whole: the
    /// last one is that of the time at which the FMU ended the simulation.
    pub fn run(
        &mut self,
        grid: &TimeGrid,
        interval: f64,
        sink: &mut dyn Sink,
        progress: &mut dyn FnMut(u64),
    ) -> Result<(), MasterError> {
        const STEPS_PER_REPORT: u64 = 1024;
        let mut schedule = Schedule::new(grid.start(), interval);
        for index in 0..grid.steps() {
            let (time, size) = (grid.time(index), grid.size(index));
            self.apply_drives(time, Some(grid.time(index + 1)))?;
            if schedule.is_due(time) {
                self.put_row(time, sink)?;
            }
            if let Err(error) = self.step(time, size) {
                if let MasterError::Ended { time: end, .. } = &error {
                    self.put_early_end(*end, time, sink)?;
                }
                return Err(error);
            }
            if index % STEPS_PER_REPORT == 0 {
                progress(index);
            }
        }
        self.apply_drives(grid.stop(), None)?;
        self.put_row(grid.stop(), sink)?;
        sink.end(grid.stop(), self.recording.values()).map_err(MasterError::Record)?;
        progress(grid.steps());
        Ok(())
    }

    /// Gives the driven inputs their values at `time`; `next` is the communication point after it. Outputs that follow
    /// them at once are fetched again, so that nobody computes with those of the old inputs.
    fn apply_drives(&mut self, time: f64, next: Option<f64>) -> Result<(), MasterError> {
        let mut apply = || {
            for drive in &mut self.drives {
                let instance = &mut self.components[drive.component].instance;
                if drive.apply(instance, time, next)? {
                    self.buses.read(drive.component, instance)?;
                }
            }
            Ok(())
        };
        apply().map_err(|source| MasterError::Step { time, source })
    }

    fn put_row(&mut self, time: f64, sink: &mut dyn Sink) -> Result<(), MasterError> {
        let failed = |source| MasterError::Step { time, source };
        self.exchange().map_err(failed)?;
        let instances = self.components.iter_mut().map(|component| &mut component.instance);
        let values = self.recording.read(instances).map_err(failed)?;
        sink.row(time, values).map_err(MasterError::Record)
    }

    /// The last row of a simulation that a component ended in the step that began at `begin`. Nothing may be set any more.
    fn put_early_end(&mut self, end: f64, begin: f64, sink: &mut dyn Sink) -> Result<(), MasterError> {
        // A slave that cannot be read after its end leaves the rows there are.
        let instances = self.components.iter_mut().map(|component| &mut component.instance);
        let Ok(values) = self.recording.read(instances) else { return Ok(()) };
        if end > begin {
            sink.row(end, values).map_err(MasterError::Record)?;
        }
        sink.end(end, values).map_err(MasterError::Record)
    }

    /// One communication step of all components, from `time` to `time + size`. Inputs that follow signals keep what they
    /// have: only [`Master::run`] moves them.
    ///
    /// # Errors
    /// When an FMU does not complete it.
    #[inline]
    pub fn step(&mut self, time: f64, size: f64) -> Result<(), MasterError> {
        let result = match self.coupling {
            Coupling::Jacobi => self.step_all(time, size),
            Coupling::GaussSeidel => self.step_in_turn(time, size),
        };
        self.exchanged = false;
        result.map_err(|(index, source)| self.failure(index, time, size, source))
    }

    fn step_all(&mut self, time: f64, size: f64) -> Result<(), (usize, CallError)> {
        self.exchange().map_err(|source| (0, source))?;
        for (index, component) in self.components.iter_mut().enumerate() {
            component.instance.do_step(time, size).map_err(|source| (index, source))?;
        }
        Ok(())
    }

    fn step_in_turn(&mut self, time: f64, size: f64) -> Result<(), (usize, CallError)> {
        for (index, component) in self.components.iter_mut().enumerate() {
            let mut turn = || {
                self.buses.write(index, &mut component.instance)?;
                component.instance.do_step(time, size)?;
                self.buses.read(index, &mut component.instance)
            };
            turn().map_err(|source| (index, source))?;
        }
        Ok(())
    }

    /// Brings every input up to the current communication point.
    fn exchange(&mut self) -> Result<(), CallError> {
        if self.exchanged {
            return Ok(());
        }
        if self.coupling == Coupling::Jacobi {
            self.read_all()?;
        }
        for (index, component) in self.components.iter_mut().enumerate() {
            self.buses.write(index, &mut component.instance)?;
        }
        self.exchanged = true;
        Ok(())
    }

    #[cold]
    fn failure(&mut self, index: usize, time: f64, size: f64, source: CallError) -> MasterError {
        let component = &mut self.components[index];
        if source.status() == Some(Status::Discard) && component.instance.wants_to_end() {
            let reached = component.instance.last_successful_time().filter(|reached| reached.is_finite());
            let time = reached.unwrap_or(time).clamp(time, time + size);
            return MasterError::Ended { time, component: component.name.clone(), source };
        }
        MasterError::Step { time, source }
    }

    /// What the components have logged since this was last asked: name and message.
    pub fn take_log(&mut self) -> Vec<(String, LogMessage)> {
        let log = self.components.iter_mut().flat_map(|component| {
            let messages = component.instance.take_log().into_iter();
            messages.map(|message| (component.name.clone(), message))
        });
        log.collect()
    }

    /// The outputs that are texts, which no row has: names, as those of the columns, and present values.
    ///
    /// # Errors
    /// When an FMU refuses.
    pub fn texts(&mut self) -> Result<Vec<(String, String)>, CallError> {
        let mut wanted = Vec::new();
        for (index, component) in self.components.iter().enumerate() {
            let description = component.instance.description();
            for variable in description.with_causality(Causality::Output) {
                if variable.base_type() == BaseType::String {
                    wanted.push((
                        index,
                        column_name(&self.described(), index, &variable.name),
                        variable.value_reference,
                    ));
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

    /// Ends the simulation and returns what the components logged: name and message.
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

impl settings::Target for Component {
    fn name(&self) -> &str {
        &self.name
    }
    fn instance(&mut self) -> &mut Instance {
        &mut self.instance
    }
    fn description(&self) -> &ModelDescription {
        self.instance.description()
    }
    fn driven_by(&self, variable: usize) -> Option<&str> {
        self.drivers.get(&variable).map(String::as_str)
    }
}

/// An FMU that allows one instance only must not be there twice.
fn check_instances(named: &[(String, Fmu)]) -> Result<(), MasterError> {
    let mut seen: HashMap<(&str, &str), &str> = HashMap::new();
    for (name, fmu) in named {
        let description = fmu.description();
        let Some(interface) = &description.co_simulation else { continue };
        if interface.can_be_instantiated_only_once_per_process
            && let Some(first) = seen.insert((&description.guid, &interface.model_identifier), name)
        {
            return Err(MasterError::OnlyOnce { first: first.to_owned(), second: name.clone() });
        }
    }
    Ok(())
}

/// The FMUs under names that tell them apart: their models', with a number from the second of one name on.
pub(crate) fn named(fmus: &[Fmu]) -> Vec<(String, Fmu)> {
    let models: HashSet<&str> = fmus.iter().map(|fmu| fmu.description().model_name.as_str()).collect();
    let mut taken: HashSet<String> = HashSet::new();
    let mut named = Vec::with_capacity(fmus.len());
    for fmu in fmus {
        let model = &fmu.description().model_name;
        // A model may be called like another one's second instance.
        let name = free_name(model, |name| taken.contains(name) || (name != model && models.contains(name)));
        taken.insert(name.clone());
        named.push((name, fmu.clone()));
    }
    named
}

/// See [`wire_by_name`].
pub(crate) fn wires_by_name(named: &[(String, Fmu)]) -> Result<Wiring, MasterError> {
    let described: Vec<_> = named.iter().map(|(name, fmu)| (name.as_str(), fmu.description())).collect();
    Ok(wire_by_name(&described)?)
}

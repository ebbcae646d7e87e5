//! From the first exchange of signals to the last step.

// As in `bus.rs`.
#![allow(clippy::inline_always)]

use super::{Coupling, Master, MasterError, check_steps};
use crate::grid::TimeGrid;
use crate::record::{Schedule, Sink};
use crate::system::is_tolerance;
use fmi2_import::{CallError, Environment, Experiment, Status};

impl Master {
    /// Exchanges at most this often to find consistent initial values.
    const MAX_SWEEPS: usize = 100;

    /// Initialises all components with consistent signals: they are exchanged in initialisation mode until they no longer
    /// change, which also resolves chains of direct feedthrough.
    ///
    /// # Errors
    /// When an FMU refuses, or the signals do not settle.
    pub fn initialize(&mut self, grid: &TimeGrid) -> Result<(), MasterError> {
        check_steps(self.described(), grid)?;
        self.warnings.clone_from(&self.remarks);
        for drive in &mut self.drives {
            let component = &self.components[drive.component];
            let variable = &component.instance.description().variables[drive.variable];
            self.warnings.extend(drive.fit(grid, &format!("{}.{}", component.name, variable.name)));
        }
        for component in &mut self.components {
            let own = component.instance.description().default_experiment.tolerance;
            let tolerance = self.tolerance.or(own).filter(|tolerance| is_tolerance(*tolerance));
            if let (Some(own), None) = (own, tolerance) {
                let name = &component.name;
                self.warnings.push(format!(
                    "{name}: the tolerance of its default experiment, {own}, is no positive number; it is left to the FMU"
                ));
            }
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

    /// Sets the inputs and fetches the outputs of every component, one after the other. True when nothing changed.
    fn sweep(&mut self) -> Result<bool, CallError> {
        let before = self.buses.snapshot();
        for (index, component) in self.components.iter_mut().enumerate() {
            component.instance.together(|slave| {
                self.buses.write(index, slave)?;
                self.buses.read(index, slave)
            })?;
        }
        Ok(self.buses.agree_with(&before))
    }

    fn read_all(&mut self) -> Result<(), CallError> {
        for (index, component) in self.components.iter_mut().enumerate() {
            component.instance.together(|slave| self.buses.read(index, slave))?;
        }
        Ok(())
    }

    /// Steps over the whole grid. Rows go to `sink` at the start and then every `interval` s, if it [wants](Sink::wants)
    /// them, and at the end; between rows the [followed](Master::follow) columns do. `progress` is called from time to time
    /// with the number of completed steps.
    ///
    /// # Errors
    /// When an FMU does not complete a step, or a row cannot be stored. After [`MasterError::Ended`] the rows are complete:
    /// the last one is for the time at which the FMU ended the simulation.
    pub fn run(
        &mut self,
        grid: &TimeGrid,
        interval: f64,
        sink: &mut dyn Sink,
        progress: &mut dyn FnMut(u64),
    ) -> Result<(), MasterError> {
        const STEPS_PER_REPORT: u64 = 1024;
        self.steps = 0;
        let mut schedule = Schedule::new(grid.start(), interval);
        let mut next = grid.time(0);
        // No other code of this thread changes it.
        let host = Environment::now();
        for index in 0..grid.steps() {
            let time = next;
            next = grid.time(index + 1);
            let size = grid.size(index);
            if !self.drives.is_empty() {
                self.apply_drives(time, Some(next))?;
            }
            if schedule.is_due(time) && sink.wants(time) {
                self.put_row(time, sink)?;
            } else if self.recording.has_followed() {
                self.put_followed(host, time, sink)?;
            }
            if let Err(error) = self.step_in(host, time, size) {
                if let MasterError::Ended { time: end, .. } = &error {
                    self.put_early_end(*end, time, sink)?;
                }
                return Err(error);
            }
            self.steps = index + 1;
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

    /// Sets the driven inputs to their values at `time`; `next` is the following communication point. Outputs that depend
    /// directly on them are fetched again, so that no component computes with outputs of the old inputs.
    fn apply_drives(&mut self, time: f64, next: Option<f64>) -> Result<(), MasterError> {
        let mut apply = || {
            for drive in &mut self.drives {
                let instance = &mut self.components[drive.component].instance;
                if drive.apply(instance, time, next)? {
                    instance.together(|slave| self.buses.read(drive.component, slave))?;
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

    #[inline(always)]
    fn put_followed(&mut self, host: Environment, time: f64, sink: &mut dyn Sink) -> Result<(), MasterError> {
        let mut follow = || {
            if !self.exchanged && self.coupling == Coupling::Jacobi {
                self.read_all()?;
            }
            let Self { components, buses, recording, exchanged, .. } = self;
            for (index, component) in components.iter_mut().enumerate() {
                component.instance.together_in(host, |slave| {
                    if !*exchanged {
                        buses.refresh(index, slave)?;
                    }
                    recording.read_followed(index, slave, |row| buses.take(index, row))
                })?;
            }
            *exchanged = true;
            Ok(())
        };
        follow().map_err(|source| MasterError::Step { time, source })?;
        sink.between(time, self.recording.values()).map_err(MasterError::Record)
    }

    /// The last row of a simulation that a component ended in the step that began at `begin`. No input may be set any more.
    fn put_early_end(&mut self, end: f64, begin: f64, sink: &mut dyn Sink) -> Result<(), MasterError> {
        // A slave that cannot be read after its end leaves the rows there are.
        let instances = self.components.iter_mut().map(|component| &mut component.instance);
        let Ok(values) = self.recording.read(instances) else { return Ok(()) };
        if end > begin {
            sink.row(end, values).map_err(MasterError::Record)?;
        }
        sink.end(end, values).map_err(MasterError::Record)
    }

    /// One communication step of all components, from `time` to `time + size`. Inputs that follow signals keep their
    /// values: only [`Master::run`] changes them.
    ///
    /// # Errors
    /// When an FMU does not complete it.
    #[inline]
    pub fn step(&mut self, time: f64, size: f64) -> Result<(), MasterError> {
        self.step_in(Environment::now(), time, size)
    }

    #[inline]
    fn step_in(&mut self, host: Environment, time: f64, size: f64) -> Result<(), MasterError> {
        let result = match self.coupling {
            Coupling::Jacobi => self.step_all(time, size),
            Coupling::GaussSeidel => self.step_in_turn(host, time, size),
        };
        self.exchanged = false;
        result.map_err(|(index, source)| self.failure(index, time, size, source))
    }

    fn step_all(&mut self, time: f64, size: f64) -> Result<(), (usize, CallError)> {
        self.exchange().map_err(|source| (0, source))?;
        for (index, component) in self.components.iter_mut().enumerate() {
            component.instance.do_step(time, size).map_err(|source| (index, source))?;
            self.buses.moved(index);
        }
        Ok(())
    }

    #[inline(always)]
    fn step_in_turn(&mut self, host: Environment, time: f64, size: f64) -> Result<(), (usize, CallError)> {
        for (index, component) in self.components.iter_mut().enumerate() {
            let turn = component.instance.together_in(host, |slave| {
                // Nobody has stepped yet: the first one has its inputs where a row was taken.
                if index == 0 && self.exchanged {
                    self.buses.refresh(index, slave)?;
                } else {
                    self.buses.write(index, slave)?;
                }
                slave.do_step(time, size)?;
                self.buses.read(index, slave)
            });
            turn.map_err(|source| (index, source))?;
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
            component.instance.together(|slave| self.buses.refresh(index, slave))?;
        }
        self.exchanged = true;
        Ok(())
    }

    #[cold]
    fn failure(&mut self, index: usize, time: f64, size: f64, source: CallError) -> MasterError {
        let component = &mut self.components[index];
        if source.status() == Some(Status::Discard) && component.instance.wants_to_end() {
            // Up to rounding of times.
            let slack = 1e-6 * size;
            let is_possible = |reached: &f64| (time - slack..=time + size + slack).contains(reached);
            let said = component.instance.last_successful_time();
            let reached = said.filter(is_possible).unwrap_or(time).clamp(time, time + size);
            if let Some(said) = said.filter(|said| !is_possible(said)) {
                self.warnings.push(format!(
                    "{} says that it got to t = {said} s in the step from {time} s to {} s: that cannot be, and the values \
                     count for {time} s",
                    component.name,
                    time + size
                ));
            }
            return MasterError::Ended { time: reached, component: component.name.clone(), source };
        }
        MasterError::Step { time, source }
    }
}

//! The first exchange of signals, and steps.

use super::turns::{self, Obstacle};
use super::{Coupling, Master, MasterError, check_steps};
use crate::grid::TimeGrid;
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
        (self.exchanged, self.is_current) = (false, false);
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

    pub(super) fn read_all(&mut self) -> Result<(), CallError> {
        for (index, component) in self.components.iter_mut().enumerate() {
            component.instance.together(|slave| self.buses.read(index, slave))?;
        }
        Ok(())
    }

    /// One communication step of all components, from `time` to `time + size`. Inputs that follow signals keep their
    /// values: only [`Master::run`] changes them.
    ///
    /// # Errors
    /// When an FMU does not complete it.
    #[inline]
    pub fn step(&mut self, time: f64, size: f64) -> Result<(), MasterError> {
        self.step_in(Environment::now(), time, size).map_err(|error| *error)
    }

    #[inline]
    pub(super) fn step_in(&mut self, host: Environment, time: f64, size: f64) -> Result<(), Box<MasterError>> {
        let result = match self.coupling {
            Coupling::Jacobi => self.step_all(time, size),
            Coupling::GaussSeidel => self.step_in_turn(host, time, size),
        };
        self.exchanged = false;
        result.map_err(|(index, source)| Box::new(self.failure(index, time, size, *source)))
    }

    fn step_all(&mut self, time: f64, size: f64) -> Result<(), Obstacle> {
        self.exchange().map_err(|source| (0, Box::new(source)))?;
        for (index, component) in self.components.iter_mut().enumerate() {
            component.instance.do_step(time, size).map_err(|source| (index, Box::new(source)))?;
        }
        Ok(())
    }

    #[inline]
    fn step_in_turn(&mut self, host: Environment, time: f64, size: f64) -> Result<(), Obstacle> {
        self.is_current = false;
        // Nobody has stepped yet: the first one has its inputs where a row was taken.
        if self.exchanged {
            self.refresh_first().map_err(|source| (0, Box::new(source)))?;
        }
        if let Some(reals) = self.buses.only_reals() {
            turns::step(&mut self.components, reals, host, (time, size), self.exchanged)?;
            self.buses.have_stepped();
        } else {
            self.step_mixed(host, time, size)?;
        }
        self.is_current = true;
        Ok(())
    }

    fn refresh_first(&mut self) -> Result<(), CallError> {
        let Some(first) = self.components.first_mut() else { return Ok(()) };
        first.instance.together(|slave| self.buses.refresh(0, slave))
    }

    /// The same as [`turns::step`] where wires carry integers or Booleans, too.
    fn step_mixed(&mut self, host: Environment, time: f64, size: f64) -> Result<(), Obstacle> {
        for (index, component) in self.components.iter_mut().enumerate() {
            let turn = component.instance.together_in(host, |slave| {
                if index > 0 || !self.exchanged {
                    self.buses.write(index, slave)?;
                }
                slave.do_step(time, size)?;
                self.buses.read(index, slave)
            });
            turn.map_err(|source| (index, Box::new(source)))?;
        }
        Ok(())
    }

    /// Brings every input up to the current communication point.
    pub(super) fn exchange(&mut self) -> Result<(), CallError> {
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
    pub(super) fn failure(&mut self, index: usize, time: f64, size: f64, source: CallError) -> MasterError {
        // Who goes on nevertheless sets all inputs again.
        (0..self.components.len()).for_each(|component| self.buses.forget(component));
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

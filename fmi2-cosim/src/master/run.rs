//! A whole run: rows, what is followed, inputs that follow signals, and steps.

use super::turns;
use super::{Coupling, Master, MasterError};
use crate::grid::TimeGrid;
use crate::record::{Schedule, Sink};
use fmi2_import::Environment;

impl Master {
    /// Steps over the whole grid. Rows go to `sink` at the start and then every `interval` s, if it [wants](Sink::wants)
    /// them, and at the end; the [followed](Master::follow) columns do from time to time, some points at once. `progress` is called
    /// from time to time with the number of completed steps.
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
        if let Some(followed) = &mut self.followed {
            followed.begin();
        }
        let result = self.step_over(grid, interval, sink, progress);
        self.pass_on(sink)?;
        result
    }

    fn step_over(
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
        let mut idle = f64::NEG_INFINITY;
        // No other code of this thread changes it.
        let host = Environment::now();
        for index in 0..grid.steps() {
            let time = next;
            next = grid.time(index + 1);
            let size = grid.size(index);
            if !self.drives.is_empty() {
                self.apply_drives(time, Some(next))?;
            }
            let is_row = schedule.is_due(time) && time >= idle && sink.wants(time);
            if is_row {
                self.put_row(time, sink)?;
            }
            if time >= idle {
                idle = sink.idle();
            }
            let usual = if is_row { None } else { self.go_on(host, time, size, sink) };
            let made = if let Some(result) = usual {
                result
            } else {
                if !is_row && self.followed.is_some() {
                    self.put_followed(time, sink)?;
                }
                self.step_in(host, time, size)
            };
            if let Err(error) = made {
                if let MasterError::Ended { time: end, .. } = *error {
                    self.put_early_end(end, time, sink)?;
                }
                return Err(*error);
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
                    self.is_current = false;
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
        self.recording.read(instances).map_err(failed)?;
        self.pass_row(time, sink)
    }

    /// Passes on the row that was read last.
    fn pass_row(&mut self, time: f64, sink: &mut dyn Sink) -> Result<(), MasterError> {
        let values = self.recording.values();
        if self.followed.as_mut().is_some_and(|followed| followed.take_row(time, values)) {
            self.pass_on(sink)?;
        }
        sink.row(time, self.recording.values()).map_err(MasterError::Record)
    }

    /// Passes on the points that are not passed on yet.
    #[inline(never)]
    fn pass_on(&mut self, sink: &mut dyn Sink) -> Result<(), MasterError> {
        self.followed.as_mut().map_or(Ok(()), |followed| followed.pass_on(sink)).map_err(MasterError::Record)
    }

    /// Takes what is followed from the signals, and makes a step, if the one before was made one component after the other and nothing
    /// has happened since. What is known of the signals' age is as after that step, and remains so.
    fn go_on(
        &mut self,
        host: Environment,
        time: f64,
        size: f64,
        sink: &mut dyn Sink,
    ) -> Option<Result<(), Box<MasterError>>> {
        let Self { components, buses, followed: Some(followed), is_current, exchanged: false, .. } = self else {
            return None;
        };
        if !*is_current {
            return None;
        }
        let (signals, ports) = buses.only_reals()?;
        let watched = followed.watched()?;
        *is_current = false;
        // Their inputs are older than the outputs from which they come: one of these comes from a later component, or from itself.
        let has_first_inputs = watched.first() == Some(&0);
        if let Err((_, source)) = turns::watch(components, (&mut *signals, ports), host, watched) {
            return Some(Err(Box::new(MasterError::Step { time, source: *source })));
        }
        if followed.take(time, signals)
            && let Err(error) = followed.pass_on(sink)
        {
            return Some(Err(Box::new(MasterError::Record(error))));
        }
        let result = turns::step(components, (signals, ports), host, (time, size), has_first_inputs);
        *is_current = result.is_ok();
        Some(result.map_err(|(index, source)| Box::new(self.failure(index, time, size, *source))))
    }

    /// Reads what is followed in any situation.
    fn put_followed(&mut self, time: f64, sink: &mut dyn Sink) -> Result<(), MasterError> {
        let mut follow = || {
            if !self.exchanged && self.coupling == Coupling::Jacobi {
                self.read_all()?;
            }
            let Self { components, buses, recording, followed, exchanged, .. } = self;
            for (index, component) in components.iter_mut().enumerate() {
                component.instance.together(|slave| {
                    if !*exchanged {
                        buses.refresh(index, slave)?;
                    }
                    followed.as_mut().map_or(Ok(()), |followed| followed.read(index, slave, recording.values_mut()))
                })?;
            }
            *exchanged = true;
            Ok(())
        };
        follow().map_err(|source| MasterError::Step { time, source })?;
        let values = self.recording.values();
        if self.followed.as_mut().is_some_and(|followed| followed.take_row(time, values)) {
            return self.pass_on(sink);
        }
        Ok(())
    }

    /// The last row of a simulation that a component ended in the step that began at `begin`. No input may be set any more.
    fn put_early_end(&mut self, end: f64, begin: f64, sink: &mut dyn Sink) -> Result<(), MasterError> {
        // A slave that cannot be read after its end leaves the rows there are.
        let instances = self.components.iter_mut().map(|component| &mut component.instance);
        if self.recording.read(instances).is_err() {
            return Ok(());
        }
        if end > begin {
            self.pass_row(end, sink)?;
        }
        sink.end(end, self.recording.values()).map_err(MasterError::Record)
    }
}

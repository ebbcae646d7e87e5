//! The communication step.

use std::fmt;

use super::{Slave, all, out_of_range};
use crate::model::{Failure, Model, Step};
use crate::phase::{Call, Phase};
use crate::status::{Outcome, Refusal};

pub(crate) trait Advance {
    /// Makes a step. What the model says of it meanwhile goes to `warn` and does not change how the call went: the step was
    /// done, and hosts stop at any status but OK.
    fn do_step(&mut self, time: f64, size: f64, warn: &mut dyn FnMut(fmt::Arguments<'_>)) -> Outcome;
    fn last_successful_time(&self) -> f64;
}

impl<M: Model> Advance for Slave<M> {
    fn do_step(&mut self, time: f64, size: f64, warn: &mut dyn FnMut(fmt::Arguments<'_>)) -> Outcome {
        self.check(Call::DoStep, "fmi2DoStep")?;
        self.check_step(time, size)?;
        if self.state.ramped {
            self.check_ramps(size)?;
        }
        let tolerance = self.state.experiment.as_ref().and_then(|experiment| experiment.tolerance);
        let mut step = Step { time, size, warn, layout: Some(&*self.layout), tolerance };
        let result = self.state.model.step(&mut step);
        self.state.stale = all();
        match result {
            Ok(()) => {
                self.state.time = time + size;
                if self.state.ramped {
                    self.finish_ramps(size);
                }
                Ok(())
            }
            // Only a step can be discarded.
            Err(Failure::Discard(message)) => {
                self.state.phase = Phase::StepFailed;
                Err(Refusal::discard(message))
            }
            Err(failure) => {
                self.state.phase = Phase::Error;
                Err(Refusal::of(&failure))
            }
        }
    }

    fn last_successful_time(&self) -> f64 {
        self.state.time
    }
}

/// How much a host's clock may be off ours when a step of this size begins or ends (s).
///
/// Hosts compute communication points as start + i·h, by adding up h (a million additions of 0.1 ms end 2 ns late, 10⁸ of 1 µs
/// 0.2 µs early), in whole microseconds, or in single precision. All that is rounding; being out by half a step is a mistake
/// with every clock.
fn rounding(time: f64, size: f64) -> f64 {
    const MICROSECOND: f64 = 1e-6;
    let clocks = MICROSECOND + f64::from(f32::EPSILON) * time.abs();
    clocks.min(0.25 * size) + 16.0 * f64::EPSILON * time.abs()
}

impl<M: Model> Slave<M> {
    /// Checks a step's start and size against the clock.
    fn check_step(&self, time: f64, size: f64) -> Result<(), Refusal> {
        if !(size.is_finite() && size > 0.0) {
            return Err(Refusal::error(format!("communicationStepSize is {size:?}, it must be positive and finite")));
        }
        if !time.is_finite() {
            return Err(Refusal::error(format!("currentCommunicationPoint is {time:?}, it must be finite")));
        }
        let now = self.state.time;
        // Most hosts tell our own time: no need to know then what rounding would be.
        if time != now && (time - now).abs() > rounding(now, size) {
            return Err(Refusal::error(format!(
                "currentCommunicationPoint is {time:?}, but the last step ended at {now:?}; \
                 fmi2SetFMUstate leads back to an earlier time"
            )));
        }
        let end = time + size;
        if end <= time {
            return Err(Refusal::error(format!(
                "communicationStepSize {size:?} is too small to change the time {time:?}"
            )));
        }
        if !end.is_finite() {
            return Err(Refusal::error(format!(
                "communicationStepSize {size:?} is too large: the step from {time:?} has no finite end"
            )));
        }
        if let Some(stop) = self.state.experiment.and_then(|e| e.stop_time)
            && end > stop
            && end > stop + rounding(stop, size)
        {
            return Err(Refusal::error(format!("the step ends at {end:?}, past the stop time {stop:?}")));
        }
        Ok(())
    }

    /// Checks that no input leaves its range on its ramp.
    fn check_ramps(&mut self, size: f64) -> Result<(), Refusal> {
        for reference in &self.layout.ramps {
            let real = &self.layout.reals[*reference as usize];
            let Some(ramp) = &real.ramp else { continue };
            let slope = *ramp(&mut self.state.model);
            let end = *(real.lens)(&mut self.state.model) + slope * size;
            if !real.accepts(end) {
                let refusal = out_of_range(self.name(&real.slot), end, real.min, real.max);
                let end = format!("; it would be at the end of this step, rising by {slope:?} per second");
                return Err(Refusal::error(refusal.message + &end));
            }
        }
        Ok(())
    }

    /// The inputs' ramps have been used: the inputs stand at their ends.
    fn finish_ramps(&mut self, size: f64) {
        for reference in &self.layout.ramps {
            let real = &self.layout.reals[*reference as usize];
            if let Some(ramp) = &real.ramp {
                let slope = std::mem::take(ramp(&mut self.state.model));
                // Adding zero would turn −0 into +0.
                if slope != 0.0 {
                    *(real.lens)(&mut self.state.model) += slope * size;
                }
            }
        }
        self.state.ramped = false;
    }
}

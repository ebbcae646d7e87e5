//! The communication step.

use std::fmt;

use super::{Slave, all, out_of_range};
use crate::model::{Failure, Step};
use crate::phase::{Call, Phase};
use crate::status::{Outcome, Refusal};

impl Slave {
    /// Whether an instance that is [ready](Self::is_ready) can make this step at once: it begins at the time that it has itself, as most hosts
    /// tell it, but for their last bits.
    #[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
    #[inline(always)]
    pub fn is_usual_step(&self, time: f64, size: f64) -> bool {
        let (now, end) = (self.frame.time, time + size);
        // Our own time is finite, so this one is, too; and a size that is NaN or not positive leads to no later time.
        (time - now).abs() <= LAST_BITS * now.abs() && end > time && end <= self.end
    }

    /// Makes a step. What the model says of it meanwhile goes to `warn` and does not change how the call went: the step was
    /// done, and hosts stop at any status but OK.
    pub fn do_step(&mut self, time: f64, size: f64, warn: &mut dyn FnMut(fmt::Arguments<'_>)) -> Outcome {
        self.check(Call::DoStep, "fmi2DoStep")?;
        self.check_step(time, size)?;
        let ramped = self.frame.ramped;
        if ramped {
            self.check_ramps(size)?;
        }
        self.step(time, size, warn).map_err(|failure| self.failed_step(failure))?;
        if ramped {
            self.finish_ramps(size);
        }
        Ok(())
    }

    /// Has the model make a step that has been checked, without ramps.
    #[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
    #[inline(always)]
    pub fn step(&mut self, time: f64, size: f64, warn: &mut dyn FnMut(fmt::Arguments<'_>)) -> Result<(), Failure> {
        let (layout, model) = self.subject.parts();
        let result =
            model.step(&mut Step { time, size, warn, layout: Some(layout), experiment: &self.frame.experiment });
        self.frame.stale = all();
        result?;
        self.frame.time = time + size;
        Ok(())
    }

    /// After a step that the model could not make.
    #[cold]
    #[inline(never)]
    pub fn failed_step(&mut self, failure: Failure) -> Refusal {
        // Only a step can be discarded.
        if let Failure::Discard(message) = failure {
            self.frame.phase = Phase::StepFailed;
            Refusal::discard(message)
        } else {
            self.frame.phase = Phase::Error;
            Refusal::of(&failure)
        }
    }

    pub fn last_successful_time(&self) -> f64 {
        self.frame.time
    }
}

/// Share of a time by which two ways to compute it differ: a product and a sum.
const LAST_BITS: f64 = 16.0 * f64::EPSILON;

/// How much a host's clock may be off ours when a step of this size begins or ends (s).
///
/// Hosts compute communication points as start + i·h, by adding up h (a million additions of 0.1 ms end 2 ns late, 10⁸ of 1 µs
/// 0.2 µs early), in whole microseconds, or in single precision. All that is rounding; being out by half a step is a mistake
/// with every clock.
fn rounding(time: f64, size: f64) -> f64 {
    const MICROSECOND: f64 = 1e-6;
    let clocks = MICROSECOND + f64::from(f32::EPSILON) * time.abs();
    clocks.min(0.25 * size) + LAST_BITS * time.abs()
}

impl Slave {
    /// Checks a step's start and size against the clock.
    #[inline(never)]
    fn check_step(&self, time: f64, size: f64) -> Result<(), Refusal> {
        if !(size.is_finite() && size > 0.0) {
            return Err(Refusal::error(format!("communicationStepSize is {size:?}, it must be positive and finite")));
        }
        if !time.is_finite() {
            return Err(Refusal::error(format!("currentCommunicationPoint is {time:?}, it must be finite")));
        }
        let now = self.frame.time;
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
        if let Some(stop) = self.frame.experiment.and_then(|e| e.stop_time)
            && end > stop
            && end > stop + rounding(stop, size)
        {
            return Err(Refusal::error(format!("the step ends at {end:?}, past the stop time {stop:?}")));
        }
        Ok(())
    }

    /// Checks that no input leaves its range on its ramp.
    #[inline(never)]
    fn check_ramps(&mut self, size: f64) -> Result<(), Refusal> {
        let (layout, mut view) = self.subject.view();
        for reference in &layout.ramps {
            let real = &layout.reals[*reference as usize];
            let Some(slope) = view.ramp(*reference).copied() else { continue };
            let end = view.real(*reference) + slope * size;
            if !real.accepts(end) {
                let refusal = out_of_range(layout.name(real.variable), end, real.min, real.max);
                let end = format!("; it would be at the end of this step, rising by {slope:?} per second");
                return Err(Refusal::error(refusal.into_message() + &end));
            }
        }
        Ok(())
    }

    /// The inputs' ramps have been used: the inputs stand at their ends.
    #[inline(never)]
    fn finish_ramps(&mut self, size: f64) {
        let (layout, mut view) = self.subject.view();
        for reference in &layout.ramps {
            let slope = view.ramp(*reference).map_or(0.0, std::mem::take);
            // Adding zero would turn −0 into +0.
            if slope != 0.0 {
                let begin = view.real(*reference);
                view.set_real(*reference, begin + slope * size);
            }
        }
        self.frame.ramped = false;
    }
}

//! Steps, and the reason if one is incomplete.

use std::thread;
use std::time::Duration;

use super::{Instance, Result};
use crate::floating_point::guarded;
use crate::library::{DO_STEP_STATUS, LAST_SUCCESSFUL_TIME, Status, TERMINATED};

impl Instance {
    /// `fmi2DoStep`: from `time` to `time + step`.
    ///
    /// # Errors
    /// When the slave does not complete the step.
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<Status> {
        self.together(|calls| calls.do_step(time, step))
    }

    /// Waits for an asynchronous step, which continues after the call.
    #[cold]
    pub(super) fn incomplete_step(&mut self, mut status: Status) -> Result<Status> {
        const LONGEST_PAUSE: Duration = Duration::from_millis(10);
        let can_wait = self.interface().is_some_and(|interface| interface.can_run_asynchronously);
        if let Some(get_status) = self.functions().get_status.filter(|_| can_wait) {
            let mut pause = Duration::from_micros(10);
            while status == Status::Pending {
                thread::sleep(pause);
                pause = LONGEST_PAUSE.min(pause * 2);
                let mut now = 0;
                // SAFETY: living component.
                let answer = guarded(|| unsafe { get_status(self.component.as_ptr(), DO_STEP_STATUS, &raw mut now) });
                status = Status::from_c(if answer == 0 { now } else { answer });
            }
        }
        self.judge("fmi2DoStep", status)
    }

    /// After a discarded step: whether the slave requests the end of the simulation.
    pub fn wants_to_end(&mut self) -> bool {
        let mut value = 0;
        let Some(function) = self.functions().get_boolean_status else { return false };
        // SAFETY: living component.
        let status = guarded(|| unsafe { function(self.component.as_ptr(), TERMINATED, &raw mut value) });
        status == 0 && value != 0
    }

    /// After a discarded step: the time up to which the slave got.
    pub fn last_successful_time(&mut self) -> Option<f64> {
        let mut value = 0.0;
        let function = self.functions().get_real_status?;
        // SAFETY: living component.
        let status = guarded(|| unsafe { function(self.component.as_ptr(), LAST_SUCCESSFUL_TIME, &raw mut value) });
        (status == 0).then_some(value)
    }
}

//! Calls that move an instance on: steps, modes, and what an integrator asks for.

use std::ffi::c_int;

use crate::Phase::{Continuous, Discarded, Event, Failed, Initialization, Instantiated, Stepping, Terminated};
use crate::common::{DISCARD, EventInfo, OK};
use crate::{Allowed, Expected, Host, Instance, Value};

impl Host<'_> {
    pub fn step(&mut self, i: usize) {
        let Expected { phase, time: now, stop, ref slopes, .. } = self.instances[i].expected;
        let ramped = slopes.values().any(|slope| *slope != 0.0);
        let size = self.random.size();
        let (time, right) = match self.random.below(30) {
            0 => (self.random.pick(&[f64::NAN, f64::INFINITY]), false),
            // Clearly elsewhere.
            1 => (now + (0.5 * size.abs()).max(1e-3 * now.abs()).max(1e-3), false),
            _ => (now, true),
        };
        let end = now + size;
        // Past the stop time by more than rounding.
        let past = end > stop + (1.1e-6 + 2e-7 * stop.abs()).min(0.5 * size) + 1e-14 * end.abs();
        let possible = right && size > 0.0 && end > now && end.is_finite() && !past;
        let allowed = if phase == Stepping && possible { Allowed::Perhaps } else { Allowed::No };
        let before = self.before(i);
        let slave = &self.instances[i].slave;
        let status = self.fmu.fmi2DoStep(slave.component, time, size, c_int::from(self.random.rarely(2)));
        // A step that the model fails at leaves the state behind; one that is refused does not.
        let message = self.instances[i].slave.message();
        let refused = phase != Stepping
            || ["communicationStepSize", "currentCommunicationPoint", "the step ends at"]
                .iter()
                .any(|start| message.starts_with(start))
            || (ramped && message.contains("at the end of this step"));
        let before = before.filter(|_| refused);
        if self.check(i, format_args!("step {time:?} {size:?}"), &allowed, before.as_deref(), status) {
            let expected = &mut self.instances[i].expected;
            expected.time = end;
            for (vr, slope) in expected.slopes.drain().filter(|(_, slope)| *slope != 0.0) {
                if let Some(Value::Real(bits)) = expected.values.get_mut(&(0, vr)) {
                    *bits = (f64::from_bits(*bits) + slope * size).to_bits();
                }
            }
        } else if status == DISCARD {
            self.instances[i].expected.phase = Discarded;
        } else if !refused {
            self.instances[i].expected.phase = Failed;
        }
    }

    /// What only model exchange has.
    pub fn be_integrated(&mut self, i: usize) {
        let Instance { model, expected, slave } = &self.instances[i];
        let (phase, exchange) = (expected.phase, expected.exchange);
        let (states, indicators) = self.profiles[*model].exchange.unwrap_or((1, 1));
        let (fmu, c) = (self.fmu, slave.component);
        let running = matches!(phase, Event | Continuous);
        let for_debugging = matches!(phase, Terminated | Failed);
        let initialization = phase == Initialization;
        // Mostly what there is.
        let wrong_count = self.random.rarely(30);
        let n = |right: usize| if wrong_count { right + 1 } else { right };
        let mut numbers = vec![7.0; states.max(indicators) + 1];
        let before = self.before(i);
        let before = before.as_deref();
        let when = |legal| if exchange && legal { Allowed::Yes } else { Allowed::No };
        let perhaps = |legal| if exchange && legal && !wrong_count { Allowed::Perhaps } else { Allowed::No };
        match (self.random.below(16), phase) {
            (0, _) => {
                let status = fmu.fmi2EnterEventMode(c);
                if self.check(i, "enter event mode", &when(running), before, status) {
                    self.instances[i].expected.phase = Event;
                }
            }
            (1..4, Event) | (1, _) => {
                let status = fmu.fmi2EnterContinuousTimeMode(c);
                if self.check(i, "enter continuous-time mode", &when(phase == Event), before, status) {
                    self.instances[i].expected.phase = Continuous;
                }
            }
            (4..6, Event) | (2, _) => {
                let mut info = EventInfo::default();
                let status = fmu.fmi2NewDiscreteStates(c, &raw mut info);
                let legal = exchange && phase == Event;
                let allowed = if legal { Allowed::Perhaps } else { Allowed::No };
                let before = before.filter(|_| !legal);
                if !self.check(i, "new discrete states", &allowed, before, status) && legal {
                    self.instances[i].expected.phase = Failed;
                }
            }
            (3, _) => {
                let status = fmu.fmi2CompletedIntegratorStep(c, 1, &mut 0, &mut 0);
                let legal = exchange && phase == Continuous;
                let allowed = if legal { Allowed::Perhaps } else { Allowed::No };
                let before = before.filter(|_| !legal);
                if !self.check(i, "completed step", &allowed, before, status) && legal {
                    self.instances[i].expected.phase = Failed;
                }
            }
            (4 | 5, _) => {
                let time = self.random.number();
                let status = fmu.fmi2SetTime(c, time);
                if self.check(i, format_args!("time {time:?}"), &when(running && time.is_finite()), before, status) {
                    self.instances[i].expected.time = time;
                }
            }
            (6..9, _) => {
                numbers.fill_with(|| self.random.number());
                let x = &numbers[..n(states)];
                let status = fmu.fmi2SetContinuousStates(c, x.as_ptr(), x.len());
                let allowed = perhaps(phase == Continuous);
                self.check(i, format_args!("states {x:?}"), &allowed, before.filter(|_| status != OK), status);
            }
            (kind, _) => {
                let x = numbers.as_mut_ptr();
                let (what, status, legal) = match kind {
                    9 | 10 => ("derivatives", fmu.fmi2GetDerivatives(c, x, n(states)), running || for_debugging),
                    11 | 12 => (
                        "indicators",
                        fmu.fmi2GetEventIndicators(c, x, n(indicators)),
                        running || for_debugging || initialization,
                    ),
                    13 => (
                        "continuous states",
                        fmu.fmi2GetContinuousStates(c, x, n(states)),
                        running || for_debugging || initialization,
                    ),
                    _ => ("nominals", fmu.fmi2GetNominalsOfContinuousStates(c, x, n(states)), true),
                };
                let allowed = perhaps(legal);
                if !self.check(i, what, &allowed, before, status) {
                    assert!(numbers.iter().all(|v| *v == 7.0), "written though refused");
                }
            }
        }
    }

    pub fn change_phase(&mut self, i: usize) {
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let Expected { phase, experiment, .. } = self.instances[i].expected;
        // Mostly forward.
        let forward = match phase {
            Instantiated if experiment => 1,
            Instantiated => 0,
            Initialization => 2,
            Stepping | Event | Continuous => 5,
            Discarded | Terminated | Failed => 4,
        };
        let choice = if self.random.rarely(3) { self.random.below(5) } else { forward };
        let before = self.before(i);
        let before = before.as_deref();
        let when = |legal| if legal { Allowed::Yes } else { Allowed::No };
        let perhaps = |legal| if legal { Allowed::Perhaps } else { Allowed::No };
        match choice {
            0 => {
                let start = self.random.pick(&[0.0, 0.0, 0.0, 1.5, -3.0, 1e9, f64::NAN, f64::INFINITY]);
                let stop = self.random.pick(&[f64::INFINITY, start + 1.0, start + 10.0, start - 1.0, f64::NAN]);
                let has_stop = !self.random.rarely(3);
                let valid = start.is_finite() && (!has_stop || stop >= start);
                let status = fmu.fmi2SetupExperiment(c, 0, f64::NAN, start, c_int::from(has_stop), stop);
                let what = format_args!("setup {start:?} {stop:?} {has_stop}");
                if self.check(i, what, &when(phase == Instantiated && valid), before, status) {
                    let expected = &mut self.instances[i].expected;
                    (expected.experiment, expected.time) = (true, start);
                    expected.stop = if has_stop { stop } else { f64::INFINITY };
                }
            }
            1 => {
                let status = fmu.fmi2EnterInitializationMode(c);
                if self.check(i, "enter", &perhaps(phase == Instantiated && experiment), before, status) {
                    self.instances[i].expected.phase = Initialization;
                }
            }
            2 => {
                let status = fmu.fmi2ExitInitializationMode(c);
                if self.check(i, "exit", &perhaps(phase == Initialization), before, status) {
                    let expected = &mut self.instances[i].expected;
                    expected.phase = if expected.exchange { Event } else { Stepping };
                }
            }
            3 if self.random.rarely(4) => {
                let status = fmu.fmi2Terminate(c);
                if self.check(
                    i,
                    "terminate",
                    &when(matches!(phase, Stepping | Discarded | Event | Continuous)),
                    before,
                    status,
                ) {
                    self.instances[i].expected.phase = Terminated;
                }
            }
            4 if forward == 4 || self.random.rarely(8) => {
                let status = fmu.fmi2Reset(c);
                if self.check(i, "reset", &Allowed::Yes, before, status) {
                    let Instance { model, expected, .. } = &self.instances[i];
                    let fresh = Expected::fresh(&self.profiles[*model], expected.exchange);
                    self.instances[i].expected = fresh;
                }
            }
            _ => {
                let status = fmu.fmi2CancelStep(c);
                self.check(i, "cancel", &Allowed::No, before, status);
            }
        }
    }
}

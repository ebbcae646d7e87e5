//! Calls that save states, and those that change nothing.

use std::ptr::{null, null_mut, without_provenance_mut};

use crate::Phase::{Discarded, Stepping, Terminated};
use crate::common::DISCARD;
use crate::{Allowed, Host};

impl Host<'_> {
    pub fn states(&mut self, i: usize) {
        let (fmu, c, model) = (self.fmu, self.instances[i].slave.component, self.instances[i].model);
        let steady = self.can_be_saved(i);
        let choice = self.random.below(12);
        let before = if choice > 2 { self.before(i) } else { None };
        let before = before.as_deref();
        match choice {
            // Save, in a new or a used place.
            0..3 => {
                let old = (!self.saved.is_empty() && self.saved.len() > self.random.below(10))
                    .then(|| self.random.below(self.saved.len()));
                let mut handle = old.map_or(null_mut(), |k| self.saved[k].0);
                let status = fmu.fmi2GetFMUstate(c, &raw mut handle);
                let allowed = if steady { Allowed::Yes } else { Allowed::Perhaps };
                if self.check(i, "save", &allowed, None, status) {
                    let entry = (handle, model, self.instances[i].expected.clone(), c);
                    match old {
                        Some(k) => self.saved[k] = entry,
                        None => self.saved.push(entry),
                    }
                } else if let Some(k) = old {
                    // If it was the destructor of the old state that panicked, the new one is in its place.
                    self.saved.swap_remove(k);
                }
            }
            // Restore, mostly the instance's own.
            3..7 if !self.saved.is_empty() => {
                let own = self.saved.iter().position(|entry| entry.1 == model).filter(|_| !self.random.rarely(4));
                let k = own.unwrap_or_else(|| self.random.below(self.saved.len()));
                let (handle, of, expected, _) = self.saved[k].clone();
                let status = fmu.fmi2SetFMUstate(c, handle);
                let is_own = of == model && expected.exchange == self.instances[i].expected.exchange;
                let allowed = if is_own { Allowed::Yes } else { Allowed::No };
                if self.check(i, format_args!("restore {handle:?}"), &allowed, before, status) {
                    self.instances[i].expected = expected;
                }
            }
            7 if !self.saved.is_empty() => {
                let k = self.random.below(self.saved.len());
                let (mut handle, ..) = self.saved.swap_remove(k);
                let status = fmu.fmi2FreeFMUstate(c, &raw mut handle);
                self.check(i, "free state", &Allowed::Yes, None, status);
            }
            // No such state.
            8 => {
                let mut handle = without_provenance_mut(self.random.pick(&[usize::MAX, 0x7fff_ffff, 1 << 40]));
                let status = match self.random.below(4) {
                    0 => fmu.fmi2SetFMUstate(c, handle),
                    1 => fmu.fmi2FreeFMUstate(c, &raw mut handle),
                    2 => fmu.fmi2GetFMUstate(c, &raw mut handle),
                    _ => fmu.fmi2SerializedFMUstateSize(c, handle, &mut 0),
                };
                self.check(i, "no such state", &Allowed::No, before, status);
            }
            9 if steady => {
                let blob = self.instances[i].slave.blob();
                let entry = (blob, model, self.instances[i].expected.clone(), self.is_sound(i));
                if self.blobs.len() < 10 {
                    self.blobs.push(entry);
                } else {
                    let k = self.random.below(10);
                    self.blobs[k] = entry;
                }
            }
            _ if !self.blobs.is_empty() => {
                let k = self.random.below(self.blobs.len());
                let (mut blob, of, expected, sound) = self.blobs[k].clone();
                let damaged = self.random.rarely(3);
                if damaged && self.random.rarely(2) {
                    blob.truncate(self.random.below(blob.len()));
                } else if damaged {
                    let at = self.random.below(8 * blob.len());
                    blob[at / 8] ^= 1 << (at % 8);
                }
                let mut handle = null_mut();
                let status = fmu.fmi2DeSerializeFMUstate(c, blob.as_ptr(), blob.len(), &raw mut handle);
                let is_own = of == model && expected.exchange == self.instances[i].expected.exchange;
                let allowed = match (is_own && !damaged, sound) {
                    (false, _) => Allowed::No,
                    (true, false) => Allowed::Perhaps,
                    (true, true) => Allowed::Yes,
                };
                if self.check(i, format_args!("deserialise, damaged: {damaged}"), &allowed, before, status) {
                    self.saved.push((handle, model, expected, c));
                }
            }
            _ => self.status(i),
        }
    }

    pub fn status(&mut self, i: usize) {
        let phase = self.instances[i].expected.phase;
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let kind = self.random.pick(&[0, 1, 2, 2, 3, 3, 4, -1]);
        let before = self.before(i);
        let legal = !self.instances[i].expected.exchange && matches!(phase, Stepping | Discarded | Terminated);
        let (mut time, mut flag) = (f64::NAN, 7);
        let which = self.random.below(5);
        let status = match which {
            0 => fmu.fmi2GetRealStatus(c, kind, &raw mut time),
            1 => fmu.fmi2GetBooleanStatus(c, kind, &raw mut flag),
            2 => fmu.fmi2GetIntegerStatus(c, kind, &raw mut flag),
            3 => fmu.fmi2GetStatus(c, kind, &raw mut flag),
            _ => fmu.fmi2GetStringStatus(c, kind, &mut null()),
        };
        let allowed = match (legal, which, kind) {
            (false, ..) => Allowed::No,
            (true, 0, 2) | (true, 1, 3) => Allowed::Yes,
            _ => {
                assert_eq!(status, DISCARD);
                Allowed::Perhaps
            }
        };
        if self.check(i, format_args!("status {which} {kind}"), &allowed, before.as_deref(), status) && which == 0 {
            assert_eq!(time.to_bits(), self.instances[i].expected.time.to_bits(), "call {}", self.calls);
        }
    }

    pub fn debug_logging(&mut self, i: usize) {
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let name = self.random.pick(&[c"logAll", c"logStatusError", c"logEvents", c"nothing"]);
        let before = self.before(i);
        let status = fmu.fmi2SetDebugLogging(c, 1, 1, &name.as_ptr());
        let allowed = if name == c"nothing" { Allowed::No } else { Allowed::Yes };
        self.check(i, "debug logging", &allowed, before.as_deref(), status);
    }

    pub fn free(&mut self, i: usize) {
        let instance = self.instances.swap_remove(i);
        let owner = instance.slave.component;
        self.saved.retain(|entry| entry.3 != owner);
        self.calls += 1;
    }
}

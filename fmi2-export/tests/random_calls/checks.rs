//! What a call may do, and whether it did.

use std::collections::HashMap;
use std::ffi::c_int;
use std::fmt::Display;

use crate::Phase::{Failed, Initialization, Instantiated};
use crate::common::real::reals;
use crate::common::{CO_SIMULATION, DISCARD, ERROR, MODEL_EXCHANGE, OK};
use crate::{Allowed, Expected, Host, Instance, Value};

impl Host<'_> {
    pub fn instantiate(&mut self) {
        let model = self.random.below(self.profiles.len());
        let profile = &self.profiles[model];
        let exchange = profile.exchange.is_some() && self.random.rarely(2);
        let kind = if exchange { MODEL_EXCHANGE } else { CO_SIMULATION };
        let slave = self.fmu.instantiate_as(kind, &profile.guid).unwrap_or_else(|log| panic!("{log:?}"));
        self.instances.push(Instance { slave, model, expected: Expected::fresh(profile, exchange) });
    }

    /// Compares what a call did with what it should have done, and says whether it succeeded.
    pub fn check(
        &mut self,
        i: usize,
        what: impl Display,
        allowed: &Allowed,
        before: Option<&[u8]>,
        status: c_int,
    ) -> bool {
        self.calls += 1;
        if self.trace {
            println!("{} {i} {:?} {what} -> {status}", self.calls, self.instances[i].expected.phase);
        }
        let case = || format!("call {} on {:?}: {what} -> {status}", self.calls, self.instances[i].expected.phase);
        let log = std::mem::take(&mut *self.instances[i].slave.log.lock().unwrap());
        assert!([OK, DISCARD, ERROR].contains(&status), "{}", case());
        if status != OK {
            let known = ["logStatusWarning", "logStatusDiscard", "logStatusError", "logEvents"];
            let told = log
                .iter()
                .any(|(s, category, text)| *s == status && known.contains(&category.as_str()) && !text.is_empty());
            assert!(told, "{}: {log:?}", case());
        }
        if status == ERROR && log.iter().any(|(_, _, message)| message.starts_with("internal error")) {
            assert!(self.profiles[self.instances[i].model].misbehaves, "{}: {log:?}", case());
            let expected = &mut self.instances[i].expected;
            // It has failed, in the midst of something.
            (expected.phase, expected.values) = (Failed, HashMap::new());
            return false;
        }
        let good = status == OK;
        match allowed {
            Allowed::No => assert!(status == ERROR, "{}: {log:?}", case()),
            Allowed::Yes => assert!(good, "{}: {log:?}", case()),
            Allowed::Perhaps => {}
        }
        if let (ERROR, Some(before)) = (status, before) {
            assert!(self.instances[i].slave.blob() == before, "{}: changed the state", case());
            self.instances[i].slave.log.lock().unwrap().clear();
        }
        good
    }

    /// The state before a call, now and then.
    pub fn before(&mut self, i: usize) -> Option<Vec<u8>> {
        (self.random.rarely(8) && self.can_be_saved(i)).then(|| self.instances[i].slave.blob())
    }

    /// Whether saving and serialising cannot fail: see the faults of `misbehaving`.
    pub fn can_be_saved(&self, i: usize) -> bool {
        let Instance { model, expected, .. } = &self.instances[i];
        !self.profiles[*model].misbehaves
            || matches!(expected.values.get(&(1, 0)), Some(Value::Integer(fault)) if *fault < 12)
    }

    /// Whether a model has to accept the state from bytes: it may refuse one with which it could not be initialized, or
    /// that has numbers beyond all bounds.
    pub fn is_sound(&self, i: usize) -> bool {
        let Instance { slave, model, expected } = &self.instances[i];
        let profile = &self.profiles[*model];
        profile.misbehaves
            || !matches!(expected.phase, Instantiated | Initialization)
                && reals(slave, profile.counts).iter().all(|value| value.is_finite())
    }
}

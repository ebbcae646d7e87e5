//! Calls that set and read variables.

use std::ffi::{CStr, CString, c_int};
use std::ptr::null;

use crate::Phase::{Continuous, Event, Initialization, Instantiated, Stepping};
use crate::profile::write;
use crate::{Allowed, Host, Value};

impl Host<'_> {
    pub fn references(&mut self, kind: usize, model: usize) -> Vec<u32> {
        let n = self.profiles[model].length(kind);
        let random = &mut self.random;
        let length = random.below(5);
        (0..length)
            .map(|_| match random.below(60) {
                0 => random.pick(&[n, n + 1, u32::MAX, u32::MAX / 2]),
                _ if n > 0 => u32::try_from(random.below(n as usize)).unwrap(),
                _ => 0,
            })
            .collect()
    }

    pub fn set(&mut self, i: usize) {
        let (model, phase) = (self.instances[i].model, self.instances[i].expected.phase);
        let kind = self.random.pick(&[0, 0, 0, 0, 1, 2, 3]);
        let mut references = self.references(kind, model);
        // Mostly what can be set: else hardly anything would be.
        if !self.random.rarely(4) {
            references
                .retain(|vr| self.profiles[model].settable[kind].get(*vr as usize).is_some_and(|s| s.in_phase(phase)));
        }
        let values: Vec<Value> = references.iter().map(|_| self.value(kind)).collect();
        let settable = references
            .iter()
            .all(|vr| self.profiles[model].settable[kind].get(*vr as usize).is_some_and(|s| s.in_phase(phase)));
        let valid = values.iter().all(|value| match value {
            Value::Real(bits) => f64::from_bits(*bits).is_finite(),
            Value::Integer(value) => kind == 1 || matches!(value, 0 | 1),
            Value::Text(text) => text.to_str().is_ok(),
        });
        let in_order =
            matches!(phase, Instantiated | Initialization | Stepping | Event) || phase == Continuous && kind == 0;
        let allowed = match (in_order && settable && valid, references.is_empty()) {
            (false, _) => Allowed::No,
            (true, true) => Allowed::Yes,
            (true, false) => Allowed::Perhaps,
        };
        let before = self.before(i);
        let status = write(&self.instances[i].slave, kind, &references, &values);
        let what = format_args!("set {kind} {references:?} {values:?}");
        if self.check(i, what, &allowed, before.as_deref(), status) {
            let known = &mut self.instances[i].expected.values;
            known.extend(references.iter().zip(values).map(|(vr, value)| ((kind, *vr), value)));
        }
    }

    pub fn value(&mut self, kind: usize) -> Value {
        let random = &mut self.random;
        match kind {
            0 => Value::Real(random.number().to_bits()),
            1 => Value::Integer(match random.below(10) {
                0 => random.pick(&[c_int::MAX, c_int::MIN, -1, 0]),
                1 => random.pick(&[100, 1000, 24, 25]),
                // Mostly no fault.
                2..6 => 1,
                _ => c_int::try_from(random.below(36)).unwrap(),
            }),
            2 => Value::Integer(if random.rarely(30) { random.pick(&[-1, 2]) } else { random.pick(&[0, 1]) }),
            _ => Value::Text(random.pick(&[c"", c"text", c"%s%n#r1#", c"\xff\xfe", c"größer", c"\x01"]).into()),
        }
    }

    pub fn get(&mut self, i: usize) {
        let (model, phase) = (self.instances[i].model, self.instances[i].expected.phase);
        let kind = self.random.pick(&[0, 0, 0, 1, 2, 3]);
        let references = self.references(kind, model);
        let known = references.iter().all(|vr| *vr < self.profiles[model].length(kind));
        // In initialization mode, the model may refuse to be initialized with these parameters.
        let allowed = match (phase, known) {
            (Instantiated, _) | (_, false) => Allowed::No,
            (Initialization, _) => Allowed::Perhaps,
            _ if self.profiles[model].misbehaves => Allowed::Perhaps,
            _ => Allowed::Yes,
        };
        let before = self.before(i);
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let n = references.len();
        let (mut reals, mut integers, mut texts) = (vec![0.5; n], vec![77; n], vec![null(); n]);
        let vr = references.as_ptr();
        let status = match kind {
            0 => fmu.fmi2GetReal(c, vr, n, reals.as_mut_ptr()),
            1 => fmu.fmi2GetInteger(c, vr, n, integers.as_mut_ptr()),
            2 => fmu.fmi2GetBoolean(c, vr, n, integers.as_mut_ptr()),
            _ => fmu.fmi2GetString(c, vr, n, texts.as_mut_ptr()),
        };
        let values: Vec<Value> = (0..n)
            .map(|k| match kind {
                0 => Value::Real(reals[k].to_bits()),
                1 | 2 => Value::Integer(integers[k]),
                _ if texts[k].is_null() => Value::Text(CString::default()),
                // SAFETY: just returned, and no call since.
                _ => Value::Text(unsafe { CStr::from_ptr(texts[k]) }.to_owned()),
            })
            .collect();
        if self.check(i, format_args!("get {kind} {references:?}"), &allowed, before.as_deref(), status) {
            for (vr, value) in references.iter().zip(&values) {
                let expected = self.instances[i].expected.values.get(&(kind, *vr));
                assert!(
                    expected.is_none_or(|e| e == value),
                    "call {}: {kind} {vr}: {value:?} {expected:?}",
                    self.calls
                );
            }
        } else {
            assert!(reals.iter().all(|v| *v == 0.5) && integers.iter().all(|v| *v == 77), "written though refused");
        }
    }

    pub fn get_many_ways(&mut self, i: usize) {
        let (model, phase) = (self.instances[i].model, self.instances[i].expected.phase);
        let (a, b) = (self.references(0, model), self.references(0, model));
        let seed: Vec<f64> = b.iter().map(|_| self.random.number()).collect();
        let orders: Vec<c_int> = a.iter().map(|_| self.random.pick(&[1, 1, 1, 2, 0, -1])).collect();
        let mut values = vec![0.0; a.len()];
        let before = self.before(i);
        let (fmu, c) = (self.fmu, self.instances[i].slave.component);
        let (status, legal) = if self.random.rarely(2) {
            let (n, k) = (a.len(), b.len());
            let (seed, values) = (seed.as_ptr(), values.as_mut_ptr());
            (fmu.fmi2GetDirectionalDerivative(c, a.as_ptr(), n, b.as_ptr(), k, seed, values), phase != Instantiated)
        } else {
            let (vr, order, values) = (a.as_ptr(), orders.as_ptr(), values.as_mut_ptr());
            let status = fmu.fmi2GetRealOutputDerivatives(c, vr, a.len(), order, values);
            (status, !self.instances[i].expected.exchange && !matches!(phase, Instantiated | Initialization))
        };
        let allowed = if legal { Allowed::Perhaps } else { Allowed::No };
        self.check(i, format_args!("derivatives {a:?} {b:?} {seed:?} {orders:?}"), &allowed, before.as_deref(), status);
    }

    pub fn ramp(&mut self, i: usize) {
        let (model, phase) = (self.instances[i].model, self.instances[i].expected.phase);
        let references = self.references(0, model);
        let values: Vec<f64> = references.iter().map(|_| self.random.number()).collect();
        let orders: Vec<c_int> = references.iter().map(|_| self.random.pick(&[1, 1, 1, 1, 2, 0])).collect();
        let ramped = references.iter().all(|vr| self.profiles[model].ramped.get(*vr as usize) == Some(&true));
        let valid = ramped && values.iter().all(|v| v.is_finite()) && orders.iter().all(|order| *order == 1);
        let legal = !self.instances[i].expected.exchange && matches!(phase, Instantiated | Initialization | Stepping);
        let before = self.before(i);
        let (vr, n) = (references.as_ptr(), references.len());
        let c = self.instances[i].slave.component;
        let status = self.fmu.fmi2SetRealInputDerivatives(c, vr, n, orders.as_ptr(), values.as_ptr());
        let allowed = if legal && valid { Allowed::Yes } else { Allowed::No };
        let what = format_args!("ramps {references:?} {orders:?} {values:?}");
        if self.check(i, what, &allowed, before.as_deref(), status) {
            self.instances[i].expected.slopes.extend(references.iter().copied().zip(values));
        }
    }
}

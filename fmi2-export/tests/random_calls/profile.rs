//! What a model can do is found out by trying.

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_int};
use std::ptr::null;

use crate::common::real::{Counts, count};
use crate::common::{Fmu, MODEL_EXCHANGE, OK, Slave};
use crate::{Profile, Settable, Value};

impl Profile {
    pub fn explore(fmu: &Fmu, guid: &str, misbehaves: bool) -> Self {
        let counts = count(fmu, guid);
        let fresh = fmu.instantiate(guid);
        fresh.initialize();
        let (before, stepping) = (fmu.instantiate(guid), fmu.instantiate(guid));
        stepping.initialize();
        let in_mode = |continuous: bool| {
            let slave = fmu.instantiate_as(MODEL_EXCHANGE, guid).ok()?;
            if continuous {
                slave.start();
            } else {
                slave.initialize();
            }
            Some(slave)
        };
        let (event, continuous) = (in_mode(false), in_mode(true));
        let exchange = continuous.as_ref().map(|slave| {
            let (c, mut buffer) = (slave.component, vec![0.0; 10_000]);
            let buffer = buffer.as_mut_ptr();
            let count = |get: &dyn Fn(usize) -> c_int| (0..10_000).find(|n| get(*n) == OK).unwrap();
            let states = count(&|n| fmu.fmi2GetContinuousStates(c, buffer, n));
            (states, count(&|n| fmu.fmi2GetEventIndicators(c, buffer, n)))
        });
        let mut start = HashMap::new();
        let lengths = [counts.reals, counts.integers, counts.booleans, counts.strings];
        let settable = std::array::from_fn(|kind| {
            (0..lengths[kind])
                .map(|vr| {
                    let value = read(&fresh, kind, vr);
                    let takes = |slave: &Slave| write(slave, kind, &[vr], std::slice::from_ref(&value)) == OK;
                    let settable = Settable {
                        before: takes(&before),
                        stepping: takes(&stepping),
                        event: event.as_ref().is_some_and(takes),
                        continuous: continuous.as_ref().is_some_and(takes),
                    };
                    if settable.before {
                        start.insert((kind, vr), value);
                    }
                    settable
                })
                .collect()
        });
        let ramped = (0..counts.reals)
            .map(|vr| fmu.fmi2SetRealInputDerivatives(stepping.component, &raw const vr, 1, &1, &0.0) == OK)
            .collect();
        Self { guid: guid.to_owned(), counts, settable, ramped, start, misbehaves, exchange }
    }

    pub fn length(&self, kind: usize) -> u32 {
        let Counts { reals, integers, booleans, strings } = self.counts;
        [reals, integers, booleans, strings][kind]
    }
}

pub fn read(slave: &Slave, kind: usize, vr: u32) -> Value {
    let (fmu, c) = (slave.fmu, slave.component);
    let (mut real, mut integer, mut text) = (0.0, 0, null());
    let status = match kind {
        0 => fmu.fmi2GetReal(c, &raw const vr, 1, &raw mut real),
        1 => fmu.fmi2GetInteger(c, &raw const vr, 1, &raw mut integer),
        2 => fmu.fmi2GetBoolean(c, &raw const vr, 1, &raw mut integer),
        _ => fmu.fmi2GetString(c, &raw const vr, 1, &raw mut text),
    };
    assert_eq!(status, OK, "{:?}", slave.log);
    match kind {
        0 => Value::Real(real.to_bits()),
        1 | 2 => Value::Integer(integer),
        // SAFETY: just returned, and no call since.
        _ => Value::Text(unsafe { CStr::from_ptr(text) }.to_owned()),
    }
}

pub fn write(slave: &Slave, kind: usize, vr: &[u32], values: &[Value]) -> c_int {
    let (fmu, c, n) = (slave.fmu, slave.component, vr.len());
    let reals: Vec<f64> =
        values.iter().map(|v| if let Value::Real(v) = v { f64::from_bits(*v) } else { 0.0 }).collect();
    let integers: Vec<c_int> = values.iter().map(|v| if let Value::Integer(v) = v { *v } else { 0 }).collect();
    let texts: Vec<*const c_char> =
        values.iter().map(|v| if let Value::Text(v) = v { v.as_ptr() } else { null() }).collect();
    match kind {
        0 => fmu.fmi2SetReal(c, vr.as_ptr(), n, reals.as_ptr()),
        1 => fmu.fmi2SetInteger(c, vr.as_ptr(), n, integers.as_ptr()),
        2 => fmu.fmi2SetBoolean(c, vr.as_ptr(), n, integers.as_ptr()),
        _ => fmu.fmi2SetString(c, vr.as_ptr(), n, texts.as_ptr()),
    }
}

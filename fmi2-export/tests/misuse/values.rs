//! Value references and values that cannot be, and extreme ones that can.

use std::ffi::c_int;
use std::ptr::null;

use crate::common::misbehaving::{FAULT, FIXED, INPUT, INTEGER, LIMITED, OUTPUT, STATE, TUNABLE, instantiate};
use crate::common::{ERROR, Fmu, OK};
use crate::{refused, stepping};

#[test]
fn references_to_no_variable_of_the_type_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let c = slave.component;
    let says = "there is no variable of this type with value reference";
    for (first, kind) in [(8, 'r'), (5, 'i'), (4, 'b'), (4, 's')] {
        for vr in [first, first + 1, u32::MAX / 2, u32::MAX] {
            refused(&slave, says, || match kind {
                'r' => fmu.fmi2GetReal(c, &vr, 1, &mut 0.0),
                'i' => fmu.fmi2GetInteger(c, &vr, 1, &mut 0),
                'b' => fmu.fmi2GetBoolean(c, &vr, 1, &mut 0),
                _ => fmu.fmi2GetString(c, &vr, 1, &mut null()),
            });
            refused(&slave, says, || match kind {
                'r' => fmu.fmi2SetReal(c, &vr, 1, &0.0),
                'i' => fmu.fmi2SetInteger(c, &vr, 1, &0),
                'b' => fmu.fmi2SetBoolean(c, &vr, 1, &0),
                _ => fmu.fmi2SetString(c, &vr, 1, &c"".as_ptr()),
            });
        }
    }
    refused(&slave, says, || fmu.fmi2SetRealInputDerivatives(c, &8, 1, &1, &0.0));
    refused(&slave, says, || fmu.fmi2GetRealOutputDerivatives(c, &8, 1, &1, &mut 0.0));
    refused(&slave, says, || fmu.fmi2GetDirectionalDerivative(c, &8, 1, &INPUT, 1, &1.0, &mut 0.0));
    refused(&slave, says, || fmu.fmi2GetDirectionalDerivative(c, &OUTPUT, 1, &8, 1, &1.0, &mut 0.0));
    refused(&slave, "real.input is no output", || {
        fmu.fmi2GetDirectionalDerivative(c, &INPUT, 1, &INPUT, 1, &1.0, &mut 0.0)
    });
    refused(&slave, "real.fixed is no input", || {
        fmu.fmi2GetDirectionalDerivative(c, &OUTPUT, 1, &FIXED, 1, &1.0, &mut 0.0)
    });
    refused(&slave, "real.input cannot be NaN", || {
        fmu.fmi2GetDirectionalDerivative(c, &OUTPUT, 1, &INPUT, 1, &f64::NAN, &mut 0.0)
    });
    refused(&slave, "real.fixed takes no derivatives", || fmu.fmi2SetRealInputDerivatives(c, &FIXED, 1, &1, &0.0));
    refused(&slave, "real.input provides no derivative", || {
        fmu.fmi2GetRealOutputDerivatives(c, &INPUT, 1, &1, &mut 0.0)
    });
    for order in [0, -1, 2, c_int::MAX, c_int::MIN] {
        refused(&slave, &format!("derivative of order {order}"), || {
            fmu.fmi2SetRealInputDerivatives(c, &INPUT, 1, &order, &0.0)
        });
        if order < 1 {
            refused(&slave, &format!("derivative of order {order}"), || {
                fmu.fmi2GetRealOutputDerivatives(c, &OUTPUT, 1, &order, &mut 0.0)
            });
        }
    }
}

#[test]
fn one_bad_value_of_several_changes_none() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let c = slave.component;
    for bad in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for vr in [INPUT, TUNABLE] {
            refused(&slave, "it must be finite", || fmu.fmi2SetReal(c, [vr, vr].as_ptr(), 2, [2.0, bad].as_ptr()));
        }
        refused(&slave, "it must be finite", || {
            fmu.fmi2SetRealInputDerivatives(c, [INPUT, INPUT].as_ptr(), 2, [1, 1].as_ptr(), [2.0, bad].as_ptr())
        });
    }
    let two = [INPUT, LIMITED];
    for bad in [1.0 + f64::EPSILON, -1.5, f64::MAX] {
        refused(&slave, "between -1.0 and 1.0", || fmu.fmi2SetReal(c, two.as_ptr(), 2, [2.0, bad].as_ptr()));
    }
    for vr in [FIXED, OUTPUT, STATE, 8] {
        refused(&slave, "", || fmu.fmi2SetReal(c, [INPUT, vr].as_ptr(), 2, [2.0, 2.0].as_ptr()));
        refused(&slave, "", || fmu.fmi2SetInteger(c, [INPUT + INTEGER, vr + INTEGER].as_ptr(), 2, [2, 2].as_ptr()));
        refused(&slave, "", || fmu.fmi2SetBoolean(c, [INPUT, vr].as_ptr(), 2, [1, 1].as_ptr()));
        let texts = [c"a".as_ptr(), c"b".as_ptr()];
        refused(&slave, "", || fmu.fmi2SetString(c, [INPUT, vr].as_ptr(), 2, texts.as_ptr()));
    }
    for bad in [0, 37, -1, c_int::MAX, c_int::MIN] {
        refused(&slave, "is no item of Fault", || {
            fmu.fmi2SetInteger(c, [INPUT + INTEGER, FAULT].as_ptr(), 2, [2, bad].as_ptr())
        });
    }
    for bad in [2, -1, c_int::MIN] {
        refused(&slave, "is no fmi2Boolean", || fmu.fmi2SetBoolean(c, [INPUT, INPUT].as_ptr(), 2, [1, bad].as_ptr()));
    }
    let texts = [c"good".as_ptr(), c"\xc3\x28".as_ptr()];
    refused(&slave, "not UTF-8", || fmu.fmi2SetString(c, [INPUT, INPUT].as_ptr(), 2, texts.as_ptr()));
    let slave = instantiate(&fmu);
    for bad in [10, -10] {
        refused(&slave, "out of range, the least is -9, the greatest 9", || slave.set_integer(FIXED + INTEGER, bad));
    }
    // Reading is the same: nothing is written if one reference is bad.
    slave.initialize();
    let mut values = [7.0, 7.0];
    assert_eq!(fmu.fmi2GetReal(slave.component, [INPUT, 8].as_ptr(), 2, values.as_mut_ptr()), ERROR);
    assert_eq!(values, [7.0, 7.0]);
}

#[test]
fn extreme_values_that_are_legal_are_taken_as_they_are() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    for value in [f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, -0.0] {
        assert_eq!(slave.set(INPUT, value), OK);
        assert_eq!(slave.get(INPUT).to_bits(), value.to_bits());
    }
    for value in [c_int::MAX, c_int::MIN] {
        assert_eq!(slave.set_integer(INPUT + INTEGER, value), OK);
    }
    let long = std::ffi::CString::new("€ß%s#%n\n\u{1}".repeat(10_000)).unwrap();
    for text in [c"", c"%n%s##r1#", long.as_c_str()] {
        assert_eq!(fmu.fmi2SetString(slave.component, &INPUT, 1, &text.as_ptr()), OK);
        let mut back = null();
        assert_eq!(fmu.fmi2GetString(slave.component, &INPUT, 1, &mut back), OK);
        // SAFETY: just returned, and no call since.
        assert_eq!(unsafe { std::ffi::CStr::from_ptr(back) }, text);
    }
}

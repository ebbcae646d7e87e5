//! Calls during a call: from the logger, and from another thread.

use std::ffi::{c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, AtomicPtr, Ordering};

use crate::common::misbehaving::{FAULT, Fault, OUTPUT};
use crate::common::{ERROR, Fmu, Log, OK, Slave, callbacks};
use crate::{calls_with_nothing, stepping};

/// What the logger of the tests below calls, and what it is answered.
struct Reentry {
    call: extern "C" fn(&Self),
    fmu: *const Fmu,
    component: AtomicPtr<c_void>,
    answer: AtomicI32,
}

unsafe extern "C" fn call_back(environment: *mut c_void, _: *const c_char, _: c_int, _: *const c_char) {
    // SAFETY: set below to something that outlives the instance.
    let reentry = unsafe { &*environment.cast::<Reentry>() };
    (reentry.call)(reentry);
}

extern "C" fn everything(reentry: &Reentry) {
    // SAFETY: lives as long as the test.
    let (fmu, c) = (unsafe { &*reentry.fmu }, reentry.component.load(Ordering::Relaxed));
    if c.is_null() {
        return; // Still in fmi2Instantiate.
    }
    let answers = calls_with_nothing(fmu, c);
    fmu.fmi2FreeInstance(c);
    reentry.answer.store(*answers.iter().min().unwrap(), Ordering::Relaxed);
}

/// Was: two mutable references to the instance, and its memory freed under a running call.
#[test]
fn a_logger_that_calls_back_into_the_instance_is_refused() {
    let fmu = Fmu::load("misbehaving");
    let reentry = Reentry {
        call: everything,
        fmu: &raw const fmu,
        component: AtomicPtr::new(null_mut()),
        answer: AtomicI32::new(-1),
    };
    let mut functions = callbacks(&Log::default());
    // SAFETY: see `crate::common::callbacks`.
    functions.logger = Some(unsafe { std::mem::transmute::<*const (), crate::common::Logger>(call_back as *const ()) });
    functions.environment = (&raw const reentry).cast_mut().cast();
    let guid = std::ffi::CString::new(fmu.guids()[0].clone()).unwrap();
    let component = fmu.fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &functions, 0, 1);
    let slave = Slave { fmu: &fmu, component, log: Log::default() };
    reentry.component.store(component, Ordering::Relaxed);
    let answer = || reentry.answer.swap(-1, Ordering::Relaxed);

    slave.initialize(); // Logs events.
    assert_eq!(answer(), ERROR);
    assert_eq!(slave.step(0.7, 0.1), ERROR); // Refused.
    assert_eq!(answer(), ERROR);
    assert_eq!(slave.set_integer(FAULT, Fault::StepWarns as i32), OK);
    assert_eq!(slave.step(0.0, 0.1), OK); // In the middle of a step.
    assert_eq!(answer(), ERROR);
    assert_eq!(slave.set_integer(FAULT, Fault::StepPanics as i32), OK);
    assert_eq!(slave.step(0.1, 0.1), ERROR);
    assert_eq!(answer(), ERROR);
    slave.start_again();
}

#[test]
fn an_instance_used_by_two_threads_at_once_refuses_one_of_them() {
    let fmu = Arc::new(Fmu::load("misbehaving"));
    let slave = stepping(&fmu);
    let component = slave.component.expose_provenance();
    let refusals: usize = std::thread::scope(|scope| {
        let run = || {
            let c = std::ptr::with_exposed_provenance_mut(component);
            (0..50_000).filter(|_| fmu.fmi2GetReal(c, &OUTPUT, 1, &mut 0.0) != OK).count()
        };
        let threads = [scope.spawn(run), scope.spawn(run)];
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    });
    println!("{refusals} of 100000 calls met another one");
    assert_eq!(slave.step(0.5, 0.5), OK);
}

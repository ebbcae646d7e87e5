//! What an `fmi2Component` points to, and how a call gets at it.

use std::any::Any;
use std::cell::UnsafeCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::guard::{Entered, Guard};
use super::logger::Logger;
use super::types::Component;
use crate::categories::Category;
use crate::served::Served;
use crate::slave::Slave;
use crate::status::{Outcome, Refusal, Status};

/// What an `fmi2Component` points to.
///
/// In lines of a processor's cache of its own, so that threads that use other instances don't wait for it; and what every call needs comes
/// first: see [`Slave`].
#[repr(C, align(64))]
pub struct Shared {
    /// Whether a call is running on the instance.
    pub guard: Guard,
    pub instance: UnsafeCell<Instance>,
}

#[repr(C)]
pub struct Instance {
    pub library: &'static Served,
    pub slave: Slave,
    /// Which model of the library, for tidying up.
    pub model: usize,
    pub logger: Logger,
}

impl Instance {
    /// Tells of a step in the instance's life.
    pub fn event(&self, what: &str) {
        self.logger.log(Status::Ok, Category::Events, format_args!("{what}"));
    }
}

/// Marks an instance as in use; `None` if it is no instance, or is in use already: by a logger that calls back, or by
/// another thread.
///
/// # Safety
/// If not null and aligned, `component` must come from `instantiate` and not have been freed.
#[inline]
pub unsafe fn occupy<'c>(component: Component) -> Option<(&'c Shared, Entered<'c>)> {
    let pointer = component.cast::<Shared>();
    if !pointer.is_aligned() {
        return None;
    }
    // SAFETY: aligned; the rest is the caller's promise.
    let shared = unsafe { pointer.as_ref() }?;
    Some((shared, shared.guard.enter()?))
}

/// The short way of a call that is made at every step, if the host's thread owns the instance: runs it and tells how it went. `None` if
/// this is no usual call: then nothing has happened, and [`call`] is to make it.
///
/// # Safety
/// As [`occupy`].
#[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
#[inline(always)]
pub unsafe fn call_shortly(component: Component, run: impl FnOnce(&mut Instance) -> Option<Status>) -> Option<Status> {
    let pointer = component.cast::<Shared>();
    if pointer.is_null() || !pointer.is_aligned() {
        return None;
    }
    // SAFETY: not null, aligned; the rest is the caller's promise.
    let shared = unsafe { &*pointer };
    let entered = shared.guard.enter_as_owner()?;
    // SAFETY: the only reference until the call has ended.
    let instance = unsafe { &mut *shared.instance.get() };
    let status = if instance.library.is_lost() { None } else { run(instance) };
    entered.leave();
    status
}

/// Runs a call on an instance; refusals are logged, panics caught. Nothing is logged about a call from within another
/// one, because the logger would call again.
///
/// # Safety
/// As [`occupy`].
pub unsafe fn call(component: Component, run: impl FnOnce(&mut Instance) -> Outcome) -> Status {
    // SAFETY: the caller's promise.
    unsafe { call_anyhow(component, |instance, _| run(instance)) }
}

/// As [`call`], where [`call_shortly`] comes first: tells whether the host's thread owns the instance, with which the short way has been tried.
/// (In the call with which it becomes the owner it has not.)
///
/// # Safety
/// As [`occupy`].
pub unsafe fn call_anyhow(component: Component, run: impl FnOnce(&mut Instance, bool) -> Outcome) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    let Some((shared, entered)) = (unsafe { occupy(component) }) else { return Status::Error };
    // SAFETY: the only reference until the call has ended.
    let instance = unsafe { &mut *shared.instance.get() };
    let status = if instance.library.is_lost() {
        refused(instance, lost())
    } else {
        let is_by_owner = shared.guard.is_by_owner(&entered);
        match catch_unwind(AssertUnwindSafe(|| run(instance, is_by_owner))) {
            Ok(Ok(())) => Status::Ok,
            Ok(Err(refusal)) => refused(instance, refusal),
            Err(panic) => panicked(instance, panic),
        }
    };
    entered.leave();
    status
}

/// Why nothing can be called any more.
#[cold]
#[inline(never)]
pub fn lost() -> Refusal {
    let message = "fmi2Fatal has been returned: nothing can be called for any instance of this FMU but fmi2FreeInstance, until it is \
                   loaded anew";
    Refusal::fatal(message)
}

#[cold]
#[inline(never)]
#[allow(clippy::needless_pass_by_value)] // Dropped here, once, and not in each C function.
fn refused(instance: &mut Instance, refusal: Refusal) -> Status {
    if refusal.status() == Status::Fatal {
        instance.library.lose();
        instance.slave.poison();
    }
    let status = refusal.status();
    instance.logger.log(status, Category::of(status), format_args!("{}", refusal.message()));
    status
}

#[cold]
#[inline(never)]
pub fn panicked(instance: &mut Instance, panic: Box<dyn Any + Send>) -> Status {
    let message = message(panic);
    instance.slave.poison();
    instance.logger.log(Status::Error, Category::Error, format_args!("internal error in the model: {message}"));
    Status::Error
}

/// Runs code that may panic; the message if it did.
pub fn guarded<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(run)).map_err(message)
}

/// What was said of a panic.
#[cold]
#[inline(never)]
fn message(panic: Box<dyn Any + Send>) -> String {
    let message = panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message")
        .to_owned();
    dispose(panic);
    message
}

/// Drops what a panic has thrown: its destructor can panic, too, and throw something of the kind.
fn dispose(mut thrown: Box<dyn Any + Send>) {
    for _ in 0..8 {
        match catch_unwind(AssertUnwindSafe(|| drop(thrown))) {
            Ok(()) => return,
            Err(next) => thrown = next,
        }
    }
    std::mem::forget(thrown);
}

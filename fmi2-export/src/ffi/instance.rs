//! What an `fmi2Component` points to, and how a call gets at it.

use std::any::Any;
use std::cell::UnsafeCell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::guard::{Entered, Guard};
use super::logger::Logger;
use super::panics;
use super::types::Component;
use crate::categories::Category;
use crate::model::Failure;
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
    pub slave: Slave,
    pub library: &'static Served,
    /// Which model of the library, for tidying up.
    pub model: usize,
    pub logger: Logger,
}

impl Instance {
    /// Makes it ready for the short way of calls, if it can take it: see [`enter_shortly`].
    fn is_ready(&mut self) -> bool {
        self.slave.is_ready() && !self.library.is_lost()
    }

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

/// Begins the short way of a call that is made at every step, if the host's thread owns the instance and it is ready, as between steps
/// without ramps. If `None`, nothing has happened, and [`call`] is to make it, which looks at everything.
///
/// A function that takes the short way calls nothing besides the model: it ends with the call that makes up for it, so that it has nothing to keep in
/// registers meanwhile.
///
/// # Safety
/// As [`occupy`].
#[allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.
#[inline(always)]
pub unsafe fn enter_shortly<'c>(component: Component) -> Option<(&'c mut Instance, Entered<'c>)> {
    let pointer = component.cast::<Shared>();
    if pointer.is_null() || !pointer.is_aligned() {
        return None;
    }
    // SAFETY: not null, aligned; the rest is the caller's promise.
    let shared = unsafe { &*pointer };
    let entered = shared.guard.enter_shortly()?;
    // SAFETY: the only reference until the call has ended.
    Some((unsafe { &mut *shared.instance.get() }, entered))
}

/// Runs a call on an instance; refusals are logged, panics caught. Nothing is logged about a call from within another
/// one, because the logger would call again.
///
/// # Safety
/// As [`occupy`].
pub unsafe fn call(component: Component, run: impl FnOnce(&mut Instance) -> Outcome) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    match unsafe { begin(component) } {
        Ok((instance, entered)) => {
            let result = catch_unwind(AssertUnwindSafe(|| run(instance)));
            end(instance, entered, result)
        }
        Err(status) => status,
    }
}

/// Begins a call. Apart from it, once for all calls.
///
/// # Safety
/// As [`occupy`].
#[inline(never)]
unsafe fn begin<'c>(component: Component) -> Result<(&'c mut Instance, Entered<'c>), Status> {
    // SAFETY: the caller's promise.
    let (shared, entered) = unsafe { occupy(component) }.ok_or(Status::Error)?;
    // SAFETY: the only reference until the call has ended.
    let instance = unsafe { &mut *shared.instance.get() };
    if instance.library.is_lost() { Err(end(instance, entered, Ok(Err(lost())))) } else { Ok((instance, entered)) }
}

/// Ends a call, which has had this result or panicked.
#[inline(never)]
fn end(instance: &mut Instance, entered: Entered<'_>, result: std::thread::Result<Outcome>) -> Status {
    let status = match result {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(refusal)) => refused(instance, refusal),
        Err(panic) => panicked(instance, panic),
    };
    entered.leave(instance.is_ready());
    status
}

/// The instance of a component that has been entered.
///
/// # Safety
/// Nobody else may use it until the call has ended.
pub unsafe fn instance<'c>(component: Component) -> &'c mut Instance {
    // SAFETY: the caller's promise.
    unsafe { &mut *(*component.cast::<Shared>()).instance.get() }
}

/// Ends a call that began with [`enter_shortly`], and in which the model has failed. It finds the instance anew, so that nothing is kept for
/// it on the way of a step.
///
/// # Safety
/// The call must have entered this component, and not use the instance any more.
#[cold]
#[inline(never)]
pub unsafe fn end_failed(component: Component, entered: Entered<'_>, failure: Failure) -> Status {
    // SAFETY: the caller's promise.
    let instance = unsafe { instance(component) };
    let refusal = instance.slave.failed_step(failure);
    end(instance, entered, Ok(Err(refusal)))
}

/// As [`end_failed`], if it has panicked.
///
/// # Safety
/// As [`end_failed`].
#[cold]
#[inline(never)]
pub unsafe fn end_panicked(component: Component, entered: Entered<'_>, panic: Box<dyn Any + Send>) -> Status {
    // SAFETY: the caller's promise.
    let instance = unsafe { instance(component) };
    end(instance, entered, Err(panic))
}

/// Why nothing can be called any more.
#[cold]
#[inline(never)]
pub fn lost() -> Refusal {
    let message = "fmi2Fatal has been returned: nothing can be called for any instance of this FMU but fmi2FreeInstance, until it is \
                   loaded anew";
    Refusal::fatal(message)
}

/// From now on all calls for any instance are refused.
#[cold]
pub fn lose(library: &Served) {
    library.lose();
    panics::disown_all();
}

#[cold]
#[inline(never)]
#[allow(clippy::needless_pass_by_value)] // Dropped here.
fn refused(instance: &mut Instance, refusal: Refusal) -> Status {
    if refusal.status() == Status::Fatal {
        lose(instance.library);
        instance.slave.poison();
    }
    let status = refusal.status();
    instance.logger.log(status, Category::of(status), format_args!("{}", refusal.message()));
    status
}

#[cold]
#[inline(never)]
fn panicked(instance: &mut Instance, panic: Box<dyn Any + Send>) -> Status {
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

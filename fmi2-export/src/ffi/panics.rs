//! What is printed about panics: nothing about those inside a call, which reach the host through its logger; all others
//! are none of our business.
//!
//! The default hook would write to the host's standard error, and touches thread-locals with destructors, which keep a
//! library from being unloaded. But a crate that exports a model can also be linked into a program, its tests for
//! example, whose own panics must stay as loud as they were. So the hook has to know whether the panic is inside a call.
//! A thread-local mark would cost every call; looking for a busy instance costs only panics. While one instance is
//! busy on some thread, a panic elsewhere is mistaken for its own.

use std::panic::PanicHookInfo;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use super::guard::Guard;

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Send + Sync>;

/// The hook there was before ours.
static PREVIOUS: OnceLock<Hook> = OnceLock::new();

/// Addresses of the guards of all instances, which tell whether a call is running on them, sorted.
static GUARDS: Mutex<Vec<usize>> = Mutex::new(Vec::new());

/// Calls under way that have no instance: those that make or free one.
static WITHOUT_INSTANCE: AtomicUsize = AtomicUsize::new(0);

/// Puts the hook in place, once. Nothing is allocated that an unloaded library would leave behind.
pub fn install_hook() {
    // The hook cannot be changed on a thread that is panicking.
    if !std::thread::panicking() {
        PREVIOUS.get_or_init(|| {
            let previous = std::panic::take_hook();
            std::panic::set_hook(Box::new(hook));
            previous
        });
    }
}

fn hook(info: &PanicHookInfo<'_>) {
    if !is_inside_a_call()
        && let Some(previous) = PREVIOUS.get()
    {
        previous(info);
    }
}

fn is_inside_a_call() -> bool {
    // SAFETY: a guard lives at least as long as it is in the set.
    let is_busy = |guard: &usize| unsafe { &*(*guard as *const Guard) }.is_busy();
    WITHOUT_INSTANCE.load(Ordering::Relaxed) > 0 || guards().iter().any(is_busy)
}

/// Runs a call that makes or frees an instance.
pub fn without_instance<T>(run: impl FnOnce() -> T) -> T {
    WITHOUT_INSTANCE.fetch_add(1, Ordering::Relaxed);
    let result = run();
    WITHOUT_INSTANCE.fetch_sub(1, Ordering::Relaxed);
    result
}

/// From now on, panics are inside a call while a call runs on this instance.
///
/// # Safety
/// The guard must live until it is [`forget`]ten.
pub unsafe fn watch(guard: *const Guard) {
    let (mut guards, guard) = (guards(), guard as usize);
    if let Err(place) = guards.binary_search(&guard) {
        guards.insert(place, guard);
    }
}

/// Ends what [`watch`] has begun.
pub fn forget(guard: *const Guard) {
    let mut guards = guards();
    if let Ok(place) = guards.binary_search(&(guard as usize)) {
        guards.remove(place);
    }
    if guards.is_empty() {
        // Statics of an unloaded library are not dropped: leave no memory in them.
        *guards = Vec::new();
    }
}

/// No call takes the short way until one has ended on its instance that asks for everything.
pub fn disown_all() {
    // SAFETY: a guard lives at least as long as it is in the set.
    guards().iter().for_each(|guard| unsafe { &*(*guard as *const Guard) }.disown());
}

fn guards() -> MutexGuard<'static, Vec<usize>> {
    GUARDS.lock().unwrap_or_else(PoisonError::into_inner)
}

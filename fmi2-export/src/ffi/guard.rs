//! One call at a time: who may use an instance.
//!
//! Of two threads that use an instance at once, which the standard forbids, one is refused. An atomic swap does that for any threads, but
//! takes 18 cycles and lets nothing overtake it: for the three calls of a step half as long as the step of a small model. So a thread that
//! calls again becomes the *owner*. It enters by an ordinary store, of a mark that it alone writes, and looks once more whether it is the
//! owner. Another thread that wants to enter takes ownership away and then has the system make every processor pass a memory barrier
//! ([`barrier`]). Either the owner's store came before its processor's barrier, and the other thread sees the mark and is refused; or its
//! second look comes after the barrier, and it sees that it is the owner no more and enters as any other thread, by a swap.
//!
//! Each owner has a mark of its own: one that was stopped between its first look and its store may write it after others have become owners.
//!
//! The mark of an owner that is not inside also tells whether the instance is ready for the short way of a call: then that need not ask for
//! what is so between almost all steps. Whoever leaves says how it is, and only the owner changes it, but for [`Guard::disown`].
//!
//! Taking ownership away takes microseconds. Where threads take turns, it happens a few times, and then they all swap.

// On the way of every step, in a crate that is compiled for size.
#![allow(clippy::inline_always)]

use std::sync::atomic::{AtomicU8, AtomicUsize, Ordering, compiler_fence};

use super::barrier::{HAS_BARRIER, barrier, can_bar, this_thread};

/// An owner that is none. No thread has such a number, nor the next.
const NOBODY: usize = usize::MAX;

/// Somebody has taken ownership away, and no barrier has been passed since.
const UNCERTAIN: usize = usize::MAX - 1;

/// Marks.
///
/// Nobody is inside, and the owner can take the short way.
const READY: u8 = 0;
/// A call is running, or somebody looks whether it can.
const INSIDE: u8 = 1;
/// Nobody is inside, and a call is to look at everything.
const UNREADY: u8 = 2;

/// How many owners an instance has at most, one after the other: a host that makes and frees instances on one thread and
/// uses them on another needs two for a run. Their numbers fit into the bits that are 0 in the number of a thread.
const OWNERS: usize = 4;

/// Whether a call is running on an instance.
#[repr(C)]
pub struct Guard {
    /// The owner's thread, and in its last bits how many owners there were before: no two owners have the same.
    owner: AtomicUsize,
    /// For each owner its mark: when it looks whether it still is the owner, it is inside already.
    owners: [AtomicU8; OWNERS],
    /// The mark of a thread that is not the owner; it is inside when it looks whether the owner is. What follows is written by that thread
    /// alone.
    other: AtomicU8,
    /// How often ownership has been taken away: the number of the next owner.
    losses: AtomicU8,
    /// The thread that was inside last without being the owner.
    last: AtomicUsize,
}

/// A call under way: its mark, to be taken away when it ends.
#[repr(transparent)]
pub struct Entered<'g>(&'g AtomicU8);

impl Entered<'_> {
    /// The call has ended; whether the next one can take the short way.
    #[inline(always)]
    pub fn leave(self, is_ready: bool) {
        self.0.store(if is_ready { READY } else { UNREADY }, Ordering::Release);
    }
}

impl Guard {
    /// Of an instance that nobody uses yet.
    pub const fn new() -> Self {
        Self {
            owner: AtomicUsize::new(NOBODY),
            owners: [const { AtomicU8::new(UNREADY) }; OWNERS],
            other: AtomicU8::new(UNREADY),
            losses: AtomicU8::new(0),
            last: AtomicUsize::new(NOBODY),
        }
    }

    /// Begins a call; `None` if one is running already: from within it, or on another thread.
    #[inline]
    pub fn enter(&self) -> Option<Entered<'_>> {
        let owner = self.owner.load(Ordering::Relaxed);
        let own = self.owners.get(owner ^ this_thread());
        own.and_then(|mark| if is_inside(mark) { None } else { self.enter_if_still(owner, mark) })
            .or_else(|| self.enter_as_any())
    }

    /// Begins a call if this thread is the owner, no call is running, and the instance is ready for the short way.
    #[inline(always)]
    pub fn enter_shortly(&self) -> Option<Entered<'_>> {
        if !HAS_BARRIER {
            return None;
        }
        let owner = self.owner.load(Ordering::Relaxed);
        let mark = self.owners.get(owner ^ this_thread())?;
        if mark.load(Ordering::Relaxed) != READY {
            return None;
        }
        self.enter_if_still(owner, mark)
    }

    /// Begins a call of the thread that was the `owner` a moment ago, if it still is, with its mark, which nobody else writes.
    #[inline(always)]
    fn enter_if_still<'g>(&'g self, owner: usize, mark: &'g AtomicU8) -> Option<Entered<'g>> {
        let entered = Entered(mark);
        mark.store(INSIDE, Ordering::Relaxed);
        // The compiler keeps the order. That the processor may not is what the other thread's barrier is for.
        compiler_fence(Ordering::SeqCst);
        if self.owner.load(Ordering::Relaxed) == owner {
            // What threads before this one did, it has seen when it became the owner.
            Some(entered)
        } else {
            // Nobody takes the short way with the mark of an owner of before, whatever it says.
            entered.leave(true);
            None
        }
    }

    /// Takes ownership away, whoever has it: no call takes the short way until one has ended that asks for everything.
    ///
    /// What has changed for that must be stored before, and loaded by who says that the instance is ready, both in the one order of all
    /// (`SeqCst`).
    pub fn disown(&self) {
        self.owner.store(UNCERTAIN, Ordering::SeqCst);
    }

    /// Begins a call of any thread.
    #[cold]
    #[inline(never)]
    fn enter_as_any(&self) -> Option<Entered<'_>> {
        let thread = this_thread();
        let owner = self.owner.load(Ordering::Relaxed);
        // The owner from within its own call loses nothing by it.
        if self.owners.get(owner ^ thread).is_some_and(is_inside) {
            return None;
        }
        if self.other.swap(INSIDE, Ordering::Acquire) == INSIDE {
            return None;
        }
        let entered = Entered(&self.other);
        if self.owner.load(Ordering::Relaxed) != NOBODY {
            self.owner.store(UNCERTAIN, Ordering::Relaxed);
            barrier();
            self.losses.store(self.losses.load(Ordering::Relaxed).saturating_add(1), Ordering::Relaxed);
            self.owner.store(NOBODY, Ordering::Relaxed);
        }
        if self.owners.iter().any(|mark| mark.load(Ordering::Acquire) == INSIDE) {
            entered.leave(false);
            return None;
        }
        let number = usize::from(self.losses.load(Ordering::Relaxed));
        let owner = thread | number;
        // A thread whose own number uses the last bits never owns anything.
        if let Some(mark) = self.owners.get(number)
            && owner ^ thread == number
            && self.last.load(Ordering::Relaxed) == thread
            && can_bar()
        {
            mark.store(INSIDE, Ordering::Relaxed);
            self.owner.store(owner, Ordering::SeqCst);
            // Whoever enters now sees both.
            entered.leave(false);
            return Some(Entered(mark));
        }
        self.last.store(thread, Ordering::Relaxed);
        Some(entered)
    }

    /// Whether a call is running. Of calls on other threads what is seen may be out of date.
    pub fn is_busy(&self) -> bool {
        self.owners.iter().chain([&self.other]).any(is_inside)
    }
}

/// Whether a mark says so. Of another thread's what is seen may be out of date.
fn is_inside(mark: &AtomicU8) -> bool {
    mark.load(Ordering::Relaxed) == INSIDE
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::UnsafeCell;
    use std::thread;

    /// Counted without atomic operations by whoever is inside.
    struct Counter {
        guard: Guard,
        value: UnsafeCell<u64>,
    }

    // SAFETY: the value is only used by who has entered: that is what is tested.
    unsafe impl Sync for Counter {}

    impl Counter {
        /// Counts `calls` times if it may; how often it did.
        fn count(&self, calls: u32) -> u64 {
            let mut counted = 0;
            for _ in 0..calls {
                if let Some(entered) = self.guard.enter() {
                    // SAFETY: nobody else is inside.
                    unsafe { *self.value.get() += 1 };
                    counted += 1;
                    entered.leave(true);
                }
            }
            counted
        }
    }

    fn counter() -> Counter {
        Counter { guard: Guard::new(), value: UnsafeCell::new(0) }
    }

    /// Two threads inside at once would lose counts. Many short races, because an instance has owners for a few changes only.
    #[test]
    fn threads_that_race_are_never_inside_together() {
        for round in 0..2000_u32 {
            let counter = counter();
            let counted: u64 = thread::scope(|scope| {
                let threads = [0, 1, 2].map(|i| {
                    let counter = &counter;
                    scope.spawn(move || counter.count(100 + 50 * ((round + i) % 3)))
                });
                threads.map(|thread| thread.join().unwrap()).into_iter().sum()
            });
            // SAFETY: all threads have ended.
            assert_eq!(unsafe { *counter.value.get() }, counted, "round {round}");
            assert!(!counter.guard.is_busy());
        }
    }

    /// One thread after the other is never refused, however often they change.
    #[test]
    fn threads_that_take_turns_always_enter() {
        let counter = counter();
        for turn in 1..=20 {
            assert_eq!(counter.count(3), 3, "turn {turn}");
            assert_eq!(thread::scope(|scope| scope.spawn(|| counter.count(3)).join().unwrap()), 3, "turn {turn}");
        }
    }

    /// While a call runs, neither its own thread gets in nor another one: whether it is the first call, or that of an owner, and also after
    /// another thread has tried.
    #[test]
    fn a_running_call_keeps_all_others_out() {
        for calls_before in 0..5 {
            let counter = counter();
            assert_eq!(counter.count(calls_before), u64::from(calls_before));
            let entered = counter.guard.enter().unwrap();
            for _ in 0..3 {
                assert!(counter.guard.is_busy());
                assert!(counter.guard.enter().is_none(), "its own thread, {calls_before}");
                assert_eq!(
                    thread::scope(|scope| scope.spawn(|| counter.count(3)).join().unwrap()),
                    0,
                    "{calls_before}"
                );
            }
            entered.leave(true);
            assert!(!counter.guard.is_busy());
            assert_eq!(counter.count(3), 3);
        }
    }

    /// The short way is open to the owner, if who left last has said so, until ownership is taken away.
    #[test]
    fn the_short_way_is_open_to_the_owner_of_what_is_ready() {
        let counter = counter();
        let guard = &counter.guard;
        let is_open = || guard.enter_shortly().map(|entered| entered.leave(true)).is_some();
        assert!(!is_open());
        counter.count(2);
        assert_eq!(is_open(), can_bar());
        assert!(!thread::scope(|scope| scope.spawn(is_open).join().unwrap()), "another thread");
        for is_ready in [false, true] {
            let entered = guard.enter().unwrap();
            assert!(!is_open(), "inside");
            entered.leave(is_ready);
            assert_eq!(is_open(), is_ready && can_bar());
        }
        guard.disown();
        assert!(!is_open());
        counter.count(2);
        assert_eq!(is_open(), can_bar());
    }

    /// A thread that calls again is the owner, where the system has barriers.
    #[test]
    fn a_thread_that_calls_again_is_the_owner_until_threads_have_changed_often() {
        let counter = counter();
        for turn in 0..=2 * OWNERS {
            counter.count(2);
            let owner = counter.guard.owner.load(Ordering::Relaxed);
            // Each turn but the first takes ownership away twice.
            let is_owner = can_bar() && 2 * turn < OWNERS;
            assert_eq!(owner == this_thread() + 2 * turn, is_owner, "turn {turn}");
            thread::scope(|scope| scope.spawn(|| counter.count(2)).join().unwrap());
        }
    }

    /// An owner that is stopped between its looks goes on when others have become owners: it neither gets in nor lets anybody in.
    #[test]
    fn an_owner_of_before_changes_nothing() {
        let counter = counter();
        counter.count(2);
        let guard = &counter.guard;
        let owner = guard.owner.load(Ordering::Relaxed);
        let Some(inside) = guard.owners.get(owner ^ this_thread()) else {
            assert!(!can_bar(), "no owner where there can be one");
            return;
        };
        thread::scope(|scope| {
            let next = scope.spawn(|| {
                counter.count(2);
                // Still inside when its thread ends.
                assert!(guard.enter().is_some());
            });
            next.join().unwrap();
            assert_ne!(guard.owner.load(Ordering::Relaxed), owner);
            assert!(guard.enter_if_still(owner, inside).is_none());
            assert!(guard.is_busy());
            assert_eq!(counter.count(3), 0);
            assert_eq!(scope.spawn(|| counter.count(3)).join().unwrap(), 0);
        });
    }
}

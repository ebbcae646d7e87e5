//! Steps that run one after the other beside those of a [`Runner`](crate::steps::Runner): most steps leave processors idle,
//! while one thing is linked, or the last test of a program runs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::output;
use crate::steps::Outcome;

/// What a step does.
pub type Action = Box<dyn FnOnce() -> Outcome + Send>;

/// A series of steps.
pub struct Beside {
    ended: Receiver<Ended>,
    stopped: Arc<AtomicBool>,
}

/// A step that has ended.
pub struct Ended {
    pub outcome: Outcome,
    pub duration: Duration,
    /// What it printed.
    pub output: Vec<u8>,
}

impl Beside {
    /// Begins with the first step. A failure is the end.
    pub fn begin(steps: Vec<Action>) -> Self {
        let stopped = Arc::new(AtomicBool::new(false));
        let (sender, ended) = channel();
        let stop = Arc::clone(&stopped);
        thread::spawn(move || {
            for action in steps {
                if stop.load(Ordering::Relaxed) {
                    return;
                }
                let start = Instant::now();
                let (outcome, output) = output::held(action);
                let failed = matches!(outcome, Outcome::Failed(_));
                if sender.send(Ended { outcome, duration: start.elapsed(), output }).is_err() || failed {
                    return;
                }
            }
        });
        Self { ended, stopped }
    }

    /// Lets no further step begin.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Waits for the next step; nothing if there is none, or none any more.
    pub fn next(&self) -> Option<Ended> {
        self.ended.recv().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_come_in_their_order_and_a_failure_is_the_last() {
        let step = |text: &'static str, outcome| -> Action {
            Box::new(move || {
                output::line(text);
                outcome
            })
        };
        let failed = || Outcome::Failed("broken".into());
        let beside =
            Beside::begin(vec![step("one", Outcome::Passed), step("two", failed()), step("three", Outcome::Passed)]);
        let [one, two] = [(); 2].map(|()| beside.next().unwrap());
        assert_eq!((one.outcome, one.output), (Outcome::Passed, b"one\n".to_vec()));
        assert_eq!((two.outcome, two.output), (failed(), b"two\n".to_vec()));
        assert!(beside.next().is_none());
    }

    #[test]
    fn what_has_begun_ends_and_nothing_begins_after_a_stop() {
        let (go, wait) = channel();
        let (say, begun) = channel();
        let first: Action = Box::new(move || {
            say.send(()).unwrap();
            wait.recv().unwrap();
            Outcome::Passed
        });
        let beside = Beside::begin(vec![first, Box::new(|| unreachable!("it was stopped"))]);
        begun.recv().unwrap();
        beside.stop();
        go.send(()).unwrap();
        assert_eq!(beside.next().unwrap().outcome, Outcome::Passed);
        assert!(beside.next().is_none());
    }
}

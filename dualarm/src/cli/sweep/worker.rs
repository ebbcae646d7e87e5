//! `dualarm sweep --worker`: makes the runs that another program requests.

use std::io::BufRead;
use std::sync::mpsc;
use std::thread;

use serde::Serialize;

use super::{Arguments, Workshop};
use crate::cli::{Failure, print_result, process};
use crate::sweep::pool;
use crate::sweep::process::Greeting;

/// Answers each line with a run's number by its row, until standard input ends.
pub fn serve(arguments: &Arguments) -> Result<(), Failure> {
    let (sender, lines) = mpsc::channel();
    // The requesting program may end while a run hangs. This process therefore ends as soon as its standard input ends,
    // during a run too.
    thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
        process::leave(0)
    });
    let workshop = arguments.plan().map_err(Failure::from).and_then(|plan| {
        let limit = arguments.limit()?;
        super::workshop(arguments, &plan, limit)
    });
    let (workshop, ready) = match workshop {
        Ok(found) => found,
        Err(failure) => {
            say(&Greeting::Failure { message: failure.message.clone(), usage: failure.code == 2 })?;
            return Err(failure);
        }
    };
    let runs = ready.runs;
    say(&Greeting::Ready(ready))?;
    let mut inner = None;
    for line in lines {
        let run = line.trim().parse().ok().filter(|run| *run < runs);
        let Some(run) = run else {
            return Err(Failure::usage(format!("{line:?} is no run of this study")));
        };
        match &workshop {
            Workshop::Threads(bench) => {
                let file = arguments.trajectories.as_deref().map(|folder| pool::trajectory(folder, run));
                say(&bench.run(run, file.as_deref()))?;
            }
            Workshop::Processes(program) => say(&program.run(&mut inner, run)?)?,
        }
    }
    Ok(())
}

fn say(what: &impl Serialize) -> Result<(), Failure> {
    print_result(&(serde_json::to_string(what).map_err(Failure::failed)? + "\n"));
    Ok(())
}

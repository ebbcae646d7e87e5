//! Loads an FMU, steps it over the experiment it suggests and prints its outputs at the end:
//! `cargo run --release -p fmi2-import --example step -- model.fmu`.

use std::error::Error;
use std::path::Path;

use fmi2_import::{Causality, Experiment, Fmu, Value};

/// The outputs at the stop time, by name.
///
/// # Errors
/// When the FMU cannot be opened, or refuses a call.
pub fn run(path: &Path) -> Result<Vec<(String, Value)>, Box<dyn Error>> {
    let fmu = Fmu::open(path)?;
    let suggested = fmu.description().default_experiment;
    let (stop, step) = (suggested.stop_time.unwrap_or(1.0), suggested.step_size.unwrap_or(1e-2));
    let mut slave = fmu.instantiate("slave")?;
    slave.setup_experiment(Experiment { stop: Some(stop), ..Experiment::default() })?;
    slave.enter_initialization_mode()?;
    slave.exit_initialization_mode()?;
    let mut steps = 0.0;
    while (steps + 0.5) * step < stop {
        slave.do_step(steps * step, step)?;
        steps += 1.0;
    }
    let outputs = fmu.description().with_causality(Causality::Output);
    Ok(outputs
        .map(|output| Ok((output.name.clone(), slave.get(output)?)))
        .collect::<Result<_, fmi2_import::CallError>>()?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("usage: step FILE.fmu")?;
    for (name, value) in run(Path::new(&path))? {
        println!("{name} = {value}");
    }
    Ok(())
}

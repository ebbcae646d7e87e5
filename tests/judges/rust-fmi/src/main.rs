//! Runs plant and controller with the `fmi` crate of rust-fmi, wired by equal names, and prints a CSV table.
//!
//! ```text
//! rust-fmi-judge <PLANT.fmu> <CONTROLLER.fmu> <gauss-seidel | jacobi | exchange> <STEP> <STEPS>
//! ```
//!
//! With `exchange` it integrates both as one system by model exchange: see the module of that name.
//!
//! Numbers are printed so that they read back as the same double. The table is for comparison with another importer
//! that makes the same calls in the same order, so nothing is rounded or interpolated. Half way through, both states are
//! serialised and the run goes on in new instances that were given the bytes.

mod exchange;

use std::collections::HashMap;
use std::fmt::Write as _;
use std::process::ExitCode;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::schema::fmi2::{Causality, ScalarVariable, ScalarVariableElement};
use fmi::traits::{FmiImport, FmiStatus};

type Anyhow<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(table) => {
            print!("{table}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &[String]) -> Anyhow<String> {
    let [plant, controller, coupling, step, steps] = arguments else {
        return Err("usage: rust-fmi-judge PLANT.fmu CONTROLLER.fmu gauss-seidel|jacobi|exchange STEP STEPS".into());
    };
    let (step, steps): (f64, u32) = (step.parse()?, steps.parse()?);
    let imports: [Fmi2Import; 2] = [fmi::import::from_path(plant)?, fmi::import::from_path(controller)?];
    if coupling == "exchange" {
        return exchange::run(&imports, step, steps);
    }
    let mut slaves = [Slave::new(&imports[0])?, Slave::new(&imports[1])?];
    let wires = [Wire::new(&slaves[0], &slaves[1]), Wire::new(&slaves[1], &slaves[0])];
    let jacobi = match coupling.as_str() {
        "jacobi" => true,
        "gauss-seidel" => false,
        other => return Err(format!("unknown coupling {other}").into()),
    };

    let steps_per_second = step.recip().round();
    if (steps_per_second * step - 1.0).abs() > 1e-12 {
        return Err(format!("{step} s is no whole fraction of a second").into());
    }
    initialize(&mut slaves, &wires, f64::from(steps) * step)?;
    let mut table = String::from("time");
    for slave in &slaves {
        for name in &slave.output_names {
            let _ = write!(table, ",{name}");
        }
    }
    table.push('\n');
    let mut signals = [wires[0].fetch(&mut slaves)?, wires[1].fetch(&mut slaves)?];
    for i in 0..=steps {
        // The decimal fraction itself, as the harness has it: 0.0003, not 3 * 1e-4.
        let time = f64::from(i) / steps_per_second;
        if jacobi {
            signals = [wires[0].fetch(&mut slaves)?, wires[1].fetch(&mut slaves)?];
        }
        for (wire, values) in wires.iter().zip(&signals).rev() {
            wire.hand_over(&mut slaves, values)?;
        }
        write_row(&mut table, time, &mut slaves)?;
        if i == steps {
            break;
        }
        if i == steps / 2 {
            for (slave, import) in slaves.iter_mut().zip(&imports) {
                slave.move_on(import)?;
            }
        }
        if jacobi {
            for slave in &slaves {
                slave.instance.do_step(time, step, true)?;
            }
        } else {
            // The plant steps first; wire 0 leads from it to the controller, wire 1 back.
            slaves[0].instance.do_step(time, step, true)?;
            signals[0] = wires[0].fetch(&mut slaves)?;
            wires[0].hand_over(&mut slaves, &signals[0])?;
            slaves[1].instance.do_step(time, step, true)?;
            signals[1] = wires[1].fetch(&mut slaves)?;
        }
    }
    for slave in &mut slaves {
        slave.instance.terminate()?;
    }
    Ok(table)
}

/// Names and value references of all real inputs or outputs.
fn reals(import: &Fmi2Import, causality: Causality) -> Vec<(String, u32)> {
    let variables = &import.model_description().model_variables.variables;
    let wanted = |variable: &&ScalarVariable| {
        variable.causality == causality && matches!(variable.elem, ScalarVariableElement::Real(_))
    };
    variables.iter().filter(wanted).map(|v| (v.name.clone(), v.value_reference)).collect()
}

/// One FMU as rust-fmi sees it.
struct Slave {
    instance: InstanceCS,
    inputs: HashMap<String, u32>,
    output_names: Vec<String>,
    outputs: Vec<u32>,
}

impl Slave {
    fn new(import: &Fmi2Import) -> Anyhow<Self> {
        let (output_names, outputs) = reals(import, Causality::Output).into_iter().unzip();
        Ok(Self {
            instance: InstanceCS::new(import, &import.model_description().model_name, false, true)?,
            inputs: reals(import, Causality::Input).into_iter().collect(),
            output_names,
            outputs,
        })
    }

    /// Leaves the instance for a new one in the same state, by way of bytes.
    fn move_on(&mut self, import: &Fmi2Import) -> Anyhow<()> {
        let state = self.instance.get_fmu_state()?;
        let bytes = self.instance.serialize_fmu_state(&state)?;
        let mut heir = InstanceCS::new(import, "heir", false, true)?;
        let state = heir.deserialize_fmu_state(&bytes)?;
        heir.set_fmu_state(&state).ok()?;
        self.instance = heir;
        Ok(())
    }
}

/// All signals from one slave to the other.
struct Wire {
    from_plant: bool,
    sources: Vec<u32>,
    sinks: Vec<u32>,
}

impl Wire {
    fn new(from: &Slave, to: &Slave) -> Self {
        let (sources, sinks) = from
            .output_names
            .iter()
            .zip(&from.outputs)
            .filter_map(|(name, source)| to.inputs.get(name).map(|sink| (*source, *sink)))
            .unzip();
        Self { from_plant: from.inputs.contains_key("tau1_cmd"), sources, sinks }
    }

    fn fetch(&self, slaves: &mut [Slave; 2]) -> Anyhow<Vec<f64>> {
        let mut values = vec![0.0; self.sources.len()];
        slaves[usize::from(!self.from_plant)].instance.get_real(&self.sources, &mut values)?;
        Ok(values)
    }

    fn hand_over(&self, slaves: &mut [Slave; 2], values: &[f64]) -> Anyhow<()> {
        slaves[usize::from(self.from_plant)].instance.set_real(&self.sinks, values)?;
        Ok(())
    }
}

/// Exchanges the initial signals until nothing changes.
fn initialize(slaves: &mut [Slave; 2], wires: &[Wire; 2], stop: f64) -> Anyhow<()> {
    for slave in slaves.iter_mut() {
        slave.instance.setup_experiment(None, 0.0, Some(stop))?;
        slave.instance.enter_initialization_mode()?;
    }
    let mut last = Vec::new();
    for _ in 0..100 {
        let mut signals = Vec::new();
        for wire in wires {
            let values = wire.fetch(slaves)?;
            wire.hand_over(slaves, &values)?;
            signals.extend(values);
        }
        if signals == last {
            for slave in slaves.iter_mut() {
                slave.instance.exit_initialization_mode()?;
            }
            return Ok(());
        }
        last = signals;
    }
    Err("the initial signals do not settle".into())
}

fn write_row(table: &mut String, time: f64, slaves: &mut [Slave; 2]) -> Anyhow<()> {
    let _ = write!(table, "{time:?}");
    for slave in slaves {
        let mut values = vec![0.0; slave.outputs.len()];
        slave.instance.get_real(&slave.outputs, &mut values)?;
        for value in values {
            let _ = write!(table, ",{value:?}");
        }
    }
    table.push('\n');
    Ok(())
}

//! Plant and controller as one system of differential equations, by model exchange.
//!
//! The classical Runge-Kutta method in steps of one size, events at their ends, in the order of operations of the tests' own
//! hosts in Python and C, so the results are equal to the bit.

use std::collections::HashMap;
use std::fmt::Write as _;

use fmi::EventFlags;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{Common, InstanceME, ModelExchange};
use fmi::schema::fmi2::Causality;
use fmi::traits::FmiImport;

use crate::{Anyhow, reals};

/// Integrates; a table of the time and all real outputs after each step.
pub fn run(imports: &[Fmi2Import; 2], size: f64, steps: u32) -> Anyhow<String> {
    let mut grasp = Grasp::new(imports)?;
    let mut z = grasp.start(f64::from(steps) * size)?;
    let mut sides = grasp.sides()?;
    let mut table = String::from("time");
    for name in grasp.models.iter().flat_map(|model| &model.output_names) {
        let _ = write!(table, ",{name}");
    }
    table.push('\n');
    for step in 0..steps {
        let time = f64::from(step) * size;
        let half = time + size / 2.0;
        let along = |h: f64, k: &[f64]| z.iter().zip(k).map(|(z, k)| z + h * k).collect::<Vec<f64>>();
        let k1 = grasp.rates(time, &z)?;
        let k2 = grasp.rates(half, &along(size / 2.0, &k1))?;
        let k3 = grasp.rates(half, &along(size / 2.0, &k2))?;
        let k4 = grasp.rates(time + size, &along(size, &k3))?;
        for (i, z) in z.iter_mut().enumerate() {
            *z += size / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
        grasp.put(time + size, &z)?;
        let now = grasp.sides()?;
        let wishes_event = grasp.step_completed()?;
        if now != sides || wishes_event {
            for model in &mut grasp.models {
                model.instance.enter_event_mode()?;
            }
            z = grasp.update()?;
        }
        sides = grasp.sides()?;
        grasp.write_row(&mut table, time + size)?;
    }
    for model in &mut grasp.models {
        model.instance.terminate()?;
    }
    Ok(table)
}

/// One FMU.
struct Model {
    instance: InstanceME,
    states: usize,
    indicators: usize,
    output_names: Vec<String>,
    outputs: Vec<u32>,
    /// Outputs, in the order of the declarations, and the other's inputs of these names.
    wire: (Vec<u32>, Vec<u32>),
}

/// Plant and controller.
struct Grasp {
    models: [Model; 2],
}

impl Grasp {
    fn new(imports: &[Fmi2Import; 2]) -> Anyhow<Self> {
        let model = |import: &Fmi2Import, other: &Fmi2Import| -> Anyhow<Model> {
            let description = import.model_description();
            let sinks: HashMap<String, u32> = reals(other, Causality::Input).into_iter().collect();
            let outputs = reals(import, Causality::Output);
            let wire = outputs.iter().filter_map(|(name, source)| Some((*source, *sinks.get(name)?))).unzip();
            let (output_names, outputs) = outputs.into_iter().unzip();
            Ok(Model {
                instance: InstanceME::new(import, &description.model_name, false, true)?,
                states: description.model_structure.derivatives.unknowns.len(),
                indicators: description.number_of_event_indicators.unwrap_or(0) as usize,
                output_names,
                outputs,
                wire,
            })
        };
        Ok(Self { models: [model(&imports[0], &imports[1])?, model(&imports[1], &imports[0])?] })
    }

    /// Initialises both with each other's outputs; the initial states.
    fn start(&mut self, stop: f64) -> Anyhow<Vec<f64>> {
        for model in &mut self.models {
            model.instance.setup_experiment(None, 0.0, Some(stop))?;
            model.instance.enter_initialization_mode()?;
        }
        self.exchange()?;
        for model in &mut self.models {
            model.instance.exit_initialization_mode()?;
        }
        self.update()
    }

    /// Measurements to the controller, commands back.
    fn exchange(&mut self) -> Anyhow<()> {
        for from in 0..2 {
            let (sources, sinks) = self.models[from].wire.clone();
            let mut values = vec![0.0; sources.len()];
            self.models[from].instance.get_real(&sources, &mut values)?;
            self.models[1 - from].instance.set_real(&sinks, &values)?;
        }
        Ok(())
    }

    fn put(&mut self, time: f64, z: &[f64]) -> Anyhow<()> {
        let (first, second) = z.split_at(self.models[0].states);
        for (model, states) in self.models.iter_mut().zip([first, second]) {
            model.instance.set_time(time)?;
            model.instance.set_continuous_states(states)?;
        }
        self.exchange()
    }

    fn rates(&mut self, time: f64, z: &[f64]) -> Anyhow<Vec<f64>> {
        self.put(time, z)?;
        let mut all = Vec::with_capacity(z.len());
        for model in &mut self.models {
            let mut rates = vec![0.0; model.states];
            model.instance.get_derivatives(&mut rates)?;
            all.append(&mut rates);
        }
        Ok(all)
    }

    /// On which side of zero the event indicators are.
    fn sides(&mut self) -> Anyhow<Vec<bool>> {
        let mut all = Vec::new();
        for model in &mut self.models {
            let mut values = vec![0.0; model.indicators];
            if !model.instance.get_event_indicators(&mut values)? {
                return Err("the event indicators cannot be computed".into());
            }
            all.extend(values.into_iter().map(|value| value > 0.0));
        }
        Ok(all)
    }

    /// Whether a model wants event mode.
    fn step_completed(&mut self) -> Anyhow<bool> {
        let mut wanted = false;
        for model in &mut self.models {
            let (mut event, mut end) = (false, false);
            model.instance.completed_integrator_step(true, &mut event, &mut end)?;
            if end {
                return Err("a model wants to end the simulation".into());
            }
            wanted |= event;
        }
        Ok(wanted)
    }

    /// From event mode to continuous-time mode, with new discrete states; the continuous states then.
    fn update(&mut self) -> Anyhow<Vec<f64>> {
        for model in &mut self.models {
            let mut flags = EventFlags { discrete_states_need_update: true, ..EventFlags::default() };
            while flags.discrete_states_need_update {
                model.instance.new_discrete_states(&mut flags)?;
                if flags.terminate_simulation {
                    return Err("a model wants to end the simulation".into());
                }
            }
            model.instance.enter_continuous_time_mode()?;
        }
        self.exchange()?;
        let mut all = Vec::new();
        for model in &mut self.models {
            let mut states = vec![0.0; model.states];
            model.instance.get_continuous_states(&mut states)?;
            all.append(&mut states);
        }
        Ok(all)
    }

    fn write_row(&mut self, table: &mut String, time: f64) -> Anyhow<()> {
        let _ = write!(table, "{time:?}");
        for model in &mut self.models {
            let mut values = vec![0.0; model.outputs.len()];
            model.instance.get_real(&model.outputs, &mut values)?;
            for value in values {
                let _ = write!(table, ",{value:?}");
            }
        }
        table.push('\n');
        Ok(())
    }
}

//! The plant as an FMU: when it is made, stepped and read, and what is warned of. Its variables: [`variables`]; what it
//! remembers of lost contact: [`grip`].

mod exchange;
mod grip;
mod saved;
mod variables;

use std::fmt;

use fmi2_export::{Conclusion, Declare, DefaultExperiment, Experiment, Failure, Info, Model, Step, Variables};
use grasp_plant::{
    Contact, DEFLECTION_POINTS, Direct, Inputs, Measured, Parameters, Plant, Rates, StepError, Uncertainty,
};
use serde::{Deserialize, Serialize};

use exchange::{Continuous, ORDER};
use grip::Grip;
use variables::{ActuatorChoice, ContactChoice};

/// `DualArmPlant.fmu`.
#[derive(Serialize, Deserialize)]
#[repr(C)] // What every step needs side by side: from the measured outputs to the first half of the plant.
pub struct DualArmPlant {
    parameters: Parameters,
    actuator_model: ActuatorChoice,
    contact_model: ContactChoice,
    /// The plant of the run before a reset: one of equal parameters takes over what was computed for it.
    #[serde(skip)]
    before: Option<Box<Plant>>,
    /// What a host that integrates may look at, from when one does.
    #[serde(skip)]
    continuous: Option<Box<Continuous>>,
    /// What the host may look at.
    #[serde(skip)]
    outputs: Outputs,
    inputs: Inputs,
    /// Slopes of the inputs over the next step.
    input_rates: Inputs,
    /// The plant, once there is a start.
    #[serde(with = "saved::plant")]
    plant: Option<Plant>,
    /// When and where contact was lost in this run.
    grip: Grip,
    /// Whether that has been said.
    told_of_contact: bool,
    /// When the run ends, if the host has said so \[s\].
    stop_time: Option<f64>,
    /// Whether the user knows that actuators are mostly at their limits in this run.
    told_of_limits: bool,
    /// For how much longer an actuator has been at its limits than none \[s\]; never negative.
    time_at_limits: f64,
}

/// Values of the output variables, each part filled in by the evaluation of its name.
#[derive(Clone, Default)]
#[repr(C)] // Last what a controller reads in every step: see `DualArmPlant`.
struct Outputs {
    /// Time derivatives, from when a host asks for them.
    rates: Option<Box<Rates>>,
    deflection: [[f64; DEFLECTION_POINTS]; 2],
    shape: Shape,
    contact: Contact,
    impacts: [i32; 2],
    in_contact: bool,
    pressing: [bool; 2],
    direct: Direct,
    uncertainty: Uncertainty,
    measured: Measured,
}

/// Outputs that are for looking at rather than for feeding back.
#[derive(Clone, Default)]
struct Shape {
    tip_deflection: [f64; 2],
    constraint: [f64; 2],
    energy: f64,
    supplied_energy: f64,
}

impl Default for DualArmPlant {
    fn default() -> Self {
        Self {
            parameters: Parameters { order: ORDER, ..Parameters::default() },
            actuator_model: ActuatorChoice::default(),
            contact_model: ContactChoice::default(),
            before: None,
            continuous: None,
            outputs: Outputs::default(),
            inputs: Inputs::ZERO,
            input_rates: Inputs::ZERO,
            plant: None,
            grip: Grip::default(),
            told_of_contact: false,
            stop_time: None,
            told_of_limits: false,
            time_at_limits: 0.0,
        }
    }
}

impl Outputs {
    fn rates(&mut self) -> &mut Rates {
        self.rates.get_or_insert_with(Box::default)
    }

    /// Takes the change of all outputs along a direction.
    fn change(&mut self, change: &Rates) {
        (self.measured, self.direct) = (change.measured, change.direct);
        (self.uncertainty, self.deflection) = (change.uncertainty, change.deflection);
        self.contact = change.contact;
        self.shape = Shape {
            tip_deflection: change.tip_deflection,
            constraint: change.constraint,
            energy: change.energy,
            supplied_energy: change.supplied_energy,
        };
    }
}

impl DualArmPlant {
    /// So much more time at the limits than inside them is worth a warning \[s\]. A loop that regulates needs its limits for a
    /// transient of tenths of a second; one that diverges is thrown from limit to limit and stays there.
    const LONG: f64 = 0.5;
    /// What the actuators at their limits are called, by the sum of 1, 2 and 4: no memory is asked for in a step.
    const LIMITED: [&str; 8] = ["", "tau1", "tau2", "tau1, tau2", "u", "tau1, u", "tau2, u", "tau1, tau2, u"];

    /// Whether the run ends with the step of this size that ends at `time`, so that it is time to say what became of the contacts: not only
    /// when it is terminated, which not every host does and after which few listen.
    #[inline]
    fn is_over(&self, time: f64, size: f64) -> bool {
        self.stop_time.is_some_and(|stop| time > stop - 0.5 * size)
    }

    /// The parameters as the host has set them.
    fn parameters(&self) -> Parameters {
        Parameters {
            actuator_model: self.actuator_model.0,
            contact_model: self.contact_model.0,
            ..self.parameters.clone()
        }
    }

    /// Adds up for how long actuators have been at their limits, of which one may be during this step.
    #[cold]
    #[inline(never)]
    fn watch_limits(&mut self, step: &mut Step<'_>, is_limited: bool) {
        if !is_limited {
            self.time_at_limits = (self.time_at_limits - step.size).max(0.0);
            return;
        }
        self.time_at_limits += step.size;
        if self.told_of_limits || self.time_at_limits < Self::LONG {
            return;
        }
        self.told_of_limits = true;
        let time = step.time + step.size;
        let Some(plant) = &self.plant else { return };
        let [first, second, object] = plant.limited(&self.inputs).map(usize::from);
        let names = Self::LIMITED[first + 2 * second + 4 * object];
        step.warn(format_args!(
            "at t = {time} s actuators ({names}) have been at their limits for {} s longer than inside them: there they do not \
             answer their controller. The loop may be unstable at this communication step (a shorter one may help), or an \
             actuator too weak. This is said once in a run",
            Self::LONG
        ));
    }

    /// Says once where and when contact was lost.
    #[cold]
    #[inline(never)]
    fn tell_of_contact(&mut self, warn: &mut dyn FnMut(fmt::Arguments<'_>)) {
        if let Some(plant) = &self.plant
            && !self.told_of_contact
            && let Some(summary) = self.grip.summary(plant)
        {
            self.told_of_contact = true;
            warn(format_args!("{summary}"));
        }
    }

    fn measured(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.measured = plant.measured();
        }
    }

    fn direct(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.direct = plant.direct(&self.inputs);
            self.outputs.in_contact = self.outputs.direct.in_contact();
        }
    }

    fn pressing(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.pressing = plant.contact_force(&self.inputs).map(|force| force > 0.0);
        }
    }

    fn contact(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.contact = plant.contact();
            let impacts = plant.state().contact.as_deref().map_or([0; 2], |contact| contact.impacts);
            self.outputs.impacts = impacts.map(|impacts| i32::try_from(impacts).unwrap_or(i32::MAX));
        }
    }

    /// Separate from the shape: a controller may read the rates of the root moments in every step and needs no energies.
    fn uncertainty(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.uncertainty = plant.uncertainty();
        }
    }

    fn shape(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.shape = Shape {
                tip_deflection: plant.tip_deflection(),
                constraint: plant.constraint(),
                energy: plant.energy(),
                supplied_energy: plant.supplied_energy(),
            };
        }
    }

    fn deflection(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.deflection = plant.deflection();
        }
    }

    fn rates(&mut self) {
        if let Some(plant) = &self.plant {
            *self.outputs.rates() = plant.rates(&self.inputs, &self.input_rates);
        }
    }
}

impl Declare for DualArmPlant {
    const INFO: Info = Info {
        name: "DualArmPlant",
        description: "Two flexible one-link arms (Euler-Bernoulli beams on motor hubs) grasping an object",
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 2.0, step_size: 1e-4, tolerance: None },
        directional_derivatives: true,
        ..fmi2_export::cargo_info!()
    };

    fn variables(variables: &mut Variables<Self>) {
        variables::declare(variables);
    }
}

impl Model for DualArmPlant {
    fn initialize(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        (self.grip, self.told_of_contact) = (Grip::from(experiment.start_time), false);
        self.stop_time = experiment.stop_time;
        (self.told_of_limits, self.time_at_limits) = (false, 0.0);
        let parameters = self.parameters();
        match self.plant.as_mut().or(self.before.as_deref_mut()) {
            Some(plant) if *plant.parameters() == parameters => {
                plant.reset();
                self.plant = self.plant.take().or(self.before.take().map(|before| *before));
            }
            _ => self.plant = Some(Plant::new(parameters).map_err(Failure::error)?),
        }
        // Kept until now: of a plant that differs in its start alone the new one shares the matrices.
        self.before = None;
        Ok(())
    }

    fn inherit(&mut self, before: Self) {
        self.before = before.plant.map(Box::new).or(before.before);
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        let Some(plant) = &mut self.plant else { return Err(no_start()) };
        plant.step(step.size, &self.inputs, &self.input_rates).map_err(discarded)?;
        let is_limited = plant.was_any_limited();
        let time = step.time + step.size;
        let size = self.grip.passed(time);
        if plant.may_have_pulled() {
            self.grip.look(time, size, plant, &self.inputs);
        }
        if self.is_over(time, size) {
            self.tell_of_contact(&mut |said| step.warn(said));
        }
        if is_limited || self.time_at_limits > 0.0 {
            self.watch_limits(step, is_limited);
        }
        Ok(())
    }

    fn conclude(&mut self, conclusion: &mut Conclusion<'_>) {
        self.tell_of_contact(&mut |said| conclusion.warn(said));
    }

    fn restored(&mut self) -> Result<(), Failure> {
        // In initialization mode the parameters may have changed since the plant was made; it will be made anew then.
        let parameters = self.parameters();
        self.plant.take_if(|plant| *plant.parameters() != parameters);
        let Some(plant) = &self.plant else { return Ok(()) };
        let lambda = plant.direct(&self.inputs).lambda;
        if !(plant.energy().is_finite() && lambda.iter().all(|value| value.is_finite())) {
            return Err(Failure::error("the plant in the state has energy or forces that are not finite"));
        }
        Ok(())
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        if let Some(plant) = &self.plant {
            direction.outputs.direct = plant.direct_derivative(&self.inputs, &direction.inputs);
        }
    }
}

#[cold]
#[inline(never)]
fn no_start() -> Failure {
    Failure::error("the plant has no start yet")
}

#[cold]
#[inline(never)]
fn discarded(error: StepError) -> Failure {
    Failure::discard(error)
}

fmi2_export::export!(DualArmPlant);

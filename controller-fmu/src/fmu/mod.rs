//! The controllers as FMUs: one interface, three laws.

use std::f64::consts::PI;

use fmi2_export::{
    Declare, DefaultExperiment, Evaluation, Experiment, Failure, Info, Model, Step, VariableBuilder, Variables,
};
use grasp_control::parameter::{Parameter, ParameterError};
use grasp_control::{Arms, Commands, Errors, Inputs, Law, Targets, inner};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

mod nabfc_controller;
mod pd_controller;
mod pds_controller;

pub use nabfc_controller::NabfcController;
pub use pd_controller::PdController;
pub use pds_controller::PdsController;

/// The longest step a controller takes \[s\], some thirty years: the products of step size and state stay finite. Far
/// longer ones would end in NaN.
const LONGEST_STEP: f64 = 1e9;

/// What makes a law an FMU.
pub trait FmuLaw: Law + Clone + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// What its user can set besides the properties of the arms.
    type Settings: Clone + Default + Serialize + DeserializeOwned + Send + Sync + 'static;
    /// Outputs it has besides those that all controllers share.
    type Extra: Clone + Default + Send + Sync + 'static;

    /// Name of the FMU.
    const NAME: &'static str;
    /// One line on what it is.
    const DESCRIPTION: &'static str;
    /// Measurements that `u_cmd` depends on, besides the position, the velocity and the shears of all laws.
    const FORCE_ALSO_DEPENDS_ON: &'static [&'static str] = &[];

    /// The law with these settings, in its initial state.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    fn create(arms: Arms, settings: &Self::Settings) -> Result<Self, ParameterError>;

    /// Changes the settings while the law runs; its state stays.
    ///
    /// # Errors
    /// The first parameter that is not in its range; the law is then as before.
    fn retune(&mut self, settings: &Self::Settings) -> Result<(), ParameterError>;

    /// Whether this law has the arms and the settings of another one, whatever its state.
    fn is_like(&self, other: &Self) -> bool;

    /// Declares the settings.
    fn declare_settings(variables: &mut Variables<Controller<Self>>);

    /// Declares the extra outputs, if there are any; `rates` computes their time derivatives.
    fn declare_extra(variables: &mut Variables<Controller<Self>>, rates: Evaluation) {
        let _ = (variables, rates);
    }

    /// The extra outputs for these inputs.
    fn extra(&self, inputs: &Inputs) -> Self::Extra {
        let _ = inputs;
        Self::Extra::default()
    }

    /// Time derivatives of the extra outputs, for inputs that change at `rates`.
    fn extra_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Self::Extra {
        let _ = (inputs, rates);
        Self::Extra::default()
    }

    /// Change of the extra outputs along a direction of the inputs.
    fn extra_derivative(&self, direction: &Inputs) -> Self::Extra {
        let _ = direction;
        Self::Extra::default()
    }
}

/// A controller FMU.
#[derive(Clone, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Controller<L: FmuLaw> {
    arms: Arms,
    settings: L::Settings,
    inputs: Inputs,
    /// Slopes of the inputs over the next step.
    input_rates: Inputs,
    /// The law, once there is a start.
    law: Option<L>,
    /// What the host may look at.
    #[serde(skip)]
    outputs: Outputs<L::Extra>,
    /// Time derivatives of the outputs.
    #[serde(skip)]
    rates: Outputs<L::Extra>,
}

/// Values of the output variables.
#[derive(Clone, Default)]
struct Outputs<X> {
    commands: Commands,
    targets: Targets,
    errors: Errors,
    extra: X,
}

impl<L: FmuLaw> Default for Controller<L> {
    fn default() -> Self {
        Self {
            arms: Arms::default(),
            settings: L::Settings::default(),
            inputs: Inputs::default(),
            input_rates: Inputs::HELD,
            law: None,
            outputs: Outputs::default(),
            rates: Outputs::default(),
        }
    }
}

impl<L: FmuLaw> Controller<L> {
    fn commands(&mut self) {
        if let Some(law) = &mut self.law {
            self.outputs.commands = law.commands(&self.inputs);
        }
    }

    fn targets(&mut self) {
        self.outputs.targets = self.arms.targets(&self.inputs.reference);
        self.outputs.errors = self.arms.errors(&self.inputs);
    }

    fn extra(&mut self) {
        if let Some(law) = &self.law {
            self.outputs.extra = law.extra(&self.inputs);
        }
    }

    fn rates(&mut self) {
        (self.rates.targets, self.rates.errors) = target_change(&self.arms, &self.input_rates);
        if let Some(law) = &mut self.law {
            self.rates.commands = law.command_rates(&self.inputs, &self.input_rates);
            self.rates.extra = law.extra_rates(&self.inputs, &self.input_rates);
        }
    }
}

/// Change of targets and errors, which are affine in the inputs, for a change of the inputs.
fn target_change(arms: &Arms, change: &Inputs) -> (Targets, Errors) {
    let change = change.to_array();
    let (targets, errors) = (arms.target_jacobian(), arms.error_jacobian());
    (
        Targets {
            lambda: targets.lambda.map(|row| inner(&row, &change)),
            theta: targets.theta.map(|row| inner(&row, &change)),
            y_object: inner(&targets.y_object, &change),
        },
        Errors { e: errors.e.map(|row| inner(&row, &change)), p: inner(&errors.p, &change) },
    )
}

impl<L: FmuLaw> Declare for Controller<L> {
    const INFO: Info = Info {
        name: L::NAME,
        description: L::DESCRIPTION,
        version: env!("CARGO_PKG_VERSION"),
        license: env!("CARGO_PKG_LICENSE"),
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 2.0, step_size: 1e-4, tolerance: None },
        directional_derivatives: true,
        ..Info::new()
    };

    fn variables(variables: &mut Variables<Self>) {
        inputs(variables);
        let rates = variables.evaluation(Self::rates);
        command_outputs(variables, rates);
        target_outputs(variables, rates);
        L::declare_extra(variables, rates);
        declare(variables, &Arms::PARAMETERS, false, |m| &mut m.arms);
        L::declare_settings(variables);
    }
}

impl<L: FmuLaw> Model for Controller<L> {
    fn initialize(&mut self, _experiment: &Experiment) -> Result<(), Failure> {
        let mut law = L::create(self.arms, &self.settings).map_err(Failure::error)?;
        law.initialize(&self.inputs);
        self.law = Some(law);
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        let law = self.law.as_mut().ok_or_else(|| Failure::error("the controller has no start yet"))?;
        if step.size > LONGEST_STEP {
            return Err(Failure::discard(format!(
                "step size {:e} s is longer than {LONGEST_STEP:e} s, the longest of a controller",
                step.size
            )));
        }
        law.step(step.size, &self.inputs, &self.input_rates).map_err(Failure::discard)
    }

    fn retuned(&mut self) -> Result<(), Failure> {
        match &mut self.law {
            Some(law) => law.retune(&self.settings).map_err(Failure::error),
            None => Ok(()),
        }
    }

    fn restored(&mut self) -> Result<(), Failure> {
        // Checks the settings, too; inputs and their slopes have been checked.
        let like_new = L::create(self.arms, &self.settings).map_err(Failure::error)?;
        // In initialization mode the settings may have changed since the law was made; it will be made anew then.
        self.law.take_if(|law| !law.is_like(&like_new));
        let inputs = self.inputs;
        if !inputs.to_array().iter().all(|value| value.abs() <= Inputs::LARGEST) {
            // Beyond what a step accepts, commands may be infinite.
            return Ok(());
        }
        let commands = self.law.as_mut().map(|law| law.commands(&inputs).to_array());
        if commands.is_some_and(|commands| !commands.iter().all(|command| command.is_finite())) {
            return Err(Failure::error("the law in the state gives commands that are not finite"));
        }
        Ok(())
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        (direction.outputs.targets, direction.outputs.errors) = target_change(&self.arms, &direction.inputs);
        if let Some(law) = &mut self.law {
            direction.outputs.commands = law.jacobian(&self.inputs).apply(&direction.inputs);
            direction.outputs.extra = law.extra_derivative(&direction.inputs);
        }
    }
}

type Builder<'a, L> = VariableBuilder<'a, Controller<L>>;

/// An angle or a rate of one, shown in degrees.
fn angle<'a, L: FmuLaw>(builder: Builder<'a, L>, unit: &str, shown: &str) -> Builder<'a, L> {
    builder.unit(unit).display_unit(shown, 180.0 / PI)
}

fn inputs<L: FmuLaw>(variables: &mut Variables<Controller<L>>) {
    for i in 0..2 {
        angle(variables.input(format!("theta{}", i + 1), move |m| &mut m.inputs.measured.theta[i]), "rad", "deg")
            .ramp(move |m| &mut m.input_rates.measured.theta[i])
            .nominal(0.1)
            .description(&format!("Measured angle of hub {}", i + 1));
    }
    for i in 0..2 {
        let name = format!("theta{}_dot", i + 1);
        angle(variables.input(name, move |m| &mut m.inputs.measured.theta_dot[i]), "rad/s", "deg/s")
            .ramp(move |m| &mut m.input_rates.measured.theta_dot[i])
            .description(&format!("Measured angular velocity of hub {}", i + 1));
    }
    variables
        .input("y_object", |m| &mut m.inputs.measured.y_object)
        .ramp(|m| &mut m.input_rates.measured.y_object)
        .unit("m")
        .nominal(0.05)
        .description("Measured position y_M of the object's centre above hub 1");
    variables
        .input("y_object_dot", |m| &mut m.inputs.measured.y_object_dot)
        .ramp(|m| &mut m.input_rates.measured.y_object_dot)
        .unit("m/s")
        .nominal(0.1)
        .description("Measured velocity of the object");
    for i in 0..2 {
        variables
            .input(format!("root_moment{}", i + 1), move |m| &mut m.inputs.measured.root_moment[i])
            .ramp(move |m| &mut m.input_rates.measured.root_moment[i])
            .unit("N.m")
            .nominal(0.1)
            .description(&format!("Measured bending moment EI w''(0) at the root of arm {}", i + 1));
    }
    for i in 0..2 {
        variables
            .input(format!("tip_shear{}", i + 1), move |m| &mut m.inputs.measured.tip_shear[i])
            .ramp(move |m| &mut m.input_rates.measured.tip_shear[i])
            .unit("N")
            .description(&format!("Measured shear force EI w'''(l) at the tip of arm {}", i + 1));
    }
    for i in 0..2 {
        variables
            .input(format!("tip_shear{}_dot", i + 1), move |m| &mut m.inputs.measured.tip_shear_dot[i])
            .ramp(move |m| &mut m.input_rates.measured.tip_shear_dot[i])
            .unit("N/s")
            .nominal(10.0)
            .description(&format!("Measured rate of the shear force at the tip of arm {}", i + 1));
    }
    variables
        .input("lambda1_ref", |m| &mut m.inputs.reference.lambda1_ref)
        .ramp(|m| &mut m.input_rates.reference.lambda1_ref)
        .unit("N")
        .description("Wanted multiplier lambda1; the wanted contact force at both tips is -lambda1_ref, so a squeeze is negative");
    angle(variables.input("theta1_ref", |m| &mut m.inputs.reference.theta1_ref), "rad", "deg")
        .ramp(|m| &mut m.input_rates.reference.theta1_ref)
        .nominal(0.1)
        .description("Wanted angle of hub 1; all other targets follow from the two references, eq. (16)");
}

fn command_outputs<L: FmuLaw>(variables: &mut Variables<Controller<L>>, rates: Evaluation) {
    let commands = variables.evaluation(Controller::<L>::commands);
    for i in 0..2 {
        let n = i + 1;
        variables
            .output(format!("tau{n}_cmd"), commands, move |m| &mut m.outputs.commands.tau[i])
            .rate(rates, move |m| &mut m.rates.commands.tau[i])
            .unit("N.m")
            .depends_on([format!("theta{n}"), format!("theta{n}_dot"), format!("root_moment{n}")])
            .depends_on(["lambda1_ref", "theta1_ref"])
            .description(&format!("Commanded torque on hub {n}"));
    }
    variables
        .output("u_cmd", commands, |m| &mut m.outputs.commands.u)
        .rate(rates, |m| &mut m.rates.commands.u)
        .unit("N")
        .nominal(0.1)
        .depends_on(["y_object", "y_object_dot", "tip_shear1", "tip_shear2", "lambda1_ref", "theta1_ref"])
        .depends_on(L::FORCE_ALSO_DEPENDS_ON.iter().copied())
        .description("Commanded force on the object");
}

fn target_outputs<L: FmuLaw>(variables: &mut Variables<Controller<L>>, rates: Evaluation) {
    let targets = variables.evaluation(Controller::<L>::targets);
    angle(variables.output("theta1_d", targets, |m| &mut m.outputs.targets.theta[0]), "rad", "deg")
        .rate(rates, |m| &mut m.rates.targets.theta[0])
        .nominal(0.1)
        .depends_linearly_on(["theta1_ref"])
        .description("Target of theta1");
    angle(variables.output("theta2_d", targets, |m| &mut m.outputs.targets.theta[1]), "rad", "deg")
        .rate(rates, |m| &mut m.rates.targets.theta[1])
        .nominal(0.1)
        .depends_linearly_on(["theta1_ref", "lambda1_ref"])
        .description("Target of theta2, eq. (16)");
    variables
        .output("y_object_d", targets, |m| &mut m.outputs.targets.y_object)
        .rate(rates, |m| &mut m.rates.targets.y_object)
        .unit("m")
        .nominal(0.05)
        .depends_linearly_on(["theta1_ref", "lambda1_ref"])
        .description("Target of y_object, eq. (16) with the L/2 it leaves out");
    variables
        .output("lambda2_d", targets, |m| &mut m.outputs.targets.lambda[1])
        .rate(rates, |m| &mut m.rates.targets.lambda[1])
        .unit("N")
        .depends_linearly_on(["lambda1_ref"])
        .description("Target of lambda2, eq. (16)");
    angle(variables.output("e1", targets, |m| &mut m.outputs.errors.e[0]), "rad", "deg")
        .rate(rates, |m| &mut m.rates.errors.e[0])
        .nominal(0.1)
        .depends_linearly_on(["theta1", "theta1_ref"])
        .description("Angle error theta1 - theta1_d");
    angle(variables.output("e2", targets, |m| &mut m.outputs.errors.e[1]), "rad", "deg")
        .rate(rates, |m| &mut m.rates.errors.e[1])
        .nominal(0.1)
        .depends_linearly_on(["theta2", "theta1_ref", "lambda1_ref"])
        .description("Angle error theta2 - theta2_d");
    variables
        .output("p", targets, |m| &mut m.outputs.errors.p)
        .rate(rates, |m| &mut m.rates.errors.p)
        .unit("m")
        .nominal(0.01)
        .depends_linearly_on(["y_object", "theta1_ref", "lambda1_ref"])
        .description("Position error y_object - y_object_d");
}

/// Declares parameters from their table.
fn declare<L: FmuLaw, T: 'static>(
    variables: &mut Variables<Controller<L>>,
    table: &'static [Parameter<T>],
    tunable: bool,
    of: fn(&mut Controller<L>) -> &mut T,
) {
    for parameter in table {
        let builder = if tunable {
            variables.tunable(parameter.name, move |m| (parameter.field)(of(m)))
        } else {
            variables.parameter(parameter.name, move |m| (parameter.field)(of(m)))
        };
        let description = parameter.description;
        let capitalised = description[..1].to_uppercase() + &description[1..];
        builder.unit(parameter.unit).range(parameter.range.min, parameter.range.max).description(&capitalised);
    }
}

fmi2_export::export!(NabfcController, PdsController, PdController);

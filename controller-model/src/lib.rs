//! The controllers as models of FMI: one interface, three laws, which are those of [`grasp_control`].
//!
//! This is a crate apart from `controller-fmu`, whose library it becomes, because the library is compiled for speed and this for size:
//! most of it runs once for an instance. The steps are in `grasp_control`.

use fmi2_export::{
    Declare, DefaultExperiment, Evaluation, Experiment, Failure, Info, Model, StateVariable, Step, Variables, field,
};
use grasp_control::blocks::observer::RateSource;
use grasp_control::continuous::{Continuous, Direction, Regimes};
use grasp_control::{Arms, Commands, Errors, Inputs, InvalidParameter, Targets, inner};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

mod exchange;
mod gains;
mod nabfc_controller;
mod pd_controller;
mod pds_controller;
mod variables;

use exchange::States;
pub use nabfc_controller::NabfcController;
pub use pd_controller::PdController;
pub use pds_controller::PdsController;

fmi2_export::enumeration! {
    /// Where the rates of angles, position and strain come from
    pub enum Rates {
        #[default]
        Measured = "measured": "From the inputs whose names end in _dot",
        Estimated = "estimated": "From observers of angles, position and strain; the inputs whose names end in _dot are not used",
    }
}

impl From<Rates> for RateSource {
    fn from(rates: Rates) -> Self {
        match rates {
            Rates::Measured => Self::Measured,
            Rates::Estimated => Self::Estimated,
        }
    }
}

/// The longest step of a controller \[s\], some thirty years, with which the products of step size and state stay finite.
/// Far longer steps would end in NaN.
const LONGEST_STEP: f64 = 1e9;

/// The properties that a law needs to become an FMU.
pub trait FmuLaw: Continuous + Clone + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// The user's settings besides the properties of the arms.
    type Settings: Clone + Default + Serialize + DeserializeOwned + Send + Sync + 'static;
    /// Outputs it has besides those that all controllers share.
    type Extra: Clone + Default + Send + Sync + 'static;

    /// Name of the FMU.
    const NAME: &'static str;
    /// Its description in one line.
    const DESCRIPTION: &'static str;
    /// Measurements that `u_cmd` depends on, besides the position, the velocity and the shears of all laws.
    const FORCE_ALSO_DEPENDS_ON: &'static [&'static str] = &[];
    /// Measurements on which each `tau{}_cmd` depends, besides the angle, its rate and the root moment, which all laws use.
    const TORQUE_ALSO_DEPENDS_ON: &'static [&'static str] = &[];

    /// How many event indicators it has, whatever its settings.
    const INDICATORS: usize;
    /// The settings that decide how many continuous states it has, for messages.
    const COUNT_FOLLOWS_FROM: &'static str = "";

    /// The continuous states that it has with these settings.
    fn state_variables(settings: &Self::Settings) -> Vec<StateVariable>;

    /// How many they are.
    fn state_count(settings: &Self::Settings) -> usize;

    /// The law with these settings, in its initial state.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    fn create(arms: Arms, settings: &Self::Settings) -> Result<Self, InvalidParameter>;

    /// Changes the settings while the law runs; its state stays.
    ///
    /// # Errors
    /// The first parameter that is not in its range; the law is then unchanged.
    fn retune(&mut self, settings: &Self::Settings) -> Result<(), InvalidParameter>;

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

    /// Change of the extra outputs along a direction of states and inputs.
    fn extra_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Self::Extra {
        let _ = (inputs, along);
        Self::Extra::default()
    }

    /// Change of the extra outputs along a direction of the inputs.
    fn extra_derivative(&self, inputs: &Inputs, direction: &Inputs) -> Self::Extra {
        let _ = (inputs, direction);
        Self::Extra::default()
    }
}

/// A controller FMU.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Controller<L: FmuLaw> {
    arms: Arms,
    settings: L::Settings,
    signals: Signals,
    /// The law, once there is a start.
    law: Option<L>,
    /// A host integrates it.
    is_integrated: bool,
    /// Which limits hold then.
    regimes: Regimes,
    /// The outputs that only this law has.
    #[serde(skip)]
    extra: L::Extra,
    /// Their time derivatives, from when a host asks for them.
    #[serde(skip)]
    extra_rates: Option<Box<L::Extra>>,
    /// The variables that a host of model exchange may read.
    #[serde(skip, default = "States::of::<L>")]
    states: States,
}

impl<L: FmuLaw> Clone for Controller<L> {
    fn clone(&self) -> Self {
        Self { law: self.law.clone(), ..self.without_law() }
    }

    /// The same in the memory that the law has.
    fn clone_from(&mut self, source: &Self) {
        let mut law = self.law.take();
        law.clone_from(&source.law);
        *self = Self { law, ..source.without_law() };
    }
}

/// What all controllers exchange with the host, whatever their law.
#[derive(Clone, Serialize, Deserialize)]
struct Signals {
    inputs: Inputs,
    /// Slopes of the inputs over the next step.
    input_rates: Inputs,
    #[serde(skip)]
    outputs: Outputs,
    /// Time derivatives of the outputs, from when a host asks for them.
    #[serde(skip)]
    rates: Option<Box<Outputs>>,
}

/// Values of the output variables.
#[derive(Clone, Copy, Default)]
struct Outputs {
    commands: Commands,
    targets: Targets,
    errors: Errors,
}

impl Signals {
    fn rates(&mut self) -> &mut Outputs {
        self.rates.get_or_insert_default()
    }

    /// Sets targets and errors.
    fn compare(&mut self, arms: &Arms) {
        self.outputs.targets = arms.targets(&self.inputs.reference);
        self.outputs.errors = self.outputs.targets.errors(&self.inputs);
    }

    /// Sets the time derivatives of targets and errors.
    #[inline(never)]
    fn compare_rates(&mut self, arms: &Arms) {
        let (targets, errors) = target_change(arms, &self.input_rates);
        let rates = self.rates();
        (rates.targets, rates.errors) = (targets, errors);
    }

    /// Sets the changes of targets and errors along a direction, which the inputs are.
    #[inline(never)]
    fn compare_changes(&mut self, arms: &Arms) {
        (self.outputs.targets, self.outputs.errors) = target_change(arms, &self.inputs);
    }
}

impl<L: FmuLaw> Default for Controller<L> {
    fn default() -> Self {
        Self {
            arms: Arms::default(),
            settings: L::Settings::default(),
            signals: Signals {
                inputs: Inputs::default(),
                input_rates: Inputs::HELD,
                outputs: Outputs::default(),
                rates: None,
            },
            law: None,
            is_integrated: false,
            regimes: Regimes::default(),
            extra: L::Extra::default(),
            extra_rates: None,
            states: States::of::<L>(),
        }
    }
}

impl<L: FmuLaw> Controller<L> {
    /// A copy of all but the law.
    #[inline(never)]
    fn without_law(&self) -> Self {
        let Self { arms, settings, signals, law: _, is_integrated, regimes, extra, extra_rates, states } = self;
        Self {
            arms: *arms,
            settings: settings.clone(),
            signals: signals.clone(),
            law: None,
            is_integrated: *is_integrated,
            regimes: *regimes,
            extra: extra.clone(),
            extra_rates: extra_rates.clone(),
            states: states.clone(),
        }
    }

    fn commands(&mut self) {
        let Signals { inputs, outputs, .. } = &mut self.signals;
        if let Some(law) = &mut self.law {
            outputs.commands = if self.is_integrated { law.present_commands(inputs) } else { law.commands(inputs) };
        }
    }

    fn targets(&mut self) {
        self.signals.compare(&self.arms);
    }

    /// The targets of the forces alone, as in [`Targets`]: a host that follows the forces reads one in every step.
    fn force_targets(&mut self) {
        self.signals.outputs.targets.lambda = self.signals.inputs.reference.lambda();
    }

    fn extra(&mut self) {
        if let Some(law) = &self.law {
            self.extra = law.extra(&self.signals.inputs);
        }
    }

    fn rates(&mut self) {
        self.signals.compare_rates(&self.arms);
        let extra_rates = self.extra_rates.get_or_insert_default();
        if let Some(law) = &mut self.law {
            let (inputs, input_rates) = (self.signals.inputs, self.signals.input_rates);
            self.signals.rates().commands = law.command_rates(&inputs, &input_rates);
            **extra_rates = law.extra_rates(&inputs, &input_rates);
        }
    }

    fn rates_of_extra(&mut self) -> &mut L::Extra {
        self.extra_rates.get_or_insert_default()
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
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 2.0, step_size: 1e-4, tolerance: None },
        directional_derivatives: true,
        ..fmi2_export::cargo_info!()
    };

    fn variables(variables: &mut Variables<Self>) {
        variables.part(field!(Self, signals), variables::inputs);
        let rates = variables.evaluation(Self::rates);
        let (commands, targets) = (variables.evaluation(Self::commands), variables.evaluation(Self::targets));
        let force_targets = variables.evaluation(Self::force_targets);
        variables.part(field!(Self, signals), |signals| {
            let (torque_also, force_also) = (L::TORQUE_ALSO_DEPENDS_ON, L::FORCE_ALSO_DEPENDS_ON);
            variables::commands(signals, commands, rates, torque_also, force_also);
            variables::targets(signals, targets, force_targets, rates);
        });
        L::declare_extra(variables, rates);
        variables.parameters(Arms::PARAMETERS, |m| &mut m.arms);
        L::declare_settings(variables);
        // Last, so that all others have the value references that they had before there were these.
        exchange::declare(variables);
    }
}

impl<L: FmuLaw> Model for Controller<L> {
    fn initialize(&mut self, _experiment: &Experiment) -> Result<(), Failure> {
        let mut law = L::create(self.arms, &self.settings).map_err(Failure::error)?;
        law.initialize(&self.signals.inputs);
        self.law = Some(law);
        (self.is_integrated, self.regimes) = (false, Regimes::default());
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
        // Not `map_err`: compiled for size, it would be a call in every step.
        match law.step(step.size, &self.signals.inputs, &self.signals.input_rates) {
            Ok(()) => Ok(()),
            Err(error) => Err(Failure::discard(error)),
        }
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
        // In initialization mode the settings may have changed since the law was created; it is then created again.
        self.law.take_if(|law| !law.is_like(&like_new));
        let inputs = self.signals.inputs;
        if !inputs.to_array().iter().all(|value| value.abs() <= Inputs::LARGEST) {
            // Outside the range that a step accepts, commands may be infinite.
            return Ok(());
        }
        let commands = self.law.as_mut().map(|law| law.commands(&inputs).to_array());
        if commands.is_some_and(|commands| !commands.iter().all(|command| command.is_finite())) {
            return Err(Failure::error("the law in the state gives commands that are not finite"));
        }
        Ok(())
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        direction.signals.compare_changes(&self.arms);
        if let Some(law) = &mut self.law {
            direction.signals.outputs.commands = law.jacobian(&self.signals.inputs).apply(&direction.signals.inputs);
            direction.extra = law.extra_derivative(&self.signals.inputs, &direction.signals.inputs);
        }
    }
}

fmi2_export::models!(for "controller-fmu": NabfcController, PdsController, PdController);

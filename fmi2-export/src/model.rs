//! What a model's author writes: identification, variables, behaviour.

use serde::{Serialize, de::DeserializeOwned};

use crate::info::Info;
use crate::layout::Layout;
use crate::resources::Resources;
use crate::variables::Variables;

/// What the outside sees of a model: what the FMU is, and its variables.
///
/// Written by hand where a model has parts, or tables of parameters. Where each variable is a field of one struct,
/// [`derive(Declare)`](macro@crate::Declare) writes it.
pub trait Declare: Sized {
    /// Name, version and the like.
    const INFO: Info;

    /// Declares every variable, in the order in which tools shall list them.
    fn variables(variables: &mut Variables<Self>);
}

/// A model that can be exported as an FMI 2.0 co-simulation slave, and for model exchange, if it is a
/// [`ModelExchange`](crate::ModelExchange), too.
///
/// The struct holds everything: inputs, parameters, outputs and state. Its [`Default`] value is the start value of every
/// variable. Variables are declared once, in [`Declare::variables`], by giving each a name and the field it lives in; the
/// C interface, `modelDescription.xml`, saved states and documentation follow from that.
///
/// The life of an instance:
///
/// 1. `Default::default()`; the host sets parameters and start values.
///    A model that reads files of its archive does so in [`resources`](Model::resources).
/// 2. [`initialize`](Model::initialize): the state is computed from parameters and inputs. Called again whenever the
///    host changes one of them in initialization mode, so the result must not depend on an earlier call.
/// 3. [`step`](Model::step) for each communication step. Inputs are fields of the struct and constant over the step,
///    or ramps if the host gave derivatives to inputs declared with [`ramp`](crate::VariableBuilder::ramp).
/// 4. Outputs are filled in by the evaluations declared with [`Variables::evaluation`], only when the host asks for them.
///
/// Saving a state is `Clone`; serialising it is `Serialize`. A state that is restored, or saved in the memory of one that was freed, is
/// `clone_from`: a model with lists can write that so that it needs no new memory. Derived data (factorised matrices, caches) can be skipped
/// with `#[serde(skip)]` and rebuilt in [`restored`](Model::restored).
pub trait Model: Declare + Clone + Default + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// Computes the initial state from the parameters, and from the inputs at the start if it depends on them: outputs
    /// that then depend on those inputs say so with [`starts_from`](crate::VariableBuilder::starts_from).
    ///
    /// Without it the state starts as in the default value, which is right where it follows from nothing.
    ///
    /// # Errors
    /// If the parameters admit no initial state. The host gets `fmi2Error` and the message, and may correct them.
    fn initialize(&mut self, experiment: &Experiment) -> Result<(), Failure> {
        let _ = experiment;
        Ok(())
    }

    /// Advances the state from `step.time` to `step.time + step.size`.
    ///
    /// # Errors
    /// [`Failure::Discard`] if a smaller step could succeed, [`Failure::Error`] otherwise.
    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure>;

    /// Computes outputs and local variables from the state, the parameters and the inputs: the evaluation of those that
    /// [`derive(Declare)`](macro@crate::Declare) declares. Not needed for fields that the step keeps up to date.
    fn outputs(&mut self) {}

    /// Computes the time derivatives of outputs, as [`outputs`](Self::outputs) the outputs.
    fn rates(&mut self) {}

    /// Hears where the files are that the archive carries below `resources/`, before anything else: when an instance is made or
    /// reset, and, for a state read from bytes, before [`restored`](Model::restored). Read them here, or keep `resources` in a
    /// field with `#[serde(skip)]` for [`initialize`](Model::initialize), if it depends on a parameter which file is read.
    ///
    /// # Errors
    /// If a file is missing or wrong: then there is no instance, or it stays as it was.
    fn resources(&mut self, resources: &Resources) -> Result<(), Failure> {
        let _ = resources;
        Ok(())
    }

    /// Takes over, when an instance is reset, what the model before has computed and what does not depend on its state, like
    /// matrices or tables: what is kept need not be made again. Called on a new model; everything must come out the same
    /// without it.
    fn inherit(&mut self, before: Self) {
        drop(before);
    }

    /// Called after the host has changed a tunable parameter while stepping, or in event mode. If it fails, the old value is put back and
    /// `retuned` is called once more.
    ///
    /// # Errors
    /// If the parameters do not fit together.
    fn retuned(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    /// Rebuilds what serialisation skipped, and checks that a state read from a blob is one this model can be in. Ranges and
    /// finiteness of inputs, their slopes and parameters have been checked before.
    ///
    /// # Errors
    /// If it is not; the blob is then refused and the instance keeps its state.
    fn restored(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    /// Called when the host terminates the run: what there is to say of it as a whole goes to `conclusion`.
    fn conclude(&mut self, conclusion: &mut Conclusion<'_>) {
        let _ = conclusion;
    }

    /// Directional derivative of the outputs with respect to the inputs at the current state (FMI 2.0.4, section 2.1.9).
    ///
    /// On entry the input fields of `direction` hold the seed `dv_known` and its output fields are zero; on exit its
    /// output fields hold `dv_unknown`, the derivative of the outputs along the seed. Only called if
    /// [`Info::directional_derivatives`] is set, and at communication points.
    ///
    /// In initialization mode outputs also follow from parameters, and from inputs through the initial state. There the
    /// library initializes copies of the model with neighbouring values and extrapolates the differences: exact up to
    /// rounding where the outputs are linear in them, ten digits where they are smooth.
    fn directional_derivative(&mut self, direction: &mut Self) {
        let _ = direction;
    }
}

/// The experiment a host has set up with `fmi2SetupExperiment`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, serde::Deserialize)]
pub struct Experiment {
    /// Start time (s).
    pub start_time: f64,
    /// Stop time (s), if the host named one; steps past it are refused.
    pub stop_time: Option<f64>,
    /// Relative tolerance, if the host named one.
    pub tolerance: Option<f64>,
}

impl Default for Experiment {
    fn default() -> Self {
        Self { start_time: 0.0, stop_time: None, tolerance: None }
    }
}

/// One communication step.
pub struct Step<'a> {
    /// Its start (s).
    pub time: f64,
    /// Its size (s), positive and finite.
    pub size: f64,
    pub(crate) warn: &'a mut dyn FnMut(std::fmt::Arguments<'_>),
    /// The layout of the model's variables, if a host makes the step.
    pub(crate) layout: Option<&'a Layout>,
    /// What the host has set up, if it makes the step.
    pub(crate) experiment: &'a Option<Experiment>,
}

impl<'a> Step<'a> {
    /// A step outside of any host, for tests and benchmarks; warnings go to `warn`.
    pub fn new(time: f64, size: f64, warn: &'a mut dyn FnMut(std::fmt::Arguments<'_>)) -> Self {
        Self { time, size, warn, layout: None, experiment: &None }
    }

    /// Tells the host's user something: logged in category `logStatusWarning` with status `fmi2Warning`. The step's own
    /// status stays `fmi2OK`, because hosts stop at any other.
    pub fn warn(&mut self, message: std::fmt::Arguments<'_>) {
        (self.warn)(message);
    }

    /// Relative tolerance, if the host has named one.
    pub(crate) fn tolerance(&self) -> Option<f64> {
        self.experiment.and_then(|experiment| experiment.tolerance)
    }
}

/// The end of a run.
pub struct Conclusion<'a> {
    /// When the run ends (s).
    pub time: f64,
    pub(crate) warn: &'a mut dyn FnMut(std::fmt::Arguments<'_>),
}

impl<'a> Conclusion<'a> {
    /// A conclusion outside of any host, for tests; warnings go to `warn`.
    pub fn new(time: f64, warn: &'a mut dyn FnMut(std::fmt::Arguments<'_>)) -> Self {
        Self { time, warn }
    }

    /// Tells the host's user something, as [`Step::warn`].
    pub fn warn(&mut self, message: std::fmt::Arguments<'_>) {
        (self.warn)(message);
    }
}

/// Why a model could not do what it was asked for. The message is shown to the host's user: say what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// The step cannot be done like this; a smaller one, or other inputs, may succeed (`fmi2Discard`).
    #[error("{0}")]
    Discard(String),
    /// It cannot be done (`fmi2Error`).
    #[error("{0}")]
    Error(String),
    /// What all instances share is beyond repair (`fmi2Fatal`): the host can call no function of the FMU any more, for none of its
    /// instances, and has to load it anew. A model that shares nothing has no use for it. A panic is no reason: it ends one
    /// instance, and a reset starts it again.
    #[error("{0}")]
    Fatal(String),
}

impl Failure {
    /// [`Failure::Error`] from anything that displays.
    pub fn error(reason: impl std::fmt::Display) -> Self {
        Self::Error(reason.to_string())
    }

    /// [`Failure::Fatal`] from anything that displays.
    pub fn fatal(reason: impl std::fmt::Display) -> Self {
        Self::Fatal(reason.to_string())
    }

    /// [`Failure::Discard`] from anything that displays.
    pub fn discard(reason: impl std::fmt::Display) -> Self {
        Self::Discard(reason.to_string())
    }
}

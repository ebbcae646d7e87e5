//! A model that fails in whatever way it is told to, with a variable of every kind: for testing how the C interface
//! behaves then, and nothing to learn from.

use fmi2_export::{
    Completed, Declare, EventUpdate, Experiment, Failure, Info, Model, ModelExchange, Moment, Step, Variables,
};
use serde::{Deserialize, Serialize, Serializer};

fmi2_export::enumeration! {
    /// What goes wrong
    enum Fault {
        #[default]
        None = "none": "Nothing",
        StepDiscards = "step discards": "A step is discarded halfway",
        StepFails = "step fails": "A step fails halfway",
        StepPanics = "step panics": "A step panics halfway",
        StepWarns = "step warns": "A step gives a warning with characters that printf would interpret",
        StepGivesNan = "step gives NaN": "The output becomes NaN",
        InitializeDiscards = "initialize discards": "Initialization asks for a smaller step, which is nonsense",
        InitializeFails = "initialize fails": "Initialization fails halfway",
        InitializePanics = "initialize panics": "Initialization panics halfway",
        EvaluationPanics = "evaluation panics": "Computing the outputs panics",
        DerivativePanics = "derivative panics": "The directional derivative panics",
        RetuneFails = "retune fails": "New values of tunable parameters are not accepted",
        RetuneDiscards = "retune discards": "They are not accepted, with the wrong kind of failure",
        RetunePanics = "retune panics": "New values of tunable parameters make it panic",
        ClonePanics = "clone panics": "It cannot be copied",
        SerializeFails = "serialize fails": "It cannot be serialised",
        SerializePanics = "serialize panics": "Serialising it panics",
        RestoreFails = "restore fails": "A serialised state is not accepted",
        RestorePanics = "restore panics": "A serialised state makes it panic",
        DropPanics = "drop panics": "Its destructor panics",
        PayloadPanics = "payload panics": "A step panics with something whose destructor panics",
        DerivativesAreNan = "derivatives are NaN": "The state's time derivative is not a number",
        DerivativesPanic = "derivatives panic": "Computing the state's time derivative panics",
        IndicatorsAreInfinite = "indicators are infinite": "The event indicators are",
        IndicatorsPanic = "indicators panic": "Computing the event indicators panics",
        StatesAreRefused = "states are refused": "The state cannot be what the host sets",
        StatesPanic = "states panic": "Setting the state panics",
        UpdateFails = "update fails": "The discrete states cannot be updated",
        UpdatePanics = "update panics": "Updating the discrete states panics",
        UpdateNeverEnds = "update never ends": "It wants to be repeated forever, and the simulation to end",
        UpdateLosesTime = "update loses time": "It says that its next event comes at NaN",
        UpdateNeverComes = "update never comes": "It says that its next event comes at infinity",
        CompletedFails = "completed fails": "A completed step is not taken well",
        CompletedPanics = "completed panics": "A completed step makes it panic",
        CompletedEnds = "completed ends": "After a completed step it wants the simulation to end",
        JacobianPanics = "jacobian panics": "The directional derivative with respect to the state panics",
    }
}

#[derive(Default, Serialize, Deserialize)]
struct Misbehaving {
    #[serde(serialize_with = "serialize_fault")]
    fault: Fault,
    real: Kinds<f64>,
    integer: Kinds<i32>,
    boolean: Kinds<bool>,
    string: Kinds<String>,
    slope: f64,
    rate: f64,
    local: f64,
    limited: f64,
    limited_slope: f64,
    x: f64,
    #[serde(skip)]
    x_dot: f64,
    #[serde(skip)]
    indicators: [f64; 2],
    updates: i32,
}

/// A variable of each causality and variability.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Kinds<T> {
    input: T,
    fixed: T,
    tunable: T,
    output: T,
}

struct Bomb;

impl Drop for Bomb {
    fn drop(&mut self) {
        panic!("the payload");
    }
}

impl Drop for Misbehaving {
    fn drop(&mut self) {
        assert!(self.fault != Fault::DropPanics || std::thread::panicking(), "drop");
    }
}

impl Clone for Misbehaving {
    fn clone(&self) -> Self {
        assert!(self.fault != Fault::ClonePanics, "clone");
        let mut clone = Self::default();
        (clone.fault, clone.slope, clone.rate, clone.local) = (self.fault, self.slope, self.rate, self.local);
        (clone.x, clone.limited, clone.limited_slope) = (self.x, self.limited, self.limited_slope);
        (clone.x_dot, clone.indicators, clone.updates) = (self.x_dot, self.indicators, self.updates);
        (clone.real, clone.integer) = (self.real.clone(), self.integer.clone());
        (clone.boolean, clone.string) = (self.boolean.clone(), self.string.clone());
        clone
    }
}

#[allow(clippy::trivially_copy_pass_by_ref)] // The signature serde asks for.
fn serialize_fault<S: Serializer>(fault: &Fault, serializer: S) -> Result<S::Ok, S::Error> {
    match fault {
        Fault::SerializeFails => Err(serde::ser::Error::custom("serialize")),
        Fault::SerializePanics => panic!("serialize"),
        fault => fault.serialize(serializer),
    }
}

impl Misbehaving {
    fn outputs(&mut self) {
        assert!(self.fault != Fault::EvaluationPanics, "evaluation");
        self.real.output = self.x + self.real.input * self.real.tunable;
        self.local = 2.0 * self.x;
        self.rate = self.real.input + self.slope * self.real.tunable;
        self.integer.output = self.integer.input.wrapping_add(self.integer.tunable);
        self.boolean.output = self.boolean.input ^ self.boolean.tunable;
        self.string.output = format!("{}{}", self.string.input, self.string.tunable);
    }

    fn rates(&mut self) {
        assert!(self.fault != Fault::DerivativesPanic, "derivatives");
        let nothing = if self.fault == Fault::DerivativesAreNan { f64::NAN } else { 0.0 };
        self.x_dot = self.real.input - self.x + nothing;
    }

    fn indicators(&mut self) {
        assert!(self.fault != Fault::IndicatorsPanic, "indicators");
        let second = if self.fault == Fault::IndicatorsAreInfinite { f64::INFINITY } else { 1.0 };
        self.indicators = [self.x - self.real.input, second];
    }
}

impl Declare for Misbehaving {
    const INFO: Info = Info {
        name: "Misbehaving",
        description: "Fails as it is told to",
        directional_derivatives: true,
        ..Info::new()
    };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(Self::outputs);
        variables.input("fault", |m| &mut m.fault).description("What goes wrong");
        variables.input("real.input", |m| &mut m.real.input).ramp(|m| &mut m.slope).description("A real input");
        variables.parameter("real.fixed", |m| &mut m.real.fixed).description("A fixed real parameter");
        variables.parameter("real.tunable", |m| &mut m.real.tunable).tunable().description("A tunable real parameter");
        variables
            .output("real.output", outputs, |m| &mut m.real.output)
            .rate(outputs, |m| &mut m.rate)
            .depends_on(["real.input"])
            .description("A real output");
        variables.local("real.local", outputs, |m| &mut m.local).description("A real local variable");
        variables
            .input("real.limited", |m| &mut m.limited)
            .ramp(|m| &mut m.limited_slope)
            .range(-1.0, 1.0)
            .description("A real input with a range");
        variables.input("integer.input", |m| &mut m.integer.input).description("An integer input");
        variables.parameter("integer.fixed", |m| &mut m.integer.fixed).range(-9.0, 9.0).description("A fixed integer");
        variables.parameter("integer.tunable", |m| &mut m.integer.tunable).tunable().description("A tunable integer");
        variables
            .output("integer.output", outputs, |m| &mut m.integer.output)
            .depends_on(["integer.input"])
            .description("An integer output");
        variables.input("boolean.input", |m| &mut m.boolean.input).description("A Boolean input");
        variables.parameter("boolean.fixed", |m| &mut m.boolean.fixed).description("A fixed Boolean");
        variables.parameter("boolean.tunable", |m| &mut m.boolean.tunable).tunable().description("A tunable Boolean");
        variables
            .output("boolean.output", outputs, |m| &mut m.boolean.output)
            .depends_on(["boolean.input"])
            .description("A Boolean output");
        variables.input("string.input", |m| &mut m.string.input).description("A string input");
        variables.parameter("string.fixed", |m| &mut m.string.fixed).description("A fixed string");
        variables.parameter("string.tunable", |m| &mut m.string.tunable).tunable().description("A tunable string");
        variables
            .output("string.output", outputs, |m| &mut m.string.output)
            .depends_on(["string.input"])
            .description("A string output");
        let (state, rates) = (variables.evaluation(|_| {}), variables.evaluation(Self::rates));
        variables.local("state", state, |m| &mut m.x).state().nominal(-2.0).description("The continuous state");
        variables
            .local("der(state)", rates, |m| &mut m.x_dot)
            .derivative_of("state")
            .depends_on(["real.input"])
            .description("Its rate");
        let indicators = variables.evaluation(Self::indicators);
        variables.event_indicators(indicators, |m| &mut m.indicators);
    }
}

impl Model for Misbehaving {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        self.x = self.real.fixed;
        match self.fault {
            Fault::InitializeDiscards => Err(Failure::discard("initialize")),
            Fault::InitializeFails => Err(Failure::error("initialize")),
            Fault::InitializePanics => panic!("initialize"),
            _ => Ok(()),
        }
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        self.x += step.size * (self.real.input + 0.5 * self.slope * step.size);
        match self.fault {
            Fault::StepDiscards => Err(Failure::discard("step")),
            Fault::StepFails => Err(Failure::error("step")),
            Fault::StepPanics => panic!("step"),
            Fault::PayloadPanics => std::panic::panic_any(Bomb),
            Fault::StepWarns => {
                step.warn(format_args!("100 %s of #r1#"));
                Ok(())
            }
            Fault::StepGivesNan => {
                self.x = f64::NAN;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn retuned(&mut self) -> Result<(), Failure> {
        match self.fault {
            Fault::RetuneFails => Err(Failure::error("retune")),
            Fault::RetuneDiscards => Err(Failure::discard("retune")),
            Fault::RetunePanics => panic!("retune"),
            _ => Ok(()),
        }
    }

    fn restored(&mut self) -> Result<(), Failure> {
        match self.fault {
            Fault::RestoreFails => Err(Failure::error("restore")),
            Fault::RestorePanics => panic!("restore"),
            _ => Ok(()),
        }
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        assert!(self.fault != Fault::DerivativePanics, "derivative");
        direction.real.output = direction.real.input * self.real.tunable;
    }
}

impl ModelExchange for Misbehaving {
    const COMPLETES_STEPS: bool = true;

    fn states_set(&mut self) -> Result<(), Failure> {
        match self.fault {
            Fault::StatesAreRefused => Err(Failure::error("states")),
            Fault::StatesPanic => panic!("states"),
            _ => Ok(()),
        }
    }

    fn new_discrete_states(&mut self, moment: &mut Moment<'_>) -> Result<EventUpdate, Failure> {
        self.updates = self.updates.wrapping_add(1);
        match self.fault {
            Fault::UpdateFails => Err(Failure::discard("update")),
            Fault::UpdatePanics => panic!("update"),
            Fault::UpdateLosesTime => Ok(EventUpdate { next_time: Some(f64::NAN), ..EventUpdate::default() }),
            Fault::UpdateNeverComes => Ok(EventUpdate { next_time: Some(f64::INFINITY), ..EventUpdate::default() }),
            Fault::UpdateNeverEnds => Ok(EventUpdate { again: true, terminate: true, next_time: None }),
            Fault::StepWarns => {
                moment.warn(format_args!("100 %s of #r1#"));
                Ok(EventUpdate { next_time: Some(moment.time + 1.0), ..EventUpdate::default() })
            }
            Fault::StepGivesNan => {
                self.x = f64::NAN;
                Ok(EventUpdate::default())
            }
            _ => Ok(EventUpdate::default()),
        }
    }

    fn step_completed(&mut self, _: &mut Moment<'_>) -> Result<Completed, Failure> {
        match self.fault {
            Fault::CompletedFails => Err(Failure::error("completed")),
            Fault::CompletedPanics => panic!("completed"),
            Fault::CompletedEnds => Ok(Completed::Terminate),
            _ => Ok(if self.x > self.real.input { Completed::EnterEventMode } else { Completed::Continue }),
        }
    }

    fn jacobian_product(&mut self, direction: &mut Self) {
        assert!(self.fault != Fault::JacobianPanics, "jacobian");
        direction.real.output = direction.x + direction.real.input * self.real.tunable;
        direction.x_dot = direction.real.input - direction.x;
    }
}

fmi2_export::export!(Misbehaving);

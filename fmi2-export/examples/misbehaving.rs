//! A model that fails in whatever way it is told to, with a variable of every kind: for testing how the C interface
//! behaves then, and nothing to learn from.

use fmi2_export::{Declare, Experiment, Failure, Info, Model, Step, Variables};
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

fmi2_export::export!(Misbehaving);

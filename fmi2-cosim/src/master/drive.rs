//! Inputs that follow signals over time.
//!
//! At every communication point an input gets the value of its signal. During the step it is held, unless the signal is a
//! straight line and the FMU can interpolate inputs: then it also gets the slope to the value at the end of the step
//! (`fmi2SetRealInputDerivatives`, order 1).

use crate::grid::TimeGrid;
use crate::settings::Place;
use crate::signal::Signal;
use fmi2_import::description::BaseType;
use fmi2_import::{CallError, Instance, ModelDescription, Value, Variable};

/// One input and the signal it follows.
pub(crate) struct Drive {
    pub component: usize,
    pub variable: usize,
    described: Variable,
    interpolates: bool,
    signal: Signal,
    /// The slope that the FMU received last; `None` if it has to be sent again.
    told: Option<f64>,
}

impl Drive {
    pub fn new((component, variable): Place, description: &ModelDescription, signal: Signal) -> Self {
        let described = description.variables[variable].clone();
        let interpolates = described.base_type() == BaseType::Real
            && description.co_simulation.as_ref().is_some_and(|interface| interface.can_interpolate_inputs);
        Self { component, variable, described, interpolates, signal, told: None }
    }

    /// Fits the signal to the communication points. Returns remarks for the user.
    pub fn fit(&mut self, grid: &TimeGrid, name: &str) -> Vec<String> {
        let jumps = self.signal.snap(grid);
        let mut remarks: Vec<String> = jumps
            .iter()
            .map(|time| {
                format!("{name} jumps at {time} s, between two communication points: the jump comes with the next one")
            })
            .collect();
        if self.signal.is_ramped() && !self.interpolates {
            remarks.push(format!(
                "{name} is a straight line, but its FMU cannot interpolate inputs: it is held during each step"
            ));
        }
        remarks
    }

    /// Sets the value at `time` and, if the FMU can use it, the slope until `next`. True if anything changed.
    pub fn apply(&mut self, instance: &mut Instance, time: f64, next: Option<f64>) -> Result<bool, CallError> {
        let value = self.signal.at(time);
        let slope = match next {
            Some(next) if self.interpolates => (self.signal.before(next) - value) / (next - time),
            _ => 0.0,
        };
        let changed = self.told != Some(value);
        if changed {
            instance.set(&self.described, &Value::Real(value))?;
        }
        if slope == 0.0 {
            self.told = Some(value);
        } else {
            instance.set_input_derivatives(&[self.described.value_reference], &[1], &[slope])?;
            self.told = None; // at the end of the step the input stands elsewhere
        }
        Ok(changed || slope != 0.0)
    }
}

//! The plant: parameters, state, and what was computed from them.

#[cfg(test)]
mod bits;
mod continuous;
mod model;
mod outputs;
mod step;

use crate::dynamics::Signals;
use crate::kernel::LANES;
use crate::parameters::Parameters;
use crate::propagator::Cache;
use crate::state::{State, StateError};
use crate::state_space::StateSpace;
use model::Model;
use parameter_table::InvalidParameter;
use std::sync::Arc;

/// Into how many parts a step is divided at most, if it is too long for one piece: seconds of computing time.
const MOST_PARTS: u32 = 1 << 22;

/// Two flexible arms grasping an object, (2)–(14), behind their actuators (18)–(20).
///
/// Cloning is cheap: clones share all matrices.
///
/// ```
/// use grasp_plant::{Inputs, Parameters, Plant};
/// let mut plant = Plant::new(Parameters::default())?;
/// let inputs = Inputs { torque_command: [0.05, 0.0], ..Inputs::ZERO };
/// for _ in 0..500 {
///     plant.step(1e-4, &inputs, &Inputs::ZERO)?;
/// }
/// // Exact value of θ_1(0.05 s) from the characteristic equation: 0.0059126125…
/// assert!((plant.measured().theta[0] - 0.005_912_612_5).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Plant {
    model: Arc<Model>,
    state: State,
    /// Signals of `state`, kept current.
    signals: Signals,
    cache: Cache,
    work: Workspace,
}

/// Buffers of a step, so that it does not allocate.
#[derive(Clone, Debug)]
struct Workspace {
    /// (x, g, r), or the whole extended vector.
    drive: Vec<f64>,
    /// Increments, padded.
    increment: Vec<[f64; LANES]>,
    next: State,
}

impl Plant {
    /// A plant at its start.
    ///
    /// # Errors
    /// If a parameter is not admissible.
    pub fn new(parameters: Parameters) -> Result<Self, InvalidParameter> {
        parameters.validate()?;
        let model = Model::new(parameters);
        let state = State::start(&model.parameters, &model.dynamics);
        let size = model.extended.layout.size();
        let work = Workspace {
            drive: vec![0.0; size],
            increment: vec![[0.0; LANES]; size.div_ceil(LANES)],
            next: state.clone(),
        };
        Ok(Self {
            signals: model.dynamics.signals(&state.coordinates),
            model: Arc::new(model),
            state,
            cache: Cache::default(),
            work,
        })
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.model.parameters
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Replaces the state by one that a plant of the same parameters had.
    ///
    /// # Errors
    /// If the state belongs to another order or holds a number that is not finite.
    pub fn set_state(&mut self, state: &State) -> Result<(), StateError> {
        let (found, expected) = (state.coordinates.len(), self.state.coordinates.len());
        if found != expected {
            return Err(StateError::Length { found, expected });
        }
        let mut values =
            state.coordinates.iter().chain(&state.position).chain(&state.carry).chain([&state.supplied_energy]);
        if !values.all(|value| value.is_finite()) {
            return Err(StateError::NotFinite);
        }
        self.state.coordinates.copy_from_slice(&state.coordinates);
        self.state.position = state.position;
        self.state.carry = state.carry;
        self.state.supplied_energy = state.supplied_energy;
        self.state.sizes = state.sizes;
        self.signals = self.model.dynamics.signals(&self.state.coordinates);
        Ok(())
    }

    /// Returns to the start. What was computed for the step sizes in use is kept.
    pub fn reset(&mut self) {
        self.state = State::start(&self.model.parameters, &self.model.dynamics);
        self.signals = self.model.dynamics.signals(&self.state.coordinates);
    }

    /// The longest step this plant takes \[s\]: [`LONGEST_STEP`](crate::LONGEST_STEP) at the default parameters of every
    /// order, less for extremely stiff ones, times the four million parts into which a step may be divided.
    #[must_use]
    pub fn longest_step(&self) -> f64 {
        self.longest_part() * f64::from(MOST_PARTS)
    }

    /// The longest step done in one piece \[s\].
    #[must_use]
    pub fn longest_part(&self) -> f64 {
        self.model.extended.longest_step
    }

    /// Coefficients of the velocity fields, then √J_i θ̇_i and √m ẏ_M, from the velocity coordinates of the state.
    pub(crate) fn physical_velocities(&self, coordinates: &[f64]) -> Vec<f64> {
        let mut velocities = coordinates.to_vec();
        self.model.dynamics.reflect(&mut velocities);
        velocities
    }

    /// The plant as a linear system.
    #[must_use]
    pub fn state_space(&self) -> StateSpace {
        StateSpace::new(&self.model.dynamics)
    }
}

//! The plant: parameters, state, and what was computed from them.

#[cfg(test)]
mod bits;
mod continuous;
mod model;
mod outputs;
mod step;

use crate::contact::Contacts;
use crate::dynamics::Signals;
use crate::kernel::LANES;
use crate::parameters::Parameters;
use crate::propagator::Cache;
use crate::state::{State, StateError};
use crate::state_space::StateSpace;
pub(crate) use model::{MAX_KINK_TIMES, Model};
use parameter_table::InvalidParameter;
use std::sync::Arc;
pub(crate) use step::{all_usable, at, flush};

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
    /// What takes over where the grasp can open.
    contacts: Option<Box<Contacts>>,
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
        let (contacts, state) = match Contacts::new(&model.parameters, model.dynamics.tip_compliance) {
            Some((contacts, state)) => (Some(Box::new(contacts)), state),
            None => (None, State::start(&model.parameters, &model.dynamics)),
        };
        let size = model.extended.layout.size();
        let work = Workspace {
            drive: vec![0.0; size],
            increment: vec![[0.0; LANES]; size.div_ceil(LANES)],
            next: state.clone(),
        };
        let mut plant = Self {
            signals: Signals::default(),
            model: Arc::new(model),
            state,
            cache: Cache::default(),
            work,
            contacts,
        };
        plant.read_signals();
        Ok(plant)
    }

    /// Makes the signals those of the state.
    fn read_signals(&mut self) {
        self.signals = match &self.contacts {
            None => self.model.dynamics.signals(&self.state.coordinates),
            Some(contacts) => contacts.signals(&self.state.coordinates),
        };
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.model.parameters
    }

    /// Whether tips can leave the object: then it is [`step`](Self::step) alone that moves the plant, from switch to switch.
    #[must_use]
    pub fn can_open(&self) -> bool {
        self.contacts.is_some()
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
        if self.contacts.is_some() {
            Contacts::check(state)?;
        } else if state.contact.is_some() {
            return Err(StateError::Contact);
        }
        if let (Some(own), Some(contact)) = (&mut self.state.contact, &state.contact) {
            **own = **contact;
        }
        self.state.coordinates.copy_from_slice(&state.coordinates);
        self.state.position = state.position;
        self.state.carry = state.carry;
        self.state.supplied_energy = state.supplied_energy;
        self.state.sizes = state.sizes;
        self.read_signals();
        Ok(())
    }

    /// Returns to the start. What was computed for the step sizes in use is kept.
    pub fn reset(&mut self) {
        self.state = match &self.contacts {
            None => State::start(&self.model.parameters, &self.model.dynamics),
            Some(contacts) => contacts.start(&self.model.parameters),
        };
        self.read_signals();
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
        self.contacts.as_ref().map_or(self.model.extended.longest_step, |contacts| contacts.longest_part())
    }

    /// Coefficients of the velocity fields, then √J_i θ̇_i and √m ẏ_M, from the velocity coordinates of the state.
    pub(crate) fn physical_velocities(&self, coordinates: &[f64]) -> Vec<f64> {
        let mut velocities = coordinates.to_vec();
        if self.contacts.is_none() {
            self.model.dynamics.reflect(&mut velocities);
        }
        velocities
    }

    /// The plant as a linear system, both tips held to the object.
    #[must_use]
    pub fn state_space(&self) -> StateSpace {
        StateSpace::new(&self.model.dynamics)
    }
}

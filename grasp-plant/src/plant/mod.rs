//! The plant: parameters, state, and results computed from them.

#[cfg(test)]
mod bits;
mod changes;
mod continuous;
mod held;
mod modal;
mod model;
mod outputs;
mod registry;
mod step;

use crate::cache::Cache;
use crate::contact::Contacts;
use crate::dynamics::Signals;
use crate::extended::MAX_COORDINATES;
use crate::kernel::LANES;
use crate::modal::{Modal, Table};
use crate::parameters::Parameters;
use crate::propagator::Propagator;
use crate::state::{Basis, State, StateError};
use crate::state_space::StateSpace;
pub(crate) use model::{MAX_KINK_TIMES, Model};
use parameter_table::InvalidParameter;
use std::sync::Arc;
pub(crate) use step::{all_usable, at, flush};

/// The largest number of parts of a step that is too long for one piece: seconds of computing time.
const MOST_PARTS: u32 = 1 << 22;

/// Two flexible arms grasping an object, (2)–(14), behind their actuators (18)–(20).
///
/// Cloning is cheap: plants with equal parameters share all matrices, in the whole process.
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
#[derive(Debug)]
#[repr(C)] // First what every step needs, in few lines of a processor's cache: of a thousand plants each has been pushed out of it.
pub struct Plant {
    /// Signals of `state`, kept current; in modal coordinates but for the rates of the root moments.
    signals: Signals,
    state: State,
    model: Arc<Model>,
    /// What usual steps may cost before the state is looked at, if it is in modal coordinates and the last step was usual: see
    /// [`held_step`](Self::held_step). Zero when anything else has changed the state.
    calm: u32,
    /// Whether a tip may have pulled at the object at the end of the last step.
    pulls: bool,
    /// Whether an actuator was at its limits in the last step.
    limited: bool,
    /// The contacts, if the grasp can open.
    contacts: Option<Box<Contacts>>,
    cache: Caches,
    work: Workspace,
    parameters: Parameters,
}

impl Clone for Plant {
    fn clone(&self) -> Self {
        let Self { signals, state, model, calm, pulls, limited, contacts, cache, work: _, parameters } = self;
        Self {
            signals: *signals,
            state: state.clone(),
            model: model.clone(),
            calm: *calm,
            pulls: *pulls,
            limited: *limited,
            contacts: contacts.clone(),
            cache: cache.clone(),
            work: Workspace::default(),
            parameters: parameters.clone(),
        }
    }

    /// In the memory that is there. What moves is copied; what is shared is left alone where it is the same already.
    fn clone_from(&mut self, source: &Self) {
        let Self { signals, state, model, calm, pulls, limited, contacts, cache, work: _, parameters } = source;
        if !Arc::ptr_eq(&self.model, model) {
            self.model = model.clone();
            self.work = Workspace::default();
        }
        self.signals = *signals;
        self.state.clone_from(state);
        (self.calm, self.pulls, self.limited) = (*calm, *pulls, *limited);
        self.contacts.clone_from(contacts);
        self.cache.tables.clone_from(&cache.tables);
        self.cache.propagators.clone_from(&cache.propagators);
        self.parameters.clone_from(parameters);
    }
}

/// Results for the step sizes last used.
#[derive(Clone, Debug, Default)]
#[repr(C)] // The usual step needs the last table alone.
struct Caches {
    tables: Cache<Table>,
    propagators: Cache<Propagator>,
}

/// Buffers of a step, so that it does not allocate. Each is empty until a step first needs it: usual steps need none.
#[derive(Debug, Default)]
struct Workspace {
    /// (x, g, r), or the whole extended vector.
    drive: Vec<f64>,
    /// Increments, padded, of dense plants.
    increment: Vec<[f64; LANES]>,
    /// The modal step of a size that is not kept.
    table: Option<Table>,
    next: State,
}

impl Plant {
    /// A plant at its start.
    ///
    /// # Errors
    /// If a parameter is not admissible.
    pub fn new(parameters: Parameters) -> Result<Self, InvalidParameter> {
        parameters.validate()?;
        let model = registry::model(&parameters);
        let (contacts, state) = match Contacts::new(&parameters, model.dynamics.tip_compliance) {
            Some((contacts, state)) => (Some(Box::new(contacts)), state),
            None => (None, State::start(&parameters, &model.dynamics)),
        };
        let mut plant = Self {
            signals: Signals::default(),
            state,
            model,
            calm: 0,
            pulls: false,
            limited: false,
            contacts,
            cache: Caches::default(),
            work: Workspace::default(),
            parameters,
        };
        plant.read_signals();
        Ok(plant)
    }

    /// Makes room for a step that is not the usual one.
    fn prepare(&mut self) {
        self.work.drive.resize(self.model.extended.layout.size(), 0.0);
        self.work.next.coordinates.resize(self.state.coordinates.len());
    }

    /// Makes room for increments.
    fn prepare_increments(&mut self) {
        self.work.increment.resize(self.model.extended.layout.size().div_ceil(LANES), [0.0; LANES]);
    }

    /// Makes the signals those of the state.
    fn read_signals(&mut self) {
        let coordinates = &self.state.coordinates;
        self.signals = match (&self.contacts, self.modal_of_state()) {
            (Some(contacts), _) => contacts.signals(coordinates),
            (None, Some(modal)) => modal.signals(coordinates),
            (None, None) => self.model.dynamics.signals(coordinates),
        };
        self.calm = 0;
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
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

    /// Replaces the state by that of a plant with the same parameters.
    ///
    /// # Errors
    /// If the state belongs to another order or holds a number that is not finite.
    pub fn set_state(&mut self, state: &State) -> Result<(), StateError> {
        let expected = match (state.basis, &self.contacts) {
            (Basis::Energy, None) => self.model.dynamics.size(),
            // A grasp that can open keeps its energy coordinates.
            (Basis::Energy, Some(_)) => self.state.coordinates.len(),
            (basis, None) => {
                let modal = self.model.modal().filter(|modal| modal.state_basis() == basis);
                modal.ok_or(StateError::NotModal)?.size()
            }
            (_, Some(_)) => return Err(StateError::NotModal),
        };
        let found = state.coordinates.len();
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
        self.state.basis = state.basis;
        self.state.coordinates.clone_from(&state.coordinates);
        self.state.position = state.position;
        self.state.carry = state.carry;
        self.state.supplied_energy = state.supplied_energy;
        self.state.sizes = state.sizes;
        self.read_signals();
        Ok(())
    }

    /// The modal form, if the state is in its coordinates.
    fn modal_of_state(&self) -> Option<&Modal> {
        if self.state.basis == Basis::Energy { None } else { self.model.modal() }
    }

    /// Energy coordinates x \[√J\], 4k + 1 of them: ½|x|² is the total energy. The last is that of the rigid motion: its
    /// momentum, without the reflection, over the root of its inertia. There are 4k + 5 if the grasp can open.
    #[must_use]
    pub fn energy_coordinates(&self) -> Vec<f64> {
        self.energy_coordinates_in(&mut [0.0; MAX_COORDINATES]).to_vec()
    }

    /// The energy coordinates, without allocation: those of the state, or computed in a buffer that has room for any order.
    fn energy_coordinates_in<'a>(&'a self, buffer: &'a mut [f64; MAX_COORDINATES]) -> &'a [f64] {
        let Some(modal) = self.modal_of_state() else { return &self.state.coordinates };
        let energy = &mut buffer[..self.model.dynamics.size()];
        modal.energy_coordinates(&self.state.coordinates, energy);
        energy
    }

    /// Returns to the start. Results for the step sizes in use are kept.
    pub fn reset(&mut self) {
        self.state = match &self.contacts {
            None => State::start(&self.parameters, &self.model.dynamics),
            Some(contacts) => contacts.start(&self.parameters),
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

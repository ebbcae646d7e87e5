//! The plant as an explicit system of ordinary differential equations, for an external solver.
//!
//! The states are minimal: the 4k + 1 energy coordinates x, the object's position `y_M`, and the work that was supplied. The
//! hub angles are none, because (12) gives them,
//!
//! ```text
//! θ_i = (w_i(l) + y_M − L/2)/l,    ẋ = A x + B g(u),    ẏ_M = v,    Ė_supplied = gᵀ Bᵀ x,
//! ```
//!
//! so the constraint holds to rounding whatever a solver's error. ½|x|² is the total energy: all x have one scale.
//!
//! A grasp that can open ([`Plant::can_open`]) has seven more, the same in all its modes: the clearances c_i of both tips and their rates,
//! the deformations of both faces, the energy lost. x is then that of the closed grasp with the momentum of tips and object, and
//! l θ_i = w_i(l) + y_M − L/2 ± c_i. Which tips touch is discrete, and changes in [`Plant::update_contacts`] alone.

use super::Plant;
use super::model::Model;
use super::step::all_usable;
use crate::actuator::Actuator;
use crate::contact::{Contacts, MOST_COORDINATES, Relative, SIGN};
use crate::dynamics::{FORCES, Signals, VELOCITY};
use crate::extended::{MAX_COORDINATES, MAX_PANELS};
use crate::kernel::{LANES, dot};
use crate::signals::Inputs;
use crate::state::{Basis, State, StateError};
use parameter_table::StateVariable;

/// Forces on hubs and object, as the states' derivatives need them.
type Forces = [f64; FORCES];

impl Plant {
    /// Number of event indicators: the kinks of the three actuators, and the two contact forces.
    pub const EVENT_INDICATORS: usize = FORCES * Actuator::MAX_KINKS + 2;

    /// Continuous states of a plant of this order k that cannot open, in the order of
    /// [`continuous_states`](Self::continuous_states).
    ///
    /// The unit of energy coordinates, √J, has no integer exponents and is left empty.
    #[must_use]
    pub fn state_variables(order: usize) -> Vec<StateVariable> {
        let coordinates = (1..=4 * order + 1).map(|number| {
            let of = match number - 1 {
                i if i < order => "bending moment of arm 1",
                i if i < 2 * order => "bending moment of arm 2",
                _ => "velocities",
            };
            let description = format!("Energy coordinate {number} ({of}), a square root of twice an energy in J");
            // The paper's grasp holds 6 mJ.
            StateVariable::new(format!("x[{number}]"), "", 0.1, description)
        });
        let others = [
            StateVariable::new(
                "y_object",
                "m",
                0.05,
                "Position y_M of the object's centre; by (12) it gives the hub angles",
            ),
            StateVariable::new("supplied_energy", "J", 0.01, "Work done by actuators and external disturbances"),
        ];
        coordinates.chain(others).collect()
    }

    /// Continuous states that a grasp has besides if it can open.
    pub const CONTACT_STATES: usize = Relative::COUNT;

    /// Number of continuous states: 4k + 3, or 4k + 10 if the grasp can open.
    #[must_use]
    pub fn state_count(&self) -> usize {
        self.model.dynamics.size() + 2 + if self.can_open() { Self::CONTACT_STATES } else { 0 }
    }

    /// Writes the continuous states: x \[√J\], `y_M` \[m\], supplied energy \[J\]; and if the grasp can open, by tip, clearances
    /// \[m\], their rates \[m/s\], deformations of the faces \[m\], and the energy lost \[J\].
    ///
    /// # Panics
    /// If `out` has not [`state_count`](Self::state_count) entries; so do all functions here that take states.
    #[inline(never)]
    pub fn continuous_states(&self, out: &mut [f64]) {
        let (x, others) = self.split_mut(out);
        let (of_grasp, of_contact) = others.split_at_mut(2);
        of_grasp.copy_from_slice(&[self.state.position[2], self.state.supplied_energy]);
        match &self.contacts {
            None => x.copy_from_slice(self.energy_coordinates_in(&mut [0.0; MAX_COORDINATES])),
            Some(contacts) => contacts.states(&self.model.dynamics, &self.state, x).write(of_contact),
        }
    }

    /// Puts the plant into these continuous states; the hub angles follow from (12). What a tip that touches does not have (the
    /// clearance of a rigid face, say) is not read.
    ///
    /// # Errors
    /// If the number of states is another one, or a state is not finite or so large that outputs are not; the plant is then as it was
    /// before.
    #[inline(never)]
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), StateError> {
        let (found, expected) = (states.len(), self.state_count());
        if found != expected {
            return Err(StateError::Length { found, expected });
        }
        if let Some(contacts) = &self.contacts {
            return set_opening_states(&self.model, contacts, &mut self.state, &mut self.signals, states);
        }
        let (coordinates, others) = self.split(states);
        let signals = self.model.dynamics.signals(coordinates);
        if !(all_usable(states) & all_usable(&signals)) {
            return Err(StateError::NotFinite);
        }
        let [y, supplied] = [others[0], others[1]];
        let parameters = &self.model.parameters;
        let angle = |tip: f64| (tip + y - parameters.object_width / 2.0) / parameters.length;
        let [first, second] = self.model.tip_deflection(coordinates).map(angle);
        self.state.position = [first, second, y];
        self.state.carry = [0.0; FORCES];
        self.state.supplied_energy = supplied;
        self.state.basis = Basis::Energy;
        self.state.coordinates.assign(coordinates);
        self.signals = signals;
        self.calm = 0;
        Ok(())
    }

    /// Time derivatives of the continuous states.
    ///
    /// # Panics
    /// See [`continuous_states`](Self::continuous_states).
    #[inline(never)]
    pub fn derivatives(&self, inputs: &Inputs, out: &mut [f64]) {
        let forces = self.model.forces(inputs);
        let velocity = VELOCITY.map(|index| self.signals[index]);
        let (x, others) = self.split_mut(out);
        let (of_grasp, of_contact) = others.split_at_mut(2);
        of_grasp.copy_from_slice(&[velocity[2], dot(&forces, &velocity)]);
        match &self.contacts {
            None => self.motion(self.energy_coordinates_in(&mut [0.0; MAX_COORDINATES]), &forces, x),
            Some(contacts) => contacts.state_rates(&self.model.dynamics, &self.state, &forces, x).write(of_contact),
        }
    }

    /// Brings the contacts up to date with the continuous states and the inputs: closes gaps, which is an impact on rigid faces, and opens
    /// contacts that pull. Returns whether there was anything to do; then states may have jumped, and the inputs that follow from
    /// them. Called once more with the same inputs, there is nothing to do.
    #[inline(never)]
    pub fn update_contacts(&mut self, inputs: &Inputs) -> bool {
        let Some(contacts) = &self.contacts else { return false };
        let forces = self.model.forces(inputs);
        let changed = contacts.update(&mut self.state, &forces);
        if changed {
            self.signals = contacts.signals(&self.state.coordinates);
            place(&self.model, &mut self.state);
        }
        changed
    }

    /// Whether a tip touches and is pulled, or does not and is in the object and goes on into it: a solver that locates no events, or not this
    /// one, sees it by this.
    #[must_use]
    pub fn contact_is_due(&self, inputs: &Inputs) -> bool {
        let Some(contacts) = &self.contacts else { return false };
        contacts.due(&self.state, &self.model.forces(inputs)) != [false; 2]
    }

    /// Event indicators: for each actuator the distances of its command from its kinks, ascending (in the command's unit; 1
    /// where there are fewer than four), then both contact forces \[N\], whose signs decide `in_contact`. If the grasp can open, a tip
    /// that does not touch has its distance from the face \[m\] there, or 1 ms times the rate of that if it is more, and what crosses zero downwards is
    /// a switch:
    /// [`update_contacts`](Self::update_contacts).
    ///
    /// # Panics
    /// If `out` has not [`EVENT_INDICATORS`](Self::EVENT_INDICATORS) entries.
    #[inline(never)]
    pub fn event_indicators(&self, inputs: &Inputs, out: &mut [f64]) {
        let (distances, contact) = out.split_at_mut(FORCES * Actuator::MAX_KINKS);
        distances.fill(1.0);
        let actuators = self.model.actuators.iter().zip(inputs.commands());
        for ((actuator, command), distances) in actuators.zip(distances.chunks_exact_mut(Actuator::MAX_KINKS)) {
            for (distance, kink) in distances.iter_mut().zip(actuator.kinks()) {
                *distance = command - kink;
            }
        }
        contact.copy_from_slice(&match &self.contacts {
            None => self.direct(inputs).contact_force,
            Some(contacts) => contacts.indicators(&self.state, &self.model.forces(inputs)),
        });
    }

    /// A x + B g.
    pub(super) fn motion(&self, x: &[f64], forces: &Forces, out: &mut [f64]) {
        let dynamics = &self.model.dynamics;
        let mut rate = [[0.0; LANES]; MAX_PANELS];
        dynamics.system_panels.multiply(x, &mut rate);
        for (row, (out, rate)) in out.iter_mut().zip(rate.as_flattened()).enumerate() {
            *out = rate + (0..FORCES).map(|force| dynamics.input(row, force) * forces[force]).sum::<f64>();
        }
    }

    /// Energy coordinates, and the other two states.
    pub(super) fn split<'a>(&self, states: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        assert_eq!(states.len(), self.state_count(), "number of states");
        states.split_at(self.model.dynamics.size())
    }

    pub(super) fn split_mut<'a>(&self, states: &'a mut [f64]) -> (&'a mut [f64], &'a mut [f64]) {
        assert_eq!(states.len(), self.state_count(), "number of states");
        states.split_at_mut(self.model.dynamics.size())
    }
}

/// [`Plant::set_continuous_states`] where the grasp can open.
fn set_opening_states(
    model: &Model,
    contacts: &Contacts,
    state: &mut State,
    signals: &mut Signals,
    states: &[f64],
) -> Result<(), StateError> {
    let Some(contact) = state.contact.as_deref_mut() else { return Err(StateError::Contact) };
    let (x, others) = states.split_at(model.dynamics.size());
    let mut buffer = [0.0; MOST_COORDINATES];
    let coordinates = &mut buffer[..state.coordinates.len()];
    let given = Relative::read(&others[2..]);
    let relative = contacts.reduce(&model.dynamics, contact.touching, x, &given, coordinates);
    let new_signals = contacts.signals(coordinates);
    if !(all_usable(states) & all_usable(coordinates) & all_usable(&new_signals)) {
        return Err(StateError::NotFinite);
    }
    (contact.clearance, contact.loss) = (relative.clearance, relative.loss);
    state.basis = Basis::Energy;
    state.coordinates.copy_from_slice(coordinates);
    state.supplied_energy = others[1];
    state.position[2] = others[0];
    place(model, state);
    *signals = new_signals;
    Ok(())
}

/// Puts the hubs where tips and clearances say.
fn place(model: &Model, state: &mut State) {
    let p = &model.parameters;
    let tips = model.tip_deflection(&state.coordinates);
    let clearance = state.contact.as_deref().map_or([0.0; 2], |contact| contact.clearance);
    for i in 0..2 {
        let above = state.position[2] - p.object_width / 2.0 + SIGN[i] * clearance[i];
        state.position[i] = (tips[i] + above) / p.length;
    }
    state.carry = [0.0; FORCES];
}

//! The plant as an explicit system of ordinary differential equations, for an external solver.
//!
//! The states are minimal: the 4k + 1 energy coordinates x, the object's position `y_M`, and the work that was supplied. The
//! hub angles are none, because (12) gives them,
//!
//! ```text
//! θ_i = (w_i(l) + y_M − L/2)/l,    ẋ = A x + B g(u),    ẏ_M = v,    Ė_supplied = gᵀ Bᵀ x,
//! ```
//!
//! so the constraint holds to rounding whatever a solver's error. ½|x|² is the total energy: all x have one scale. A grasp that
//! can open ([`Plant::can_open`]) has no such form.

use super::Plant;
use super::model::Model;
use super::outputs::{measured, uncertainty};
use super::step::all_usable;
use crate::actuator::Actuator;
use crate::dynamics::{FORCES, VELOCITY};
use crate::extended::{MAX_COORDINATES, MAX_PANELS};
use crate::kernel::{LANES, dot};
use crate::signals::{Inputs, Rates};
use crate::state::{Basis, StateError};
use parameter_table::StateVariable;

/// Forces on hubs and object, as the states' derivatives need them.
type Forces = [f64; FORCES];

impl Plant {
    /// Number of event indicators: the kinks of the three actuators, and the two contact forces.
    pub const EVENT_INDICATORS: usize = FORCES * Actuator::MAX_KINKS + 2;

    /// Continuous states of a plant of this order k, in the order of [`continuous_states`](Self::continuous_states).
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

    /// Number of continuous states, 4k + 3.
    #[must_use]
    pub fn state_count(&self) -> usize {
        self.model.dynamics.size() + 2
    }

    /// Writes the continuous states: x \[√J\], `y_M` \[m\], supplied energy \[J\].
    ///
    /// # Panics
    /// If `out` has not [`state_count`](Self::state_count) entries; so do all functions here that take states.
    pub fn continuous_states(&self, out: &mut [f64]) {
        let (coordinates, others) = self.split_mut(out);
        coordinates.copy_from_slice(self.energy_coordinates_in(&mut [0.0; MAX_COORDINATES]));
        others.copy_from_slice(&[self.state.position[2], self.state.supplied_energy]);
    }

    /// Puts the plant into these continuous states; the hub angles follow from (12).
    ///
    /// # Errors
    /// If the grasp can open, the number of states is another one, or a state is not finite or so large that outputs are not; the plant is
    /// then as it was before.
    pub fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), StateError> {
        let (found, expected) = (states.len(), self.state_count());
        if found != expected {
            return Err(StateError::Length { found, expected });
        }
        if self.can_open() {
            return Err(StateError::Contact);
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
        self.state.coordinates.clear();
        self.state.coordinates.extend_from_slice(coordinates);
        self.signals = signals;
        Ok(())
    }

    /// Time derivatives of the continuous states.
    ///
    /// # Panics
    /// See [`continuous_states`](Self::continuous_states).
    pub fn derivatives(&self, inputs: &Inputs, out: &mut [f64]) {
        let forces = self.model.forces(inputs);
        let velocity = VELOCITY.map(|index| self.signals[index]);
        let (coordinates, others) = self.split_mut(out);
        let mut buffer = [0.0; MAX_COORDINATES];
        self.motion(self.energy_coordinates_in(&mut buffer), &forces, coordinates);
        others.copy_from_slice(&[velocity[2], dot(&forces, &velocity)]);
    }

    /// The exact product of the Jacobian of [`derivatives`](Self::derivatives) with a direction of states and inputs. At a
    /// kink of an actuator it is that of the flat side.
    ///
    /// # Panics
    /// See [`continuous_states`](Self::continuous_states).
    pub fn derivative_change(&self, inputs: &Inputs, states: &[f64], direction: &Inputs, out: &mut [f64]) {
        let (x, _) = self.split(states);
        let (forces, force_change) = (self.model.forces(inputs), self.model.force_rates(inputs, direction));
        let signals = self.model.dynamics.signals(x);
        let (velocity, change) = (VELOCITY.map(|index| self.signals[index]), VELOCITY.map(|index| signals[index]));
        let (coordinates, others) = self.split_mut(out);
        self.motion(x, &force_change, coordinates);
        others.copy_from_slice(&[change[2], dot(&force_change, &velocity) + dot(&forces, &change)]);
    }

    /// The exact change of all outputs along a direction of states and inputs.
    ///
    /// # Panics
    /// See [`continuous_states`](Self::continuous_states).
    #[must_use]
    pub fn output_change(&self, inputs: &Inputs, states: &[f64], direction: &Inputs) -> Rates {
        let Model { dynamics, parameters, .. } = &*self.model;
        let (x, others) = self.split(states);
        let (y, supplied) = (others[0], others[1]);
        let signals = dynamics.signals(x);
        let tip_deflection = self.model.tip_deflection(x);
        let [first, second] = tip_deflection.map(|tip| (tip + y) / parameters.length);
        let response = self.model.command_response(inputs, direction);
        Rates {
            measured: measured(&[first, second, y], &signals),
            direct: self.model.direct(&signals, &response, &direction.disturbances()),
            uncertainty: uncertainty(parameters, &signals),
            deflection: [0, 1].map(|arm| dynamics.deflection(arm, x)),
            tip_deflection,
            // By (12), from which the angles follow.
            constraint: [0.0; 2],
            energy: dot(self.energy_coordinates_in(&mut [0.0; MAX_COORDINATES]), x),
            supplied_energy: supplied,
            contact: crate::Contact::default(),
        }
    }

    /// Event indicators: for each actuator the distances of its command from its kinks, ascending (in the command's unit; 1
    /// where there are fewer than four), then both contact forces \[N\], whose signs decide `in_contact`.
    ///
    /// # Panics
    /// If `out` has not [`EVENT_INDICATORS`](Self::EVENT_INDICATORS) entries.
    pub fn event_indicators(&self, inputs: &Inputs, out: &mut [f64]) {
        let (distances, contact) = out.split_at_mut(FORCES * Actuator::MAX_KINKS);
        distances.fill(1.0);
        let actuators = self.model.actuators.iter().zip(inputs.commands());
        for ((actuator, command), distances) in actuators.zip(distances.chunks_exact_mut(Actuator::MAX_KINKS)) {
            for (distance, kink) in distances.iter_mut().zip(actuator.kinks()) {
                *distance = command - kink;
            }
        }
        contact.copy_from_slice(&self.direct(inputs).contact_force);
    }

    /// A x + B g.
    fn motion(&self, x: &[f64], forces: &Forces, out: &mut [f64]) {
        let dynamics = &self.model.dynamics;
        let mut rate = [[0.0; LANES]; MAX_PANELS];
        dynamics.system_panels.multiply(x, &mut rate);
        for (row, (out, rate)) in out.iter_mut().zip(rate.as_flattened()).enumerate() {
            *out = rate + (0..FORCES).map(|force| dynamics.input(row, force) * forces[force]).sum::<f64>();
        }
    }

    /// Energy coordinates, and the other two states.
    fn split<'a>(&self, states: &'a [f64]) -> (&'a [f64], &'a [f64]) {
        assert_eq!(states.len(), self.state_count(), "number of states");
        states.split_at(self.model.dynamics.size())
    }

    fn split_mut<'a>(&self, states: &'a mut [f64]) -> (&'a mut [f64], &'a mut [f64]) {
        assert_eq!(states.len(), self.state_count(), "number of states");
        states.split_at_mut(self.model.dynamics.size())
    }
}

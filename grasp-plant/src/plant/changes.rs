//! The Jacobian of the differential equations and of the outputs, as exact products with directions.

use super::Plant;
use super::model::Model;
use super::outputs::{held, measured, opening_direct, uncertainty};
use crate::contact::{Contact, MOST_COORDINATES, Relative, SIGN};
use crate::dynamics::{Signals, VELOCITY};
use crate::extended::MAX_COORDINATES;
use crate::kernel::dot;
use crate::signals::{Inputs, Rates};

/// A change of the states, as coordinates and what is read of them.
struct Change<'a> {
    coordinates: &'a [f64],
    signals: Signals,
    y: f64,
    supplied: f64,
    relative: Relative,
}

impl Plant {
    /// The exact product of the Jacobian of [`derivatives`](Self::derivatives) with a direction of states and inputs. At a
    /// kink of an actuator it is that of the flat side.
    ///
    /// # Panics
    /// See [`continuous_states`](Self::continuous_states).
    #[inline(never)]
    pub fn derivative_change(&self, inputs: &Inputs, states: &[f64], direction: &Inputs, out: &mut [f64]) {
        let (forces, force_change) = (self.model.forces(inputs), self.model.force_rates(inputs, direction));
        let mut buffer = [0.0; MOST_COORDINATES];
        let Change { coordinates, signals, .. } = self.change(states, &mut buffer);
        let (velocity, change) = (VELOCITY.map(|index| self.signals[index]), VELOCITY.map(|index| signals[index]));
        let (x, others) = self.split_mut(out);
        let (of_grasp, of_contact) = others.split_at_mut(2);
        of_grasp.copy_from_slice(&[change[2], dot(&force_change, &velocity) + dot(&forces, &change)]);
        let Model { dynamics, .. } = &*self.model;
        match &self.contacts {
            None => self.motion(coordinates, &force_change, x),
            Some(contacts) => {
                contacts.state_rate_change(dynamics, &self.state, coordinates, &force_change, x).write(of_contact);
            }
        }
    }

    /// The exact change of all outputs along a direction of states and inputs.
    ///
    /// # Panics
    /// See [`continuous_states`](Self::continuous_states).
    #[must_use]
    #[inline(never)]
    pub fn output_change(&self, inputs: &Inputs, states: &[f64], direction: &Inputs) -> Rates {
        let Model { dynamics, parameters, .. } = &*self.model;
        let mut buffer = [0.0; MOST_COORDINATES];
        let Change { coordinates: x, signals, y, supplied, relative } = self.change(states, &mut buffer);
        let tip_deflection = self.model.tip_deflection(x);
        let [first, second] =
            [0, 1].map(|i| (tip_deflection[i] + y + SIGN[i] * relative.clearance[i]) / parameters.length);
        let response = self.model.command_response(inputs, direction);
        let (direct, contact) = match &self.contacts {
            None => (self.model.direct(&signals, &response, &direction.disturbances()), Contact::default()),
            Some(contacts) => {
                let (forces, by) = (self.model.forces(inputs), self.model.force_rates(inputs, direction));
                let force = contacts.force_change(&self.state, &forces, x, &by);
                let gap = contacts.gap_change(&self.state, &relative);
                let contact = Contact { gap, indentation: relative.indentation, loss: relative.loss };
                (opening_direct(&response, force), contact)
            }
        };
        Rates {
            measured: measured(&[first, second, y], &signals),
            direct,
            uncertainty: held(self.state.contact.as_deref(), uncertainty(parameters, &signals)),
            deflection: [0, 1].map(|arm| dynamics.deflection(arm, x)),
            tip_deflection,
            // By (12), from which the angles follow. No negative zeros.
            constraint: [0, 1].map(|i| 0.0 + SIGN[i] * relative.clearance[i]),
            energy: dot(self.energy_coordinates_in(&mut [0.0; MAX_COORDINATES]), x),
            supplied_energy: supplied,
            contact,
        }
    }

    /// What a change of the states is a change of.
    fn change<'a>(&self, states: &'a [f64], buffer: &'a mut [f64; MOST_COORDINATES]) -> Change<'a> {
        let Model { dynamics, .. } = &*self.model;
        let (x, others) = self.split(states);
        let [y, supplied] = [others[0], others[1]];
        let Some(contacts) = &self.contacts else {
            let signals = dynamics.signals(x);
            return Change { coordinates: x, signals, y, supplied, relative: Relative::default() };
        };
        let touching = self.state.contact.as_deref().map_or([false; 2], |contact| contact.touching);
        let coordinates = &mut buffer[..self.state.coordinates.len()];
        let relative = contacts.reduce(dynamics, touching, x, &Relative::read(&others[2..]), coordinates);
        Change { signals: contacts.signals(coordinates), coordinates, y, supplied, relative }
    }
}

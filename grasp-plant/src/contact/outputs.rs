//! Outputs of a grasp that can open, and their derivatives.

use super::layout::SIGN;
use super::mode::Mode;
use super::{Contacts, Modes};
use crate::dynamics::FORCES;
use crate::state::State;

/// The contacts (or their time derivatives).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Distance between each tip and the face of the object \[m\]: zero while they touch.
    pub gap: [f64; 2],
    /// How far each face of a compliant object is pressed in \[m\].
    pub indentation: [f64; 2],
    /// Energy lost in impacts and in the object's faces since the start \[J\].
    pub loss: f64,
}

/// The rates of everything that moves, at one moment.
pub(crate) struct Moment {
    /// Of the coordinates, then padding.
    pub coordinates: super::piece::Scratch,
    /// Of the contact forces.
    pub force: [f64; 2],
    /// Of the contacts.
    pub contact: Contact,
}

impl Contacts {
    /// The contact forces with g applied, and the mode that follows.
    pub(super) fn pushing(&self, state: &State, forces: &[f64; FORCES]) -> ([f64; 2], &Mode) {
        let (modes, x) = (&*self.modes, &state.coordinates[..]);
        let touching = state.contact.as_deref().map_or([false; 2], |contact| contact.touching);
        if modes.rigid {
            let (force, pushing) = modes.pushing(x, forces, touching, Modes::magnitude(x, forces));
            return (force, modes.mode(pushing));
        }
        let mode = modes.mode(touching);
        ([0, 1].map(|side| mode.force(side, x, forces).max(0.0)), mode)
    }

    /// The contact forces with g applied \[N\]: positive in compression, zero where nothing touches.
    pub fn force(&self, state: &State, forces: &[f64; FORCES]) -> [f64; 2] {
        self.pushing(state, forces).0
    }

    /// Their change with a change of the forces.
    pub fn force_derivative(&self, state: &State, forces: &[f64; FORCES], change: &[f64; FORCES]) -> [f64; 2] {
        let mode = self.pushing(state, forces).1;
        [0, 1].map(|side| mode.force(side, &[], change))
    }

    /// Gaps, faces, losses.
    pub fn contact(&self, state: &State) -> Contact {
        let Some(contact) = state.contact.as_deref() else { return Contact::default() };
        let indentation = self.indentation(&state.coordinates);
        let gap = [0, 1].map(|side| {
            if contact.touching[side] { 0.0 } else { (contact.clearance[side] + indentation[side]).max(0.0) }
        });
        Contact { gap, indentation, loss: contact.loss }
    }

    pub(super) fn indentation(&self, x: &[f64]) -> [f64; 2] {
        if self.modes.rigid {
            return [0.0; 2];
        }
        [0, 1].map(|side| x[self.modes.layout.face(side)] / self.modes.faces[side].stiffness.sqrt())
    }

    /// The rates with g applied and changing at r.
    pub fn moment(&self, state: &State, forces: &[f64; FORCES], force_rates: &[f64; FORCES]) -> Moment {
        let (modes, x) = (&*self.modes, &state.coordinates[..]);
        let mode = self.pushing(state, forces).1;
        let touching = mode.touching;
        let coordinates = modes.rates(touching, x, forces);
        let rates = &coordinates.as_flattened()[..modes.layout.size()];
        let indentation = self.indentation(rates);
        let mut contact = Contact { indentation, ..Contact::default() };
        for side in 0..2 {
            contact.loss += modes.loss_rate(touching, x, x, side);
            if !touching[side] {
                contact.gap[side] = modes.opening_rate(x, side) + indentation[side];
            }
        }
        let force = [0, 1].map(|side| mode.force(side, rates, force_rates));
        Moment { coordinates, force, contact }
    }

    /// λ_i of contact forces.
    pub fn lambda(force: [f64; 2]) -> [f64; 2] {
        // No negative zeros.
        [0, 1].map(|side| 0.0 + SIGN[side] * force[side])
    }
}

//! A grasp that can open as differential equations whose states are the same in all modes.
//!
//! # States
//! x are the 4k + 1 energy coordinates of a closed grasp (see [`dynamics`](crate::dynamics)), with tips and object at the velocity
//! q/√m of their common centre of mass, q = (m_1 v_1(l) + m_2 v_2(l) + M ẏ_M)/√m, m = m_1 + m_2 + M. Beside them stands what a closed
//! grasp does not have ([`Relative`]): clearances, their rates ġ_i = σ_i (v_i(l) − ẏ_M), the faces' deformations, what was lost. Then
//!
//! ```text
//! ẏ_M = q/√m − Σ m_i σ_i ġ_i/m,     v_i(l) = ẏ_M + σ_i ġ_i,     l θ_i = w_i(l) + y_M − L/2 + σ_i c_i.
//! ```
//!
//! An impact changes no q: what jumps are the rates ġ_i alone, and where a rigid side touches, c_i = ġ_i = 0.
//!
//! # Modes
//! From the states to a mode's coordinates leads a reduction P, back a lift L, P L = 1, and the derivatives are L f_mode(P x). P puts to zero
//! what a mode does not have: so a solver may hand in states that no motion leads to, and none of it is felt.
//!
//! # Switches
//! Which sides touch stays as it is until [`Contacts::update`]. An indicator falls through zero when a side has to switch: the contact force
//! of a mode that goes on; or the larger one of the distance d_i from the face and of τ (ḋ_i + ε), ε being slower than any impact that
//! could bounce. For a solver's error may well be larger than the bounces of rigid faces, and have a tip that leaves one a little inside; that
//! is no matter while it does not move in. After an event no indicator is zero, as FMI 2.0 asks for: a gap's is at least τ ε then, and a force is
//! raised by its rounding. A solver that finds no events leaves gaps that have gone too deep: they are closed where they are found.

use super::layout::SIGN;
use super::{Contacts, Modes};
use crate::dynamics::{Dynamics, FORCES};
use crate::state::State;

/// Rigid gaps that close within this time after another one \[s\] close with it. Solvers put two arms that do the same that far
/// apart.
const SIMULTANEOUS: f64 = 1e-9;

/// τ: so long a way of a tip counts like its distance \[s\].
const WAY: f64 = 1e-3;

/// ε \[m/s\]: less than any `plastic_speed`, more than rounding.
const SLOW: f64 = 1e-10;

/// What forces are raised by besides their rounding \[N\].
const RAISED: f64 = 1e-24;

/// Switches at one instant after which the contacts are left as they are. Two sides can need four.
const MOST_AT_ONCE: u32 = 64;

/// What a closed grasp does not have, or the time derivatives of that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Relative {
    /// Distance of each tip from the object's undeformed face \[m\].
    pub clearance: [f64; 2],
    /// Its rate \[m/s\].
    pub opening: [f64; 2],
    /// How far each face is pressed in \[m\]. While a tip touches it, that is what the clearance says.
    pub indentation: [f64; 2],
    /// Energy lost in impacts and faces \[J\].
    pub loss: f64,
}

impl Relative {
    /// Number of states.
    pub const COUNT: usize = 7;

    /// # Panics
    /// If these are not [`COUNT`](Self::COUNT).
    pub fn read(states: &[f64]) -> Self {
        let pair = |first: usize| [states[first], states[first + 1]];
        Self { clearance: pair(0), opening: pair(2), indentation: pair(4), loss: states[6] }
    }

    /// # Panics
    /// If there is no room for [`COUNT`](Self::COUNT).
    pub fn write(&self, states: &mut [f64]) {
        let pairs = [self.clearance, self.opening, self.indentation];
        states[..6].copy_from_slice(pairs.as_flattened());
        states[6] = self.loss;
    }
}

impl Contacts {
    /// L without clearances and losses: x, and rates and deformations, from coordinates or their time derivatives.
    fn lift(&self, dynamics: &Dynamics, coordinates: &[f64], x: &mut [f64]) -> Relative {
        let (modes, layout) = (&*self.modes, self.modes.layout);
        let (common, others) = x.split_at_mut(layout.tip(0));
        common.copy_from_slice(&coordinates[..layout.tip(0)]);
        let momentum = modes.object_mass.sqrt() * coordinates[layout.object()]
            + (0..2).map(|i| modes.tip_masses[i].sqrt() * coordinates[layout.tip(i)]).sum::<f64>();
        others[0] = momentum / modes.moving_mass().sqrt();
        dynamics.reflect(&mut x[layout.field(0)..]);
        Relative {
            opening: [0, 1].map(|i| modes.opening_rate(coordinates, i)),
            indentation: self.indentation(coordinates),
            ..Relative::default()
        }
    }

    /// P: coordinates from states or a change of them. Returns the rest of the states, as it is in this mode.
    pub fn reduce(
        &self,
        dynamics: &Dynamics,
        touching: [bool; 2],
        x: &[f64],
        given: &Relative,
        coordinates: &mut [f64],
    ) -> Relative {
        let (modes, layout) = (&*self.modes, self.modes.layout);
        let mut relative = *given;
        for i in 0..2 {
            if modes.rigid && touching[i] {
                (relative.clearance[i], relative.opening[i]) = (0.0, 0.0);
            }
            relative.indentation[i] = match (modes.rigid, touching[i]) {
                (false, true) => -relative.clearance[i],
                // One without damping is back at once.
                (false, false) if modes.faces[i].damping > 0.0 => relative.indentation[i],
                _ => 0.0,
            };
        }
        // The last velocity's place is the first tip's.
        let (of_grasp, of_masses) = coordinates.split_at_mut(layout.tip(0) + 1);
        of_grasp.copy_from_slice(x);
        dynamics.reflect(&mut of_grasp[layout.field(0)..]);
        let mass = modes.moving_mass();
        let share = (0..2).map(|i| modes.tip_masses[i] * SIGN[i] * relative.opening[i]).sum::<f64>() / mass;
        let object = of_grasp[layout.tip(0)] / mass.sqrt() - share;
        let tips = [0, 1].map(|i| modes.tip_masses[i].sqrt() * (object + SIGN[i] * relative.opening[i]));
        of_grasp[layout.tip(0)] = tips[0];
        of_masses[0] = tips[1];
        of_masses[1] = modes.object_mass.sqrt() * object;
        for i in 0..2 {
            of_masses[2 + i] = modes.faces[i].stiffness.sqrt() * relative.indentation[i];
        }
        relative
    }

    /// The states.
    pub fn states(&self, dynamics: &Dynamics, state: &State, x: &mut [f64]) -> Relative {
        let contact = state.contact.as_deref().copied().unwrap_or_default();
        let relative = self.lift(dynamics, &state.coordinates, x);
        let closed = [0, 1].map(|i| self.modes.rigid && contact.touching[i]);
        Relative {
            clearance: contact.clearance,
            // Of masses that move together the difference is rounding.
            opening: [0, 1].map(|i| if closed[i] { 0.0 } else { relative.opening[i] }),
            loss: contact.loss,
            ..relative
        }
    }

    /// The states' time derivatives with g applied.
    pub fn state_rates(&self, dynamics: &Dynamics, state: &State, forces: &[f64; FORCES], x: &mut [f64]) -> Relative {
        let modes = &*self.modes;
        let touching = touching(state);
        let relative = self.relative_rates(dynamics, touching, &state.coordinates, forces, x);
        let losses = [0, 1].map(|i| modes.loss_rate(touching, &state.coordinates, &state.coordinates, i));
        Relative { loss: losses[0] + losses[1], ..relative }
    }

    /// Their change with a change of the coordinates, which [`Self::reduce`] gives, and of the forces.
    pub fn state_rate_change(
        &self,
        dynamics: &Dynamics,
        state: &State,
        change: &[f64],
        force_change: &[f64; FORCES],
        x: &mut [f64],
    ) -> Relative {
        let modes = &*self.modes;
        let touching = touching(state);
        let relative = self.relative_rates(dynamics, touching, change, force_change, x);
        let losses = [0, 1].map(|i| 2.0 * modes.loss_rate(touching, &state.coordinates, change, i));
        Relative { loss: losses[0] + losses[1], ..relative }
    }

    /// Linear in coordinates and forces: all but losses.
    fn relative_rates(
        &self,
        dynamics: &Dynamics,
        touching: [bool; 2],
        coordinates: &[f64],
        forces: &[f64; FORCES],
        x: &mut [f64],
    ) -> Relative {
        let modes = &*self.modes;
        let rates = modes.rates(touching, coordinates, forces);
        let relative = self.lift(dynamics, &rates.as_flattened()[..modes.layout.size()], x);
        let free = |i: usize, value: f64| if modes.rigid && touching[i] { 0.0 } else { value };
        Relative {
            clearance: [0, 1].map(|i| free(i, modes.opening_rate(coordinates, i))),
            opening: [0, 1].map(|i| free(i, relative.opening[i])),
            ..relative
        }
    }

    /// The contact forces' change with the coordinates and the forces.
    pub fn force_change(&self, state: &State, forces: &[f64; FORCES], change: &[f64], by: &[f64; FORCES]) -> [f64; 2] {
        let (now, mode) = self.pushing(state, forces);
        [0, 1].map(|i| if self.modes.rigid || now[i] > 0.0 { mode.force(i, change, by) } else { 0.0 })
    }

    /// The gaps' change with clearances and deformations.
    pub fn gap_change(&self, state: &State, change: &Relative) -> [f64; 2] {
        let contact = state.contact.as_deref().copied().unwrap_or_default();
        let indentation = self.indentation(&state.coordinates);
        [0, 1].map(|i| {
            let open = !contact.touching[i] && contact.clearance[i] + indentation[i] >= 0.0;
            if open { change.clearance[i] + change.indentation[i] } else { 0.0 }
        })
    }

    /// What must not become negative on each side: the contact force \[N\] where it touches, else the distance from the face \[m\], or
    /// τ (ḋ + ε) if that is more.
    pub fn indicators(&self, state: &State, forces: &[f64; FORCES]) -> [f64; 2] {
        let (modes, x) = (&*self.modes, &state.coordinates[..]);
        let contact = state.contact.as_deref().copied().unwrap_or_default();
        let indentation = self.indentation(x);
        // Twice, so that what has fallen through zero counts as pulling.
        let noise = if modes.rigid { 2.0 * modes.noise(Modes::magnitude(x, forces)) } else { 0.0 };
        [0, 1].map(|i| {
            if contact.touching[i] {
                let rounding = noise / modes.delassus.diagonal[i];
                modes.mode(contact.touching).force(i, x, forces) + rounding + RAISED
            } else {
                (contact.clearance[i] + indentation[i]).max(WAY * (modes.gap_rate(x, i) + SLOW))
            }
        })
    }

    /// Sides that are closed or open, and cannot stay so.
    pub fn due(&self, state: &State, forces: &[f64; FORCES]) -> [bool; 2] {
        self.indicators(state, forces).map(|indicator| indicator <= 0.0)
    }

    /// Switches the sides that have to. Returns whether there was one.
    pub fn update(&self, state: &mut State, forces: &[f64; FORCES]) -> bool {
        (0..MOST_AT_ONCE).take_while(|_| self.switch(state, forces)).count() > 0
    }

    fn switch(&self, state: &mut State, forces: &[f64; FORCES]) -> bool {
        let (modes, due) = (&*self.modes, self.due(state, forces));
        let State { coordinates: x, contact, .. } = state;
        let Some(contact) = contact.as_deref_mut() else { return false };
        if !modes.rigid {
            for i in (0..2).filter(|i| due[*i]) {
                if contact.touching[i] {
                    modes.leave(x, contact, i);
                } else {
                    modes.meet(x, contact, i);
                }
            }
            return due != [false; 2];
        }
        let closing = [0, 1].map(|i| due[i] && !contact.touching[i]);
        if closing != [false; 2] {
            let closing = modes.closing_with(x, contact, closing, SIMULTANEOUS);
            modes.hit(x, forces, contact, closing);
            return true;
        }
        let (_, pushing) = modes.pushing(x, forces, contact.touching, Modes::magnitude(x, forces));
        if pushing == contact.touching {
            return false;
        }
        modes.touch(x, contact, pushing);
        true
    }
}

fn touching(state: &State) -> [bool; 2] {
    state.contact.as_deref().map_or([false; 2], |contact| contact.touching)
}

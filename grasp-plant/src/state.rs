//! The state of the plant, and the reasons for which a step or a state is refused.

use crate::contact::ContactState;
use crate::coordinates::Coordinates;
use crate::dynamics::{Dynamics, FORCES};
use crate::initial;
use crate::modal::Four;
use crate::parameters::Parameters;
use crate::step_sizes::StepSizes;
use serde::{Deserialize, Serialize};
use std::mem::offset_of;

/// The meaning of the coordinates of a [`State`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Basis {
    /// Energy coordinates x, 4k + 1 of them: ½|x|² is the total energy. A plant starts with them, and keeps them if its
    /// modes are too close to each other.
    #[default]
    Energy,
    /// Modal coordinates, which a plant uses from its first step on:
    /// [`Plant::energy_coordinates`](crate::Plant::energy_coordinates) converts them.
    Modal,
    /// Modal coordinates of equal arms: of what both do alike, then of what they do against each other.
    EvenAndOdd,
}

/// Everything that changes while the plant moves. Together with [`Parameters`] it determines the further motion.
// What is unsafe relies on the places of the fields, and on nothing in them.
#[allow(clippy::unsafe_derive_deserialize)]
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C)] // The step sizes, of which a step needs the last, behind what it needs all of.
pub struct State {
    /// The meaning of the coordinates.
    pub basis: Basis,
    /// The moments and velocities of arms and object \[√J\] in this basis. 4k + 5 energy coordinates if the grasp can open.
    pub coordinates: Coordinates,
    /// θ_1 \[rad\], θ_2 \[rad\], `y_M` \[m\].
    pub position: [f64; 3],
    /// The parts that rounding has kept from being added to the positions so far (compensated summation). At rest,
    /// increments are below half a unit in the last place of the positions, but not of the beams' coordinates, and (12)
    /// couples the two.
    pub carry: [f64; 3],
    /// Work done on the plant by actuators and external disturbances since the start \[J\].
    pub supplied_energy: f64,
    /// The step sizes so far, which decide how the next step is computed.
    pub sizes: StepSizes,
    /// The contacts, where they can open.
    pub contact: Option<Box<ContactState>>,
}

/// Positions, what rounding has kept from being added to them, and the supplied energy: as they stand side by side in a [`State`].
pub(crate) type Positions = [f64; 2 * FORCES + 1];

impl Clone for State {
    fn clone(&self) -> Self {
        let mut state = Self::default();
        state.clone_from(self);
        state
    }

    /// In the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        let Self { basis, coordinates, position, carry, supplied_energy, sizes, contact } = source;
        (self.basis, self.position, self.carry) = (*basis, *position, *carry);
        (self.supplied_energy, self.sizes) = (*supplied_energy, *sizes);
        self.coordinates.clone_from(coordinates);
        self.contact.clone_from(contact);
    }
}

impl State {
    /// The state at the start.
    pub(crate) fn start(parameters: &Parameters, dynamics: &Dynamics) -> Self {
        let start = &parameters.start;
        Self {
            basis: Basis::Energy,
            coordinates: initial::coordinates(parameters, dynamics).into(),
            position: [start.theta[0], start.theta[1], start.y_object],
            carry: [0.0; 3],
            supplied_energy: 0.0,
            sizes: StepSizes::default(),
            contact: None,
        }
    }

    /// The coordinates; and positions, what rounding has kept from being added to them, and the supplied energy, which stand side by side.
    #[inline]
    pub(crate) fn coordinates_and_motion(&mut self) -> (&mut Coordinates, &mut Positions) {
        const { assert!(offset_of!(Self, carry) - offset_of!(Self, position) == size_of::<[f64; FORCES]>()) };
        const { assert!(offset_of!(Self, supplied_energy) - offset_of!(Self, carry) == size_of::<[f64; FORCES]>()) };
        let state = std::ptr::from_mut(self);
        // SAFETY: a field, and the numbers of three others, without gaps.
        unsafe { (&mut (*state).coordinates, &mut *state.byte_add(offset_of!(Self, position)).cast()) }
    }

    /// As [`travel`](Self::travel), from where the [motion](Self::coordinates_and_motion) is; and adds to the supplied energy what stands in
    /// the last lane.
    #[allow(clippy::inline_always)] // Into a function for wide registers, or the compiler does not use these registers.
    #[inline(always)]
    pub(crate) fn travel_in_lanes<V: Four>(motion: &mut Positions, travel: V) {
        let first = |motion: &[f64; 7]| V::load(motion.first_chunk().unwrap_or(&[0.0; 4]));
        let last = |motion: &[f64; 7]| V::load(motion.last_chunk().unwrap_or(&[0.0; 4]));
        // Behind the positions comes the first of what is carried, and behind that the energy.
        let (position, increment) = (first(motion), last(motion).plus(travel));
        let next = position.plus(increment);
        let carry = increment.minus(next.minus(position));
        motion[..4].copy_from_slice(&next.lanes());
        motion[3..].copy_from_slice(&carry.with_last_of(increment).lanes());
    }

    /// Adds to the positions and keeps the rounding error for the next time.
    pub(crate) fn travel(&mut self, from: &Self, travel: &[f64; FORCES]) {
        (self.position, self.carry) = travelled(&from.position, &from.carry, travel);
    }
}

/// Positions after a travel, and what rounding has kept from being added to them.
#[inline]
pub(crate) fn travelled(
    from: &[f64; FORCES],
    carry: &[f64; FORCES],
    travel: &[f64; FORCES],
) -> ([f64; FORCES], [f64; FORCES]) {
    let increment: [f64; FORCES] = std::array::from_fn(|i| carry[i] + travel[i]);
    let position: [f64; FORCES] = std::array::from_fn(|i| from[i] + increment[i]);
    (position, std::array::from_fn(|i| increment[i] - (position[i] - from[i])))
}

/// Why a step was refused. The plant is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The step size is not a positive finite number.
    #[error("step size {h} s is not positive and finite")]
    NotPositive {
        /// The step size \[s\].
        h: f64,
    },
    /// The step is longer than [`Plant::longest_step`](crate::Plant::longest_step).
    #[error("step size {h:e} s is longer than {longest:e} s, the longest for these parameters")]
    TooLong {
        /// The step size \[s\].
        h: f64,
        /// The longest admissible one \[s\].
        longest: f64,
    },
    /// An input or an input's derivative is infinite or not a number.
    #[error("an input or its derivative is not finite")]
    InputNotFinite,
    /// The state, or the outputs that follow from it, would leave the range of floating-point numbers.
    #[error("the state would overflow")]
    Overflow,
    /// The contacts switch too often, or too often at one instant.
    #[error("a step of {h:e} s cannot be resolved: the contacts switch more than {switches} times; take a shorter one")]
    Unresolved {
        /// The step size \[s\].
        h: f64,
        /// Switches that were resolved.
        switches: u32,
    },
    /// A rigid contact opens and closes without end, since ΔF ends with it and the damped arm pushes the tip back.
    #[error(
        "a step of {h:e} s has no end: after {switches} switches a contact neither stays closed nor open, as rigid faces may with \
         kelvin_voigt and tip_uncertainty together; set one of these to 0, or contact_model to compliant"
    )]
    Endless {
        /// The step size \[s\].
        h: f64,
        /// Switches that were resolved.
        switches: u32,
    },
}

/// Why a [`State`] was refused. The plant is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// The state is one of another order.
    #[error("a state of {found} coordinates does not fit a plant of {expected}")]
    Length {
        /// Number of coordinates of the refused state.
        found: usize,
        /// Number of coordinates of this plant.
        expected: usize,
    },
    /// The state has modal coordinates, but a plant of these parameters has none.
    #[error("the state has modal coordinates that a plant of these parameters does not have")]
    NotModal,
    /// A number in the state is infinite or not a number.
    #[error("the state has an entry that is not finite")]
    NotFinite,
    /// The state is one of a grasp that can open, and this one cannot, or the other way round.
    #[error("the state belongs to another contact model")]
    Contact,
}

//! What goes in and out of a controller, by the names of the interface.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use crate::blocks::four::Four;
use serde::{Deserialize, Serialize};

/// Number of inputs of every controller: fourteen measurements and two references.
pub const INPUTS: usize = 16;

/// Names of the inputs, in the order of [`Inputs::to_array`] and of every Jacobian row.
pub const INPUT_NAMES: [&str; INPUTS] = [
    "theta1",
    "theta2",
    "theta1_dot",
    "theta2_dot",
    "y_object",
    "y_object_dot",
    "root_moment1",
    "root_moment2",
    "tip_shear1",
    "tip_shear2",
    "tip_shear1_dot",
    "tip_shear2_dot",
    "root_moment1_dot",
    "root_moment2_dot",
    "lambda1_ref",
    "theta1_ref",
];

/// Columns of the inputs in a Jacobian row; per-arm signals give the column of arm 1, arm 2 follows it.
pub(crate) mod column {
    pub const THETA: usize = 0;
    pub const THETA_DOT: usize = 2;
    pub const Y_OBJECT: usize = 4;
    pub const Y_OBJECT_DOT: usize = 5;
    pub const ROOT_MOMENT: usize = 6;
    pub const TIP_SHEAR: usize = 8;
    pub const TIP_SHEAR_DOT: usize = 10;
    pub const ROOT_MOMENT_DOT: usize = 12;
    pub const LAMBDA1_REF: usize = 14;
    pub const THETA1_REF: usize = 15;
}

/// The measured signals; index 0 of an array is arm 1.
///
/// The same type carries their time derivatives where a function asks for rates.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[repr(C)] // In the order in which hosts set them.
pub struct Measurements {
    /// Hub angles θᵢ \[rad\].
    pub theta: [f64; 2],
    /// Hub angular velocities θ̇ᵢ \[rad/s\].
    pub theta_dot: [f64; 2],
    /// Object position `y_M` \[m\].
    pub y_object: f64,
    /// Object velocity `ẏ_M` \[m/s\].
    pub y_object_dot: f64,
    /// Bending moments at the roots, Mᵢ(0) = `EIᵢ` wᵢ''(0) \[N·m\].
    pub root_moment: [f64; 2],
    /// Shear forces at the tips, Qᵢ = `EIᵢ` wᵢ'''(l) \[N\].
    pub tip_shear: [f64; 2],
    /// Rates of the shear forces at the tips, Q̇ᵢ \[N/s\].
    pub tip_shear_dot: [f64; 2],
    /// Rates of the bending moments at the roots, Ṁᵢ(0) \[N·m/s\].
    pub root_moment_dot: [f64; 2],
}

/// The two references from which all targets follow, eq. (16).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct References {
    /// Wanted Lagrange multiplier λ₁ᵈ \[N\]; the contact force of arm 1 is −λ₁, so a squeeze is negative.
    pub lambda1_ref: f64,
    /// Wanted hub angle θ₁ᵈ \[rad\].
    pub theta1_ref: f64,
}

impl References {
    /// The targets λᵢᵈ of both multipliers \[N\], λ₂ᵈ = −λ₁ᵈ (16).
    #[must_use]
    #[inline]
    pub fn lambda(&self) -> [f64; 2] {
        [self.lambda1_ref, -self.lambda1_ref]
    }
}

impl Default for References {
    /// The paper's task: λ₁ᵈ = −0.5 N, θ₁ᵈ = 3°.
    fn default() -> Self {
        Self { lambda1_ref: -0.5, theta1_ref: 3.0_f64.to_radians() }
    }
}

/// Everything a controller reads.
///
/// The same type carries the time derivatives of the inputs where a function asks for rates;
/// [`Inputs::HELD`] are the rates of inputs that are held constant.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Inputs {
    /// The fourteen measured signals.
    pub measured: Measurements,
    /// The two references.
    pub reference: References,
}

impl Inputs {
    /// Rates of constant inputs: all zero.
    pub const HELD: Self = Self::from_array([0.0; INPUTS]);

    /// The largest magnitude a step accepts for an input or for its change over the step, in SI units.
    ///
    /// Far beyond anything physical; below it no product in the control laws can overflow.
    pub const LARGEST: f64 = 1e50;

    /// Whether these rates are those of constant inputs.
    #[must_use]
    #[inline(always)]
    pub fn are_held(&self) -> bool {
        // Without a branch for each, so that several are compared at once.
        let mut any_differs = false;
        for rate in self.to_array() {
            any_differs |= rate != 0.0;
        }
        !any_differs
    }

    /// Whether all are zero and positive. Unlike [`are_held`](Self::are_held) it looks at bits, which takes fewer instructions.
    #[inline(always)]
    pub(crate) fn are_zeros(&self) -> bool {
        let mut bits = 0;
        for value in self.to_array() {
            bits |= value.to_bits();
        }
        bits == 0
    }

    /// Whether they have the bits of others.
    #[inline(always)]
    pub(crate) fn has_bits_of(&self, other: &Self) -> bool {
        have_same_bits(self.to_array(), other.to_array())
    }

    /// Whether no input can be one that a step refuses: four sums of magnitudes are usable.
    ///
    /// Read in pairs, as they have just been set: where four are read at once, a processor waits until all of them are in its cache.
    #[inline(always)]
    pub(crate) fn are_surely_usable<V: Four>(&self) -> bool {
        // No closure and no loop: they would not see the wide registers.
        let x = self.to_array();
        let motions = V::pairs([x[0], x[1]], [x[2], x[3]]).abs() + V::pairs([x[4], x[5]], [x[6], x[7]]).abs();
        let rest = V::pairs([x[8], x[9]], [x[10], x[11]]).abs() + V::pairs([x[12], x[13]], [x[14], x[15]]).abs();
        let mut are_usable = true;
        for sum in (motions + rest).lanes() {
            are_usable &= sum <= Self::LARGEST;
        }
        are_usable
    }

    /// The inputs as one array, ordered like [`INPUT_NAMES`].
    #[must_use]
    pub const fn to_array(&self) -> [f64; INPUTS] {
        let Measurements {
            theta,
            theta_dot,
            y_object,
            y_object_dot,
            root_moment,
            tip_shear,
            tip_shear_dot,
            root_moment_dot,
        } = self.measured;
        [
            theta[0],
            theta[1],
            theta_dot[0],
            theta_dot[1],
            y_object,
            y_object_dot,
            root_moment[0],
            root_moment[1],
            tip_shear[0],
            tip_shear[1],
            tip_shear_dot[0],
            tip_shear_dot[1],
            root_moment_dot[0],
            root_moment_dot[1],
            self.reference.lambda1_ref,
            self.reference.theta1_ref,
        ]
    }

    /// The inputs from one array, ordered like [`INPUT_NAMES`].
    #[must_use]
    pub const fn from_array(values: [f64; INPUTS]) -> Self {
        let [
            theta1,
            theta2,
            theta1_dot,
            theta2_dot,
            y_object,
            y_object_dot,
            root_moment1,
            root_moment2,
            tip_shear1,
            tip_shear2,
            tip_shear1_dot,
            tip_shear2_dot,
            root_moment1_dot,
            root_moment2_dot,
            lambda1_ref,
            theta1_ref,
        ] = values;
        Self {
            measured: Measurements {
                theta: [theta1, theta2],
                theta_dot: [theta1_dot, theta2_dot],
                y_object,
                y_object_dot,
                root_moment: [root_moment1, root_moment2],
                tip_shear: [tip_shear1, tip_shear2],
                tip_shear_dot: [tip_shear1_dot, tip_shear2_dot],
                root_moment_dot: [root_moment1_dot, root_moment2_dot],
            },
            reference: References { lambda1_ref, theta1_ref },
        }
    }

    /// The inputs a time `dt` \[s\] later when they change at the constant `rates`.
    #[must_use]
    pub fn after(&self, dt: f64, rates: &Self) -> Self {
        let (mut values, rates) = (self.to_array(), rates.to_array());
        for (value, rate) in values.iter_mut().zip(rates) {
            *value += rate * dt;
        }
        Self::from_array(values)
    }
}

/// Whether numbers are the same to the bit, so that zeros of both signs are not; without a branch for each.
#[inline(always)]
pub(crate) fn have_same_bits<const N: usize>(some: [f64; N], others: [f64; N]) -> bool {
    let mut bits = 0;
    for (one, other) in some.into_iter().zip(others) {
        bits |= one.to_bits() ^ other.to_bits();
    }
    bits == 0
}

/// What a controller commands.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[repr(C)] // In the order in which hosts read them.
pub struct Commands {
    /// Hub torques τ̄ᵢ before the actuators' limits \[N·m\] (`tau1_cmd`, `tau2_cmd`).
    pub tau: [f64; 2],
    /// Force v on the object before the actuator's limits \[N\] (`u_cmd`).
    pub u: f64,
}

impl Commands {
    /// `[tau1_cmd, tau2_cmd, u_cmd]`.
    #[must_use]
    pub const fn to_array(&self) -> [f64; 3] {
        [self.tau[0], self.tau[1], self.u]
    }
}

/// Distances from the static target (16).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Errors {
    /// Hub angle errors eᵢ = θᵢ − θᵢᵈ \[rad\].
    pub e: [f64; 2],
    /// Object position error p = `y_M` − `y_M`ᵈ \[m\].
    pub p: f64,
}

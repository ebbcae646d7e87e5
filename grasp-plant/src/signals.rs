//! The inputs and outputs of the plant.

use serde::{Deserialize, Serialize};

/// Inputs of the plant, or their time derivatives, or a direction of them.
// What is unsafe relies on the places of the fields, and on nothing in them.
#[allow(clippy::unsafe_derive_deserialize)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C)] // In the order in which hosts set them.
pub struct Inputs {
    /// Commanded hub torques τ̄_i \[N·m\].
    pub torque_command: [f64; 2],
    /// Commanded force on the object v \[N\].
    pub force_command: f64,
    /// External disturbance torques on the hubs \[N·m\], added to the built-in Δf_i.
    pub hub_disturbance: [f64; 2],
    /// External disturbance force on the object \[N\], added to the built-in ΔF.
    pub object_disturbance: f64,
}

impl Inputs {
    /// No input, and no change of any input.
    pub const ZERO: Self =
        Self { torque_command: [0.0; 2], force_command: 0.0, hub_disturbance: [0.0; 2], object_disturbance: 0.0 };

    /// Commands in the order of the forces: torque 1, torque 2, force.
    #[inline]
    pub(crate) fn commands(&self) -> [f64; 3] {
        [self.torque_command[0], self.torque_command[1], self.force_command]
    }

    /// External disturbances in the order of the forces.
    #[inline]
    pub(crate) fn disturbances(&self) -> [f64; 3] {
        [self.hub_disturbance[0], self.hub_disturbance[1], self.object_disturbance]
    }

    /// Commands and disturbances in lanes, of which the last repeats the third; read [singly](read_singly), since hosts have often just set them, one by
    /// one.
    #[inline]
    pub(crate) fn fresh_lanes(&self) -> [[f64; 4]; 2] {
        let Self { torque_command, force_command, hub_disturbance, object_disturbance } = self;
        // No zero: valgrind does not know the instruction that the compiler finds for it.
        let lanes = |of_hubs: &[f64; 2], of_object| {
            let [first, second, third] = [&of_hubs[0], &of_hubs[1], of_object].map(read_singly);
            [first, second, third, third]
        };
        [lanes(torque_command, force_command), lanes(hub_disturbance, object_disturbance)]
    }

    /// All numbers.
    #[inline]
    pub(crate) fn numbers(&self) -> &[f64; 6] {
        const { assert!(size_of::<Self>() == size_of::<[f64; 6]>()) };
        // SAFETY: six numbers in the order of the fields (`repr(C)`), without gaps.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }

    #[inline]
    pub(crate) fn is_finite(&self) -> bool {
        self.commands().iter().chain(&self.disturbances()).all(|value| value.is_finite())
    }
}

/// A number, by itself. The compiler would read two at once where two are needed; if they have just been written in another way, a processor
/// waits until both are in its cache, and with them all that was written before.
#[inline]
pub(crate) fn read_singly(number: &f64) -> f64 {
    // SAFETY: of a reference.
    unsafe { std::ptr::from_ref(number).read_volatile() }
}

/// The twelve measured outputs (or their time derivatives). They depend on the state alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)] // In the order in which hosts read them.
pub struct Measured {
    /// Hub angles θ_i \[rad\].
    pub theta: [f64; 2],
    /// Hub angular velocities \[rad/s\].
    pub theta_dot: [f64; 2],
    /// Object position `y_M` \[m\].
    pub y_object: f64,
    /// Object velocity \[m/s\].
    pub y_object_dot: f64,
    /// Elastic root moments EI_i w_i''(0) \[N·m\], without the Kelvin–Voigt part, as a strain gauge measures them.
    pub root_moment: [f64; 2],
    /// Elastic tip shears EI_i w_i'''(l) \[N\], without the Kelvin–Voigt part.
    pub tip_shear: [f64; 2],
    /// Rates of the elastic tip shears \[N/s\].
    pub tip_shear_dot: [f64; 2],
}

/// The outputs that depend directly on the inputs (or their time derivatives, or their change along a direction of inputs).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Direct {
    /// Hub torques τ_i that the actuators deliver \[N·m\].
    pub torque: [f64; 2],
    /// Force u that the object's actuator delivers \[N\].
    pub force: f64,
    /// Multipliers λ_i \[N\], eqs. (13) and (14).
    pub lambda: [f64; 2],
    /// Contact forces f_i = (−1)^i λ_i \[N\], positive in compression.
    pub contact_force: [f64; 2],
}

impl Direct {
    /// Whether both arms press on the object: both contact forces strictly positive. Arms that just touch it (the start
    /// at rest, force zero) do not press.
    #[must_use]
    #[inline]
    pub fn in_contact(&self) -> bool {
        self.contact_force.iter().all(|force| *force > 0.0)
    }
}

/// The built-in uncertainties (or their time derivatives).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Uncertainty {
    /// Built-in Δf_i on the hubs \[N·m\].
    pub delta_f: [f64; 2],
    /// Built-in ΔF on the object \[N\].
    pub delta_force: f64,
    /// Rates of the elastic root moments d/dt(EI_i w_i''(0)) \[N·m/s\], to which Δf_i is proportional.
    pub root_moment_dot: [f64; 2],
}

/// Time derivatives of all outputs, or their change along a direction of states and inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Of the measured outputs.
    pub measured: Measured,
    /// Of the outputs that follow the inputs at once.
    pub direct: Direct,
    /// Of the built-in uncertainties.
    pub uncertainty: Uncertainty,
    /// Of the deflections, by arm and point \[m/s\].
    pub deflection: [[f64; crate::DEFLECTION_POINTS]; 2],
    /// Of the tip deflections \[m/s\].
    pub tip_deflection: [f64; 2],
    /// Of the constraints φ_i, zero up to rounding \[m/s\].
    pub constraint: [f64; 2],
    /// Of the energy \[W\].
    pub energy: f64,
    /// Of the supplied energy \[W\]: the power of actuators and external disturbances.
    pub supplied_energy: f64,
    /// Of the contacts.
    pub contact: crate::Contact,
}

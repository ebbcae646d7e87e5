//! The numbers of (8)–(11) that proofs are about.

use grasp_plant::Parameters;

/// One arm and its hub.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// Flexural rigidity EI \[N·m²\].
    pub ei: f64,
    /// Mass per length ρ \[kg/m\].
    pub rho: f64,
    /// Hub inertia J \[kg·m²\].
    pub hub_inertia: f64,
}

/// Two arms and the object between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grasp {
    /// The arms.
    pub arms: [Arm; 2],
    /// Length l of both \[m\].
    pub length: f64,
    /// Everything that moves with the object, m = m_1 + m_2 + M \[kg\].
    pub mass: f64,
}

impl From<&Parameters> for Grasp {
    fn from(parameters: &Parameters) -> Self {
        let arms = parameters.arms.map(|arm| Arm { ei: arm.ei, rho: arm.rho, hub_inertia: arm.hub_inertia });
        Self { arms, length: parameters.length, mass: parameters.moving_mass() }
    }
}

impl Grasp {
    /// Tip stiffness 3EI/l³ of an arm clamped at its hub \[N/m\].
    #[must_use]
    pub fn tip_stiffness(&self, arm: usize) -> f64 {
        3.0 * self.arms[arm].ei / self.length.powi(3)
    }
}

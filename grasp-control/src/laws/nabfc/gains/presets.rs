//! Sets of gains, and what they achieve with the paper's arms.

use super::{Gains, ObjectGains, PostureGains, RbfLayout};

impl Default for Gains {
    /// Tuned for robustness: both contact forces settle within 2 % in 0.31 s with less than 0.1 % overshoot,
    /// |τ| ≤ 0.62 N·m, |u| ≤ 0.17 N, at steps of 0.05 to 1 ms.
    ///
    /// The object loop is soft on purpose. s contains Σ q'''(l), 750 times the position error of a squeezed object, so
    /// η and k act 750-fold; and what they gain in stiffness they lose, one sampling delay later, in damping. m̂ adds
    /// damping at the object's own frequency, and the low-pass keeps it from feeding back the beams'. What stiffness
    /// leaves of a lasting disturbance the networks take over: their learning rates a₁‖Y‖² and a₃‖Y‖² are those of an
    /// integrator about as fast as its loop.
    ///
    /// Leakages bear sensor noise. s is an input of the networks and drives them, so noise alone makes them learn an ever larger
    /// gain on s; and π̂ integrates s tanh(s/ϵ). With a₂ = 0.001, a₄ = 1e-4 and ζ₂ = 0.002, as they were first, lasting
    /// disturbances leave less than 2 µN, and one percent of noise drives the torques to their limits after 105 s. With these,
    /// disturbances leave up to 0.1 mN and noise 8 mN rms, for ten minutes and more.
    fn default() -> Self {
        let posture = PostureGains {
            xi: 0.8,
            k: 0.38,
            mu: 6.5,
            c3: 6.5,
            epsilon2: 0.2,
            a3: 10.0,
            a4: 0.02,
            u_max: 0.0,
            zeta1: 3.0,
            zeta2: 0.5,
            g1: 0.001,
            g2: 0.01,
            j_hat_0: 0.0,
        };
        let object = ObjectGains {
            eta: 0.3,
            k: 0.25,
            mu_bar: 2.0,
            c1: 2.0,
            epsilon1: 1.0,
            a1: 0.4,
            a2: 0.05,
            w_max: 0.0,
            gamma1: 0.01,
            gamma2: 1.0,
            b1: 3e-4,
            b2: 1.0,
            m_hat_0: 0.015,
        };
        let rbf = RbfLayout::default();
        Self { object, posture: [posture; 2], sat_limit: 0.01, shear_rate_bandwidth: 300.0, rbf }
    }
}

impl Gains {
    /// The fast preset: the object loop of the default with posture loops of twice the slope.
    ///
    /// Both contact forces settle within 2 % in 0.16 s with 0.3 % overshoot, |τ| ≤ 0.9 N·m, |u| ≤ 0.21 N, at steps of
    /// 0.05 to 1 ms. Less forgiving than the default: a larger change of the references overshoots.
    #[must_use]
    pub fn fast() -> Self {
        let default = Self::default();
        let posture = PostureGains { xi: 1.0, k: 0.3, mu: 13.0, c3: 13.0, a3: 15.0, ..default.posture[0] };
        let rbf =
            RbfLayout { width_posture: 0.8, posture_surface_scale: 1.3, posture_alpha_scale: 10.0, ..default.rbf };
        Self { posture: [posture; 2], rbf, ..default }
    }

    /// A plain set without networks and without low-pass, and with a stiff object loop; a baseline for comparisons.
    ///
    /// Both contact forces settle within 2 % in 0.43 s, without overshoot. Away from the nominal case (unequal arms or
    /// hubs, another reference, a heavy object, `EI` known too small) the object force saturates and stays in a limit
    /// cycle.
    #[must_use]
    pub fn baseline() -> Self {
        let posture = PostureGains {
            xi: 1.0,
            k: 0.3,
            mu: 5.0,
            c3: 5.0,
            epsilon2: 0.1,
            a3: 0.0,
            a4: 0.0,
            u_max: 0.0,
            zeta1: 1.0,
            zeta2: 0.01,
            g1: 0.01,
            g2: 0.01,
            j_hat_0: 0.0,
        };
        let object = ObjectGains {
            eta: 1.0,
            k: 5.0,
            mu_bar: 5.0,
            c1: 5.0,
            epsilon1: 0.1,
            a1: 0.0,
            a2: 0.0,
            w_max: 0.0,
            gamma1: 1.0,
            gamma2: 0.01,
            b1: 1.0,
            b2: 0.01,
            m_hat_0: 0.0,
        };
        let rbf = RbfLayout::default();
        Self { object, posture: [posture; 2], sat_limit: 0.01, shear_rate_bandwidth: 0.0, rbf }
    }
}

impl Default for RbfLayout {
    /// Five nodes per axis, wide enough to overlap, on boxes that hold the way into the grasp.
    fn default() -> Self {
        Self {
            nodes_posture: 5,
            rings_object: 2,
            width_posture: 1.1,
            width_object: 0.75,
            position_scale: 0.01,
            object_surface_scale: 1.0,
            object_alpha_scale: 50.0,
            shear_scale: 10.0,
            shear_rate_scale: 50.0,
            angle_scale: 0.05,
            posture_surface_scale: 0.7,
            posture_alpha_scale: 5.0,
        }
    }
}

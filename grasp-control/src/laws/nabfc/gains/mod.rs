//! Gains of the NABFC law. Names, units and ranges are in tables: [`ObjectGains::PARAMETERS`] and so on.

mod presets;
mod table;

use crate::blocks::rbf::Layout;
use serde::{Deserialize, Serialize};

/// Gains of the object-position loop, eqs. (33)–(39).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObjectGains {
    /// Switching gain η \[N·s/m\]; acts on sat(s).
    pub eta: f64,
    /// Gain k of the sliding variable \[N·s/m\].
    pub k: f64,
    /// Slope μ̄ of the sliding surface (33) \[1/s\].
    pub mu_bar: f64,
    /// Gain c₁ of the virtual control (34) \[1/s\].
    pub c1: f64,
    /// Width ϵ₁ of the tanh in (36) and (38) \[m/s\].
    pub epsilon1: f64,
    /// Adaptation gain a₁ of the network weights (37) \[N/m\]; zero switches the network off.
    pub a1: f64,
    /// Leakage a₂ of the network weights (37) \[m/(N·s)\].
    pub a2: f64,
    /// Radius ω₃ of the ball that holds the weights Ŵ (Lemma 3) \[N\]; 0 = no bound.
    pub w_max: f64,
    /// Adaptation gain γ₁ of the bound ε̂ (38) \[N/m\].
    pub gamma1: f64,
    /// Leakage γ₂ of the bound ε̂ (38) \[m/(N·s)\].
    pub gamma2: f64,
    /// Adaptation gain b₁ of the mass m̂ (39) \[kg·s²/m²\].
    pub b1: f64,
    /// Leakage b₂ of the mass m̂ (39) \[m²/(kg·s³)\].
    pub b2: f64,
    /// Initial estimate m̂(0) of the moving mass m₁ + m₂ + M \[kg\].
    ///
    /// m̂ multiplies a shear *rate*: near the true mass the loop gain at high frequency exceeds what any sampled loop
    /// bears, and the force ends in a limit cycle. Keep it well below.
    pub m_hat_0: f64,
}

/// Gains of the posture loop of one arm, eqs. (51)–(57).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PostureGains {
    /// Switching gain ξᵢ \[N·m·s/rad\]; acts on sat(sᵢ).
    pub xi: f64,
    /// Gain kᵢ of the sliding variable \[N·m·s/rad\].
    pub k: f64,
    /// Slope μᵢ of the sliding surface (51) \[1/s\].
    pub mu: f64,
    /// Gain c₃ᵢ of the virtual control (52) \[1/s\].
    pub c3: f64,
    /// Width ϵ₂ᵢ of the tanh in (54) and (56) \[rad/s\].
    pub epsilon2: f64,
    /// Adaptation gain a₃ᵢ of the network weights (55) \[N·m/rad\]; zero switches the network off.
    pub a3: f64,
    /// Leakage a₄ᵢ of the network weights (55) \[rad/(N·m·s)\].
    pub a4: f64,
    /// Radius ω₃ of the ball that holds the weights Ûᵢ (Lemma 3) \[N·m\]; 0 = no bound.
    pub u_max: f64,
    /// Adaptation gain ζ₁ᵢ of the bound π̂ᵢ (56) \[N·m/rad\].
    pub zeta1: f64,
    /// Leakage ζ₂ᵢ of the bound π̂ᵢ (56) \[rad/(N·m·s)\].
    pub zeta2: f64,
    /// Adaptation gain g₁ᵢ of the hub inertia Ĵᵢ (57) \[kg·m²·s²/rad²\].
    pub g1: f64,
    /// Leakage g₂ᵢ of the hub inertia Ĵᵢ (57) \[rad²/(kg·m²·s³)\].
    pub g2: f64,
    /// Initial estimate Ĵᵢ(0) of the hub inertia \[kg·m²\].
    pub j_hat_0: f64,
}

/// Layout and scaling of the networks, see [`rbf`](crate::blocks::rbf).
///
/// A scale is the magnitude of a signal that maps to the edge of the box the centres fill.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RbfLayout {
    /// Nodes per axis of the posture networks: a network has the cube of it.
    pub nodes_posture: u32,
    /// Nodes of the object network on each side of the origin along each of its seven axes.
    pub rings_object: u32,
    /// Width b of the posture networks' Gaussians in normalised units.
    pub width_posture: f64,
    /// Width b of the object network's Gaussians in normalised units.
    pub width_object: f64,
    /// Scale of z₁ = p \[m\].
    pub position_scale: f64,
    /// Scale of s \[m/s\].
    pub object_surface_scale: f64,
    /// Scale of α̇₁ \[m/s²\].
    pub object_alpha_scale: f64,
    /// Scale of wᵢ'''(l) \[1/m²\].
    pub shear_scale: f64,
    /// Scale of ẇᵢ'''(l) \[1/(m²·s)\].
    pub shear_rate_scale: f64,
    /// Scale of eᵢ \[rad\].
    pub angle_scale: f64,
    /// Scale of sᵢ \[rad/s\].
    pub posture_surface_scale: f64,
    /// Scale of α̇₂ᵢ \[rad/s²\].
    pub posture_alpha_scale: f64,
}

impl RbfLayout {
    /// Layout of a posture network.
    #[must_use]
    pub const fn posture(&self) -> Layout {
        Layout::Grid(self.nodes_posture as usize)
    }

    /// Layout of the object network.
    #[must_use]
    pub const fn object(&self) -> Layout {
        Layout::Star(self.rings_object as usize)
    }
}

/// All parameters of the NABFC law; index 0 of an array is arm 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// Object-position loop.
    pub object: ObjectGains,
    /// Posture loops.
    pub posture: [PostureGains; 2],
    /// Limit of `sat`, which replaces the sign function: sat clips its argument to ± this value. In m/s in (36), in
    /// rad/s in (54). 0 switches these terms off.
    pub sat_limit: f64,
    /// Bandwidth of the low-pass on the measured shear rates \[rad/s\]; 0 = off.
    pub shear_rate_bandwidth: f64,
    /// Networks.
    pub rbf: RbfLayout,
}

impl Gains {
    /// These gains with all networks switched off: a₁ = a₃ᵢ = 0.
    #[must_use]
    pub fn without_networks(mut self) -> Self {
        self.object.a1 = 0.0;
        for posture in &mut self.posture {
            posture.a3 = 0.0;
        }
        self
    }
}

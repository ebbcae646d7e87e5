//! Gains for which no H of this kind decreases, whatever its constants.
//!
//! Take e_1 = e_2 = p/l, everything at rest, and loads that make all three surfaces zero: M̃_i = −(G_i/c_i) e_i, S = −(G/c)
//! p. Then no observer and no surface moves, V̇ = 0, and fields q_i with these boundary values and q_i(l) = 0 exist with
//! arbitrarily small ∫q_i''². So Ḣ comes arbitrarily close to
//!
//! ```text
//! ε_1 Σ(l/2EI_i) M̃_i² + ε_2 (Σ e_i M̃_i + p S)
//! ```
//!
//! and must not be positive, while the motion of the arms alone demands ε_2 < ½ε_1. With loads per p, K = Σ
//! (l/2EI_i)(G_i/c_i l)² / (Σ G_i/(c_i l²) + G/c) therefore has to be below ½.

use super::Port;
use crate::Grasp;
use serde::Serialize;

/// Why there is no certificate of this kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Obstacle {
    /// K.
    pub value: f64,
    /// Its upper limit.
    pub limit: f64,
}

/// K, if it is not below ½ by more than rounding.
#[must_use]
pub fn obstacle(grasp: &Grasp, ports: &[Port; 3]) -> Option<Obstacle> {
    let ratio = |end: usize| ports[end].slope / ports[end].strain;
    let l = grasp.length;
    let against: f64 = (0..2).map(|i| l / (2.0 * grasp.arms[i].ei) * (ratio(i) / l).powi(2)).sum();
    let with: f64 = (0..2).map(|i| ratio(i) / l.powi(2)).sum::<f64>() + ratio(2);
    let value = against / with;
    (value >= 0.5 * (1.0 + 1e-12)).then_some(Obstacle { value, limit: 0.5 })
}

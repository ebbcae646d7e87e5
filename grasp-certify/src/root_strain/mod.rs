//! The law with root strain in the posture surface: a certified decay rate and ultimate bounds.
//!
//! The proof holds for the undiscretised, undamped beams in continuous time, without limits of the actuators, for fixed
//! gains, observers included: constants ε_1, ε_2, τ_i and storage functions V exist for which H of `form` satisfies
//!
//! ```text
//! Ḣ ≤ −φ H + D √(2H/θ),   θ W ≤ H ≤ (2−θ) W,
//! ```
//!
//! so W decays like e^{−φt} and ends below 2D²/(φθ)². A search finds the constants, and interval arithmetic checks them.
//! [`obstacle`] determines the gains for which no constants exist.

mod beam;
mod bound;
mod form;
mod leakage;
mod obstacle;
mod port;
mod search;

use crate::Grasp;
use crate::interval::{Interval, Number, is_positive_definite};
pub use bound::{Bound, Disturbance};
pub use leakage::{Estimator, Leakage};
pub use obstacle::{Obstacle, obstacle};
pub use port::Port;
pub use search::certify;
use serde::Serialize;

/// The storage function of one end: ½A p² + ½B(ζ + w p + x a + y δ)² + ½R(a'² + 2g a'δ' + h δ'²), a' = a + u p, δ' = δ + v p.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Storage {
    /// A.
    pub position: f64,
    /// B.
    pub crossed: f64,
    /// w \[1/s\].
    pub slope: f64,
    /// x; 0 without observer.
    pub error: f64,
    /// y; 0 without observer.
    pub learnt: f64,
    /// R, g, h; without meaning without observer.
    pub observer: [f64; 3],
    /// u, v \[1/s\]; 0 without observer.
    pub drift: [f64; 2],
}

impl Storage {
    /// The storage function of an end without observer.
    #[must_use]
    pub const fn plain([position, crossed, slope]: [f64; 3]) -> Self {
        Self { position, crossed, slope, error: 0.0, learnt: 0.0, observer: [1.0, 0.0, 1.0], drift: [0.0; 2] }
    }

    /// Whether it is certainly positive definite.
    fn is_positive(&self) -> bool {
        let [r, g, h] = self.observer.map(Interval::exact);
        self.position > 0.0 && self.crossed > 0.0 && r.is_positive() && (h - g * g).is_positive()
    }
}

/// The constants of H.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Constants {
    /// Weight ε_1 of Σρ∫(x−l)ẏq' \[1/(m·s)\].
    pub epsilon_1: f64,
    /// Weight ε_2 \[1/s\].
    pub epsilon_2: f64,
    /// Weights τ_i of (l e_i − p)² ≤ (l³/3EI_i) EI_i∫q_i''².
    pub tau: [f64; 2],
    /// V by end: hub 1, hub 2, object.
    pub storage: [Storage; 3],
}

/// A proved decay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certificate {
    /// Rate φ of H and W \[1/s\]; amplitudes decay with φ/2.
    pub phi: f64,
    /// θ with θ W ≤ H ≤ (2−θ) W.
    pub theta: f64,
    /// The constants that prove it.
    pub constants: Constants,
}

fn proves<N: Number>(grasp: &Grasp, ports: &[Port; 3], constants: &Constants, phi: f64) -> bool {
    form::decay::<N>(grasp, ports, constants, phi).is_some_and(|matrix| is_positive_definite(&matrix))
}

/// The largest value up to `limit` for which `holds`, starting from `least`; `holds` is true up to it. `None` if it is
/// false for `least`.
fn largest(least: f64, limit: f64, holds: impl Fn(f64) -> bool) -> Option<f64> {
    let (mut low, mut high) = (least, 2.0 * least);
    if !holds(low) {
        return None;
    }
    while high < limit && holds(high) {
        (low, high) = (high, 2.0 * high);
    }
    high = high.min(limit);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    Some(low)
}

/// The certificate of given constants, with a rate of at most `phi`: the part that is a proof.
#[must_use]
pub fn verify(grasp: &Grasp, ports: &[Port; 3], constants: &Constants, phi: f64) -> Option<Certificate> {
    if !ports.iter().all(Port::is_usable) {
        return None;
    }
    // The rounding error is a few parts in 1e12 of the largest entries; a failure slightly below this is not due to
    // rounding.
    let below = [1e-7, 1e-5, 1e-3];
    let phi = below
        .iter()
        .map(|share| phi * (1.0 - share))
        .find(|phi| *phi > 0.0 && proves::<Interval>(grasp, ports, constants, *phi))?;
    let theta = largest(1e-4, 1.0, |theta| form::dominates::<Interval>(grasp, constants, theta))?;
    Some(Certificate { phi, theta, constants: *constants })
}

#[cfg(test)]
mod tests;

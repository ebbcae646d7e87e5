//! φ, h and the ultimate bounds (92), (94) that the conditions promise.

use super::conditions::Margins;
use super::{Constants, Gains, violated};
use crate::Grasp;
use crate::search::maximise;
use serde::Serialize;

/// Rates and leakages of the estimators (37)–(39), (55)–(57). A network with rate 0 is off and not part of H.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learning {
    /// a_1, a_2 of (37).
    pub weights: [f64; 2],
    /// γ_1, γ_2 of (38).
    pub bias: [f64; 2],
    /// b_1, b_2 of (39).
    pub mass: [f64; 2],
    /// a_3i, a_4i of (55).
    pub hub_weights: [[f64; 2]; 2],
    /// ζ_1i, ζ_2i of (56).
    pub hub_bias: [[f64; 2]; 2],
    /// g_1i, g_2i of (57).
    pub inertia: [[f64; 2]; 2],
}

/// The bounds that the theorem would guarantee with the best constants found by a search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounds {
    /// The constants.
    pub constants: Constants,
    /// φ with φ_3 in the denominator, as H ≤ φ_3(…) demands \[1/s\].
    pub phi: f64,
    /// φ as printed, divided by φ_2 < 1 \[1/s\].
    pub phi_printed: f64,
    /// φ_2 of (71).
    pub phi_2: f64,
    /// h for W* = U* = 0, ε̄ = π̄ = 0: the least it can be.
    pub h: f64,
    /// (92) with φ as printed \[m\].
    pub position: f64,
    /// (94) with φ as printed \[rad\].
    pub angle: [f64; 2],
    /// 4√m \[m\]: no gains bring (92) below.
    pub least_position: f64,
    /// 4√((m² + ΣJ²)/J_i) \[rad\]: no gains bring (94) below.
    pub least_angle: [f64; 2],
}

/// Terms of κ_1 … κ_4 and φ_4, φ_5 that come from an estimator: half the leakage, and half of 1/rate.
fn on(rates: &[f64; 2]) -> Option<(f64, f64)> {
    (rates[0] > 0.0).then(|| (0.5 * rates[1], 0.5 / rates[0]))
}

/// min{κ_1/κ_2, κ_3/κ_4, κ_5/κ_6}, before the division by φ_2 or φ_3; not positive if a condition is violated.
fn decay(grasp: &Grasp, gains: &Gains, learning: &Learning, c: &Constants) -> (f64, f64) {
    let m = Margins::<f64>::new(grasp, gains, c);
    let worst = m.named().iter().fold(f64::INFINITY, |least, (_, margin)| least.min(*margin));
    if worst <= 0.0 {
        return (worst, m.eq_71);
    }
    let mut kappa_1 = (gains.g * m.eq_82).min(m.eq_83);
    let mut kappa_2 = (0.5 * grasp.mass).max(1.0);
    for (leak, weight) in [&learning.weights, &learning.bias, &learning.mass].into_iter().filter_map(on) {
        (kappa_1, kappa_2) = (kappa_1.min(leak), kappa_2.max(weight));
    }
    let (mut kappa_3, mut kappa_4) = (f64::INFINITY, 1f64);
    let mut kappa_5 = f64::INFINITY;
    let mut kappa_6 = 0f64;
    for (i, arm) in grasp.arms.iter().enumerate() {
        kappa_3 = kappa_3.min(gains.g3[i] * m.eq_85[i]).min(m.eq_83_hub[i]);
        kappa_4 = kappa_4.max(0.5 * arm.hub_inertia);
        let estimators = [&learning.hub_weights[i], &learning.hub_bias[i], &learning.inertia[i]];
        for (leak, weight) in estimators.into_iter().filter_map(on) {
            (kappa_3, kappa_4) = (kappa_3.min(leak), kappa_4.max(weight));
        }
        kappa_5 = kappa_5.min(c.beta_2 * arm.rho * m.eq_88_hub[i]).min(1.5 * c.beta_2 * arm.ei);
        kappa_6 = kappa_6.max(0.5 * c.beta_1 * arm.ei.max(arm.rho));
    }
    ((kappa_1 / kappa_2).min(kappa_3 / kappa_4).min(kappa_5 / kappa_6), m.eq_71)
}

/// The bounds with the constants that give the largest φ (with φ_3) among those that a search from `start` visits.
#[must_use]
pub fn bounds(grasp: &Grasp, gains: &Gains, learning: &Learning, start: &Constants) -> Bounds {
    let pack = |c: &Constants| {
        [
            c.beta_1,
            c.beta_2,
            c.theta_1,
            c.theta_2,
            c.theta_3,
            c.theta_4[0],
            c.theta_4[1],
            c.theta_5[0],
            c.theta_5[1],
            c.theta_6[0],
            c.theta_6[1],
            c.theta_7[0],
            c.theta_7[1],
        ]
        .map(f64::ln)
    };
    let unpack = |x: &[f64; 13]| {
        let x = x.map(f64::exp);
        Constants {
            beta_1: x[0],
            beta_2: x[1],
            theta_1: x[2],
            theta_2: x[3],
            theta_3: x[4],
            theta_4: [x[5], x[6]],
            theta_5: [x[7], x[8]],
            theta_6: [x[9], x[10]],
            theta_7: [x[11], x[12]],
        }
    };
    // φ_1 = 1 − eq_71, φ_3 = 1 + φ_1.
    let rate = |c: &Constants| {
        let (decay, phi_2) = decay(grasp, gains, learning, c);
        if decay > 0.0 { decay / (2.0 - phi_2) } else { decay }
    };
    let (found, _) = maximise(|x| rate(&unpack(x)), pack(start), 1e-3, 60_000);
    let found = unpack(&found);
    let constants = if violated(grasp, gains, &found).is_empty() { found } else { *start };
    let (decay, phi_2) = decay(grasp, gains, learning, &constants);
    let (m, inertias) = (grasp.mass, grasp.arms.map(|arm| arm.hub_inertia));
    // With b_3 = γ_3 = g_3i = ζ_3i = 2, which makes b_3²/(b_3 − 1), and so h/φ, smallest.
    let h = 2.0 * learning.mass[1] * m * m
        + (0..2).map(|i| 2.0 * learning.inertia[i][1] * inertias[i].powi(2)).sum::<f64>();
    let weight = |inertia: f64, estimators: [&[f64; 2]; 3]| {
        estimators.into_iter().filter_map(on).fold((0.5 * inertia).min(1.0), |least, (_, weight)| least.min(weight))
    };
    let ultimate = |weight: f64| (2.0 * h / (weight * decay)).sqrt();
    Bounds {
        constants,
        phi: decay / (2.0 - phi_2),
        phi_printed: decay / phi_2,
        phi_2,
        h,
        position: ultimate(weight(m, [&learning.weights, &learning.bias, &learning.mass])),
        angle: std::array::from_fn(|i| {
            ultimate(weight(inertias[i], [&learning.hub_weights[i], &learning.hub_bias[i], &learning.inertia[i]]))
        }),
        least_position: 4.0 * m.sqrt(),
        least_angle: inertias.map(|j| 4.0 * ((m * m + inertias.iter().map(|j| j * j).sum::<f64>()) / j).sqrt()),
    }
}

//! The conditions (71), (82)–(88) as printed: do constants β_1, β_2, ϑ_1 … ϑ_7 exist for given gains?
//!
//! With g = μ̄ + c_1, g_3 = μ_i + c_3i, B = β_1(EI_1+EI_2), r = β_2/β_1 (derivations: `docs/certificates.md`):
//!
//! * (82), (86), (88): exactly if g < 1/8 and B > B_min(g), the positive root of B²(¼ − 2g) g − (3/2) g B − 1 = 0.
//! * (83): B < 2k. So k > B_min(g)/2.
//! * (85), (87), (88) of an arm, for k_i without bound: 2 β_1 g_3 (EI/(r l) + r l³ ρ) < 1, an interval of r; it is not
//!   empty if 4 β_1 l g_3 √(ρ EI) < 1.
//! * (71): r < r_max.
//! * with (83) for k_i: K_i(r) < k_i, where K_i(r) is a minimum over ϑ_7 alone. All conditions get harder as β_1 grows, so
//!   β_1 is B_min(g)/(EI_1+EI_2).

mod conditions;
mod posture;
mod rate;

use crate::Grasp;
use crate::interval::{Interval, Number};
pub use conditions::{Constants, violated};
pub use rate::{Bounds, Learning, bounds};
use serde::Serialize;

/// The gains that the conditions are about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// g = μ̄ + c_1 \[1/s\].
    pub g: f64,
    /// k of (36).
    pub k: f64,
    /// μ_i + c_3i \[1/s\].
    pub g3: [f64; 2],
    /// k_i of (54).
    pub k_hub: [f64; 2],
}

/// Conditions that exclude each other, and by how much.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conflict {
    /// The conditions, by equation number.
    pub conditions: &'static str,
    /// The quantity that decides.
    pub quantity: String,
    /// Its value.
    pub value: f64,
    /// Its limit from above (or from below, as `quantity` says).
    pub limit: f64,
}

/// The result of the analysis.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// These constants satisfy everything, checked in interval arithmetic.
    Feasible(Constants),
    /// No constants do.
    Infeasible(Vec<Conflict>),
    /// Too close to call: the gains are within 1e-6 of the limit, relatively.
    Undecided,
}

/// The smallest B that (82), (86), (88) allow for g < 1/8.
#[must_use]
pub fn smallest_b(g: f64) -> Interval {
    let n = Interval::exact;
    let g = n(g);
    let slope = n(0.25) - n(2.0) * g;
    let linear = n(1.5) * g;
    (linear + Number::sqrt(linear * linear + n(4.0) * slope * g)) / (n(2.0) * slope * g)
}

/// The smallest B_min over all g, 6 + 8√2, at B g = 1/√2.
#[must_use]
pub fn smallest_b_of_all() -> f64 {
    6.0 + 8.0 * 2f64.sqrt()
}

/// Decides whether constants exist.
#[must_use]
pub fn decide(grasp: &Grasp, gains: &Gains) -> Verdict {
    let mut conflicts = Vec::new();
    let stiffness = grasp.arms[0].ei + grasp.arms[1].ei;
    let (least, most) = if gains.g < 0.125 {
        let b = smallest_b(gains.g);
        (b.lo(), b.hi())
    } else {
        conflicts.push(Conflict {
            conditions: "(82), (86), (88)",
            quantity: "mu_bar + c1 [1/s], to be below".to_owned(),
            value: gains.g,
            limit: 0.125,
        });
        (smallest_b_of_all(), smallest_b_of_all())
    };
    if gains.k <= 0.5 * least {
        conflicts.push(Conflict {
            conditions: "(82), (83), (86), (88)",
            quantity: "k, to be above".to_owned(),
            value: gains.k,
            limit: 0.5 * least,
        });
    }
    let beta = least / stiffness;
    for (i, arm) in grasp.arms.iter().enumerate() {
        let value = 4.0 * beta * grasp.length * gains.g3[i] * (arm.rho * arm.ei).sqrt();
        // Rounding of a handful of operations.
        if value >= 1.0 + 1e-14 {
            conflicts.push(Conflict {
                conditions: if i == 0 {
                    "(82), (86), (88) with (85), (87), (88) of arm 1"
                } else {
                    "(82), (86), (88) with (85), (87), (88) of arm 2"
                },
                quantity: format!("mu{0} + c3{0} [1/s], to be below", i + 1),
                value: gains.g3[i],
                limit: gains.g3[i] / value,
            });
        }
    }
    if !conflicts.is_empty() {
        return Verdict::Infeasible(conflicts);
    }
    if posture::excluded(grasp, gains, beta) {
        let needed = posture::needed_gain(grasp, gains, beta);
        conflicts.push(Conflict {
            conditions: "(71), (83), (85), (87), (88) of both arms",
            quantity: "the factor by which k1 and k2 have to grow, to be below".to_owned(),
            value: needed,
            limit: 1.0,
        });
        return Verdict::Infeasible(conflicts);
    }
    match posture::constants(grasp, gains, most * (1.0 + 1e-7) / stiffness) {
        Some(constants) if violated(grasp, gains, &constants).is_empty() => Verdict::Feasible(constants),
        _ => Verdict::Undecided,
    }
}

#[cfg(test)]
mod tests;

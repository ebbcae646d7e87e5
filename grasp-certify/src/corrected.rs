//! The conditions with corrected signs: no gains satisfy them, and Theorem 3 is false for Δ = 0.
//!
//! On the surface s = 0 the object's loop has ṗ = −g z − S with g = μ̄ + c_1, z = z_1, S = Σq_i'''(l). There V̇_o
//! contributes −g z² − z S and, for equal arms, Ė contributes b ṗ S with b = β_1 EI. The sum is exactly
//!
//! ```text
//! −g z² − (1 + b g) z S − b S²,     discriminant (1 + b g)² − 4 b g = (1 − b g)² ≥ 0.
//! ```
//!
//! So the object's part is positive somewhere unless b g = 1, and then it is zero somewhere. The hubs' terms can compensate
//! this: a small ∫q''² forces e_i → p/l, and −Σg_3i z_3i² becomes −(Σg_3i/l²) z². The root moment excludes all gains: with
//! e = p = ė = ṗ = 0, S = 0 (so s = s_i = 0), q_i''(0) = X and the integrals of q''² and ẏ² → 0, Ḣ → +½ β_2 l ΣEI_i X² > 0
//! for any β_2 > 0.

use crate::Grasp;
use serde::Serialize;
use std::f64::consts::PI;

/// The object's form in the corrected conditions, for given g and β_1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Form {
    /// b = β_1 EI, in units that (34) leaves open (errata 10).
    pub b: f64,
    /// (1 − b g)²: how far the form is from one without positive values.
    pub discriminant: f64,
    /// (z, S) where the form is largest for given z, with z = 1: S = −(1 + b g)/(2b).
    pub worst_shear: f64,
    /// Its value there, (1 − b g)²/(4b) ≥ 0; the object's part alone is negative definite only if it is below zero.
    pub value: f64,
}

/// The exact object form on s = 0 for g \[1/s\] and β_1, with b = β_1 EI for equal arms.
#[must_use]
pub fn form(g: f64, beta_1: f64, ei: f64) -> Form {
    let b = beta_1 * ei;
    let discriminant = (1.0 - b * g).powi(2);
    Form { b, discriminant, worst_shear: -(1.0 + b * g) / (2.0 * b), value: discriminant / (4.0 * b) }
}

/// The value of the form at (z, S).
#[must_use]
pub fn value(g: f64, b: f64, z: f64, shear: f64) -> f64 {
    -g * z * z - (1.0 + b * g) * z * shear - b * shear * shear
}

/// Frequencies \[rad/s\] of the first `count` motions that the paper's law does not damp for Δ = 0, whatever its gains:
/// q_1'''(l) = −q_2'''(l), both arms clamped at resting hubs and pinned at the resting object, so that s = s_1 = s_2 = 0.
/// They exist if both arms have the same EI/ρ; otherwise the list is empty.
///
/// tan x = tanh x with x in (nπ, nπ + π/2), ω = x² √(EI/ρ)/l².
#[must_use]
pub fn undamped_frequencies(grasp: &Grasp, count: usize) -> Vec<f64> {
    let [speed, other] = grasp.arms.map(|arm| arm.ei / arm.rho);
    if (speed - other).abs() > 4.0 * f64::EPSILON * speed {
        return Vec::new();
    }
    (1..=count).map(|n| clamped_pinned_number(n).powi(2) * speed.sqrt() / grasp.length.powi(2)).collect()
}

/// The n-th positive root of tan x = tanh x, n from 1.
#[must_use]
pub fn clamped_pinned_number(n: usize) -> f64 {
    // x = nπ + atan(tanh x), a contraction with factor below 1e-3.
    let mut x = n as f64 * PI + PI / 4.0;
    for _ in 0..20 {
        x = n as f64 * PI + x.tanh().atan();
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use grasp_plant::Parameters;

    /// Against mpmath (`tests/test_certificates.py`), to the digits given.
    #[test]
    fn the_undamped_modes_of_the_paper() {
        let grasp = Grasp::from(&Parameters::default());
        let found = undamped_frequencies(&grasp, 3);
        for (found, exact) in found.iter().zip([562.504_349, 1_822.874_382, 3_803.281_896]) {
            assert!((found - exact).abs() < 2e-9 * exact, "{found}");
        }
        let mut unequal = grasp;
        unequal.arms[1].ei *= 1.1;
        assert!(undamped_frequencies(&unequal, 3).is_empty());
    }

    #[test]
    fn the_form_is_positive_somewhere_for_any_gains() {
        for g in [1e-3, 0.1, 1.0, 50.0] {
            for beta_1 in [1e-3, 1.0, 85.0, 1e4] {
                let form = form(g, beta_1, 0.115);
                let there = value(g, form.b, 1.0, form.worst_shear);
                // Rounding of terms of the size g + (1 + bg)²/b.
                let scale = g + (1.0 + form.b * g).powi(2) / form.b;
                assert!((there - form.value).abs() < 1e-15 * 8.0 * scale, "{there} {}", form.value);
                assert!(form.value >= 0.0);
            }
        }
    }
}

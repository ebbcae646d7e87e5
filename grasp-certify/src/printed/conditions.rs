//! The conditions themselves, for given constants.

use super::Gains;
use crate::Grasp;
use crate::interval::{Interval, Number};
use serde::Serialize;

/// β_1, β_2 and ϑ_1 … ϑ_7 of Section III.C; index 0 of an array is arm 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Constants {
    /// Weight of the energy (68).
    pub beta_1: f64,
    /// Weight of the crossing term (69).
    pub beta_2: f64,
    /// ϑ_1 of (48).
    pub theta_1: f64,
    /// ϑ_2 of (73).
    pub theta_2: f64,
    /// ϑ_3 of (73).
    pub theta_3: f64,
    /// ϑ_4i of (73).
    pub theta_4: [f64; 2],
    /// ϑ_5i of (73).
    pub theta_5: [f64; 2],
    /// ϑ_6i of (79).
    pub theta_6: [f64; 2],
    /// ϑ_7i of (79).
    pub theta_7: [f64; 2],
}

/// The left sides of (82)–(88) and 1 − φ_1 of (71), as printed.
// Fields are named by their equations.
#[allow(clippy::struct_field_names)]
pub(super) struct Margins<N> {
    pub(super) eq_82: N,
    pub(super) eq_83: N,
    pub(super) eq_83_hub: [N; 2],
    pub(super) eq_85: [N; 2],
    pub(super) eq_86: N,
    pub(super) eq_87: [N; 2],
    pub(super) eq_88_hub: [N; 2],
    pub(super) eq_88: N,
    pub(super) eq_71: N,
}

impl<N: Number> Margins<N> {
    pub(super) fn new(grasp: &Grasp, gains: &Gains, constants: &Constants) -> Self {
        let n = N::exact;
        let (one, half, l) = (n(1.0), n(0.5), n(grasp.length));
        let c = constants;
        let (g, beta_1, beta_2) = (n(gains.g), n(c.beta_1), n(c.beta_2));
        let [ei_1, ei_2] = grasp.arms.map(|arm| arm.ei);
        let [rho_1, rho_2] = grasp.arms.map(|arm| arm.rho);
        let b = beta_1 * (n(ei_1) + n(ei_2));
        let per_arm = |f: &dyn Fn(usize) -> N| [f(0), f(1)];
        let ei = |i: usize| n(grasp.arms[i].ei);
        let rho = |i: usize| n(grasp.arms[i].rho);
        let g3 = |i: usize| n(gains.g3[i]);
        let least = n(ei_1.min(ei_2).min(rho_1).min(rho_2));
        let square = if grasp.length < 1.0 { l * l } else { one };
        Self {
            eq_82: one - n(c.theta_1) / g + b * (half - n(c.theta_3) - one / n(c.theta_2)),
            eq_83: n(gains.k) - half * b,
            eq_83_hub: per_arm(&|i| {
                n(gains.k_hub[i]) - beta_1 * ei(i) * n(c.theta_4[i]) - beta_1 * l * l * rho(i) / n(c.theta_6[i])
            }),
            eq_85: per_arm(&|i| one - beta_1 * ei(i) / n(c.theta_5[i]) - beta_2 * l * l * rho(i) * n(c.theta_7[i])),
            eq_86: b * (half - g / n(c.theta_3)) - one / n(c.theta_1),
            eq_87: per_arm(&|i| half * beta_2 * l - beta_1 * (one / n(c.theta_4[i]) + n(c.theta_5[i]) * g3(i))),
            eq_88_hub: per_arm(&|i| half - l * n(c.theta_6[i]) - l * g3(i) / n(c.theta_7[i])),
            eq_88: half - n(c.theta_2) * g,
            eq_71: one - beta_2 * l * n(rho_1.min(rho_2)) * square / (half * beta_1 * least),
        }
    }

    pub(super) fn named(&self) -> [(&'static str, N); 13] {
        [
            ("(71)", self.eq_71),
            ("(82)", self.eq_82),
            ("(83) k", self.eq_83),
            ("(83) k1", self.eq_83_hub[0]),
            ("(83) k2", self.eq_83_hub[1]),
            ("(85) arm 1", self.eq_85[0]),
            ("(85) arm 2", self.eq_85[1]),
            ("(86)", self.eq_86),
            ("(87) arm 1", self.eq_87[0]),
            ("(87) arm 2", self.eq_87[1]),
            ("(88) arm 1", self.eq_88_hub[0]),
            ("(88) arm 2", self.eq_88_hub[1]),
            ("(88) object", self.eq_88),
        ]
    }
}

/// The conditions that these constants do not certainly satisfy. (84) holds for b_3 = γ_3 = g_3i = ζ_3i = 2.
#[must_use]
pub fn violated(grasp: &Grasp, gains: &Gains, constants: &Constants) -> Vec<&'static str> {
    Margins::<Interval>::new(grasp, gains, constants)
        .named()
        .into_iter()
        .filter(|(_, margin)| !margin.is_positive())
        .map(|(name, _)| name)
        .collect()
}

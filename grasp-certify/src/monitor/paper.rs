//! H of the paper's law, (67)–(69), and its bound (90).

use super::{Integrals, Sample};
use crate::printed::{self, Verdict};
use crate::settings::Settings;

/// The paper's H without the contribution of the estimates' ideal values, which depends on disturbances known only at the
/// end.
#[derive(Clone, Debug)]
pub struct PaperLaw {
    settings: Settings,
    beta: [f64; 2],
    /// φ as printed and the least h, if constants exist that satisfy the conditions.
    claimed: Option<[f64; 2]>,
}

impl PaperLaw {
    /// For these gains. If the conditions have no solution, β_1 is the smallest that any gains allow and β_2 is such that
    /// φ_1 as printed is ½.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        let (grasp, gains) = (settings.grasp(), settings.printed_gains());
        let [a, b] = grasp.arms;
        if let Verdict::Feasible(constants) = printed::decide(&grasp, &gains) {
            let bounds = printed::bounds(&grasp, &gains, &settings.learning(), &constants);
            let c = bounds.constants;
            return Self {
                settings: settings.clone(),
                beta: [c.beta_1, c.beta_2],
                claimed: Some([bounds.phi_printed, bounds.h]),
            };
        }
        let beta_1 = printed::smallest_b_of_all() / (a.ei + b.ei);
        let least = a.ei.min(b.ei).min(a.rho).min(b.rho);
        let beta_2 = 0.25 * beta_1 * least / (grasp.length * a.rho.min(b.rho) * grasp.length.powi(2).min(1.0));
        Self { settings: settings.clone(), beta: [beta_1, beta_2], claimed: None }
    }

    /// Whether (90) claims anything for these gains.
    #[must_use]
    pub fn is_claimed(&self) -> bool {
        self.claimed.is_some()
    }

    /// H, E, C, V_o, V_I1, V_I2. `disturbance` are bounds of |Δ_1|, |Δ_2|, |Δ̄|: with W* = U_i* = 0, the networks' errors
    /// are the disturbances themselves, and these are π̄_i and ε̄.
    #[must_use]
    pub fn values(&self, integrals: &Integrals, sample: &Sample, disturbance: [f64; 3]) -> [f64; 6] {
        let learning = self.settings.learning();
        let grasp = self.settings.grasp();
        let part = |gain: f64, error: f64| if gain > 0.0 { 0.5 * error * error / gain } else { 0.0 };
        let end = |i: usize, inertia: f64, gains: [[f64; 2]; 3]| {
            0.5 * sample.error[i].powi(2)
                + 0.5 * inertia * sample.surface[i].powi(2)
                + part(gains[0][0], sample.weights[i])
                + part(gains[1][0], disturbance[i] - sample.bound[i])
                + part(gains[2][0], inertia - sample.inertia[i])
        };
        let v_o = end(2, grasp.mass, [learning.weights, learning.bias, learning.mass]);
        let hub = |i: usize| {
            let gains = [learning.hub_weights[i], learning.hub_bias[i], learning.inertia[i]];
            end(i, grasp.arms[i].hub_inertia, gains)
        };
        let (e, c) = (self.beta[0] * integrals.energy, self.beta[1] * integrals.first);
        let (v_1, v_2) = (hub(0), hub(1));
        [v_o + e + c + v_1 + v_2, e, c, v_o, v_1, v_2]
    }

    /// (90) at `time` \[s\] after the first value of H; h with ε̄ and π̄_i of these disturbances.
    #[must_use]
    pub fn bound(&self, first: f64, time: f64, disturbance: [f64; 3]) -> Option<f64> {
        let [phi, h] = self.claimed?;
        let (learning, gains) = (self.settings.learning(), &self.settings.paper);
        let [d1, d2, d] = disturbance;
        // γ_3 = ζ_3i = 2, as in `printed::bounds`.
        let more = 2.0 * learning.bias[1] * d * d
            + 0.2785 * gains.object.epsilon1 * d
            + (0..2)
                .map(|i| {
                    let pi = [d1, d2][i];
                    2.0 * learning.hub_bias[i][1] * pi * pi + 0.2785 * gains.posture[i].epsilon2 * pi
                })
                .sum::<f64>();
        Some(first * (-phi * time).exp() + (h + more) / phi)
    }
}

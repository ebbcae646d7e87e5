//! The law with root strain in the posture surface: a certified decay rate and ultimate bounds.
//!
//! What is proved holds for the undiscretised, undamped beams in continuous time, without limits of the actuators, for
//! fixed gains: constants ε_1, ε_2, τ_i and storage functions V exist for which H of `form` satisfies
//!
//! ```text
//! Ḣ ≤ −φ H + D √(2H/θ),   θ W ≤ H ≤ (2−θ) W,   D² = Σ B Δ²/m²,
//! ```
//!
//! so W decays like e^{−φt} and ends below 2D²/(φθ)². The constants come from a search; that they do it is checked
//! with intervals.

mod beam;
mod form;
mod port;

use crate::Grasp;
use crate::interval::{Interval, Number, is_positive_definite};
use crate::search::maximise;
pub use port::Port;
use serde::Serialize;

/// The constants of H.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Constants {
    /// Weight ε_1 of Σρ∫(x−l)ẏq' \[1/(m·s)\].
    pub epsilon_1: f64,
    /// Weight ε_2 \[1/s\].
    pub epsilon_2: f64,
    /// Weights τ_i of (l e_i − p)² ≤ (l³/3EI_i) EI_i∫q_i''².
    pub tau: [f64; 2],
    /// A, B, w of V = ½A p² + ½B(ζ + w p)², by end: hub 1, hub 2, object.
    pub storage: [[f64; 3]; 3],
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

/// What stays in the end, or follows from a value of W.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// W \[J\].
    pub energy: f64,
    /// |e_i| \[rad\].
    pub angle: [f64; 2],
    /// |p| \[m\].
    pub position: f64,
    /// (3EI_i/l³)|q_i(l)|, the contact force that the arm's bending makes at rest \[N\].
    pub force: [f64; 2],
}

/// Logarithms of the constants, but w in units of f G.
fn unpack(ports: &[Port; 3], x: &[f64; 13]) -> Constants {
    Constants {
        epsilon_1: x[0].exp(),
        epsilon_2: x[1].exp(),
        tau: [x[2].exp(), x[3].exp()],
        storage: std::array::from_fn(|end| {
            let at = 4 + 3 * end;
            let scale = ports[end].effective_feedforward() * ports[end].slope;
            [x[at].exp(), x[at + 1].exp(), x[at + 2] * scale]
        }),
    }
}

fn proves<N: Number>(grasp: &Grasp, ports: &[Port; 3], constants: &Constants, phi: f64) -> bool {
    form::decay::<N>(grasp, ports, constants, phi).is_some_and(|matrix| is_positive_definite(&matrix))
}

/// The largest value up to `limit` for which `holds`, starting from `least`; `holds` is true up to it. None if not even `least`.
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

/// Where the search begins: with V = ½(G/c)p² + ½mβ(ζ + fGp)², for which −dV/dt − ṗS is
/// [β k η²/f·m + ṗη(β(f − m c k (1−f)) − 1)/(f c) + ṗ²/(f c)] ≥ 0, η = ζ + fGp; the best of a grid of ε_1, ε_2, τ.
fn start(grasp: &Grasp, ports: &[Port; 3]) -> Option<[f64; 13]> {
    let mut x = [0.0; 13];
    for (end, port) in ports.iter().enumerate() {
        let (k, f) = (port.effective_reach(), port.effective_feedforward());
        let coupling = port.inertia * port.strain * k;
        let beta = 1.0 / (f - coupling * (1.0 - f)).abs().max(1e-3 * coupling);
        x[4 + 3 * end..7 + 3 * end].copy_from_slice(&[
            (port.slope / port.strain).ln(),
            (port.inertia * beta).ln(),
            1.0,
        ]);
    }
    let time = grasp.arms.iter().map(|arm| grasp.length.powi(2) * (arm.rho / arm.ei).sqrt()).fold(0.0, f64::max);
    let mut best = None;
    for first in 0..16 {
        for second in 1..11 {
            for third in 1..13 {
                let epsilon_1 = 2.0 / time * 0.5f64.powi(first);
                let epsilon_2 = epsilon_1 * 0.5f64.powi(second);
                x[0] = epsilon_1.ln();
                x[1] = epsilon_2.ln();
                for i in 0..2 {
                    let most = (1.5 * epsilon_1 + epsilon_2) * grasp.tip_stiffness(i);
                    x[2 + i] = (most * 0.5f64.powi(third)).ln();
                }
                let rate = rate(grasp, ports, &x);
                if best.is_none_or(|(_, highest)| rate > highest) {
                    best = Some((x, rate));
                }
            }
        }
    }
    best.filter(|(_, rate)| *rate > 0.0).map(|(x, _)| x)
}

/// φ in floating point; −1 if there is none.
fn rate(grasp: &Grasp, ports: &[Port; 3], x: &[f64; 13]) -> f64 {
    let constants = unpack(ports, x);
    if !form_is_positive(grasp, &constants) {
        return -1.0;
    }
    largest(1e-6, 1e6, |phi| proves::<f64>(grasp, ports, &constants, phi)).unwrap_or(-1.0)
}

/// H has to bound W from below.
fn form_is_positive(grasp: &Grasp, constants: &Constants) -> bool {
    form::dominates::<f64>(grasp, constants, 1e-3)
}

/// The best certificate that a search finds. None if it finds none, which proves nothing.
///
/// Needs positive inertias and gains; without feed-forward (f = 0) or root strain (c = 0) there is no such certificate.
#[must_use]
pub fn certify(grasp: &Grasp, ports: &[Port; 3]) -> Option<Certificate> {
    let usable = |port: &Port| {
        [port.inertia, port.assumed_inertia, port.slope, port.reach, port.strain, port.feedforward]
            .iter()
            .all(|value| *value > 0.0 && value.is_finite())
    };
    if !ports.iter().all(usable) {
        return None;
    }
    let (found, rate) = maximise(|x| rate(grasp, ports, x), start(grasp, ports)?, 0.1, 12_000);
    let constants = unpack(ports, &found);
    verify(grasp, ports, &constants, rate)
}

/// The certificate of given constants, with a rate of at most `phi`: the part that is a proof.
#[must_use]
pub fn verify(grasp: &Grasp, ports: &[Port; 3], constants: &Constants, phi: f64) -> Option<Certificate> {
    // Rounding costs a few parts in 1e12 of the largest entries; what fails a little below is no matter of rounding.
    let below = [1e-7, 1e-5, 1e-3];
    let phi = below
        .iter()
        .map(|share| phi * (1.0 - share))
        .find(|phi| *phi > 0.0 && proves::<Interval>(grasp, ports, constants, *phi))?;
    let theta = largest(1e-4, 1.0, |theta| form::dominates::<Interval>(grasp, constants, theta))?;
    Some(Certificate { phi, theta, constants: *constants })
}

impl Certificate {
    /// What a value of W \[J\] implies.
    #[must_use]
    pub fn implied(&self, grasp: &Grasp, energy: f64) -> Bound {
        if energy == 0.0 {
            return Bound { energy, angle: [0.0; 2], position: 0.0, force: [0.0; 2] };
        }
        let n = Interval::exact;
        let w = n(2.0) * n(energy);
        let by = |weight: f64| Number::sqrt(w / n(weight)).hi();
        let cube = n(grasp.length) * n(grasp.length) * n(grasp.length);
        Bound {
            energy,
            angle: std::array::from_fn(|i| by(self.constants.storage[i][0])),
            position: by(self.constants.storage[2][0]),
            force: std::array::from_fn(|i| Number::sqrt(n(3.0) * n(grasp.arms[i].ei) * w / cube).hi()),
        }
    }

    /// The ultimate bound under disturbances of at most these sizes: on hub 1, hub 2 \[N·m\], on the object \[N\]. With the
    /// law's own estimates in the loop it is what the estimates leave that counts.
    #[must_use]
    pub fn ultimate(&self, grasp: &Grasp, ports: &[Port; 3], disturbances: [f64; 3]) -> Bound {
        let n = Interval::exact;
        let mut square = n(0.0);
        for (end, disturbance) in disturbances.into_iter().enumerate() {
            let share = n(disturbance) / n(ports[end].inertia);
            square = square + n(self.constants.storage[end][1]) * share * share;
        }
        let rate = n(self.phi) * n(self.theta);
        let energy = if disturbances == [0.0; 3] { 0.0 } else { (n(2.0) * square / (rate * rate)).hi() };
        self.implied(grasp, energy)
    }

    /// What estimators with leakage would cost. An estimate x̂ of a constant x with the law x̂˙ = a(… − b x̂) adds x̃²/2a to H and
    /// −½b x̃² + ½b x² to its rate. Given (a b \[1/s\], ½ b x² \[W\]) of each: the rate and W's ultimate bound.
    #[must_use]
    pub fn with_leakage(&self, estimators: &[(f64, f64)]) -> (f64, f64) {
        let phi = estimators.iter().fold(self.phi, |phi, (rate, _)| phi.min(*rate));
        let cost: f64 = estimators.iter().map(|(_, cost)| cost).sum();
        (phi, cost / (phi * self.theta))
    }

    /// W at rest with these errors of the angles and of the position, the arms bent as at rest \[J\].
    #[must_use]
    pub fn energy_at_rest(&self, grasp: &Grasp, ports: &[Port; 3], angle: [f64; 2], position: f64) -> f64 {
        let l = grasp.length;
        let mut energy = 0.0;
        let mut load = [0.0; 3];
        for i in 0..2 {
            let tip = l * angle[i] - position;
            let force = grasp.tip_stiffness(i) * tip;
            energy += 0.5 * force * tip;
            load[i] = force * l;
            load[2] -= force;
        }
        let errors = [angle[0], angle[1], position];
        for end in 0..3 {
            let [a, b, w] = self.constants.storage[end];
            let zeta = ports[end].effective_feedforward() * ports[end].strain * load[end];
            energy += 0.5 * a * errors[end].powi(2) + 0.5 * b * (zeta + w * errors[end]).powi(2);
        }
        energy
    }

    /// Time after which both forces of bending certainly stay within `tolerance` \[N\] without disturbances, from W = `energy`.
    #[must_use]
    pub fn settling_time(&self, grasp: &Grasp, energy: f64, tolerance: f64) -> f64 {
        let allowed = (0..2).map(|i| 0.5 * tolerance.powi(2) / grasp.tip_stiffness(i)).fold(f64::INFINITY, f64::min);
        ((2.0 - self.theta) / self.theta * energy / allowed).ln().max(0.0) / self.phi
    }
}

#[cfg(test)]
mod tests;

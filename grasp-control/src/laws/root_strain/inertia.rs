//! Estimates of the object's mass and of the hubs' inertias by weighted least squares.
//!
//! The update laws (39) and (57) answer to s and so to everything that makes s; they cannot tell a heavy object from a disturbance,
//! and stop as soon as s is small. What tells an inertia is the prediction error of (10) or (11), J ẍ = f + Δ with the known
//! force f, the limited command less the load: composite adaptation (Slotine and Li, 1989,
//! doi:10.1016/0005-1098(89)90094-0). A part of Δ moves with the load N (root moment; tip shears): arms that lose energy act with
//! −c Ṅ, Section IV's uncertainty. That takes most of the torque of a light hub, so without c in the model Ĵ would be several
//! times too large. c is estimated with it. No acceleration is measured, so all go through the same filters, which also take
//! constants away:
//!
//! ```text
//! a = filtered ẍ,  f = filtered force,  n = filtered Ṅ;   a = β f − γ n,   Ĵ = 1/β,   c = γ/β
//! Ṡ_xy = ω (x y − f² S_xy/S)  for the pairs of a, f, n,    ω = f²/(f² + f₀²)
//! ⎡S_ff + w     −S_fn    ⎤ ⎡β⎤   ⎡S_af + w/J₀⎤
//! ⎣ −S_fn    S_nn + w Ω² ⎦ ⎣γ⎦ = ⎣   −S_an   ⎦ ,   1/β clamped,  γ ≥ 0,    Ω² = (dN/dx)/J₀
//! ```
//!
//! The regression is of acceleration on force, because force is the better known of the two. ω is the condition of excitation:
//! forces below f₀ are no better known than dead zones and friction are, and do not count. S forgets by excitation and not by
//! time: without motion nothing is learnt and nothing forgotten.

mod continuous;

use crate::blocks::exponential::exp_m1;
use serde::{Deserialize, Serialize};

/// Settings of the estimator of the mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MassGains {
    /// Mass m₀ at the start \[kg\].
    pub initial: f64,
    /// Smallest estimate \[kg\].
    pub smallest: f64,
    /// Largest estimate \[kg\].
    pub largest: f64,
    /// Force f₀ below which motion tells little \[N\].
    pub threshold: f64,
    /// Weight w of the mass at the start \[N²·s\].
    pub prior: f64,
    /// Excitation S that is remembered \[N²·s\].
    pub memory: f64,
}

/// Settings of the estimators of the hubs' inertias; each begins at what the observers are told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InertiaGains {
    /// Smallest estimate in units of the inertia at the start.
    pub smallest: f64,
    /// Largest estimate in units of the inertia at the start.
    pub largest: f64,
    /// Torque f₀ below which motion tells little \[N·m\].
    pub threshold: f64,
    /// Weight w of the inertia at the start \[N²·m²·s\].
    pub prior: f64,
    /// Excitation S that is remembered \[N²·m²·s\].
    pub memory: f64,
}

/// Filters of all estimators.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FilterGains {
    /// Bandwidth of the filter that stands for the differentiation \[rad/s\].
    pub bandwidth: f64,
    /// Corner below which nothing counts \[rad/s\]: constant disturbances do not.
    pub high_pass: f64,
}

/// What an estimator is told. Units: [`MassGains`], [`InertiaGains`]; inertias in kg or kg·m².
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Prior {
    pub initial: f64,
    pub smallest: f64,
    pub largest: f64,
    pub threshold: f64,
    pub weight: f64,
    pub memory: f64,
    /// dN/dx, what the arm's load does against a motion \[N/m or N·m/rad\].
    pub stiffness: f64,
}

impl Prior {
    /// Half of the lower part of β that there is without any motion.
    fn least(&self, has_losses: bool) -> f64 {
        0.5 * if has_losses { self.weight * (self.weight * self.stiffness / self.initial) } else { self.weight }
    }

    /// ω for a squared force.
    fn counting(&self, square: f64) -> f64 {
        square / (square + self.threshold * self.threshold)
    }
}

/// What is known of a coordinate's motion: its rate, the known force on it, and the load in that.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving {
    pub rate: f64,
    pub force: f64,
    pub load: f64,
}

/// Acceleration a, force f and the load's rate n; or filters of these.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Signals {
    a: f64,
    f: f64,
    n: f64,
}

/// The sums S.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Sums {
    ff: f64,
    nn: f64,
    nf: f64,
    af: f64,
    an: f64,
}

impl Sums {
    fn of(Signals { a, f, n }: Signals) -> Self {
        Self { ff: f * f, nn: n * n, nf: n * f, af: a * f, an: a * n }
    }

    /// The sum of a share of these and a share of others.
    fn combine(&self, own: f64, other: &Self, share: f64) -> Self {
        Self {
            ff: own * self.ff + share * other.ff,
            nn: own * self.nn + share * other.nn,
            nf: own * self.nf + share * other.nf,
            af: own * self.af + share * other.af,
            an: own * self.an + share * other.an,
        }
    }
}

/// An estimator's state.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Estimator {
    /// Low-passed rate, force and load, in this order.
    smooth: Signals,
    /// What the high-pass takes away.
    slow: Signals,
    sums: Sums,
}

impl Estimator {
    /// Nothing learnt, filters in equilibrium at this motion without a force.
    pub fn settled(rate: f64, load: f64) -> Self {
        Self { smooth: Signals { a: rate, f: 0.0, n: load }, ..Self::default() }
    }

    /// The sums with the prior's weight in them.
    fn weighted(&self, prior: &Prior) -> Sums {
        let Prior { initial, weight: w, stiffness, .. } = *prior;
        let Sums { ff, nn, nf, af, an } = self.sums;
        Sums { ff: ff + w, nn: nn + w * stiffness / initial, nf, af: af + w / initial, an }
    }

    /// 1/β with β in its bounds, and whether it is inside of them.
    fn clamped(prior: &Prior, above: f64, below: f64) -> (f64, bool) {
        let (least, most) = (below / prior.largest, below / prior.smallest);
        (below / above.clamp(least, most), (least..=most).contains(&above))
    }

    /// β as a fraction, and whether losses are part of it: they never drive, so γ is positive or nothing.
    ///
    /// Sums of squares and products have ff nn ≥ nf², so with the prior's weight the lower part is at least that of the prior alone.
    /// A solver's trial states need not be such sums: for them is the bound, half of that.
    fn fraction(prior: &Prior, weighted: &Sums) -> (f64, f64, bool) {
        let Sums { ff, nn, nf, af, an } = *weighted;
        let has_losses = nf * af > ff * an;
        let (above, below) = if has_losses { (af * nn - nf * an, ff * nn - nf * nf) } else { (af, ff) };
        (above, below.max(prior.least(has_losses)), has_losses)
    }

    /// Ĵ.
    pub fn inertia(&self, prior: &Prior) -> f64 {
        let (above, below, _) = Self::fraction(prior, &self.weighted(prior));
        Self::clamped(prior, above, below).0
    }

    fn signals(&self, filter: &FilterGains, moving: Moving) -> Signals {
        Signals {
            a: filter.bandwidth * (moving.rate - self.smooth.a) - self.slow.a,
            f: self.smooth.f - self.slow.f,
            n: filter.bandwidth * (moving.load - self.smooth.n) - self.slow.n,
        }
    }

    /// d/dt Ĵ.
    pub fn inertia_rate(&self, filter: &FilterGains, prior: &Prior, moving: Moving) -> f64 {
        let signals = self.signals(filter, moving);
        let square = signals.f * signals.f;
        let weight = prior.counting(square);
        self.inertia_change(prior, &Sums::of(signals).combine(weight, &self.sums, -weight * square / prior.memory))
    }

    /// Change of Ĵ for a change `by` of the sums.
    fn inertia_change(&self, prior: &Prior, by: &Sums) -> f64 {
        let weighted = self.weighted(prior);
        let (above, below, has_losses) = Self::fraction(prior, &weighted);
        let Sums { ff, nn, nf, af, an } = weighted;
        let (above_change, mut below_change) = if has_losses {
            (by.af * nn + af * by.nn - by.nf * an - nf * by.an, by.ff * nn + ff * by.nn - 2.0 * nf * by.nf)
        } else {
            (by.af, by.ff)
        };
        if below <= prior.least(has_losses) {
            below_change = 0.0;
        }
        let (inertia, inside) = Self::clamped(prior, above, below);
        if inside { (below_change - inertia * above_change) / above } else { 0.0 }
    }

    /// Advances by `h` \[s\] with a held motion; the sums hold their regressors over the step.
    pub fn step(&mut self, h: f64, filter: &FilterGains, shares: &Shares, prior: &Prior, moving: Moving) {
        let signals = self.signals(filter, moving);
        let square = signals.f * signals.f;
        let weight = h * prior.counting(square);
        // Forgetting by an implicit step: stable for every excitation, and no exponential.
        let decay = 1.0 / (1.0 + weight * square / prior.memory);
        self.sums = self.sums.combine(decay, &Sums::of(signals), decay * weight);
        let Shares { slow, follow } = *shares;
        self.slow.a += slow * signals.a;
        self.slow.f += slow * signals.f;
        self.slow.n += slow * signals.n;
        self.smooth.a += follow * (moving.rate - self.smooth.a);
        self.smooth.f += follow * (moving.force - self.smooth.f);
        self.smooth.n += follow * (moving.load - self.smooth.n);
    }
}

/// By how much of their distance high-pass and low-pass move in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shares {
    slow: f64,
    follow: f64,
}

impl FilterGains {
    /// For a step of `h` \[s\].
    pub(super) fn shares(&self, h: f64) -> Shares {
        Shares { slow: -exp_m1(-self.high_pass * h), follow: -exp_m1(-self.bandwidth * h) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILTER: FilterGains = FilterGains { bandwidth: 150.0, high_pass: 3.0 };
    const HUB: Prior = Prior {
        initial: 0.0073,
        smallest: 0.000_73,
        largest: 0.146,
        threshold: 0.1,
        weight: 3e-4,
        memory: 0.1,
        stiffness: 1.725,
    };

    /// A hub on a spring with losses −c Ṁ, under a torque that goes to and fro for two seconds and a constant one that nobody
    /// knows.
    fn learnt(inertia: f64, loss: f64) -> Estimator {
        let (h, mut angle, mut rate) = (1e-4, 0.0, 0.0);
        let mut estimator = Estimator::settled(rate, 0.0);
        for step in 0..20_000 {
            let load = HUB.stiffness * angle;
            let torque = (25.0 * f64::from(step) * h).sin() + 0.5 * (60.0 * f64::from(step) * h).sin() - load;
            let acceleration = (torque - loss * HUB.stiffness * rate + 0.05) / inertia;
            rate += 0.5 * h * acceleration;
            estimator.step(h, &FILTER, &FILTER.shares(h), &HUB, Moving { rate, force: torque, load });
            rate += 0.5 * h * acceleration;
            angle += h * rate;
        }
        estimator
    }

    #[test]
    fn the_inertia_is_found_beside_losses_and_a_constant_torque() {
        let mut found = Vec::new();
        for ratio in [0.5, 1.0, 2.0, 5.0, 14.0] {
            for loss in [0.0, 0.025, 0.1] {
                found.push((ratio, loss, learnt(ratio * HUB.initial, loss).inertia(&HUB) / (ratio * HUB.initial)));
            }
        }
        // The prior weighs 3e-4 beside a remembered excitation of 0.1, and pulls 1/Ĵ towards the start: by 0.3 % for each multiple of
        // it, and by more for light hubs with losses, whose torque is mostly along Ṁ.
        assert!(found.iter().all(|(_, _, ratio)| (ratio - 1.0).abs() < 0.06), "{found:.3?}");
    }

    /// The projection, and the rate that is the derivative of what the steps do.
    #[test]
    fn estimates_stay_in_their_bounds_and_move_at_their_rate() {
        let estimator = learnt(5.0 * HUB.initial, 0.05);
        let held = Prior { smallest: HUB.initial, largest: HUB.initial, ..HUB };
        assert!((estimator.inertia(&held) - HUB.initial).abs() < 1e-15);
        let moving = Moving { rate: 0.3, force: 0.4, load: 0.1 };
        assert_eq!(estimator.inertia_rate(&FILTER, &held, moving), 0.0);
        // One-sided, so the error is that of the next order, h/2 times what relatively changes within a filter's 7 ms.
        let (mut after, h) = (estimator, 1e-7);
        after.step(h, &FILTER, &FILTER.shares(h), &HUB, moving);
        let difference = (after.inertia(&HUB) - estimator.inertia(&HUB)) / h;
        let rate = estimator.inertia_rate(&FILTER, &HUB, moving);
        assert!(rate != 0.0 && (difference - rate).abs() < 1e-3 * rate.abs(), "{difference} {rate}");
    }

    /// Rest, and torques far below the threshold, which count by their fourth power.
    #[test]
    fn nothing_is_forgotten_without_excitation() {
        let mut estimator = learnt(3.0 * HUB.initial, 0.05);
        estimator.smooth = Signals::default();
        estimator.slow = Signals::default();
        let before = estimator.inertia(&HUB);
        let shares = FILTER.shares(1e-3);
        for step in 0..100_000 {
            let force = 0.002 * f64::from(step % 7 - 3);
            estimator.step(1e-3, &FILTER, &shares, &HUB, Moving { rate: 0.0, force, load: 0.0 });
        }
        let change = estimator.inertia(&HUB) / before - 1.0;
        assert!(change.abs() < 1e-3, "{change}");
    }
}

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

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

mod continuous;
mod settings;
mod side_by_side;
#[cfg(test)]
mod tests;

pub use settings::{FilterGains, InertiaGains, MassGains};
pub(super) use side_by_side::{Estimators, OfSize, Priors, Sights};

use crate::blocks::exponential::exp_m1;
use crate::blocks::four::Number;
use serde::{Deserialize, Serialize};

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

    /// What follows from it for every step.
    fn weights(&self) -> Weights<f64> {
        let Self { initial, smallest, largest, threshold, weight, memory, stiffness } = *self;
        Weights {
            force: weight,
            load: weight * stiffness / initial,
            acceleration: weight / initial,
            least: [self.least(false), self.least(true)],
            smallest,
            largest,
            threshold: threshold * threshold,
            memory,
        }
    }
}

/// What a [`Prior`] adds to the sums and how it bounds what comes of them: of one coordinate, or of several side by side.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Weights<V> {
    /// Weights in S_ff, S_nn and S_af.
    force: V,
    load: V,
    acceleration: V,
    /// Of the lower part of β, without losses and with them.
    least: [V; 2],
    smallest: V,
    largest: V,
    /// f₀².
    threshold: V,
    memory: V,
}

impl<V: Copy> Weights<V> {
    /// How many they are.
    const NUMBERS: usize = 9;

    fn to_array(self) -> [V; 9] {
        let Self { force, load, acceleration, least: [without, with], smallest, largest, threshold, memory } = self;
        [force, load, acceleration, without, with, smallest, largest, threshold, memory]
    }

    #[inline(always)]
    fn from_array(numbers: [V; 9]) -> Self {
        let [force, load, acceleration, without, with, smallest, largest, threshold, memory] = numbers;
        Self { force, load, acceleration, least: [without, with], smallest, largest, threshold, memory }
    }
}

/// What is known of a coordinate's motion: its rate, the known force on it, and the load in that.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving<V = f64> {
    pub rate: V,
    pub force: V,
    pub load: V,
}

/// Acceleration a, force f and the load's rate n; or filters of these.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Signals<V = f64> {
    a: V,
    f: V,
    n: V,
}

/// The sums S.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Sums<V = f64> {
    ff: V,
    nn: V,
    nf: V,
    af: V,
    an: V,
}

impl<V: Number> Sums<V> {
    #[inline(always)]
    fn of(Signals { a, f, n }: Signals<V>) -> Self {
        Self { ff: f * f, nn: n * n, nf: n * f, af: a * f, an: a * n }
    }

    /// The sum of a share of these and a share of others.
    #[inline(always)]
    fn combine(&self, own: V, other: &Self, share: V) -> Self {
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
pub(super) struct Estimator<V = f64> {
    /// Low-passed rate, force and load, in this order.
    smooth: Signals<V>,
    /// What the high-pass takes away.
    slow: Signals<V>,
    sums: Sums<V>,
}

impl Estimator {
    /// Nothing learnt, filters in equilibrium at this motion without a force.
    pub fn settled(rate: f64, load: f64) -> Self {
        Self { smooth: Signals { a: rate, f: 0.0, n: load }, ..Self::default() }
    }

    /// The sums with the prior's weight in them.
    fn weighted(&self, prior: &Prior) -> Sums {
        self.sums_with(&prior.weights())
    }

    /// 1/β with β in its bounds, and whether it is inside of them.
    fn clamped(prior: &Prior, above: f64, below: f64) -> (f64, bool) {
        let (least, most) = (below / prior.largest, below / prior.smallest);
        (bounded(&prior.weights(), above, below), (least..=most).contains(&above))
    }

    /// β as a fraction, and whether losses are part of it.
    fn fraction(prior: &Prior, weighted: &Sums) -> (f64, f64, bool) {
        let (above, below) = fraction(&prior.weights(), weighted);
        (above, below, weighted.nf * weighted.af > weighted.ff * weighted.an)
    }

    /// Ĵ.
    pub fn inertia(&self, prior: &Prior) -> f64 {
        self.inertia_with(&prior.weights())
    }

    fn signals(&self, filter: &FilterGains, moving: Moving) -> Signals {
        self.signals_of(filter.bandwidth, &moving)
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
}

/// β as a fraction. Losses, if they are part of it, never drive, so γ is positive or nothing.
///
/// Sums of squares and products have ff nn ≥ nf², so with the prior's weight the lower part is at least that of the prior alone.
/// A solver's trial states need not be such sums: for them is the bound, half of that.
#[inline(always)]
fn fraction<V: Number>(weights: &Weights<V>, weighted: &Sums<V>) -> (V, V) {
    let Sums { ff, nn, nf, af, an } = *weighted;
    // Larger: there are losses.
    let (one, other) = (nf * af, ff * an);
    let below = one.where_larger(other, ff * nn - nf * nf, ff);
    let least = one.where_larger(other, weights.least[1], weights.least[0]);
    (one.where_larger(other, af * nn - nf * an, af), below.larger(least))
}

/// 1/β with β in its bounds.
#[inline(always)]
fn bounded<V: Number>(weights: &Weights<V>, above: V, below: V) -> V {
    let (least, most) = (below / weights.largest, below / weights.smallest);
    below / most.smaller(least.larger(above))
}

impl<V: Number> Estimator<V> {
    #[inline(always)]
    fn sums_with(&self, weights: &Weights<V>) -> Sums<V> {
        let Sums { ff, nn, nf, af, an } = self.sums;
        Sums { ff: ff + weights.force, nn: nn + weights.load, nf, af: af + weights.acceleration, an }
    }

    #[inline(always)]
    fn inertia_with(&self, weights: &Weights<V>) -> V {
        let (above, below) = fraction(weights, &self.sums_with(weights));
        bounded(weights, above, below)
    }

    #[inline(always)]
    fn signals_of(&self, bandwidth: V, moving: &Moving<V>) -> Signals<V> {
        Signals {
            a: bandwidth * (moving.rate - self.smooth.a) - self.slow.a,
            f: self.smooth.f - self.slow.f,
            n: bandwidth * (moving.load - self.smooth.n) - self.slow.n,
        }
    }

    /// Advances by `h` \[s\] with a held motion; the sums hold their regressors over the step.
    #[inline(always)]
    fn step_with(&mut self, h: V, bandwidth: V, [slow, follow]: [V; 2], weights: &Weights<V>, moving: &Moving<V>) {
        let signals = self.signals_of(bandwidth, moving);
        let square = signals.f * signals.f;
        let weight = h * (square / (square + weights.threshold));
        // Forgetting by an implicit step: stable for every excitation, and no exponential.
        let one = V::splat(1.0);
        let decay = one / (one + weight * square / weights.memory);
        self.sums = self.sums.combine(decay, &Sums::of(signals), decay * weight);
        self.slow.a = self.slow.a + slow * signals.a;
        self.slow.f = self.slow.f + slow * signals.f;
        self.slow.n = self.slow.n + slow * signals.n;
        self.smooth.a = self.smooth.a + follow * (moving.rate - self.smooth.a);
        self.smooth.f = self.smooth.f + follow * (moving.force - self.smooth.f);
        self.smooth.n = self.smooth.n + follow * (moving.load - self.smooth.n);
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

//! What a loop of NABFC learns, eqs. (37)–(39) and (55)–(57).
//!
//! The object's loop and those of the posture learn alike: the inertia that they move, a bound on the error of their
//! network, and the network's weights. Each of the three follows a leaky law with a forcing of its own.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

mod continuous;

pub(crate) use continuous::{EstimatorChange, Scalars};

use crate::blocks::adaptation::{HeldStep, LeakyLaw, Steps};
use crate::blocks::four::{Four, Lanes};
use crate::blocks::rbf::Network;
use serde::{Deserialize, Serialize};

/// The update laws of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Laws {
    /// Of the weights, (37) and (55).
    pub weights: LeakyLaw,
    /// Of the bound, (38) and (56).
    pub bound: LeakyLaw,
    /// Of the inertia, (39) and (57).
    pub inertia: LeakyLaw,
    /// Radius ω₃ of the ball that holds the weights (Lemma 3); 0 = no bound.
    pub radius: f64,
}

/// What drives the estimates at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drive {
    /// The sliding variable; the weights' forcing is s Y.
    pub s: f64,
    /// Forcing of the bound.
    pub bound: f64,
    /// Forcing of the inertia.
    pub inertia: f64,
}

/// Time derivatives of the estimates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EstimateRates {
    /// d/dt of the inertia.
    pub inertia: f64,
    /// d/dt of the bound.
    pub bound: f64,
    /// d/dt of the norm of the weights.
    pub norm: f64,
    /// d/dt of the network's output at the point where it is evaluated.
    pub output: f64,
}

/// The estimates of one loop, whose network has `D` inputs.
#[derive(Debug, Serialize, Deserialize)]
#[repr(C, align(64))] // The estimates and the beginning of the network, which a step touches, are on one line of the cache.
pub(crate) struct Estimator<const D: usize> {
    laws: Laws,
    initial_inertia: f64,
    /// m̂ \[kg\] or Ĵ \[kg·m²\].
    pub inertia: f64,
    /// ε̂ \[N\] or π̂ \[N·m\].
    pub bound: f64,
    /// Ŵᵀ Y(X) or Ûᵀ Y(Z).
    pub network: Network<D>,
    /// Whether the network does anything: with zero weights and no adaptation it need not be evaluated.
    has_network: bool,
    /// Of the last size, for all steps but the usual one.
    #[serde(skip)]
    steps: Option<Box<Steps>>,
}

impl<const D: usize> Clone for Estimator<D> {
    fn clone(&self) -> Self {
        let Self { laws, initial_inertia, inertia, bound, network, has_network, steps: _ } = self;
        Self {
            laws: *laws,
            initial_inertia: *initial_inertia,
            inertia: *inertia,
            bound: *bound,
            network: network.clone(),
            has_network: *has_network,
            steps: None,
        }
    }

    /// The same in the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        let Self { laws, initial_inertia, inertia, bound, network, has_network, steps: _ } = source;
        if self.laws != *laws {
            self.steps = None;
        }
        (self.laws, self.initial_inertia, self.has_network) = (*laws, *initial_inertia, *has_network);
        (self.inertia, self.bound) = (*inertia, *bound);
        self.network.clone_from(network);
    }
}

/// Estimates and weights, to be changed.
pub(crate) struct Learner<'a, const N: usize> {
    pub inertia: &'a mut f64,
    pub bound: &'a mut f64,
    /// Those of a usual network.
    pub weights: &'a mut [Lanes; N],
}

impl<const D: usize> Estimator<D> {
    pub fn new(laws: Laws, initial_inertia: f64, network: Network<D>) -> Self {
        Self {
            laws,
            initial_inertia,
            inertia: initial_inertia,
            bound: 0.0,
            network,
            has_network: laws.weights.gain > 0.0,
            steps: None,
        }
    }

    /// Other laws for the same estimates.
    pub fn retune(&mut self, laws: Laws) {
        self.laws = laws;
        // What has been learnt stays, even if nothing more is learnt.
        self.has_network |= laws.weights.gain > 0.0;
        self.steps = None;
    }

    /// Whether laws, initial estimates and the network's layout are those of another estimator.
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.laws == other.laws
            && self.initial_inertia == other.initial_inertia
            && self.network.has_layout_of(&other.network)
    }

    /// The update laws.
    pub fn laws(&self) -> &Laws {
        &self.laws
    }

    /// Whether its network learns, is plain and has no ball.
    pub fn is_plain(&self) -> bool {
        self.has_network && !self.has_ball() && self.network.is_plain()
    }

    /// All that it learns, if there are as many fours of weights.
    #[inline(always)]
    pub fn learner<const N: usize>(&mut self) -> Option<Learner<'_, N>> {
        let Self { inertia, bound, network, .. } = self;
        network.plain_weights().map(|weights| Learner { inertia, bound, weights })
    }

    /// Gives back the memory that the usual step does without.
    pub fn leave(&mut self) {
        self.network.leave();
        self.steps = None;
    }

    /// Back to the initial estimates.
    pub fn reset(&mut self) {
        self.inertia = self.initial_inertia;
        self.bound = 0.0;
        self.network.reset();
    }

    /// Evaluates the network's basis at a normalised input in the lanes of its axes, for all that follows.
    #[inline]
    pub fn activate(&mut self, x: &[Lanes; 2]) {
        if self.has_network {
            self.network.activate_lanes(x);
        }
    }

    /// The network's output, for a caller that knows the registers.
    #[inline(always)]
    pub fn output_here<V: Four>(&self) -> f64 {
        if self.has_network { self.network.output_here::<V>() } else { 0.0 }
    }

    /// Gradient of [`output_here`](Self::output_here) with respect to the normalised input.
    pub fn gradient(&self) -> [f64; D] {
        if self.has_network { self.network.gradient() } else { [0.0; D] }
    }

    /// Time derivatives of the estimates.
    pub fn rates(&self, drive: &Drive) -> EstimateRates {
        let Laws { weights, bound, inertia, radius } = &self.laws;
        let (mut norm, mut output) = (0.0, 0.0);
        if self.has_network {
            norm = self.network.norm_rate(weights, drive.s);
            output = weights.rate(self.network.output(), drive.s * self.network.learning_gain());
            let length = self.network.norm();
            // On the sphere, what points outwards is taken away. The scaling puts the weights there up to rounding.
            if *radius > 0.0 && norm > 0.0 && length >= radius * (1.0 - 1e-12) {
                output -= self.network.output() * norm / length;
                norm = 0.0;
            }
        }
        EstimateRates {
            inertia: inertia.rate(self.inertia, drive.inertia),
            bound: bound.rate(self.bound, drive.bound),
            norm,
            output,
        }
    }

    /// Keeps the laws' steps over `h`.
    #[inline(always)]
    fn prepare(&mut self, h: f64) {
        if self.steps.as_ref().is_none_or(|steps| steps.h != h) {
            let Laws { weights, bound, inertia, .. } = self.laws;
            let new = Steps::new(h, [weights, bound, inertia]);
            match &mut self.steps {
                Some(steps) => **steps = new,
                None => self.steps = Some(Box::new(new)),
            }
        }
    }

    /// The part that `node` of [`NODES`](crate::blocks::adaptation::NODES) has in a step of `h` \[s\], from the drive there. To be
    /// called for the first node, then for the second.
    pub fn step_sampled(&mut self, h: f64, node: usize, drive: &Drive) {
        self.prepare(h);
        if let Some(steps) = &self.steps {
            self.apply(steps.sampled.map(|step| step.part(node)), drive);
        }
    }

    fn apply(&mut self, [weights, bound, inertia]: [HeldStep; 3], drive: &Drive) {
        self.bound = bound.apply(self.bound, drive.bound);
        self.inertia = inertia.apply(self.inertia, drive.inertia);
        if self.has_network {
            self.network.adapt(weights.decay, weights.weight * drive.s);
            self.project();
        }
    }

    /// Puts the weights back on their ball, if they are out of it.
    fn project(&mut self) {
        if self.laws.radius > 0.0 {
            self.network.project(self.laws.radius);
        }
    }

    /// Advances the estimates over a step of `h` \[s\] with a drive that stays the same, exactly.
    #[inline(always)]
    pub fn step_here<V: Four>(&mut self, h: f64, drive: &Drive) {
        self.prepare(h);
        let Some(Steps { held: [weights, bound, inertia], .. }) = self.steps.as_deref() else { return };
        self.bound = bound.apply(self.bound, drive.bound);
        self.inertia = inertia.apply(self.inertia, drive.inertia);
        if self.has_network {
            self.network.adapt_here::<V>(weights.decay, weights.weight * drive.s);
            self.project();
        }
    }

    /// As [`step_sampled`](Self::step_sampled) for both nodes at once, with one sliding variable, where the weights have no ball and
    /// the network is a plain star that is [evaluated at both](Network::fill_plain_both).
    #[inline(always)]
    pub fn step_both_here<V: Four>(&mut self, h: f64, drives: &[Drive; 2]) {
        self.prepare(h);
        let Some(Steps { sampled: [weights, bound, inertia], .. }) = self.steps.as_deref() else { return };
        self.bound = bound.apply(self.bound, [drives[0].bound, drives[1].bound]);
        self.inertia = inertia.apply(self.inertia, [drives[0].inertia, drives[1].inertia]);
        if self.has_network {
            let by = [weights.weights[0] * drives[0].s, weights.weights[1] * drives[1].s];
            self.network.adapt_twice::<V>(weights.decay, by);
        }
    }

    /// Whether a ball holds the weights.
    pub fn has_ball(&self) -> bool {
        self.laws.radius > 0.0
    }
}

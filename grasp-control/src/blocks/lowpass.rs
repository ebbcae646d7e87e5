//! First-order low-pass for the measured shear rates.
//!
//! −m̂ Σ q̇ᵢ'''(l) in (36) feeds back the rate of a shear force. Its loop gain grows with frequency, and no sensor gives
//! that rate without a bandwidth. ẏ = ω (x − y) is solved exactly for inputs that are held or ramp over a step.

// Inlined, so that nothing is left of the rates of inputs that are held.
#![allow(clippy::inline_always)]

use crate::blocks::adaptation::{NODES, phi1, phi2};
use serde::{Deserialize, Serialize};

/// Two first-order low-pass filters of one bandwidth, one per arm; bandwidth 0 switches them off and passes the input through.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LowPass {
    bandwidth: f64,
    state: [f64; 2],
    #[serde(skip)]
    responses: Option<Responses>,
}

/// How far the filters have followed their input after some time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Response {
    /// Share of the distance to a held input that is gone, 1 − e^{−ωt}.
    follow: f64,
    /// What a unit rate of the input adds \[s\].
    ramp: f64,
}

/// Responses at the nodes and at the end of a step, kept for the next step of the same size.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Responses {
    h: f64,
    nodes: [Response; 2],
    end: Response,
}

impl LowPass {
    /// Filters of `bandwidth` ω \[rad/s\], ≥ 0, at rest at zero.
    #[must_use]
    pub const fn new(bandwidth: f64) -> Self {
        Self { bandwidth, state: [0.0; 2], responses: None }
    }

    /// ω \[rad/s\].
    #[must_use]
    pub const fn bandwidth(&self) -> f64 {
        self.bandwidth
    }

    /// Changes the bandwidth; the filters go on from where they are.
    pub fn set_bandwidth(&mut self, bandwidth: f64) {
        self.bandwidth = bandwidth;
        self.responses = None;
    }

    /// Whether the bandwidth is that of other filters.
    #[must_use]
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.bandwidth == other.bandwidth
    }

    /// Whether the filters do anything.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.bandwidth > 0.0
    }

    /// Puts the filters in equilibrium with `input`.
    #[inline]
    pub fn settle(&mut self, input: [f64; 2]) {
        self.state = input;
    }

    /// Where the filters are.
    #[inline]
    pub(crate) fn state(&self) -> [f64; 2] {
        self.state
    }

    /// Shares of the distance to a held input that are gone after some times \[s\].
    pub(crate) fn follows(&self, times: [f64; 3]) -> [f64; 3] {
        times.map(|time| self.response(time).follow)
    }

    /// What the filters give now.
    #[must_use]
    pub fn output(&self, input: [f64; 2]) -> [f64; 2] {
        if self.is_on() { self.state } else { input }
    }

    /// Time derivative of [`output`](Self::output) when the input changes at `rate`.
    #[must_use]
    pub fn output_rate(&self, input: [f64; 2], rate: [f64; 2]) -> [f64; 2] {
        if self.is_on() { std::array::from_fn(|i| self.bandwidth * (input[i] - self.state[i])) } else { rate }
    }

    /// Whether the output stays constant as long as `input` is held.
    #[must_use]
    pub fn is_settled(&self, input: [f64; 2]) -> bool {
        !self.is_on() || self.state == input
    }

    /// What the filters give at the [`NODES`] of a step of `h` \[s\], for an input that starts at `input` and changes at
    /// `rate`.
    #[inline]
    pub fn sampled(&mut self, h: f64, input: [f64; 2], rate: [f64; 2]) -> [[f64; 2]; 2] {
        if !self.is_on() {
            return NODES.map(|node| std::array::from_fn(|i| input[i] + rate[i] * node * h));
        }
        self.responses(h).nodes.map(|response| self.after(response, input, rate))
    }

    /// Advances the filters by `h` \[s\].
    #[inline(always)]
    pub fn step(&mut self, h: f64, input: [f64; 2], rate: [f64; 2]) {
        self.state = if self.is_on() {
            let end = self.responses(h).end;
            self.after(end, input, rate)
        } else {
            std::array::from_fn(|i| input[i] + rate[i] * h)
        };
    }

    #[inline(always)]
    fn after(&self, response: Response, input: [f64; 2], rate: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|i| {
            let y = self.state[i];
            y + (input[i] - y) * response.follow + rate[i] * response.ramp
        })
    }

    #[inline(always)]
    fn responses(&mut self, h: f64) -> Responses {
        match self.responses {
            Some(responses) if responses.h == h => responses,
            _ => *self.responses.insert(self.responses_to(h)),
        }
    }

    #[cold]
    #[inline(never)]
    fn responses_to(&self, h: f64) -> Responses {
        Responses { h, nodes: NODES.map(|node| self.response(node * h)), end: self.response(h) }
    }

    fn response(&self, t: f64) -> Response {
        let z = self.bandwidth * t;
        Response { follow: z * phi1(z), ramp: t * z * phi2(z) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn bandwidth_zero_passes_through() {
        let mut filter = LowPass::new(0.0);
        filter.step(0.1, [1.0, 2.0], [0.0; 2]);
        assert_eq!(filter.output([3.0, 4.0]), [3.0, 4.0]);
        let [first, second] = filter.sampled(1.0, [3.0, 4.0], [2.0, 0.0]);
        assert_eq!((first[0] + second[0], first[1], second[1]), (8.0, 4.0, 4.0));
    }

    #[test]
    fn step_response_is_the_exponential() {
        let mut filter = LowPass::new(200.0);
        for _ in 0..10 {
            filter.step(1e-3, [1.0; 2], [0.0; 2]);
        }
        let exact = 1.0 - (-2.0_f64).exp();
        assert!((filter.output([1.0; 2])[0] - exact).abs() < 1e-15);
    }

    proptest! {
        /// y = x₀ − r/ω + r t + c e^{−ωt}, the textbook solution; its own cancellation sets the bound.
        #[test]
        fn ramp_response_is_exact(
            bandwidth in 1.0..5e3, h in 1e-5..1e-2, y in -5.0..5.0, x in -5.0..5.0, rate in -50.0..50.0,
        ) {
            let mut filter = LowPass::new(bandwidth);
            filter.settle([y; 2]);
            let samples = filter.sampled(h, [x; 2], [rate; 2]);
            filter.step(h, [x; 2], [rate; 2]);
            let lag = rate / bandwidth;
            let exact = |t: f64| x - lag + rate * t + (y - x + lag) * (-bandwidth * t).exp();
            prop_assert!((filter.output([0.0; 2])[0] - exact(h)).abs() < 1e-13);
            for (sample, node) in samples.iter().zip(NODES) {
                prop_assert!((sample[0] - exact(node * h)).abs() < 1e-13);
            }
        }
    }
}

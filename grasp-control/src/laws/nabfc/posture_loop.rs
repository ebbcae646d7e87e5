//! Posture loop of one arm, eqs. (49)–(57).

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

mod continuous;

use super::estimator::{Drive, EstimateRates, Estimator, Laws};
use super::gains::{Gains, PostureGains, RbfLayout};
use crate::blocks::adaptation::LeakyLaw;
use crate::blocks::exponential::tanh;
use crate::blocks::four::{Four, Lanes};
use crate::blocks::rbf::Network;
use crate::blocks::sat::{sat, sat_slope};
use crate::signals::have_same_bits;
use serde::{Deserialize, Serialize};

/// What the user can set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct PostureSettings {
    pub gains: PostureGains,
    sat_limit: f64,
    /// Normalises Z = [e, s, α̇₂].
    pub inverse_scales: [f64; 3],
}

impl PostureSettings {
    fn new(gains: &Gains, arm: usize) -> Self {
        let RbfLayout { angle_scale, posture_surface_scale, posture_alpha_scale, .. } = gains.rbf;
        Self {
            gains: gains.posture[arm],
            sat_limit: gains.sat_limit,
            inverse_scales: [angle_scale, posture_surface_scale, posture_alpha_scale].map(f64::recip),
        }
    }

    /// The update laws (55)–(57): Û, π̂, Ĵ.
    fn laws(&self) -> Laws {
        let g = &self.gains;
        Laws {
            weights: LeakyLaw { gain: g.a3, leakage: g.a4 },
            bound: LeakyLaw { gain: g.zeta1, leakage: g.zeta2 },
            inertia: LeakyLaw { gain: g.g1, leakage: g.g2 },
            radius: g.u_max,
        }
    }
}

/// Controller of one hub.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct PostureLoop {
    pub(super) settings: PostureSettings,
    /// Ĵ, π̂, Û.
    pub estimator: Estimator<3>,
    #[serde(skip)]
    pub point: Option<Point>,
}

impl Clone for PostureLoop {
    /// Evaluated nowhere.
    fn clone(&self) -> Self {
        let Self { settings, estimator, point: _ } = self;
        Self { settings: *settings, estimator: estimator.clone(), point: None }
    }

    /// The same in the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        let Self { settings, estimator, point: _ } = source;
        (self.settings, self.point) = (*settings, None);
        self.estimator.clone_from(estimator);
    }
}

/// Signals of the loop at one instant. The moment M(0) is not among them: it enters the command only.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    pub e: f64,
    pub e_dot: f64,
    /// s = (μ + c₃) e + ė.
    pub s: f64,
    /// tanh(s/ϵ₂).
    pub tanh: f64,
    /// ė (μ + c₃), which Ĵ multiplies.
    regressor: f64,
    /// Whether it is of the inputs that the law has seen last.
    pub is_of_seen: bool,
}

impl Point {
    /// Forcings of (55)–(57): s Y(Z), s tanh(s/ϵ₂) and s ė (μ + c₃).
    #[inline(always)]
    pub fn drive(&self) -> Drive {
        Drive { s: self.s, bound: self.s * self.tanh, inertia: self.s * self.regressor }
    }
}

/// Partial derivatives of the hub torque, apart from ∂τ̄/∂M(0) = 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PosturePartials {
    pub e: f64,
    pub e_dot: f64,
}

impl PostureLoop {
    pub fn new(gains: &Gains, arm: usize) -> Self {
        let settings = PostureSettings::new(gains, arm);
        let network = Network::new(gains.rbf.posture(), gains.rbf.width_posture);
        Self { settings, estimator: Estimator::new(settings.laws(), gains.posture[arm].j_hat_0, network), point: None }
    }

    /// Other gains for the same estimates. The layout of the network must be the same.
    pub fn retune(&mut self, gains: &Gains, arm: usize) {
        self.settings = PostureSettings::new(gains, arm);
        self.estimator.retune(self.settings.laws());
        self.point = None;
    }

    /// Whether gains, scales and the network's layout are those of another loop.
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.settings == other.settings && self.estimator.has_settings_of(&other.estimator)
    }

    /// Gives back the memory that the usual step does without.
    pub fn leave(&mut self) {
        self.point = None;
        self.estimator.leave();
    }

    /// Back to the initial estimates.
    pub fn reset(&mut self) {
        self.estimator.reset();
    }

    /// Time derivatives of the estimates for these inputs, from (55)–(57).
    pub fn estimate_rates(&mut self, e: f64, e_dot: f64) -> EstimateRates {
        let drive = self.at(e, e_dot).drive();
        self.estimator.rates(&drive)
    }

    /// μ + c₃.
    pub fn slope(&self) -> f64 {
        self.settings.gains.mu + self.settings.gains.c3
    }

    /// s = μ z₃ + z₄ with z₄ = ė + c₃ e, eqs. (50)–(52).
    pub fn surface(&self, e: f64, e_dot: f64) -> f64 {
        self.slope() * e + e_dot
    }

    /// Evaluates the surface, the tanh, the regressor and the network's basis, once per point.
    fn at(&mut self, e: f64, e_dot: f64) -> Point {
        if let Some(point) = self.point
            && have_same_bits([point.e, point.e_dot], [e, e_dot])
        {
            return point;
        }
        let (mut point, [e_scaled, s_scaled, alpha_dot, _]) = self.signals(e, e_dot);
        point.tanh = tanh(point.s / self.epsilon());
        self.estimator.activate(&[[e_scaled, s_scaled, alpha_dot, 0.0], [0.0; 4]]);
        self.point = Some(point);
        point
    }

    /// ϵ₂.
    #[inline(always)]
    pub fn epsilon(&self) -> f64 {
        self.settings.gains.epsilon2
    }

    /// The signals at a point, without its tanh, and the normalised input of the network. The last lane does not count; for a zero there,
    /// the compiler may choose an instruction that valgrind 3.19 does not know, and hosts run under valgrind, too.
    #[inline(always)]
    pub fn signals(&self, e: f64, e_dot: f64) -> (Point, Lanes) {
        let PostureSettings { gains, inverse_scales: [angle, surface, alpha], .. } = &self.settings;
        let s = self.surface(e, e_dot);
        let point = Point { e, e_dot, s, tanh: 0.0, regressor: e_dot * self.slope(), is_of_seen: false };
        let alpha_dot = -gains.c3 * e_dot * alpha;
        (point, [e * angle, s * surface, alpha_dot, alpha_dot])
    }

    /// Hub torque τ̄, eq. (54).
    ///
    /// EI q''(0) − λᵈ l is the measured moment M(0): the target's own moment cancels.
    #[inline(always)]
    pub fn command_here<V: Four>(&self, point: &Point, root_moment: f64) -> f64 {
        let Point { e, s, tanh, regressor, .. } = *point;
        let PostureSettings { gains: g, sat_limit, .. } = &self.settings;
        -g.xi * sat(s, *sat_limit) - g.k * s - e - self.estimator.inertia * regressor + root_moment
            - self.estimator.output_here::<V>()
            - self.estimator.bound * tanh
    }

    /// Advances the estimates over a step with held signals, where the loop is evaluated, exactly.
    #[inline(always)]
    pub fn step_here<V: Four>(&mut self, h: f64) {
        if let Some(point) = &self.point {
            self.estimator.step_here::<V>(h, &point.drive());
        }
    }

    /// Advances the estimates over a step with the signals (e, ė) sampled at [`NODES`](crate::blocks::adaptation::NODES).
    pub fn step_sampled(&mut self, h: f64, samples: [(f64, f64); 2]) {
        for (node, (e, e_dot)) in samples.into_iter().enumerate() {
            let drive = self.at(e, e_dot).drive();
            self.estimator.step_sampled(h, node, &drive);
        }
    }

    /// Partial derivatives of the torque with respect to e and ė.
    pub fn partials(&mut self, e: f64, e_dot: f64) -> PosturePartials {
        let Point { s, tanh, .. } = self.at(e, e_dot);
        let PostureSettings { gains: g, sat_limit, inverse_scales } = self.settings;
        let gradient = self.estimator.gradient();
        let [by_angle, by_surface, by_alpha] = std::array::from_fn(|axis| gradient[axis] * inverse_scales[axis]);
        let by_s = -g.xi * sat_slope(s, sat_limit)
            - g.k
            - self.estimator.bound * (1.0 - tanh * tanh) / g.epsilon2
            - by_surface;
        PosturePartials {
            e: by_s * self.slope() - 1.0 - by_angle,
            e_dot: by_s - self.estimator.inertia * self.slope() + g.c3 * by_alpha,
        }
    }

    /// Time derivative of the torque through the estimates alone, eqs. (55)–(57) in (54).
    pub fn drift(&mut self, e: f64, e_dot: f64) -> f64 {
        let point = self.at(e, e_dot);
        let rates = self.estimator.rates(&point.drive());
        -rates.output - rates.bound * point.tanh - rates.inertia * point.regressor
    }
}

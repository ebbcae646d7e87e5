//! Object-position loop, eqs. (31)–(39).

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

mod continuous;

use super::estimator::{Drive, EstimateRates, Estimator, Laws};
use super::gains::{Gains, ObjectGains, RbfLayout};
use crate::blocks::adaptation::LeakyLaw;
use crate::blocks::exponential::{exp_of_all, tanh};
use crate::blocks::four::{Four, Lanes};
use crate::blocks::rbf::Network;
use crate::blocks::sat::{sat, sat_slope};
use serde::{Deserialize, Serialize};

/// What the loop sees at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ObjectInputs {
    /// z₁ = p \[m\].
    pub z1: f64,
    /// ż₁ = `ẏ_M` \[m/s\]: the target is static in the law.
    pub z1_dot: f64,
    /// Qᵢ = `EIᵢ` wᵢ'''(l) \[N\].
    pub shear: [f64; 2],
    /// Q̇ᵢ \[N/s\], filtered.
    pub shear_dot: [f64; 2],
    /// λ₁ᵈ \[N\]; λ₂ᵈ = −λ₁ᵈ.
    pub lambda1: f64,
}

/// What the user can set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct ObjectSettings {
    gains: ObjectGains,
    sat_limit: f64,
    /// 1/EIᵢ.
    compliance: [f64; 2],
    /// Normalises X = [z₁, s, α̇₁, w₁''', w₂''', ẇ₁''', ẇ₂'''].
    inverse_scales: [f64; 7],
}

impl ObjectSettings {
    fn new(gains: &Gains, ei: [f64; 2]) -> Self {
        let RbfLayout {
            position_scale, object_surface_scale, object_alpha_scale, shear_scale, shear_rate_scale, ..
        } = gains.rbf;
        Self {
            gains: gains.object,
            sat_limit: gains.sat_limit,
            compliance: ei.map(f64::recip),
            inverse_scales: [
                position_scale,
                object_surface_scale,
                object_alpha_scale,
                shear_scale,
                shear_scale,
                shear_rate_scale,
                shear_rate_scale,
            ]
            .map(f64::recip),
        }
    }

    /// The update laws (37)–(39): Ŵ, ε̂, m̂.
    fn laws(&self) -> Laws {
        let g = &self.gains;
        Laws {
            weights: LeakyLaw { gain: g.a1, leakage: g.a2 },
            bound: LeakyLaw { gain: g.gamma1, leakage: g.gamma2 },
            inertia: LeakyLaw { gain: g.b1, leakage: g.b2 },
            radius: g.w_max,
        }
    }
}

/// Controller of the object.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct ObjectLoop {
    settings: ObjectSettings,
    /// m̂, ε̂, Ŵ.
    pub estimator: Estimator<7>,
    #[serde(skip)]
    pub point: Option<Point>,
}

/// Signals of the loop at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    pub inputs: ObjectInputs,
    /// s = (μ̄ + c₁) z₁ + ż₁ + Σ qᵢ'''(l).
    s: f64,
    /// tanh(s/ϵ₁).
    pub tanh: f64,
    /// (μ̄ + c₁) ż₁ + Σ q̇ᵢ'''(l), which m̂ multiplies.
    regressor: f64,
    /// The normalised input of the network.
    pub x: [f64; 7],
    /// Whether it is of the inputs that the law has seen last.
    pub is_of_seen: bool,
}

impl Point {
    /// Forcings of (37)–(39): s Y(X), s tanh(s/ϵ₁) and s ((μ̄ + c₁) ż₁ + Σ q̇''').
    #[inline(always)]
    pub fn drive(&self) -> Drive {
        Drive { s: self.s, bound: self.s * self.tanh, inertia: self.s * self.regressor }
    }
}

/// Partial derivatives of the object force or of the sliding variable.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ObjectPartials {
    pub z1: f64,
    pub z1_dot: f64,
    pub shear: [f64; 2],
    pub shear_dot: [f64; 2],
    pub lambda1: f64,
}

impl ObjectLoop {
    pub fn new(gains: &Gains, ei: [f64; 2]) -> Self {
        let settings = ObjectSettings::new(gains, ei);
        let network = Network::new(gains.rbf.object(), gains.rbf.width_object);
        Self { settings, estimator: Estimator::new(settings.laws(), gains.object.m_hat_0, network), point: None }
    }

    /// Other gains for the same estimates. The layout of the network must be the same.
    pub fn retune(&mut self, gains: &Gains, ei: [f64; 2]) {
        self.settings = ObjectSettings::new(gains, ei);
        self.estimator.retune(self.settings.laws());
        self.point = None;
    }

    /// Whether gains, scales and the network's layout are those of another loop.
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.settings == other.settings && self.estimator.has_settings_of(&other.estimator)
    }

    /// Back to the initial estimates.
    pub fn reset(&mut self) {
        self.estimator.reset();
    }

    /// Time derivatives of the estimates for these inputs, from (37)–(39).
    pub fn estimate_rates(&mut self, inputs: &ObjectInputs) -> EstimateRates {
        let drive = self.at(inputs).drive();
        self.estimator.rates(&drive)
    }

    /// μ̄ + c₁.
    fn slope(&self) -> f64 {
        self.settings.gains.mu_bar + self.settings.gains.c1
    }

    /// s = μ̄ z₁ + z₂ with z₂ = ż₁ − α₁ and α₁ = −c₁ z₁ − Σ qᵢ'''(l), eqs. (32)–(34); qᵢ''' = (Qᵢ − λᵢᵈ)/EIᵢ.
    pub fn surface(&self, inputs: &ObjectInputs) -> f64 {
        let [c1, c2] = self.settings.compliance;
        let shear_error = (inputs.shear[0] - inputs.lambda1) * c1 + (inputs.shear[1] + inputs.lambda1) * c2;
        self.slope() * inputs.z1 + inputs.z1_dot + shear_error
    }

    /// Partial derivatives of s.
    pub fn surface_partials(&self) -> ObjectPartials {
        ObjectPartials {
            z1: self.slope(),
            z1_dot: 1.0,
            shear: self.settings.compliance,
            shear_dot: [0.0; 2],
            lambda1: self.settings.compliance[1] - self.settings.compliance[0],
        }
    }

    /// Evaluates the surface, the tanh, the regressor and the network's basis, once per point.
    fn at(&mut self, inputs: &ObjectInputs) -> Point {
        if let Some(point) = self.point
            && point.inputs == *inputs
        {
            return point;
        }
        // Where only the shear rates differ, the surface is the same.
        let mut point = self.signals(inputs);
        point.tanh = match self.point {
            Some(known) if known.s == point.s => known.tanh,
            _ => tanh(self.tanh_argument(&point)),
        };
        self.estimator.activate(point.x);
        self.point = Some(point);
        point
    }

    /// What tanh in [`Point`] is of.
    #[inline(always)]
    pub fn tanh_argument(&self, point: &Point) -> f64 {
        point.s / self.settings.gains.epsilon1
    }

    /// The signals at a point, without its tanh.
    #[inline(always)]
    pub fn signals(&self, inputs: &ObjectInputs) -> Point {
        let ObjectSettings { gains, compliance: [c1, c2], inverse_scales, .. } = &self.settings;
        let w_dot = [inputs.shear_dot[0] * c1, inputs.shear_dot[1] * c2];
        let shear_rate = w_dot[0] + w_dot[1];
        let s = self.surface(inputs);
        let alpha_dot = -gains.c1 * inputs.z1_dot - shear_rate;
        let x = [inputs.z1, s, alpha_dot, inputs.shear[0] * c1, inputs.shear[1] * c2, w_dot[0], w_dot[1]];
        Point {
            inputs: *inputs,
            s,
            tanh: 0.0,
            regressor: self.slope() * inputs.z1_dot + shear_rate,
            x: std::array::from_fn(|axis| x[axis] * inverse_scales[axis]),
            is_of_seen: false,
        }
    }

    /// What is else at a point with other shear rates: the regressor, and the network's inputs α̇₁, ẇ₁''' and ẇ₂''', with the same numbers as of
    /// [`signals`](Self::signals).
    #[inline(always)]
    fn moved(&self, z1_dot: f64, shear_dot: [f64; 2]) -> (f64, [f64; 3]) {
        let ObjectSettings { gains, compliance: [c1, c2], inverse_scales, .. } = &self.settings;
        let w_dot = [shear_dot[0] * c1, shear_dot[1] * c2];
        let shear_rate = w_dot[0] + w_dot[1];
        let alpha_dot = -gains.c1 * z1_dot - shear_rate;
        let [.., alpha, _, _, by1, by2] = inverse_scales;
        (self.slope() * z1_dot + shear_rate, [alpha_dot * alpha, w_dot[0] * by1, w_dot[1] * by2])
    }

    /// The second half of the exponentials that the network needs where only the shear rates are others than at a `point`.
    #[inline(always)]
    pub fn moved_exponentials<V: Four>(&self, point: &Point, shear_dot: [f64; 2]) -> Lanes {
        let (_, [alpha_dot, w1_dot, w2_dot]) = self.moved(point.inputs.z1_dot, shear_dot);
        let [z1, s, _, w1, w2, ..] = point.x;
        let x = [z1, s, alpha_dot, w1, w2, w1_dot, w2_dot];
        let [moved] = exp_of_all([self.estimator.network.moving_exponents::<V>(x)]);
        moved
    }

    /// Goes on from where the loop is evaluated to a point where only the shear rates are others.
    #[inline(always)]
    pub fn move_to<V: Four>(&mut self, shear_dot: [f64; 2], moving: Lanes) {
        let z1_dot = self.point.as_ref().map_or(0.0, |point| point.inputs.z1_dot);
        let (regressor, [alpha_dot, w1_dot, w2_dot]) = self.moved(z1_dot, shear_dot);
        let Some(point) = &mut self.point else { return };
        (point.inputs.shear_dot, point.regressor) = (shear_dot, regressor);
        (point.x[2], point.x[5], point.x[6]) = (alpha_dot, w1_dot, w2_dot);
        self.estimator.fill_moving::<V>(point.x, moving);
    }

    /// Advances the estimates over a step with held signals, where the loop is evaluated, exactly.
    #[inline(always)]
    pub fn step_here<V: Four>(&mut self, h: f64) {
        if let Some(point) = &self.point {
            self.estimator.step_here::<V>(h, &point.drive());
        }
    }

    /// Advances the estimates over a step whose shear rates are sampled at [`NODES`](crate::blocks::adaptation::NODES): the loop is
    /// evaluated at the first node, `moved` are the [`moved_exponentials`](Self::moved_exponentials) of the second.
    #[inline(always)]
    pub fn step_both_here<V: Four>(&mut self, h: f64, shear_dot: [f64; 2], moved: Lanes) {
        let Some(first) = self.point.as_ref().map(Point::drive) else { return };
        if self.estimator.has_ball() {
            self.estimator.step_sampled(h, 0, &first);
        }
        self.move_to::<V>(shear_dot, moved);
        let Some(second) = self.point.as_ref().map(Point::drive) else { return };
        if self.estimator.has_ball() {
            self.estimator.step_sampled(h, 1, &second);
        } else {
            self.estimator.step_both_here::<V>(h, &[first, second]);
        }
    }

    /// Force v on the object, eq. (36). Σ `EIᵢ` qᵢ''' is Q₁ + Q₂, because λ₁ᵈ + λ₂ᵈ = 0.
    #[inline(always)]
    pub fn command_here<V: Four>(&self, point: &Point) -> f64 {
        let Point { inputs, s, tanh, regressor, .. } = point;
        let ObjectSettings { gains: g, sat_limit, .. } = &self.settings;
        -g.eta * sat(*s, *sat_limit) - g.k * s - inputs.z1 + inputs.shear[0] + inputs.shear[1]
            - self.estimator.output_here::<V>()
            - self.estimator.bound * tanh
            - self.estimator.inertia * regressor
    }

    /// Advances the estimates over a step with the inputs sampled at [`NODES`](crate::blocks::adaptation::NODES).
    pub fn step_sampled(&mut self, h: f64, samples: &[ObjectInputs; 2]) {
        for (node, inputs) in samples.iter().enumerate() {
            let drive = self.at(inputs).drive();
            self.estimator.step_sampled(h, node, &drive);
        }
    }

    /// Partial derivatives of the force.
    pub fn partials(&mut self, inputs: &ObjectInputs) -> ObjectPartials {
        let Point { s, tanh, .. } = self.at(inputs);
        let ObjectSettings { gains: g, sat_limit, compliance, inverse_scales } = self.settings;
        let gradient = self.estimator.gradient();
        let [by_position, by_surface, by_alpha, by_w1, by_w2, by_w1_dot, by_w2_dot] =
            std::array::from_fn(|axis| gradient[axis] * inverse_scales[axis]);
        let by_s = -g.eta * sat_slope(s, sat_limit)
            - g.k
            - self.estimator.bound * (1.0 - tanh * tanh) / g.epsilon1
            - by_surface;
        let surface = self.surface_partials();
        let (by_w, by_w_dot) = ([by_w1, by_w2], [by_w1_dot, by_w2_dot]);
        ObjectPartials {
            z1: by_s * surface.z1 - 1.0 - by_position,
            z1_dot: by_s - self.estimator.inertia * self.slope() + g.c1 * by_alpha,
            shear: std::array::from_fn(|i| 1.0 + (by_s - by_w[i]) * compliance[i]),
            shear_dot: std::array::from_fn(|i| (by_alpha - self.estimator.inertia - by_w_dot[i]) * compliance[i]),
            lambda1: by_s * surface.lambda1,
        }
    }

    /// Time derivative of the force through the estimates alone, eqs. (37)–(39) in (36).
    pub fn drift(&mut self, inputs: &ObjectInputs) -> f64 {
        let point = self.at(inputs);
        let rates = self.estimator.rates(&point.drive());
        -rates.output - rates.bound * point.tanh - rates.inertia * point.regressor
    }
}

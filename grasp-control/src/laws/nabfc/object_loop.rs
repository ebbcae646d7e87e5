//! Object-position loop, eqs. (31)–(39).

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

mod continuous;

use super::estimator::{Drive, EstimateRates, Estimator, Laws};
use super::gains::{Gains, ObjectGains, RbfLayout};
use crate::blocks::adaptation::LeakyLaw;
use crate::blocks::exponential::{powers, tanh};
use crate::blocks::four::{Four, Lanes, Narrow};
use crate::blocks::rbf::Network;
use crate::blocks::sat::{sat, sat_slope};
use crate::signals::have_same_bits;
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

impl ObjectInputs {
    /// Whether they have the bits of others: the sign of a zero may be that of a command.
    fn has_bits_of(&self, other: &Self) -> bool {
        let numbers = |inputs: &Self| {
            let Self { z1, z1_dot, shear, shear_dot, lambda1 } = *inputs;
            [z1, z1_dot, shear[0], shear[1], shear_dot[0], shear_dot[1], lambda1]
        };
        have_same_bits(numbers(self), numbers(other))
    }
}

/// What the user can set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct ObjectSettings {
    pub gains: ObjectGains,
    pub sat_limit: f64,
    /// 1/EIᵢ.
    pub compliance: [f64; 2],
    /// Normalises X = [z₁, s, α̇₁, w₁''', w₂''', ẇ₁''', ẇ₂'''].
    pub inverse_scales: [f64; 7],
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

    /// What moves with unit ż₁, Q̇₁ and Q̇₂.
    pub fn moving(&self) -> Moving {
        let [c1, c2] = self.compliance;
        let [.., alpha, _, _, by1, by2] = self.inverse_scales;
        [
            [-self.gains.c1 * alpha, 0.0, 0.0, self.gains.mu_bar + self.gains.c1],
            [-c1 * alpha, c1 * by1, 0.0, c1],
            [-c2 * alpha, 0.0, c2 * by2, c2],
        ]
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
// What is unsafe asks for a feature of the processor, and nothing of the data.
#[allow(clippy::unsafe_derive_deserialize)]
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct ObjectLoop {
    pub(super) settings: ObjectSettings,
    /// m̂, ε̂, Ŵ.
    pub estimator: Estimator<7>,
    #[serde(skip)]
    pub point: Option<Point>,
    /// See [`ObjectSettings::moving`]; a restored law has none until it is evaluated.
    #[serde(skip)]
    moving: Option<Moving>,
}

impl Clone for ObjectLoop {
    /// Evaluated nowhere.
    fn clone(&self) -> Self {
        let Self { settings, estimator, point: _, moving } = self;
        Self { settings: *settings, estimator: estimator.clone(), point: None, moving: *moving }
    }

    /// The same in the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        let Self { settings, estimator, point: _, moving } = source;
        (self.settings, self.point, self.moving) = (*settings, None, *moving);
        self.estimator.clone_from(estimator);
    }
}

/// What ż₁, Q̇₁ and Q̇₂ move: the network's inputs α̇₁, ẇ₁''' and ẇ₂''', normalised, and in the last lane the regressor. Linear, each
/// by one of these.
pub(super) type Moving = [Lanes; 3];

/// Signals of the loop at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    pub inputs: ObjectInputs,
    /// s = (μ̄ + c₁) z₁ + ż₁ + Σ qᵢ'''(l).
    pub s: f64,
    /// tanh(s/ϵ₁).
    pub tanh: f64,
    /// (μ̄ + c₁) ż₁ + Σ q̇ᵢ'''(l), which m̂ multiplies.
    regressor: f64,
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
        let estimator = Estimator::new(settings.laws(), gains.object.m_hat_0, network);
        Self { settings, estimator, point: None, moving: None }
    }

    /// Other gains for the same estimates. The layout of the network must be the same.
    pub fn retune(&mut self, gains: &Gains, ei: [f64; 2]) {
        self.settings = ObjectSettings::new(gains, ei);
        self.estimator.retune(self.settings.laws());
        (self.moving, self.point) = (None, None);
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
            && point.inputs.has_bits_of(inputs)
        {
            return point;
        }
        // Where only the shear rates differ, the surface is the same.
        let (mut point, still) = self.signals(inputs);
        point.tanh = match self.point {
            Some(known) if have_same_bits([known.s], [point.s]) => known.tanh,
            _ => tanh(point.s / self.epsilon()),
        };
        self.prepare();
        let moved = self.moved::<Narrow>(inputs.z1_dot, inputs.shear_dot);
        point.regressor = moved.last();
        self.estimator.activate(&[still, moved.with_last(0.0).lanes()]);
        self.point = Some(point);
        point
    }

    /// ϵ₁.
    #[inline(always)]
    pub fn epsilon(&self) -> f64 {
        self.settings.gains.epsilon1
    }

    /// The signals at a point, without its tanh and its regressor, and the network's inputs z₁, s, w₁''' and w₂''', normalised.
    #[inline(always)]
    pub fn signals(&self, inputs: &ObjectInputs) -> (Point, Lanes) {
        let ObjectSettings { compliance: [c1, c2], inverse_scales: [position, surface, _, by1, by2, ..], .. } =
            &self.settings;
        let s = self.surface(inputs);
        let still = [inputs.z1 * position, s * surface, inputs.shear[0] * c1 * by1, inputs.shear[1] * c2 * by2];
        (Point { inputs: *inputs, s, tanh: 0.0, regressor: 0.0, is_of_seen: false }, still)
    }

    /// Makes [`moved`](Self::moved) ready.
    #[inline(always)]
    pub fn prepare(&mut self) {
        if self.moving.is_none() {
            self.moving = Some(self.settings.moving());
        }
    }

    /// What the shear rates move: the network's inputs α̇₁, ẇ₁''' and ẇ₂''', normalised, and in the last lane the regressor.
    #[inline(always)]
    fn moved<V: Four>(&self, z1_dot: f64, shear_dot: [f64; 2]) -> V {
        let Some([by_velocity, by_rate1, by_rate2]) = &self.moving else { return V::splat(0.0) };
        let of_rates = V::splat(shear_dot[0]) * V::load(by_rate1) + V::splat(shear_dot[1]) * V::load(by_rate2);
        V::splat(z1_dot) * V::load(by_velocity) + of_rates
    }

    /// Goes to a point where only the shear rates are others than where the loop is evaluated. Not inlined: it is called in several places,
    /// and the usual step does without.
    #[inline(never)]
    pub fn move_to<V: Four>(&mut self, shear_dot: [f64; 2]) {
        let Some(point) = &self.point else { return };
        let x = self.moved::<V>(point.inputs.z1_dot, shear_dot);
        let network = &mut self.estimator.network;
        if network.is_plain() {
            let [of_x] = powers([network.last_exponents(x)]);
            network.fill_plain_last(x, of_x);
        } else {
            network.go_on(x.lanes());
        }
        self.arrive(shear_dot, x.last());
    }

    /// The loop is evaluated there.
    #[inline(always)]
    fn arrive(&mut self, shear_dot: [f64; 2], regressor: f64) {
        if let Some(point) = &mut self.point {
            (point.inputs.shear_dot, point.regressor) = (shear_dot, regressor);
        }
    }

    /// Advances the estimates over a step with held signals, where the loop is evaluated, exactly.
    #[inline(always)]
    pub fn step_here<V: Four>(&mut self, h: f64) {
        if let Some(point) = &self.point {
            self.estimator.step_here::<V>(h, &point.drive());
        }
    }

    /// Advances the estimates over a step whose shear rates are sampled at [`NODES`](crate::blocks::adaptation::NODES), from where the
    /// loop is evaluated for the same inputs but for these.
    #[inline(always)]
    pub fn step_both_here<V: Four>(&mut self, h: f64, shear_dot: [[f64; 2]; 2]) {
        let Some(point) = &self.point else { return };
        if self.estimator.has_ball() || !self.estimator.network.is_plain() {
            self.step_one_by_one(h, shear_dot);
            return;
        }
        let (z1_dot, mut drive) = (point.inputs.z1_dot, point.drive());
        let s = drive.s;
        let [first, second] = [self.moved::<V>(z1_dot, shear_dot[0]), self.moved::<V>(z1_dot, shear_dot[1])];
        let network = &mut self.estimator.network;
        let of_both = powers([network.last_exponents(first), network.last_exponents(second)]);
        network.fill_plain_both(second, of_both);
        drive.inertia = s * first.last();
        self.estimator.step_both_here::<V>(h, &[drive, Drive { inertia: s * second.last(), ..drive }]);
        self.arrive(shear_dot[1], second.last());
    }

    /// The same one after the other, for networks that are not plain and where a ball holds the weights, which are put back on it in
    /// between.
    #[inline(never)]
    fn step_one_by_one(&mut self, h: f64, shear_dot: [[f64; 2]; 2]) {
        for (node, shear_dot) in shear_dot.into_iter().enumerate() {
            self.move_to::<Narrow>(shear_dot);
            if let Some(drive) = self.point.as_ref().map(Point::drive) {
                self.estimator.step_sampled(h, node, &drive);
            }
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

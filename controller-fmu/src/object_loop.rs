//! Object-position loop, eqs. (31)–(39).

use crate::adaptation::{LeakyLaw, Steps};
use crate::exponential::tanh;
use crate::gains::{Gains, ObjectGains, RbfLayout};
use crate::rbf::Network;
use crate::sat::{sat, sat_slope};
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

/// Controller of the object: its gains, its estimates m̂, ε̂, Ŵ.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct ObjectLoop {
    gains: ObjectGains,
    sat_limit: f64,
    /// 1/EIᵢ.
    compliance: [f64; 2],
    /// m̂ \[kg\].
    pub m_hat: f64,
    /// ε̂ \[N\].
    pub epsilon_hat: f64,
    /// Ŵᵀ Y(X).
    pub network: Network<7>,
    /// Normalises X = [z₁, s, α̇₁, w₁''', w₂''', ẇ₁''', ẇ₂'''].
    inverse_scales: [f64; 7],
    /// Whether the network does anything: with zero weights and no adaptation it need not be evaluated.
    has_network: bool,
    #[serde(skip)]
    point: Option<Point>,
    #[serde(skip)]
    steps: Option<Steps>,
}

/// Signals of the loop at one instant.
#[derive(Debug, Clone, Copy)]
struct Point {
    inputs: ObjectInputs,
    /// s = (μ̄ + c₁) z₁ + ż₁ + Σ qᵢ'''(l).
    s: f64,
    /// tanh(s/ϵ₁).
    tanh: f64,
    /// (μ̄ + c₁) ż₁ + Σ q̇ᵢ'''(l), which m̂ multiplies.
    regressor: f64,
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
        let RbfLayout {
            position_scale, object_surface_scale, object_alpha_scale, shear_scale, shear_rate_scale, ..
        } = gains.rbf;
        Self {
            gains: gains.object,
            sat_limit: gains.sat_limit,
            compliance: ei.map(f64::recip),
            m_hat: gains.object.m_hat_0,
            epsilon_hat: 0.0,
            network: Network::new(gains.rbf.object(), gains.rbf.width_object),
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
            has_network: gains.object.a1 > 0.0,
            point: None,
            steps: None,
        }
    }

    /// Other gains for the same estimates. The layout of the network must be the same.
    pub fn retune(&mut self, gains: &Gains, ei: [f64; 2]) {
        let new = Self::new(gains, ei);
        *self = Self {
            m_hat: self.m_hat,
            epsilon_hat: self.epsilon_hat,
            network: self.network.clone(),
            // What has been learnt stays, even if nothing more is learnt.
            has_network: self.has_network || new.has_network,
            ..new
        };
    }

    /// Time derivatives of m̂, ε̂ and ‖Ŵ‖ for these inputs, from (37)–(39).
    pub fn estimate_rates(&mut self, inputs: &ObjectInputs) -> [f64; 3] {
        let point = self.at(inputs);
        let [epsilon, m] = Self::forcings(&point);
        let [weights, epsilon_law, m_law] = self.laws();
        let norm = if self.has_network { self.network.norm_rate(&weights, point.s) } else { 0.0 };
        [m_law.rate(self.m_hat, m), epsilon_law.rate(self.epsilon_hat, epsilon), norm]
    }

    /// Whether gains, scales and the network's layout are those of another loop.
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.gains == other.gains
            && self.sat_limit == other.sat_limit
            && self.compliance == other.compliance
            && self.inverse_scales == other.inverse_scales
            && self.network.has_layout_of(&other.network)
    }

    /// Back to the initial estimates.
    pub fn reset(&mut self) {
        self.m_hat = self.gains.m_hat_0;
        self.epsilon_hat = 0.0;
        self.network.reset();
    }

    /// μ̄ + c₁.
    fn slope(&self) -> f64 {
        self.gains.mu_bar + self.gains.c1
    }

    /// s = μ̄ z₁ + z₂ with z₂ = ż₁ − α₁ and α₁ = −c₁ z₁ − Σ qᵢ'''(l), eqs. (32)–(34); qᵢ''' = (Qᵢ − λᵢᵈ)/EIᵢ.
    pub fn surface(&self, inputs: &ObjectInputs) -> f64 {
        let [c1, c2] = self.compliance;
        let shear_error = (inputs.shear[0] - inputs.lambda1) * c1 + (inputs.shear[1] + inputs.lambda1) * c2;
        self.slope() * inputs.z1 + inputs.z1_dot + shear_error
    }

    /// Partial derivatives of s.
    pub fn surface_partials(&self) -> ObjectPartials {
        ObjectPartials {
            z1: self.slope(),
            z1_dot: 1.0,
            shear: self.compliance,
            shear_dot: [0.0; 2],
            lambda1: self.compliance[1] - self.compliance[0],
        }
    }

    /// Evaluates the surface, the tanh, the regressor and the network's basis, once per point.
    fn at(&mut self, inputs: &ObjectInputs) -> Point {
        if let Some(point) = self.point
            && point.inputs == *inputs
        {
            return point;
        }
        let [c1, c2] = self.compliance;
        let w_dot = [inputs.shear_dot[0] * c1, inputs.shear_dot[1] * c2];
        let shear_rate = w_dot[0] + w_dot[1];
        let s = self.surface(inputs);
        // Where only the shear rates differ, the surface is the same.
        let tanh = match self.point {
            Some(point) if point.s == s => point.tanh,
            _ => tanh(s / self.gains.epsilon1),
        };
        let point = Point { inputs: *inputs, s, tanh, regressor: self.slope() * inputs.z1_dot + shear_rate };
        if self.has_network {
            let alpha_dot = -self.gains.c1 * inputs.z1_dot - shear_rate;
            let x = [inputs.z1, s, alpha_dot, inputs.shear[0] * c1, inputs.shear[1] * c2, w_dot[0], w_dot[1]];
            self.network.activate(std::array::from_fn(|axis| x[axis] * self.inverse_scales[axis]));
        }
        self.point = Some(point);
        point
    }

    /// Force v on the object, eq. (36). Σ `EIᵢ` qᵢ''' is Q₁ + Q₂, because λ₁ᵈ + λ₂ᵈ = 0.
    pub fn command(&mut self, inputs: &ObjectInputs) -> f64 {
        let Point { s, tanh, regressor, .. } = self.at(inputs);
        let g = &self.gains;
        let network = if self.has_network { self.network.output() } else { 0.0 };
        -g.eta * sat(s, self.sat_limit) - g.k * s - inputs.z1 + inputs.shear[0] + inputs.shear[1]
            - network
            - self.epsilon_hat * tanh
            - self.m_hat * regressor
    }

    /// The three update laws (37)–(39): Ŵ, ε̂, m̂.
    fn laws(&self) -> [LeakyLaw; 3] {
        let g = &self.gains;
        [(g.a1, g.a2), (g.gamma1, g.gamma2), (g.b1, g.b2)].map(|(gain, leakage)| LeakyLaw { gain, leakage })
    }

    /// The laws' steps over `h`.
    fn steps(&mut self, h: f64) -> Steps {
        let laws = self.laws();
        Steps::of_size(&mut self.steps, h, laws)
    }

    /// Forcings of (38) and (39): s tanh(s/ϵ₁) and s ((μ̄ + c₁) ż₁ + Σ q̇'''). That of (37) is s Y(X).
    fn forcings(point: &Point) -> [f64; 2] {
        [point.s * point.tanh, point.s * point.regressor]
    }

    /// Advances the estimates over a step with held signals, exactly.
    pub fn step(&mut self, h: f64, inputs: &ObjectInputs) {
        let [weights, epsilon_hat, m_hat] = self.steps(h).held;
        let point = self.at(inputs);
        let [epsilon, m] = Self::forcings(&point);
        self.epsilon_hat = epsilon_hat.apply(self.epsilon_hat, epsilon);
        self.m_hat = m_hat.apply(self.m_hat, m);
        if self.has_network {
            self.network.adapt(weights.decay, weights.weight * point.s);
        }
    }

    /// Advances the estimates over a step with the inputs sampled at [`NODES`](crate::adaptation::NODES).
    pub fn step_sampled(&mut self, h: f64, samples: &[ObjectInputs; 2]) {
        let [weights, epsilon_hat, m_hat] = self.steps(h).sampled;
        let mut epsilon = [0.0; 2];
        let mut m = [0.0; 2];
        for (node, inputs) in samples.iter().enumerate() {
            let point = self.at(inputs);
            [epsilon[node], m[node]] = Self::forcings(&point);
            if self.has_network {
                let decay = if node == 0 { weights.decay } else { 1.0 };
                self.network.adapt(decay, weights.weights[node] * point.s);
            }
        }
        self.epsilon_hat = epsilon_hat.apply(self.epsilon_hat, epsilon);
        self.m_hat = m_hat.apply(self.m_hat, m);
    }

    /// Partial derivatives of the force.
    pub fn partials(&mut self, inputs: &ObjectInputs) -> ObjectPartials {
        let Point { s, tanh, .. } = self.at(inputs);
        let g = &self.gains;
        let [by_position, by_surface, by_alpha, by_w1, by_w2, by_w1_dot, by_w2_dot] = if self.has_network {
            let gradient = self.network.gradient();
            std::array::from_fn(|axis| gradient[axis] * self.inverse_scales[axis])
        } else {
            [0.0; 7]
        };
        let by_s = -g.eta * sat_slope(s, self.sat_limit)
            - g.k
            - self.epsilon_hat * (1.0 - tanh * tanh) / g.epsilon1
            - by_surface;
        let surface = self.surface_partials();
        let (by_w, by_w_dot) = ([by_w1, by_w2], [by_w1_dot, by_w2_dot]);
        ObjectPartials {
            z1: by_s * surface.z1 - 1.0 - by_position,
            z1_dot: by_s - self.m_hat * self.slope() + g.c1 * by_alpha,
            shear: std::array::from_fn(|i| 1.0 + (by_s - by_w[i]) * self.compliance[i]),
            shear_dot: std::array::from_fn(|i| (by_alpha - self.m_hat - by_w_dot[i]) * self.compliance[i]),
            lambda1: by_s * surface.lambda1,
        }
    }

    /// Time derivative of the force through the estimates alone, eqs. (37)–(39) in (36).
    pub fn drift(&mut self, inputs: &ObjectInputs) -> f64 {
        let point = self.at(inputs);
        let [epsilon, m] = Self::forcings(&point);
        let [weights, epsilon_law, m_law] = self.laws();
        let network = if self.has_network {
            weights.rate(self.network.output(), point.s * self.network.learning_gain())
        } else {
            0.0
        };
        -network
            - epsilon_law.rate(self.epsilon_hat, epsilon) * point.tanh
            - m_law.rate(self.m_hat, m) * point.regressor
    }
}

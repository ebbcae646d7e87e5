//! Posture loop of one arm, eqs. (49)–(57).

use crate::adaptation::{LeakyLaw, Steps};
use crate::exponential::tanh;
use crate::gains::{Gains, PostureGains, RbfLayout};
use crate::rbf::Network;
use crate::sat::{sat, sat_slope};
use serde::{Deserialize, Serialize};

/// Controller of one hub: its gains, its estimates Ĵ, π̂, Û.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PostureLoop {
    gains: PostureGains,
    sat_limit: f64,
    /// Ĵ \[kg·m²\].
    pub j_hat: f64,
    /// π̂ \[N·m\].
    pub pi_hat: f64,
    /// Ûᵀ Y(Z).
    pub network: Network<3>,
    /// Normalises Z = [e, s, α̇₂].
    inverse_scales: [f64; 3],
    /// Whether the network does anything: with zero weights and no adaptation it need not be evaluated.
    has_network: bool,
    #[serde(skip)]
    point: Option<Point>,
    #[serde(skip)]
    steps: Option<Steps>,
}

/// Signals of the loop at one instant. The moment M(0) is not among them: it enters the command only.
#[derive(Debug, Clone, Copy)]
struct Point {
    e: f64,
    e_dot: f64,
    /// s = (μ + c₃) e + ė.
    s: f64,
    /// tanh(s/ϵ₂).
    tanh: f64,
}

/// Partial derivatives of the hub torque, apart from ∂τ̄/∂M(0) = 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PosturePartials {
    pub e: f64,
    pub e_dot: f64,
}

impl PostureLoop {
    pub fn new(gains: &Gains, arm: usize) -> Self {
        let RbfLayout { angle_scale, posture_surface_scale, posture_alpha_scale, .. } = gains.rbf;
        Self {
            gains: gains.posture[arm],
            sat_limit: gains.sat_limit,
            j_hat: gains.posture[arm].j_hat_0,
            pi_hat: 0.0,
            network: Network::new(gains.rbf.posture(), gains.rbf.width_posture),
            inverse_scales: [angle_scale, posture_surface_scale, posture_alpha_scale].map(f64::recip),
            has_network: gains.posture[arm].a3 > 0.0,
            point: None,
            steps: None,
        }
    }

    /// Other gains for the same estimates. The layout of the network must be the same.
    pub fn retune(&mut self, gains: &Gains, arm: usize) {
        let new = Self::new(gains, arm);
        *self = Self {
            j_hat: self.j_hat,
            pi_hat: self.pi_hat,
            network: self.network.clone(),
            // What has been learnt stays, even if nothing more is learnt.
            has_network: self.has_network || new.has_network,
            ..new
        };
    }

    /// Time derivatives of Ĵ, π̂ and ‖Û‖ for these inputs, from (55)–(57).
    pub fn estimate_rates(&mut self, e: f64, e_dot: f64) -> [f64; 3] {
        let point = self.at(e, e_dot);
        let [pi, j] = self.forcings(&point);
        let [weights, pi_law, j_law] = self.laws();
        let norm = if self.has_network { self.network.norm_rate(&weights, point.s) } else { 0.0 };
        [j_law.rate(self.j_hat, j), pi_law.rate(self.pi_hat, pi), norm]
    }

    /// Whether gains, scales and the network's layout are those of another loop.
    pub fn has_settings_of(&self, other: &Self) -> bool {
        self.gains == other.gains
            && self.sat_limit == other.sat_limit
            && self.inverse_scales == other.inverse_scales
            && self.network.has_layout_of(&other.network)
    }

    /// Back to the initial estimates.
    pub fn reset(&mut self) {
        self.j_hat = self.gains.j_hat_0;
        self.pi_hat = 0.0;
        self.network.reset();
    }

    /// μ + c₃.
    pub fn slope(&self) -> f64 {
        self.gains.mu + self.gains.c3
    }

    /// s = μ z₃ + z₄ with z₄ = ė + c₃ e, eqs. (50)–(52).
    pub fn surface(&self, e: f64, e_dot: f64) -> f64 {
        self.slope() * e + e_dot
    }

    /// Evaluates the surface, the tanh and the network's basis, once per point.
    fn at(&mut self, e: f64, e_dot: f64) -> Point {
        if let Some(point) = self.point
            && point.e == e
            && point.e_dot == e_dot
        {
            return point;
        }
        let s = self.surface(e, e_dot);
        let point = Point { e, e_dot, s, tanh: tanh(s / self.gains.epsilon2) };
        if self.has_network {
            let [angle, surface, alpha] = self.inverse_scales;
            self.network.activate([e * angle, s * surface, -self.gains.c3 * e_dot * alpha]);
        }
        self.point = Some(point);
        point
    }

    /// Hub torque τ̄, eq. (54).
    ///
    /// EI q''(0) − λᵈ l is the measured moment M(0): the target's own moment cancels.
    pub fn command(&mut self, e: f64, e_dot: f64, root_moment: f64) -> f64 {
        let Point { s, tanh, .. } = self.at(e, e_dot);
        let g = &self.gains;
        let network = if self.has_network { self.network.output() } else { 0.0 };
        -g.xi * sat(s, self.sat_limit) - g.k * s - e - self.j_hat * e_dot * self.slope() + root_moment
            - network
            - self.pi_hat * tanh
    }

    /// The three update laws (55)–(57): Û, π̂, Ĵ.
    fn laws(&self) -> [LeakyLaw; 3] {
        let g = &self.gains;
        [(g.a3, g.a4), (g.zeta1, g.zeta2), (g.g1, g.g2)].map(|(gain, leakage)| LeakyLaw { gain, leakage })
    }

    /// The laws' steps over `h`.
    fn steps(&mut self, h: f64) -> Steps {
        let laws = self.laws();
        Steps::of_size(&mut self.steps, h, laws)
    }

    /// Forcings of (56) and (57): s tanh(s/ϵ₂) and s ė (μ + c₃). That of (55) is s Y(Z).
    fn forcings(&self, point: &Point) -> [f64; 2] {
        let Point { e_dot, s, tanh, .. } = *point;
        [s * tanh, s * e_dot * self.slope()]
    }

    /// Advances the estimates over a step with held signals, exactly.
    pub fn step(&mut self, h: f64, e: f64, e_dot: f64) {
        let [weights, pi_hat, j_hat] = self.steps(h).held;
        let point = self.at(e, e_dot);
        let [pi, j] = self.forcings(&point);
        self.pi_hat = pi_hat.apply(self.pi_hat, pi);
        self.j_hat = j_hat.apply(self.j_hat, j);
        if self.has_network {
            self.network.adapt(weights.decay, weights.weight * point.s);
        }
    }

    /// Advances the estimates over a step with the signals (e, ė) sampled at [`NODES`](crate::adaptation::NODES).
    pub fn step_sampled(&mut self, h: f64, samples: [(f64, f64); 2]) {
        let [weights, pi_hat, j_hat] = self.steps(h).sampled;
        let mut pi = [0.0; 2];
        let mut j = [0.0; 2];
        for (node, (e, e_dot)) in samples.into_iter().enumerate() {
            let point = self.at(e, e_dot);
            [pi[node], j[node]] = self.forcings(&point);
            if self.has_network {
                let decay = if node == 0 { weights.decay } else { 1.0 };
                self.network.adapt(decay, weights.weights[node] * point.s);
            }
        }
        self.pi_hat = pi_hat.apply(self.pi_hat, pi);
        self.j_hat = j_hat.apply(self.j_hat, j);
    }

    /// Partial derivatives of the torque with respect to e and ė.
    pub fn partials(&mut self, e: f64, e_dot: f64) -> PosturePartials {
        let Point { s, tanh, .. } = self.at(e, e_dot);
        let g = &self.gains;
        let [by_angle, by_surface, by_alpha] = if self.has_network {
            let gradient = self.network.gradient();
            std::array::from_fn(|axis| gradient[axis] * self.inverse_scales[axis])
        } else {
            [0.0; 3]
        };
        let by_s =
            -g.xi * sat_slope(s, self.sat_limit) - g.k - self.pi_hat * (1.0 - tanh * tanh) / g.epsilon2 - by_surface;
        PosturePartials {
            e: by_s * self.slope() - 1.0 - by_angle,
            e_dot: by_s - self.j_hat * self.slope() + g.c3 * by_alpha,
        }
    }

    /// Time derivative of the torque through the estimates alone, eqs. (55)–(57) in (54).
    pub fn drift(&mut self, e: f64, e_dot: f64) -> f64 {
        let point = self.at(e, e_dot);
        let [pi, j] = self.forcings(&point);
        let [weights, pi_law, j_law] = self.laws();
        let network = if self.has_network {
            weights.rate(self.network.output(), point.s * self.network.learning_gain())
        } else {
            0.0
        };
        -network - pi_law.rate(self.pi_hat, pi) * point.tanh - j_law.rate(self.j_hat, j) * e_dot * self.slope()
    }
}

//! The NABFC law written down once more, straight from the paper and as naively as possible, and random inputs.

#![allow(dead_code, missing_docs, clippy::large_types_passed_by_value)]

use grasp_control::Arms;
use grasp_control::laws::nabfc::Gains;
use grasp_control::{INPUTS, Inputs};
use proptest::prelude::*;

/// Eqs. (36)–(39) and (54)–(57), with the shear rates as measured (no low-pass).
pub struct Paper {
    pub arms: Arms,
    pub gains: Gains,
    pub m_hat: f64,
    pub epsilon_hat: f64,
    pub w: Vec<f64>,
    pub j_hat: [f64; 2],
    pub pi_hat: [f64; 2],
    pub u: [Vec<f64>; 2],
}

/// Signals of the paper.
#[derive(Debug)]
pub struct Signals {
    pub lambda_d: [f64; 2],
    pub e: [f64; 2],
    pub e_dot: [f64; 2],
    pub z1: f64,
    pub z1_dot: f64,
    pub q3: [f64; 2],
    pub q3_dot: [f64; 2],
    pub q2_0: [f64; 2],
    pub s: f64,
    pub s_i: [f64; 2],
    pub x: [f64; 7],
    pub z: [[f64; 3]; 2],
}

pub fn gaussians(x: &[f64], centres: &[Vec<f64>], width: f64) -> Vec<f64> {
    centres
        .iter()
        .map(|centre| {
            let distance2: f64 = x.iter().zip(centre).map(|(x, c)| (x - c).powi(2)).sum();
            (-distance2 / width.powi(2)).exp()
        })
        .collect()
}

/// Equally spaced on [−1, 1]; a single one sits at 0.
fn axis(nodes: u32) -> Vec<f64> {
    match nodes {
        1 => vec![0.0],
        _ => (0..nodes).map(|j| -1.0 + 2.0 * f64::from(j) / f64::from(nodes - 1)).collect(),
    }
}

pub fn grid_centres(nodes: u32) -> Vec<Vec<f64>> {
    let mut centres = Vec::new();
    for &a in &axis(nodes) {
        for &b in &axis(nodes) {
            for &c in &axis(nodes) {
                centres.push(vec![a, b, c]);
            }
        }
    }
    centres
}

pub fn star_centres(rings: u32) -> Vec<Vec<f64>> {
    let mut centres = vec![vec![0.0; 7]];
    for dimension in 0..7 {
        for c in axis(2 * rings + 1) {
            if c != 0.0 {
                let mut centre = vec![0.0; 7];
                centre[dimension] = c;
                centres.push(centre);
            }
        }
    }
    centres
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Paper {
    pub fn new(arms: Arms, gains: Gains) -> Self {
        let nodes = |centres: Vec<Vec<f64>>| vec![0.0; centres.len()];
        let u = nodes(grid_centres(gains.rbf.nodes_posture));
        Self {
            arms,
            gains,
            m_hat: gains.object.m_hat_0,
            epsilon_hat: 0.0,
            w: nodes(star_centres(gains.rbf.rings_object)),
            j_hat: gains.posture.map(|g| g.j_hat_0),
            pi_hat: [0.0; 2],
            u: [u.clone(), u],
        }
    }

    pub fn signals(&self, inputs: &Inputs) -> Signals {
        let (l, ei) = (self.arms.length, self.arms.ei);
        let m = inputs.measured;
        let lambda1_d = inputs.reference.lambda1_ref;
        let theta1_d = inputs.reference.theta1_ref;
        // (16), with L/2
        let lambda_d = [lambda1_d, -lambda1_d];
        let theta2_d = theta1_d + lambda1_d * l * l / 3.0 * ((ei[0] + ei[1]) / (ei[0] * ei[1]));
        let y_d = l * theta1_d + l.powi(3) * lambda1_d / (3.0 * ei[0]) + self.arms.hub_distance / 2.0;
        let e = [m.theta[0] - theta1_d, m.theta[1] - theta2_d];
        let e_dot = m.theta_dot;
        let (z1, z1_dot) = (m.y_object - y_d, m.y_object_dot);
        // q = w − w^d, w^d''' = λ^d/EI, w^d''(0) = −λ^d l/EI
        let w3 = [m.tip_shear[0] / ei[0], m.tip_shear[1] / ei[1]];
        let w3_dot = [m.tip_shear_dot[0] / ei[0], m.tip_shear_dot[1] / ei[1]];
        let q3 = [w3[0] - lambda_d[0] / ei[0], w3[1] - lambda_d[1] / ei[1]];
        let w2_0 = [m.root_moment[0] / ei[0], m.root_moment[1] / ei[1]];
        let q2_0 = [w2_0[0] + lambda_d[0] * l / ei[0], w2_0[1] + lambda_d[1] * l / ei[1]];
        let o = &self.gains.object;
        // (32)–(34)
        let alpha1 = -o.c1 * z1 - (q3[0] + q3[1]);
        let alpha1_dot = -o.c1 * z1_dot - (w3_dot[0] + w3_dot[1]);
        let z2 = z1_dot - alpha1;
        let s = o.mu_bar * z1 + z2;
        // (50)–(52)
        let s_i = [0, 1].map(|i| {
            let g = &self.gains.posture[i];
            let alpha2 = -g.c3 * e[i];
            g.mu * e[i] + (e_dot[i] - alpha2)
        });
        let r = &self.gains.rbf;
        let x = [
            z1 / r.position_scale,
            s / r.object_surface_scale,
            alpha1_dot / r.object_alpha_scale,
            w3[0] / r.shear_scale,
            w3[1] / r.shear_scale,
            w3_dot[0] / r.shear_rate_scale,
            w3_dot[1] / r.shear_rate_scale,
        ];
        let z = [0, 1].map(|i| {
            [
                e[i] / r.angle_scale,
                s_i[i] / r.posture_surface_scale,
                -self.gains.posture[i].c3 * e_dot[i] / r.posture_alpha_scale,
            ]
        });
        Signals { lambda_d, e, e_dot, z1, z1_dot, q3, q3_dot: w3_dot, q2_0, s, s_i, x, z }
    }

    pub fn y_object(&self, signals: &Signals) -> Vec<f64> {
        let rbf = &self.gains.rbf;
        gaussians(&signals.x, &star_centres(rbf.rings_object), rbf.width_object)
    }

    pub fn y_posture(&self, signals: &Signals, arm: usize) -> Vec<f64> {
        let rbf = &self.gains.rbf;
        gaussians(&signals.z[arm], &grid_centres(rbf.nodes_posture), rbf.width_posture)
    }

    fn sat(&self, value: f64) -> f64 {
        value.min(self.gains.sat_limit).max(-self.gains.sat_limit)
    }

    /// `[τ̄₁, τ̄₂, v]`, eqs. (54) and (36).
    pub fn commands(&self, inputs: &Inputs) -> [f64; 3] {
        let x = self.signals(inputs);
        let ei = self.arms.ei;
        let o = &self.gains.object;
        let v = -o.eta * self.sat(x.s) - o.k * x.s - x.z1 - self.m_hat * x.z1_dot * (o.mu_bar + o.c1)
            + (ei[0] * x.q3[0] + ei[1] * x.q3[1])
            - dot(&self.w, &self.y_object(&x))
            - self.epsilon_hat * (x.s / o.epsilon1).tanh()
            - self.m_hat * (x.q3_dot[0] + x.q3_dot[1]);
        let tau = [0, 1].map(|i| {
            let g = &self.gains.posture[i];
            -g.xi * self.sat(x.s_i[i]) - g.k * x.s_i[i] - x.e[i] - self.j_hat[i] * x.e_dot[i] * (g.mu + g.c3)
                + ei[i] * x.q2_0[i]
                - dot(&self.u[i], &self.y_posture(&x, i))
                - self.pi_hat[i] * (x.s_i[i] / g.epsilon2).tanh()
                - x.lambda_d[i] * self.arms.length
        });
        [tau[0], tau[1], v]
    }

    /// Right-hand sides of (37)–(39) and (55)–(57), all estimates in one vector: see [`estimates`](Self::estimates).
    pub fn rates(&self, inputs: &Inputs) -> Vec<f64> {
        let x = self.signals(inputs);
        let o = &self.gains.object;
        let mut rates = vec![
            o.b1 * x.s * x.z1_dot * (o.mu_bar + o.c1) - o.b1 * o.b2 * self.m_hat
                + o.b1 * x.s * (x.q3_dot[0] + x.q3_dot[1]),
            o.gamma1 * x.s * (x.s / o.epsilon1).tanh() - o.gamma1 * o.gamma2 * self.epsilon_hat,
        ];
        let y = self.y_object(&x);
        rates.extend(self.w.iter().zip(&y).map(|(w, y)| o.a1 * x.s * y - o.a1 * o.a2 * w));
        for i in 0..2 {
            let g = &self.gains.posture[i];
            let s = x.s_i[i];
            rates.push(g.g1 * s * x.e_dot[i] * (g.mu + g.c3) - g.g1 * g.g2 * self.j_hat[i]);
            rates.push(g.zeta1 * s * (s / g.epsilon2).tanh() - g.zeta1 * g.zeta2 * self.pi_hat[i]);
            let y = self.y_posture(&x, i);
            rates.extend(self.u[i].iter().zip(&y).map(|(u, y)| g.a3 * s * y - g.a3 * g.a4 * u));
        }
        rates
    }

    /// m̂, ε̂, Ŵ, Ĵ₁, π̂₁, Û₁, Ĵ₂, π̂₂, Û₂.
    pub fn estimates(&self) -> Vec<f64> {
        let mut all = vec![self.m_hat, self.epsilon_hat];
        all.extend(&self.w);
        for i in 0..2 {
            all.extend([self.j_hat[i], self.pi_hat[i]]);
            all.extend(&self.u[i]);
        }
        all
    }

    pub fn set_estimates(&mut self, all: &[f64]) {
        let mut all = all.iter().copied();
        let mut next = || all.next().unwrap();
        self.m_hat = next();
        self.epsilon_hat = next();
        self.w.fill_with(&mut next);
        for i in 0..2 {
            self.j_hat[i] = next();
            self.pi_hat[i] = next();
            self.u[i].fill_with(&mut next);
        }
    }

    /// One classic Runge–Kutta step of the update laws; `inputs(t)` for t in [0, dt].
    pub fn rk4(&mut self, dt: f64, inputs: impl Fn(f64) -> Inputs) {
        let x0 = self.estimates();
        let mut slope = |time: f64, from: &[f64], along: f64| -> Vec<f64> {
            let x: Vec<f64> = x0.iter().zip(from).map(|(x, k)| x + along * k).collect();
            self.set_estimates(&x);
            self.rates(&inputs(time))
        };
        let zero = vec![0.0; x0.len()];
        let k1 = slope(0.0, &zero, 0.0);
        let k2 = slope(0.5 * dt, &k1, 0.5 * dt);
        let k3 = slope(0.5 * dt, &k2, 0.5 * dt);
        let k4 = slope(dt, &k3, dt);
        let x: Vec<f64> =
            (0..x0.len()).map(|i| x0[i] + dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])).collect();
        self.set_estimates(&x);
    }
}

/// Gains with everything switched on and visible: nothing is zero, nothing is alike.
pub fn lively() -> Gains {
    let mut gains = Gains::baseline();
    let o = &mut gains.object;
    (o.eta, o.k, o.mu_bar, o.c1, o.epsilon1) = (0.9, 0.7, 3.0, 4.5, 0.2);
    (o.a1, o.a2, o.gamma1, o.gamma2, o.b1, o.b2, o.m_hat_0) = (2.0, 0.3, 1.1, 0.4, 0.6, 0.7, 0.2);
    for (i, g) in gains.posture.iter_mut().enumerate() {
        let f = 1.0 + 0.2 * i as f64;
        (g.xi, g.k, g.mu, g.c3, g.epsilon2) = (1.2 * f, 0.3 * f, 5.0 * f, 7.0 * f, 0.15 * f);
        (g.a3, g.a4, g.zeta1, g.zeta2, g.g1, g.g2, g.j_hat_0) =
            (3.0 * f, 0.2 * f, 1.3 * f, 0.5 * f, 0.4 * f, 0.9 * f, 0.005 * f);
    }
    gains.rbf.nodes_posture = 3;
    gains.rbf.rings_object = 2;
    gains
}

pub fn unequal_arms() -> Arms {
    Arms { ei: [0.115, 0.16], length: 0.23, hub_distance: 0.11 }
}

/// Inputs of the magnitudes a grasp produces.
pub fn grasp_inputs() -> impl Strategy<Value = Inputs> {
    let scales: [f64; INPUTS] = [0.08, 0.08, 0.5, 0.5, 0.01, 0.05, 0.2, 0.2, 1.0, 1.0, 5.0, 5.0, 1.0, 1.0, 1.0, 0.1];
    prop::array::uniform16(-1.0..1.0_f64).prop_map(move |unit| {
        let mut values: [f64; INPUTS] = std::array::from_fn(|i| unit[i] * scales[i]);
        values[4] += 0.055;
        Inputs::from_array(values)
    })
}

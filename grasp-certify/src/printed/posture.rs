//! The conditions of the hubs' loops, (71), (83), (85), (87), (88), for the smallest β_1.
//!
//! For given r = β_2/β_1 and ϑ_7, (85) allows ϑ_5 down to β_1 EI/(1 − β_1 r l² ρ ϑ_7). With it (87) allows 1/ϑ_4 up to r
//! l/2 − g_3 ϑ_5, and (88) allows ϑ_6 up to 1/(2l) − g_3/ϑ_7. So (83) demands
//!
//! ```text
//! k_i > K_i(r, ϑ_7) = β_1 EI/(r l/2 − g_3 ϑ_5) + β_1 l² ρ/(1/(2l) − g_3/ϑ_7).
//! ```
//!
//! Between r_1 ≤ r ≤ r_2 and t_1 ≤ ϑ_7 ≤ t_2 it is at least the value of the formula with r_1 and t_1 in ϑ_5, and r_2 and
//! t_2 elsewhere. So boxes can be excluded with certainty. All conditions are posynomials in (r, ϑ), hence K_i is unimodal
//! in ln r.

use super::{Constants, Gains, smallest_b};
use crate::Grasp;
use crate::interval::{Interval, Number};

/// Halvings of r and of ϑ_7 before a box is left undecided.
const DEPTH: u32 = 40;

/// K_i with r and ϑ_7 from different ends of a box; `None` if the formula has no positive value.
fn gain<N: Number>(grasp: &Grasp, gains: &Gains, beta: f64, arm: usize, r: [f64; 2], theta: [f64; 2]) -> Option<N> {
    let n = N::exact;
    let (ei, rho, l, g3) = (n(grasp.arms[arm].ei), n(grasp.arms[arm].rho), n(grasp.length), n(gains.g3[arm]));
    let beta = n(beta);
    let rest = n(1.0) - beta * n(r[0]) * l * l * rho * n(theta[0]);
    if (-rest).is_positive() {
        return None;
    }
    let theta_5 = beta * ei / rest;
    let bending = n(r[1]) * l * n(0.5) - g3 * theta_5;
    let inertia = n(0.5) / l - g3 / n(theta[1]);
    if (-bending).is_positive() || (-inertia).is_positive() {
        return None;
    }
    Some(beta * ei / bending + beta * l * l * rho / inertia)
}

/// Largest r that (71) allows, outside of which nothing has to be excluded.
fn largest_ratio(grasp: &Grasp) -> f64 {
    let [a, b] = grasp.arms;
    let l = grasp.length;
    0.5 * a.ei.min(b.ei).min(a.rho).min(b.rho) / (l * a.rho.min(b.rho) * (l * l).min(1.0))
}

/// The range of ϑ_7 that (85) and (88) leave.
fn theta_range(grasp: &Grasp, gains: &Gains, beta: f64, arm: usize, r: f64) -> [f64; 2] {
    let l = grasp.length;
    [2.0 * l * gains.g3[arm], 1.0 / (beta * r * l * l * grasp.arms[arm].rho)]
}

/// Whether no r and no constants satisfy the conditions of both arms. Only a proof makes it true.
pub(super) fn excluded(grasp: &Grasp, gains: &Gains, beta: f64) -> bool {
    let l = grasp.length;
    // Below this, even the smallest ϑ_5, β_1 EI, exceeds the limit of (87); above, (71) fails. Widened for rounding.
    let low = (0..2).map(|i| 2.0 * gains.g3[i] * beta * grasp.arms[i].ei / l).fold(0.0, f64::max);
    let (low, high) = (low * (1.0 - 1e-12), largest_ratio(grasp) * (1.0 + 1e-12));
    low >= high || excluded_between(grasp, gains, beta, [low, high], DEPTH)
}

fn excluded_between(grasp: &Grasp, gains: &Gains, beta: f64, r: [f64; 2], depth: u32) -> bool {
    let by_one = (0..2).any(|arm| {
        let range = theta_range(grasp, gains, beta, arm, r[0]);
        let range = [range[0] * (1.0 - 1e-12), range[1] * (1.0 + 1e-12)];
        range[0] >= range[1] || excluded_for(grasp, gains, beta, arm, r, range, 12)
    });
    if by_one {
        return true;
    }
    if depth == 0 || r[1] - r[0] < 1e-7 * r[1] {
        return false;
    }
    let middle = (r[0] * r[1]).sqrt();
    excluded_between(grasp, gains, beta, [r[0], middle], depth - 1)
        && excluded_between(grasp, gains, beta, [middle, r[1]], depth - 1)
}

fn excluded_for(grasp: &Grasp, gains: &Gains, beta: f64, arm: usize, r: [f64; 2], theta: [f64; 2], depth: u32) -> bool {
    let least = gain::<Interval>(grasp, gains, beta, arm, r, theta);
    if least.is_none_or(|least| least.lo() >= gains.k_hub[arm]) {
        return true;
    }
    if depth == 0 {
        return false;
    }
    let middle = (theta[0] * theta[1]).sqrt();
    excluded_for(grasp, gains, beta, arm, r, [theta[0], middle], depth - 1)
        && excluded_for(grasp, gains, beta, arm, r, [middle, theta[1]], depth - 1)
}

/// Smallest K_i(r) over ϑ_7, and where.
fn least_gain(grasp: &Grasp, gains: &Gains, beta: f64, arm: usize, r: f64) -> (f64, f64) {
    let range = theta_range(grasp, gains, beta, arm, r).map(f64::ln);
    golden(range, |x| {
        let theta = x.exp();
        gain::<f64>(grasp, gains, beta, arm, [r; 2], [theta; 2]).unwrap_or(f64::INFINITY)
    })
}

/// The smallest value of a unimodal function, and its place. Infinite values mean "outside"; a scan finds the inside.
fn golden([low, high]: [f64; 2], f: impl Fn(f64) -> f64) -> (f64, f64) {
    const POINTS: u32 = 200;
    let at = |i: u32| low + (high - low) * f64::from(i) / f64::from(POINTS);
    let best = (0..=POINTS).min_by(|a, b| f(at(*a)).total_cmp(&f(at(*b)))).unwrap_or(0);
    let (mut a, mut b) = (at(best.saturating_sub(1)), at((best + 1).min(POINTS)));
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..80 {
        let (left, right) = (b - ratio * (b - a), a + ratio * (b - a));
        if f(left) < f(right) { b = right } else { a = left }
    }
    let x = 0.5 * (a + b);
    let (scanned, found) = (f(at(best)), f(x));
    if scanned < found { (scanned, at(best)) } else { (found, x) }
}

/// The r with the smallest max K_i(r)/k_i, and that value.
fn best_ratio(grasp: &Grasp, gains: &Gains, beta: f64) -> (f64, f64) {
    let low = (0..2).map(|i| 2.0 * gains.g3[i] * beta * grasp.arms[i].ei / grasp.length).fold(0.0, f64::max);
    let (value, x) = golden([low, largest_ratio(grasp) * (1.0 - 1e-9)].map(f64::ln), |x| {
        (0..2).map(|arm| least_gain(grasp, gains, beta, arm, x.exp()).0 / gains.k_hub[arm]).fold(0.0, f64::max)
    });
    (value, x.exp())
}

/// The factor by which k_1 and k_2 have to grow, as found by the search; infinite if no factor is enough.
pub(super) fn needed_gain(grasp: &Grasp, gains: &Gains, beta: f64) -> f64 {
    best_ratio(grasp, gains, beta).0
}

/// Constants for the smallest β_1 of this module, with the slack spread evenly. `None` if the search finds none.
pub(super) fn constants(grasp: &Grasp, gains: &Gains, beta: f64) -> Option<Constants> {
    let (value, r) = best_ratio(grasp, gains, beta);
    if value >= 1.0 {
        return None;
    }
    let (g, l) = (gains.g, grasp.length);
    // A larger β_1 gives (82) and (86) slack; the hubs' conditions limit it.
    let b = beta * (grasp.arms[0].ei + grasp.arms[1].ei);
    debug_assert!(b >= smallest_b(g).lo());
    let rest = 1.0 + 0.5 * b - 2.0 * b * g;
    let theta_3 = g * (2.0 * rest / (b * g)).sqrt();
    let low = 1.0 / (b * (0.5 - g / theta_3));
    let room = g * (1.0 + b * (0.5 - theta_3 - 2.0 * g));
    if room <= low {
        return None;
    }
    let theta_1 = (low * room).sqrt();
    // 1/ϑ_2 may exceed 2g by the slack of (82).
    let slack = (1.0 - theta_1 / g) / b + 0.5 - theta_3 - 2.0 * g;
    let theta_2 = 1.0 / (2.0 * g + 0.5 * slack);
    let arm = |i: usize| {
        let (needed, x) = least_gain(grasp, gains, beta, i, r);
        let (ei, rho, theta_7) = (grasp.arms[i].ei, grasp.arms[i].rho, x.exp());
        let theta_5_least = beta * ei / (1.0 - beta * r * l * l * rho * theta_7);
        // A third of the gain's slack for each of ϑ_4, ϑ_5, ϑ_6.
        let share = (gains.k_hub[i] / needed).cbrt().min(2.0);
        let bending = r * l * 0.5 - gains.g3[i] * theta_5_least;
        let theta_5 = theta_5_least + (1.0 - 1.0 / share) * bending / gains.g3[i];
        let theta_4 = share / (r * l * 0.5 - gains.g3[i] * theta_5);
        let theta_6 = (0.5 / l - gains.g3[i] / theta_7) / share;
        [theta_4, theta_5, theta_6, theta_7]
    };
    let arms = [arm(0), arm(1)];
    let pick = |j: usize| [arms[0][j], arms[1][j]];
    Some(Constants {
        beta_1: beta,
        beta_2: r * beta,
        theta_1,
        theta_2,
        theta_3,
        theta_4: pick(0),
        theta_5: pick(1),
        theta_6: pick(2),
        theta_7: pick(3),
    })
}

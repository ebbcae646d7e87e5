//! The search for good constants. [`verify`] checks its results; if it finds nothing, nothing is proved.

use super::{Certificate, Constants, Port, Storage, form, largest, proves, verify};
use crate::Grasp;
use crate::search::maximise;
use std::cell::Cell;

/// Numbers per end with and without observers, after ε_1, ε_2, τ_1, τ_2.
const OBSERVED: usize = 10;
const PLAIN: usize = 3;
const FIELDS: usize = 4;

/// The best certificate found by a search. `None` if it finds none, which proves nothing.
///
/// Needs positive inertias and gains, and feed-forward or a built-in uncertainty at each end.
#[must_use]
pub fn certify(grasp: &Grasp, ports: &[Port; 3]) -> Option<Certificate> {
    if !ports.iter().all(Port::is_usable) {
        return None;
    }
    // The cost of a step grows with the number of unknowns, and so does the number of steps that it takes.
    if ports.iter().any(|port| port.observer > 0.0) {
        search::<{ FIELDS + 3 * OBSERVED }>(grasp, ports, 16_000)
    } else {
        search::<{ FIELDS + 3 * PLAIN }>(grasp, ports, 12_000)
    }
}

fn search<const N: usize>(grasp: &Grasp, ports: &[Port; 3], evaluations: usize) -> Option<Certificate> {
    let units = ports.map(|port| port.natural_storage()[2]);
    let climb = |ports: &[Port; 3], from: Option<[f64; N]>, evaluations: usize| {
        let best = Cell::new(LOWEST);
        let value = |x: &[f64; N]| {
            let rate = rate(grasp, &unpack(&units, x), ports, best.get());
            best.set(best.get().max(rate));
            rate
        };
        let start = from.or_else(|| start::<N>(grasp, ports, &units, &value))?;
        Some(maximise(value, start, 0.1, evaluations))
    };
    let mut reached = climb(ports, None, evaluations)?;
    if reached.1 <= 0.0 && ports.iter().any(|port| port.load_rate > 0.0) {
        // From where there are no uncertainties to where they are, each stage from the end of the one before.
        let mut from = None;
        for share in [0.0, 0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0] {
            let stage = ports.map(|port| Port { load_rate: share * port.load_rate, ..port });
            if !stage.iter().all(Port::is_usable) {
                continue;
            }
            reached = climb(&stage, from, evaluations / 2)?;
            from = Some(reached.0);
        }
    }
    let (found, rate) = reached;
    if rate > 0.0 { verify(grasp, ports, &unpack(&units, &found), rate) } else { None }
}

/// Logarithms of the constants; w, u and v in their natural unit, x, y and g unchanged, h as its excess over g².
fn unpack<const N: usize>(units: &[f64; 3], x: &[f64; N]) -> Constants {
    let per_end = (N - FIELDS) / 3;
    Constants {
        epsilon_1: x[0].exp(),
        epsilon_2: x[1].exp(),
        tau: [x[2].exp(), x[3].exp()],
        storage: std::array::from_fn(|end| {
            let x = &x[FIELDS + per_end * end..][..per_end];
            let slope = units[end];
            let plain = Storage::plain([x[0].exp(), x[1].exp(), x[2] * slope]);
            match x[PLAIN..] {
                [error, learnt, r, g, excess, u, v] => Storage {
                    error,
                    learnt,
                    observer: [r.exp(), g, g * g + excess.exp()],
                    drift: [u * slope, v * slope],
                    ..plain
                },
                _ => plain,
            }
        }),
    }
}

/// Nothing decays that slowly.
const LOWEST: f64 = -1e7;

/// The largest φ in floating point that the constants prove, also below zero: the distance from a proof guides the search.
/// No more than `known` if it is not larger than that.
fn rate(grasp: &Grasp, constants: &Constants, ports: &[Port; 3], known: f64) -> f64 {
    let holds = |phi: f64| proves::<f64>(grasp, ports, constants, phi);
    // H has to bound W from below.
    if !form::dominates::<f64>(grasp, constants, 1e-3) || !holds(known) {
        return LOWEST;
    }
    if known > 0.0 {
        return largest(known, 1e6, holds).unwrap_or(LOWEST);
    }
    if let Some(rate) = largest(1e-6, 1e6, holds) {
        return rate;
    }
    let (mut low, mut high) = (known, 0.0);
    for _ in 0..50 {
        let middle = if low < -1.0 && high > 0.1 * low { -(low * high.min(-0.1)).sqrt() } else { 0.5 * (low + high) };
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// The start of the search: natural storage functions, and the best point of a grid of ε_1, ε_2, τ and the observers'
/// weight. `None` if no point of it proves any rate, however negative.
fn start<const N: usize>(
    grasp: &Grasp,
    ports: &[Port; 3],
    units: &[f64; 3],
    value: &impl Fn(&[f64; N]) -> f64,
) -> Option<[f64; N]> {
    let per_end = (N - FIELDS) / 3;
    let time = grasp.arms.iter().map(|arm| grasp.length.powi(2) * (arm.rho / arm.ei).sqrt()).fold(0.0, f64::max);
    let mut x = [0.0; N];
    let mut best = None;
    // ζ + w p by itself, or ζ − a + w p = v̂ + f c S + w p, which the law uses: that is the place where a fast observer
    // cancels the built-in uncertainties.
    let weights = [0.01, 0.1, 1.0, 10.0].into_iter().flat_map(|weight| [(weight, 0.0), (weight, -1.0)]);
    let starts: Vec<_> = if per_end == OBSERVED { weights.collect() } else { vec![(1.0, 0.0)] };
    for (weight, error) in starts {
        for (end, port) in ports.iter().enumerate() {
            let seen =
                if error == 0.0 { *port } else { Port { load_rate: 0.0, inertia: port.assumed_inertia, ..*port } };
            let [a, b, w] = if seen.is_usable() { seen } else { *port }.natural_storage();
            let x = &mut x[FIELDS + per_end * end..][..per_end];
            x[..PLAIN].copy_from_slice(&[a.ln(), b.ln(), w / units[end]]);
            if per_end == OBSERVED {
                // a² + 2aδ + 3δ² falls by ω(a² + δ²) in an observer without errors of its model.
                x[PLAIN..].copy_from_slice(&[error, 0.0, (weight * b).ln(), 1.0, 2f64.ln(), 0.0, 0.0]);
            }
        }
        for first in 0..16 {
            for second in 1..11 {
                for third in 1..13 {
                    let epsilon_1 = 2.0 / time * 0.5f64.powi(first);
                    let epsilon_2 = epsilon_1 * 0.5f64.powi(second);
                    x[0] = epsilon_1.ln();
                    x[1] = epsilon_2.ln();
                    for i in 0..2 {
                        let most = (1.5 * epsilon_1 + epsilon_2) * grasp.tip_stiffness(i);
                        x[2 + i] = (most * 0.5f64.powi(third)).ln();
                    }
                    let rate = value(&x);
                    if rate > best.map_or(LOWEST, |(_, highest)| highest) {
                        best = Some((x, rate));
                    }
                }
            }
        }
    }
    best.map(|(x, _)| x)
}

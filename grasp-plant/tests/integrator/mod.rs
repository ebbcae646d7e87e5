//! Ordinary differential equations to nearly full precision: Gragg, Bulirsch and Stoer's extrapolated midpoint rule.
//!
//! Explicit, so its steps are a few of the fastest time constants long: for tests, where nothing is known to be simpler. (Hairer,
//! Nørsett, Wanner: *Solving Ordinary Differential Equations I*, II.9.)

#![allow(dead_code)]

/// A system ẋ = f(t, x) that is smooth between events.
pub trait System {
    /// f(t, x).
    fn rates(&mut self, time: f64, x: &[f64], out: &mut [f64]);

    /// Magnitudes of the states, to which errors are compared.
    fn scales(&self) -> Vec<f64>;

    /// Signals whose change of sign is an event.
    fn indicators(&mut self, _time: f64, _x: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    /// Something happened.
    fn event(&mut self, _time: f64, _x: &mut [f64]) {}
}

/// Columns of the extrapolation: the order is twice as high.
const COLUMNS: usize = 7;

/// Integrates from `time` to `end` with steps whose errors are below `tolerance` times the scales; returns the times of events.
pub fn integrate(system: &mut impl System, x: &mut [f64], mut time: f64, end: f64, tolerance: f64) -> Vec<f64> {
    let scales = system.scales();
    let mut events = Vec::new();
    let mut h = (end - time) * 1e-5;
    let mut signs = signs(system, time, x);
    while time < end {
        h = h.min(end - time);
        let (next, error) = step(system, time, x, h, &scales);
        let error = error / tolerance;
        let factor = (0.8 * error.powf(-1.0 / (2 * COLUMNS - 1) as f64)).clamp(0.1, 2.5);
        if error > 1.0 || error.is_nan() {
            h *= if error.is_nan() { 0.1 } else { factor };
            assert!(h > 1e-17, "the step vanishes at t = {time}: {error:e}");
            continue;
        }
        let found = self::signs(system, time + h, &next);
        let (mut after, mut taken) = (next, h);
        let happens = found != signs;
        if happens {
            // The shortest step after which a sign has changed.
            let (mut before, mut late) = (0.0, h);
            while late - before > 1e-14 * h.max(1e-6) {
                let middle = f64::midpoint(before, late);
                if middle <= before || middle >= late {
                    break;
                }
                let (trial, _) = step(system, time, x, middle, &scales);
                if self::signs(system, time + middle, &trial) == signs {
                    before = middle;
                } else {
                    (late, after) = (middle, trial);
                }
            }
            taken = late;
        }
        x.copy_from_slice(&after);
        // The last step ends exactly there.
        time = if taken == end - time { end } else { time + taken };
        if happens {
            events.push(time);
            system.event(time, x);
            assert!(events.len() < 1000, "events without end at t = {time}");
            h = (h * 1e-2).max(1e-9);
        } else {
            h *= factor;
        }
        signs = self::signs(system, time, x);
    }
    events
}

fn signs(system: &mut impl System, time: f64, x: &[f64]) -> Vec<bool> {
    system.indicators(time, x).into_iter().map(|z| z > 0.0).collect()
}

/// The state after one step of `h`, and its error in units of the scales.
fn step(system: &mut impl System, time: f64, x: &[f64], h: f64, scales: &[f64]) -> (Vec<f64>, f64) {
    let mut start = vec![0.0; x.len()];
    system.rates(time, x, &mut start);
    let mut row: Vec<Vec<f64>> = Vec::new();
    let mut error = f64::INFINITY;
    for j in 0..COLUMNS {
        let mut column = midpoint(system, time, x, &start, h, 2 * (j + 1));
        let mut new_row = Vec::with_capacity(j + 1);
        for (k, old) in row.iter().enumerate() {
            let ratio = ((j + 1) as f64 / (j - k) as f64).powi(2);
            let better = column.iter().zip(old).map(|(new, old)| new + (new - old) / (ratio - 1.0)).collect();
            new_row.push(std::mem::replace(&mut column, better));
        }
        if j + 1 == COLUMNS {
            error = column.iter().zip(&new_row[j - 1]).zip(scales).fold(0.0, |most: f64, ((a, b), scale)| {
                let e = (a - b).abs() / scale;
                if e.is_nan() { f64::NAN } else { most.max(e) }
            });
        }
        new_row.push(column);
        row = new_row;
    }
    (row.pop().unwrap(), error)
}

/// The midpoint rule in `n` parts.
fn midpoint(system: &mut impl System, time: f64, x: &[f64], start: &[f64], h: f64, n: usize) -> Vec<f64> {
    let part = h / n as f64;
    let mut before = x.to_vec();
    let mut now: Vec<f64> = x.iter().zip(start).map(|(x, rate)| x + part * rate).collect();
    let mut rate = vec![0.0; x.len()];
    for i in 1..n {
        system.rates(time + i as f64 * part, &now, &mut rate);
        for ((before, now), rate) in before.iter_mut().zip(&mut now).zip(&rate) {
            let next = *before + 2.0 * part * rate;
            *before = std::mem::replace(now, next);
        }
    }
    now
}

//! The estimates of hubs that move under known torques.

use super::*;

const FILTER: FilterGains = FilterGains { bandwidth: 150.0, high_pass: 3.0 };
const HUB: Prior = Prior {
    initial: 0.0073,
    smallest: 0.000_73,
    largest: 0.146,
    threshold: 0.1,
    weight: 3e-4,
    memory: 0.1,
    stiffness: 1.725,
};

impl Estimator {
    fn step(&mut self, h: f64, filter: &FilterGains, shares: &Shares, prior: &Prior, moving: Moving) {
        self.step_with(h, filter.bandwidth, [shares.slow, shares.follow], &prior.weights(), &moving);
    }
}

/// A hub on a spring with losses −c Ṁ, under a torque that goes to and fro for two seconds and a constant one that nobody
/// knows.
fn learnt(inertia: f64, loss: f64) -> Estimator {
    let (h, mut angle, mut rate) = (1e-4, 0.0, 0.0);
    let mut estimator = Estimator::settled(rate, 0.0);
    for step in 0..20_000 {
        let load = HUB.stiffness * angle;
        let torque = (25.0 * f64::from(step) * h).sin() + 0.5 * (60.0 * f64::from(step) * h).sin() - load;
        let acceleration = (torque - loss * HUB.stiffness * rate + 0.05) / inertia;
        rate += 0.5 * h * acceleration;
        estimator.step(h, &FILTER, &FILTER.shares(h), &HUB, Moving { rate, force: torque, load });
        rate += 0.5 * h * acceleration;
        angle += h * rate;
    }
    estimator
}

#[test]
fn the_inertia_is_found_beside_losses_and_a_constant_torque() {
    let mut found = Vec::new();
    for ratio in [0.5, 1.0, 2.0, 5.0, 14.0] {
        for loss in [0.0, 0.025, 0.1] {
            found.push((ratio, loss, learnt(ratio * HUB.initial, loss).inertia(&HUB) / (ratio * HUB.initial)));
        }
    }
    // The prior weighs 3e-4 beside a remembered excitation of 0.1, and pulls 1/Ĵ towards the start: by 0.3 % for each multiple of
    // it, and by more for light hubs with losses, whose torque is mostly along Ṁ.
    assert!(found.iter().all(|(_, _, ratio)| (ratio - 1.0).abs() < 0.06), "{found:.3?}");
}

/// The projection, and the rate that is the derivative of what the steps do.
#[test]
fn estimates_stay_in_their_bounds_and_move_at_their_rate() {
    let estimator = learnt(5.0 * HUB.initial, 0.05);
    let held = Prior { smallest: HUB.initial, largest: HUB.initial, ..HUB };
    assert!((estimator.inertia(&held) - HUB.initial).abs() < 1e-15);
    let moving = Moving { rate: 0.3, force: 0.4, load: 0.1 };
    assert_eq!(estimator.inertia_rate(&FILTER, &held, moving), 0.0);
    // One-sided, so the error is that of the next order, h/2 times what relatively changes within a filter's 7 ms.
    let (mut after, h) = (estimator, 1e-7);
    after.step(h, &FILTER, &FILTER.shares(h), &HUB, moving);
    let difference = (after.inertia(&HUB) - estimator.inertia(&HUB)) / h;
    let rate = estimator.inertia_rate(&FILTER, &HUB, moving);
    assert!(rate != 0.0 && (difference - rate).abs() < 1e-3 * rate.abs(), "{difference} {rate}");
}

/// Rest, and torques far below the threshold, which count by their fourth power.
#[test]
fn nothing_is_forgotten_without_excitation() {
    let mut estimator = learnt(3.0 * HUB.initial, 0.05);
    estimator.smooth = Signals::default();
    estimator.slow = Signals::default();
    let before = estimator.inertia(&HUB);
    let shares = FILTER.shares(1e-3);
    for step in 0..100_000 {
        let force = 0.002 * f64::from(step % 7 - 3);
        estimator.step(1e-3, &FILTER, &shares, &HUB, Moving { rate: 0.0, force, load: 0.0 });
    }
    let change = estimator.inertia(&HUB) / before - 1.0;
    assert!(change.abs() < 1e-3, "{change}");
}

//! Noise of one percent and more, for a minute and for ten.

use super::*;

/// Noise of one percent: less force error than the tuned PID and PD have (12 mN rms), limits reached at the start only, and the
/// last ten of sixty seconds no worse than the second ten. `noise_for_ten_minutes` has the whole requirement.
#[test]
fn noise() {
    for (outcome, bound) in [(default(&NOISE), 0.0075), (fast(&NOISE), 0.0075)] {
        assert!(outcome.rms <= bound && outcome.rms <= 1.2 * outcome.rms_early, "{outcome:?}");
        assert!(outcome.saturated <= 0.02, "{outcome:?}");
    }
}

/// Networks and robust terms in the place of the observers' constants: they find lasting disturbances and bear noise,
/// later and rougher than those.
#[test]
fn networks_learn_from_prediction_errors() {
    for case in [
        Case { hub_torque: 0.1, ..Case::default() },
        Case { object_force: 0.1, ..Case::default() },
        Case { friction: 0.02, ..Case::default() },
    ] {
        let outcome = networks(&Case { duration: 3.0, ..case });
        assert!(outcome.settling() <= 0.5 && outcome.mean_error <= 5e-4, "{case:?} {outcome:?}");
    }
    let outcome = networks(&NOISE);
    assert!(outcome.rms <= 1.2 * outcome.rms_early && outcome.saturated <= 0.02, "{outcome:?}");
    // In Lemma 3's balls, whose radii are the actuators' limits.
    assert!(outcome.estimates[0] <= 2.0 && outcome.estimates[1] <= 2.0 && outcome.estimates[2] <= 0.3, "{outcome:?}");
}

/// The paper's law bears noise, by its leakages, with both sets of gains.
#[test]
fn noise_and_the_papers_law() {
    let paper = |case: &Case| run_law(case, &mut Nabfc::new(case.arms(), Gains::default()).unwrap());
    let outcome = run_law(&NOISE, &mut Nabfc::new(NOISE.arms(), Gains::fast()).unwrap());
    assert!(outcome.rms <= 0.015 && outcome.rms <= 1.2 * outcome.rms_early, "{outcome:?}");
    let outcome = paper(&Case::default());
    assert!(outcome.settling() <= 0.32 && outcome.overshoot <= 0.02 && outcome.mean_error <= 5e-4, "{outcome:?}");
    for case in [Case { hub_torque: 0.1, ..Case::default() }, Case { object_force: 0.1, ..Case::default() }] {
        let outcome = paper(&Case { duration: 4.0, ..case });
        assert!(outcome.mean_error <= 5e-4 && outcome.force <= 0.5, "{case:?} {outcome:?}");
    }
    let outcome = paper(&NOISE);
    assert!(outcome.rms <= 0.01 && outcome.rms <= 1.2 * outcome.rms_early, "{outcome:?}");
}

/// Noise at 10 kHz, where the paper's networks learn ten times as often from it.
#[test]
fn fast_noise() {
    let case = Case { step: 1e-4, duration: 40.0, ..NOISE };
    for (name, run) in [PRESETS[0], PRESETS[1], PRESETS[3], PRESETS[4]] {
        let outcome = run(&case);
        assert!(outcome.rms <= 1.2 * outcome.rms_early && outcome.saturated <= 0.01, "{name} {outcome:?}");
    }
}

/// Every preset, for ten minutes: `cargo test --release -p grasp-control --test requirements -- --ignored --nocapture
/// noise_for_ten_minutes`.
#[test]
#[ignore = "takes two minutes"]
fn noise_for_ten_minutes() {
    for (what, case) in [
        ("at 1 kHz", Case { duration: 600.0, ..NOISE }),
        ("doubled", Case { duration: 600.0, noise: 2.0, ..NOISE }),
        ("at 10 kHz", Case { duration: 600.0, step: 1e-4, ..NOISE }),
    ] {
        println!("one percent of noise, {what}: rms force error from 10 s to 20 s, from 590 s to 600 s");
        // The paper's PDS and PD are unstable at 1 kHz, with and without noise.
        for (name, run) in PRESETS.iter().filter(|(name, _)| !["pds", "pd"].contains(name) || case.step < 2e-4) {
            let outcome = run(&case);
            println!("  {name:24} {:7.2} {:7.2} mN", 1e3 * outcome.rms_early, 1e3 * outcome.rms);
            assert!(outcome.rms <= 1.2 * outcome.rms_early, "{name} {case:?} {outcome:?}");
            assert!(outcome.saturated <= 0.01, "{name} {case:?} {outcome:?}");
            assert!(outcome.estimates[..2].iter().all(|estimate| estimate.abs() < 0.5), "{name} {case:?} {outcome:?}");
        }
    }
}

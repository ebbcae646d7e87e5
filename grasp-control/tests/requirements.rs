//! What the shipped gains promise, on the plant with its beams, at 1 kHz.
//!
//! "Settled" means that both contact forces, both angles and the object's position, all of (17), are within 2 % of their
//! way. Bounds are the requirements, not the values reached.

mod grasp;

use grasp::{Case, NOISE, Outcome, run, run_law};
use grasp_control::Law;
use grasp_control::blocks::observer::RateSource;
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::nabfc::{Gains, Nabfc};
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::laws::pds::{Limits, Pds, PdsGains};
use grasp_control::laws::root_strain::{Learner, RootStrainGains};
use grasp_plant::ActuatorModel;

/// Default gains.
fn default(case: &Case) -> Outcome {
    run(case, &RootStrainGains::default())
}

/// The preset *fast*.
fn fast(case: &Case) -> Outcome {
    run(case, &RootStrainGains::fast())
}

/// A law that has observers only where rates are not measured.
fn seen<L: Law>(case: &Case, law: L) -> Outcome {
    let source = if case.encoders { RateSource::Estimated } else { RateSource::Measured };
    run_law(case, &mut Encoders::new(law, source, Actuation::default()).unwrap())
}

type Run = fn(&Case) -> Outcome;

/// Every set of gains by the name that the tool has for it.
const PRESETS: [(&str, Run); 10] = [
    ("nabfc-r", default),
    ("nabfc-r-fast", fast),
    ("nabfc-r, networks", networks),
    ("nabfc", |case| seen(case, Nabfc::new(case.arms(), Gains::default()).unwrap())),
    ("nabfc-fast", |case| seen(case, Nabfc::new(case.arms(), Gains::fast()).unwrap())),
    ("pid", |case| seen(case, Pd::new(case.arms(), PdGains::pid(), Limits::default()).unwrap())),
    ("pd-tuned", |case| seen(case, Pd::new(case.arms(), PdGains::tuned(), Limits::default()).unwrap())),
    ("pds-tuned", |case| seen(case, Pds::new(case.arms(), PdsGains::tuned(), Limits::default()).unwrap())),
    ("pds", |case| seen(case, Pds::new(case.arms(), PdsGains::default(), Limits::default()).unwrap())),
    ("pd", |case| seen(case, Pd::new(case.arms(), PdGains::default(), Limits::default()).unwrap())),
];

/// Networks in the root-strain law.
fn networks(case: &Case) -> Outcome {
    run(case, &RootStrainGains { learner: Learner::Networks, ..RootStrainGains::default() })
}

/// The undisturbed grasp: all of (17) within 0.2 s and 0.12 s, overshoot below 2 %, inside the paper's limits; the same
/// for other orders of the discretisation and other initial masses.
#[test]
fn undisturbed() {
    for order in [8, 12] {
        let case = Case { order, ..Case::default() };
        let outcome = default(&case);
        assert!(outcome.settling() <= 0.2 && outcome.overshoot <= 0.02, "{outcome:?}");
        let outcome = fast(&case);
        assert!(outcome.settling() <= 0.12 && outcome.overshoot <= 0.02, "{outcome:?}");
    }
    for initial in [0.25, 1.0] {
        let mut gains = RootStrainGains::default();
        gains.mass.initial = initial;
        let outcome = run(&Case::default(), &gains);
        assert!(outcome.settling() <= 0.2 && outcome.overshoot <= 0.02, "{initial} kg: {outcome:?}");
    }
}

/// Lasting disturbances: 0.25 s and 0.5 mN, overshoot below 2 %. No position bound under ΔF: a third of the actuator's
/// force is gone, and the object needs all of it to stop within 2 % of 1.1 mm.
#[test]
fn lasting_disturbances() {
    let base = Case::default();
    for case in [
        Case { hub_torque: 0.1, ..base },
        Case { object_force: 0.1, ..base },
        Case { object_force: -0.1, ..base },
        Case { actuator: ActuatorModel::Raw, ..base },
        Case { friction: 0.02, ..base },
        Case { dahl: 0.02, ..base },
    ] {
        for outcome in [default(&case), fast(&case)] {
            assert!(outcome.settling() <= 0.25, "{case:?} {outcome:?}");
            assert!(outcome.mean_error <= 5e-4 && outcome.overshoot <= 0.02, "{case:?} {outcome:?}");
        }
    }
}

/// Masses the controller does not know. The force limit alone allows 2√(m d/`u_max`) for the object's way d: 0.39 s at
/// 10 kg. Force and angles are there within 0.5 s, and the object within 1.5 times the limit or 0.2 s.
#[test]
fn unknown_masses() {
    for mass in [0.05, 0.3, 1.0, 2.0, 5.0, 10.0] {
        let case = Case { object_mass: mass, duration: 3.0, ..Case::default() };
        let outcome = default(&case);
        let limit = 2.0 * ((mass + 0.2) * 1.122e-3 / 0.3_f64).sqrt();
        assert!(outcome.force <= 0.5 && outcome.angles <= 0.5, "{mass} kg: {outcome:?}");
        assert!(outcome.position <= (1.5 * limit).max(0.2), "{mass} kg, limit {limit} s: {outcome:?}");
    }
}

/// Arms of other lengths and stiffnesses, known to the controller, with the same gains: 0.5 s, or 1.5 times what the
/// force limit alone allows for the object's way.
#[test]
fn other_arms() {
    let base = Case { duration: 4.0, ..Case::default() };
    let arms = [(0.1, 1.0), (0.3, 1.0), (0.4, 1.0), (0.5, 1.0), (0.2, 0.25), (0.2, 0.5), (0.2, 2.0), (0.2, 4.0)];
    for (length, stiffness) in arms {
        let case = Case { length, stiffness, ..base };
        let outcome = default(&case);
        let limit = 2.0 * (0.5 * case.way() / 0.3_f64).sqrt();
        assert!(outcome.settling() <= (1.5 * limit).max(0.5), "{case:?}, limit {limit} s: {outcome:?}");
    }
}

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

/// The latest commands that each preset bears at 1 kHz: the paper's grasp ends within 10 mN rms, with angles settled in a
/// second. `cargo test --release -p grasp-control --test requirements -- --ignored --nocapture delay_margins`.
#[test]
#[ignore = "prints a table"]
fn delay_margins() {
    for (name, run) in PRESETS {
        let bears = |delay: &usize| {
            let outcome = run(&Case { delay: *delay, duration: 3.0, ..Case::default() });
            outcome.rms < 0.01 && outcome.angles < 1.0
        };
        let margin = (0..30).take_while(bears).last();
        println!("{name:24} {}", margin.map_or("unstable at 1 kHz".into(), |delay| format!("{delay} ms")));
    }
}

/// Commands 2 ms late; the default bears 5 ms.
#[test]
fn delay() {
    for (outcome, delay) in [
        (default(&Case { delay: 2, ..Case::default() }), 2),
        (default(&Case { delay: 5, ..Case::default() }), 5),
        (fast(&Case { delay: 2, ..Case::default() }), 2),
        (default(&Case { delay: 2, ..NOISE }), 2),
    ] {
        assert!(outcome.rms <= 0.0075 && outcome.angles <= 0.25, "{delay} ms: {outcome:?}");
    }
}

/// Angles from 16-bit encoders, position from one of 1 µm, strain in steps of 30 µN·m and 0.15 mN, no rates at all.
#[test]
fn encoders_only() {
    for noise in [0.0, 0.3] {
        let case = Case { encoders: true, noise, duration: 4.0, ..Case::default() };
        for outcome in [default(&case), fast(&case)] {
            assert!(outcome.angles <= 0.6 && outcome.position <= 0.6 && outcome.rms <= 0.01, "{outcome:?}");
            assert!(noise > 0.0 || outcome.force <= 0.6, "{outcome:?}");
        }
    }
}

/// The mass within 20 % after a rich motion: two seconds of a reference that goes to and fro.
#[test]
fn the_mass_is_found() {
    let found = [0.3, 1.0, 2.0, 5.0, 10.0].map(|object_mass| {
        let case = Case { object_mass, sway: 0.02, duration: 4.0, ..Case::default() };
        (object_mass, default(&case).mass / (object_mass + 0.2))
    });
    assert!(found.iter().all(|(_, ratio)| (0.8..=1.2).contains(ratio)), "{found:.3?}");
}

/// Hubs of a quarter to fourteen times the inertia that the controller is told, with little and with much damping at the roots:
/// Ĵ finds it, heavy hubs within a third, and all of (17) settles within 0.75 s without overshoot. (Held at what it is told, the
/// law does not settle from five times on.) A light hub's torque goes into losses, so its inertia matters little and shows little.
#[test]
fn hub_inertias_need_not_be_known() {
    for hub_inertia in [0.25, 0.5, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0] {
        for root_uncertainty in [0.025, 0.1] {
            let case = Case { hub_inertia, root_uncertainty, duration: 2.0, ..Case::default() };
            for outcome in [default(&case), fast(&case)] {
                assert!(outcome.settling() <= 0.75 && outcome.overshoot <= 0.04, "{case:?} {outcome:?}");
                let found = outcome.inertia.map(|j| j / (0.0073 * hub_inertia));
                assert!(
                    hub_inertia < 2.0 || found.iter().all(|ratio| (0.67..1.33).contains(ratio)),
                    "{case:?} {found:?}"
                );
            }
        }
    }
}

/// The default gains that an earlier search found without such cases, with the parts that have to do with hubs.
fn former() -> RootStrainGains {
    let mut gains =
        RootStrainGains { strain_bandwidth: 0.0, strain_rate_bandwidth: 8.164, ..RootStrainGains::default() };
    for hub in &mut gains.hub {
        (hub.slope, hub.reach, hub.strain, hub.feedforward, hub.observer) = (1.126, 0.6525, 8.321, 0.3829, 153.0);
    }
    gains
}

/// Little damping at the roots, noise that excites the beams, commands late: ends within 10 mN rms.
fn bears(gains: &RootStrainGains, root_uncertainty: f64, hub_inertia: f64, delay: usize) -> bool {
    let case = Case { root_uncertainty, hub_inertia, delay, noise: 0.3, duration: 4.0, ..Case::default() };
    run(&case, gains).rms < 0.01
}

/// A quarter of the paper's damping, the least of the robustness study, hubs of half and twice the inertia, commands up to 3 ms late:
/// default and *fast* bear it. The former gains did not: in the study they ended in limit cycles.
#[test]
fn little_damping() {
    for delay in 0..=3 {
        for hub_inertia in [0.5, 1.0, 2.0] {
            for gains in [RootStrainGains::default(), RootStrainGains::fast()] {
                assert!(
                    bears(&gains, 0.025, hub_inertia, delay),
                    "hubs times {hub_inertia}, {delay} ms late: {gains:?}"
                );
            }
        }
    }
    assert!(!bears(&former(), 0.025, 1.0, 2));
}

/// The table of `docs/comparison.md`: the least `c_f` that is enough, by bisection.
/// `cargo test --release -p grasp-control --test requirements -- --ignored --nocapture least_damping`.
#[test]
#[ignore = "prints a table"]
fn least_damping() {
    println!("least c_f in s, commands 0 to 5 ms late");
    let sets =
        [("default", RootStrainGains::default()), ("fast", RootStrainGains::fast()), ("former default", former())];
    for (name, gains) in sets {
        let row = [0, 1, 2, 3, 4, 5].map(|delay| {
            let (mut low, mut high) = (0.0, 0.2);
            for _ in 0..8 {
                let middle = 0.5 * (low + high);
                if bears(&gains, middle, 1.0, delay) { high = middle } else { low = middle }
            }
            format!("{high:.3}")
        });
        println!("| {name} | {} |", row.join(" | "));
    }
}

/// The table of `docs/controllers.md`, Ĵ estimated and held:
/// `cargo test --release -p grasp-control --test requirements -- --ignored --nocapture hub_inertias`.
#[test]
#[ignore = "prints a table"]
fn hub_inertias() {
    let mut held = RootStrainGains::default();
    (held.inertia.smallest, held.inertia.largest) = (1.0, 1.0);
    println!("| inertia, in units of what the law is told | estimated | Ĵ/J | held |\n|--:|--:|--:|--:|");
    for hub_inertia in [0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0] {
        let case = Case { hub_inertia, duration: 5.0, ..Case::default() };
        let cell = |outcome: &Outcome| match outcome.settling() {
            time if time.is_finite() => format!("{time:.2} s, {:.0} %", 100.0 * outcome.overshoot.max(0.0)),
            _ => format!("never, {:.0} %", 100.0 * outcome.overshoot),
        };
        let (ours, held) = (default(&case), run(&case, &held));
        let found = ours.inertia[0] / (0.0073 * hub_inertia);
        println!("| {hub_inertia} | {} | {found:.2} | {} |", cell(&ours), cell(&held));
    }
}

/// In force, no slower than the tuned PD by more than a tenth, for heavy and light objects and long arms. Short arms are lost
/// (`docs/comparison.md`): PD drags the object along with its hubs, and overshoots by a hundred percent.
#[test]
fn no_slower_than_the_tuned_pd() {
    let base = Case { duration: 5.0, ..Case::default() };
    let cases = [0.05, 0.3, 2.0, 5.0, 10.0].map(|object_mass| Case { object_mass, ..base });
    for case in cases.into_iter().chain([0.2, 0.3, 0.4, 0.5].map(|length| Case { length, ..base })) {
        let mut pd = Pd::new(case.arms(), PdGains::tuned(), Limits::default()).unwrap();
        let (ours, pd) = (default(&case), run_law(&case, &mut pd));
        assert!(ours.force <= 1.1 * pd.force, "{case:?}: {ours:?} {pd:?}");
    }
}

/// The figures of `docs/controllers.md`:
/// `cargo test --release -p grasp-control --test requirements -- --ignored --nocapture figures`.
#[test]
#[ignore = "prints a table"]
fn figures() {
    let base = Case { duration: 5.0, ..Case::default() };
    let cases = [
        ("undisturbed", base),
        ("hub torque 0.1", Case { hub_torque: 0.1, ..base }),
        ("object force 0.1", Case { object_force: 0.1, ..base }),
        ("object force -0.1", Case { object_force: -0.1, ..base }),
        ("friction 0.02", Case { friction: 0.02, ..base }),
        ("Dahl friction", Case { dahl: 0.02, ..base }),
        ("raw dead zones", Case { actuator: ActuatorModel::Raw, ..base }),
        ("M 0.05", Case { object_mass: 0.05, ..base }),
        ("M 2", Case { object_mass: 2.0, ..base }),
        ("M 5", Case { object_mass: 5.0, ..base }),
        ("M 10", Case { object_mass: 10.0, ..base }),
        ("l 0.1", Case { length: 0.1, ..base }),
        ("l 0.3", Case { length: 0.3, ..base }),
        ("l 0.4", Case { length: 0.4, ..base }),
        ("l 0.5", Case { length: 0.5, ..base }),
        ("EI/4", Case { stiffness: 0.25, ..base }),
        ("EI x 4", Case { stiffness: 4.0, ..base }),
        ("hubs x 0.25", Case { hub_inertia: 0.25, ..base }),
        ("hubs x 2", Case { hub_inertia: 2.0, ..base }),
        ("hubs x 7", Case { hub_inertia: 7.0, ..base }),
        ("hubs x 14", Case { hub_inertia: 14.0, ..base }),
        ("delay 2 ms", Case { delay: 2, ..base }),
        ("delay 5 ms", Case { delay: 5, ..base }),
        ("encoders", Case { encoders: true, ..base }),
        ("order 12", Case { order: 12, ..base }),
        ("noise", NOISE),
    ];
    for (name, run) in PRESETS {
        println!("{name}");
        for (case_name, case) in cases {
            let o = run(&case);
            println!(
                "  {case_name:18} {:7.3} {:7.3} {:7.3} s, overshoot {:6.2} %, mean {:8.3} rms {:8.3} mN, m {:.2}, J {:.4}",
                o.force,
                o.angles,
                o.position,
                100.0 * o.overshoot,
                1e3 * o.mean_error,
                1e3 * o.rms,
                o.mass,
                o.inertia[0]
            );
        }
        for sway in [0.01, 0.02, 0.04] {
            let masses = [0.05, 0.3, 1.0, 2.0, 5.0, 10.0]
                .map(|object_mass| run(&Case { object_mass, sway, duration: 4.0, ..base }).mass / (object_mass + 0.2));
            println!("  m_hat/m after {sway} rad to and fro: {masses:.2?}");
        }
    }
}

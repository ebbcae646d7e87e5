//! Hubs of unknown inertia, and arms whose roots hardly damp.

use super::*;

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

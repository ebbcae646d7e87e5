//! The sampled laws tend to the laws as differential equations; and those to solutions by other means.

use crate::continuous::integrator::{System, integrate};
use crate::continuous::{self, Loop, cases, paper, pd, pds, root_strain, share};
use grasp_control::References;
use grasp_control::blocks::observer::RateSource;
use grasp_control::continuous::LAYER;
use grasp_control::laws::nabfc::Gains;
use grasp_control::laws::pd::PdGains;
use grasp_control::laws::pds::PdsGains;
use grasp_control::laws::root_strain::RootStrainGains;
use grasp_plant::Parameters;

const NO_LOAD: grasp_plant::Inputs = grasp_plant::Inputs::ZERO;

/// The largest difference of two states in units of their magnitudes.
fn distance(a: &[f64], b: &[f64], scales: &[f64]) -> f64 {
    a.iter().zip(b).zip(scales).fold(0.0, |most, ((a, b), scale)| most.max((a - b).abs() / scale.max(b.abs())))
}

/// Every law, on a way so short that no limit matters: as the step of the sampled loop is halved, its distance from the
/// solution of the differential equations is halved (inputs are held), and extrapolated to zero it is none.
#[test]
fn the_sampled_loop_tends_to_the_equations() {
    let (end, coarsest, levels) = (0.01, 200, 6);
    for index in 0..cases().len() {
        let start = || {
            let parameters = Parameters { order: 4, ..Parameters::default() };
            Loop::new(cases().swap_remove(index), parameters, share(0.01), NO_LOAD)
        };
        let mut system = start();
        let scales = system.scales();
        let (exact, _) = system.run(end, 1e-12);
        let runs: Vec<_> = (0..levels).map(|level| start().sample(end, coarsest << level)).collect();
        let [.., coarse, fine] = &runs[..] else { unreachable!() };
        let ratio = distance(coarse, &exact, &scales) / distance(fine, &exact, &scales);
        // Neville: a series in h.
        let mut rows = runs.clone();
        for column in 1..rows.len() {
            let factor = f64::from(1 << column) - 1.0;
            rows = rows
                .windows(2)
                .map(|pair| pair[1].iter().zip(&pair[0]).map(|(f, c)| f + (f - c) / factor).collect())
                .collect();
        }
        let limit = distance(&rows[0], &exact, &scales);
        println!("{}: ratio {ratio:.4}, limit {limit:.2e}", system.case.name);
        assert!((ratio - 2.0).abs() < 0.05, "{}: {ratio}", system.case.name);
        assert!(limit < 1e-9, "{}: {limit:e}", system.case.name);
    }
}

/// The paper's laws with their own gains, unsaturated and saturated, against a solution with other matrices and laws, written
/// in another language (`tests/oracle/monolith.py`, which `dualarm verify` reads too). The tolerance is 1e-9, or three times what
/// the oracle's two solutions differ by: its forces are of the fastest motion.
#[test]
fn loops_agree_with_the_monolithic_solution() {
    let document: serde_json::Value =
        serde_json::from_str(include_str!("../../dualarm/data/verify/closed_loop.json")).unwrap();
    for (name, solution) in document["cases"].as_object().unwrap() {
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let case = match solution["controller"].as_str().unwrap() {
            "PdController" => pd("pd", PdGains::default(), RateSource::Measured),
            "PdsController" => pds("pds", PdsGains::default(), RateSource::Measured),
            _ => paper("paper", &Gains::default(), RateSource::Measured),
        };
        let mut parameters = Parameters { order: 6, ..Parameters::default() };
        for (setting, value) in solution["settings"].as_object().unwrap() {
            let channels = (&mut parameters.torque_channel, &mut parameters.force_channel);
            *match setting.as_str() {
                "k_M1" => &mut channels.0.k_max,
                "k_m1" => &mut channels.0.k_min,
                "k_M2" => &mut channels.1.k_max,
                "k_m2" => &mut channels.1.k_min,
                other => panic!("{other}"),
            } = number(value);
        }
        let reference =
            References { lambda1_ref: number(&solution["lambda1_ref"]), theta1_ref: number(&solution["theta1_ref"]) };
        let mut system = Loop::new(case, parameters, reference, NO_LOAD);
        let (mut x, mut time) = (system.states(), 0.0);
        // The first two of five times hold the transients and the saturation.
        for row in &solution["at"].as_array().unwrap()[..2] {
            let end = number(&row["t"]);
            integrate(&mut system, &mut x, time, end, 1e-12);
            time = end;
            let inputs = system.put(&x);
            let commands = system.case.law.present_commands(&inputs);
            let contact = system.plant.direct(&system.driven(commands)).contact_force;
            let m = inputs.measured;
            for (output, found) in [
                ("theta1", m.theta[0]),
                ("theta2", m.theta[1]),
                ("y_object", m.y_object),
                ("root_moment1", m.root_moment[0]),
                ("tip_shear1", m.tip_shear[0]),
                ("contact_force1", contact[0]),
                ("contact_force2", contact[1]),
            ] {
                let difference = (found - number(&row[output])).abs();
                let tolerance = 3.0 * number(&solution["error"][output]);
                assert!(difference < tolerance.max(1e-9), "{name} {output} at {end}: {difference:e}");
            }
        }
    }
}

/// The Jacobian of the loop with PD and PDS has the eigenvalues that the dynamic stiffness of the beams gives without any
/// discretisation (`tests/oracle`, unsaturated). 1e-9, absolute below 1/s: rounding of an eigenvalue
/// problem whose largest one is a million times as large.
#[test]
fn the_jacobian_has_the_exact_eigenvalues() {
    let with_pd = [
        (-0.575_784_236_421_5, 0.0),
        (-1.087_654_806_108, 0.0),
        (-1.091_373_110_256, 0.0),
        (-35.952_565_158_46, 0.0),
        (-0.083_947_068_356, 561.340_888_192_2),
        (-86.753_323_903_7, 576.140_665_429_7),
    ];
    let with_pds = [
        (-1.022_864_913_719, 0.0),
        (-3.123_915_537_211, 0.0),
        (-3.449_517_830_929, 0.0),
        (-95.583_728_685_28, 0.0),
        (-1.734_320_429_731, 558.727_469_393_3),
        (-91.692_755_221_6, 564.510_140_039_8),
    ];
    for (case, exact) in [
        (pd("pd", PdGains::default(), RateSource::Measured), with_pd),
        (pds("pds", PdsGains::default(), RateSource::Measured), with_pds),
    ] {
        let parameters = Parameters { order: 12, ..Parameters::default() };
        let mut system = Loop::new(case, parameters, share(0.01), NO_LOAD);
        let found = system.jacobian().complex_eigenvalues();
        for (re, im) in exact {
            let distance = found.iter().map(|z| (z.re - re).hypot(z.im - im)).fold(f64::INFINITY, f64::min);
            assert!(distance < 1e-9 * re.hypot(im).max(1.0), "{} {re} {im}: {distance:e}", system.case.name);
        }
    }
}

/// Integrals that stop while their commands are beyond the limits and would be pushed further; and networks whose learnt force
/// slides along its limit, because forgetting brings it back inside.
#[test]
fn anti_windup_is_the_limit_of_the_sampled_one() {
    let load = grasp_plant::Inputs { hub_disturbance: [2.5, 0.0], ..NO_LOAD };
    // A hub against such a load needs all of its torque: the command slides along the limit.
    let sliding = PdGains { kp_arm: [20.0; 2], ki_arm: [2e4; 2], ..PdGains::pid() };
    for (name, start, end, load) in [
        ("pid", (|| pd("pid", PdGains::pid(), RateSource::Measured)) as fn() -> _, 0.05, NO_LOAD),
        ("sliding", || unreachable!(), 0.03, load),
        ("networks", || root_strain("networks", &continuous::networks(), RateSource::Measured), 0.012, load),
    ] {
        let start = || {
            let case = if name == "sliding" { pd("sliding", sliding, RateSource::Measured) } else { start() };
            Loop::new(case, Parameters { order: 4, ..Parameters::default() }, share(1.0), load)
        };
        let mut system = start();
        let scales = system.scales();
        let (exact, events) = system.run(end, 1e-9);
        // An event falls anywhere within a step, so a single number of steps is right by chance: the worst of three is of first order.
        let [coarse, fine] = [4000, 16_000].map(|steps: u32| {
            let neighbours = (0..3).map(|k| steps + k * steps / 20);
            neighbours.map(|steps| distance(&start().sample(end, steps), &exact, &scales)).fold(0.0, f64::max)
        });
        println!("{name}: {} events, {coarse:e} {fine:e}", events.len());
        if name == "sliding" {
            let inputs = system.put(&exact);
            let torque = system.case.law.present_commands(&inputs).tau[0];
            assert!((torque.abs() - 2.0).abs() <= 2.0 * LAYER, "{torque}");
        }
        assert!(!events.is_empty() && fine < 0.4 * coarse && fine < 1e-2, "{name}: {coarse:e} {fine:e}");
    }
}

/// A disturbance of 3 N·m, half as much again as the motor gives: what is learnt stays at the limit while it lasts, by events and
/// not by chance, and the sampled loop tends to the same.
#[test]
fn limits_hold_what_is_learnt() {
    let load = grasp_plant::Inputs { hub_disturbance: [3.0, 0.0], object_disturbance: 0.5, ..NO_LOAD };
    let end = 0.05;
    for (name, start) in [
        ("observers", (|| root_strain("observers", &RootStrainGains::default(), RateSource::Measured)) as fn() -> _),
        ("estimated", || root_strain("estimated", &RootStrainGains::default(), RateSource::Estimated)),
        ("pid, estimated", || pd("pid, estimated", PdGains::pid(), RateSource::Estimated)),
        ("ball", || paper("ball", &in_ball(), RateSource::Measured)),
    ] {
        let start = || Loop::new(start(), Parameters { order: 4, ..Parameters::default() }, share(1.0), load);
        let mut system = start();
        let scales = system.scales();
        let (exact, events) = system.run(end, 1e-11);
        let held = [system.regimes.disturbance, system.regimes.weights].concat();
        println!("{name}: {} changes, {} events, {held:?}", system.changes, events.len());
        assert!(system.changes > 0, "{name}");
        let [coarse, fine] = [4000, 16_000].map(|steps| distance(&start().sample(end, steps), &exact, &scales));
        println!("{name}: {coarse:e} {fine:e}");
        assert!(fine < 0.4 * coarse && fine < 1e-2, "{name}: {coarse:e} {fine:e}");
    }
}

fn in_ball() -> Gains {
    let mut gains = Gains::default();
    gains.object.w_max = 0.01;
    gains.posture.iter_mut().for_each(|posture| posture.u_max = 0.05);
    gains
}

/// A state far beyond its limit is put back, and stays: the next decision leaves all states alone. In the law of root strains without
/// networks the observed disturbances are such states.
#[test]
fn states_beyond_their_limits_are_put_back_once() {
    let mut put_back = 0;
    for case in cases() {
        let mut system = Loop::new(case, Parameters { order: 4, ..Parameters::default() }, share(0.01), NO_LOAD);
        let mut x = system.states();
        let first = system.plant.state_count();
        for state in &mut x[first..] {
            *state = 1e3;
        }
        let inputs = system.put(&x);
        let (law, mut regimes) = (&mut system.case.law, system.regimes);
        let (decision, again) = (law.decide(&inputs, &mut regimes), law.decide(&inputs, &mut regimes));
        println!("{}: {decision:?}, then {again:?}", system.case.name);
        assert!(!again.states, "{}: {again:?}", system.case.name);
        put_back += usize::from(decision.states);
    }
    assert!(put_back > 0);
}

//! Compares model exchange by a small host in these tests, and the same models in co-simulation with the built-in solver,
//! with exact solutions.

#[path = "../../fmi2-export/tests/common/mod.rs"]
mod common;

#[path = "../examples/bouncing_ball.rs"]
#[allow(missing_docs, dead_code)]
mod models;

use common::{DISCARD, EventInfo, Fmu, MODEL_EXCHANGE, OK, Slave, sizes_of_all_magnitudes};

const BALL: usize = 0;
const VAN_DER_POL: usize = 1;
const STAIRS: usize = 2;
/// Start height and gravity of the ball, its restitution.
const H: f64 = 1.0;
const G: f64 = 9.81;
const E: f64 = 0.7;

fn load() -> Fmu {
    Fmu::load("bouncing_ball")
}

fn guid(model: usize) -> String {
    models::FMUS.models()[model].description().unwrap().guid
}

fn exchange(fmu: &Fmu, model: usize) -> Slave<'_> {
    fmu.instantiate_as(MODEL_EXCHANGE, &guid(model)).unwrap_or_else(|log| panic!("{log:?}"))
}

/// The states after a step of the classical Runge–Kutta method, which is exact for parabolas; time and states are set.
fn runge_kutta(slave: &Slave, time: f64, x: &[f64], h: f64) -> Vec<f64> {
    let n = x.len();
    let rate = |t: f64, x: &[f64]| {
        assert_eq!(slave.set_time(t), OK);
        assert_eq!(slave.set_states(x), OK, "{:?}", slave.log);
        slave.derivatives(n)
    };
    let along = |k: &[f64], h: f64| x.iter().zip(k).map(|(x, k)| x + h * k).collect::<Vec<f64>>();
    let k1 = rate(time, x);
    let k2 = rate(time + h / 2.0, &along(&k1, h / 2.0));
    let k3 = rate(time + h / 2.0, &along(&k2, h / 2.0));
    let k4 = rate(time + h, &along(&k3, h));
    let next: Vec<f64> = (0..n).map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])).collect();
    assert_eq!(slave.set_time(time + h), OK);
    assert_eq!(slave.set_states(&next), OK);
    next
}

/// Lets the ball bounce until a time; the times of the impacts.
fn bounce(slave: &Slave, end: f64) -> Vec<f64> {
    let mut impacts = Vec::new();
    let (mut time, mut x) = (0.0, slave.states(2));
    while time < end {
        let step = |h: f64| {
            let next = runge_kutta(slave, time, &x, h);
            (slave.indicators(1)[0] > 0.0, next)
        };
        let h = 0.01_f64.min(end - time);
        let (above, next) = step(h);
        if above || x[0] <= 0.0 {
            (time, x) = (time + h, next);
            continue;
        }
        let (mut before, mut after) = (0.0, h);
        while after - before > 1e-15 {
            let middle = 0.5 * (before + after);
            if step(middle).0 { before = middle } else { after = middle }
        }
        step(after);
        time += after;
        impacts.push(time);
        assert_eq!(slave.fmu.fmi2EnterEventMode(slave.component), OK);
        let info = slave.update();
        assert_eq!(info, EventInfo { states_changed: 1, ..EventInfo::default() });
        x = slave.states(2);
    }
    impacts
}

/// Time and downward speed of impact number k, from 0.
fn impact(k: i32) -> (f64, f64) {
    let (first, speed) = ((2.0 * H / G).sqrt(), (2.0 * H * G).sqrt());
    let flights: f64 = (1..=k).map(|i| 2.0 * E.powi(i) * speed / G).sum();
    (first + flights, speed * E.powi(k))
}

#[test]
fn the_ball_bounces_where_it_should() {
    let fmu = load();
    let slave = exchange(&fmu, BALL);
    slave.start();
    let impacts = bounce(&slave, 2.0);
    assert_eq!(impacts.len(), 4);
    for (k, time) in (0..).zip(impacts) {
        // Each impact is found to 1 fs; rounding of positions of 1 m at 4 m/s, and of the speeds, adds up.
        assert!((time - impact(k).0).abs() < 1e-13, "{k} {time}");
    }
    let mut bounces = 0;
    assert_eq!(fmu.fmi2GetInteger(slave.component, &0, 1, &mut bounces), OK);
    assert_eq!(bounces, 4);
}

#[test]
fn a_saved_state_of_model_exchange_continues_bit_for_bit_in_another_instance() {
    let fmu = load();
    let (slave, other) = (exchange(&fmu, BALL), exchange(&fmu, BALL));
    slave.start();
    bounce(&slave, 0.75);
    let blob = slave.blob();
    let first: Vec<u64> = bounce(&slave, 0.5).iter().chain(&slave.states(2)).map(|x| x.to_bits()).collect();
    assert_eq!(other.load(&blob), OK);
    let second: Vec<u64> = bounce(&other, 0.5).iter().chain(&other.states(2)).map(|x| x.to_bits()).collect();
    assert_eq!(first, second);
}

#[test]
fn in_co_simulation_the_built_in_solver_finds_the_impacts() {
    let fmu = load();
    let slave = fmu.instantiate(&guid(BALL));
    slave.initialize();
    let bounces = || {
        let mut bounces = 0;
        assert_eq!(fmu.fmi2GetInteger(slave.component, &0, 1, &mut bounces), OK);
        bounces
    };
    for i in 0..13 {
        assert_eq!(slave.step(f64::from(i) * 0.1, 0.1), OK, "{:?}", slave.log);
    }
    assert_eq!(bounces(), 2);
    let (last, speed) = impact(1);
    let (t, v) = (1.3 - last, speed * E);
    // The solver's tolerance is 1e-9, and its steps are exact for parabolas.
    assert!((slave.get(0) - (v * t - 0.5 * G * t * t)).abs() < 1e-10, "{}", slave.get(0));
    assert!((slave.get(1) - (v - G * t)).abs() < 1e-10);
    // All impacts are over within 3 s; the rest is rest.
    assert_eq!(slave.step(1.3, 3.0), OK, "{:?}", slave.log);
    assert_eq!((slave.get(0), slave.get(1)), (0.0, 0.0));
    // It rises e^{2k} metres after k impacts: less than a micrometre after 20.
    assert_eq!(bounces(), 20);
    assert_eq!(slave.step(4.3, 1e6), OK, "nothing happens any more");
}

#[test]
fn the_oscillator_is_the_same_in_both_interfaces_and_has_its_jacobian() {
    let fmu = load();
    let (slave, stepping) = (exchange(&fmu, VAN_DER_POL), fmu.instantiate(&guid(VAN_DER_POL)));
    slave.start();
    stepping.initialize();
    let mut x = slave.states(2);
    for i in 0..2000 {
        x = runge_kutta(&slave, f64::from(i) * 1e-3, &x, 1e-3);
    }
    for i in 0..4 {
        assert_eq!(stepping.step(0.5 * f64::from(i), 0.5), OK);
    }
    for (reference, x) in (0..).zip(&x) {
        // Runge-Kutta: h⁴ = 1e-12 times derivatives of order 10.
        assert!((stepping.get(reference) - x).abs() < 1e-9, "{reference}");
    }
    let mut jacobian = [[f64::NAN; 2]; 2];
    for (known, column) in (0..).zip(&mut jacobian) {
        let (c, unknowns) = (slave.component, [2, 3]);
        let status =
            fmu.fmi2GetDirectionalDerivative(c, unknowns.as_ptr(), 2, &raw const known, 1, &1.0, column.as_mut_ptr());
        assert_eq!(status, OK);
    }
    assert_eq!(jacobian, [[0.0, -2.0 * x[0] * x[1] - 1.0], [1.0, 1.0 - x[0] * x[0]]]);
}

#[test]
fn time_events_come_when_they_were_said_to() {
    let fmu = load();
    let slave = exchange(&fmu, STAIRS);
    slave.initialize();
    let mut info = slave.update();
    let height = |slave: &Slave| {
        let mut y = 0;
        assert_eq!(fmu.fmi2GetInteger(slave.component, &2, 1, &mut y), OK);
        y
    };
    for second in 1..=3 {
        assert_eq!((info.has_next_time, info.next_time), (1, f64::from(second)));
        assert_eq!(slave.set_time(info.next_time), OK);
        assert_eq!(fmu.fmi2EnterEventMode(slave.component), OK);
        if second == 3 {
            assert_eq!(slave.set_integer(0, 10), OK, "inputs that jump do so in event mode");
        }
        info = slave.update();
    }
    assert_eq!(height(&slave), 12);

    let slave = fmu.instantiate(&guid(STAIRS));
    assert_eq!(slave.set_integer(1, 5), OK);
    slave.initialize();
    assert_eq!(slave.step(0.0, 3.5), OK);
    assert_eq!(height(&slave), 3);
    assert_eq!(slave.step(3.5, 0.5), OK);
    assert_eq!(height(&slave), 4, "an event at the end of a step is done");
    assert_eq!(slave.step(4.0, 4.0), DISCARD);
    assert!(slave.message().contains("has ended the simulation at t = 5.0 s"), "{}", slave.message());
}

#[test]
fn the_time_may_go_back_and_a_saved_state_knows_the_next_event() {
    let fmu = load();
    let (slave, other) = (exchange(&fmu, STAIRS), exchange(&fmu, STAIRS));
    slave.initialize();
    slave.update();
    // A solver looks ahead and comes back; an event happens only when the solver reports it.
    for time in [1.5, 0.25, -1.0, 1.0] {
        assert_eq!(slave.set_time(time), OK);
    }
    assert_eq!(fmu.fmi2EnterEventMode(slave.component), OK);
    assert_eq!(slave.update().next_time, 2.0);
    assert_eq!(other.load(&slave.blob()), OK);
    let mut y = 0;
    assert_eq!(fmu.fmi2GetInteger(other.component, &2, 1, &mut y), OK);
    assert_eq!(y, 1);
    assert_eq!(other.set_time(3.0), OK);
    assert_eq!(fmu.fmi2EnterEventMode(other.component), OK);
    let info = other.update();
    assert_eq!((info.next_time, info.states_changed), (4.0, 0), "both events that were due, and no states to change");
}

#[test]
fn the_description_has_what_a_host_needs() {
    let xml = models::FMUS.models()[BALL].description().unwrap().xml;
    for part in [
        "numberOfEventIndicators=\"1\"",
        "<ModelExchange modelIdentifier=\"BouncingBall\" completedIntegratorStepNotNeeded=\"true\" \
         canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\" \
         providesDirectionalDerivative=\"true\"/>",
        "<CoSimulation modelIdentifier=\"BouncingBall\"",
        "<Real unit=\"m/s2\" derivative=\"2\"/>",
    ] {
        assert!(xml.contains(part), "{part} is not in {xml}");
    }
    let structure = xml.split("<ModelStructure>").nth(1).unwrap().split("</ModelStructure>").next().unwrap();
    let structure: Vec<&str> = structure.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let expected = [
        "<Outputs>",
        "<Unknown index=\"1\" dependencies=\"1\"/>",
        "<Unknown index=\"2\" dependencies=\"2\"/>",
        "<Unknown index=\"5\" dependencies=\"\"/>",
        "</Outputs>",
        "<Derivatives>",
        "<Unknown index=\"3\" dependencies=\"2\"/>",
        "<Unknown index=\"4\" dependencies=\"\"/>",
        "</Derivatives>",
        "<InitialUnknowns>",
        "<Unknown index=\"1\"/>",
        "<Unknown index=\"2\"/>",
        "<Unknown index=\"3\"/>",
        "<Unknown index=\"4\"/>",
        "<Unknown index=\"5\"/>",
        "</InitialUnknowns>",
    ];
    assert_eq!(structure, expected);
}

#[test]
fn steps_of_any_size_add_up() {
    let fmu = load();
    for model in [BALL, VAN_DER_POL, STAIRS] {
        let slave = fmu.instantiate(&guid(model));
        slave.initialize();
        let mut time = 0.0;
        for size in sizes_of_all_magnitudes() {
            assert_eq!(slave.step(time, size), OK, "{model}: {size:?} {:?}", slave.log);
            time += size;
        }
    }
}

#[test]
fn what_cannot_be_integrated_is_discarded() {
    let fmu = load();
    // μ = 1000: its period is 1600 s, and an explicit method crawls.
    let slave = fmu.instantiate(&guid(VAN_DER_POL));
    assert_eq!(slave.set(4, 1e3), OK);
    slave.initialize();
    assert_eq!(slave.step(0.0, 1e4), DISCARD);
    let message = slave.message();
    assert!(message.contains("stiff") || message.contains("too many steps"), "{message}");
    // With e = 1 the ball bounces without end, and no bounce is lost.
    let slave = fmu.instantiate(&guid(BALL));
    assert_eq!(slave.set(4, 1.0), OK);
    slave.initialize();
    assert_eq!(slave.step(0.0, 1e4), DISCARD);
    assert!(slave.message().contains("more than 1000 events in one step"), "{}", slave.message());
}

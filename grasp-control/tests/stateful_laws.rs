//! Laws with observers and integrals: derivatives, saved states, extreme inputs, parameters by their names.

#![allow(clippy::float_cmp)]

use crate::common::{grasp_inputs, lively, unequal_arms};
use grasp_control::blocks::observer::RateSource;
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::nabfc::{Nabfc, RbfLayout};
use grasp_control::laws::pds::{Limits, Pds, PdsGains};
use grasp_control::laws::root_strain::{
    HubGains, Learner, MassGains, NetworkGains, ObjectGains, RootStrain, RootStrainGains,
};
use grasp_control::{INPUT_NAMES, INPUTS, Inputs, Law};
use proptest::prelude::*;
use serde::{Serialize, de::DeserializeOwned};

/// Gains that differ from arm to arm and leave nothing at zero.
fn uneven(bandwidth: f64) -> RootStrainGains {
    let mut gains = RootStrainGains::default();
    let hub = &mut gains.hub[1];
    (hub.slope, hub.reach, hub.strain, hub.feedforward, hub.observer) = (20.0, 15.0, 30.0, 0.6, 100.0);
    (gains.object.slope, gains.object.brake, gains.object.observer) = (60.0, 1.3, 60.0);
    gains.strain_rate_bandwidth = bandwidth;
    // Random inputs are far more excitation than a grasp: with the default's weights the mass would change within
    // microseconds, and differences would show nothing.
    (gains.mass.prior, gains.mass.memory) = (0.1, 10.0);
    // A heavy object's surface bends so sharply that differences would have to be finer.
    gains.mass.largest = 2.0;
    gains
}

fn actuation() -> Actuation {
    Actuation { hub_inertia: [0.0073, 0.009], bandwidth: 120.0, ..Actuation::default() }
}

fn root_strain(source: RateSource, bandwidth: f64) -> RootStrain {
    RootStrain::new(unequal_arms(), uneven(bandwidth), actuation(), source, &RbfLayout::default()).unwrap()
}

fn networks() -> RootStrain {
    let gains = RootStrainGains { learner: Learner::Networks, ..uneven(10.0) };
    RootStrain::new(unequal_arms(), gains, actuation(), RateSource::Measured, &RbfLayout::default()).unwrap()
}

fn pid() -> Pds {
    let gains = PdsGains { ki: 200.0, ki_arm: [30.0, 50.0], ..PdsGains::default() };
    Pds::new(unequal_arms(), gains, Limits::default()).unwrap()
}

fn encoders<L: Law>(law: L) -> Encoders<L> {
    Encoders::new(law, RateSource::Estimated, actuation()).unwrap()
}

fn assert_close(actual: f64, expected: f64, what: &str) {
    // As in derivatives.rs: truncation and round-off of differences over 1e-6.
    assert!((actual - expected).abs() < 2e-5 * (1.0 + expected.abs()), "{what}: {actual}, by differences {expected}");
}

/// The Jacobian, and the time derivative of the commands, against differences.
fn assert_derivatives<L: Law + Clone>(mut law: L, history: &[Inputs], inputs: &Inputs, rates: &Inputs) {
    law.initialize(&history[0]);
    for inputs in history {
        law.step(0.01, inputs, &Inputs::HELD).unwrap();
    }
    let jacobian = law.jacobian(inputs);
    let step = 1e-6;
    for column in 0..INPUTS {
        let mut direction = [0.0; INPUTS];
        direction[column] = 1.0;
        let direction = Inputs::from_array(direction);
        let up = law.commands(&inputs.after(step, &direction)).to_array();
        let down = law.commands(&inputs.after(-step, &direction)).to_array();
        for (row, (up, down)) in [&jacobian.tau[0], &jacobian.tau[1], &jacobian.u].iter().zip(up.iter().zip(down)) {
            assert_close(row[column], (up - down) / (2.0 * step), INPUT_NAMES[column]);
        }
    }
    let expected = law.command_rates(inputs, rates).to_array();
    // Estimated inertias change within 1e-7 s at rates as random ones can be; rounding of commands of 1e3 is 2e-5 here. Within the
    // interval an estimate may also come to where γ ≥ 0 begins to hold, a kink. A tenth of the interval then shows the slope before.
    let by_differences = |h: f64| -> [f64; 3] {
        let later = |steps: f64| {
            let mut law = law.clone();
            if steps > 0.0 {
                law.step(steps * h, inputs, rates).unwrap();
            }
            law.commands(&inputs.after(steps * h, rates)).to_array()
        };
        let (c0, c1, c2) = (later(0.0), later(1.0), later(2.0));
        std::array::from_fn(|i| (-3.0 * c0[i] + 4.0 * c1[i] - c2[i]) / (2.0 * h))
    };
    // The second derivatives of observers and filters are up to 1e7; they matter as h² times a third one.
    let close = |actual: f64, expected: f64| (actual - expected).abs() < 1e-4 * (1.0 + expected.abs());
    let (coarse, fine) = (by_differences(3e-8), by_differences(3e-9));
    for i in 0..3 {
        let right = close(coarse[i], expected[i]) || close(fine[i], expected[i]);
        assert!(right, "{i}: {} or {}, {expected:?}", coarse[i], fine[i]);
    }
}

/// The same future from a law, its copy and the one that went through text.
fn assert_state_is_whole<L: Law + Clone + Serialize + DeserializeOwned>(mut law: L, history: &[Inputs]) {
    law.initialize(&history[0]);
    let (first, second) = history.split_at(history.len() / 2);
    for inputs in first {
        law.step(1e-3, inputs, &Inputs::HELD).unwrap();
    }
    let mut restored: L = serde_json::from_str(&serde_json::to_string(&law).unwrap()).unwrap();
    for inputs in second {
        law.step(1e-3, inputs, &Inputs::HELD).unwrap();
        restored.step(1e-3, inputs, &Inputs::HELD).unwrap();
    }
    assert_eq!(law.commands(&history[0]), restored.commands(&history[0]));
}

fn assert_finite<L: Law>(mut law: L, inputs: &Inputs, h: f64) {
    law.initialize(&Inputs::default());
    for _ in 0..3 {
        law.step(h, inputs, &Inputs::HELD).unwrap();
        let commands = law.commands(inputs).to_array();
        assert!(commands.iter().all(|command| command.is_finite()), "{commands:?}");
        let rates = law.command_rates(inputs, &Inputs::HELD).to_array();
        assert!(rates.iter().all(|rate| rate.is_finite()), "{rates:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn derivatives_are_right(
        history in prop::collection::vec(grasp_inputs(), 1..6), inputs in grasp_inputs(), rates in grasp_inputs(),
    ) {
        // The slope of the root-strain law's surface has a kink at p = 0, which differences would smooth.
        prop_assume!(unequal_arms().errors(&inputs).p.abs() > 1e-4);
        for bandwidth in [0.0, 10.0] {
            assert_derivatives(root_strain(RateSource::Measured, bandwidth), &history, &inputs, &rates);
        }
        assert_derivatives(root_strain(RateSource::Estimated, 10.0), &history, &inputs, &rates);
        assert_derivatives(pid(), &history, &inputs, &rates);
        assert_derivatives(encoders(pid()), &history, &inputs, &rates);
    }

    #[test]
    fn states_are_whole(history in prop::collection::vec(grasp_inputs(), 2..6)) {
        assert_state_is_whole(root_strain(RateSource::Measured, 10.0), &history);
        assert_state_is_whole(root_strain(RateSource::Estimated, 10.0), &history);
        assert_state_is_whole(networks(), &history);
        assert_state_is_whole(encoders(pid()), &history);
        assert_state_is_whole(encoders(Nabfc::new(unequal_arms(), lively()).unwrap()), &history);
    }

    /// Every magnitude from 1e-300 to the largest accepted one, every sign, every step.
    #[test]
    fn extreme_inputs_give_finite_commands(
        exponents in prop::array::uniform16(-300.0..49.5_f64), signs in prop::array::uniform16(prop::bool::ANY),
        exponent in -9.0..9.0_f64,
    ) {
        let inputs = Inputs::from_array(std::array::from_fn(|i| {
            let magnitude = 10.0_f64.powf(exponents[i]);
            if signs[i] { magnitude } else { -magnitude }
        }));
        let h = 10.0_f64.powf(exponent);
        assert_finite(root_strain(RateSource::Measured, 10.0), &inputs, h);
        assert_finite(root_strain(RateSource::Estimated, 10.0), &inputs, h);
        assert_finite(networks(), &inputs, h);
        assert_finite(pid(), &inputs, h);
        assert_finite(encoders(pid()), &inputs, h);
    }
}

/// Sliding variables by differences, along inputs and in time.
#[test]
fn surfaces_have_the_right_derivatives() {
    let mut law = root_strain(RateSource::Measured, 10.0);
    let inputs = Inputs::from_array(std::array::from_fn(|i| 0.01 * (i as f64 + 1.0)));
    let rates = Inputs::from_array(std::array::from_fn(|i| 0.3 - 0.05 * i as f64));
    law.initialize(&inputs);
    law.step(0.01, &inputs, &rates).unwrap();
    let array = |law: &RootStrain, inputs: &Inputs| {
        let s = law.surfaces(inputs);
        [s.object, s.posture[0], s.posture[1]]
    };
    let h = 1e-6;
    let along = law.surface_derivative(&inputs, &rates);
    let (up, down) = (array(&law, &inputs.after(h, &rates)), array(&law, &inputs.after(-h, &rates)));
    for (i, expected) in [along.object, along.posture[0], along.posture[1]].into_iter().enumerate() {
        assert_close(expected, (up[i] - down[i]) / (2.0 * h), "s along inputs");
    }
    let in_time = law.surface_rates(&inputs, &rates);
    let (now, mut later) = (array(&law, &inputs), law.clone());
    later.step(1e-7, &inputs, &rates).unwrap();
    let later = array(&later, &inputs.after(1e-7, &rates));
    for (i, expected) in [in_time.object, in_time.posture[0], in_time.posture[1]].into_iter().enumerate() {
        let actual = (later[i] - now[i]) / 1e-7;
        // First order: half a step of second derivatives up to 1e4.
        assert!((actual - expected).abs() < 1e-3 * (1.0 + expected.abs()), "{i}: {actual} {expected}");
    }
}

/// Every parameter is in its table under its own name: setting it out of range names it.
#[test]
fn bad_parameters_are_named() {
    let mut gains = RootStrainGains::default();
    for row in ObjectGains::PARAMETERS {
        *(row.field)(&mut gains.object) = -1.0;
        assert_eq!(gains.validate().unwrap_err().name, row.name);
        gains = RootStrainGains::default();
    }
    for row in HubGains::PARAMETERS {
        *(row.field)(&mut gains.hub[1]) = f64::NAN;
        assert_eq!(gains.validate().unwrap_err().name, row.name.replace("{}", "2"));
        gains = RootStrainGains::default();
    }
    for row in MassGains::PARAMETERS.iter().chain(MassGains::FIXED) {
        *(row.field)(&mut gains.mass) = -1.0;
        assert_eq!(gains.validate().unwrap_err().name, row.name);
        gains = RootStrainGains::default();
    }
    for row in NetworkGains::PARAMETERS {
        *(row.field)(&mut gains.networks) = -1.0;
        assert_eq!(gains.validate().unwrap_err().name, row.name);
        gains = RootStrainGains::default();
    }
    gains.mass.largest = 0.1;
    assert_eq!(gains.validate().unwrap_err().name, "r_mass_max");
    for row in Actuation::PARAMETERS {
        let mut actuation = Actuation::default();
        *(row.field)(&mut actuation) = -1.0;
        assert_eq!(actuation.validate().unwrap_err().name, row.name);
    }
    RootStrainGains::fast().validate().unwrap();
}

/// An integral stands still at the limit and goes on below it.
#[test]
fn integrals_do_not_wind_up() {
    let mut law = pid();
    let mut inputs = Inputs::default();
    inputs.measured.theta = [1.0, 0.0];
    law.initialize(&inputs);
    let before = law.commands(&inputs);
    assert!(before.tau[0] < -2.0);
    for _ in 0..1000 {
        law.step(1e-3, &inputs, &Inputs::HELD).unwrap();
    }
    assert_eq!(law.commands(&inputs).tau[0], before.tau[0]);
}

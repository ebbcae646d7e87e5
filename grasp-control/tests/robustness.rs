//! What must never happen: NaN, panics, state lost or changed by a refused step.

#![allow(clippy::float_cmp)]

use crate::common::{grasp_inputs, lively, unequal_arms};
use grasp_control::Arms;
use grasp_control::Parameter;
use grasp_control::laws::nabfc::{Gains, Nabfc, ObjectGains, PostureGains, RbfLayout};
use grasp_control::{INPUTS, Inputs};
use grasp_control::{Law, StepError};
use proptest::prelude::*;

fn state(law: &Nabfc) -> String {
    serde_json::to_string(law).unwrap()
}

fn all_finite(law: &mut Nabfc, inputs: &Inputs) -> bool {
    let e = law.estimates();
    law.commands(inputs).to_array().iter().all(|x| x.is_finite())
        && [e.m_hat, e.epsilon_hat, e.w_norm, e.j_hat[0], e.pi_hat[1], e.u_norm[0]].iter().all(|x| x.is_finite())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Every magnitude from 1e-300 to the largest accepted one, every sign.
    #[test]
    fn extreme_inputs_give_finite_results(
        exponents in prop::array::uniform16(-300.0..49.5_f64),
        signs in prop::array::uniform16(prop::bool::ANY),
        h in 1e-9..1e3,
    ) {
        let inputs = Inputs::from_array(std::array::from_fn(|i| {
            let magnitude = 10.0_f64.powf(exponents[i]);
            if signs[i] { magnitude } else { -magnitude }
        }));
        for bandwidth in [0.0, 100.0] {
            let mut law = Nabfc::new(unequal_arms(), Gains { shear_rate_bandwidth: bandwidth, ..lively() }).unwrap();
            law.initialize(&Inputs::default());
            for _ in 0..3 {
                law.step(h, &inputs, &Inputs::HELD).unwrap();
                prop_assert!(all_finite(&mut law, &inputs));
                prop_assert!(law.jacobian(&inputs).u.iter().all(|x| x.is_finite()));
            }
        }
    }

    /// A copy, and a copy through serialisation, go on exactly like the original.
    #[test]
    fn copies_continue_alike(history in prop::collection::vec(grasp_inputs(), 2..8)) {
        let gains = Gains { shear_rate_bandwidth: 400.0, ..lively() };
        let mut law = Nabfc::new(unequal_arms(), gains).unwrap();
        law.initialize(&history[0]);
        let (first, second) = history.split_at(history.len() / 2);
        for inputs in first {
            law.step(1e-3, inputs, &Inputs::HELD).unwrap();
        }
        let mut copy = law.clone();
        let mut restored: Nabfc = serde_json::from_str(&state(&law)).unwrap();
        for inputs in second {
            for law in [&mut law, &mut copy, &mut restored] {
                law.step(1e-3, inputs, &Inputs::HELD).unwrap();
            }
        }
        let last = &history[0];
        prop_assert_eq!(law.commands(last), copy.commands(last));
        prop_assert_eq!(law.commands(last), restored.commands(last));
        prop_assert_eq!(state(&law), state(&restored));
    }
}

#[test]
fn refused_steps_change_nothing() {
    let mut law = Nabfc::new(Arms::default(), lively()).unwrap();
    let good = Inputs::from_array([0.01; INPUTS]);
    law.initialize(&good);
    law.step(1e-3, &good, &Inputs::HELD).unwrap();
    let before = state(&law);
    for h in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        assert!(matches!(law.step(h, &good, &Inputs::HELD), Err(StepError::StepSize(_))));
    }
    for bad in [f64::NAN, f64::INFINITY, 1e60] {
        let mut values = [0.0; INPUTS];
        values[8] = bad;
        let bad = Inputs::from_array(values);
        for (inputs, rates) in [(&bad, &Inputs::HELD), (&good, &bad)] {
            let error = law.step(1e-3, inputs, rates).unwrap_err();
            assert!(error.to_string().contains("tip_shear1"), "{error}");
        }
    }
    assert_eq!(state(&law), before);
}

#[test]
fn initialising_again_forgets_everything() {
    let mut law = Nabfc::new(Arms::default(), lively()).unwrap();
    let inputs = Inputs::from_array([0.01; INPUTS]);
    law.initialize(&inputs);
    let fresh = state(&law);
    law.step(0.1, &inputs, &Inputs::HELD).unwrap();
    assert_ne!(state(&law), fresh);
    law.initialize(&inputs);
    assert_eq!(state(&law), fresh);
}

/// Sets each parameter of a table out of its range, in turn: the gains are refused, and the error names it. Returns the
/// names; `number` is the owner's in a family.
fn refused_names<T>(table: &[Parameter<T>], number: &str, owner: fn(&mut Gains, usize) -> &mut T) -> Vec<String> {
    let index = usize::from(number == "2");
    let names = table.iter().map(|parameter| {
        let name = parameter.name.replace("{}", number);
        for bad in [f64::NAN, f64::NEG_INFINITY, -1.0, 1e10] {
            let mut gains = Gains::default();
            *(parameter.field)(owner(&mut gains, index)) = bad;
            let error = gains.validate().unwrap_err();
            assert_eq!(error.name, name);
            assert!(error.to_string().contains(&name));
        }
        name
    });
    names.collect()
}

/// Every parameter is in its table under its own name: setting it out of range names it.
#[test]
fn bad_gains_are_named() {
    let mut names = refused_names(ObjectGains::PARAMETERS, "", |gains, _| &mut gains.object);
    names.extend(refused_names(ObjectGains::FIXED, "", |gains, _| &mut gains.object));
    for number in ["1", "2"] {
        names.extend(refused_names(PostureGains::PARAMETERS, number, |gains, arm| &mut gains.posture[arm]));
        names.extend(refused_names(PostureGains::FIXED, number, |gains, arm| &mut gains.posture[arm]));
    }
    names.extend(refused_names(Gains::PARAMETERS, "", |gains, _| gains));
    names.extend(refused_names(RbfLayout::PARAMETERS, "", |gains, _| &mut gains.rbf));
    let expected = "eta k mu_bar c1 epsilon1 a1 a2 W_max gamma1 gamma2 b1 b2 m_hat_0 \
        xi1 k1 mu1 c31 epsilon21 a31 a41 U1_max zeta11 zeta21 g11 g21 J1_hat_0 \
        xi2 k2 mu2 c32 epsilon22 a32 a42 U2_max zeta12 zeta22 g12 g22 J2_hat_0 sat_limit shear_rate_bandwidth";
    for name in expected.split_whitespace() {
        assert_eq!(names.iter().filter(|n| *n == name).count(), 1, "{name}");
    }
    let mut gains = Gains::default();
    gains.rbf.nodes_posture = 0;
    assert_eq!(gains.validate().unwrap_err().name, "rbf_nodes_posture");
    gains.rbf.nodes_posture = 3;
    gains.rbf.rings_object = 5;
    assert_eq!(gains.validate().unwrap_err().name, "rbf_rings_object");
}

#[test]
fn presets_are_valid() {
    for gains in [Gains::default(), Gains::fast(), Gains::baseline(), Gains::default().without_networks()] {
        gains.validate().unwrap();
    }
}

/// The projection keeps the weights in the ball of Lemma 3, whatever drives them, and lets them back from its surface.
#[test]
fn weights_stay_in_their_ball() {
    let mut gains = Gains::default();
    gains.object.w_max = 0.2;
    gains.posture[0].u_max = 0.3;
    // Hardly any leakage, so that what holds the weights is the projection.
    (gains.object.a2, gains.posture[0].a4, gains.posture[1].a4) = (1e-3, 1e-4, 1e-4);
    let mut law = Nabfc::new(Arms::default(), gains).unwrap();
    let mut values = [0.01; INPUTS];
    let push = Inputs::from_array(values);
    law.initialize(&push);
    for _ in 0..2000 {
        law.step(1e-3, &push, &Inputs::HELD).unwrap();
        let estimates = law.estimates();
        assert!(estimates.w_norm <= 0.2 * (1.0 + 1e-12) && estimates.u_norm[0] <= 0.3 * (1.0 + 1e-12));
    }
    let full = law.estimates();
    assert!(full.u_norm[0] > 0.299 && full.u_norm[1] > full.u_norm[0], "only the bounded network is held: {full:?}");
    assert_eq!(law.estimate_rates(&push).u_norm[0], 0.0);
    // The other way: s = 13 (−0.06 − 0.01) + 0.01 rad/s, a hundred times what has filled the ball.
    values[0] = -0.06;
    let back = Inputs::from_array(values);
    assert!(law.estimate_rates(&back).u_norm[0] < 0.0);
    for _ in 0..10 {
        law.step(1e-3, &back, &Inputs::HELD).unwrap();
    }
    let left = law.estimates().u_norm[0];
    assert!(left < 0.99 * full.u_norm[0], "{left}");
}

//! Analytic derivatives against central differences.

#![allow(clippy::float_cmp)]

use crate::common::{grasp_inputs, lively, unequal_arms};
use grasp_control::Law;
use grasp_control::laws::nabfc::Gains;
use grasp_control::laws::nabfc::Nabfc;
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::laws::pds::{Limits, Pds, PdsGains};
use grasp_control::{INPUT_NAMES, INPUTS, Inputs};
use proptest::prelude::*;

/// Central difference of `f` along input `column`.
fn difference<const N: usize>(inputs: &Inputs, column: usize, mut f: impl FnMut(&Inputs) -> [f64; N]) -> [f64; N] {
    let step = 1e-6;
    let mut direction = [0.0; INPUTS];
    direction[column] = 1.0;
    let direction = Inputs::from_array(direction);
    let (up, down) = (f(&inputs.after(step, &direction)), f(&inputs.after(-step, &direction)));
    std::array::from_fn(|row| (up[row] - down[row]) / (2.0 * step))
}

fn assert_row(actual: f64, expected: f64, what: &str, column: usize) {
    // Truncation ~ step²·f''' with tanh(s/ϵ): slopes of s up to 20, so f''' up to 1e6; round-off ~ 1e-16·|f|/step.
    assert!(
        (actual - expected).abs() < 1e-5 * (1.0 + expected.abs()),
        "∂{what}/∂{}: {actual}, by differences {expected}",
        INPUT_NAMES[column]
    );
}

fn assert_jacobian(law: &mut dyn Law, inputs: &Inputs) {
    let jacobian = law.jacobian(inputs);
    for column in 0..INPUTS {
        let expected = difference(inputs, column, |x| law.commands(x).to_array());
        for (row, name) in [&jacobian.tau[0], &jacobian.tau[1], &jacobian.u].into_iter().zip(["tau1", "tau2", "u"]) {
            let index = ["tau1", "tau2", "u"].iter().position(|n| *n == name).unwrap();
            assert_row(row[column], expected[index], name, column);
        }
    }
}

fn assert_targets_and_errors(law: &mut dyn Law, inputs: &Inputs) {
    let targets = law.arms().target_jacobian();
    let errors = law.arms().error_jacobian();
    for column in 0..INPUTS {
        let expected = difference(inputs, column, |x| {
            let t = law.targets(&x.reference);
            let e = law.errors(x);
            [t.lambda[0], t.lambda[1], t.theta[0], t.theta[1], t.y_object, e.e[0], e.e[1], e.p]
        });
        let rows = [
            targets.lambda[0],
            targets.lambda[1],
            targets.theta[0],
            targets.theta[1],
            targets.y_object,
            errors.e[0],
            errors.e[1],
            errors.p,
        ];
        for (row, expected) in rows.iter().zip(expected) {
            assert_row(row[column], expected, "target or error", column);
        }
    }
}

/// A controller with estimates that have learned something.
fn experienced(gains: &Gains, history: &[Inputs]) -> Nabfc {
    let mut law = Nabfc::new(unequal_arms(), *gains).unwrap();
    law.initialize(&history[0]);
    for inputs in history {
        law.step(0.05, inputs, &Inputs::HELD).unwrap();
    }
    law
}

/// Whether a sliding variable is so near a corner of sat that a difference straddles it.
fn near_a_corner(law: &Nabfc, inputs: &Inputs) -> bool {
    let s = law.surfaces(inputs);
    [s.object, s.posture[0], s.posture[1]].iter().any(|s| (s.abs() - law.gains().sat_limit).abs() < 1e-4)
}

/// Inside the linear range of sat: the same inputs, sat opened wide.
fn unsaturated() -> Gains {
    Gains { sat_limit: 100.0, ..lively() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn nabfc_jacobian(history in prop::collection::vec(grasp_inputs(), 1..5), inputs in grasp_inputs()) {
        for gains in [lively(), unsaturated(), lively().without_networks()] {
            let mut law = experienced(&gains, &history);
            if near_a_corner(&law, &inputs) {
                continue;
            }
            assert_jacobian(&mut law, &inputs);
            assert_targets_and_errors(&mut law, &inputs);
            let surfaces = law.surface_jacobian();
            for column in 0..INPUTS {
                let expected = difference(&inputs, column, |x| {
                    let s = law.surfaces(x);
                    [s.object, s.posture[0], s.posture[1]]
                });
                let actual = [surfaces.object, surfaces.posture[0], surfaces.posture[1]];
                for (row, expected) in actual.iter().zip(expected) {
                    assert_row(row[column], expected, "s", column);
                }
            }
        }
    }

    /// With the low-pass on, the commands do not depend on the measured shear rates.
    #[test]
    fn nabfc_jacobian_with_low_pass(history in prop::collection::vec(grasp_inputs(), 1..5), inputs in grasp_inputs()) {
        let mut law = experienced(&Gains { shear_rate_bandwidth: 300.0, ..lively() }, &history);
        if !near_a_corner(&law, &inputs) {
            assert_jacobian(&mut law, &inputs);
            let jacobian = law.jacobian(&inputs);
            prop_assert_eq!(&jacobian.u[10..12], &[0.0, 0.0]);
        }
    }

    #[test]
    fn pd_and_pds_jacobians(inputs in grasp_inputs()) {
        let arms = unequal_arms();
        assert_jacobian(&mut Pds::new(arms, PdsGains::default(), Limits::default()).unwrap(), &inputs);
        assert_jacobian(&mut Pd::new(arms, PdGains::default(), Limits::default()).unwrap(), &inputs);
    }

    /// The time derivative against what the commands do over a very short step, forwards and second order:
    /// (−3 c(0) + 4 c(h) − c(2h))/2h.
    #[test]
    fn command_rates_follow_the_state(
        history in prop::collection::vec(grasp_inputs(), 1..5), inputs in grasp_inputs(), rates in grasp_inputs(),
        bandwidth in prop::sample::select(vec![0.0, 200.0]),
    ) {
        let h = 1e-6;
        let mut law = experienced(&Gains { shear_rate_bandwidth: bandwidth, ..lively() }, &history);
        if near_a_corner(&law, &inputs) {
            return Ok(());
        }
        let expected = law.command_rates(&inputs, &rates).to_array();
        let later = |steps: f64| {
            let mut law = law.clone();
            if steps > 0.0 {
                law.step(steps * h, &inputs, &rates).unwrap();
            }
            law.commands(&inputs.after(steps * h, &rates)).to_array()
        };
        let (c0, c1, c2) = (later(0.0), later(1.0), later(2.0));
        for i in 0..3 {
            let actual = (-3.0 * c0[i] + 4.0 * c1[i] - c2[i]) / (2.0 * h);
            prop_assert!((actual - expected[i]).abs() < 1e-5 * (1.0 + expected[i].abs()), "{actual} {expected:?}");
        }
    }
}

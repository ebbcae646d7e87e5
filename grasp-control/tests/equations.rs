//! The controllers against the equations of the paper.

#![allow(clippy::float_cmp)]

use crate::common::{Paper, grasp_inputs, lively, unequal_arms};
use grasp_control::Arms;
use grasp_control::Law;
use grasp_control::laws::nabfc::Gains;
use grasp_control::laws::nabfc::Nabfc;
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::laws::pds::{Limits, Pds, PdsGains};
use grasp_control::{Commands, Inputs, Measurements, References};
use proptest::prelude::*;

/// All estimates of the controller in the order of [`Paper::estimates`].
fn estimates(law: &Nabfc) -> Vec<f64> {
    let e = law.estimates();
    let mut all = vec![e.m_hat, e.epsilon_hat];
    all.extend(law.object_weights());
    for arm in 0..2 {
        all.extend([e.j_hat[arm], e.pi_hat[arm]]);
        all.extend(law.posture_weights(arm));
    }
    all
}

fn assert_close(actual: &[f64], expected: &[f64], tolerance: f64, what: &str) {
    assert_eq!(actual.len(), expected.len());
    for (i, (a, b)) in actual.iter().zip(expected).enumerate() {
        assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{what}[{i}]: {a} instead of {b}");
    }
}

/// A controller whose estimates have been moved about by `history`, and the transcription in the same state.
fn with_history(gains: &Gains, history: &[Inputs]) -> (Nabfc, Paper) {
    let arms = unequal_arms();
    let mut law = Nabfc::new(arms, *gains).unwrap();
    law.initialize(&history[0]);
    for inputs in history {
        law.step(0.05, inputs, &Inputs::HELD).unwrap();
    }
    let mut paper = Paper::new(arms, *gains);
    paper.set_estimates(&estimates(&law));
    (law, paper)
}

fn histories() -> impl Strategy<Value = Vec<Inputs>> {
    prop::collection::vec(grasp_inputs(), 1..6)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Round-off: some twenty terms of magnitude up to 1e2, and activations good to 1e-13.
    #[test]
    fn commands_are_the_control_laws(history in histories(), inputs in grasp_inputs()) {
        let (mut law, paper) = with_history(&lively(), &history);
        assert_close(&law.commands(&inputs).to_array(), &paper.commands(&inputs), 1e-12, "command");
        // The evaluation kept from before must not leak into the commands of other inputs.
        let other = inputs.after(1.0, &history[0]);
        assert_close(&law.commands(&other).to_array(), &paper.commands(&other), 1e-12, "command");
        let surfaces = law.surfaces(&inputs);
        let expected = paper.signals(&inputs);
        assert_close(&[surfaces.object], &[expected.s], 1e-13, "s");
        assert_close(&surfaces.posture, &expected.s_i, 1e-13, "s_i");
    }

    /// The held step against 200 Runge–Kutta steps of (37)–(39), (55)–(57): h·aσ ≤ 0.1, so RK4 is at round-off.
    #[test]
    fn a_held_step_solves_the_update_laws(history in histories(), inputs in grasp_inputs(), h in 1e-4..0.05) {
        let (mut law, mut paper) = with_history(&lively(), &history);
        law.step(h, &inputs, &Inputs::HELD).unwrap();
        for _ in 0..200 {
            paper.rk4(h / 200.0, |_| inputs);
        }
        assert_close(&estimates(&law), &paper.estimates(), 1e-12, "estimate");
        assert_close(&law.commands(&inputs).to_array(), &paper.commands(&inputs), 1e-12, "command");
    }

    /// A small step with ramps of realistic rates (full range in 20 ms) against Runge–Kutta. The two-point rule's error
    /// is that of tanh(s/ϵ) and of the Gaussians within a step of 0.1 ms.
    #[test]
    fn a_ramped_step_solves_the_update_laws(
        history in histories(), inputs in grasp_inputs(), ahead in grasp_inputs(),
    ) {
        let h = 1e-4;
        let rates = rates_between(&inputs, &ahead, 0.02);
        let (mut law, mut paper) = with_history(&lively(), &history);
        law.step(h, &inputs, &rates).unwrap();
        for i in 0..20 {
            let start = f64::from(i) * h / 20.0;
            paper.rk4(h / 20.0, |t| inputs.after(start + t, &rates));
        }
        assert_close(&estimates(&law), &paper.estimates(), 1e-9, "estimate");
    }

    /// The low-pass replaces the measured rates by filtered ones everywhere, and nowhere else.
    #[test]
    fn the_low_pass_acts_on_the_shear_rates(history in histories(), inputs in grasp_inputs(), before in grasp_inputs()) {
        let bandwidth = 300.0;
        let (_, mut paper) = with_history(&lively(), &history);
        let gains = Gains { shear_rate_bandwidth: bandwidth, ..lively() };
        let mut law = Nabfc::new(unequal_arms(), gains).unwrap();
        law.initialize(&before);
        paper.set_estimates(&estimates(&law));
        let filtered = |t: f64| {
            let mut filtered = inputs;
            for arm in 0..2 {
                let (x, y) = (inputs.measured.tip_shear_dot[arm], before.measured.tip_shear_dot[arm]);
                filtered.measured.tip_shear_dot[arm] = x + (y - x) * (-bandwidth * t).exp();
            }
            filtered
        };
        assert_close(&law.commands(&inputs).to_array(), &paper.commands(&filtered(0.0)), 1e-12, "command");
        let h = 2e-4;
        law.step(h, &inputs, &Inputs::HELD).unwrap();
        for i in 0..50 {
            let start = f64::from(i) * h / 50.0;
            paper.rk4(h / 50.0, |t| filtered(start + t));
        }
        // ωh = 0.06: the two-point rule is good to (ωh)⁴/4320 = 3e-9 of the forcing's share in the step, here up to 0.2.
        assert_close(&estimates(&law), &paper.estimates(), 1e-8, "estimate");
        assert_close(&law.commands(&inputs).to_array(), &paper.commands(&filtered(h)), 1e-7, "command");
    }

    /// V̇ in (63)–(65) and (45)–(47) with exact parameters, no disturbance and no leakage: all adaptation cancels and
    /// −Λe² − ξ s sat(s) − k s² remains, in the object loop −Λz₁² − z₁Σq''' − η s sat(s) − k s².
    #[test]
    fn lyapunov_functions_decay_as_the_paper_says(history in histories(), inputs in grasp_inputs()) {
        let mut gains = lively();
        (gains.object.a2, gains.object.gamma2, gains.object.b2) = (0.0, 0.0, 0.0);
        for g in &mut gains.posture {
            (g.a4, g.zeta2, g.g2) = (0.0, 0.0, 0.0);
        }
        let (mut law, paper) = with_history(&gains, &history);
        let commands = law.commands(&inputs);
        let (before, before_w) = (law.estimates(), law.object_weights().collect::<Vec<_>>());
        let before_u = [0, 1].map(|arm| law.posture_weights(arm).collect::<Vec<_>>());
        // Without leakage the estimates move linearly within a held step: differences are exact rates.
        law.step(1.0, &inputs, &Inputs::HELD).unwrap();
        let after = law.estimates();
        let weights_part = |before: &[f64], after: Vec<f64>| -> f64 {
            before.iter().zip(after).map(|(b, a)| b * (a - b)).sum()
        };
        let x = paper.signals(&inputs);
        let (m, j) = (0.5, 0.0073);
        let sat = |value: f64| value.clamp(-gains.sat_limit, gains.sat_limit);

        let o = &gains.object;
        let slope = o.mu_bar + o.c1;
        let force = commands.u - (0..2).map(|i| unequal_arms().ei[i] * x.q3[i]).sum::<f64>();
        // (43): ṡ = Λ ż₁ + (v − ΣEI q''')/m + Σ q̇'''
        let m_s_dot = m * slope * x.z1_dot + force + m * (x.q3_dot[0] + x.q3_dot[1]);
        let v_dot = x.z1 * x.z1_dot + x.s * m_s_dot
            - (m - before.m_hat) * (after.m_hat - before.m_hat) / o.b1
            + before.epsilon_hat * (after.epsilon_hat - before.epsilon_hat) / o.gamma1
            + weights_part(&before_w, law.object_weights().collect()) / o.a1;
        let expected = -slope * x.z1 * x.z1 - x.z1 * (x.q3[0] + x.q3[1]) - o.eta * x.s * sat(x.s) - o.k * x.s * x.s;
        // Terms of magnitude up to 1e4 cancel.
        prop_assert!((v_dot - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{v_dot} {expected}");

        for (i, before_u) in before_u.iter().enumerate() {
            let g = &gains.posture[i];
            let (slope, s, e, e_dot) = (g.mu + g.c3, x.s_i[i], x.e[i], x.e_dot[i]);
            // (61): J ṡ = J Λ ė + τ̄ − M(0)
            let j_s_dot = j * slope * e_dot + commands.tau[i] - inputs.measured.root_moment[i];
            let v_dot = e * e_dot + s * j_s_dot
                - (j - before.j_hat[i]) * (after.j_hat[i] - before.j_hat[i]) / g.g1
                + before.pi_hat[i] * (after.pi_hat[i] - before.pi_hat[i]) / g.zeta1
                + weights_part(before_u, law.posture_weights(i).collect()) / g.a3;
            let expected = -slope * e * e - g.xi * s * sat(s) - g.k * s * s;
            prop_assert!((v_dot - expected).abs() < 1e-10 * (1.0 + expected.abs()), "{v_dot} {expected}");
        }
    }

    /// (95)–(98) term by term.
    #[test]
    fn pd_and_pds_are_their_equations(inputs in grasp_inputs()) {
        let arms = unequal_arms();
        let paper = Paper::new(arms, Gains::baseline());
        let x = paper.signals(&inputs);
        let shear: f64 = inputs.measured.tip_shear.iter().sum();
        let moment = inputs.measured.root_moment;
        let pds = Pds::new(arms, PdsGains::default(), Limits::default()).unwrap().commands(&inputs);
        let pd = Pd::new(arms, PdGains::default(), Limits::default()).unwrap().commands(&inputs);
        let expected_pds = [
            -35.0 * x.e[0] - 15.0 * x.e_dot[0] - 10.0 * arms.ei[0] * x.q2_0[0] + moment[0],
            -35.0 * x.e[1] - 15.0 * x.e_dot[1] - 10.0 * arms.ei[1] * x.q2_0[1] + moment[1],
            -40.0 * x.z1 - 35.0 * x.z1_dot + shear,
        ];
        let expected_pd = [
            -60.0 * x.e[0] - 55.0 * x.e_dot[0] + moment[0],
            -60.0 * x.e[1] - 55.0 * x.e_dot[1] + moment[1],
            -10.0 * x.z1 - 9.0 * x.z1_dot + shear,
        ];
        assert_close(&pds.to_array(), &expected_pds, 1e-14, "pds");
        assert_close(&pd.to_array(), &expected_pd, 1e-14, "pd");
    }
}

/// Rates that lead from `a` to `b` in `time`.
fn rates_between(a: &Inputs, b: &Inputs, time: f64) -> Inputs {
    let (a, b) = (a.to_array(), b.to_array());
    Inputs::from_array(std::array::from_fn(|i| (b[i] - a[i]) / time))
}

/// At the static target every law holds the static loads: Mᵢ(0) = −λᵢᵈ l at the hubs, nothing at the object.
#[test]
fn at_the_target_the_commands_are_the_static_loads() {
    let arms = Arms::default();
    let reference = References::default();
    let targets = arms.targets(&reference);
    let moment = [0.1, -0.1];
    let inputs = Inputs {
        measured: Measurements {
            theta: targets.theta,
            y_object: targets.y_object,
            root_moment: moment,
            tip_shear: targets.lambda,
            ..Measurements::default()
        },
        reference,
    };
    let expected = Commands { tau: moment, u: 0.0 };
    let mut laws: [Box<dyn Law>; 4] = [
        Box::new(Nabfc::new(arms, Gains::default()).unwrap()),
        Box::new(Nabfc::new(arms, Gains::fast()).unwrap()),
        Box::new(Pds::new(arms, PdsGains::default(), Limits::default()).unwrap()),
        Box::new(Pd::new(arms, PdGains::default(), Limits::default()).unwrap()),
    ];
    for law in &mut laws {
        law.initialize(&inputs);
        let commands = law.commands(&inputs);
        assert_close(&commands.to_array(), &expected.to_array(), 1e-15, "static load");
        law.step(1.0, &inputs, &Inputs::HELD).unwrap();
        assert_close(&law.commands(&inputs).to_array(), &expected.to_array(), 1e-15, "static load");
    }
}

//! Laws as differential equations: exact products of their Jacobians, and what the sampled laws say of the same rates.

use crate::common::grasp_inputs;
use crate::continuous::{Case, cases, networks, reach, smooth};
use grasp_control::blocks::observer::RateSource;
use grasp_control::continuous::{Continuous, Direction, Regimes, nabfc_state_variables};
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::nabfc::{Estimates, Nabfc, RbfLayout, Surfaces};
use grasp_control::laws::root_strain::{RootStrain, RootStrainGains};
use grasp_control::{Arms, Inputs, Law};
use proptest::prelude::*;

fn flat(surfaces: &Surfaces, estimates: &Estimates) -> Vec<f64> {
    let [s1, s2] = surfaces.posture;
    let Estimates { m_hat, j_hat, epsilon_hat, pi_hat, w_norm, u_norm } = *estimates;
    let mut all = vec![surfaces.object, s1, s2, m_hat, epsilon_hat, w_norm];
    all.extend([j_hat, pi_hat, u_norm].concat());
    all
}

/// Somewhere in the space of states, within what a grasp does; rates are zero where a law does not use a state.
fn states(case: &Case, unit: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; case.states];
    case.law.continuous_states(&mut out);
    for ((out, unit), scale) in out.iter_mut().zip(unit.iter().cycle()).zip(&case.reach) {
        *out += 0.5 * unit * scale;
    }
    out
}

/// A point and a direction of states and inputs, by a law's index.
struct Line {
    x: Vec<f64>,
    dx: Vec<f64>,
    inputs: Inputs,
    change: Inputs,
}

impl Line {
    fn at(&self, t: f64) -> (Vec<f64>, Inputs) {
        (self.x.iter().zip(&self.dx).map(|(x, dx)| x + t * dx).collect(), self.inputs.after(t, &self.change))
    }
}

fn derivatives(case: &mut Case, regimes: &Regimes, (x, inputs): &(Vec<f64>, Inputs)) -> Vec<f64> {
    let mut out = vec![0.0; case.states + 3];
    case.law.set_continuous_states(x).unwrap();
    case.law.derivatives(inputs, regimes, &mut out[..case.states]);
    out[case.states..].copy_from_slice(&case.law.present_commands(inputs).to_array());
    out
}

fn signs(case: &mut Case, regimes: &Regimes, (x, inputs): &(Vec<f64>, Inputs)) -> Vec<bool> {
    let mut out = vec![0.0; case.indicators];
    case.law.set_continuous_states(x).unwrap();
    case.law.event_indicators(inputs, regimes, &mut out);
    out.into_iter().map(|z| z > 0.0).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Differences of fourth order, with steps of 1e-5 of the signals' magnitudes: short beside the 0.2 mm of p within which the
    /// root-strain law's surface bends, and rounding is below 1e-10 of the largest term of a sum.
    #[test]
    fn products_are_differences(
        which in 0..18_usize,
        unit in prop::collection::vec(-1.0..1.0_f64, 67),
        direction in prop::collection::vec(-1.0..1.0_f64, 71),
        inputs in grasp_inputs(),
        change in grasp_inputs(),
        held in any::<bool>(),
    ) {
        let mut case = cases().swap_remove(which);
        case.law.initialize(&inputs);
        let x = states(&case, &unit);
        let dx = direction.iter().cycle().zip(&case.reach).map(|(unit, scale)| unit * scale).collect();
        let line = Line { x, dx, inputs, change };
        let regimes = Regimes { disturbance: [held; 3], weights: [held; 3], bound: [held; 3] };
        let h = 1e-5;
        let points: Vec<_> = [-2.0, -1.0, 1.0, 2.0].map(|t| line.at(t * h)).into_iter().collect();
        let here = signs(&mut case, &regimes, &line.at(0.0));
        prop_assume!(points.iter().all(|point| signs(&mut case, &regimes, point) == here));
        let values: Vec<_> = points.iter().map(|point| derivatives(&mut case, &regimes, point)).collect();
        let now = derivatives(&mut case, &regimes, &line.at(0.0));
        let along = Direction { states: &line.dx, inputs: &line.change };
        let mut exact = vec![0.0; case.states];
        case.law.derivative_change(&line.inputs, &regimes, along, &mut exact);
        exact.extend(case.law.command_change(&line.inputs, along).to_array());
        for (i, exact) in exact.iter().enumerate() {
            let [a, b, c, d] = std::array::from_fn(|point| values[point][i]);
            let difference = (a - 8.0 * b + 8.0 * c - d) / (12.0 * h);
            let size = exact.abs().max(now[i].abs()).max(1.0);
            prop_assert!((difference - exact).abs() < 2e-7 * size, "{} {i}: {difference:e} {exact:e}", case.name);
        }
    }

    /// Sliding variables and estimates, which are outputs too.
    #[test]
    fn changes_of_other_outputs_are_differences(
        unit in prop::collection::vec(-1.0..1.0_f64, 67),
        direction in prop::collection::vec(-1.0..1.0_f64, 71),
        inputs in grasp_inputs(),
        change in grasp_inputs(),
        estimated in any::<bool>(),
        with_networks in any::<bool>(),
    ) {
        let source = if estimated { RateSource::Estimated } else { RateSource::Measured };
        let gains = if with_networks { networks() } else { RootStrainGains::default() };
        let layout = RbfLayout::default();
        let scales: Vec<_> = nabfc_state_variables(&layout).iter().map(reach).collect();
        let dx: Vec<_> = direction.iter().cycle().zip(&scales).map(|(unit, scale)| unit * scale).collect();
        let paper = Nabfc::new(Arms::default(), smooth()).unwrap();
        let mut paper = Encoders::new(paper, source, Actuation::default()).unwrap();
        let mut strain = RootStrain::new(Arms::default(), gains, Actuation::default(), source, &layout).unwrap();
        paper.initialize(&inputs);
        strain.initialize(&inputs);
        let mut start = vec![0.0; dx.len()];
        strain.continuous_states(&mut start);
        let x: Vec<_> = start.iter().zip(unit.iter().cycle()).zip(&scales).map(|((x, u), s)| x + 0.5 * u * s).collect();
        let line = Line { x, dx, inputs, change };
        let mut outputs = |t: f64| {
            let (x, inputs) = line.at(t);
            paper.set_continuous_states(&x).unwrap();
            strain.set_continuous_states(&x).unwrap();
            let mut all = flat(&paper.law().surfaces(&paper.seen(&inputs)), &paper.law().estimates());
            all.extend(flat(&strain.surfaces(&inputs), &strain.estimates()));
            all
        };
        let h = 1e-5;
        let [a, b, c, d, _] = [-2.0, -1.0, 1.0, 2.0, 0.0].map(|t| outputs(t * h));
        let along = Direction { states: &line.dx, inputs: &line.change };
        let seen = paper.seen_change(along);
        let mut exact = flat(
            &paper.law().surface_change(Direction { inputs: &seen, ..along }),
            &paper.law().estimate_change(&line.dx),
        );
        exact.extend(flat(&strain.surface_change(&line.inputs, along), &strain.estimate_change(&line.dx)));
        for (i, exact) in exact.iter().enumerate() {
            let difference = (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h);
            prop_assert!((difference - exact).abs() < 1e-7 * exact.abs().max(1.0), "{i}: {difference:e} {exact:e}");
        }
    }

    /// States come back, whatever they are; a law does not answer to those that it does not use.
    #[test]
    fn states_come_back(which in 0..18_usize, unit in prop::collection::vec(-1.0..1.0_f64, 67), inputs in grasp_inputs()) {
        let mut case = cases().swap_remove(which);
        case.law.initialize(&inputs);
        let x = states(&case, &unit);
        let one = derivatives(&mut case, &Regimes::default(), &(x.clone(), inputs));
        let mut used = vec![0.0; case.states];
        case.law.continuous_states(&mut used);
        for (used, x) in used.iter().zip(&x) {
            prop_assert!(*used == 0.0 || used == x);
        }
        let other = derivatives(&mut case, &Regimes::default(), &(used.clone(), inputs));
        prop_assert_eq!(one, other);
    }
}

#[test]
fn unusable_states_are_refused() {
    for mut case in cases() {
        for bad in [f64::NAN, f64::NEG_INFINITY, 1e51] {
            let mut x = vec![0.0; case.states];
            x[4] = bad;
            let error = case.law.set_continuous_states(&x).unwrap_err();
            assert_eq!(error.index, 4);
        }
    }
}

//! Eigenvalues of the discrete plant against the exact ones.
//!
//! The exact values are roots of the closed-form characteristic equation (each arm's dynamic stiffness in cos, sin, cosh
//! and sinh of βx), computed without any discretisation.

#![allow(clippy::doc_markdown)]

use grasp_plant::nalgebra::{Complex, ComplexField, DMatrix, linalg::balancing::balance_parlett_reinsch};
use grasp_plant::{Parameters, Plant, StateSpace};

fn conservative(order: usize) -> Parameters {
    Parameters { order, root_uncertainty: 0.0, tip_uncertainty: 0.0, ..Parameters::default() }
}

/// Eigenvalues of the plant under g = `feedback` · measured, without those that are zero whatever the feedback: the rigid
/// velocity of the free plant, and the two relations (12) between positions and tip deflections.
fn eigenvalues(parameters: Parameters, feedback: Option<&DMatrix<f64>>) -> (Vec<Complex<f64>>, f64) {
    let length = parameters.length;
    let StateSpace { a, b, c, tip_deflection: tip } = Plant::new(parameters).unwrap().state_space();
    let n = a.nrows() - 3;
    let mut reduced = match feedback {
        // The last energy coordinate is the rigid motion; nothing depends on it and it spans the kernel.
        None => a.view((0, 0), (n - 1, n - 1)).into_owned(),
        Some(feedback) => {
            let closed = a + b * feedback * c;
            // θ_i = (y + w_i(l))/l leaves x and y as independent coordinates.
            let mut coordinates = DMatrix::zeros(n + 3, n + 1);
            coordinates.view_mut((0, 0), (n, n)).fill_with_identity();
            coordinates[(n + 2, n)] = 1.0;
            for arm in 0..2 {
                coordinates[(n + arm, n)] = 1.0 / length;
                for j in 0..n {
                    coordinates[(n + arm, j)] = tip[(arm, j)] / length;
                }
            }
            let all = closed * coordinates;
            DMatrix::from_fn(n + 1, n + 1, |i, j| all[(if i < n { i } else { n + 2 }, j)])
        }
    };
    let norm = reduced.norm();
    balance_parlett_reinsch(&mut reduced);
    (reduced.complex_eigenvalues().iter().copied().collect(), norm)
}

/// Relative distance of `exact` to the nearest computed eigenvalue.
fn mismatch(computed: &[Complex<f64>], exact: Complex<f64>) -> f64 {
    computed.iter().map(|value| (value - exact).modulus()).fold(f64::INFINITY, f64::min) / exact.modulus()
}

/// Columns of `measured` in [`grasp_plant::StateSpace`].
const THETA: usize = 0;
const THETA_DOT: usize = 2;
const Y: usize = 4;
const Y_DOT: usize = 5;
const ROOT_MOMENT: usize = 6;
const TIP_SHEAR: usize = 8;

/// PDS (95)(96); PD (97)(98) is the case `ks` = 0.
fn controller(kp: f64, kv: f64, kpi: f64, kvi: f64, ks: f64) -> DMatrix<f64> {
    let mut feedback = DMatrix::zeros(3, 12);
    for arm in 0..2 {
        feedback[(arm, THETA + arm)] = -kpi;
        feedback[(arm, THETA_DOT + arm)] = -kvi;
        feedback[(arm, ROOT_MOMENT + arm)] = 1.0 - ks;
        feedback[(2, TIP_SHEAR + arm)] = 1.0;
    }
    feedback[(2, Y)] = -kp;
    feedback[(2, Y_DOT)] = -kv;
    feedback
}

const FREE: [f64; 6] = [
    15.363_434_952_660,
    20.188_878_615_560,
    562.784_507_659_1,
    564.265_294_299_7,
    1_822.960_811_734_2,
    1_824.535_403_856_0,
];

fn free_frequencies(order: usize) -> Vec<f64> {
    let (values, _) = eigenvalues(conservative(order), None);
    let mut frequencies: Vec<f64> = values.iter().map(|value| value.im).filter(|im| *im > 0.0).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies
}

#[test]
fn free_frequencies_converge_spectrally() {
    let frequencies = free_frequencies(8);
    for (mode, tolerance) in [1e-6, 1e-6, 1e-6, 1e-6, 1e-4].into_iter().enumerate() {
        assert!((frequencies[mode] / FREE[mode] - 1.0).abs() < tolerance, "order 8: {frequencies:?}");
    }
    let frequencies = free_frequencies(12);
    for mode in 0..5 {
        assert!((frequencies[mode] / FREE[mode] - 1.0).abs() < 1e-9, "order 12: {frequencies:?}");
    }
}

#[test]
fn eigenvalues_with_uncertainties_match_the_exact_ones() {
    let loops = [
        (
            "no control",
            None,
            vec![
                (-11.819_910_654_31, 9.846_575_085_34),
                (-17.332_726_116_47, 0.0),
                (-23.809_157_743_02, 0.0),
                (-15.761_872_350_17, 562.026_862_052_0),
                (-100.901_872_173, 579.751_354_470),
            ],
        ),
        (
            "PD",
            Some(controller(10.0, 9.0, 60.0, 55.0, 0.0)),
            vec![
                (-0.575_784_236_421_5, 0.0),
                (-1.087_654_806_108, 0.0),
                (-1.091_373_110_256, 0.0),
                (-35.952_565_158_46, 0.0),
                (-0.083_947_068_356, 561.340_888_192_2),
                (-86.753_323_903_7, 576.140_665_429_7),
            ],
        ),
        (
            "PDS",
            Some(controller(40.0, 35.0, 35.0, 15.0, 10.0)),
            vec![
                (-1.022_864_913_719, 0.0),
                (-3.123_915_537_211, 0.0),
                (-3.449_517_830_929, 0.0),
                (-95.583_728_685_28, 0.0),
                (-1.734_320_429_731, 558.727_469_393_3),
                (-91.692_755_221_6, 564.510_140_039_8),
            ],
        ),
    ];
    for (name, feedback, exact) in loops {
        let parameters = Parameters { order: 12, ..Parameters::default() };
        let (values, _) = eigenvalues(parameters, feedback.as_ref());
        for (re, im) in exact {
            let error = mismatch(&values, Complex::new(re, im));
            println!("{name} {re} {im}: {error:.1e}");
            assert!(error < 1e-6, "{name} {re} ± {im} i: {error:e}");
        }
        assert!(values.iter().all(|value| value.re < 0.0), "{name} is stable");
    }
}

/// PD without uncertainties leaves an antisymmetric vibration undamped, contrary to the paper's (77).
#[test]
fn pd_does_not_damp_the_antisymmetric_vibration() {
    let (values, _) = eigenvalues(conservative(12), Some(&controller(10.0, 9.0, 60.0, 55.0, 0.0)));
    let nearest = values.iter().min_by(|l, r| (l.im - 562.504_3).abs().total_cmp(&(r.im - 562.504_3).abs())).unwrap();
    assert!((nearest.im - 562.504_3).abs() < 1e-4 && nearest.re.abs() < 1e-7, "{nearest}");
}

/// The exact plant is passive, and so is the discrete one: no eigenvalue in the right half plane at any order.
#[test]
fn no_order_has_a_growing_mode() {
    for order in 4..=24 {
        let mut worst = [0.0f64; 4];
        for (case, (uncertain, kelvin_voigt)) in
            [(false, 0.0), (true, 0.0), (false, 1e-4), (true, 1e-4)].into_iter().enumerate()
        {
            let base = if uncertain { Parameters { order, ..Parameters::default() } } else { conservative(order) };
            let (values, norm) = eigenvalues(Parameters { kelvin_voigt, ..base }, None);
            let growth = values.iter().map(|value| value.re).fold(f64::NEG_INFINITY, f64::max);
            worst[case] = growth;
            // The QR algorithm is backward stable: eigenvalues err by the rounding unit times the norm. Undamped modes
            // have a real part of zero, so theirs is that error.
            let tolerance = 1e-15 * norm;
            assert!(growth < tolerance, "order {order} case {case}: {growth:e} above {tolerance:e}");
            if uncertain {
                assert!(growth < -10.0, "order {order}: the slowest mode decays with 11.8 1/s, not {growth}");
            }
        }
        println!("{order} {worst:?}");
    }
}

use super::super::assembly::Assembly;
use super::*;
use crate::parameters::{ContactModel, Parameters};

fn modes(parameters: &Parameters) -> Vec<Mode> {
    let assembly = Assembly::new(parameters);
    let relaxes = |touching| touching != [true; 2] && parameters.contact_model == ContactModel::Compliant;
    [[false, false], [true, false], [false, true], [true, true]]
        .map(|touching| Mode::new(touching, assembly.layout, assembly.mode(touching), false, relaxes(touching)))
        .into()
}

/// exp(𝒜t) by scaling and doubling of 𝒜 itself: knows no pieces, no series of signals, and nothing of what is stiff.
fn exponential(mode: &Mode, duration: f64) -> DMatrix<f64> {
    let (mut part, mut doublings) = (duration, 0);
    while part * crate::exponential::one_norm(&mode.matrix) > 0.5 {
        part *= 0.5;
        doublings += 1;
    }
    let mut increment = exp_m1(&(&mode.matrix * part));
    for _ in 0..doublings {
        increment = doubled(&increment);
    }
    increment
}

/// The series of each watched signal is that of the exact motion, over pieces and over shorter times, and so are the increments.
#[test]
fn series_and_increments_are_those_of_the_motion() {
    for (model, order, uncertain) in [
        (ContactModel::Unilateral, 8, true),
        (ContactModel::Compliant, 8, true),
        (ContactModel::Unilateral, 15, true),
        (ContactModel::Unilateral, 8, false),
    ] {
        let mut parameters = Parameters { contact_model: model, order, ..Parameters::default() };
        if !uncertain {
            (parameters.root_uncertainty, parameters.tip_uncertainty) = (0.0, 0.0);
        }
        for mode in modes(&parameters) {
            let stiff = uncertain && mode.touching == [true; 2];
            assert_eq!(mode.stiff.is_some(), stiff, "{model:?} {order} {:?}", mode.touching);
            let layout = mode.layout;
            let drive: Vec<f64> = (0..layout.drive()).map(|i| (1.0 + i as f64).sin()).collect();
            let mut start = vec![0.0; layout.extended()];
            start[..layout.size()].copy_from_slice(&drive[..layout.size()]);
            start[layout.force()..].copy_from_slice(&drive[layout.size()..]);
            let mut motions = Vec::new();
            for piece in mode.ladder() {
                motions.push((piece.duration, Motion::none()));
                piece.motion(&drive, &mut motions.last_mut().unwrap().1);
            }
            for duration in [0.77, 0.01, 1e-6].map(|share| share * mode.base) {
                let (mut of_piece, mut short) = (Motion::none(), Motion::none());
                mode.piece(duration).motion(&drive, &mut of_piece);
                mode.short(duration, &drive, &mut short);
                motions.extend([(duration, of_piece), (duration, short)]);
            }
            for (duration, motion) in motions {
                for node in [0.0, 0.013, 0.37, 0.77, 1.0] {
                    let moved = exponential(&mode, node * duration) * DVector::from_column_slice(&start);
                    for side in 0..2 {
                        let read = |z: &[f64]| dot(mode.watched[side].as_slice(), z);
                        let exact = read(&start) + read(moved.as_slice());
                        let found = motion.watched[side].value_and_slope(node).0;
                        let scale = mode.sizes[side] * (layout.drive() as f64).sqrt();
                        let error = (found - exact).abs() / scale;
                        assert!(error < 1e-13, "{model:?} {order} {:?} {duration:e} {node}: {error:e}", mode.touching);
                    }
                    if node == 1.0 {
                        let increments = &motion.increment.as_flattened()[..layout.increments()];
                        for (row, increment) in increments.iter().enumerate() {
                            let error = (moved[row] - increment).abs();
                            assert!(error < 1e-11, "{row} {increment} {error:e}");
                        }
                    }
                }
            }
        }
    }
}

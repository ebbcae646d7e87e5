//! Refusals, and extreme but legal parameters and step sizes.

#![allow(clippy::doc_markdown)]

use grasp_plant::{ActuatorModel, Arm, Inputs, LONGEST_STEP, Parameters, Plant, Start, State, StateError, StepError};

const PUSH: Inputs = Inputs { torque_command: [1.0, -1.0], force_command: 0.2, ..Inputs::ZERO };

#[test]
fn refused_steps_change_nothing() {
    let mut plant = Plant::new(Parameters::default()).unwrap();
    plant.step(1e-3, &PUSH, &Inputs::ZERO).unwrap();
    let before = plant.state().clone();
    let measured = plant.measured();
    for h in [0.0, -0.0, -1e-3, f64::NAN, f64::INFINITY] {
        assert!(matches!(plant.step(h, &PUSH, &Inputs::ZERO), Err(StepError::NotPositive { .. })));
    }
    let longest = plant.longest_step();
    assert_eq!(plant.step(2.0 * longest, &PUSH, &Inputs::ZERO), Err(StepError::TooLong { h: 2.0 * longest, longest }));
    for bad in [f64::NAN, f64::INFINITY] {
        let inputs = Inputs { object_disturbance: bad, ..PUSH };
        assert_eq!(plant.step(1e-3, &inputs, &Inputs::ZERO), Err(StepError::InputNotFinite));
        assert_eq!(plant.step(1e-3, &PUSH, &inputs), Err(StepError::InputNotFinite));
    }
    let huge = Inputs { object_disturbance: f64::MAX, ..PUSH };
    assert_eq!(plant.step(100.0, &huge, &Inputs::ZERO), Err(StepError::Overflow));
    assert_eq!(plant.step(100.0, &PUSH, &huge), Err(StepError::Overflow));
    let kinked = Inputs { torque_command: [1.0, 0.0], ..huge };
    assert_eq!(plant.step(100.0, &PUSH, &kinked), Err(StepError::Overflow));
    assert_eq!((plant.state(), plant.measured()), (&before, measured));
    plant.step(1e-3, &PUSH, &Inputs::ZERO).unwrap();
}

/// A step that is made leaves outputs that are finite, whatever finite inputs it had: energies are squares of the state.
#[test]
fn every_output_is_finite_or_the_step_is_refused() {
    let set: [fn(&mut Inputs, f64); 6] = [
        |inputs, value| inputs.torque_command[0] = value,
        |inputs, value| inputs.torque_command[1] = -value,
        |inputs, value| inputs.force_command = value,
        |inputs, value| inputs.hub_disturbance[0] = value,
        |inputs, value| inputs.hub_disturbance[1] = -value,
        |inputs, value| inputs.object_disturbance = value,
    ];
    let (mut made, mut refused) = (0, 0);
    for actuator_model in [ActuatorModel::Ideal, ActuatorModel::Compensated, ActuatorModel::Raw] {
        for magnitude in [1.0, 1e50, 1e99, 1e103, 1e120, 1e150, 1e154, 1e200, 1e307, f64::MAX] {
            for (set, h) in set.iter().flat_map(|set| [1e-9, 1e-4, 0.1, 3.0].map(|h| (set, h))) {
                for ramp in [false, true] {
                    let (mut inputs, mut rates) = (Inputs::ZERO, Inputs::ZERO);
                    set(if ramp { &mut rates } else { &mut inputs }, magnitude);
                    let mut plant = Plant::new(Parameters { actuator_model, ..Parameters::default() }).unwrap();
                    for _ in 0..3 {
                        if plant.step(h, &inputs, &rates).is_err() {
                            refused += 1;
                            break;
                        }
                        made += 1;
                        let (direct, rates) = (plant.direct(&inputs), plant.rates(&inputs, &rates));
                        let text = format!(
                            "{:?} {direct:?} {rates:?} {:?} {:?} {} {}",
                            plant.measured(),
                            plant.uncertainty(),
                            plant.deflection(),
                            plant.energy(),
                            plant.supplied_energy()
                        );
                        assert!(!text.contains("inf") && !text.contains("NaN"), "{magnitude:e} {h}: {text}");
                    }
                }
            }
        }
    }
    assert!(made > 100 && refused > 100, "{made} {refused}");
}

#[test]
fn foreign_states_are_refused() {
    let mut plant = Plant::new(Parameters::default()).unwrap();
    let mut other = Plant::new(Parameters { order: 9, ..Parameters::default() }).unwrap();
    assert_eq!(plant.set_state(other.state()), Err(StateError::Length { found: 37, expected: 33 }));
    let spoiled = State { position: [0.0, f64::NAN, 0.0], ..plant.state().clone() };
    assert_eq!(plant.set_state(&spoiled), Err(StateError::NotFinite));
    // Modal coordinates of as many motions, but not of the same ones.
    let mut unequal =
        Plant::new(Parameters { arms: [Arm::default(), Arm { ei: 0.2, ..Arm::default() }], ..Parameters::default() })
            .unwrap();
    unequal.step(1e-3, &PUSH, &Inputs::ZERO).unwrap();
    plant.step(1e-3, &PUSH, &Inputs::ZERO).unwrap();
    assert_eq!(plant.state().coordinates.len(), unequal.state().coordinates.len());
    assert_eq!(plant.set_state(unequal.state()), Err(StateError::NotModal));
    assert_eq!(unequal.set_state(plant.state()), Err(StateError::NotModal));
    other.step(1e-3, &PUSH, &Inputs::ZERO).unwrap();
    other.reset();
    assert_eq!(other.state(), Plant::new(other.parameters().clone()).unwrap().state());
}

/// EI over six decades, tip masses down to 1e-6 kg, all at the highest order, with every kind of dissipation.
#[test]
fn extreme_plants_stay_finite() {
    for (ei, tip_mass, kelvin_voigt, order) in [
        (1e-4, 0.1, 0.0, 24),
        (1e2, 0.1, 0.0, 24),
        (0.115, 1e-6, 0.0, 24),
        (1e2, 1e-6, 1e-3, 24),
        (1e-4, 1e-6, 1.0, 24),
        (1e2, 1e-6, 1.0, 4),
    ] {
        let arms = [Arm { ei, tip_mass, ..Arm::default() }, Arm { tip_mass: 1e-6, ..Arm::default() }];
        for uncertain in [0.0, 1.0] {
            let parameters = Parameters {
                arms,
                order,
                kelvin_voigt,
                object_mass: 1e-6,
                root_uncertainty: 0.1 * uncertain,
                tip_uncertainty: 0.05 * uncertain,
                ..Parameters::default()
            };
            let mut plant = Plant::new(parameters).unwrap();
            for h in [1e-12, 1e-6, 1e-4, 1e-2, 1.0].map(|h: f64| h.min(plant.longest_part())) {
                for _ in 0..20 {
                    let result = plant.step(h, &PUSH, &Inputs { force_command: 0.1 / h, ..Inputs::ZERO });
                    assert_eq!(result, Ok(()), "EI {ei} m {tip_mass} kappa {kelvin_voigt} uncertain {uncertain} h {h}");
                }
            }
            println!(
                "EI {ei} m {tip_mass} kappa {kelvin_voigt} uncertain {uncertain}: energy {:.2e} J, longest {:.1e} s, phi {:.1e}",
                plant.energy(),
                plant.longest_part(),
                plant.constraint()[0]
            );
            assert!(plant.energy() < 1e9);
        }
    }
}

/// Sizes that never come twice are stepped without matrices. That is as exact: the end is the one that equal steps reach, up to
/// the rounding of a thousand steps. And it is decided by the state: a run that goes on from a saved state has the same bits.
#[test]
fn sizes_that_never_repeat_are_exact_and_their_bits_depend_on_the_state_alone() {
    let rates = Inputs { torque_command: [3.0, -2.0], ..Inputs::ZERO };
    for (rates, start) in [(Inputs::ZERO, 0.2), (rates, 0.2), (rates, 0.0)] {
        let at = |time: f64| {
            let mut inputs = Inputs { force_command: start, ..PUSH };
            inputs.torque_command.iter_mut().zip(rates.torque_command).for_each(|(value, rate)| *value += rate * time);
            inputs
        };
        let mut plant = Plant::new(Parameters::default()).unwrap();
        let mut equal = plant.clone();
        let (mut time, mut restored) = (0.0, None::<Plant>);
        for i in 0..1000 {
            // Between 50 and 150 µs, all different.
            let h = 1e-4 * (1.0 + 0.5 * (f64::from(i) * 0.7).sin()) + 1e-12 * f64::from(i);
            plant.step(h, &at(time), &rates).unwrap();
            if let Some(restored) = &mut restored {
                restored.step(h, &at(time), &rates).unwrap();
                assert_eq!(restored.state(), plant.state());
            } else if i == 500 {
                let mut made_anew = Plant::new(Parameters::default()).unwrap();
                made_anew.set_state(plant.state()).unwrap();
                restored = Some(made_anew);
            }
            time += h;
        }
        let h = time / 1000.0;
        for i in 0..1000 {
            equal.step(h, &at(h * f64::from(i)), &rates).unwrap();
        }
        // ‖𝒜‖ h rounding units a step, for a thousand steps, of a motion of 0.1: some 1e-14 each.
        let (one, other) = (plant.measured(), equal.measured());
        for (one, other) in one.theta.iter().chain([&one.y_object]).zip(other.theta.iter().chain([&other.y_object])) {
            assert!((one - other).abs() < 1e-12, "{one} and {other} differ by {:e}", one - other);
        }
        let balance = plant.energy() - plant.supplied_energy();
        let expected = equal.energy() - equal.supplied_energy();
        assert!((balance - expected).abs() < 1e-12, "{balance:e} and {expected:e}");
        assert!(plant.constraint().iter().all(|gap| gap.abs() < 1e-15));
    }
}

/// A plant so stiff that the default step is too long for one piece: the step is as exact as the same one done in parts.
#[test]
fn a_step_too_long_for_one_piece_is_done_in_parts() {
    let arm = Arm { ei: 100.0, tip_mass: 1e-6, ..Arm::default() };
    let parameters = Parameters { arms: [arm; 2], object_mass: 1e-6, order: 24, ..Parameters::default() };
    let mut whole = Plant::new(parameters).unwrap();
    let h = 2.5 * whole.longest_part();
    let mut parts = whole.clone();
    let rates = Inputs { torque_command: [3.0, -2.0], ..Inputs::ZERO };
    whole.step(h, &PUSH, &rates).unwrap();
    for i in 0..3 {
        let time = h / 3.0 * f64::from(i);
        let mut inputs = PUSH;
        inputs.torque_command[0] += rates.torque_command[0] * time;
        inputs.torque_command[1] += rates.torque_command[1] * time;
        parts.step(h / 3.0, &inputs, &rates).unwrap();
    }
    assert_eq!(whole.state(), parts.state());
}

#[test]
fn the_longest_step_is_stable_at_every_order() {
    for order in 4..=24 {
        for conservative in [true, false] {
            let mut parameters = Parameters { order, ..Parameters::default() };
            parameters.start = Start { theta: [0.1, -0.1], ..Start::default() };
            if conservative {
                (parameters.root_uncertainty, parameters.tip_uncertainty) = (0.0, 0.0);
            }
            let mut plant = Plant::new(parameters).unwrap();
            assert_eq!(plant.longest_part().to_bits(), LONGEST_STEP.to_bits());
            let before = plant.energy();
            for _ in 0..1000 {
                plant.step(LONGEST_STEP, &Inputs::ZERO, &Inputs::ZERO).unwrap();
            }
            let ratio = plant.energy() / before;
            if conservative {
                assert!((ratio - 1.0).abs() < 1e-11, "order {order}: {ratio}");
            } else {
                assert!(ratio < 1.0, "order {order}: {ratio}");
            }
        }
    }
}

/// A decaying motion ends in zeros, not in subnormal numbers.
#[test]
fn decay_ends_in_zeros() {
    let mut plant = Plant::new(Parameters { kelvin_voigt: 1e-3, ..Parameters::default() }).unwrap();
    let squeeze = Inputs { torque_command: [0.1, -0.1], ..Inputs::ZERO };
    plant.step(0.01, &squeeze, &Inputs::ZERO).unwrap();
    for _ in 0..1000 {
        plant.step(0.1, &Inputs::ZERO, &Inputs::ZERO).unwrap();
        assert!(plant.state().coordinates.iter().all(|x| *x == 0.0 || x.is_normal()));
    }
}

//! A grasp that can open as differential equations: the same switches and motion as its exact steps, in every mode the derivatives of
//! what it says, and contacts that are brought up to date wherever a solver leaves them.

#![allow(clippy::doc_markdown)]

use crate::equations::{derivatives, flat, outputs, states};
use crate::integrator::{System, integrate};
use grasp_plant::{ContactModel, ContactState, Face, Inputs, Parameters, Plant, Start, StateError};

const MODELS: [ContactModel; 2] = [ContactModel::Unilateral, ContactModel::Compliant];
const INPUTS: Inputs = Inputs {
    torque_command: [0.35, -0.3],
    force_command: 0.05,
    hub_disturbance: [0.01, -0.02],
    object_disturbance: 0.03,
};

fn contact(plant: &Plant) -> ContactState {
    *plant.state().contact.as_deref().unwrap()
}

/// Where the clearances begin among the states.
fn clearances(plant: &Plant) -> usize {
    plant.state_count() - Plant::CONTACT_STATES
}

/// Tips that come from both sides: they bounce, stay and are torn off, press faces in and leave them.
fn coming() -> [Parameters; 3] {
    let start = Start { theta: [-5e-4, 1e-3], theta_dot: [0.2, -0.3], ..Start::default() };
    let faces = [Face { stiffness: 2e4, damping: 5.0 }; 2];
    [(ContactModel::Unilateral, 0.3), (ContactModel::Unilateral, 0.0), (ContactModel::Compliant, 0.0)].map(
        |(contact_model, restitution)| Parameters {
            contact_model,
            restitution,
            start,
            faces,
            order: 4,
            ..Parameters::default()
        },
    )
}

struct Solved {
    plant: Plant,
    inputs: Inputs,
}

impl System for Solved {
    fn rates(&mut self, _: f64, x: &[f64], out: &mut [f64]) {
        self.plant.set_continuous_states(x).unwrap();
        self.plant.derivatives(&self.inputs, out);
    }

    fn scales(&self) -> Vec<f64> {
        let grasp = Plant::state_variables(self.plant.parameters().order).into_iter().map(|state| state.nominal);
        grasp.chain([0.01, 0.01, 0.1, 0.1, 1e-3, 1e-3, 1e-3]).collect()
    }

    fn indicators(&mut self, _: f64, x: &[f64]) -> Vec<f64> {
        self.plant.set_continuous_states(x).unwrap();
        let mut out = vec![0.0; Plant::EVENT_INDICATORS];
        self.plant.event_indicators(&self.inputs, &mut out);
        out.split_off(Plant::EVENT_INDICATORS - 2)
    }

    fn event(&mut self, _: f64, x: &mut [f64]) {
        self.plant.set_continuous_states(x).unwrap();
        self.plant.update_contacts(&self.inputs);
        assert!(!self.plant.update_contacts(&self.inputs), "there is more to do at once");
        self.plant.continuous_states(x);
    }
}

/// Integrated with located events to 2e-13 of the scales, 25 ms of impacts, bounces and openings are those of the exact step, each at its
/// time to a tenth of a nanosecond: the switches of the exact motion are counted on both sides of it.
#[test]
fn integrated_derivatives_are_the_exact_steps_through_switches() {
    let (mut impacts, mut openings) = (0, 0);
    for parameters in coming() {
        let contact_model = parameters.contact_model;
        let mut system = Solved { plant: Plant::new(parameters.clone()).unwrap(), inputs: INPUTS };
        system.plant.update_contacts(&INPUTS);
        let (mut x, end) = (states(&system.plant), 0.025);
        let events = integrate(&mut system, &mut x, 0.0, end, 2e-13);
        system.plant.set_continuous_states(&x).unwrap();
        let exact = |time: f64| {
            let mut plant = Plant::new(parameters.clone()).unwrap();
            plant.step(time, &INPUTS, &Inputs::ZERO).unwrap();
            plant
        };
        let (found, expected) = (&system.plant, exact(end));
        let count = |plant: &Plant| contact(plant).impacts.iter().chain(&contact(plant).openings).sum::<u32>();
        println!("{contact_model:?}: {events:?} {:?}", contact(found));
        assert_eq!(contact(found).impacts, contact(&expected).impacts);
        assert_eq!(contact(found).openings, contact(&expected).openings);
        impacts += contact(found).impacts.iter().sum::<u32>();
        openings += contact(found).openings.iter().sum::<u32>();
        for time in &events {
            // A signal that comes back through zero is an event of no consequence.
            let (before, after) = (exact(time - 1e-10), exact(time + 1e-10));
            let switched = count(&after) > count(&before) || contact(&after).impacts != contact(&before).impacts;
            assert!(switched || contact(&before).touching == contact(&after).touching, "{time}");
        }
        let switches = events.iter().filter(|time| count(&exact(**time + 1e-10)) > count(&exact(**time - 1e-10)));
        assert!(switches.count() >= 2);
        for (x, exact) in x.iter().zip(states(&expected)) {
            assert!((x - exact).abs() < 1e-10, "{contact_model:?} {x} {exact}");
        }
        let (a, b) = (found.measured(), expected.measured());
        for i in 0..2 {
            assert!((a.theta[i] - b.theta[i]).abs() < 1e-10);
        }
        assert!((found.contact().loss - expected.contact().loss).abs() < 1e-10 && found.contact().loss > 0.0);
    }
    assert!(impacts >= 7 && openings >= 3, "{impacts} {openings}");
}

/// One plant in each of the four modes, moving, with faces that are pressed in or relaxing.
fn in_each_mode(contact_model: ContactModel) -> Vec<Plant> {
    let mut plants = Vec::new();
    for theta in [[-0.02, 0.02], [0.01, 0.02], [-0.02, -0.01], [0.01, -0.01]] {
        let start = Start { theta, theta_dot: [0.3, -0.2], y_object_dot: 0.02, ..Start::default() };
        let faces = [Face { stiffness: 500.0, damping: 20.0 }, Face::default()];
        let parameters = Parameters { contact_model, start, faces, ..Parameters::default() };
        let mut plant = Plant::new(parameters).unwrap();
        plant.step(1e-4, &INPUTS, &Inputs::ZERO).unwrap();
        let mut x = states(&plant);
        let first = clearances(&plant);
        x.iter_mut().enumerate().for_each(|(i, x)| *x += 0.02 * (1.7 * i as f64).sin());
        // Open gaps, and free faces that still relax.
        (x[first], x[first + 1]) = (x[first].abs() + 1e-3, x[first + 1].abs() + 1e-3);
        if contact_model == ContactModel::Compliant {
            let touching = contact(&plant).touching;
            (0..2).filter(|i| touching[*i]).for_each(|i| x[first + i] *= -0.1);
        }
        (x[first + 4], x[first + 5]) = (3e-4, 2e-4);
        plant.set_continuous_states(&x).unwrap();
        plants.push(plant);
    }
    let modes: Vec<_> = plants.iter().map(|plant| contact(plant).touching).collect();
    assert_eq!(modes, [[false, false], [true, false], [false, true], [true, true]]);
    plants
}

/// Everything is at most quadratic in states and inputs, so central differences are exact up to rounding: in each mode, along
/// directions in all states, also those that a mode does not have.
#[test]
fn changes_are_differences_in_each_mode() {
    for (contact_model, plant) in MODELS.into_iter().flat_map(|m| in_each_mode(m).into_iter().map(move |p| (m, p))) {
        let touching = contact(&plant).touching;
        for seed in 1..8 {
            let wave = |i: usize| (f64::from(seed) * 1.3 + 2.1 * i as f64).sin();
            let n = plant.state_count();
            let direction: Vec<f64> = (0..n).map(|i| if i < n - 7 { 0.1 } else { 0.01 } * wave(i)).collect();
            let change = Inputs {
                torque_command: [wave(50), wave(51)],
                force_command: wave(52),
                hub_disturbance: [wave(53), wave(54)],
                object_disturbance: wave(55),
            };
            let mut exact = vec![0.0; n];
            plant.derivative_change(&INPUTS, &direction, &change, &mut exact);
            let exact_outputs = flat(&plant.output_change(&INPUTS, &direction, &change));
            // Short enough to keep every contact's force positive and every gap open.
            let step = 1e-5;
            let at = |sign: f64| {
                let mut moved = plant.clone();
                let x: Vec<f64> = states(&plant).iter().zip(&direction).map(|(x, dx)| x + sign * step * dx).collect();
                moved.set_continuous_states(&x).unwrap();
                let [a, b, c] = [change.torque_command[0], change.torque_command[1], change.force_command];
                let inputs = Inputs {
                    torque_command: [0.35 + sign * step * a, -0.3 + sign * step * b],
                    force_command: 0.05 + sign * step * c,
                    hub_disturbance: [
                        0.01 + sign * step * change.hub_disturbance[0],
                        -0.02 + sign * step * change.hub_disturbance[1],
                    ],
                    object_disturbance: 0.03 + sign * step * change.object_disturbance,
                };
                (derivatives(&moved, &inputs), outputs(&moved, &inputs))
            };
            let (forward, backward) = (at(1.0), at(-1.0));
            let largest = derivatives(&plant, &INPUTS).iter().fold(1.0, |most: f64, rate| most.max(rate.abs()));
            for (i, ((plus, minus), exact)) in forward.0.iter().zip(&backward.0).zip(&exact).enumerate() {
                let difference = (plus - minus) / (2.0 * step);
                let scale = 1e-9 * largest.max(exact.abs());
                assert!(
                    (difference - exact).abs() < scale,
                    "{contact_model:?} {touching:?} {i}: {difference:e} {exact:e}"
                );
            }
            let size = outputs(&plant, &INPUTS).iter().fold(1.0, |most: f64, value| most.max(value.abs()));
            for (i, ((plus, minus), exact)) in forward.1.iter().zip(&backward.1).zip(&exact_outputs).enumerate() {
                let difference = (plus - minus) / (2.0 * step);
                let scale = 1e-9 * size.max(exact.abs());
                assert!(
                    (difference - exact).abs() < scale,
                    "{contact_model:?} {touching:?} {i}: {difference:e} {exact:e}"
                );
            }
        }
    }
}

/// The time derivative of every output is its change along the states' derivatives, in each mode.
#[test]
fn outputs_move_with_the_states() {
    let ramps = Inputs { torque_command: [3.0, 2.0], object_disturbance: 0.7, ..Inputs::ZERO };
    for plant in MODELS.into_iter().flat_map(in_each_mode) {
        // Forces that push, so that the mode of what is read is that of the motion.
        if plant.contact_is_due(&INPUTS) {
            continue;
        }
        let change = flat(&plant.output_change(&INPUTS, &derivatives(&plant, &INPUTS), &ramps));
        for (change, rate) in change.iter().zip(flat(&plant.rates(&INPUTS, &ramps))) {
            assert!((change - rate).abs() <= 1e-11 * (1.0 + rate.abs()), "{change:e} {rate:e}");
        }
    }
}

/// States that are read come back when they are set, and what a mode does not have is not felt: it is read as nothing, its derivatives are
/// zero, and no other derivative depends on it.
#[test]
fn what_a_mode_does_not_have_is_not_felt() {
    for (contact_model, mut plant) in MODELS.into_iter().flat_map(|m| in_each_mode(m).into_iter().map(move |p| (m, p)))
    {
        let touching = contact(&plant).touching;
        let (good, first) = (states(&plant), clearances(&plant));
        plant.set_continuous_states(&good).unwrap();
        let rates = derivatives(&plant, &INPUTS);
        for (again, x) in states(&plant).iter().zip(&good) {
            assert!((again - x).abs() < 1e-15);
        }
        assert!(
            plant
                .constraint()
                .iter()
                .zip(contact(&plant).clearance)
                .zip([-1.0, 1.0])
                .all(|((constraint, clearance), sign)| (constraint - sign * clearance).abs() < 1e-16)
        );
        for side in 0..2 {
            let idle = match (contact_model, touching[side]) {
                (ContactModel::Compliant, true) => vec![first + 4 + side],
                (ContactModel::Compliant, false) => vec![],
                (_, true) => vec![first + side, first + 2 + side, first + 4 + side],
                (_, false) => vec![first + 4 + side],
            };
            for place in idle {
                let mut off = good.clone();
                off[place] += 0.3;
                plant.set_continuous_states(&off).unwrap();
                assert_eq!(derivatives(&plant, &INPUTS), rates, "{contact_model:?} {touching:?} {place}");
                if contact_model == ContactModel::Unilateral {
                    assert_eq!((states(&plant)[place], rates[place]), (0.0, 0.0));
                }
            }
        }
        let held = plant.state().clone();
        for place in [0, 20, 33, 34, first, first + 2, first + 4, first + 6] {
            for bad in [f64::NAN, f64::INFINITY, 1e200] {
                let mut off = good.clone();
                off[place] = bad;
                assert_eq!(plant.set_continuous_states(&off), Err(StateError::NotFinite), "{bad:e} at {place}");
            }
        }
        assert_eq!(*plant.state(), held);
    }
}

/// A sequence of numbers in (−1, 1) that looks random.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Wherever a solver leaves them, deep inside the object or pulled from it, by small and by large forces: once brought up to date there is
/// nothing more to do and nothing due, no rigid side approaches that is closed, no energy is made and all that goes is booked, and of the states
/// only clearances, rates and losses have jumped.
#[test]
fn contacts_are_brought_up_to_date_from_anywhere() {
    let mut seed = 7;
    for contact_model in MODELS {
        // Each of these plants serves for fifty cases: to make one takes most of a millisecond, all that is looked at here 20 µs.
        let plants = (0..60).map(|number| {
            let restitution = [0.0, 0.5, 1.0][number % 3];
            let mut parameters = Parameters { contact_model, restitution, order: 4, ..Parameters::default() };
            if number % 2 == 0 {
                parameters.faces[0].damping = 0.0;
            }
            parameters.start.theta = [1e-3 * random(&mut seed), 1e-3 * random(&mut seed)];
            let plant = Plant::new(parameters).unwrap();
            (plant.state().clone(), plant)
        });
        let mut plants: Vec<_> = plants.collect();
        let mut switches = 0;
        for case in 0..3000 {
            let (start, plant) = &mut plants[case % 60];
            plant.set_state(start).unwrap();
            let first = clearances(plant);
            let depth = 10f64.powf(-8.0 + 6.0 * random(&mut seed).abs());
            let mut x = states(plant);
            for (i, x) in x.iter_mut().enumerate().filter(|(i, _)| *i != first - 1) {
                *x += random(&mut seed) * if i < first { 0.1 } else { depth };
            }
            // Faces are pressed in, if anything.
            (x[first + 4], x[first + 5]) = (x[first + 4].abs(), x[first + 5].abs());
            plant.set_continuous_states(&x).unwrap();
            let inputs = Inputs {
                object_disturbance: random(&mut seed),
                torque_command: [random(&mut seed), random(&mut seed)],
                ..Inputs::ZERO
            };
            let (before, energy, loss) = (states(plant), plant.energy(), plant.contact().loss);
            let changed = plant.update_contacts(&inputs);
            switches += usize::from(changed);
            let after = states(plant);
            assert!(!plant.contact_is_due(&inputs) && !plant.update_contacts(&inputs), "{contact_model:?} {case}");
            assert_eq!(states(plant), after);
            for (i, (before, after)) in before.iter().zip(&after).enumerate().take(first) {
                assert!((before - after).abs() < 1e-14, "{i}: {before} {after}");
            }
            let now = contact(plant);
            if contact_model == ContactModel::Unilateral {
                let gone = energy - plant.energy();
                let booked = plant.contact().loss - loss;
                assert!((gone - booked).abs() < 1e-13 && booked > -1e-14, "{gone} {booked}");
            } else {
                assert!(plant.energy() <= energy + 1e-15, "{case}");
            }
            let force = plant.direct(&inputs).contact_force;
            for side in 0..2 {
                let gap = plant.contact().gap[side];
                assert!(gap * force[side] == 0.0 && gap >= 0.0 && force[side] >= 0.0, "{case} {gap} {force:?}");
                // What is deep inside is on its way out.
                let closed = now.touching[side] || after[first + side] + after[first + 4 + side] >= -1e-8;
                let opens = derivatives(plant, &inputs)[first + side] + derivatives(plant, &inputs)[first + 4 + side];
                // But for what is slower than any bounce.
                assert!(closed || opens >= -1e-10 - 1e-14, "{case} {side} {opens}");
            }
        }
        assert!(switches > 500, "{switches}");
    }
}

//! Two equal arms: what they do alike and what they do against each other are motions of their own.

use grasp_plant::{Inputs, Measured, Parameters, Plant};

/// Of which groups of modes are whole, and incomplete.
const ORDERS: [usize; 6] = [4, 6, 8, 13, 21, 24];

/// All that is measured, by arm, and the object's position and velocity.
fn by_arm(m: &Measured) -> ([[f64; 5]; 2], [f64; 2]) {
    let arm = |i: usize| [m.theta[i], m.theta_dot[i], m.root_moment[i], m.tip_shear[i], m.tip_shear_dot[i]];
    ([arm(0), arm(1)], [m.y_object, m.y_object_dot])
}

fn plants(orders: &[usize]) -> impl Iterator<Item = Plant> {
    orders.iter().flat_map(|order| {
        let order = *order;
        let certain = Parameters { order, root_uncertainty: 0.0, tip_uncertainty: 0.0, ..Parameters::default() };
        [Parameters { order, ..Parameters::default() }, certain].map(|parameters| Plant::new(parameters).unwrap())
    })
}

/// Held and ramped torques in turn, of a few sizes of steps.
fn drive(plant: &mut Plant, i: u32, sign: f64, force: f64) {
    let torque = 0.3 * f64::from(i * i % 11) - 1.0;
    let inputs = Inputs { torque_command: [torque, sign * torque], force_command: force, ..Inputs::ZERO };
    let slope = if i % 5 == 4 { 3.0 } else { 0.0 };
    let rates = Inputs { torque_command: [slope, sign * slope], ..Inputs::ZERO };
    plant.step([1e-4, 1e-4, 1e-3][i as usize % 3], &inputs, &rates).unwrap();
}

/// By symmetry the arms move as one, to the bit, also where they push the object.
#[test]
fn arms_that_are_driven_alike_move_alike() {
    for mut plant in plants(&ORDERS) {
        for i in 0..200 {
            drive(&mut plant, i, 1.0, 0.1);
            let ([first, second], _) = by_arm(&plant.measured());
            assert_eq!(
                first.map(f64::to_bits),
                second.map(f64::to_bits),
                "order {}, step {i}",
                plant.parameters().order
            );
        }
        assert!(plant.measured().theta[0] != 0.0);
    }
}

/// By symmetry the object stays where it is, to the bit, and each arm does the opposite of the other.
#[test]
fn arms_that_are_driven_against_each_other_leave_the_object_at_rest() {
    for mut plant in plants(&ORDERS) {
        for i in 0..200 {
            drive(&mut plant, i, -1.0, 0.0);
            let ([first, second], object) = by_arm(&plant.measured());
            let order = plant.parameters().order;
            assert_eq!(object, [plant.parameters().start.y_object, 0.0], "order {order}, step {i}");
            assert_eq!(first, second.map(|number| -number), "order {order}, step {i}");
        }
        assert!(plant.measured().theta[0] != 0.0);
    }
}

/// Arms that differ by a billionth, which are stepped in another way, move nearly as equal ones do.
#[test]
fn equal_arms_move_as_nearly_equal_ones() {
    for equal in plants(&[4, 6, 8]) {
        let mut parameters = equal.parameters().clone();
        parameters.arms[1].ei *= 1.0 + 1e-9;
        let mut nearly = Plant::new(parameters).unwrap();
        let mut equal = equal;
        let mut largest = ([0.0f64; 5], [0.0f64; 2]);
        let mut differences = largest;
        for i in 0..500 {
            let inputs = Inputs {
                torque_command: [0.5, -0.1 * f64::from(i % 7)],
                force_command: 0.2,
                hub_disturbance: [0.0, 0.05],
                object_disturbance: 0.1,
            };
            for plant in [&mut equal, &mut nearly] {
                plant.step(2e-4, &inputs, &Inputs::ZERO).unwrap();
            }
            let ((arms, object), (other_arms, other_object)) = (by_arm(&equal.measured()), by_arm(&nearly.measured()));
            for arm in 0..2 {
                for (s, value) in arms[arm].iter().enumerate() {
                    largest.0[s] = largest.0[s].max(value.abs());
                    differences.0[s] = differences.0[s].max((value - other_arms[arm][s]).abs());
                }
            }
            for s in 0..2 {
                largest.1[s] = largest.1[s].max(object[s].abs());
                differences.1[s] = differences.1[s].max((object[s] - other_object[s]).abs());
            }
        }
        let order = equal.parameters().order;
        let pairs = largest.0.iter().chain(&largest.1).zip(differences.0.iter().chain(&differences.1));
        for (s, (size, difference)) in pairs.enumerate() {
            assert!(difference > &0.0 || s == 5, "order {order}: the arms have not been told apart");
            // The highest frequency, of order 8 some 1.5e5 rad/s, has turned by 1.5e4 rad, and differs by half a billionth.
            assert!(*difference < 1e-5 * size, "order {order}, {s}: {difference:e} of {size:e}");
        }
    }
}

//! The longest stable sampling steps of PD and PDS, from the spectral radius of the sampled loop.
//!
//! Runs do not show them: near its limit the 562 rad/s mode of the beams grows by a few percent a second.

use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::laws::pds::{Limits, Pds, PdsGains};
use grasp_control::{Arms, Inputs, Law, Measurements};
use grasp_plant::{ActuatorModel, Basis, Parameters, Plant, State};
use nalgebra::DMatrix;

/// Coordinates of the plant, its three positions, and the three commands that are on their way.
fn advance(plant: &mut Plant, law: &mut dyn Law, h: f64, late: bool, state: &[f64]) -> Vec<f64> {
    let (coordinates, rest) = state.split_at(state.len() - 6);
    let mut inner = State { basis: Basis::Energy, coordinates: coordinates.into(), ..plant.state().clone() };
    inner.position.copy_from_slice(&rest[..3]);
    inner.carry = [0.0; 3];
    plant.set_state(&inner).unwrap();
    let m = plant.measured();
    let inputs = Inputs {
        measured: Measurements {
            theta: m.theta,
            theta_dot: m.theta_dot,
            y_object: m.y_object,
            y_object_dot: m.y_object_dot,
            root_moment: m.root_moment,
            tip_shear: m.tip_shear,
            tip_shear_dot: m.tip_shear_dot,
            ..Measurements::default()
        },
        ..Inputs::default()
    };
    let fresh = law.commands(&inputs).to_array();
    let acting = if late { [rest[3], rest[4], rest[5]] } else { fresh };
    let driven = grasp_plant::Inputs {
        torque_command: [acting[0], acting[1]],
        force_command: acting[2],
        ..grasp_plant::Inputs::ZERO
    };
    plant.step(h, &driven, &grasp_plant::Inputs::ZERO).unwrap();
    let position = plant.state().position;
    plant.energy_coordinates().into_iter().chain(position).chain(fresh).collect()
}

/// The largest magnitude of the eigenvalues of one step, without the two of the invariants of (12), which are 1.
fn radius(law: &mut dyn Law, h: f64, late: bool) -> f64 {
    let parameters = Parameters { actuator_model: ActuatorModel::Ideal, ..Parameters::default() };
    let mut plant = Plant::new(parameters).unwrap();
    let size = plant.energy_coordinates().len() + 6;
    // The loop is affine: columns are differences from where zero goes.
    let offset = advance(&mut plant, law, h, late, &vec![0.0; size]);
    let mut matrix = DMatrix::zeros(size, size);
    for column in 0..size {
        let mut unit = vec![0.0; size];
        unit[column] = 1.0;
        for (row, value) in advance(&mut plant, law, h, late, &unit).into_iter().enumerate() {
            matrix[(row, column)] = value - offset[row];
        }
    }
    let eigenvalues = matrix.complex_eigenvalues();
    eigenvalues.iter().filter(|z| (z.re - 1.0).hypot(z.im) > 1e-7).map(|z| z.re.hypot(z.im)).fold(0.0, f64::max)
}

/// The limits of README.md: stable just below, unstable just above.
#[test]
fn longest_steps_of_the_papers_gains() {
    let arms = Arms::default();
    let pd = || -> Box<dyn Law> { Box::new(Pd::new(arms, PdGains::default(), Limits::default()).unwrap()) };
    let pds = || -> Box<dyn Law> { Box::new(Pds::new(arms, PdsGains::default(), Limits::default()).unwrap()) };
    let loops = [
        (pd(), false, 0.260e-3, 0.275e-3),
        (pd(), true, 0.0890e-3, 0.0900e-3),
        (pds(), false, 0.970e-3, 0.995e-3),
        (pds(), true, 0.390e-3, 0.402e-3),
    ];
    for (mut law, late, stable, unstable) in loops {
        let (below, above) = (radius(&mut *law, stable, late), radius(&mut *law, unstable, late));
        assert!(below < 1.0 && above > 1.0, "late {late}: {stable} s {below:.9}, {unstable} s {above:.9}");
    }
}

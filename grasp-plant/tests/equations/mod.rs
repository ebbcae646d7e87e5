//! A plant as differential equations, as tests look at it: states, their derivatives, and all outputs in one list.

use grasp_plant::{Contact, Inputs, Plant, Rates};

pub fn states(plant: &Plant) -> Vec<f64> {
    let mut states = vec![0.0; plant.state_count()];
    plant.continuous_states(&mut states);
    states
}

pub fn derivatives(plant: &Plant, inputs: &Inputs) -> Vec<f64> {
    let mut out = vec![0.0; plant.state_count()];
    plant.derivatives(inputs, &mut out);
    out
}

/// All outputs as one list.
pub fn flat(rates: &Rates) -> Vec<f64> {
    let m = &rates.measured;
    let mut all = [m.theta, m.theta_dot, m.root_moment, m.tip_shear, m.tip_shear_dot].concat();
    all.extend([m.y_object, m.y_object_dot, rates.energy, rates.supplied_energy, rates.direct.force]);
    all.extend([rates.direct.torque, rates.direct.lambda, rates.direct.contact_force].concat());
    all.extend(rates.uncertainty.delta_f.iter().chain(&rates.uncertainty.root_moment_dot));
    all.push(rates.uncertainty.delta_force);
    all.extend(rates.deflection.as_flattened().iter().chain(&rates.tip_deflection).chain(&rates.constraint));
    let Contact { gap, indentation, loss } = rates.contact;
    all.extend(gap.iter().chain(&indentation).chain([&loss]));
    all
}

/// The outputs themselves, in the same order.
pub fn outputs(plant: &Plant, inputs: &Inputs) -> Vec<f64> {
    flat(&Rates {
        measured: plant.measured(),
        direct: plant.direct(inputs),
        uncertainty: plant.uncertainty(),
        deflection: plant.deflection(),
        tip_deflection: plant.tip_deflection(),
        constraint: plant.constraint(),
        energy: plant.energy(),
        supplied_energy: plant.supplied_energy(),
        contact: plant.contact(),
    })
}

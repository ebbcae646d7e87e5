//! The loop of plant and controller in one Rust program, without FMI: `cargo run --release -p grasp-control --example closed_loop`.

use grasp_control::laws::nabfc::{Gains, Nabfc};
use grasp_control::{Arms, Inputs, Law, Measurements, References};
use grasp_plant::{Measured, Parameters, Plant};

/// What the plant measures, as the controller reads it: the names and units are the same.
fn read(plant: &Plant) -> Measurements {
    let Measured { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot } = plant.measured();
    let root_moment_dot = plant.uncertainty().root_moment_dot;
    Measurements { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot, root_moment_dot }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut plant = Plant::new(Parameters::default())?;
    let mut law = Nabfc::new(Arms::default(), Gains::default())?;
    let step = 1e-4; // s
    let mut seen = Inputs { measured: read(&plant), reference: References::default() };
    law.initialize(&seen);
    for i in 0..=5000_u32 {
        let commands = law.commands(&seen);
        let inputs =
            grasp_plant::Inputs { torque_command: commands.tau, force_command: commands.u, ..Default::default() };
        if i.is_multiple_of(500) {
            let [first, second] = plant.direct(&inputs).contact_force;
            println!("t = {:.2} s: the tips press with {first:.4} N and {second:.4} N", f64::from(i) * step);
        }
        law.step(step, &seen, &Inputs::HELD)?;
        plant.step(step, &inputs, &grasp_plant::Inputs::ZERO)?;
        seen.measured = read(&plant);
    }
    Ok(())
}

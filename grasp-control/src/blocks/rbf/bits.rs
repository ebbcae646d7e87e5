//! The same bits on every processor, in the loop that the networks learn in.

use crate::blocks::observer::RateSource;
use crate::laws::encoders::Actuation;
use crate::laws::nabfc::{Gains, Nabfc, RbfLayout};
use crate::laws::root_strain::{Learner, RootStrain, RootStrainGains};
use crate::{Arms, Inputs, Law, Measurements, References};
use grasp_kernel::narrowly;
use grasp_plant::{Measured, Parameters, Plant};
use serde::Serialize;

const STEP: f64 = 1e-3;

fn read(plant: &Plant) -> Measurements {
    let Measured { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot } = plant.measured();
    let root_moment_dot = plant.uncertainty().root_moment_dot;
    Measurements { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot, root_moment_dot }
}

/// Commands, plant and law (weights included) over 200 steps together.
fn run(mut law: impl Law + Serialize) -> (Vec<u64>, String) {
    let mut plant = Plant::new(Parameters::default()).unwrap();
    let mut seen = Inputs { measured: read(&plant), reference: References::default() };
    law.initialize(&seen);
    let mut numbers = Vec::new();
    for _ in 0..200 {
        let commands = law.commands(&seen);
        let inputs = grasp_plant::Inputs {
            torque_command: commands.tau,
            force_command: commands.u,
            ..grasp_plant::Inputs::ZERO
        };
        law.step(STEP, &seen, &Inputs::HELD).unwrap();
        plant.step(STEP, &inputs, &grasp_plant::Inputs::ZERO).unwrap();
        seen.measured = read(&plant);
        numbers.extend(commands.to_array());
        numbers.extend(&plant.state().coordinates);
    }
    // The text format keeps every bit.
    (numbers.into_iter().map(f64::to_bits).collect(), serde_json::to_string(&law).unwrap())
}

/// What the plant's own test shows for its matrices, for the networks; together: the whole loop.
#[test]
fn whole_loops_are_the_same_bits_without_wide_registers() {
    for gains in [Gains::default(), Gains::fast()] {
        let law = || Nabfc::new(Arms::default(), gains).unwrap();
        assert!(run(law()) == narrowly(|| run(law())), "{gains:?}");
    }
}

/// As above, for the default law, whatever learns and wherever rates come from.
#[test]
fn whole_loops_of_the_default_law_are_the_same_bits_without_wide_registers() {
    for learner in [Learner::Observer, Learner::Networks] {
        let gains = RootStrainGains { learner, ..RootStrainGains::default() };
        for source in [RateSource::Measured, RateSource::Estimated] {
            let (arms, actuation, layout) = (Arms::default(), Actuation::default(), RbfLayout::default());
            let law = || RootStrain::new(arms, gains, actuation, source, &layout).unwrap();
            assert!(run(law()) == narrowly(|| run(law())), "{learner:?}, {source:?}");
        }
    }
}

//! An FMU of one's own: dry friction in both hubs, after Dahl.
//!
//! ```sh
//! cargo run --release -p hub-friction --features package      # writes dist/HubFriction.fmu
//! cargo run --release -- simulate dist/DualArmPlant.fmu dist/NabfcController.fmu dist/HubFriction.fmu -o friction.csv
//! ```
//!
//! Its inputs have the names of the plant's outputs, its outputs those of the plant's disturbance inputs, so every tool
//! that wires by equal names puts it into the loop.
//!
//! The friction torque F follows the hub's speed v by Ḟ = σ (v − |v| F/C): a spring of stiffness σ for small motions, the
//! Coulomb torque ±C in sliding (P. Dahl, *A solid friction model*, The Aerospace Corporation, TOR-0158(3107-18)-1, 1968).

use fmi2_export::{Experiment, Failure, Model, Step};

/// Dry friction in both hubs of the dual-arm plant (Dahl's model)
#[fmi2_export::model(stop_time = 2.0, step_size = 1e-4)]
pub struct HubFriction {
    /// Angular velocity of hub {}
    #[input(name = "theta{}_dot", unit = "rad/s")]
    speed: [f64; 2],
    /// Friction torque on hub {}
    #[output(name = "delta_f{}", unit = "N.m")]
    torque: [f64; 2],
    /// Friction torque in sliding
    #[parameter(unit = "N.m", start = 0.03, min = 1e-6, max = 1e3)]
    coulomb: f64,
    /// Stiffness before sliding
    #[parameter(unit = "N.m/rad", start = 30.0, min = 1e-6, max = 1e6)]
    stiffness: f64,
    /// Friction torques F \[N·m\]: the state.
    #[state]
    friction: [f64; 2],
}

impl Model for HubFriction {
    fn initialize(&mut self, _experiment: &Experiment) -> Result<(), Failure> {
        self.friction = [0.0; 2];
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        for (friction, speed) in self.friction.iter_mut().zip(self.speed) {
            // Linear in F while the speed is held, so the step is exact: F approaches ±C exponentially.
            let way = self.stiffness * speed.abs() * step.size / self.coulomb;
            let sliding = self.coulomb.copysign(speed);
            *friction = sliding + (*friction - sliding) * (-way).exp();
        }
        Ok(())
    }

    /// What acts on the hubs.
    fn outputs(&mut self) {
        self.torque = self.friction.map(|friction| -friction);
    }
}

fmi2_export::export!(HubFriction);

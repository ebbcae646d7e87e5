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

use fmi2_export::{Declare, DefaultExperiment, Experiment, Failure, Info, Model, Step, Variables};
use serde::{Deserialize, Serialize};

/// `HubFriction.fmu`.
#[derive(Clone, Serialize, Deserialize)]
pub struct HubFriction {
    /// Coulomb torque C \[N·m\], > 0.
    coulomb: f64,
    /// Stiffness σ before sliding \[N·m/rad\], > 0.
    stiffness: f64,
    /// Speeds of the hubs \[rad/s\].
    speed: [f64; 2],
    /// Friction torques F \[N·m\]: the state.
    friction: [f64; 2],
    /// Torques that act on the hubs, −F \[N·m\].
    torque: [f64; 2],
}

/// The default values are the start values.
impl Default for HubFriction {
    fn default() -> Self {
        Self { coulomb: 0.03, stiffness: 30.0, speed: [0.0; 2], friction: [0.0; 2], torque: [0.0; 2] }
    }
}

impl Declare for HubFriction {
    const INFO: Info = Info {
        name: "HubFriction",
        description: "Dry friction in both hubs of the dual-arm plant (Dahl's model)",
        version: env!("CARGO_PKG_VERSION"),
        license: env!("CARGO_PKG_LICENSE"),
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 2.0, step_size: 1e-4, tolerance: None },
        ..Info::new()
    };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|m: &mut Self| m.torque = m.friction.map(|friction| -friction));
        for arm in 0..2 {
            let n = arm + 1;
            variables
                .input(format!("theta{n}_dot"), move |m| &mut m.speed[arm])
                .unit("rad/s")
                .description(&format!("Angular velocity of hub {n}"));
            variables
                .output(format!("delta_f{n}"), outputs, move |m| &mut m.torque[arm])
                .unit("N.m")
                .description(&format!("Friction torque on hub {n}"));
        }
        variables
            .parameter("coulomb", |m| &mut m.coulomb)
            .unit("N.m")
            .range(1e-6, 1e3)
            .description("Friction torque in sliding");
        variables
            .parameter("stiffness", |m| &mut m.stiffness)
            .unit("N.m/rad")
            .range(1e-6, 1e6)
            .description("Stiffness before sliding");
    }
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
}

fmi2_export::export!(HubFriction);

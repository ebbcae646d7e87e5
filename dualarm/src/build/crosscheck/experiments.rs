//! The experiment of each FMU alone.

/// An experiment with one FMU.
#[derive(Debug, Clone, Copy)]
pub struct SoloExperiment {
    /// The FMU.
    pub model: &'static str,
    /// A description of the experiment and of its interesting results.
    pub story: &'static str,
    /// Stop time in s.
    pub stop: f64,
    /// Where the inputs come from.
    pub inputs: Source,
    /// The outputs of the reference solution, at most ten as the rules recommend.
    pub outputs: &'static [&'static str],
}

/// Points of a piecewise-linear signal: time in s, value.
type Points = &'static [(f64, f64)];

/// Where the inputs of an experiment come from.
#[derive(Debug, Clone, Copy)]
pub enum Source {
    /// Straight lines through these points.
    Ramps(&'static [(&'static str, Points)]),
    /// The measurements of a controller while it controls the plant and one of its references changes.
    ClosedLoop {
        /// The plant.
        plant: &'static str,
        /// The reference that changes.
        reference: (&'static str, Points),
    },
}

/// λ₁ᵈ changes from −0.5 N to −0.6 N: the desired contact force rises by a fifth.
const FIRMER_GRASP: (&str, Points) = ("lambda1_ref", &[(0.0, -0.5), (0.6, -0.5), (0.7, -0.6), (1.0, -0.6)]);

const COMMANDS: [&str; 6] = ["tau1_cmd", "tau2_cmd", "u_cmd", "e1", "e2", "p"];

/// All experiments.
pub const EXPERIMENTS: [SoloExperiment; 6] = [
    SoloExperiment {
        model: "DualArmPlant",
        story: "Open loop: the motors of both arms push against each other with 0.1 N.m, which squeezes the object with \
                0.5 N; then a push of 0.05 N on the object is felt by one arm as more force and by the other as less.",
        stop: 1.0,
        inputs: Source::Ramps(&[
            ("tau1_cmd", &[(0.0, 0.0), (0.2, 0.1), (1.0, 0.1)]),
            ("tau2_cmd", &[(0.0, 0.0), (0.2, -0.1), (1.0, -0.1)]),
            ("delta_F", &[(0.0, 0.0), (0.6, 0.0), (0.65, 0.05), (0.7, 0.0), (1.0, 0.0)]),
        ]),
        outputs: &[
            "theta1",
            "theta2",
            "y_object",
            "root_moment1",
            "root_moment2",
            "tip_shear1",
            "tip_shear2",
            "contact_force1",
            "contact_force2",
            "energy",
        ],
    },
    SoloExperiment {
        model: "NabfcController",
        story: "The signals it measured while it closed the grasp and then, at 0.6 s, was asked for a firmer one: its \
                commands and its estimate of the object's mass.",
        stop: 1.0,
        inputs: Source::ClosedLoop { plant: "DualArmPlant", reference: FIRMER_GRASP },
        outputs: &["tau1_cmd", "tau2_cmd", "u_cmd", "e1", "e2", "p", "m_hat"],
    },
    SoloExperiment {
        model: "PdsController",
        story: "The signals it measured while it closed the grasp and, at 0.6 s, was asked for a firmer one. Its law has \
                no memory: the commands follow the inputs at once.",
        stop: 1.0,
        inputs: Source::ClosedLoop { plant: "DualArmPlant", reference: FIRMER_GRASP },
        outputs: &COMMANDS,
    },
    SoloExperiment {
        model: "PdController",
        story: "The signals it measured while it closed the grasp and, at 0.6 s, was asked for a firmer one, long before \
                the first force had settled. Its law has no memory: the commands follow the inputs at once.",
        stop: 1.0,
        inputs: Source::ClosedLoop { plant: "DualArmPlant", reference: FIRMER_GRASP },
        outputs: &COMMANDS,
    },
    SoloExperiment {
        model: "GraspInstruments",
        story: "With its start values a sensor shows its signal as it is: hub 1 turns to and fro, the object moves aside.",
        stop: 1.0,
        inputs: Source::Ramps(&[
            ("theta1", &[(0.0, 0.0), (0.3, 0.05), (0.7, -0.02), (1.0, 0.0)]),
            ("y_object", &[(0.0, 0.05), (0.5, 0.05), (0.8, 0.048), (1.0, 0.048)]),
        ]),
        outputs: &["theta1_measured", "y_object_measured"],
    },
    SoloExperiment {
        model: "GraspActuators",
        story: "With its start values every command is passed on as it is: the hubs' torques rise, the force has a pulse.",
        stop: 1.0,
        inputs: Source::Ramps(&[
            ("tau1_cmd", &[(0.0, 0.0), (0.2, 0.1), (1.0, 0.1)]),
            ("tau2_cmd", &[(0.0, 0.0), (0.2, -0.1), (1.0, -0.1)]),
            ("u_cmd", &[(0.0, 0.0), (0.6, 0.0), (0.65, 0.05), (0.7, 0.0), (1.0, 0.0)]),
        ]),
        outputs: &["tau1_cmd_sent", "tau2_cmd_sent", "u_cmd_sent"],
    },
];

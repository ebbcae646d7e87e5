//! The Lyapunov functions along a run: H, E, C, V_o, V_Ii of (67)–(69) for the paper's law, H of the root-strain law, each
//! with its claimed bound.
//!
//! Fields are not outputs of a plant. A [`Mirror`] computes them: a plant with the same parameters whose hubs and object
//! are forced, step by step, to have the recorded velocities. The forces that this takes are the forces that acted in the
//! run, whatever their origin.

mod mirror;
mod paper;
mod root;

pub use mirror::{Integrals, Mirror};
pub use paper::PaperLaw;
pub use root::RootLaw;

/// Names and units of the recorded columns: H and its parts E, C, V_o, V_I1, V_I2, the drive D of the root-strain law, and
/// the bound of H.
pub const COLUMNS: [(&str, &str); 8] = [
    ("lyapunov_H", "J"),
    ("lyapunov_E", "J"),
    ("lyapunov_C", "J"),
    ("lyapunov_V_o", "J"),
    ("lyapunov_V_I1", "J"),
    ("lyapunov_V_I2", "J"),
    ("lyapunov_D", "1"),
    ("lyapunov_bound", "J"),
];

/// The data of an instant: true signals of the plant, target, and the estimates of the paper's law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// θ̇_1, θ̇_2, ẏ_M.
    pub rate: [f64; 3],
    /// EI_i w_i''(0) and EI_i w_i'''(l), to compare with the mirror's.
    pub load: [f64; 4],
    /// e_1, e_2, p.
    pub error: [f64; 3],
    /// λ_1^d, λ_2^d.
    pub lambda: [f64; 2],
    /// s_1, s_2, s of the paper's law.
    pub surface: [f64; 3],
    /// ‖Û_1‖, ‖Û_2‖, ‖Ŵ‖.
    pub weights: [f64; 3],
    /// π̂_1, π̂_2, ε̂.
    pub bound: [f64; 3],
    /// Ĵ_1, Ĵ_2, m̂.
    pub inertia: [f64; 3],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use grasp_plant::{Inputs, Parameters, Plant};

    fn sample(plant: &Plant) -> Sample {
        let m = plant.measured();
        Sample {
            rate: [m.theta_dot[0], m.theta_dot[1], m.y_object_dot],
            load: [m.root_moment[0], m.root_moment[1], m.tip_shear[0], m.tip_shear[1]],
            ..Sample::default()
        }
    }

    /// The mirror finds the forces that moved the recorded plant, and with them its fields.
    #[test]
    fn the_mirror_follows() {
        let parameters = Parameters::default();
        let mut recorded = Plant::new(parameters.clone()).unwrap();
        let mut mirror = Mirror::new(&parameters).unwrap();
        for step in 0..400 {
            let t = f64::from(step) * 1e-3;
            let inputs = Inputs {
                torque_command: [0.1 * (9.0 * t).sin(), -0.05],
                force_command: 0.05 * (20.0 * t).cos(),
                hub_disturbance: [0.0, 0.02],
                ..Inputs::ZERO
            };
            recorded.step(1e-3, &inputs, &Inputs::ZERO).unwrap();
            mirror.step(1e-3, &sample(&recorded)).unwrap();
            assert!((mirror.force()[1] + 0.03).abs() < 1e-6, "{step} {:?}", mirror.force());
        }
        assert!(mirror.deviation() < 1e-6, "{}", mirror.deviation());
        // Without a target, E is the energy of the arms alone.
        let m = recorded.measured();
        let rigid = 0.5 * (0.0073 * (m.theta_dot[0].powi(2) + m.theta_dot[1].powi(2)) + 0.5 * m.y_object_dot.powi(2));
        let energy = mirror.integrals(&Sample::default()).energy;
        assert!((energy + rigid - recorded.energy()).abs() < 1e-6 * recorded.energy());
    }

    /// For the gains of the errata's example (90) claims something; for those of the FMU nothing.
    #[test]
    fn only_some_gains_have_a_claim() {
        let mut settings = Settings::default();
        assert!(!PaperLaw::new(&settings).is_claimed());
        let gains = [("mu_bar", 0.015), ("c1", 0.015), ("k", 1e5), ("b1", 1.0), ("gamma1", 1.0), ("a1", 1.0)];
        for (name, value) in gains {
            settings.set(name, value).unwrap();
        }
        for i in 1..=2 {
            for (name, value) in [("mu", 0.04), ("c3", 0.04), ("k", 1e5), ("g1", 1.0), ("zeta1", 1.0), ("a3", 1.0)] {
                settings.set(&format!("{name}{i}"), value).unwrap();
            }
        }
        let law = PaperLaw::new(&settings);
        assert!(law.is_claimed() && law.bound(1.0, 0.0, [0.0; 3]).unwrap() > 1.0);
    }
}

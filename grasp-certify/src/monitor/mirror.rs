//! A plant that moves as a recorded one.

use super::Sample;
use grasp_plant::nalgebra::{Matrix3, Vector3};
use grasp_plant::{ActuatorModel, Fields, Inputs, Parameters, Plant, StepError};

/// A plant that follows a recorded one.
#[derive(Clone, Debug)]
pub struct Mirror {
    plant: Plant,
    fields: Fields,
    /// Velocities per unit of the forces, for steps of this size.
    response: Option<(f64, Matrix3<f64>)>,
    /// Forces over the last step, without the built-in ones.
    force: [f64; 3],
    /// Largest difference of a load from the recorded one, relative to the largest of its kind.
    worst: [f64; 2],
    largest: [f64; 2],
}

/// Integrals over the arms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Integrals {
    /// ½Σ(EI∫q''² + ρ∫ẏ²) \[J\].
    pub energy: f64,
    /// Σρ∫(x−l)ẏq' \[J·s·m⁻¹·m\].
    pub first: f64,
    /// Σρ∫ẏy \[J·s\].
    pub second: f64,
}

impl Mirror {
    /// At the plant's start.
    ///
    /// # Errors
    /// Parameters that are not admissible.
    pub fn new(parameters: &Parameters) -> Result<Self, grasp_plant::InvalidParameter> {
        let parameters = Parameters { actuator_model: ActuatorModel::Ideal, ..parameters.clone() };
        let fields = Fields::new(&parameters);
        let plant = Plant::new(parameters)?;
        Ok(Self { plant, fields, response: None, force: [0.0; 3], worst: [0.0; 2], largest: [1e-9; 2] })
    }

    fn rates(plant: &Plant) -> Vector3<f64> {
        let measured = plant.measured();
        Vector3::new(measured.theta_dot[0], measured.theta_dot[1], measured.y_object_dot)
    }

    fn driven(force: [f64; 3]) -> Inputs {
        Inputs { hub_disturbance: [force[0], force[1]], object_disturbance: force[2], ..Inputs::ZERO }
    }

    /// A step of `h` \[s\] at whose end hubs and object have the velocities of `sample`.
    ///
    /// # Errors
    /// The plant refuses the step.
    pub fn step(&mut self, h: f64, sample: &Sample) -> Result<(), StepError> {
        let mut free = self.plant.clone();
        free.step(h, &Inputs::ZERO, &Inputs::ZERO)?;
        let free = Self::rates(&free);
        let response = match &self.response {
            // Steps of a grid differ by rounding.
            Some((size, response)) if (size - h).abs() < 1e-9 * h => *response,
            _ => {
                let mut response = Matrix3::zeros();
                for column in 0..3 {
                    let mut unit = [0.0; 3];
                    unit[column] = 1.0;
                    let mut plant = self.plant.clone();
                    plant.step(h, &Self::driven(unit), &Inputs::ZERO)?;
                    response.set_column(column, &(Self::rates(&plant) - free));
                }
                self.response = Some((h, response));
                response
            }
        };
        let missing = Vector3::from(sample.rate) - free;
        let force = response.lu().solve(&missing).unwrap_or_default();
        self.force = [force[0], force[1], force[2]];
        self.plant.step(h, &Self::driven(self.force), &Inputs::ZERO)?;
        let measured = self.plant.measured();
        for (kind, loads) in [measured.root_moment, measured.tip_shear].into_iter().enumerate() {
            for (arm, load) in loads.into_iter().enumerate() {
                let recorded = sample.load[2 * kind + arm];
                self.worst[kind] = self.worst[kind].max((load - recorded).abs());
                self.largest[kind] = self.largest[kind].max(recorded.abs());
            }
        }
        Ok(())
    }

    /// The difference between the loads and the recorded ones, relative to the largest of their kind. It is small if the
    /// recorded plant is this one.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        (self.worst[0] / self.largest[0]).max(self.worst[1] / self.largest[1])
    }

    /// Length of the arms \[m\].
    pub(super) fn length(&self) -> f64 {
        self.plant.parameters().length
    }

    /// The forces on hubs and object over the last step, without the built-in uncertainties: torques \[N·m\], force \[N\].
    #[must_use]
    pub const fn force(&self) -> [f64; 3] {
        self.force
    }

    /// The integrals of the deviations from the target.
    #[must_use]
    pub fn integrals(&self, sample: &Sample) -> Integrals {
        let p = self.plant.parameters();
        let l = p.length;
        let mut sum = Integrals::default();
        for (i, nodes) in self.fields.of(&self.plant).iter().enumerate() {
            let (ei, rho, lambda) = (p.arms[i].ei, p.arms[i].rho, sample.lambda[i]);
            for n in nodes {
                // w^d = (λ x²/2EI)(x/3 − l) of (16).
                let moment = n.moment - lambda * (n.x - l);
                let slope = n.slope - lambda / ei * n.x * (0.5 * n.x - l);
                let q = n.deflection - lambda / (2.0 * ei) * n.x.powi(2) * (n.x / 3.0 - l);
                let rate = -n.velocity;
                sum.energy += 0.5 * n.weight * (moment.powi(2) / ei + rho * rate.powi(2));
                sum.first += n.weight * rho * (n.x - l) * rate * slope;
                sum.second += n.weight * rho * rate * (q - n.x * sample.error[i]);
            }
        }
        sum
    }
}

//! The fields of both arms, for integrals over them.

use crate::basis::{gauss, legendre, moment_shape};
use crate::parameters::Parameters;
use crate::plant::Plant;
use nalgebra::{DMatrix, DVector};

/// An arm at one node of a Gauss rule over its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Distance from the root \[m\].
    pub x: f64,
    /// Weight of the node \[m\].
    pub weight: f64,
    /// EI w'' \[N·m\].
    pub moment: f64,
    /// w'.
    pub slope: f64,
    /// w \[m\].
    pub deflection: f64,
    /// Velocity across the arm, xθ̇ − ẇ \[m/s\].
    pub velocity: f64,
}

/// Reads the fields of plants with the same parameters. The rule integrates products of two fields and x exactly.
#[derive(Clone, Debug)]
pub struct Fields {
    order: usize,
    arms: [Rows; 2],
}

/// Values at the nodes per coefficient.
#[derive(Clone, Debug)]
struct Rows {
    nodes: Vec<(f64, f64)>,
    moment: DMatrix<f64>,
    slope: DMatrix<f64>,
    deflection: DMatrix<f64>,
    velocity: DMatrix<f64>,
}

impl Fields {
    /// For plants of these parameters.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        let (k, l) = (parameters.order, parameters.length);
        let (outer, inner) = (gauss(k + 2), gauss(k));
        let arms = parameters.arms.each_ref().map(|arm| {
            let scale = |j: usize| (arm.ei * (2 * j + 3) as f64 / l).sqrt();
            let speed = |r: usize| ((2 * r + 1) as f64 / (arm.rho * l)).sqrt();
            let of_moments = |f: &dyn Fn(f64, usize) -> f64| {
                DMatrix::from_fn(outer.len(), k, |node, j| scale(j) * f(outer[node].0, j))
            };
            let integral = |xi: f64, j: usize, weight: &dyn Fn(f64) -> f64| {
                inner.iter().map(|(sigma, w)| w * weight(*sigma) * moment_shape(j, xi * sigma)).sum::<f64>() / arm.ei
            };
            Rows {
                nodes: outer.iter().map(|(xi, weight)| (l * xi, l * weight)).collect(),
                moment: of_moments(&|xi, j| moment_shape(j, xi)),
                slope: of_moments(&|xi, j| xi * l * integral(xi, j, &|_| 1.0)),
                deflection: of_moments(&|xi, j| (xi * l).powi(2) * integral(xi, j, &|sigma| 1.0 - sigma)),
                velocity: DMatrix::from_fn(outer.len(), k - 1, |node, r| {
                    speed(r) * legendre(r, 2.0 * outer[node].0 - 1.0)
                }),
            }
        });
        Self { order: k, arms }
    }

    /// The arms of `plant` as they are.
    #[must_use]
    pub fn of(&self, plant: &Plant) -> [Vec<Node>; 2] {
        let k = self.order;
        let coordinates = &plant.energy_coordinates();
        let (moments, velocities) = coordinates.split_at(2 * k);
        let velocities = plant.physical_velocities(velocities);
        std::array::from_fn(|i| {
            let rows = &self.arms[i];
            let a = DVector::from_column_slice(&moments[i * k..(i + 1) * k]);
            let b = DVector::from_column_slice(&velocities[i * (k - 1)..(i + 1) * (k - 1)]);
            let (moment, slope) = (&rows.moment * &a, &rows.slope * &a);
            let (deflection, velocity) = (&rows.deflection * &a, &rows.velocity * &b);
            rows.nodes
                .iter()
                .enumerate()
                .map(|(n, (x, weight))| Node {
                    x: *x,
                    weight: *weight,
                    moment: moment[n],
                    slope: slope[n],
                    deflection: deflection[n],
                    velocity: velocity[n],
                })
                .collect()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Inputs;

    /// The integrals of the fields are the plant's energy, and w at the tip its deflection, up to rounding of sums.
    #[test]
    fn the_fields_hold_the_energy() {
        for order in [4, 8, 13] {
            let parameters = Parameters { order, ..Parameters::default() };
            let mut plant = Plant::new(parameters.clone()).unwrap();
            let inputs = Inputs { torque_command: [0.3, -0.2], force_command: 0.1, ..Inputs::ZERO };
            plant.step(0.013, &inputs, &Inputs::ZERO).unwrap();
            let fields = Fields::new(&parameters).of(&plant);
            let mut energy = 0.5 * parameters.moving_mass() * plant.measured().y_object_dot.powi(2);
            for (i, nodes) in fields.iter().enumerate() {
                let arm = &parameters.arms[i];
                energy += 0.5 * arm.hub_inertia * plant.measured().theta_dot[i].powi(2);
                energy += nodes
                    .iter()
                    .map(|n| 0.5 * n.weight * (n.moment.powi(2) / arm.ei + arm.rho * n.velocity.powi(2)))
                    .sum::<f64>();
                // ∫w'dx = w(l).
                let tip: f64 = nodes.iter().map(|n| n.weight * n.slope).sum();
                assert!((tip - plant.tip_deflection()[i]).abs() < 1e-13, "{order} {tip}");
            }
            assert!((energy - plant.energy()).abs() < 1e-12 * energy, "{order}: {energy} {}", plant.energy());
        }
    }
}

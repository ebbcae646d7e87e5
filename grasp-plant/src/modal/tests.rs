//! Modal steps against the dense matrices of the same plant.

use super::{Modal, Table};
use crate::dynamics::{Dynamics, FORCES};
use crate::extended::{Extended, MAX_PANELS};
use crate::kernel::LANES;
use crate::parameters::{Arm, Parameters};

/// A plant in both forms.
struct Both {
    dynamics: Dynamics,
    extended: Extended,
    modal: Modal,
    table: Table,
}

impl Both {
    fn new(parameters: &Parameters) -> Self {
        let dynamics = Dynamics::new(parameters);
        let modal = Modal::new(&dynamics, parameters).unwrap_or_else(|| panic!("no modal form of {parameters:?}"));
        let extended = Extended::new(&dynamics, parameters.length);
        Self { table: modal.table(), dynamics, extended, modal }
    }

    /// A step from energy coordinates: the next ones, Θ and Ψ.
    fn modal(&mut self, x: &[f64], forces: &[f64; FORCES], rates: &[f64; FORCES], h: f64) -> Vec<f64> {
        let modal = &self.modal;
        let (mut z, mut next) = (vec![0.0; modal.size()], vec![0.0; modal.size()]);
        modal.modal_coordinates(x, &mut z);
        modal.fill(&mut self.table, h);
        let travel = modal.step(&self.table, &z, forces, Some(rates), &mut next);
        let mut end = vec![0.0; x.len()];
        modal.energy_coordinates(&next, &mut end);
        for values in [travel.total, travel.integral] {
            let [w_1, w_2, y] = values;
            end.extend([w_1, w_2].map(|w| (w + y) / self.extended.length));
            end.push(y);
        }
        end
    }

    fn dense(&self, x: &[f64], forces: &[f64; FORCES], rates: &[f64; FORCES], h: f64) -> Vec<f64> {
        let layout = self.extended.layout;
        let mut z = vec![0.0; layout.size()];
        z[..layout.n].copy_from_slice(x);
        z[layout.force()..layout.force_rate()].copy_from_slice(forces);
        z[layout.force_rate()..].copy_from_slice(rates);
        self.extended.advance(h, &mut z, &mut [[0.0; LANES]; MAX_PANELS]);
        z.truncate(layout.force());
        z
    }
}

fn plants() -> Vec<Parameters> {
    let conservative = Parameters { root_uncertainty: 0.0, tip_uncertainty: 0.0, ..Parameters::default() };
    let other = Arm { ei: 0.4, rho: 0.1, hub_inertia: 0.02, tip_mass: 0.05 };
    let base = [
        Parameters::default(),
        conservative.clone(),
        Parameters { kelvin_voigt: 1e-3, ..conservative.clone() },
        Parameters { kelvin_voigt: 1e-4, ..Parameters::default() },
        Parameters { tip_uncertainty: 0.0, ..Parameters::default() },
        Parameters { root_uncertainty: 0.0, ..Parameters::default() },
        Parameters { root_uncertainty: 1e-6, tip_uncertainty: 1e-6, ..Parameters::default() },
    ];
    let unequal = base.clone().map(|p| Parameters { arms: [Arm::default(), other], ..p });
    base.into_iter().chain(unequal).collect()
}

#[test]
fn modal_steps_are_the_dense_ones() {
    let (mut worst, mut at) = (0.0f64, String::new());
    for order in [4, 5, 8, 12, 16, 24] {
        for parameters in plants() {
            let parameters = Parameters { order, ..parameters };
            let mut both = Both::new(&parameters);
            // A smooth motion: what a push has made of rest.
            let n = both.dynamics.size();
            let (push, rates) = ([0.1, -0.07, 0.2], [3.0, 1.0, -2.0]);
            let x = both.dense(&vec![0.0; n], &push, &rates, 0.02)[..n].to_vec();
            let size = x.iter().map(|x| x * x).sum::<f64>().sqrt();
            for h in [1e-9, 1e-4, 1e-3, 0.05, 1.0] {
                let (modal, dense) = (both.modal(&x, &push, &rates, h), both.dense(&x, &push, &rates, h));
                let error = modal.iter().zip(&dense).map(|(m, d)| (m - d).abs()).fold(0.0, f64::max) / size.max(h * h);
                if error > worst {
                    (worst, at) = (error, format!("order {order} h {h} {parameters:?}"));
                }
                println!(
                    "{order} {} {} {h}: {error:.1e} condition {:.1e}",
                    parameters.root_uncertainty,
                    parameters.kelvin_voigt,
                    both.modal.condition()
                );
            }
        }
    }
    println!("{worst:e} {at}");
    assert!(worst < 1e-9, "{worst:e} {at}");
}

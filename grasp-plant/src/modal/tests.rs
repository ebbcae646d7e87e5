//! Modal steps against the dense matrices of the same plant.

use super::{Modal, Table};
use crate::dynamics::{Dynamics, FORCES};
use crate::exponential::one_norm;
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

    /// A step from energy coordinates: the next ones, Θ and, of ramps, Ψ.
    fn modal(&mut self, x: &[f64], forces: &[f64; FORCES], rates: Option<&[f64; FORCES]>, h: f64) -> Vec<f64> {
        let modal = &self.modal;
        let (mut z, mut next) = (vec![0.0; modal.size()], vec![0.0; modal.size()]);
        modal.modal_coordinates(x, &mut z);
        modal.fill(&mut self.table, h);
        let travel = modal.step(&self.table, &z, forces, rates, &mut next);
        let mut end = vec![0.0; x.len()];
        modal.energy_coordinates(&next, &mut end);
        end.extend(travel.total);
        if rates.is_some() {
            end.extend(travel.integral);
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

/// The largest difference between a modal and a dense step of size h, relative to the motion, and its bound by rounding:
/// the dense step rotates its fastest motions by ‖𝒜‖h, and modal coordinates are larger than the motion.
fn difference(both: &mut Both, h: f64) -> (f64, f64) {
    // A smooth motion: the motion after a push from rest.
    let n = both.dynamics.size();
    let (push, rates) = ([0.1, -0.07, 0.2], [3.0, 1.0, -2.0]);
    let x = both.dense(&vec![0.0; n], &push, &rates, h)[..n].to_vec();
    let mut error = 0.0f64;
    // Ramps, held forces in the same way, and held forces in theirs.
    for (ramps, rates) in [(true, rates), (true, [0.0; FORCES]), (false, [0.0; FORCES])] {
        let (modal, dense) = (both.modal(&x, &push, ramps.then_some(&rates), h), both.dense(&x, &push, &rates, h));
        let size = dense.iter().chain(&x).fold(0.0f64, |size, x| size.max(x.abs()));
        error = error.max(modal.iter().zip(&dense).map(|(m, d)| (m - d).abs()).fold(0.0, f64::max) / size);
    }
    let rounding = f64::EPSILON * (8.0 + both.modal.condition() + 8.0 * h * one_norm(&both.extended.matrix));
    (error, rounding)
}

#[test]
fn modal_steps_are_the_dense_ones() {
    for order in [4, 5, 8, 12, 24] {
        for parameters in plants() {
            let parameters = Parameters { order, ..parameters };
            if parameters.kelvin_voigt > 0.0 && parameters.root_uncertainty == 0.0 && parameters.tip_uncertainty == 0.0
            {
                assert!(Modal::new(&Dynamics::new(&parameters), &parameters).is_none());
                continue;
            }
            let mut both = Both::new(&parameters);
            for h in [1e-9, 1e-4, 1e-3, 0.05, 1.0] {
                let (error, rounding) = difference(&mut both, h);
                assert!(error <= rounding, "order {order} h {h}: {error:e} beyond {rounding:e}, {parameters:?}");
            }
        }
    }
}

/// Plants of all kinds, each parameter within three decades: nearly all have a modal form, and it moves like the dense
/// matrices.
#[test]
fn odd_plants_move_as_their_matrices_do() {
    let mut seed = 12345u64;
    let mut random = move || {
        // Knuth's linear congruential generator.
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut without = 0;
    for i in 0..150 {
        let mut around = |middle: f64| middle * 10f64.powf(3.0 * random() - 1.5);
        let mut arm =
            || Arm { ei: around(0.115), rho: around(0.054), hub_inertia: around(0.0073), tip_mass: around(0.1) };
        let arms = if i % 11 == 0 { [arm(); 2] } else { [arm(), arm()] };
        let mut given = |middle: f64, none: bool| if none { 0.0 } else { around(middle) };
        let parameters = Parameters {
            arms,
            root_uncertainty: given(0.05, i % 5 == 0),
            tip_uncertainty: given(0.03, i % 7 == 0),
            kelvin_voigt: given(1e-4, i % 3 == 0),
            object_mass: given(0.3, false),
            order: 4 + i % 9,
            ..Parameters::default()
        };
        let dynamics = Dynamics::new(&parameters);
        let Some(modal) = Modal::new(&dynamics, &parameters) else {
            without += 1;
            continue;
        };
        let extended = Extended::new(&dynamics, parameters.length);
        let mut both = Both { table: modal.table(), dynamics, extended, modal };
        for h in [1e-7f64, 1e-4, 1e-2] {
            let h = h.min(both.extended.longest_step);
            let (error, rounding) = difference(&mut both, h);
            assert!(error <= rounding, "{i} h {h}: {error:e} beyond {rounding:e}, {parameters:?}");
        }
    }
    assert!(without < 8, "{without} without a modal form");
}

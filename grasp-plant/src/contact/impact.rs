//! Impacts, and which sides touch when continuity does not tell.

use super::layout::SIGN;
use super::{ContactState, Modes};
use crate::dynamics::FORCES;

/// Gaps that close within this time after another one \[s\] close with it. Far below any time that could matter, far above
/// the rounding of two arms that do the same.
pub(super) const SIMULTANEOUS: f64 = 1e-13;

/// Rounding of forces and rates, in units of the numbers they are summed from.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Modes {
    /// The length of (x, g), by which rounding is measured.
    pub fn magnitude(x: &[f64], forces: &[f64]) -> f64 {
        x.iter().chain(forces).map(|value| value * value).sum::<f64>().sqrt()
    }

    /// Contact forces with g applied now, and the sides that push, among rigid sides that touch: those of the accelerations'
    /// complementarity problem. By how much an acceleration \[m/s²\] may be wrong follows from `size`, |(x, g)|.
    pub fn pushing(&self, x: &[f64], forces: &[f64], touching: [bool; 2], size: f64) -> ([f64; 2], [bool; 2]) {
        let object = forces[2] / self.object_mass;
        let opening = [0, 1].map(|i| {
            let shear: f64 = self.shear.row(i).iter().zip(x).map(|(row, x)| row * x).sum();
            SIGN[i] * (-shear / self.tip_masses[i] - object)
        });
        self.delassus.solve(opening, touching, self.noise(size))
    }

    /// By how much rounding may put accelerations of the gaps wrong \[m/s²\], if `size` is |(x, g)|.
    pub fn noise(&self, size: f64) -> f64 {
        (0..2).fold(0.0, |noise: f64, i| {
            let scale = self.shear.row(i).norm() / self.tip_masses[i] + 1.0 / self.object_mass;
            noise.max(ROUNDING * scale * size)
        })
    }

    /// The impact of all sides in `closing` on those that touch and each other. Returns the energy it takes and the sides
    /// that touch afterwards, as far as velocities tell.
    pub fn impact(&self, x: &mut [f64], touching: [bool; 2], closing: [bool; 2]) -> (f64, [bool; 2]) {
        let layout = self.layout;
        let places = [layout.tip(0), layout.tip(1), layout.object()];
        let before = places.map(|place| x[place]);
        let closed = [0, 1].map(|i| touching[i] || closing[i]);
        let rate = [0, 1].map(|i| if closing[i] { self.opening_rate(x, i).min(0.0) } else { 0.0 });
        let bounce = rate.map(|rate| if -rate < self.plastic_speed { 0.0 } else { self.restitution });
        let demand = [0, 1].map(|i| (1.0 + bounce[i]) * rate[i]);
        let (impulse, pushed) = self.delassus.solve(demand, closed, 0.0);
        for i in 0..2 {
            x[places[i]] += SIGN[i] * impulse[i] / self.tip_masses[i].sqrt();
            x[places[2]] -= SIGN[i] * impulse[i] / self.object_mass.sqrt();
        }
        // Sides whose velocities are equal now stay together.
        let together = [0, 1].map(|i| pushed[i] && bounce[i] * rate[i] == 0.0);
        self.merge(x, together);
        let loss = (0..3).map(|i| 0.5 * (before[i] - x[places[i]]) * (before[i] + x[places[i]])).sum();
        (loss, together)
    }

    /// The projection on the common motion of object and touching tips.
    pub fn merge(&self, x: &mut [f64], touching: [bool; 2]) {
        let layout = self.layout;
        let object_root = self.object_mass.sqrt();
        let (mut momentum, mut mass) = (object_root * x[layout.object()], self.object_mass);
        for i in (0..2).filter(|i| touching[*i]) {
            momentum += self.tip_masses[i].sqrt() * x[layout.tip(i)];
            mass += self.tip_masses[i];
        }
        if touching == [false; 2] {
            return;
        }
        let velocity = momentum / mass;
        x[layout.object()] = object_root * velocity;
        for i in (0..2).filter(|i| touching[*i]) {
            x[layout.tip(i)] = self.tip_masses[i].sqrt() * velocity;
        }
    }

    /// Rigid gaps that close with those that are `closing`: within this time \[s\].
    pub fn closing_with(&self, x: &[f64], contact: &ContactState, mut closing: [bool; 2], within: f64) -> [bool; 2] {
        for i in 0..2 {
            let rate = self.opening_rate(x, i);
            closing[i] |= !contact.touching[i] && rate < 0.0 && contact.clearance[i] <= within * -rate;
        }
        closing
    }
}

/// The forces within (x, g, r).
pub(super) fn forces_of(drive: &[f64], size: usize) -> &[f64] {
    &drive[size..size + FORCES]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{ContactModel, Parameters};

    /// A sequence of numbers in (0, 1) that looks random.
    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A hundred thousand impacts of random masses, velocities, sides and restitutions: momentum stays to rounding, what is lost
    /// is what is booked, nothing is gained, no side approaches afterwards, and who bounces does so with e.
    #[test]
    fn a_hundred_thousand_random_impacts_conserve_momentum() {
        let mut seed = 1;
        for _ in 0..100 {
            let mut parameters =
                Parameters { contact_model: ContactModel::Unilateral, order: 4, ..Parameters::default() };
            for arm in &mut parameters.arms {
                arm.tip_mass = 10f64.powf(-2.0 + 2.0 * random(&mut seed));
            }
            parameters.object_mass = 10f64.powf(-2.0 + 3.0 * random(&mut seed));
            parameters.restitution = random(&mut seed);
            let modes = Modes::new(&parameters, [1.0; 2]);
            let places = [modes.layout.tip(0), modes.layout.tip(1), modes.layout.object()];
            let roots = [modes.tip_masses[0].sqrt(), modes.tip_masses[1].sqrt(), modes.object_mass.sqrt()];
            let momentum = |x: &[f64]| (0..3).map(|i| roots[i] * x[places[i]]).sum::<f64>();
            let energy = |x: &[f64]| (0..3).map(|i| 0.5 * x[places[i]] * x[places[i]]).sum::<f64>();
            for case in 0..1000 {
                let mut x = vec![0.0; modes.layout.size()];
                for (place, root) in places.into_iter().zip(roots) {
                    x[place] = root * (2.0 * random(&mut seed) - 1.0);
                }
                let touching = [false, case % 3 == 1];
                modes.merge(&mut x, touching);
                let closing = [0, 1].map(|i| !touching[i] && modes.opening_rate(&x, i) < 0.0);
                if closing == [false; 2] {
                    continue;
                }
                let before = x.clone();
                let (loss, together) = modes.impact(&mut x, touching, closing);
                let scale = energy(&before);
                assert!((momentum(&x) - momentum(&before)).abs() < 1e-14 * (1.0 + scale.sqrt()));
                assert!((energy(&before) - energy(&x) - loss).abs() < 1e-14 * scale && loss > -1e-15 * scale);
                for i in (0..2).filter(|i| closing[*i] || touching[*i]) {
                    let (then, now) = (modes.opening_rate(&before, i), modes.opening_rate(&x, i));
                    assert!(now >= -1e-14, "{then} {now}");
                    let bounced = if closing[i] { -parameters.restitution * then } else { 0.0 };
                    // A side may be carried away faster by the other one, not slower.
                    assert!(now >= bounced - 1e-13 && (!together[i] || now.abs() < 1e-14), "{then} {now} {bounced}");
                }
            }
        }
    }
}

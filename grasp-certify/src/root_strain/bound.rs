//! The guarantees of a certificate in metres, radians and newtons.

use super::{Certificate, Port, Storage};
use crate::Grasp;
use crate::interval::{Interval, Number};
use serde::Serialize;

/// Bounds in the end, or bounds that follow from a value of W.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// W \[J\].
    pub energy: f64,
    /// |e_i| \[rad\].
    pub angle: [f64; 2],
    /// |p| \[m\].
    pub position: f64,
    /// (3EI_i/l³)|q_i(l)|, the contact force that the arm's bending makes at rest \[N\].
    pub force: [f64; 2],
}

/// Bounds of the disturbances: on hub 1, hub 2 \[N·m\], on the object \[N\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Disturbance {
    /// Bounds of |Δ| of any shape. An observer may take a sudden one for the opposite for a while.
    pub size: [f64; 3],
    /// Bounds of |Δ̇| of disturbances of any size, which observers learn \[1/s\]; without observers they are not used.
    pub rate: [f64; 3],
}

impl Storage {
    /// The square of the steepest slope of √(2V) in a direction (ζ̇, ȧ, δ̇).
    fn steepness(&self, [zeta, error, learnt]: [Interval; 3]) -> Interval {
        let n = Interval::exact;
        let crossed = zeta + n(self.error) * error + n(self.learnt) * learnt;
        let [r, g, h] = self.observer.map(n);
        let watched = error * error + n(2.0) * g * error * learnt + h * learnt * learnt;
        n(self.crossed) * crossed * crossed + r * watched
    }

    /// V at rest, with the load S.
    fn at_rest(&self, port: &Port, position: f64, load: f64) -> f64 {
        let (zeta, error) = (port.crossing() * load, port.observed_crossing() * load);
        let error = if port.observer > 0.0 { error } else { 0.0 };
        let crossed = zeta + self.slope * position + self.error * error;
        let [r, g, h] = self.observer;
        let (error, learnt) = (error + self.drift[0] * position, self.drift[1] * position);
        let watched = r * (error * error + 2.0 * g * error * learnt + h * learnt * learnt);
        0.5 * (self.position * position.powi(2) + self.crossed * crossed.powi(2) + watched)
    }
}

impl Certificate {
    /// The consequences of a value of W \[J\].
    #[must_use]
    pub fn implied(&self, grasp: &Grasp, energy: f64) -> Bound {
        if energy == 0.0 {
            return Bound { energy, angle: [0.0; 2], position: 0.0, force: [0.0; 2] };
        }
        let n = Interval::exact;
        let w = n(2.0) * n(energy);
        let by = |weight: f64| Number::sqrt(w / n(weight)).hi();
        let cube = n(grasp.length) * n(grasp.length) * n(grasp.length);
        Bound {
            energy,
            angle: std::array::from_fn(|i| by(self.constants.storage[i].position)),
            position: by(self.constants.storage[2].position),
            force: std::array::from_fn(|i| Number::sqrt(n(3.0) * n(grasp.arms[i].ei) * w / cube).hi()),
        }
    }

    /// D with Ḣ ≤ −φH + D√(2H/θ).
    #[must_use]
    pub fn drive(&self, ports: &[Port; 3], disturbance: &Disturbance) -> f64 {
        let n = Interval::exact;
        let zero = n(0.0);
        let mut square = zero;
        for (end, (port, storage)) in ports.iter().zip(&self.constants.storage).enumerate() {
            // Both kinds at once: their slopes add up.
            let share = n(disturbance.size[end]) / n(port.inertia);
            let watched = port.observer > 0.0;
            let sudden = storage.steepness([share, if watched { share } else { zero }, zero]);
            let slow = if watched {
                let rate = n(disturbance.rate[end]) / (n(port.assumed_inertia) * n(port.observer));
                storage.steepness([zero, zero, rate])
            } else {
                zero
            };
            let both = Number::sqrt(sudden) + Number::sqrt(slow);
            square = square + both * both;
        }
        if *disturbance == Disturbance::default() { 0.0 } else { Number::sqrt(square).hi() }
    }

    /// The ultimate bound under these disturbances.
    #[must_use]
    pub fn ultimate(&self, grasp: &Grasp, ports: &[Port; 3], disturbance: &Disturbance) -> Bound {
        let n = Interval::exact;
        let drive = self.drive(ports, disturbance);
        let root = n(drive) / (n(self.phi) * n(self.theta));
        self.implied(grasp, if drive == 0.0 { 0.0 } else { (n(2.0) * root * root).hi() })
    }

    /// W at rest with these errors of the angles and of the position, with arms in static bending and observers that have
    /// learnt the disturbances \[J\].
    #[must_use]
    pub fn energy_at_rest(&self, grasp: &Grasp, ports: &[Port; 3], angle: [f64; 2], position: f64) -> f64 {
        let l = grasp.length;
        let mut energy = 0.0;
        let mut load = [0.0; 3];
        for i in 0..2 {
            let tip = l * angle[i] - position;
            let force = grasp.tip_stiffness(i) * tip;
            energy += 0.5 * force * tip;
            load[i] = force * l;
            load[2] -= force;
        }
        let errors = [angle[0], angle[1], position];
        for (end, storage) in self.constants.storage.iter().enumerate() {
            energy += storage.at_rest(&ports[end], errors[end], load[end]);
        }
        energy
    }

    /// Time after which both bending forces certainly stay within `tolerance` \[N\] without disturbances, from W =
    /// `energy`.
    #[must_use]
    pub fn settling_time(&self, grasp: &Grasp, energy: f64, tolerance: f64) -> f64 {
        let allowed = (0..2).map(|i| 0.5 * tolerance.powi(2) / grasp.tip_stiffness(i)).fold(f64::INFINITY, f64::min);
        ((2.0 - self.theta) / self.theta * energy / allowed).ln().max(0.0) / self.phi
    }
}

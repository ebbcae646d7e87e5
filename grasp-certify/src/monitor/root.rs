//! H of the root-strain law, and its certified bound.

use super::{COLUMNS, Mirror, Sample};
use crate::root_strain::{Certificate, Port, certify};
use crate::settings::Settings;

/// H of the root-strain law without observers. Everything else in the law is treated as a disturbance D(t), and so are
/// limits, sampling and noise.
#[derive(Clone, Debug)]
pub struct RootLaw {
    ports: [Port; 3],
    certificate: Certificate,
    /// √H may not exceed this.
    root: Option<f64>,
}

impl RootLaw {
    /// For these gains. None if no certificate is found.
    #[must_use]
    pub fn new(settings: &Settings) -> Option<Self> {
        let ports = settings.ports()?.map(Port::without_observer);
        let certificate = certify(&settings.grasp(), &ports)?;
        Some(Self { ports, certificate, root: None })
    }

    /// φ \[1/s\].
    #[must_use]
    pub const fn phi(&self) -> f64 {
        self.certificate.phi
    }

    /// Loads' deviations from the target: M̃_1, M̃_2, S.
    fn loads(sample: &Sample, length: f64) -> [f64; 3] {
        let [m1, m2, q1, q2] = sample.load;
        [m1 + sample.lambda[0] * length, m2 + sample.lambda[1] * length, q1 + q2 - sample.lambda[0] - sample.lambda[1]]
    }

    /// D of the difference between the forces that acted and those of the law without observers, at an instant. `load_rate`
    /// are the rates of the loads.
    fn drive(&self, sample: &Sample, loads: [f64; 3], load_rate: [f64; 3], force: [f64; 3]) -> f64 {
        let mut square = 0.0;
        for (end, port) in self.ports.iter().enumerate() {
            let [position, rate, load, by_rate] = port.feedback();
            let wanted = -(position * sample.error[end]
                + rate * sample.rate[end]
                + load * loads[end]
                + by_rate * load_rate[end]);
            let extra = force[end] - wanted;
            square += self.certificate.constants.storage[end].crossed * (extra / port.inertia).powi(2);
        }
        square.sqrt()
    }

    /// The values of [`COLUMNS`] after a step of `h` \[s\] (0 at the first instant); `load_rate` are the rates of M̃_i and S at the
    /// beginning and the end of the step.
    pub fn values(
        &mut self,
        mirror: &Mirror,
        h: f64,
        samples: [&Sample; 2],
        load_rate: [[f64; 3]; 2],
    ) -> [f64; COLUMNS.len()] {
        let length = mirror.length();
        let now = samples[1];
        let integrals = mirror.integrals(now);
        let c = &self.certificate.constants;
        let loads = Self::loads(now, length);
        // The actuators' forces include the static ones (M^d, sum of λ); only deviations count here.
        let rest = [-now.lambda[0] * length, -now.lambda[1] * length, now.lambda[0] + now.lambda[1]];
        let force = std::array::from_fn(|i| mirror.force()[i] - rest[i]);
        let drive = [0, 1]
            .map(|k| self.drive(samples[k], Self::loads(samples[k], length), load_rate[k], force))
            .into_iter()
            .fold(0.0, f64::max);
        let drive = if h > 0.0 { drive } else { 0.0 };
        let storage: [f64; 3] = std::array::from_fn(|end| {
            let s = &c.storage[end];
            let zeta = now.rate[end] + self.ports[end].crossing() * loads[end];
            let crossed = zeta + s.slope * now.error[end];
            0.5 * (s.position * now.error[end].powi(2) + s.crossed * crossed.powi(2))
        });
        let crossing = c.epsilon_1 * integrals.first + c.epsilon_2 * integrals.second;
        let energy = integrals.energy + crossing + storage.iter().sum::<f64>();
        let phi = self.certificate.phi;
        let decay = (-0.5 * phi * h).exp();
        // d√H/dt ≤ −½φ√H + D/√(2θ), with the largest D of the step's ends.
        let root = self.root.map_or(energy.max(0.0).sqrt(), |root| {
            decay * root + drive / (2.0 * self.certificate.theta).sqrt() * (1.0 - decay) * 2.0 / phi
        });
        self.root = Some(root);
        let [hub_1, hub_2, object] = storage;
        [energy, integrals.energy, crossing, object, hub_1, hub_2, drive, root * root]
    }
}

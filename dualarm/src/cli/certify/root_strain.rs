//! Results of `certify` about the root-strain law, as text and as JSON.

use std::fmt;

use grasp_certify::root_strain::{Bound, Certificate, Disturbance, Leakage, Obstacle, Port, certify, obstacle};
use grasp_certify::settings::Settings;
use grasp_certify::spectrum::{Characteristic, Region, eigenvalues};
use grasp_certify::{Grasp, LinearLoop};
use serde::Serialize;

/// The band of settling for the guaranteed force: this share of the force.
const SETTLED: f64 = 0.02;

/// `--mode root-strain`.
#[derive(Serialize)]
pub struct RootStrain {
    command: &'static str,
    mode: &'static str,
    /// `certified`, `impossible` (for certificates of this kind), `not found`.
    verdict: &'static str,
    /// Hub 1, hub 2, object.
    ends: [Port; 3],
    /// Why no certificate of this kind exists.
    obstacle: Option<Obstacle>,
    /// Features of these gains that the proof does not cover.
    uncovered: Vec<&'static str>,
    /// Bounds of disturbances.
    disturbance: Disturbance,
    /// The law without observers.
    #[serde(flatten)]
    core: Proof,
    /// The law with its observers.
    observed: Proof,
    /// The part of `certificate` that would remain with the paper's adaptation.
    leakage: Option<Leakage>,
    /// Largest real part among the exact eigenvalues examined, without observers \[1/s\].
    abscissa: Option<f64>,
    /// The region examined \[1/s\]: left, right, bottom, top.
    region: [f64; 4],
    /// Eigenvalues in it with Im >= 0.
    eigenvalues: usize,
}

/// A certificate and its consequences.
#[derive(Default, Serialize)]
struct Proof {
    certificate: Option<Certificate>,
    /// In the end, under the given disturbances.
    ultimate: Option<Bound>,
    /// Time after which the forces are certainly within 2 % of `lambda1_ref` \[s\], without disturbances.
    settling_time: Option<f64>,
}

impl Proof {
    fn new(settings: &Settings, grasp: &Grasp, ports: &[Port; 3]) -> Self {
        let certificate = certify(grasp, ports);
        let (angle, position) = settings.start_errors();
        let settling_time = certificate.map(|certificate| {
            let energy = certificate.energy_at_rest(grasp, ports, angle, position);
            certificate.settling_time(grasp, energy, SETTLED * settings.references.lambda1_ref.abs())
        });
        let ultimate = certificate.map(|certificate| certificate.ultimate(grasp, ports, &settings.disturbance));
        Self { certificate, ultimate, settling_time }
    }

    fn write(&self, f: &mut fmt::Formatter<'_>, what: &str) -> fmt::Result {
        let (Some(c), Some(u), Some(time)) = (&self.certificate, &self.ultimate, self.settling_time) else {
            return writeln!(f, "{what}: no certificate found, which proves nothing");
        };
        writeln!(f, "{what}: certified in interval arithmetic")?;
        writeln!(f, "  energy decays at least with phi = {:.4} 1/s, amplitudes with {:.4} 1/s", c.phi, 0.5 * c.phi)?;
        writeln!(
            f,
            "  theta {:.4}, epsilon_1 {:.4}, epsilon_2 {:.4}, tau {:.4} {:.4}",
            c.theta, c.constants.epsilon_1, c.constants.epsilon_2, c.constants.tau[0], c.constants.tau[1]
        )?;
        for (end, storage) in ["hub 1", "hub 2", "object"].iter().zip(c.constants.storage) {
            let (a, b, w) = (storage.position, storage.crossed, storage.slope);
            writeln!(f, "  storage of {end}: A {a:.4e}, B {b:.4e}, w {w:.4}")?;
        }
        writeln!(f, "  without disturbances the forces are within 2 % after {time:.2} s at the latest")?;
        writeln!(f, "  in the end, with these disturbances: {}", Line(u))
    }
}

/// A bound in a line.
struct Line<'a>(&'a Bound);

impl fmt::Display for Line<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Bound { angle, position, force, .. } = self.0;
        write!(
            f,
            "|p| <= {:.4} mm, |e| <= {:.4e}, {:.4e} rad, force {:.3}, {:.3} mN",
            1e3 * position,
            angle[0],
            angle[1],
            1e3 * force[0],
            1e3 * force[1]
        )
    }
}

/// The region in which eigenvalues are searched. The corners avoid round numbers, on which an eigenvalue could lie.
const REGION: Region = Region { left: -60.37, right: 40.61, bottom: -1.073, top: 4000.9 };

/// Largest real part among the exact eigenvalues in the region, without observers, and their number.
pub fn abscissa(grasp: &Grasp, ports: &[Port; 3]) -> (Option<f64>, usize) {
    let function = Characteristic { grasp: *grasp, feedback: LinearLoop::root_strain(ports), kelvin_voigt: 0.0 };
    match eigenvalues(&function, &REGION) {
        Ok(found) => (found.first().map(|first| first.s.re), found.len()),
        Err(_) => (None, 0),
    }
}

impl RootStrain {
    pub fn new(settings: &Settings) -> Result<Self, &'static str> {
        let grasp = settings.grasp();
        let ports = settings.ports().ok_or(
            "with tip_uncertainty the force on the object is no feedback of its load where the arms differ in stiffness: set \
             tip_uncertainty=0, or equal EI1 and EI2",
        )?;
        let bare = ports.map(Port::without_observer);
        let obstacle = obstacle(&grasp, &ports);
        // There is no search for a certificate that cannot exist.
        let prove = |ports| if obstacle.is_some() { Proof::default() } else { Proof::new(settings, &grasp, ports) };
        let (core, observed) = (prove(&bare), prove(&ports));
        let verdict = match (&observed.certificate, &obstacle) {
            (Some(_), _) => "certified",
            (None, Some(_)) => "impossible",
            (None, None) => "not found",
        };
        let leakage = core.certificate.map(|certificate| certificate.with_leakage(&grasp, settings.estimators()));
        let (abscissa, eigenvalues) = abscissa(&grasp, &bare);
        Ok(Self {
            command: "certify",
            mode: "root-strain",
            verdict,
            ends: ports,
            obstacle,
            uncovered: settings.uncovered(),
            disturbance: settings.disturbance,
            core,
            observed,
            leakage,
            abscissa,
            region: [REGION.left, REGION.right, REGION.bottom, REGION.top],
            eigenvalues,
        })
    }
}

impl fmt::Display for RootStrain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Obstacle { value, limit }) = &self.obstacle {
            writeln!(
                f,
                "root-strain law: no certificate of this kind exists, whatever its constants: K = {value:.3} has to be below {limit}"
            )?;
            writeln!(f, "  what helps: a smaller r_slope1 and r_slope2, a larger r_strain1 and r_strain2")?;
        } else {
            self.core.write(f, "root-strain law without observers")?;
            self.observed.write(f, "root-strain law with its observers")?;
        }
        if let Some(Leakage { phi, ultimate, .. }) = &self.leakage {
            writeln!(f, "learning from s with the paper's rates and leakages instead would cost:")?;
            writeln!(f, "  phi {phi:.3e} 1/s, and in the end {}", Line(ultimate))?;
        }
        match self.abscissa {
            Some(abscissa) => writeln!(
                f,
                "exact eigenvalues without observers: {} with {} < Re < {} and {} < Im < {}, counted; amplitudes of the slowest decay \
                 with {:.4} 1/s",
                self.eigenvalues, self.region[0], self.region[1], self.region[2], self.region[3], -abscissa
            )?,
            None => writeln!(f, "no exact eigenvalue was found with Re > {}", self.region[0])?,
        }
        writeln!(f, "Holds for undamped beams in continuous time, within the actuators' limits.")?;
        for part in &self.uncovered {
            writeln!(f, "Not in it, but in these gains: {part}.")?;
        }
        writeln!(f, "Not in it: limits, sampling, delay, noise.")
    }
}

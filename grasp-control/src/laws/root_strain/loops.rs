//! The three loops at one instant: surfaces, forces, commands; and how they change with the signals.

use super::RootStrainGains;
use crate::laws::encoders::Actuation;
use crate::target::Arms;

/// Signals of the law at one instant, or their change.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Point {
    /// eᵢ \[rad\].
    pub e: [f64; 2],
    /// Predicted rates of the hubs \[rad/s\].
    pub omega: [f64; 2],
    /// M̃ᵢ \[N·m\] and its rate.
    pub moment: [f64; 2],
    pub moment_rate: [f64; 2],
    /// Measured root moments \[N·m\].
    pub load: [f64; 2],
    /// p \[m\] and the object's predicted rate \[m/s\].
    pub p: f64,
    pub v: f64,
    /// Q \[N\] and its rate.
    pub shear: f64,
    pub shear_rate: f64,
    /// m̂ \[kg\].
    pub mass: f64,
    /// Δ̂ of hub 1, hub 2 \[N·m\] and of the object \[N\].
    pub unknown: [f64; 3],
}

/// What the loops make of a point, or the change of that.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outcome {
    /// s and sᵢ.
    pub object: f64,
    pub posture: [f64; 2],
    /// Commands.
    pub u: f64,
    pub tau: [f64; 2],
}

/// Properties of the arms that turn strain into motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Compliance {
    /// aᵢ = l/3EIᵢ \[rad/(N·m)\].
    pub root: [f64; 2],
    /// 3EIᵢ/l³ \[N/m\].
    pub tip_stiffness: [f64; 2],
    /// b \[m/N\].
    pub tip: f64,
}

impl Compliance {
    pub fn of(arms: &Arms) -> Self {
        let l = arms.length;
        let tip_stiffness = arms.ei.map(|ei| 3.0 * ei / (l * l * l));
        Self { root: arms.ei.map(|ei| l / (3.0 * ei)), tip_stiffness, tip: 1.0 / (tip_stiffness[0] + tip_stiffness[1]) }
    }
}

/// The loops with all that does not change from step to step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loops<'a> {
    gains: &'a RootStrainGains,
    actuation: &'a Actuation,
    /// σᵢ aᵢ \[rad/(N·m·s)\] and κ b \[m/(N·s)\].
    root: [f64; 2],
    tip: f64,
}

/// The object's loop without the arms' strain.
struct Object {
    /// G(p) p + ṗ \[m/s\].
    s: f64,
    /// f G ṗ \[m/s²\].
    forward: f64,
    /// The force on the object that is wanted to move it \[N\].
    force: f64,
}

impl<'a> Loops<'a> {
    pub fn new(arms: &Arms, gains: &'a RootStrainGains, actuation: &'a Actuation) -> Self {
        let compliance = Compliance::of(arms);
        Self {
            gains,
            actuation,
            root: [0, 1].map(|i| gains.hub[i].strain * compliance.root[i]),
            tip: gains.object.strain * compliance.tip,
        }
    }

    /// (1 + r)^(−½) and r = |p| m̂ G²/(2 q u_max), which bends the surface.
    fn bend(&self, at: &Point) -> (f64, f64) {
        let g = &self.gains.object;
        let r = at.p.abs() * at.mass * g.slope * g.slope / (2.0 * g.brake * self.actuation.force_limit);
        ((1.0 + r).sqrt().recip(), r)
    }

    fn object(&self, at: &Point) -> Object {
        let g = &self.gains.object;
        let s = g.slope * self.bend(at).0 * at.p + at.v;
        let forward = g.feedforward * g.slope * at.v;
        let force = -at.mass * (g.reach * s + forward) - at.v / self.tip;
        Object { s, forward, force }
    }

    /// Surfaces and commands.
    pub fn at(&self, at: &Point) -> Outcome {
        let object = self.object(at);
        let mut posture = [0.0; 2];
        let tau = std::array::from_fn(|i| {
            let g = &self.gains.hub[i];
            posture[i] = g.slope * at.e[i] + at.omega[i] + self.root[i] * at.moment[i];
            let forward = g.feedforward * (g.slope * at.omega[i] + self.root[i] * at.moment_rate[i]);
            at.load[i]
                - self.actuation.hub_inertia[i] * (g.reach * posture[i] + forward)
                - at.omega[i] / self.root[i]
                - at.unknown[i]
        });
        let g = &self.gains.object;
        let strain = self.tip * at.shear;
        let damping = at.mass * (g.reach * strain + g.feedforward * self.tip * at.shear_rate);
        Outcome { object: object.s + strain, posture, u: at.shear + object.force - damping - at.unknown[2], tau }
    }

    /// Change of surfaces and commands for a change `by` of the point.
    pub fn change(&self, at: &Point, by: &Point) -> Outcome {
        let g = &self.gains.object;
        let object = self.object(at);
        let (bend, r) = self.bend(at);
        let s = g.slope * (bend - 0.5 * r * bend.powi(3)) * by.p
            - 0.5 * g.slope * at.p * r * bend.powi(3) * by.mass / at.mass
            + by.v;
        let forward = g.feedforward * g.slope * by.v;
        let force =
            -by.mass * (g.reach * object.s + object.forward) - at.mass * (g.reach * s + forward) - by.v / self.tip;
        let mut posture = [0.0; 2];
        let tau = std::array::from_fn(|i| {
            let g = &self.gains.hub[i];
            posture[i] = g.slope * by.e[i] + by.omega[i] + self.root[i] * by.moment[i];
            let forward = g.feedforward * (g.slope * by.omega[i] + self.root[i] * by.moment_rate[i]);
            by.load[i]
                - self.actuation.hub_inertia[i] * (g.reach * posture[i] + forward)
                - by.omega[i] / self.root[i]
                - by.unknown[i]
        });
        let g = &self.gains.object;
        let strain = self.tip * by.shear;
        let damping = at.mass * (g.reach * strain + g.feedforward * self.tip * by.shear_rate)
            + by.mass * (g.reach * self.tip * at.shear + g.feedforward * self.tip * at.shear_rate);
        Outcome { object: s + strain, posture, u: by.shear + force - damping - by.unknown[2], tau }
    }
}

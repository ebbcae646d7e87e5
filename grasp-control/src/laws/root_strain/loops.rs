//! The three loops at one instant: surfaces, forces, commands; and how they change with the signals.

use super::RootStrainGains;
use super::natural::Scaled;
use crate::laws::encoders::Actuation;

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
    /// Ĵᵢ \[kg·m²\].
    pub inertia: [f64; 2],
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

/// The loops with all that does not change from step to step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loops<'a> {
    pub gains: &'a RootStrainGains,
    pub scaled: &'a Scaled,
    pub actuation: &'a Actuation,
}

/// The object's loop without the arms' strain.
struct Object {
    /// G(p) p + ṗ \[m/s\].
    s: f64,
    /// f G ṗ \[m/s²\].
    forward: f64,
}

impl Loops<'_> {
    /// (1 + r)^(−½) and r = |p| m̂ G²/(2 q u_max), which bends the surface.
    fn bend(&self, at: &Point) -> (f64, f64) {
        let slope = self.scaled.slope;
        let r = at.p.abs() * at.mass * slope * slope / (2.0 * self.gains.object.brake * self.actuation.force_limit);
        ((1.0 + r).sqrt().recip(), r)
    }

    fn object(&self, at: &Point) -> Object {
        let s = self.scaled.slope * self.bend(at).0 * at.p + at.v;
        Object { s, forward: self.gains.object.feedforward * self.scaled.slope * at.v }
    }

    /// κ √(b/m̂), the share of the shears in the object's surface \[m/(N·s)\].
    pub fn tip(&self, at: &Point) -> f64 {
        self.scaled.strain / at.mass.sqrt()
    }

    /// kᵢ (Gᵢ eᵢ + ėᵢ) + fᵢ Gᵢ ėᵢ + ėᵢ/cᵢ, which Ĵᵢ multiplies \[rad/s²\].
    fn turning(&self, i: usize, at: &Point) -> f64 {
        let (g, slope) = (&self.gains.hub[i], self.scaled.hub_slope[i]);
        self.scaled.hub_reach[i] * (slope * at.e[i] + at.omega[i])
            + (g.feedforward * slope + self.scaled.hub_strain[i].recip()) * at.omega[i]
    }

    /// cᵢ (kᵢ M̃ᵢ + fᵢ M̃̇ᵢ) \[N·m\].
    fn yielding(&self, i: usize, at: &Point) -> f64 {
        let scaled = self.scaled;
        let answer = scaled.hub_reach[i] * at.moment[i] + self.gains.hub[i].feedforward * at.moment_rate[i];
        scaled.hub_strain[i] * answer
    }

    /// Surfaces and commands.
    #[inline(always)]
    pub fn at(&self, at: &Point) -> Outcome {
        let posture = std::array::from_fn(|i| {
            self.scaled.hub_slope[i] * at.e[i] + at.omega[i] + self.scaled.hub_strain[i] * at.moment[i] / at.inertia[i]
        });
        let tau = std::array::from_fn(|i| {
            at.load[i] - at.inertia[i] * self.turning(i, at) - self.yielding(i, at) - at.unknown[i]
        });
        let (object, tip) = (self.object(at), self.tip(at));
        let (k, f) = (self.scaled.reach, self.gains.object.feedforward);
        let force = -at.mass * (k * object.s + object.forward) - at.v / tip;
        let damping = at.mass * tip * (k * at.shear + f * at.shear_rate);
        Outcome { object: object.s + tip * at.shear, posture, u: at.shear + force - damping - at.unknown[2], tau }
    }

    /// Change of surfaces and commands for a change `by` of the point.
    pub fn change(&self, at: &Point, by: &Point) -> Outcome {
        let posture = std::array::from_fn(|i| {
            let share = self.scaled.hub_strain[i] / at.inertia[i];
            self.scaled.hub_slope[i] * by.e[i] + by.omega[i] + share * by.moment[i]
                - share * at.moment[i] * by.inertia[i] / at.inertia[i]
        });
        let tau = std::array::from_fn(|i| {
            by.load[i]
                - at.inertia[i] * self.turning(i, by)
                - by.inertia[i] * self.turning(i, at)
                - self.yielding(i, by)
                - by.unknown[i]
        });
        let (object, tip) = (self.object(at), self.tip(at));
        let (k, f, slope) = (self.scaled.reach, self.gains.object.feedforward, self.scaled.slope);
        let (bend, r) = self.bend(at);
        let s = slope * (bend - 0.5 * r * bend.powi(3)) * by.p
            - 0.5 * slope * at.p * r * bend.powi(3) * by.mass / at.mass
            + by.v;
        let by_tip = -0.5 * tip * by.mass / at.mass;
        let force = -by.mass * (k * object.s + object.forward) - at.mass * (k * s + f * slope * by.v) - by.v / tip
            + at.v * by_tip / (tip * tip);
        // m̂ κ √(b/m̂) grows like √m̂.
        let damping =
            at.mass * tip * (k * by.shear + f * by.shear_rate) - at.mass * by_tip * (k * at.shear + f * at.shear_rate);
        let u = by.shear + force - damping - by.unknown[2];
        Outcome { object: s + tip * by.shear + by_tip * at.shear, posture, u, tau }
    }
}

//! The three loops at one instant: surfaces, forces, commands; and how they change with the signals.

use super::RootStrainGains;
use super::natural::Scaled;

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
}

/// The object's loop without the arms' strain.
struct Object {
    /// G(p) p \[m/s\].
    pull: f64,
    /// D = k + f G + 1/(m̂ C), which damps the object's rate \[1/s\].
    damping: f64,
    /// D² + B m̂ |p|, whose root is D while the target is near.
    bend: f64,
    /// C = κ √(b/m̂), the share of the shears in the surface \[m/(N·s)\].
    tip: f64,
}

impl Loops<'_> {
    fn object(&self, at: &Point) -> Object {
        let scaled = self.scaled;
        let root = at.mass.sqrt().recip();
        let damping = scaled.damping + scaled.inverse_strain * root;
        let bend = damping * damping + scaled.bend * at.mass * at.p.abs();
        Object { pull: scaled.slope * at.p * damping / bend.sqrt(), damping, bend, tip: scaled.strain * root }
    }

    /// Change of G(p) p.
    fn pull_change(&self, at: &Point, object: &Object, by: &Point) -> f64 {
        let Object { damping, bend, .. } = *object;
        let bent = self.scaled.bend * at.p.abs();
        // m̂ ∂D/∂m̂ is half of what D has above the part that does not depend on m̂, with a minus.
        let by_mass = -0.5 * at.p * bent * (2.0 * damping - self.scaled.damping) * by.mass;
        let by_way = damping * (damping * damping + 0.5 * bent * at.mass) * by.p;
        self.scaled.slope * (by_way + by_mass) / (bend * bend.sqrt())
    }

    /// C \[m/(N·s)\].
    pub fn tip(&self, at: &Point) -> f64 {
        self.scaled.strain * at.mass.sqrt().recip()
    }

    /// By how much Gᵢ of a hub of this inertia is more than that of a light one \[1/s\]. Without a branch, for both hubs at once.
    fn rise(&self, i: usize, inertia: f64) -> f64 {
        let rise = self.scaled.hub_rise[i] - self.scaled.hub_fall[i] / inertia;
        if rise > 0.0 { rise } else { 0.0 }
    }

    /// Gᵢ of a hub of this inertia \[1/s\].
    pub fn hub_slope(&self, i: usize, inertia: f64) -> f64 {
        self.scaled.hub_slope[i] + self.rise(i, inertia)
    }

    /// Change of [`hub_slope`](Self::hub_slope).
    pub fn hub_slope_change(&self, i: usize, inertia: f64, by: f64) -> f64 {
        if self.rise(i, inertia) > 0.0 { self.scaled.hub_fall[i] / (inertia * inertia) * by } else { 0.0 }
    }

    /// What Gᵢ multiplies in `turning`: kᵢ eᵢ + fᵢ ėᵢ.
    fn sloping(&self, i: usize, at: &Point) -> f64 {
        self.scaled.hub_reach[i] * at.e[i] + self.gains.hub[i].feedforward * at.omega[i]
    }

    /// kᵢ (Gᵢ eᵢ + ėᵢ) + fᵢ Gᵢ ėᵢ + ėᵢ/cᵢ, which Ĵᵢ multiplies \[rad/s²\], with Gᵢ for this inertia.
    fn turning(&self, i: usize, inertia: f64, at: &Point) -> f64 {
        let light = self.scaled.hub_pull[i] * at.e[i] + self.scaled.hub_damping[i] * at.omega[i];
        light + self.rise(i, inertia) * self.sloping(i, at)
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
            self.hub_slope(i, at.inertia[i]) * at.e[i]
                + at.omega[i]
                + self.scaled.hub_strain[i] * at.moment[i] / at.inertia[i]
        });
        let tau = std::array::from_fn(|i| {
            at.load[i] - at.inertia[i] * self.turning(i, at.inertia[i], at) - self.yielding(i, at) - at.unknown[i]
        });
        let object = self.object(at);
        let tip = object.tip;
        let (k, f) = (self.scaled.reach, self.gains.object.feedforward);
        let motion = k * object.pull + object.damping * at.v + tip * (k * at.shear + f * at.shear_rate);
        let surface = object.pull + at.v + tip * at.shear;
        Outcome { object: surface, posture, u: at.shear - at.mass * motion - at.unknown[2], tau }
    }

    /// Change of surfaces and commands for a change `by` of the point.
    pub fn change(&self, at: &Point, by: &Point) -> Outcome {
        let by_slope: [f64; 2] = std::array::from_fn(|i| self.hub_slope_change(i, at.inertia[i], by.inertia[i]));
        let posture = std::array::from_fn(|i| {
            let share = self.scaled.hub_strain[i] / at.inertia[i];
            self.hub_slope(i, at.inertia[i]) * by.e[i] + by_slope[i] * at.e[i] + by.omega[i] + share * by.moment[i]
                - share * at.moment[i] * by.inertia[i] / at.inertia[i]
        });
        let tau = std::array::from_fn(|i| {
            let turning = self.turning(i, at.inertia[i], by) + by_slope[i] * self.sloping(i, at);
            by.load[i]
                - at.inertia[i] * turning
                - by.inertia[i] * self.turning(i, at.inertia[i], at)
                - self.yielding(i, by)
                - by.unknown[i]
        });
        let object = self.object(at);
        let tip = object.tip;
        let (k, f) = (self.scaled.reach, self.gains.object.feedforward);
        let pull = self.pull_change(at, &object, by);
        let by_tip = -0.5 * tip * by.mass / at.mass;
        let strain = |point: &Point| k * point.shear + f * point.shear_rate;
        // m̂ D and m̂ C: 1/(m̂ C) falls and m̂ C grows like √m̂.
        let by_mass = k * object.pull + 0.5 * (object.damping + self.scaled.damping) * at.v + 0.5 * tip * strain(at);
        let motion = k * pull + object.damping * by.v + tip * strain(by);
        let u = by.shear - by.mass * by_mass - at.mass * motion - by.unknown[2];
        Outcome { object: pull + by.v + tip * by.shear + by_tip * at.shear, posture, u, tau }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::encoders::Actuation;
    use crate::target::Arms;

    const GAINS: fn() -> RootStrainGains = RootStrainGains::default;

    fn scaled(gains: &RootStrainGains) -> Scaled {
        Scaled::new(gains, &Arms::default(), &Actuation::default())
    }

    fn point(p: f64, inertia: f64, mass: f64) -> Point {
        Point {
            e: [0.1, -0.2],
            omega: [0.7, 0.4],
            moment: [0.03, -0.05],
            moment_rate: [1.0, 2.0],
            load: [0.1, 0.2],
            inertia: [inertia; 2],
            p,
            v: -0.05,
            shear: 0.2,
            shear_rate: 3.0,
            mass,
            unknown: [0.01, 0.02, 0.03],
        }
    }

    /// Differences over 2e-6 of the point err by less than 1e-8 of the commands' scale.
    #[test]
    fn changes_are_derivatives() {
        let gains = GAINS();
        let scaled = scaled(&gains);
        let loops = Loops { gains: &gains, scaled: &scaled };
        let by = point(0.003, 0.002, 0.3);
        for (p, inertia, mass) in [(0.04, 0.0073, 0.5), (-0.0002, 0.05, 5.0), (0.03, 0.1, 0.2), (-0.15, 0.0147, 11.0)] {
            let at = point(p, inertia, mass);
            let along = |h: f64| {
                let pair = |a: [f64; 2], b: [f64; 2]| [a[0] + h * b[0], a[1] + h * b[1]];
                loops.at(&Point {
                    e: pair(at.e, by.e),
                    omega: pair(at.omega, by.omega),
                    moment: pair(at.moment, by.moment),
                    moment_rate: pair(at.moment_rate, by.moment_rate),
                    load: pair(at.load, by.load),
                    inertia: pair(at.inertia, by.inertia),
                    p: at.p + h * by.p,
                    v: at.v + h * by.v,
                    shear: at.shear + h * by.shear,
                    shear_rate: at.shear_rate + h * by.shear_rate,
                    mass: at.mass + h * by.mass,
                    unknown: std::array::from_fn(|i| at.unknown[i] + h * by.unknown[i]),
                })
            };
            let (before, after, change) = (along(-1e-6), along(1e-6), loops.change(&at, &by));
            let numbers = |o: &Outcome| [o.object, o.posture[0], o.posture[1], o.u, o.tau[0], o.tau[1]];
            for ((low, high), exact) in numbers(&before).into_iter().zip(numbers(&after)).zip(numbers(&change)) {
                let slope = (high - low) / 2e-6;
                assert!((slope - exact).abs() < 1e-7 * (1.0 + exact.abs()), "{p} {inertia} {mass}: {slope} {exact}");
            }
        }
    }

    /// Far from the target the command vanishes where the object has the rate from which the share q of the limit stops it there.
    #[test]
    fn the_object_follows_the_parabola() {
        let gains = GAINS();
        let scaled = scaled(&gains);
        let loops = Loops { gains: &gains, scaled: &scaled };
        for (way, mass) in [(0.05, 0.5), (-0.2, 10.0)] {
            let v = -(2.0 * gains.object.brake * 0.3 * f64::abs(way) / mass).sqrt() * f64::signum(way);
            let push = |v: f64| loops.at(&Point { p: way, v, mass, inertia: [0.0073; 2], ..Point::default() }).u;
            // (D/kG)² against m̂ |p|/(2 q u_max) of the curve: a hundredth.
            assert!(
                push(0.99 * v) * way < 0.0 && push(1.01 * v) * way > 0.0,
                "{way} {mass}: {} {}",
                push(0.99 * v),
                push(1.01 * v)
            );
        }
        let straight =
            RootStrainGains { object: crate::laws::root_strain::ObjectGains { brake: 0.0, ..gains.object }, ..gains };
        let scaled = self::scaled(&straight);
        let loops = Loops { gains: &straight, scaled: &scaled };
        let pull = |p: f64| loops.at(&Point { p, mass: 0.5, inertia: [0.0073; 2], ..Point::default() }).object;
        assert!((pull(0.2) - 200.0 * pull(0.001)).abs() < 1e-12 * pull(0.2));
    }

    /// A heavy hub's slope has no jump where it begins, and tends to what its strain would give.
    #[test]
    fn heavy_hubs_have_steeper_surfaces() {
        let gains = GAINS();
        let scaled = scaled(&gains);
        let loops = Loops { gains: &gains, scaled: &scaled };
        let slope = |times: f64| loops.hub_slope(0, 0.0073 * times);
        assert_eq!(slope(0.5), scaled.hub_slope[0]);
        assert_eq!(slope(2.0), scaled.hub_slope[0]);
        assert!((slope(2.0 + 1e-9) - slope(2.0)).abs() < 1e-6);
        // c Ω² = 3.382 · 15.37 1/s.
        assert!((slope(1e9) - scaled.hub_slope[0] - 0.4 * 3.382 * 15.372_097).abs() < 1e-4);
    }
}

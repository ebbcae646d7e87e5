//! The shortest time in which the target can be reached.
//!
//! Let the object of mass M be pushed over the distance d by at most F, from rest. It has settled once |p| ≤ ε d for good, so
//! it may still move when it enters the band, as long as braking with F keeps it inside: from speed v at the edge it stops
//! within v²/2a ≤ 2 ε d, a = F/M. Full thrust, then full brake gives the shortest time,
//!
//! ```text
//! T = 2 (√(1+ε) − √ε) √(M d/F)          (ε = 2 %: 1.737 √(M d/F))
//! ```
//!
//! The thrust consists of the force actuator with |u| ≤ uₘ, a disturbance ΔF, and the difference f₁ − f₂ of the contact
//! forces. While contact is kept and no force overshoots the target by more than ε, each contact force is between 0 and
//! (1+ε)|λᵈ|. So the arms, however strong their hubs, add no more than (1+ε)|λᵈ|:
//!
//! ```text
//! F = uₘ + |ΔF| + (1+ε)|λᵈ|
//! ```
//!
//! A hub of inertia J turns by Δθ with its torque limit and the moment (1+ε)|λᵈ| l with which the arm then loads it
//! (quasi-static arms). The limit is the longest of the three times. A controller that is faster has broken contact or
//! overshot.
//!
//! Arms that add (1+ε)|λᵈ| as long as the object moves have released one side, press on the other side with the largest
//! allowed force, and change sides at once. If a controller keeps the forces constant meanwhile, only the force actuator, F
//! = uₘ + |ΔF|, moves the object and both tips, m₁ + m₂ + M. This is the second limit.

/// Half of the width of a band, relative to its reference value.
pub const BAND: f64 = 0.02;

/// One body that has to be moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Mass in kg or inertia in kg·m².
    pub inertia: f64,
    /// Way in m or rad.
    pub way: f64,
    /// Largest thrust in N or N·m; `None` means no limit.
    pub thrust: Option<f64>,
}

/// Shortest time in s in which a body gets from rest into the band of [`BAND`] times its way, and stays there.
#[must_use]
pub fn shortest(body: Body) -> f64 {
    let Body { inertia, way, thrust } = body;
    let Some(thrust) = thrust.filter(|thrust| *thrust > 0.0) else { return 0.0 };
    2.0 * ((1.0 + BAND).sqrt() - BAND.sqrt()) * (inertia * way.abs() / thrust).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thrust_and_brake_enter_the_band_in_this_time_and_stay() {
        let body = Body { inertia: 10.0, way: 1.1e-3, thrust: Some(0.8) };
        let limit = shortest(body);
        assert!((limit - 1.7371 * (10.0_f64 * 1.1e-3 / 0.8).sqrt()).abs() < 1e-5);
        // The same by hand: thrust over (1+ε)/2 of the way, then brake; it stops a band's width beyond the target.
        let a = 0.08;
        let switch = ((1.0 + BAND) * body.way / a).sqrt();
        let (mut y, mut v, mut t, h) = (0.0, 0.0, 0.0, 1e-6);
        let mut entered = None;
        while v >= 0.0 {
            let thrust = if t < switch { a } else { -a };
            y += h * v + 0.5 * h * h * thrust;
            v += h * thrust;
            t += h;
            if entered.is_none() && y >= (1.0 - BAND) * body.way {
                entered = Some(t);
            }
        }
        assert!((entered.unwrap() - limit).abs() < 1e-5, "{entered:?} instead of {limit}");
        assert!((y - (1.0 + BAND) * body.way).abs() < 1e-6);
        assert_eq!(shortest(Body { thrust: None, ..body }), 0.0);
    }
}

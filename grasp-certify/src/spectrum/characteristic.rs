//! The characteristic function of the exact grasp under linear feedback.
//!
//! With Y = xθ − w, ρ s² Y + EI(1 + κs) Y'''' = 0, Y(0) = Y''(l) = 0, Y'(0) = θ, and β⁴ = −ρs²/(EI(1 + κs)), the hub's
//! equation h θ = EI g Y''(0), h = J s² + …, g = 1 + κs + …, leaves one constant per arm. Up to it
//!
//! ```text
//! Y(l)    = EI g · sin β sinh β/β² + h (sin β cosh β − sinh β cos β)/(2β³)          =: N   (β l written β, lengths restored)
//! Y'''(l) = EI g · β⁴ (sin β cosh β − sinh β cos β)/(2β³) − h (1 + cos β cosh β)/2   =: S
//! ```
//!
//! and the object's equation is F = D N_1 N_2 − EI_1 R_1 S_1 N_2 − EI_2 R_2 S_2 N_1 = 0, D = m s² + …, R_i = 1 + κs + ….
//! All are entire functions of s (except at s = −1/κ), so the argument principle counts only zeros.

use super::complex::Complex;
use crate::{Grasp, LinearLoop};

/// Grasp, loop and material damping.
#[derive(Clone, Copy, Debug)]
pub struct Characteristic {
    /// The grasp.
    pub grasp: Grasp,
    /// The feedback.
    pub feedback: LinearLoop,
    /// Kelvin–Voigt coefficient κ \[s\].
    pub kelvin_voigt: f64,
}

/// sin x sinh x/x², (sin x cosh x − sinh x cos x)/(2x³), (1 + cos x cosh x)/2 as functions of x⁴.
fn beam_functions(fourth: Complex) -> [Complex; 3] {
    if fourth.abs() < 1.0 {
        // Σ(−1)^n 2^{2n+1} x^{4n}/(4n+2)!, Σ(−1)^n 2^{2n+1} x^{4n}/(4n+3)!, ½ + ½Σ(−4)^n x^{4n}/(4n)!; the remainder after
        // five terms is below 1e-17.
        let mut power = Complex::from(1.0);
        let mut sums = [Complex::from(0.0); 3];
        let mut factorial = 1.0;
        for n in 0..6 {
            let k = f64::from(4 * n);
            if n > 0 {
                factorial *= k * (k - 1.0) * (k - 2.0) * (k - 3.0);
                power = power * fourth * -4.0;
            }
            let second = factorial * (k + 1.0) * (k + 2.0);
            sums[0] = sums[0] + power * (2.0 / second);
            sums[1] = sums[1] + power * (2.0 / (second * (k + 3.0)));
            sums[2] = sums[2] + power * (0.5 / factorial);
        }
        sums[2] = sums[2] + Complex::from(0.5);
        return sums;
    }
    let square = fourth.sqrt();
    let x = square.sqrt();
    let [s, c, sh, ch] = x.waves();
    [(s * sh).div(square), (s * ch - sh * c).div(square * x * 2.0), (Complex::from(1.0) + c * ch) * 0.5]
}

impl Characteristic {
    /// F(s), up to a positive factor.
    #[must_use]
    pub fn value(&self, s: Complex) -> Complex {
        let Self { grasp, feedback, kelvin_voigt } = self;
        let l = grasp.length;
        let square = s * s;
        let material = Complex::from(1.0) + s * *kelvin_voigt;
        let linear = |constant: f64, rate: f64| Complex::from(constant) + s * rate;
        let ends: [(Complex, Complex); 2] = std::array::from_fn(|i| {
            let (arm, hub) = (&grasp.arms[i], &feedback.hub[i]);
            // (βl)⁴; ratio 1/l of the units of h and EI g.
            let fourth = (-(square * (arm.rho * l.powi(4) / arm.ei))).div(material);
            let [crossed, difference, free] = beam_functions(fourth);
            let h = (square * arm.hub_inertia + linear(hub.angle, hub.rate)) * l;
            let g = (material + linear(hub.moment, hub.moment_rate)) * arm.ei;
            // N l², S l⁵ in units without length: Y(l) = l²(…), Y'''(l) = l^{-1}(…).
            (g * crossed + h * difference, g * fourth * difference - h * free)
        });
        let object = &feedback.object;
        let d = square * grasp.mass + linear(object.position, object.rate);
        let pull = |i: usize| {
            (material + linear(object.shear[i], object.shear_rate[i])) * (grasp.arms[i].ei / l.powi(3)) * ends[i].1
        };
        d * ends[0].0 * ends[1].0 - pull(0) * ends[1].0 - pull(1) * ends[0].0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Series and closed forms agree where they meet.
    #[test]
    fn the_series_continue_the_functions() {
        for angle in [0.0, 0.7, 2.0, 3.1, -1.2] {
            let on = |r: f64| Complex::new(r * f64::cos(angle), r * f64::sin(angle));
            let (inner, outer) = (beam_functions(on(0.999_999_999)), beam_functions(on(1.000_000_001)));
            for (a, b) in inner.iter().zip(outer) {
                assert!((*a - b).abs() < 1e-8, "{a:?} {b:?}");
            }
        }
    }
}

//! e^x, sine and cosine from basic arithmetic alone: the system's functions differ between processors and versions.

use super::twofold::{Twofold, two_product, two_sum};

/// 1/m!.
pub(super) const INVERSE_FACTORIAL: [f64; 21] = {
    let mut values = [1.0; 21];
    let mut factorial = 1.0;
    let mut m = 1;
    while m < 21 {
        // Exact up to 18!.
        factorial *= m as f64;
        values[m] = 1.0 / factorial;
        m += 1;
    }
    values
};

/// Rounds to the nearest whole number, for magnitudes below 2⁵¹.
fn nearest(x: f64) -> f64 {
    const SHIFT: f64 = 6_755_399_441_055_744.0; // 1.5 · 2⁵²
    (x + SHIFT) - SHIFT
}

/// `x` · 2^k for whole k from −1200 to 1200.
fn times_power_of_two(x: f64, k: f64) -> f64 {
    // Each half is far inside the range of normal numbers; the numbers that are cast are integers and positive.
    let half = nearest(k / 2.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let power = |k: f64| f64::from_bits(((k + 1023.0) as u64) << 52);
    x * power(half) * power(k - half)
}

/// (e^x, e^x − 1).
pub(super) fn exponential(x: f64) -> (f64, f64) {
    const LN2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
    if x.is_nan() {
        return (x, x);
    }
    let x = x.clamp(-800.0, 800.0);
    let k = nearest(x * std::f64::consts::LOG2_E);
    // The upper part of ln 2 has 33 digits: its product is exact.
    let r = (x - k * LN2[0]) - k * LN2[1];
    let mut sum = INVERSE_FACTORIAL[13];
    for m in (2..13).rev() {
        sum = sum * r + INVERSE_FACTORIAL[m];
    }
    let less_one = r + r * r * sum;
    if k == 0.0 {
        return (1.0 + less_one, less_one);
    }
    let value = times_power_of_two(1.0 + less_one, k);
    (value, value - 1.0)
}

/// Sine, cosine and cosine − 1 of an angle below 2⁵⁰.
pub(super) fn sine_cosine(angle: Twofold) -> (f64, f64, f64) {
    /// π/2 in three parts.
    const HALF_PI: [f64; 3] = [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_183_3e-33];
    let quarters = nearest(angle.hi * std::f64::consts::FRAC_2_PI);
    let (product, error) = two_product(quarters, HALF_PI[0]);
    let (lower, lower_error) = two_product(quarters, HALF_PI[1]);
    // Exact: both are near each other.
    let rest = angle.hi - product;
    let (r, r_low) = two_sum(rest, angle.lo - error - lower);
    let r_low = r_low - lower_error - quarters * HALF_PI[2];
    let square = r * r;
    let mut sine = INVERSE_FACTORIAL[17];
    let mut cosine = INVERSE_FACTORIAL[18];
    for m in (1..8).rev() {
        sine = INVERSE_FACTORIAL[2 * m + 1] - square * sine;
        cosine = INVERSE_FACTORIAL[2 * m + 2] - square * cosine;
    }
    // sin r = r − r³ (1/3! − …), cos r − 1 = −r² (1/2! − r² (1/4! − …)).
    let sine_rest = -(r * square * sine);
    let cosine_less_one = -(square * (0.5 - square * cosine));
    let sine = r + (sine_rest + r_low * (1.0 + cosine_less_one));
    let cosine_less_one = cosine_less_one - sine * r_low;
    let cosine = 1.0 + cosine_less_one;
    // The quarter turn, modulo four.
    let turn = quarters - 4.0 * nearest(quarters / 4.0);
    if turn == 0.0 {
        (sine, cosine, cosine_less_one)
    } else if turn == 1.0 {
        (cosine, -sine, -sine - 1.0)
    } else if turn == -1.0 {
        (-cosine, sine, sine - 1.0)
    } else {
        (-sine, -cosine, -cosine - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_are_those_of_the_system() {
        for i in -4000..4000 {
            let x = f64::from(i) * 0.173;
            let (value, less_one) = exponential(x);
            let exact = x.exp();
            assert!((value - exact).abs() <= 4.0 * f64::EPSILON * exact, "{x}: {value:e} {exact:e}");
            let exact = x.exp_m1();
            assert!((less_one - exact).abs() <= 4.0 * f64::EPSILON * exact.abs(), "{x}: {less_one:e} {exact:e}");
        }
        let [tiny, zero, huge] = [-1e-20, -1e6, 1e6].map(exponential);
        assert_eq!((tiny.1.to_bits(), zero.0, huge.0), ((-1e-20f64).to_bits(), 0.0, f64::INFINITY));
    }

    /// Also of angles with many turns: cos² + sin² is 1, and the values are those of the system for the same angle.
    #[test]
    fn sines_are_those_of_the_system() {
        for i in -2000..2000 {
            for scale in [1e-9, 1e-3, 0.37, 511.3, 1e9] {
                let angle = f64::from(i) * scale;
                let (sine, cosine, less_one) = sine_cosine(Twofold::from(angle));
                assert!((sine - angle.sin()).abs() <= 2e-16, "{angle}: {sine} {}", angle.sin());
                assert!((cosine - angle.cos()).abs() <= 2e-16, "{angle}: {cosine} {}", angle.cos());
                assert!((less_one + 1.0 - cosine).abs() <= 2e-16);
                let half = (angle / 2.0).sin();
                // Where no quarter turns are taken away, every digit counts.
                let size = if angle.abs() < 0.78 { half * half } else { 1.0 };
                assert!((less_one + 2.0 * half * half).abs() <= 2e-15 * size, "{angle}");
            }
        }
    }
}

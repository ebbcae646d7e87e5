//! e^x and its kin with errors of about one unit in the last place, the same bits on every machine.
//!
//! The system's mathematics library chooses among several implementations by the processor at hand, which differ in the
//! last bit, and evaluates one number at a time. Here are plain multiplications and additions without branches, so that
//! the compiler evaluates several numbers at once.

// Inlined into functions for wide registers, and indexed in step, or the compiler does not use these registers.
#![allow(clippy::inline_always, clippy::needless_range_loop)]

/// ln 2 in two parts; products of the first with an exponent are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];

/// Adding and subtracting it rounds to an integer, whose bits are then the lowest ones of the sum.
const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;

/// Beyond ±this, results are those of the limits. e^708 is within the range of normal numbers.
const LIMIT: f64 = 708.0;

/// (2^k, e^r − 1) with x = k ln 2 + r and |r| ≤ ½ ln 2.
#[inline(always)]
fn parts(x: f64) -> (f64, f64) {
    let x = x.clamp(-LIMIT, LIMIT);
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let k = shifted - ROUND;
    let r = (x - k * LN_2[0]) - k * LN_2[1];
    let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    // Σ r^j/(j+2)!, j = 0 … 11: the remainder r¹⁴/14! is below 5·10⁻¹⁸. By Estrin's scheme, whose chains are short.
    let r2 = r * r;
    let r4 = r2 * r2;
    let even = (1.0 / 2.0 + r2 * (1.0 / 24.0))
        + r4 * ((1.0 / 720.0 + r2 * (1.0 / 40_320.0)) + r4 * (1.0 / 3_628_800.0 + r2 * (1.0 / 479_001_600.0)));
    let odd = (1.0 / 6.0 + r2 * (1.0 / 120.0))
        + r4 * ((1.0 / 5_040.0 + r2 * (1.0 / 362_880.0)) + r4 * (1.0 / 39_916_800.0 + r2 * (1.0 / 6_227_020_800.0)));
    (power, r + r2 * (even + r * odd))
}

/// e^x for |x| ≤ 708; its value there for larger ones.
#[must_use]
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    let (power, rest) = parts(x);
    power + power * rest
}

/// e^x − 1.
#[must_use]
#[inline]
pub fn exp_m1(x: f64) -> f64 {
    let (power, rest) = parts(x);
    (power - 1.0) + power * rest
}

/// tanh x, with an error of up to three units in the last place.
#[must_use]
#[inline]
pub fn tanh(x: f64) -> f64 {
    // (1 − e^{−2|x|})/(1 + e^{−2|x|}): nothing cancels, and nothing overflows.
    let rest = exp_m1(-2.0 * x.abs());
    (-rest / (2.0 + rest)).copysign(x)
}

/// Replaces every x by e^x.
#[inline(always)]
pub fn exp_all(x: &mut [f64]) {
    // No closure: it would not be compiled for the wide registers of a caller.
    for x in x {
        *x = exp(*x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Distance in units in the last place of the expected value.
    fn ulps(found: f64, expected: f64) -> f64 {
        let ulp = f64::from_bits(expected.abs().to_bits() + 1) - expected.abs();
        ((found - expected) / ulp).abs()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// The reference is the system's library, itself within one unit; so neighbours count as equal.
        #[test]
        fn agrees_with_the_system(x in -700.0..700.0, small in -1.0..1.0, tiny in -1e-6..1e-6) {
            for x in [x, small, tiny] {
                prop_assert!(ulps(exp(x), x.exp()) <= 1.0, "exp {x:e}");
                prop_assert!(ulps(exp_m1(x), x.exp_m1()) <= 2.0, "exp_m1 {x:e}");
                prop_assert!(ulps(tanh(x), x.tanh()) <= 4.0, "tanh {x:e}");
            }
        }
    }

    #[test]
    fn limits_are_exact() {
        assert_eq!((exp(0.0), exp_m1(0.0)), (1.0, 0.0));
        assert_eq!(exp_m1(-700.0), -1.0);
        assert_eq!([tanh(f64::INFINITY), tanh(-50.0)], [1.0, -1.0]);
        assert_eq!(tanh(-0.0).to_bits(), (-0.0_f64).to_bits());
    }

    /// All at once and one by one give the same bits, for every remainder of a vectorised loop.
    #[test]
    fn several_at_once_are_the_same_bits() {
        for length in 0..40 {
            let numbers: Vec<f64> = (0..length).map(|i| (f64::from(i) * 7.3).sin() * 300.0).collect();
            let mut all = numbers.clone();
            exp_all(&mut all);
            for (x, found) in numbers.into_iter().zip(all) {
                assert_eq!(found.to_bits(), exp(x).to_bits());
            }
        }
    }
}

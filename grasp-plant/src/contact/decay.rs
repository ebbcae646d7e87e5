//! e^{−x} by basic arithmetic alone: the same bits on every machine, which the systems' mathematics libraries do not promise.

/// ln 2 in two parts; multiples up to 2¹⁰ of the first are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// e^{−x} for x ≥ 0, to rounding; zero where it would be subnormal.
pub(super) fn decay(x: f64) -> f64 {
    if x > 708.0 {
        return 0.0;
    }
    let halvings = (x * std::f64::consts::LOG2_E + 0.5).floor();
    // In [−0.35, 0.35].
    let rest = halvings * LN_2_LOW - (x - halvings * LN_2_HIGH);
    // 0.35¹⁶/16! is 2·10⁻²¹.
    let series = (1..=15).rev().fold(1.0, |sum, m| 1.0 + sum * rest / f64::from(m));
    // 2^−halvings by its bits.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number from 0 to 1022")]
    let halvings = halvings as u64;
    series * f64::from_bits((1023 - halvings) << 52)
}

#[cfg(test)]
mod tests {
    use super::decay;

    #[test]
    fn it_is_the_exponential() {
        for i in 0..100_000 {
            let x = f64::from(i) * 0.00707;
            let exact = (-x).exp();
            assert!((decay(x) - exact).abs() <= 4.0 * f64::EPSILON * exact, "{x}");
        }
        assert!(decay(0.0) == 1.0 && decay(1e300) == 0.0 && decay(f64::INFINITY) == 0.0);
    }
}

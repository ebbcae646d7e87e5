//! A search for good constants: (1+1)-CMA-ES (Igel, Suttorp, Hansen 2006, doi:10.1145/1143997.1144082). Its results are
//! checked elsewhere; if it finds nothing, that proves nothing. The same start gives the same result.

/// Normally distributed numbers from SplitMix64 and the Box–Muller transform: repeatable, and good enough for a search.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        // 53 bits, never zero.
        (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Maximises `value` from `start` with at most `evaluations` evaluations; `step` is the size of the first steps.
pub(crate) fn maximise<const N: usize>(
    value: impl Fn(&[f64; N]) -> f64,
    start: [f64; N],
    step: f64,
    evaluations: usize,
) -> ([f64; N], f64) {
    const TARGET: f64 = 2.0 / 11.0;
    let size = N as f64;
    let (learning, memory) = (1.0 / 12.0, 2.0 / (size * size + 6.0));
    let mut random = Normal(1);
    let mut factor: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let (mut best, mut highest) = (start, value(&start));
    let (mut step, mut success) = (step, TARGET);
    for _ in 0..evaluations {
        let z: [f64; N] = std::array::from_fn(|_| random.next());
        let y: [f64; N] = std::array::from_fn(|i| (0..N).map(|j| factor[i][j] * z[j]).sum());
        let candidate: [f64; N] = std::array::from_fn(|i| best[i] + step * y[i]);
        let reached = value(&candidate);
        let better = reached > highest;
        success = (1.0 - learning) * success + learning * f64::from(u8::from(better));
        step *= ((success - TARGET) / (1.0 - TARGET) / (1.0 + 0.5 * size)).exp();
        if better {
            (best, highest) = (candidate, reached);
            if success < 0.44 {
                let square: f64 = z.iter().map(|z| z * z).sum();
                let keep = (1.0 - memory).sqrt();
                let gain = keep / square * ((1.0 + memory * square / (1.0 - memory)).sqrt() - 1.0);
                for i in 0..N {
                    for j in 0..N {
                        factor[i][j] = keep * factor[i][j] + gain * y[i] * z[j];
                    }
                }
            }
        }
        if step < 1e-10 {
            break;
        }
    }
    (best, highest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A valley with a condition number of 1e4, not along the axes.
    #[test]
    fn a_narrow_valley_is_followed() {
        let value = |x: &[f64; 3]| -((x[0] + x[1] - 1.0).powi(2) + 1e4 * (x[0] - x[1]).powi(2) + (x[2] - 2.0).powi(2));
        let (best, _) = maximise(value, [0.0; 3], 0.3, 20_000);
        for (found, exact) in best.iter().zip([0.5, 0.5, 2.0]) {
            assert!((found - exact).abs() < 1e-4, "{best:?}");
        }
    }
}

//! What noise is like: its mean, deviation, whiteness, distribution and independence, within confidence bounds.
//!
//! Seeds are fixed, so the tests always say the same. Four standard errors leave a chance of 6e-5 to each statistic that a
//! fair generator would have failed when the seeds were chosen.

use grasp_instruments::{InstrumentSettings, Instruments, SIGNALS, Stream, profiles};

const N: usize = 200_000;
const STANDARD_ERRORS: f64 = 4.0;

fn deviates(seed: u32, number: u32) -> Vec<f64> {
    (0..N as u64).map(|k| Stream { seed, number }.deviate(k)).collect()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// Of the products of two sequences; a mean of N products of independent deviates has the standard error 1/√N.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    mean(a.iter().zip(b).map(|(a, b)| a * b))
}

#[test]
fn deviates_have_mean_0_and_variance_1_and_are_white() {
    let error = STANDARD_ERRORS / (N as f64).sqrt();
    for (seed, number) in [(0, 0), (1, 0), (1, 13), (2, 0), (u32::MAX, 7)] {
        let x = deviates(seed, number);
        let what = format!("seed {seed}, signal {number}");
        assert!(mean(x.iter().copied()).abs() < error, "{what}: mean");
        // Moments of a normal deviate: E x⁴ = 3, E x⁶ = 15, E x⁸ = 105; so Var x² = 2, Var x³ = 15, Var x⁴ = 96.
        assert!((mean(x.iter().map(|x| x * x)) - 1.0).abs() < 2.0_f64.sqrt() * error, "{what}: variance");
        assert!(mean(x.iter().map(|x| x.powi(3))).abs() < 15.0_f64.sqrt() * error, "{what}: skewness");
        assert!((mean(x.iter().map(|x| x.powi(4))) - 3.0).abs() < 96.0_f64.sqrt() * error, "{what}: tails");
        for lag in [1, 2, 3, 4, 5, 7, 10, 64, 1000] {
            assert!(
                correlation(&x[..N - lag], &x[lag..]).abs() < 1.01 * error,
                "{what}: correlation over {lag} samples"
            );
        }
    }
}

/// The share of deviates below each of many quantiles (Kolmogorov–Smirnov): √N times its greatest error exceeds 2.23 with
/// a chance of 1e-4. That the quantiles are right is tested with them.
#[test]
fn deviates_are_normally_distributed() {
    let mut x = deviates(3, 5);
    x.sort_by(f64::total_cmp);
    for level in (1..1000).map(|i| f64::from(i) / 1000.0) {
        let below = x.partition_point(|x| *x < grasp_instruments::normal::quantile(level));
        assert!((below as f64 / N as f64 - level).abs() * (N as f64).sqrt() < 2.23, "{level}: {below}");
    }
}

#[test]
fn signals_and_seeds_are_independent() {
    let error = STANDARD_ERRORS / (N as f64).sqrt();
    let sequences: Vec<_> = [(1, 0), (1, 1), (1, 2), (2, 0), (2, 1)].iter().map(|(s, n)| deviates(*s, *n)).collect();
    for (i, a) in sequences.iter().enumerate() {
        for b in &sequences[..i] {
            assert!(correlation(a, b).abs() < error);
            assert!(correlation(&a[1..], &b[..N - 1]).abs() < error);
        }
    }
}

/// The profile's deviations reach the outputs, each at its sample time, whatever the steps.
#[test]
fn the_noise_profile_is_what_it_says() {
    let wanted = [
        ("theta1", 1e-4),
        ("theta2_dot", 1e-2),
        ("y_object", 1e-5),
        ("y_object_dot", 1e-3),
        ("root_moment1", 1e-3),
        ("tip_shear2", 5e-3),
        ("tip_shear1_dot", 0.5),
        ("root_moment2_dot", 0.1),
    ];
    let settings = InstrumentSettings { sensors: profiles::noise(), ..InstrumentSettings::default() };
    let settings = settings.sampled(profiles::SAMPLE_TIME);
    let mut instruments = Instruments::new(&settings, 0.0, &[0.0; 14]).unwrap();
    let n = 20_000;
    let mut squares = [0.0; 14];
    for k in 0..n {
        instruments.step(f64::from(k) * 1e-3, 1e-3, &[0.0; 14], &[0.0; 14]).unwrap();
        for (sum, x) in squares.iter_mut().zip(instruments.outputs(&[0.0; 14])) {
            *sum += x * x;
        }
    }
    for (name, deviation) in wanted {
        let i = SIGNALS.iter().position(|signal| signal.name == name).unwrap();
        let variance = squares[i] / f64::from(n) / (deviation * deviation);
        assert!((variance - 1.0).abs() < STANDARD_ERRORS * (2.0 / f64::from(n)).sqrt(), "{name}: {variance}");
    }
}

//! Eigenvalues of a linear system from its pulse responses: the eigensystem realisation algorithm (J. Juang, R. Pappa,
//! *J. Guidance* 8(5), 1985, doi:10.2514/3.20031).
//!
//! A linear system that is stepped is x ← A x, y = C x at equally spaced times. Hankel matrices of its responses give
//! the eigenvalues of A to rounding if all states are observable.

use grasp_plant::nalgebra::{Complex, ComplexField, DMatrix};

/// Samples of each response.
pub const SAMPLES: usize = 60;
/// Block rows of the Hankel matrix.
const ROWS: usize = 20;
/// Singular values that are smaller, relative to the largest, are round-off.
const RANK: f64 = 1e-11;

/// Eigenvalues of A from the responses `y[n]` = C Aⁿ B.
///
/// # Panics
/// When there are fewer than [`SAMPLES`] responses.
#[must_use]
pub fn realise(responses: &[DMatrix<f64>]) -> Vec<Complex<f64>> {
    let (outputs, inputs) = responses[0].shape();
    let columns = SAMPLES - ROWS;
    let hankel = |shift: usize| {
        DMatrix::from_fn(ROWS * outputs, columns * inputs, |i, j| {
            // The last block of the shifted matrix would need one sample more.
            responses[(i / outputs + j / inputs + shift).min(SAMPLES - 1)][(i % outputs, j % inputs)]
        })
    };
    let used = (columns - 1) * inputs;
    let (first, second) = (hankel(0), hankel(1));
    let svd = first.columns(0, used).clone_owned().svd(true, true);
    let (Some(left), Some(right)) = (svd.u, svd.v_t) else { return Vec::new() };
    let largest = svd.singular_values.max();
    let kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&i| svd.singular_values[i] > RANK * largest).collect();
    let roots: Vec<f64> = kept.iter().map(|&i| svd.singular_values[i].sqrt()).collect();
    let inner = left.select_columns(&kept).transpose() * second.columns(0, used) * right.select_rows(&kept).transpose();
    let system = DMatrix::from_fn(kept.len(), kept.len(), |i, j| inner[(i, j)] / (roots[i] * roots[j]));
    system.complex_eigenvalues().iter().copied().collect()
}

/// The eigenvalue in 1/s that belongs to an expected one: the nearest after one sample.
#[must_use]
pub fn nearest(found: &[Complex<f64>], expected: Complex<f64>, sample: f64) -> Complex<f64> {
    let z = (expected * sample).exp();
    let distance = |candidate: &&Complex<f64>| (*candidate - z).modulus();
    let best = found.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    best.map_or(Complex::new(f64::NAN, f64::NAN), |best| expected + (best / z).ln() / sample)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_of_a_known_system_are_found() {
        let poles = [Complex::new(-3.0, 40.0), Complex::new(-0.5, 0.0), Complex::new(-12.0, 0.0)];
        let sample = 0.01;
        let responses: Vec<_> = (0..SAMPLES)
            .map(|n| {
                let t = (n + 1) as f64 * sample;
                DMatrix::from_fn(2, 2, |i, j| {
                    let weight = |k: usize| 1.0 + (i + 2 * j + k) as f64;
                    poles.iter().enumerate().map(|(k, pole)| weight(k * k) * (pole * t).exp().re).sum()
                })
            })
            .collect();
        let found = realise(&responses);
        for pole in poles {
            let identified = nearest(&found, pole, sample);
            assert!((identified - pole).modulus() < 1e-8 * pole.modulus(), "{identified} instead of {pole}");
        }
    }
}

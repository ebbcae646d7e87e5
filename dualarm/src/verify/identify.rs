//! Eigenvalues of a linear system from its pulse responses: the eigensystem realisation algorithm (J. Juang, R. Pappa,
//! *J. Guidance* 8(5), 1985, doi:10.2514/3.20031).
//!
//! A slave that steps a linear system is x ← A x, y = C x at equally spaced times. Hankel matrices of its responses give
//! the eigenvalues of A to rounding if all states are observable. The inside of the FMU is not used.

use nalgebra::{Complex, ComplexField, DMatrix};

use super::VerifyError;
use super::rig::{Rig, Settings};
use fmi2_import::Fmu;

/// The measured outputs and their scales, so that no output is lost in the rounding errors of another.
pub const MEASURED: [(&str, f64); 12] = [
    ("theta1", 0.05),
    ("theta2", 0.05),
    ("theta1_dot", 1.0),
    ("theta2_dot", 1.0),
    ("y_object", 0.01),
    ("y_object_dot", 0.1),
    ("root_moment1", 0.1),
    ("root_moment2", 0.1),
    ("tip_shear1", 1.0),
    ("tip_shear2", 1.0),
    ("tip_shear1_dot", 300.0),
    ("tip_shear2_dot", 300.0),
];

/// Samples of each response, and block rows of the Hankel matrix.
const SAMPLES: usize = 60;
const ROWS: usize = 20;
/// Singular values that are smaller, relative to the largest, are round-off.
const RANK: f64 = 1e-11;

/// One-step eigenvalues of the FMUs, sampled every `steps` steps of `step` s, from responses to a pulse of each input of
/// the plant (the first FMU), one sample long.
///
/// # Errors
/// When an FMU fails.
pub fn eigenvalues(
    fmus: &[&Fmu],
    settings: &Settings,
    inputs: [&str; 3],
    step: f64,
    steps: u64,
) -> Result<Vec<Complex<f64>>, VerifyError> {
    let mut responses = vec![DMatrix::zeros(MEASURED.len(), inputs.len()); SAMPLES];
    for pulsed in 0..inputs.len() {
        let mut rig = Rig::new(fmus, settings, step)?;
        let input = rig.port(0, &inputs)?;
        let output = rig.port(0, &MEASURED.map(|(name, _)| name))?;
        let rest = rig.get(&output)?;
        let mut pulse = [0.0; 3];
        pulse[pulsed] = 1.0;
        rig.set(&input, &pulse)?;
        for (sample, response) in responses.iter_mut().enumerate() {
            rig.advance(steps)?;
            if sample == 0 {
                rig.set(&input, &[0.0; 3])?;
            }
            for (row, (value, (_, size))) in rig.get(&output)?.iter().zip(MEASURED).enumerate() {
                response[(row, pulsed)] = (value - rest[row]) / size;
            }
        }
    }
    Ok(realise(&responses))
}

/// Eigenvalues of A from the responses `y[n]` = C Aⁿ B.
///
/// # Panics
/// When there are fewer than `SAMPLES` responses.
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

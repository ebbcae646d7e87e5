//! Eigenvalues of FMUs from their [pulse responses](grasp_certify::realisation). The inside of the FMU is not used.

use grasp_certify::realisation::{SAMPLES, realise};
use nalgebra::{Complex, DMatrix};

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

//! How fast a grasp comes to rest: measured in runs of the linear loop from the plant's start.

use crate::controllers::{Controller, ControllerError};
use crate::law::{LawError, SampledLaw};
use crate::sampled::Coupled;
use crate::settings::Settings;
use grasp_control::Targets;
use grasp_plant::nalgebra::{DMatrix, DVector};
use grasp_plant::{Parameters, Plant, Start};

/// Why a decay can't be measured.
#[derive(Debug, thiserror::Error)]
pub enum DecayError {
    /// There is no such controller.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// The controller has no linear system.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The plant does not exist.
    #[error(transparent)]
    Plant(#[from] grasp_plant::InvalidParameter),
}

/// The plant at rest with these angles and this position.
fn at_rest(parameters: &Parameters, theta: [f64; 2], y_object: f64) -> Result<DVector<f64>, DecayError> {
    let start = Start { theta, y_object, theta_dot: [0.0; 2], y_object_dot: 0.0 };
    let plant = Plant::new(Parameters { start, ..parameters.clone() })?;
    let mut state = plant.energy_coordinates();
    state.push(plant.state().position[2]);
    Ok(DVector::from_vec(state))
}

/// The rate \[1/s\] at which amplitudes fall between the half and the whole of `duration` \[s\] after the start, with
/// commands at once every `h` \[s\]. Negative if they grow.
///
/// # Errors
/// There is no such controller, or the plant does not exist.
pub fn measured(
    fmu: &str,
    choices: &[(String, String)],
    settings: &Settings,
    h: f64,
    duration: f64,
) -> Result<f64, DecayError> {
    let mut law = Controller::new(fmu, choices, settings)?;
    let inputs = law.at_target(settings);
    let law = law.linear(&inputs, h)?.reachable();
    let plant = Plant::new(settings.plant.clone())?;
    let Targets { theta, y_object, .. } = settings.targets();
    let start = settings.plant.start;
    let error = at_rest(&settings.plant, start.theta, start.y_object)? - at_rest(&settings.plant, theta, y_object)?;
    Ok(rate(&Coupled::new(&plant, h), &law, &error, h, duration))
}

/// See [`measured`]; `start` is the plant's state, the law begins at rest.
fn rate(coupled: &Coupled, law: &SampledLaw, start: &DVector<f64>, h: f64, duration: f64) -> f64 {
    // Amplitudes every millisecond.
    const EVERY: f64 = 1e-3;
    let matrix = coupled.matrix(law, 0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between one and millions
    let steps = (EVERY / h).round().max(1.0) as u32;
    let several = power(&matrix, steps);
    let every = h * f64::from(steps);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some thousand
    let rows = (duration / every) as usize;
    let mut state = DVector::zeros(matrix.nrows());
    state.rows_mut(0, start.len()).copy_from(start);
    let mut sizes = Vec::with_capacity(rows);
    // Growing or falling states are rescaled, so that no number leaves its range.
    let mut scale = 0.0;
    for _ in 0..rows {
        state = &several * state;
        let size = state.norm();
        sizes.push(scale + state.rows(0, start.len()).norm().ln());
        state /= size;
        scale += size.ln();
    }
    // The mean logarithm over a tenth of the run forgets where in their swing the modes are.
    let window = (rows / 10).max(1);
    let mean = |from: usize| sizes[from..from + window].iter().sum::<f64>() / window as f64;
    let (middle, end) = (rows / 2 - window / 2, rows - window);
    (mean(middle) - mean(end)) / ((end - middle) as f64 * every)
}

/// Matrix to the n-th, n from 1.
fn power(matrix: &DMatrix<f64>, mut n: u32) -> DMatrix<f64> {
    let (mut result, mut square) = (DMatrix::identity(matrix.nrows(), matrix.nrows()), matrix.clone());
    while n > 0 {
        if n & 1 == 1 {
            result = &result * &square;
        }
        square = &square * &square;
        n >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PD's run falls with the slowest exact eigenvalue, −0.0839 1/s (561 rad/s), once the other modes have decayed. Ten
    /// seconds leave 1 % of modes that decay with 0.576 1/s.
    #[test]
    fn pd_falls_with_its_slowest_mode() {
        let mut settings = Settings::default();
        settings.plant.root_uncertainty = 0.1;
        settings.plant.tip_uncertainty = 0.05;
        let found = measured("PdController", &[], &settings, 1e-6, 60.0).unwrap();
        assert!((found - 0.083_947).abs() < 0.002, "{found}");
    }
}

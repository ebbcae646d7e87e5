//! The static target (16): what the grasp looks like at rest.

use crate::signals::{Errors, INPUTS, Inputs, References, column};
use parameter_table::{InvalidParameter, Parameter, Range, check, parameter};
use serde::{Deserialize, Serialize};

/// What a controller knows about the arms; index 0 of an array is arm 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Arms {
    /// Flexural rigidities `EIᵢ` \[N·m²\].
    pub ei: [f64; 2],
    /// Length l of both arms \[m\].
    pub length: f64,
    /// Distance L between the two hubs, so that the undeformed tips meet at L/2 \[m\].
    pub hub_distance: f64,
}

impl Default for Arms {
    /// The values of Section IV.
    fn default() -> Self {
        Self { ei: [0.115; 2], length: 0.2, hub_distance: 0.1 }
    }
}

/// Admissible range of a length or a stiffness: positive, and so far from the limits of `f64` that nothing overflows.
const PHYSICAL: Range = Range::new(1e-6, 1e6);

impl Arms {
    /// The parameters by their names in the interface.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<Arms>; 4] = [
            parameter!("EI1", "N.m2", PHYSICAL, "Flexural rigidity of arm 1", ei[0]),
            parameter!("EI2", "N.m2", PHYSICAL, "Flexural rigidity of arm 2", ei[1]),
            parameter!("l", "m", PHYSICAL, "Length of each arm", length),
            parameter!("L", "m", PHYSICAL, "Width of the object and distance of the hubs", hub_distance),
        ];
        &ROWS
    };

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is not finite or not in its range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check(Self::PARAMETERS, self)
    }

    /// The static target (16) of the references, with the L/2 that (16) leaves out and constraint (12) needs.
    #[must_use]
    pub fn targets(&self, reference: &References) -> Targets {
        self.targets_with(&self.slopes(), reference)
    }

    /// What [`targets_with`](Self::targets_with) needs: it does not change while a law runs.
    pub(crate) fn slopes(&self) -> TargetSlopes {
        TargetSlopes { theta2: self.theta2_per_lambda1(), y: self.y_per_lambda1() }
    }

    /// As [`targets`](Self::targets), for a caller that keeps the slopes of these arms.
    #[inline]
    pub(crate) fn targets_with(&self, slopes: &TargetSlopes, reference: &References) -> Targets {
        let References { lambda1_ref, theta1_ref } = *reference;
        let l = self.length;
        Targets {
            lambda: reference.lambda(),
            theta: [theta1_ref, theta1_ref + slopes.theta2 * lambda1_ref],
            y_object: l * theta1_ref + slopes.y * lambda1_ref + 0.5 * self.hub_distance,
        }
    }

    /// Errors with respect to the targets of the same inputs.
    #[must_use]
    pub fn errors(&self, inputs: &Inputs) -> Errors {
        self.targets(&inputs.reference).errors(inputs)
    }

    /// ∂θ₂ᵈ/∂λ₁ᵈ, eq. (16).
    fn theta2_per_lambda1(&self) -> f64 {
        let [ei1, ei2] = self.ei;
        self.length.powi(2) / 3.0 * (ei1 + ei2) / (ei1 * ei2)
    }

    /// ∂`y_M`ᵈ/∂λ₁ᵈ, eq. (16).
    fn y_per_lambda1(&self) -> f64 {
        self.length.powi(3) / (3.0 * self.ei[0])
    }

    /// Partial derivatives of the targets with respect to the inputs.
    #[must_use]
    pub fn target_jacobian(&self) -> TargetJacobian {
        let row = |per_lambda1: f64, per_theta1: f64| {
            let mut row = [0.0; INPUTS];
            row[column::LAMBDA1_REF] = per_lambda1;
            row[column::THETA1_REF] = per_theta1;
            row
        };
        TargetJacobian {
            lambda: [row(1.0, 0.0), row(-1.0, 0.0)],
            theta: [row(0.0, 1.0), row(self.theta2_per_lambda1(), 1.0)],
            y_object: row(self.y_per_lambda1(), self.length),
        }
    }

    /// Partial derivatives of the errors with respect to the inputs.
    #[must_use]
    pub fn error_jacobian(&self) -> ErrorJacobian {
        let targets = self.target_jacobian();
        let mut e = targets.theta.map(|row| row.map(|value| -value));
        let mut p = targets.y_object.map(|value| -value);
        for (arm, row) in e.iter_mut().enumerate() {
            row[column::THETA + arm] += 1.0;
        }
        p[column::Y_OBJECT] += 1.0;
        ErrorJacobian { e, p }
    }
}

/// How the targets move with λ₁ᵈ, eq. (16).
#[derive(Debug, Clone, Copy)]
pub(crate) struct TargetSlopes {
    /// ∂θ₂ᵈ/∂λ₁ᵈ \[rad/N\].
    pub theta2: f64,
    /// ∂`y_M`ᵈ/∂λ₁ᵈ \[m/N\].
    pub y: f64,
}

/// The static target (16).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Targets {
    /// Lagrange multipliers λᵢᵈ \[N\], λ₂ᵈ = −λ₁ᵈ.
    pub lambda: [f64; 2],
    /// Hub angles θᵢᵈ \[rad\].
    pub theta: [f64; 2],
    /// Object position `y_M`ᵈ \[m\].
    pub y_object: f64,
}

impl Targets {
    /// Errors of the measurements with respect to these targets.
    #[must_use]
    #[inline]
    pub fn errors(&self, inputs: &Inputs) -> Errors {
        let measured = &inputs.measured;
        Errors {
            e: [measured.theta[0] - self.theta[0], measured.theta[1] - self.theta[1]],
            p: measured.y_object - self.y_object,
        }
    }
}

/// Partial derivatives of [`Targets`]; rows are ordered like [`INPUT_NAMES`](crate::signals::INPUT_NAMES).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetJacobian {
    /// ∂λᵢᵈ.
    pub lambda: [[f64; INPUTS]; 2],
    /// ∂θᵢᵈ.
    pub theta: [[f64; INPUTS]; 2],
    /// ∂`y_M`ᵈ.
    pub y_object: [f64; INPUTS],
}

/// Partial derivatives of [`Errors`]; rows are ordered like [`INPUT_NAMES`](crate::signals::INPUT_NAMES).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorJacobian {
    /// ∂eᵢ.
    pub e: [[f64; INPUTS]; 2],
    /// ∂p.
    pub p: [f64; INPUTS],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::Measurements;

    /// θ₂ᵈ = π/60 − 0.5·0.2²/3·0.23/0.115², `y_M`ᵈ = 0.2·π/60 − 0.5·0.2³/0.345 + 0.05, worked out by hand.
    #[test]
    fn the_papers_case() {
        let targets = Arms::default().targets(&References::default());
        assert!((targets.theta[1] - -0.063_582_151_4).abs() < 5e-11);
        assert!((targets.y_object - 0.048_877_772_6).abs() < 5e-11);
        assert_eq!(targets.lambda, [-0.5, 0.5]);
    }

    /// With wᵢᵈ(l) = −λᵢᵈ l³/3EI from (16), constraint (12) holds for both arms, however unequal they are.
    #[test]
    fn the_target_satisfies_the_constraint() {
        let arms = Arms { ei: [0.07, 0.31], length: 0.27, hub_distance: 0.13 };
        let targets = arms.targets(&References { lambda1_ref: -0.8, theta1_ref: -0.03 });
        for arm in 0..2 {
            let tip = -targets.lambda[arm] * arms.length.powi(3) / (3.0 * arms.ei[arm]);
            let constraint = arms.length * targets.theta[arm] - tip - targets.y_object + 0.5 * arms.hub_distance;
            assert!(constraint.abs() < 1e-17, "arm {arm}: {constraint}");
        }
    }

    /// p = l eᵢ − qᵢ(l) (Section III.C), which holds only with L/2 in the target.
    #[test]
    fn position_error_follows_from_angle_and_deflection() {
        let arms = Arms::default();
        let targets = arms.targets(&References::default());
        let inputs = Inputs {
            measured: Measurements { theta: [0.02, -0.01], y_object: 0.051, ..Measurements::default() },
            reference: References::default(),
        };
        let errors = targets.errors(&inputs);
        for arm in 0..2 {
            let w = arms.length * inputs.measured.theta[arm] - inputs.measured.y_object + 0.5 * arms.hub_distance;
            let w_target = -targets.lambda[arm] * arms.length.powi(3) / (3.0 * arms.ei[arm]);
            let p = arms.length * errors.e[arm] - (w - w_target);
            assert!((p - errors.p).abs() < 1e-16);
        }
    }

    #[test]
    fn bad_parameters_are_named() {
        let arms = Arms { ei: [0.1, 0.0], ..Arms::default() };
        assert_eq!(arms.validate().unwrap_err().name, "EI2");
        let arms = Arms { hub_distance: f64::NAN, ..Arms::default() };
        assert_eq!(arms.validate().unwrap_err().name, "L");
    }
}

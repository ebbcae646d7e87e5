//! The variables that all controllers share. They are declared of the part that the controllers have alike, once for all laws.

use fmi2_export::{Evaluation, Variables, field};

use super::Signals;

/// Targets and errors follow from references and measurements alone.
const NO_STATES: [&str; 0] = [];

pub(super) fn inputs(variables: &mut Variables<Signals>) {
    variables
        .input_field("theta{}", field!(Signals, inputs.measured.theta))
        .ramp_array(|m| &mut m.input_rates.measured.theta)
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .description("Measured angle of hub {}");
    variables
        .input_field("theta{}_dot", field!(Signals, inputs.measured.theta_dot))
        .ramp_array(|m| &mut m.input_rates.measured.theta_dot)
        .unit("rad/s")
        .display_degrees()
        .description("Measured angular velocity of hub {}");
    variables
        .input_field("y_object", field!(Signals, inputs.measured.y_object))
        .ramp(|m| &mut m.input_rates.measured.y_object)
        .unit("m")
        .nominal(0.05)
        .description("Measured position y_M of the object's centre above hub 1");
    variables
        .input_field("y_object_dot", field!(Signals, inputs.measured.y_object_dot))
        .ramp(|m| &mut m.input_rates.measured.y_object_dot)
        .unit("m/s")
        .nominal(0.1)
        .description("Measured velocity of the object");
    variables
        .input_field("root_moment{}", field!(Signals, inputs.measured.root_moment))
        .ramp_array(|m| &mut m.input_rates.measured.root_moment)
        .unit("N.m")
        .nominal(0.1)
        .description("Measured bending moment EI w''(0) at the root of arm {}");
    variables
        .input_field("tip_shear{}", field!(Signals, inputs.measured.tip_shear))
        .ramp_array(|m| &mut m.input_rates.measured.tip_shear)
        .unit("N")
        .description("Measured shear force EI w'''(l) at the tip of arm {}");
    variables
        .input_field("tip_shear{}_dot", field!(Signals, inputs.measured.tip_shear_dot))
        .ramp_array(|m| &mut m.input_rates.measured.tip_shear_dot)
        .unit("N/s")
        .nominal(10.0)
        .description("Measured rate of the shear force at the tip of arm {}");
    variables
        .input_field("lambda1_ref", field!(Signals, inputs.reference.lambda1_ref))
        .ramp(|m| &mut m.input_rates.reference.lambda1_ref)
        .unit("N")
        .description("Wanted multiplier lambda1; the wanted contact force at both tips is -lambda1_ref, so a squeeze is negative");
    variables
        .input_field("theta1_ref", field!(Signals, inputs.reference.theta1_ref))
        .ramp(|m| &mut m.input_rates.reference.theta1_ref)
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .description("Wanted angle of hub 1; all other targets follow from the two references, eq. (16)");
    // Last, so that all other inputs are where they were before there were these.
    variables
        .input_field("root_moment{}_dot", field!(Signals, inputs.measured.root_moment_dot))
        .ramp_array(|m| &mut m.input_rates.measured.root_moment_dot)
        .unit("N.m/s")
        .description("Measured rate of the bending moment at the root of arm {}");
}

/// The commands. Some laws' torques and forces depend on further measurements.
pub(super) fn commands(
    variables: &mut Variables<Signals>,
    commands: Evaluation,
    rates: Evaluation,
    torque_also: &[&'static str],
    force_also: &[&'static str],
) {
    variables
        .output_field("tau{}_cmd", commands, field!(Signals, outputs.commands.tau))
        .rate_array(rates, |m| &mut m.rates().commands.tau)
        .unit("N.m")
        .depends_on(["theta{}", "theta{}_dot", "root_moment{}", "lambda1_ref", "theta1_ref"])
        .depends_on(torque_also.iter().copied())
        .description("Commanded torque on hub {}");
    variables
        .output_field("u_cmd", commands, field!(Signals, outputs.commands.u))
        .rate(rates, |m| &mut m.rates().commands.u)
        .unit("N")
        .nominal(0.1)
        .depends_on(["y_object", "y_object_dot", "tip_shear1", "tip_shear2", "lambda1_ref", "theta1_ref"])
        .depends_on(force_also.iter().copied())
        .description("Commanded force on the object");
}

pub(super) fn targets(
    variables: &mut Variables<Signals>,
    targets: Evaluation,
    force_targets: Evaluation,
    rates: Evaluation,
) {
    variables
        .output_field("theta1_d", targets, field!(Signals, outputs.targets.theta).element(0))
        .rate(rates, |m| &mut m.rates().targets.theta[0])
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .depends_linearly_on(["theta1_ref"])
        .depends_on_states(NO_STATES)
        .description("Target of theta1");
    variables
        .output_field("theta2_d", targets, field!(Signals, outputs.targets.theta).element(1))
        .rate(rates, |m| &mut m.rates().targets.theta[1])
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .depends_linearly_on(["theta1_ref", "lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Target of theta2, eq. (16)");
    variables
        .output_field("y_object_d", targets, field!(Signals, outputs.targets.y_object))
        .rate(rates, |m| &mut m.rates().targets.y_object)
        .unit("m")
        .nominal(0.05)
        .depends_linearly_on(["theta1_ref", "lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Target of y_object, eq. (16) with the L/2 it leaves out");
    variables
        .output_field("lambda2_d", force_targets, field!(Signals, outputs.targets.lambda).element(1))
        .rate(rates, |m| &mut m.rates().targets.lambda[1])
        .unit("N")
        .depends_linearly_on(["lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Target of lambda2, eq. (16)");
    variables
        .output_field("e1", targets, field!(Signals, outputs.errors.e).element(0))
        .rate(rates, |m| &mut m.rates().errors.e[0])
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .depends_linearly_on(["theta1", "theta1_ref"])
        .depends_on_states(NO_STATES)
        .description("Angle error theta1 - theta1_d");
    variables
        .output_field("e2", targets, field!(Signals, outputs.errors.e).element(1))
        .rate(rates, |m| &mut m.rates().errors.e[1])
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .depends_linearly_on(["theta2", "theta1_ref", "lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Angle error theta2 - theta2_d");
    variables
        .output_field("p", targets, field!(Signals, outputs.errors.p))
        .rate(rates, |m| &mut m.rates().errors.p)
        .unit("m")
        .nominal(0.01)
        .depends_linearly_on(["y_object", "theta1_ref", "lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Position error y_object - y_object_d");
}

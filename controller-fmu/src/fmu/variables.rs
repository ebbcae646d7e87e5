//! The variables that all controllers share.

use fmi2_export::{Evaluation, Variables};

use super::{Controller, FmuLaw};

/// Targets and errors follow from references and measurements alone.
const NO_STATES: [&str; 0] = [];

pub(super) fn inputs<L: FmuLaw>(variables: &mut Variables<Controller<L>>) {
    variables
        .input_array("theta{}", |m| &mut m.inputs.measured.theta)
        .ramp_array(|m| &mut m.input_rates.measured.theta)
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .description("Measured angle of hub {}");
    variables
        .input_array("theta{}_dot", |m| &mut m.inputs.measured.theta_dot)
        .ramp_array(|m| &mut m.input_rates.measured.theta_dot)
        .unit("rad/s")
        .display_degrees()
        .description("Measured angular velocity of hub {}");
    variables
        .input("y_object", |m| &mut m.inputs.measured.y_object)
        .ramp(|m| &mut m.input_rates.measured.y_object)
        .unit("m")
        .nominal(0.05)
        .description("Measured position y_M of the object's centre above hub 1");
    variables
        .input("y_object_dot", |m| &mut m.inputs.measured.y_object_dot)
        .ramp(|m| &mut m.input_rates.measured.y_object_dot)
        .unit("m/s")
        .nominal(0.1)
        .description("Measured velocity of the object");
    variables
        .input_array("root_moment{}", |m| &mut m.inputs.measured.root_moment)
        .ramp_array(|m| &mut m.input_rates.measured.root_moment)
        .unit("N.m")
        .nominal(0.1)
        .description("Measured bending moment EI w''(0) at the root of arm {}");
    variables
        .input_array("tip_shear{}", |m| &mut m.inputs.measured.tip_shear)
        .ramp_array(|m| &mut m.input_rates.measured.tip_shear)
        .unit("N")
        .description("Measured shear force EI w'''(l) at the tip of arm {}");
    variables
        .input_array("tip_shear{}_dot", |m| &mut m.inputs.measured.tip_shear_dot)
        .ramp_array(|m| &mut m.input_rates.measured.tip_shear_dot)
        .unit("N/s")
        .nominal(10.0)
        .description("Measured rate of the shear force at the tip of arm {}");
    variables
        .input("lambda1_ref", |m| &mut m.inputs.reference.lambda1_ref)
        .ramp(|m| &mut m.input_rates.reference.lambda1_ref)
        .unit("N")
        .description("Wanted multiplier lambda1; the wanted contact force at both tips is -lambda1_ref, so a squeeze is negative");
    variables
        .input("theta1_ref", |m| &mut m.inputs.reference.theta1_ref)
        .ramp(|m| &mut m.input_rates.reference.theta1_ref)
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .description("Wanted angle of hub 1; all other targets follow from the two references, eq. (16)");
    // Last, so that all other inputs are where they were before there were these.
    variables
        .input_array("root_moment{}_dot", |m| &mut m.inputs.measured.root_moment_dot)
        .ramp_array(|m| &mut m.input_rates.measured.root_moment_dot)
        .unit("N.m/s")
        .description("Measured rate of the bending moment at the root of arm {}");
}

pub(super) fn commands<L: FmuLaw>(variables: &mut Variables<Controller<L>>, rates: Evaluation) {
    let commands = variables.evaluation(Controller::<L>::commands);
    variables
        .output_array("tau{}_cmd", commands, |m| &mut m.outputs.commands.tau)
        .rate_array(rates, |m| &mut m.rates.commands.tau)
        .unit("N.m")
        .depends_on(["theta{}", "theta{}_dot", "root_moment{}", "lambda1_ref", "theta1_ref"])
        .depends_on(L::TORQUE_ALSO_DEPENDS_ON.iter().copied())
        .description("Commanded torque on hub {}");
    variables
        .output("u_cmd", commands, |m| &mut m.outputs.commands.u)
        .rate(rates, |m| &mut m.rates.commands.u)
        .unit("N")
        .nominal(0.1)
        .depends_on(["y_object", "y_object_dot", "tip_shear1", "tip_shear2", "lambda1_ref", "theta1_ref"])
        .depends_on(L::FORCE_ALSO_DEPENDS_ON.iter().copied())
        .description("Commanded force on the object");
}

pub(super) fn targets<L: FmuLaw>(variables: &mut Variables<Controller<L>>, rates: Evaluation) {
    let targets = variables.evaluation(Controller::<L>::targets);
    variables
        .output("theta1_d", targets, |m| &mut m.outputs.targets.theta[0])
        .rate(rates, |m| &mut m.rates.targets.theta[0])
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .depends_linearly_on(["theta1_ref"])
        .depends_on_states(NO_STATES)
        .description("Target of theta1");
    variables
        .output("theta2_d", targets, |m| &mut m.outputs.targets.theta[1])
        .rate(rates, |m| &mut m.rates.targets.theta[1])
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .depends_linearly_on(["theta1_ref", "lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Target of theta2, eq. (16)");
    variables
        .output("y_object_d", targets, |m| &mut m.outputs.targets.y_object)
        .rate(rates, |m| &mut m.rates.targets.y_object)
        .unit("m")
        .nominal(0.05)
        .depends_linearly_on(["theta1_ref", "lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Target of y_object, eq. (16) with the L/2 it leaves out");
    variables
        .output("lambda2_d", targets, |m| &mut m.outputs.targets.lambda[1])
        .rate(rates, |m| &mut m.rates.targets.lambda[1])
        .unit("N")
        .depends_linearly_on(["lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Target of lambda2, eq. (16)");
    variables
        .output("e1", targets, |m| &mut m.outputs.errors.e[0])
        .rate(rates, |m| &mut m.rates.errors.e[0])
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .depends_linearly_on(["theta1", "theta1_ref"])
        .depends_on_states(NO_STATES)
        .description("Angle error theta1 - theta1_d");
    variables
        .output("e2", targets, |m| &mut m.outputs.errors.e[1])
        .rate(rates, |m| &mut m.rates.errors.e[1])
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .depends_linearly_on(["theta2", "theta1_ref", "lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Angle error theta2 - theta2_d");
    variables
        .output("p", targets, |m| &mut m.outputs.errors.p)
        .rate(rates, |m| &mut m.rates.errors.p)
        .unit("m")
        .nominal(0.01)
        .depends_linearly_on(["y_object", "theta1_ref", "lambda1_ref"])
        .depends_on_states(NO_STATES)
        .description("Position error y_object - y_object_d");
}

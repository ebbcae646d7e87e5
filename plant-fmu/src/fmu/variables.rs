//! Names, units and dependencies of the variables.

use fmi2_export::{Enumeration, Evaluation, Variables, field};
use grasp_plant::{ActuatorModel, Arm, Channel, ContactModel, DEFLECTION_POINTS, Face, ORDER_RANGE, Parameters, Start};
use serde::{Deserialize, Serialize};

use super::{DualArmPlant, exchange};

pub(super) fn declare(variables: &mut Variables<DualArmPlant>) {
    inputs(variables);
    let rates = variables.evaluation(DualArmPlant::rates);
    measured_outputs(variables, rates);
    direct_outputs(variables, rates);
    shape_outputs(variables, rates);
    parameters(variables);
    // What is new comes last, so that all others keep their value references.
    let states = exchange::declare(variables);
    contact(variables, rates);
    exchange::declare_contact(variables, &states);
}

fn inputs(variables: &mut Variables<DualArmPlant>) {
    variables
        .input_field("tau{}_cmd", field!(DualArmPlant, inputs.torque_command))
        .ramp_array(|m| &mut m.input_rates.torque_command)
        .unit("N.m")
        .nominal(1.0)
        .description("Commanded torque on hub {}, before the actuator's limits");
    variables
        .input_field("u_cmd", field!(DualArmPlant, inputs.force_command))
        .ramp(|m| &mut m.input_rates.force_command)
        .unit("N")
        .nominal(0.1)
        .description("Commanded force on the object, before the actuator's limits");
    variables
        .input_field("delta_f{}", field!(DualArmPlant, inputs.hub_disturbance))
        .ramp_array(|m| &mut m.input_rates.hub_disturbance)
        .unit("N.m")
        .nominal(0.1)
        .description("External disturbance torque on hub {}, added to the built-in one");
    variables
        .input_field("delta_F", field!(DualArmPlant, inputs.object_disturbance))
        .ramp(|m| &mut m.input_rates.object_disturbance)
        .unit("N")
        .nominal(0.1)
        .description("External disturbance force on the object, added to the built-in one");
}

fn measured_outputs(variables: &mut Variables<DualArmPlant>, rates: Evaluation) {
    let measured = variables.evaluation(DualArmPlant::measured);
    variables
        .output_field("theta{}", measured, field!(DualArmPlant, outputs.measured.theta))
        .rate_array(rates, |m| &mut m.outputs.rates().measured.theta)
        .unit("rad")
        .display_degrees()
        .nominal(0.1)
        .description("Angle of hub {}, counter-clockwise");
    variables
        .output_field("theta{}_dot", measured, field!(DualArmPlant, outputs.measured.theta_dot))
        .rate_array(rates, |m| &mut m.outputs.rates().measured.theta_dot)
        .unit("rad/s")
        .display_degrees()
        .description("Angular velocity of hub {}");
    variables
        .output_field("y_object", measured, field!(DualArmPlant, outputs.measured.y_object))
        .rate(rates, |m| &mut m.outputs.rates().measured.y_object)
        .state()
        .depends_on_states(["y_object"])
        .unit("m")
        .nominal(0.05)
        .description("Position y_M of the object's centre above hub 1; L/2 when straight arms just touch it");
    variables
        .output_field("y_object_dot", measured, field!(DualArmPlant, outputs.measured.y_object_dot))
        .rate(rates, |m| &mut m.outputs.rates().measured.y_object_dot)
        .derivative_of("y_object")
        .depends_on_states(exchange::coordinate_names())
        .depends_on_states(["clearance1_dot", "clearance2_dot"])
        .unit("m/s")
        .nominal(0.1)
        .description("Velocity of the object");
    variables
        .output_field("root_moment{}", measured, field!(DualArmPlant, outputs.measured.root_moment))
        .rate_array(rates, |m| &mut m.outputs.rates().measured.root_moment)
        .unit("N.m")
        .nominal(0.1)
        .description("Elastic bending moment EI w''(0) at the root of arm {}");
    variables
        .output_field("tip_shear{}", measured, field!(DualArmPlant, outputs.measured.tip_shear))
        .rate_array(rates, |m| &mut m.outputs.rates().measured.tip_shear)
        .unit("N")
        .description("Elastic shear force EI w'''(l) at the tip of arm {}");
    variables
        .output_field("tip_shear{}_dot", measured, field!(DualArmPlant, outputs.measured.tip_shear_dot))
        .rate_array(rates, |m| &mut m.outputs.rates().measured.tip_shear_dot)
        .unit("N/s")
        .nominal(10.0)
        .description("Rate of the elastic shear force at the tip of arm {}");
}

fn direct_outputs(variables: &mut Variables<DualArmPlant>, rates: Evaluation) {
    let direct = variables.evaluation(DualArmPlant::direct);
    variables
        .output_field("lambda{}", direct, field!(DualArmPlant, outputs.direct.lambda))
        .rate_array(rates, |m| &mut m.outputs.rates().direct.lambda)
        .unit("N")
        .depends_on(["u_cmd", "delta_F"])
        .description(
            "Lagrange multiplier of constraint {}, eqs. (13) and (14): contact_force1 = -lambda1, contact_force2 = lambda2",
        );
    variables
        .output_field("contact_force{}", direct, field!(DualArmPlant, outputs.direct.contact_force))
        .rate_array(rates, |m| &mut m.outputs.rates().direct.contact_force)
        .unit("N")
        .depends_on(["u_cmd", "delta_F"])
        .description("Force between tip {} and the object, positive in compression; zero where they do not touch");
    variables
        .output_field("tau{}", direct, field!(DualArmPlant, outputs.direct.torque))
        .rate_array(rates, |m| &mut m.outputs.rates().direct.torque)
        .unit("N.m")
        .depends_on(["tau{}_cmd"])
        .description("Torque that actuator {} delivers, within its limits");
    variables
        .output_field("u", direct, field!(DualArmPlant, outputs.direct.force))
        .rate(rates, |m| &mut m.outputs.rates().direct.force)
        .unit("N")
        .nominal(0.1)
        .depends_on(["u_cmd"])
        .description("Force that the object's actuator delivers, within its limits");
    variables
        .output_field("in_contact", direct, field!(DualArmPlant, outputs.in_contact))
        .depends_on(["u_cmd", "delta_F"])
        .description("Whether both contact forces are compressive; with contact_model = bilateral the arms stay on the object anyway");
}

/// What a grasp that can open has besides: in one that cannot, these outputs stay zero.
fn contact(variables: &mut Variables<DualArmPlant>, rates: Evaluation) {
    const NONE: [&str; 0] = [];
    let pressing = variables.evaluation(DualArmPlant::pressing);
    let contact = variables.evaluation(DualArmPlant::contact);
    variables
        .output_field("in_contact{}", pressing, field!(DualArmPlant, outputs.pressing))
        .depends_on(["u_cmd", "delta_F"])
        .description("Whether the contact force at tip {} is compressive");
    variables
        .output_field("gap{}", contact, field!(DualArmPlant, outputs.contact.gap))
        .rate_array(rates, |m| &mut m.outputs.rates().contact.gap)
        .depends_on_states(["clearance{}", "indentation{}"])
        .unit("m")
        .nominal(0.01)
        .description(
            "Distance between tip {} and the object, zero while they touch and with contact_model = bilateral",
        );
    variables
        .output_field("indentation{}", contact, field!(DualArmPlant, outputs.contact.indentation))
        .rate_array(rates, |m| &mut m.outputs.rates().contact.indentation)
        .state()
        .depends_on_states(["clearance{}", "indentation{}"])
        .unit("m")
        .nominal(1e-3)
        .description("How far the object's face at tip {} is pressed in, with contact_model = compliant");
    variables
        .output_field("impact_loss", contact, field!(DualArmPlant, outputs.contact.loss))
        .rate(rates, |m| &mut m.outputs.rates().contact.loss)
        .state()
        .depends_on_states(["impact_loss"])
        .unit("J")
        .nominal(1e-3)
        .description("Energy lost in impacts and in the object's faces since the start");
    variables
        .output_field("impacts{}", contact, field!(DualArmPlant, outputs.impacts))
        .depends_on_states(NONE)
        .description("How often tip {} has come onto the object since the start");
    variables
        .parameter("contact_model", |m| &mut m.contact_model)
        .description("What holds the tips to the object; by default, and in the paper, they never leave it");
    variables.parameter_family(&Face::PARAMETERS, |m| &mut m.parameters.faces);
    variables.parameters(&Parameters::IMPACT, |m| &mut m.parameters);
}

fn shape_outputs(variables: &mut Variables<DualArmPlant>, rates: Evaluation) {
    let uncertainty = variables.evaluation(DualArmPlant::uncertainty);
    let shape = variables.evaluation(DualArmPlant::shape);
    let deflection = variables.evaluation(DualArmPlant::deflection);
    variables
        .output_field("tip_deflection{}", shape, field!(DualArmPlant, outputs.shape.tip_deflection))
        .rate_array(rates, |m| &mut m.outputs.rates().tip_deflection)
        .unit("m")
        .nominal(0.01)
        .description("Deflection w(l) of the tip of arm {}, back from the line that turns with the hub");
    variables
        .output_field("constraint{}", shape, field!(DualArmPlant, outputs.shape.constraint))
        .rate_array(rates, |m| &mut m.outputs.rates().constraint)
        .unit("m")
        .nominal(1e-12)
        .description("Residual of the geometric constraint (12) of arm {}, zero up to rounding");
    variables
        .output_field("root_moment{}_dot", uncertainty, field!(DualArmPlant, outputs.uncertainty.root_moment_dot))
        .rate_array(rates, |m| &mut m.outputs.rates().uncertainty.root_moment_dot)
        .unit("N.m/s")
        .description("Rate of the elastic bending moment at the root of arm {}");
    variables
        .output_field("hub_uncertainty{}", uncertainty, field!(DualArmPlant, outputs.uncertainty.delta_f))
        .rate_array(rates, |m| &mut m.outputs.rates().uncertainty.delta_f)
        .unit("N.m")
        .nominal(0.1)
        .description("Built-in disturbance torque on hub {}: -root_uncertainty times the rate of its root moment");
    variables
        .output_field("object_uncertainty", uncertainty, field!(DualArmPlant, outputs.uncertainty.delta_force))
        .rate(rates, |m| &mut m.outputs.rates().uncertainty.delta_force)
        .unit("N")
        .nominal(0.1)
        .description("Built-in disturbance force on the object, from the rates of the tip shears");
    variables
        .output_field("energy", shape, field!(DualArmPlant, outputs.shape.energy))
        .rate(rates, |m| &mut m.outputs.rates().energy)
        .unit("J")
        .nominal(0.01)
        .description("Kinetic and strain energy");
    variables
        .output_field("supplied_energy", shape, field!(DualArmPlant, outputs.shape.supplied_energy))
        .rate(rates, |m| &mut m.outputs.rates().supplied_energy)
        .state()
        .unit("J")
        .nominal(0.01)
        .description("Work done by the actuators and the external disturbances since the start");
    for arm in 0..2 {
        variables
            .output_field(
                &format!("deflection{}", arm + 1),
                deflection,
                field!(DualArmPlant, outputs.deflection).element(arm),
            )
            .rate_array(rates, move |m| &mut m.outputs.rates().deflection[arm])
            .unit("m")
            .nominal(0.01)
            .descriptions(|point| {
                let place = point as f64 / (DEFLECTION_POINTS - 1) as f64;
                format!("Deflection w(x) of arm {} at x = {place} l", arm + 1)
            });
    }
}

/// Names, units and ranges are those of the plant's own tables.
fn parameters(variables: &mut Variables<DualArmPlant>) {
    variables.parameter_family(&Arm::PARAMETERS, |m| &mut m.parameters.arms);
    variables.parameters(&Parameters::COMMON, |m| &mut m.parameters);
    variables
        .parameter("order", |m| &mut m.parameters.order)
        .range(*ORDER_RANGE.start() as f64, *ORDER_RANGE.end() as f64)
        .description("Polynomial degree of the bending moment over each arm; the velocity has two less");
    variables
        .parameter("actuator_model", |m| &mut m.actuator_model)
        .description("How the actuators turn commands into torques and the force; by default without dead zone");
    variables.parameters(&Channel::TORQUE_PARAMETERS, |m| &mut m.parameters.torque_channel);
    variables.parameters(&Channel::FORCE_PARAMETERS, |m| &mut m.parameters.force_channel);
    variables.parameters(&Start::ANGLES, |m| &mut m.parameters.start).display_degrees();
    variables.parameters(&Start::OBJECT, |m| &mut m.parameters.start);
}

/// The actuator model as a variable of the FMU: what FMI needs to know of it can't be said of another crate's type.
#[derive(Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ActuatorChoice(pub ActuatorModel);

impl Enumeration for ActuatorChoice {
    const NAME: &'static str = "ActuatorModel";
    const DESCRIPTION: &'static str = "How a command becomes an actuator output";
    const ITEMS: &'static [(&'static str, &'static str)] = &[
        ("ideal", "The output equals the command"),
        ("compensated", "Eq. (18): the dead zone is compensated, only saturation remains"),
        ("raw", "Saturation, then the dead zone"),
    ];
    const VALUES: &'static [Self] =
        &[Self(ActuatorModel::Ideal), Self(ActuatorModel::Compensated), Self(ActuatorModel::Raw)];
}

/// The contact model, likewise.
#[derive(Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ContactChoice(pub ContactModel);

impl Enumeration for ContactChoice {
    const NAME: &'static str = "ContactModel";
    const DESCRIPTION: &'static str = "What holds the tips to the object";
    const ITEMS: &'static [(&'static str, &'static str)] = &[
        ("bilateral", "Constraint (12), whatever the sign of the force: the paper's grasp"),
        ("unilateral", "Rigid faces that push and do not pull; a tip that comes back makes an impact"),
        ("compliant", "Kelvin-Voigt faces that push and do not pull: a soft or fragile object"),
    ];
    const VALUES: &'static [Self] =
        &[Self(ContactModel::Bilateral), Self(ContactModel::Unilateral), Self(ContactModel::Compliant)];
}

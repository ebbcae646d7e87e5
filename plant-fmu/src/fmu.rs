//! The plant as an FMU: names, units and dependencies of its variables, nothing else.

use std::f64::consts::PI;

use fmi2_export::{
    Declare, DefaultExperiment, Enumeration, Evaluation, Experiment, Failure, Info, Model, Step, VariableBuilder,
    Variables,
};
use grasp_plant::{
    ActuatorModel, Arm, Channel, DEFLECTION_POINTS, Direct, Inputs, LARGEST, Measured, ORDER_RANGE, Parameters, Plant,
    Rates, SMALLEST, Uncertainty,
};
use serde::{Deserialize, Serialize};

/// `DualArmPlant.fmu`.
#[derive(Clone, Serialize, Deserialize)]
pub struct DualArmPlant {
    parameters: Parameters,
    actuator_model: ActuatorChoice,
    inputs: Inputs,
    /// Slopes of the inputs over the next step.
    input_rates: Inputs,
    /// The plant, once there is a start.
    #[serde(with = "plant_state")]
    plant: Option<Plant>,
    /// Whether the grasp counts as closed, so that its next loss is worth a warning.
    is_closed: bool,
    /// What the host may look at.
    #[serde(skip)]
    outputs: Outputs,
}

/// Values of the output variables, each part filled in by the evaluation of its name.
#[derive(Clone, Default)]
struct Outputs {
    measured: Measured,
    direct: Direct,
    in_contact: bool,
    shape: Shape,
    deflection: [[f64; DEFLECTION_POINTS]; 2],
    rates: Rates,
}

/// Outputs that are for looking at rather than for feeding back.
#[derive(Clone, Default)]
struct Shape {
    tip_deflection: [f64; 2],
    constraint: [f64; 2],
    energy: f64,
    supplied_energy: f64,
    uncertainty: Uncertainty,
}

impl Default for DualArmPlant {
    fn default() -> Self {
        Self {
            parameters: Parameters::default(),
            actuator_model: ActuatorChoice::default(),
            inputs: Inputs::ZERO,
            input_rates: Inputs::ZERO,
            plant: None,
            is_closed: true,
            outputs: Outputs::default(),
        }
    }
}

impl DualArmPlant {
    /// Tension that is more than rounding \[N\].
    const TENSION: f64 = 1e-9;
    /// Compression from which on a grasp counts as closed again \[N\]: forces that tremble about zero warn once.
    const FIRM: f64 = 0.01;

    /// The parameters as the host has set them.
    fn parameters(&self) -> Parameters {
        Parameters { actuator_model: self.actuator_model.0, ..self.parameters.clone() }
    }

    fn measured(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.measured = plant.measured();
        }
    }

    fn direct(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.direct = plant.direct(&self.inputs);
            self.outputs.in_contact = self.outputs.direct.in_contact();
        }
    }

    fn shape(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.shape = Shape {
                tip_deflection: plant.tip_deflection(),
                constraint: plant.constraint(),
                energy: plant.energy(),
                supplied_energy: plant.supplied_energy(),
                uncertainty: plant.uncertainty(),
            };
        }
    }

    fn deflection(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.deflection = plant.deflection();
        }
    }

    fn rates(&mut self) {
        if let Some(plant) = &self.plant {
            self.outputs.rates = plant.rates(&self.inputs, &self.input_rates);
        }
    }
}

impl Declare for DualArmPlant {
    const INFO: Info = Info {
        name: "DualArmPlant",
        description: "Two flexible one-link arms (Euler-Bernoulli beams on motor hubs) grasping an object",
        version: env!("CARGO_PKG_VERSION"),
        license: env!("CARGO_PKG_LICENSE"),
        default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 2.0, step_size: 1e-4, tolerance: None },
        directional_derivatives: true,
        ..Info::new()
    };

    fn variables(variables: &mut Variables<Self>) {
        inputs(variables);
        let rates = variables.evaluation(Self::rates);
        measured_outputs(variables, rates);
        direct_outputs(variables, rates);
        shape_outputs(variables, rates);
        for arm in 0..2 {
            arm_parameters(variables, arm);
        }
        common_parameters(variables);
        channel_parameters(variables, "hub torque", 1, "N.m", |p| &mut p.torque_channel);
        channel_parameters(variables, "object force", 2, "N", |p| &mut p.force_channel);
        start_parameters(variables);
    }
}

impl Model for DualArmPlant {
    fn initialize(&mut self, _experiment: &Experiment) -> Result<(), Failure> {
        self.is_closed = true;
        let parameters = self.parameters();
        match &mut self.plant {
            Some(plant) if *plant.parameters() == parameters => plant.reset(),
            plant => *plant = Some(Plant::new(parameters).map_err(Failure::error)?),
        }
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        let plant = self.plant.as_mut().ok_or_else(|| Failure::error("the plant has no start yet"))?;
        plant.step(step.size, &self.inputs, &self.input_rates).map_err(Failure::discard)?;
        let forces = plant.direct(&self.inputs).contact_force;
        let (arm, weakest) = if forces[0] <= forces[1] { (1, forces[0]) } else { (2, forces[1]) };
        if self.is_closed && weakest < -Self::TENSION {
            self.is_closed = false;
            let time = step.time + step.size;
            step.warn(format_args!(
                "contact lost at t = {time} s: the force at tip {arm} is {weakest:.3e} N. The model goes on holding the \
                 arms to the object, which no real grasp does; start with a preload or see in_contact"
            ));
        } else if weakest > Self::FIRM {
            self.is_closed = true;
        }
        Ok(())
    }

    fn restored(&mut self) -> Result<(), Failure> {
        // In initialization mode the parameters may have changed since the plant was made; it will be made anew then.
        let parameters = self.parameters();
        self.plant.take_if(|plant| *plant.parameters() != parameters);
        let Some(plant) = &self.plant else { return Ok(()) };
        let lambda = plant.direct(&self.inputs).lambda;
        if !(plant.energy().is_finite() && lambda.iter().all(|value| value.is_finite())) {
            return Err(Failure::error("the plant in the state has energy or forces that are not finite"));
        }
        Ok(())
    }

    fn directional_derivative(&mut self, direction: &mut Self) {
        if let Some(plant) = &self.plant {
            direction.outputs.direct = plant.direct_derivative(&self.inputs, &direction.inputs);
        }
    }
}

type Builder<'a> = VariableBuilder<'a, DualArmPlant>;

/// An angle or a rate of one, shown in degrees.
fn angle<'a>(builder: Builder<'a>, unit: &str, shown: &str) -> Builder<'a> {
    builder.unit(unit).display_unit(shown, 180.0 / PI)
}

fn inputs(variables: &mut Variables<DualArmPlant>) {
    for arm in 0..2 {
        variables
            .input(format!("tau{}_cmd", arm + 1), move |m| &mut m.inputs.torque_command[arm])
            .ramp(move |m| &mut m.input_rates.torque_command[arm])
            .unit("N.m")
            .nominal(1.0)
            .description(&format!("Commanded torque on hub {}, before the actuator's limits", arm + 1));
    }
    variables
        .input("u_cmd", |m| &mut m.inputs.force_command)
        .ramp(|m| &mut m.input_rates.force_command)
        .unit("N")
        .nominal(0.1)
        .description("Commanded force on the object, before the actuator's limits");
    for arm in 0..2 {
        variables
            .input(format!("delta_f{}", arm + 1), move |m| &mut m.inputs.hub_disturbance[arm])
            .ramp(move |m| &mut m.input_rates.hub_disturbance[arm])
            .unit("N.m")
            .nominal(0.1)
            .description(&format!("External disturbance torque on hub {}, added to the built-in one", arm + 1));
    }
    variables
        .input("delta_F", |m| &mut m.inputs.object_disturbance)
        .ramp(|m| &mut m.input_rates.object_disturbance)
        .unit("N")
        .nominal(0.1)
        .description("External disturbance force on the object, added to the built-in one");
}

/// An output for each arm, `{}` in name and description standing for its number.
struct PerArm<'v> {
    variables: &'v mut Variables<DualArmPlant>,
    evaluation: Evaluation,
    rates: Evaluation,
}

type PerArmField = fn(&mut Outputs) -> &mut [f64; 2];

impl PerArm<'_> {
    /// Declares the pair; `finish` adds unit and dependencies.
    fn declare(
        &mut self,
        name: &str,
        description: &str,
        field: PerArmField,
        rate: PerArmField,
        finish: impl for<'b> Fn(Builder<'b>) -> Builder<'b>,
    ) {
        for arm in 0..2 {
            let number = (arm + 1).to_string();
            let builder = self
                .variables
                .output(name.replace("{}", &number), self.evaluation, move |m| &mut field(&mut m.outputs)[arm])
                .rate(self.rates, move |m| &mut rate(&mut m.outputs)[arm]);
            finish(builder).description(&description.replace("{}", &number));
        }
    }
}

fn measured_outputs(variables: &mut Variables<DualArmPlant>, rates: Evaluation) {
    let measured = variables.evaluation(DualArmPlant::measured);
    let mut arms = PerArm { variables, evaluation: measured, rates };
    arms.declare(
        "theta{}",
        "Angle of hub {}, counter-clockwise",
        |o| &mut o.measured.theta,
        |o| &mut o.rates.measured.theta,
        |b| angle(b, "rad", "deg").nominal(0.1),
    );
    arms.declare(
        "theta{}_dot",
        "Angular velocity of hub {}",
        |o| &mut o.measured.theta_dot,
        |o| &mut o.rates.measured.theta_dot,
        |b| angle(b, "rad/s", "deg/s"),
    );
    arms.variables
        .output("y_object", measured, |m| &mut m.outputs.measured.y_object)
        .rate(rates, |m| &mut m.outputs.rates.measured.y_object)
        .unit("m")
        .nominal(0.05)
        .description("Position y_M of the object's centre above hub 1; L/2 when straight arms just touch it");
    arms.variables
        .output("y_object_dot", measured, |m| &mut m.outputs.measured.y_object_dot)
        .rate(rates, |m| &mut m.outputs.rates.measured.y_object_dot)
        .unit("m/s")
        .nominal(0.1)
        .description("Velocity of the object");
    arms.declare(
        "root_moment{}",
        "Elastic bending moment EI w''(0) at the root of arm {}",
        |o| &mut o.measured.root_moment,
        |o| &mut o.rates.measured.root_moment,
        |b| b.unit("N.m").nominal(0.1),
    );
    arms.declare(
        "tip_shear{}",
        "Elastic shear force EI w'''(l) at the tip of arm {}",
        |o| &mut o.measured.tip_shear,
        |o| &mut o.rates.measured.tip_shear,
        |b| b.unit("N"),
    );
    arms.declare(
        "tip_shear{}_dot",
        "Rate of the elastic shear force at the tip of arm {}",
        |o| &mut o.measured.tip_shear_dot,
        |o| &mut o.rates.measured.tip_shear_dot,
        |b| b.unit("N/s").nominal(10.0),
    );
}

fn direct_outputs(variables: &mut Variables<DualArmPlant>, rates: Evaluation) {
    let direct = variables.evaluation(DualArmPlant::direct);
    let mut arms = PerArm { variables, evaluation: direct, rates };
    arms.declare(
        "lambda{}",
        "Lagrange multiplier of constraint {}, eqs. (13) and (14): contact_force1 = -lambda1, contact_force2 = lambda2",
        |o| &mut o.direct.lambda,
        |o| &mut o.rates.direct.lambda,
        |b| b.unit("N").depends_on(["u_cmd"]).depends_linearly_on(["delta_F"]),
    );
    arms.declare(
        "contact_force{}",
        "Force between tip {} and the object, positive in compression",
        |o| &mut o.direct.contact_force,
        |o| &mut o.rates.direct.contact_force,
        |b| b.unit("N").depends_on(["u_cmd"]).depends_linearly_on(["delta_F"]),
    );
    for arm in 0..2 {
        arms.variables
            .output(format!("tau{}", arm + 1), direct, move |m| &mut m.outputs.direct.torque[arm])
            .rate(rates, move |m| &mut m.outputs.rates.direct.torque[arm])
            .unit("N.m")
            .depends_on([format!("tau{}_cmd", arm + 1)])
            .description(&format!("Torque that actuator {} delivers, within its limits", arm + 1));
    }
    variables
        .output("u", direct, |m| &mut m.outputs.direct.force)
        .rate(rates, |m| &mut m.outputs.rates.direct.force)
        .unit("N")
        .nominal(0.1)
        .depends_on(["u_cmd"])
        .description("Force that the object's actuator delivers, within its limits");
    variables
        .output("in_contact", direct, |m| &mut m.outputs.in_contact)
        .depends_on(["u_cmd", "delta_F"])
        .description("Whether both contact forces are compressive; the model itself holds the arms to the object");
}

fn shape_outputs(variables: &mut Variables<DualArmPlant>, rates: Evaluation) {
    let shape = variables.evaluation(DualArmPlant::shape);
    let deflection = variables.evaluation(DualArmPlant::deflection);
    let mut arms = PerArm { variables, evaluation: shape, rates };
    arms.declare(
        "tip_deflection{}",
        "Deflection w(l) of the tip of arm {}, back from the line that turns with the hub",
        |o| &mut o.shape.tip_deflection,
        |o| &mut o.rates.tip_deflection,
        |b| b.unit("m").nominal(0.01),
    );
    arms.declare(
        "constraint{}",
        "Residual of the geometric constraint (12) of arm {}, zero up to rounding",
        |o| &mut o.shape.constraint,
        |o| &mut o.rates.constraint,
        |b| b.unit("m").nominal(1e-12),
    );
    arms.declare(
        "root_moment{}_dot",
        "Rate of the elastic bending moment at the root of arm {}",
        |o| &mut o.shape.uncertainty.root_moment_dot,
        |o| &mut o.rates.uncertainty.root_moment_dot,
        |b| b.unit("N.m/s"),
    );
    arms.declare(
        "hub_uncertainty{}",
        "Built-in disturbance torque on hub {}: -root_uncertainty times the rate of its root moment",
        |o| &mut o.shape.uncertainty.delta_f,
        |o| &mut o.rates.uncertainty.delta_f,
        |b| b.unit("N.m").nominal(0.1),
    );
    variables
        .output("object_uncertainty", shape, |m| &mut m.outputs.shape.uncertainty.delta_force)
        .rate(rates, |m| &mut m.outputs.rates.uncertainty.delta_force)
        .unit("N")
        .nominal(0.1)
        .description("Built-in disturbance force on the object, from the rates of the tip shears");
    variables
        .output("energy", shape, |m| &mut m.outputs.shape.energy)
        .rate(rates, |m| &mut m.outputs.rates.energy)
        .unit("J")
        .nominal(0.01)
        .description("Kinetic and strain energy");
    variables
        .output("supplied_energy", shape, |m| &mut m.outputs.shape.supplied_energy)
        .rate(rates, |m| &mut m.outputs.rates.supplied_energy)
        .unit("J")
        .nominal(0.01)
        .description("Work done by the actuators and the external disturbances since the start");
    for arm in 0..2 {
        variables
            .output_array(&format!("deflection{}", arm + 1), deflection, move |m| &mut m.outputs.deflection[arm][..])
            .rate_array(rates, move |m| &mut m.outputs.rates.deflection[arm][..])
            .unit("m")
            .nominal(0.01)
            .descriptions(|point| {
                let place = point as f64 / (DEFLECTION_POINTS - 1) as f64;
                format!("Deflection w(x) of arm {} at x = {place} l", arm + 1)
            });
    }
}

fn arm_parameters(variables: &mut Variables<DualArmPlant>, arm: usize) {
    type Field = fn(&mut Arm) -> &mut f64;
    let number = arm + 1;
    let fields: [(&str, Field, &str, &str); 4] = [
        ("EI", |a| &mut a.ei, "N.m2", "Flexural rigidity of arm"),
        ("rho", |a| &mut a.rho, "kg/m", "Mass per length of arm"),
        ("m", |a| &mut a.tip_mass, "kg", "Point mass at the tip of arm"),
        ("J", |a| &mut a.hub_inertia, "kg.m2", "Moment of inertia of hub"),
    ];
    for (name, field, unit, description) in fields {
        variables
            .parameter(format!("{name}{number}"), move |m| field(&mut m.parameters.arms[arm]))
            .unit(unit)
            .range(SMALLEST, LARGEST)
            .description(&format!("{description} {number}"));
    }
}

fn common_parameters(variables: &mut Variables<DualArmPlant>) {
    type Field = fn(&mut Parameters) -> &mut f64;
    let positive: [(&str, Field, &str, &str); 3] = [
        ("l", |p| &mut p.length, "m", "Length of each arm"),
        (
            "L",
            |p| &mut p.object_width,
            "m",
            "Width of the object and distance of the hubs: straight arms just touch it",
        ),
        ("M", |p| &mut p.object_mass, "kg", "Mass of the object"),
    ];
    for (name, field, unit, description) in positive {
        variables
            .parameter(name, move |m| field(&mut m.parameters))
            .unit(unit)
            .range(SMALLEST, LARGEST)
            .description(description);
    }
    let time_constants: [(&str, Field, &str); 3] = [
        (
            "root_uncertainty",
            |p| &mut p.root_uncertainty,
            "c_f of the built-in disturbance -c_f d/dt EI w''(0) on each hub; 0 = none",
        ),
        (
            "tip_uncertainty",
            |p| &mut p.tip_uncertainty,
            "c_F of the built-in disturbance -c_F (EI1+EI2) d/dt(w1'''(l)+w2'''(l)) on the object; 0 = none",
        ),
        (
            "kelvin_voigt",
            |p| &mut p.kelvin_voigt,
            "Kelvin-Voigt coefficient: the arms transmit the moment EI (w'' + kelvin_voigt d/dt w''); 0 = none",
        ),
    ];
    for (name, field, description) in time_constants {
        variables
            .parameter(name, move |m| field(&mut m.parameters))
            .unit("s")
            .range(0.0, LARGEST)
            .description(description);
    }
    let (least, greatest) = (*ORDER_RANGE.start() as f64, *ORDER_RANGE.end() as f64);
    variables
        .parameter("order", |m| &mut m.parameters.order)
        .range(least, greatest)
        .description("Polynomial degree of the bending moment over each arm; the velocity has two less");
    variables
        .parameter("actuator_model", |m| &mut m.actuator_model)
        .description("How the actuators turn commands into torques and the force; by default without dead zone");
}

fn channel_parameters(
    variables: &mut Variables<DualArmPlant>,
    what: &str,
    number: usize,
    unit: &str,
    channel: fn(&mut Parameters) -> &mut Channel,
) {
    type Field = fn(&mut Channel) -> &mut f64;
    let fields: [(&str, Field, &str, [f64; 2], &str); 6] = [
        ("k_M", |c| &mut c.k_max, unit, [0.0, LARGEST], "Upper saturation level"),
        ("k_m", |c| &mut c.k_min, unit, [-LARGEST, 0.0], "Lower saturation level"),
        ("m_r", |c| &mut c.m_r, unit, [0.0, LARGEST], "Upper end of the dead zone"),
        ("m_l", |c| &mut c.m_l, unit, [-LARGEST, 0.0], "Lower end of the dead zone"),
        ("k_r", |c| &mut c.k_r, "1", [SMALLEST, LARGEST], "Slope above the dead zone"),
        ("k_l", |c| &mut c.k_l, "1", [SMALLEST, LARGEST], "Slope below the dead zone"),
    ];
    for (name, field, unit, [min, max], description) in fields {
        variables
            .parameter(format!("{name}{number}"), move |m| field(channel(&mut m.parameters)))
            .unit(unit)
            .range(min, max)
            .description(&format!("{description}, {what} channel, eq. (18)"));
    }
}

fn start_parameters(variables: &mut Variables<DualArmPlant>) {
    for arm in 0..2 {
        angle(
            variables.parameter(format!("theta{}_0", arm + 1), move |m| &mut m.parameters.start.theta[arm]),
            "rad",
            "deg",
        )
        .range(-LARGEST, LARGEST)
        .description(&format!("Angle of hub {} at the start", arm + 1));
        angle(
            variables.parameter(format!("theta{}_dot_0", arm + 1), move |m| &mut m.parameters.start.theta_dot[arm]),
            "rad/s",
            "deg/s",
        )
        .range(-LARGEST, LARGEST)
        .description(&format!("Angular velocity of hub {} at the start", arm + 1));
    }
    variables
        .parameter("y_object_0", |m| &mut m.parameters.start.y_object)
        .unit("m")
        .range(-LARGEST, LARGEST)
        .description("Position of the object at the start; the arms' shapes follow from it and the hub angles");
    variables
        .parameter("y_object_dot_0", |m| &mut m.parameters.start.y_object_dot)
        .unit("m/s")
        .range(-LARGEST, LARGEST)
        .description("Velocity of the object at the start");
}

/// The actuator model as a variable of the FMU.
#[derive(Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
struct ActuatorChoice(ActuatorModel);

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

/// A plant in a saved state is its parameters and what moves; the matrices are computed again.
mod plant_state {
    use grasp_plant::{Parameters, Plant, State};
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    #[allow(clippy::ref_option)] // The signature serde asks for.
    pub fn serialize<S: Serializer>(plant: &Option<Plant>, serializer: S) -> Result<S::Ok, S::Error> {
        plant.as_ref().map(|plant| (plant.parameters(), plant.state())).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Plant>, D::Error> {
        let Some((parameters, state)) = Option::<(Parameters, State)>::deserialize(deserializer)? else {
            return Ok(None);
        };
        let mut plant = Plant::new(parameters).map_err(D::Error::custom)?;
        plant.set_state(&state).map_err(D::Error::custom)?;
        Ok(Some(plant))
    }
}

fmi2_export::export!(DualArmPlant);

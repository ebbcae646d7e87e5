//! `NabfcController.fmu`.

use fmi2_export::{Evaluation, StateVariable, Variables, field};
use grasp_control::continuous::{
    Continuous, Decision, Direction, NABFC_INDICATORS, Regimes, nabfc_state_variables, nabfc_states,
};
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::nabfc::{Estimates, Gains, Nabfc, RbfLayout, Surfaces};
use grasp_control::laws::root_strain::{Learner, RootStrain, RootStrainGains};
use grasp_control::{Arms, CommandJacobian, Commands, Inputs, InvalidParameter, Law, StepError, inner};
use serde::{Deserialize, Serialize};

use super::gains::{chosen, declare};
use super::{Controller, FmuLaw, Rates};

/// `NabfcController.fmu`.
pub type NabfcController = Controller<NabfcLaw>;

fmi2_export::enumeration! {
    /// Which law commands the grasp
    pub enum Choice {
        Paper = "paper": "Equations (31)-(39) and (49)-(57) of the paper",
        #[default]
        RootStrain = "root_strain": "Root strain in the posture surface, disturbances learnt from prediction errors, estimated mass; its parameters begin with r_",
    }
}

fmi2_export::enumeration! {
    /// Where the gains of the law come from
    pub enum Preset {
        #[default]
        Parameters = "parameters": "As the gain parameters say; their start values are tuned for robustness",
        Fast = "fast": "A built-in set with the shortest settling time; the gain parameters are not used",
        Certified = "certified": "A built-in set of the law root_strain with a proof of its decay; for the paper's law, which has none, its start values",
    }
}

fmi2_export::enumeration! {
    /// What learns the disturbances in the root-strain law
    pub enum LearnerChoice {
        #[default]
        Observer = "observer": "The weight of one constant basis function per coordinate",
        Networks = "networks": "Networks and robust terms as in the paper, laid out as rbf_... say",
    }
}

impl From<LearnerChoice> for Learner {
    fn from(learner: LearnerChoice) -> Self {
        match learner {
            LearnerChoice::Observer => Self::Observer,
            LearnerChoice::Networks => Self::Networks,
        }
    }
}

/// The settings of the user.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
pub struct Settings {
    choice: Choice,
    preset: Preset,
    rates: Rates,
    gains: Gains,
    root_strain: RootStrainGains,
    learner: LearnerChoice,
    actuation: Actuation,
}

impl Settings {
    fn gains(&self) -> Gains {
        chosen(self.preset, self.gains)
    }

    fn root_strain(&self) -> RootStrainGains {
        RootStrainGains { learner: self.learner.into(), ..chosen(self.preset, self.root_strain) }
    }
}

/// One of the two laws.
#[derive(Serialize, Deserialize)]
pub enum NabfcLaw {
    /// The paper's.
    Paper(Box<Encoders<Nabfc>>),
    /// With root strain in the posture surface.
    RootStrain(Box<RootStrain>),
}

impl Clone for NabfcLaw {
    fn clone(&self) -> Self {
        match self {
            Self::Paper(law) => Self::Paper(law.clone()),
            Self::RootStrain(law) => Self::RootStrain(law.clone()),
        }
    }

    /// The same in the memory that is there.
    fn clone_from(&mut self, source: &Self) {
        match (self, source) {
            (Self::Paper(law), Self::Paper(source)) => law.clone_from(source),
            (Self::RootStrain(law), Self::RootStrain(source)) => law.clone_from(source),
            (law, source) => *law = source.clone(),
        }
    }
}

impl NabfcLaw {
    fn law(&self) -> &dyn Continuous {
        match self {
            Self::Paper(law) => &**law,
            Self::RootStrain(law) => &**law,
        }
    }

    fn law_mut(&mut self) -> &mut dyn Continuous {
        match self {
            Self::Paper(law) => &mut **law,
            Self::RootStrain(law) => &mut **law,
        }
    }
}

impl Law for NabfcLaw {
    fn arms(&self) -> &Arms {
        self.law().arms()
    }

    fn initialize(&mut self, inputs: &Inputs) {
        self.law_mut().initialize(inputs);
    }

    fn commands(&mut self, inputs: &Inputs) -> Commands {
        self.law_mut().commands(inputs)
    }

    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        self.law_mut().step(h, inputs, rates)
    }

    fn jacobian(&mut self, inputs: &Inputs) -> CommandJacobian {
        self.law_mut().jacobian(inputs)
    }

    fn command_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Commands {
        self.law_mut().command_rates(inputs, rates)
    }
}

impl Continuous for NabfcLaw {
    fn continuous_states(&self, out: &mut [f64]) {
        self.law().continuous_states(out);
    }

    fn take_states(&mut self, states: &[f64]) {
        self.law_mut().take_states(states);
    }

    fn present_commands(&mut self, inputs: &Inputs) -> Commands {
        self.law_mut().present_commands(inputs)
    }

    fn command_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Commands {
        self.law_mut().command_change(inputs, along)
    }

    fn derivatives(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        self.law_mut().derivatives(inputs, regimes, out);
    }

    fn derivative_change(&mut self, inputs: &Inputs, regimes: &Regimes, along: Direction<'_>, out: &mut [f64]) {
        self.law_mut().derivative_change(inputs, regimes, along, out);
    }

    fn event_indicators(&mut self, inputs: &Inputs, regimes: &Regimes, out: &mut [f64]) {
        self.law_mut().event_indicators(inputs, regimes, out);
    }

    fn decide(&mut self, inputs: &Inputs, regimes: &mut Regimes) -> Decision {
        self.law_mut().decide(inputs, regimes)
    }
}

/// The sliding variables and the estimates.
#[derive(Clone, Copy, Default)]
pub struct Extra {
    surfaces: Surfaces,
    estimates: Estimates,
}

/// Change of the paper's sliding variables along a direction of the law's inputs, in which they are linear.
fn paper_surfaces(law: &Nabfc, direction: &Inputs) -> Surfaces {
    let (jacobian, direction) = (law.surface_jacobian(), direction.to_array());
    Surfaces {
        object: inner(&jacobian.object, &direction),
        posture: jacobian.posture.map(|row| inner(&row, &direction)),
    }
}

impl FmuLaw for NabfcLaw {
    type Settings = Settings;
    type Extra = Extra;

    const NAME: &'static str = "NabfcController";
    const DESCRIPTION: &'static str =
        "Neuro-adaptive boundary force control (NABFC) of the dual-arm grasp, eqs. (31)-(39) and (49)-(57)";
    const FORCE_ALSO_DEPENDS_ON: &'static [&'static str] = &["tip_shear1_dot", "tip_shear2_dot"];
    const TORQUE_ALSO_DEPENDS_ON: &'static [&'static str] = &["root_moment{}_dot"];
    const INDICATORS: usize = NABFC_INDICATORS;
    const COUNT_FOLLOWS_FROM: &'static str = "rbf_nodes_posture and rbf_rings_object";

    fn state_variables(settings: &Settings) -> Vec<StateVariable> {
        nabfc_state_variables(&settings.gains.rbf)
    }

    fn state_count(settings: &Settings) -> usize {
        nabfc_states(&settings.gains.rbf)
    }

    fn create(arms: Arms, settings: &Settings) -> Result<Self, InvalidParameter> {
        // Both are checked, so that a parameter's range does not depend on another parameter.
        let paper = Nabfc::new(arms, settings.gains())?;
        let (rates, actuation) = (settings.rates.into(), settings.actuation);
        let root_strain = RootStrain::new(arms, settings.root_strain(), actuation, rates, &settings.gains.rbf)?;
        Ok(match settings.choice {
            Choice::Paper => Self::Paper(Box::new(Encoders::new(paper, rates, actuation)?)),
            Choice::RootStrain => Self::RootStrain(Box::new(root_strain)),
        })
    }

    fn retune(&mut self, settings: &Settings) -> Result<(), InvalidParameter> {
        settings.gains().validate()?;
        settings.root_strain().validate()?;
        match self {
            Self::Paper(law) => {
                settings.actuation.validate()?;
                law.law_mut().set_gains(settings.gains())?;
                law.set_actuation(settings.actuation)
            }
            Self::RootStrain(law) => law.set_gains(settings.root_strain(), settings.actuation),
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Paper(law), Self::Paper(other)) => {
                law.has_settings_of(other) && law.law().has_settings_of(other.law())
            }
            (Self::RootStrain(law), Self::RootStrain(other)) => law.has_settings_of(other),
            _ => false,
        }
    }

    fn declare_settings(variables: &mut Variables<NabfcController>) {
        variables.parameter("law", |m| &mut m.settings.choice).description("Which law commands the grasp");
        variables.parameter("preset", |m| &mut m.settings.preset).description("Where the gains come from");
        declare(variables, |m| &mut m.settings.gains, |_| {});
        let (posture, object) = (RbfLayout::NODES_POSTURE, RbfLayout::RINGS_OBJECT);
        variables
            .parameter("rbf_nodes_posture", |m| &mut m.settings.gains.rbf.nodes_posture)
            .range(f64::from(*posture.start()), f64::from(*posture.end()))
            .description("Nodes of each posture network along each of its three axes");
        variables
            .parameter("rbf_rings_object", |m| &mut m.settings.gains.rbf.rings_object)
            .range(f64::from(*object.start()), f64::from(*object.end()))
            .description("Nodes of the object network on each side of the centre along each of its seven axes");
        declare(
            variables,
            |m| &mut m.settings.root_strain,
            |variables| {
                variables
                    .parameter("r_learner", |m| &mut m.settings.learner)
                    .description("Root-strain law: what learns the disturbances");
            },
        );
        variables
            .parameter("rate_source", |m| &mut m.settings.rates)
            .description("Where the rates of angles, position and strain come from");
        variables.parameters(Actuation::PARAMETERS, |m| &mut m.settings.actuation).tunable();
    }

    fn declare_extra(variables: &mut Variables<NabfcController>, rates: Evaluation) {
        let extra = variables.evaluation(NabfcController::extra);
        surface_outputs(variables, extra, rates);
        estimate_outputs(variables, extra, rates);
    }

    fn extra(&self, inputs: &Inputs) -> Extra {
        match self {
            Self::Paper(law) => {
                let (seen, law) = (law.seen(inputs), law.law());
                Extra { surfaces: law.surfaces(&seen), estimates: law.estimates() }
            }
            Self::RootStrain(law) => Extra { surfaces: law.surfaces(inputs), estimates: law.estimates() },
        }
    }

    fn extra_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Extra {
        match self {
            Self::Paper(law) => {
                let (seen, seen_rates) = (law.seen(inputs), law.seen_rates(inputs, rates));
                let surfaces = paper_surfaces(law.law(), &seen_rates);
                Extra { surfaces, estimates: law.law_mut().estimate_rates(&seen) }
            }
            Self::RootStrain(law) => {
                Extra { surfaces: law.surface_rates(inputs, rates), estimates: law.estimate_rates(inputs) }
            }
        }
    }

    fn extra_change(&mut self, inputs: &Inputs, along: Direction<'_>) -> Extra {
        match self {
            Self::Paper(law) => {
                let seen = law.seen_change(along);
                let surfaces = law.law().surface_change(Direction { inputs: &seen, ..along });
                Extra { surfaces, estimates: law.law().estimate_change(along.states) }
            }
            Self::RootStrain(law) => {
                Extra { surfaces: law.surface_change(inputs, along), estimates: law.estimate_change(along.states) }
            }
        }
    }

    fn extra_derivative(&self, inputs: &Inputs, direction: &Inputs) -> Extra {
        let surfaces = match self {
            Self::Paper(law) => paper_surfaces(law.law(), &law.seen_direction(direction)),
            Self::RootStrain(law) => law.surface_derivative(inputs, direction),
        };
        // Estimates change with time only.
        Extra { surfaces, estimates: Estimates::default() }
    }
}

fn surface_outputs(variables: &mut Variables<NabfcController>, extra: Evaluation, rates: Evaluation) {
    variables
        .output_field("s", extra, field!(NabfcController, extra.surfaces.object))
        .rate(rates, |m| &mut m.rates_of_extra().surfaces.object)
        .unit("m/s")
        .depends_on(["y_object", "y_object_dot", "tip_shear1", "tip_shear2", "lambda1_ref", "theta1_ref"])
        .description("Sliding variable of the object loop, eq. (33) or its counterpart of the root-strain law");
    for i in 0..2 {
        let n = i + 1;
        let output =
            variables.output_field(&format!("s{n}"), extra, field!(NabfcController, extra.surfaces.posture).element(i));
        output
            .unit("rad/s")
            .display_degrees()
            .rate(rates, move |m| &mut m.rates_of_extra().surfaces.posture[i])
            .depends_on([format!("theta{n}"), format!("theta{n}_dot"), format!("root_moment{n}")])
            .depends_on(["theta1_ref", "lambda1_ref"])
            .description(&format!(
                "Sliding variable of posture loop {n}, eq. (51) or its counterpart of the root-strain law"
            ));
    }
}

fn estimate_outputs(variables: &mut Variables<NabfcController>, extra: Evaluation, rates: Evaluation) {
    type Field = fn(&mut Estimates) -> &mut f64;
    let fields: [(&str, Field, &str, f64, &str); 9] = [
        ("m_hat", |e| &mut e.m_hat, "kg", 0.1, "Estimate of the moving mass m1 + m2 + M, eq. (39)"),
        ("J1_hat", |e| &mut e.j_hat[0], "kg.m2", 1e-3, "Estimate of the inertia of hub 1, eq. (57)"),
        ("J2_hat", |e| &mut e.j_hat[1], "kg.m2", 1e-3, "Estimate of the inertia of hub 2, eq. (57)"),
        ("epsilon_hat", |e| &mut e.epsilon_hat, "N", 0.1, "Estimated bound of the object network's error, eq. (38)"),
        ("pi1_hat", |e| &mut e.pi_hat[0], "N.m", 0.1, "Estimated bound of posture network 1's error, eq. (56)"),
        ("pi2_hat", |e| &mut e.pi_hat[1], "N.m", 0.1, "Estimated bound of posture network 2's error, eq. (56)"),
        ("W_norm", |e| &mut e.w_norm, "N", 0.1, "Norm of the object network's weights, eq. (37)"),
        ("U1_norm", |e| &mut e.u_norm[0], "N.m", 0.1, "Norm of posture network 1's weights, eq. (55)"),
        ("U2_norm", |e| &mut e.u_norm[1], "N.m", 0.1, "Norm of posture network 2's weights, eq. (55)"),
    ];
    for (name, field, unit, nominal, description) in fields {
        variables
            .output(name, extra, move |m| field(&mut m.extra.estimates))
            .rate(rates, move |m| field(&mut m.rates_of_extra().estimates))
            .unit(unit)
            .nominal(nominal)
            .description(description);
    }
}

//! `NabfcController.fmu`.

use fmi2_export::{Evaluation, Variables};
use grasp_control::laws::nabfc::{Estimates, Gains, Nabfc, ObjectGains, PostureGains, RbfLayout, Surfaces};
use grasp_control::{Arms, Inputs, InvalidParameter, inner};
use serde::{Deserialize, Serialize};

use super::{Controller, FmuLaw};

/// `NabfcController.fmu`.
pub type NabfcController = Controller<Nabfc>;

fmi2_export::enumeration! {
    /// Where the gains of the law come from
    pub enum Preset {
        #[default]
        Parameters = "parameters": "As the gain parameters say; their start values are tuned for robustness",
        Fast = "fast": "A built-in set with the shortest settling time; the gain parameters are not used",
    }
}

/// What the user can set.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Settings {
    preset: Preset,
    gains: Gains,
}

impl Settings {
    fn gains(&self) -> Gains {
        match self.preset {
            Preset::Parameters => self.gains,
            Preset::Fast => Gains::fast(),
        }
    }
}

/// The sliding variables and the estimates.
#[derive(Clone, Default)]
pub struct Extra {
    surfaces: Surfaces,
    estimates: Estimates,
}

impl FmuLaw for Nabfc {
    type Settings = Settings;
    type Extra = Extra;

    const NAME: &'static str = "NabfcController";
    const DESCRIPTION: &'static str =
        "Neuro-adaptive boundary force control (NABFC) of the dual-arm grasp, eqs. (31)-(39) and (49)-(57)";
    const FORCE_ALSO_DEPENDS_ON: &'static [&'static str] = &["tip_shear1_dot", "tip_shear2_dot"];

    fn create(arms: Arms, settings: &Settings) -> Result<Self, InvalidParameter> {
        Self::new(arms, settings.gains())
    }

    fn retune(&mut self, settings: &Settings) -> Result<(), InvalidParameter> {
        self.set_gains(settings.gains())
    }

    fn is_like(&self, other: &Self) -> bool {
        self.has_settings_of(other)
    }

    fn declare_settings(variables: &mut Variables<NabfcController>) {
        variables.parameter("preset", |m| &mut m.settings.preset).description("Where the gains come from");
        variables.tunables(ObjectGains::PARAMETERS.map(Into::into), |m| &mut m.settings.gains.object);
        variables.tunable_family(PostureGains::PARAMETERS.map(Into::into), |m| &mut m.settings.gains.posture);
        variables.tunables(Gains::PARAMETERS.map(Into::into), |m| &mut m.settings.gains);
        variables.parameter_family(PostureGains::FIXED.map(Into::into), |m| &mut m.settings.gains.posture);
        variables.parameters(ObjectGains::FIXED.map(Into::into), |m| &mut m.settings.gains.object);
        variables.parameters(RbfLayout::PARAMETERS.map(Into::into), |m| &mut m.settings.gains.rbf);
        let (posture, object) = (RbfLayout::NODES_POSTURE, RbfLayout::RINGS_OBJECT);
        variables
            .parameter("rbf_nodes_posture", |m| &mut m.settings.gains.rbf.nodes_posture)
            .range(f64::from(*posture.start()), f64::from(*posture.end()))
            .description("Nodes of each posture network along each of its three axes");
        variables
            .parameter("rbf_rings_object", |m| &mut m.settings.gains.rbf.rings_object)
            .range(f64::from(*object.start()), f64::from(*object.end()))
            .description("Nodes of the object network on each side of the centre along each of its seven axes");
    }

    fn declare_extra(variables: &mut Variables<NabfcController>, rates: Evaluation) {
        let extra = variables.evaluation(NabfcController::extra);
        surface_outputs(variables, extra, rates);
        estimate_outputs(variables, extra, rates);
    }

    fn extra(&self, inputs: &Inputs) -> Extra {
        Extra { surfaces: self.surfaces(inputs), estimates: self.estimates() }
    }

    fn extra_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Extra {
        // The sliding variables are linear in the inputs and depend on nothing else.
        Extra { estimates: self.estimate_rates(inputs), ..self.extra_derivative(rates) }
    }

    fn extra_derivative(&self, direction: &Inputs) -> Extra {
        let (jacobian, direction) = (self.surface_jacobian(), direction.to_array());
        let surfaces = Surfaces {
            object: inner(&jacobian.object, &direction),
            posture: jacobian.posture.map(|row| inner(&row, &direction)),
        };
        // Estimates change with time only.
        Extra { surfaces, estimates: Estimates::default() }
    }
}

fn surface_outputs(variables: &mut Variables<NabfcController>, extra: Evaluation, rates: Evaluation) {
    variables
        .output("s", extra, |m| &mut m.outputs.extra.surfaces.object)
        .rate(rates, |m| &mut m.rates.extra.surfaces.object)
        .unit("m/s")
        .depends_on(["y_object", "y_object_dot", "tip_shear1", "tip_shear2", "lambda1_ref", "theta1_ref"])
        .description("Sliding variable of the object loop, eq. (33)");
    for i in 0..2 {
        let n = i + 1;
        let output = variables.output(format!("s{n}"), extra, move |m| &mut m.outputs.extra.surfaces.posture[i]);
        output
            .unit("rad/s")
            .display_degrees()
            .rate(rates, move |m| &mut m.rates.extra.surfaces.posture[i])
            .depends_on([format!("theta{n}"), format!("theta{n}_dot")])
            .depends_on(["theta1_ref", "lambda1_ref"].into_iter().take(n))
            .description(&format!("Sliding variable of posture loop {n}, eq. (51)"));
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
            .output(name, extra, move |m| field(&mut m.outputs.extra.estimates))
            .rate(rates, move |m| field(&mut m.rates.extra.estimates))
            .unit(unit)
            .nominal(nominal)
            .description(description);
    }
}

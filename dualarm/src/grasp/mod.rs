//! The parts of the grasp: the plant, its controllers by name with the paper's statements about them, and its actuators'
//! limits.
//!
//! * [`scenarios`] are compiled in and define runs of the parts;
//! * [`systems`] are SSP archives of the plant with each controller;
//! * [`instruments`] are sensors and actuators between plant and controller;
//! * [`GraspWatch`] observes a run, and [`grasp_merit`] evaluates it;
//! * [`presets`] are the controllers' built-in sets of gains;
//! * [`matrix`] runs many controllers in many cases.

pub mod instruments;
pub mod kind;
mod lyapunov;
pub mod matrix;
pub mod presets;
pub mod scenarios;
pub mod systems;
mod watch;

pub use lyapunov::{LyapunovWatch, NoFunctions, Recorded};
pub use watch::GraspWatch;

use fmi2_cosim::master::Applied;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::wiring::Wire;
use fmi2_import::{Fmu, Instance, Value};
use grasp_merit::metrics::Limits;

/// File name of the plant.
pub const PLANT: &str = "DualArmPlant.fmu";

/// A controller of the plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Controller {
    /// The name that a user types; also the name of the built-in scenario of the paper's case with this controller.
    pub key: &'static str,
    /// The title in figures and tables.
    pub title: &'static str,
    /// File name of the controller.
    pub fmu: &'static str,
    /// Names and values that make this controller of the FMU.
    settings: &'static [(&'static str, &'static str)],
    /// The paper's statement of the settling time of the contact force, or an empty text.
    pub paper: &'static str,
}

/// Neuro-adaptive boundary force control: the paper's law.
pub const NABFC: Controller = Controller {
    key: "nabfc",
    title: "NABFC",
    fmu: "NabfcController.fmu",
    settings: &[("law", "paper")],
    paper: "less than 0.5 s",
};
/// The same with the faster gains.
pub const NABFC_FAST: Controller = Controller {
    key: "nabfc-fast",
    title: "NABFC, fast preset",
    settings: &[("law", "paper"), ("preset", "fast")],
    paper: "",
    ..NABFC
};
/// NABFC with root strain in the posture surfaces: the default of `NabfcController.fmu`.
pub const NABFC_R: Controller =
    Controller { key: "nabfc-r", title: "NABFC-R", settings: &[("law", "root_strain")], paper: "", ..NABFC };
/// The same with the faster gains.
pub const NABFC_R_FAST: Controller = Controller {
    key: "nabfc-r-fast",
    title: "NABFC-R, fast preset",
    settings: &[("law", "root_strain"), ("preset", "fast")],
    paper: "",
    ..NABFC
};
/// The same with gains whose decay rate is proved.
pub const NABFC_R_CERTIFIED: Controller = Controller {
    key: "nabfc-r-certified",
    title: "NABFC-R, certified",
    settings: &[("law", "root_strain"), ("preset", "certified")],
    paper: "",
    ..NABFC
};
/// Proportional-derivative control with strain feedback.
pub const PDS: Controller =
    Controller { key: "pds", title: "PDS", fmu: "PdsController.fmu", settings: &[], paper: "almost 2 s" };
/// Proportional-derivative control.
pub const PD: Controller =
    Controller { key: "pd", title: "PD", fmu: "PdController.fmu", settings: &[], paper: "much longer" };

/// PDS with gains from a search.
pub const PDS_TUNED: Controller =
    Controller { key: "pds-tuned", title: "PDS, tuned", settings: &[("preset", "tuned")], paper: "", ..PDS };
/// PD with gains from a search.
pub const PD_TUNED: Controller =
    Controller { key: "pd-tuned", title: "PD, tuned", settings: &[("preset", "tuned")], paper: "", ..PD };
/// PD with integrals, gains from a search.
pub const PID: Controller = Controller { key: "pid", title: "PID", settings: &[("preset", "pid")], paper: "", ..PD };

/// All controllers a user can name.
pub const CONTROLLERS: &[Controller] =
    &[NABFC, NABFC_FAST, NABFC_R, NABFC_R_FAST, NABFC_R_CERTIFIED, PDS, PDS_TUNED, PD, PD_TUNED, PID];
/// The controllers the paper compares, in its order.
pub const PAPER: [Controller; 3] = [NABFC, PDS, PD];

impl Controller {
    /// The controller a user names.
    #[must_use]
    pub fn find(key: &str) -> Option<&'static Self> {
        CONTROLLERS.iter().find(|controller| controller.key == key)
    }

    /// Its settings.
    pub fn settings(&self) -> impl Iterator<Item = Setting> {
        self.settings.iter().map(|(name, value)| Setting::new(*name, *value))
    }
}

/// A remark on gains that `preset = fast` of `NabfcController` does not use.
pub fn unused_gains<'a>(settings: impl Iterator<Item = Applied<'a>>) -> Vec<String> {
    /// Parameters that are used with every preset: the arms and the references.
    const NO_GAINS: [&str; 15] = [
        "preset",
        "law",
        "rate_source",
        "EI1",
        "EI2",
        "l",
        "L",
        "lambda1_ref",
        "theta1_ref",
        "tau_limit",
        "u_limit",
        "observer_inertia1",
        "observer_inertia2",
        "observer_mass",
        "observer_bandwidth",
    ];
    let settings: Vec<_> = settings.filter(|setting| NABFC.fmu.strip_suffix(".fmu") == Some(setting.model)).collect();
    let is_fast = |component: &str| {
        let mut presets = settings.iter().rev().filter(|setting| setting.variable.name == "preset");
        let preset = presets.find(|setting| setting.component == component);
        preset.is_some_and(|preset| preset.variable.with_name(preset.value.clone()) == Value::from("fast"))
    };
    let unused = settings
        .iter()
        .filter(|setting| !NO_GAINS.contains(&setting.variable.name.as_str()) && is_fast(setting.component));
    let remark = |Applied { component, variable, .. }: &Applied| {
        let name = &variable.name;
        format!("{component}.{name} is not used: preset=fast has gains of its own (preset=parameters uses yours)")
    };
    unused.map(remark).collect()
}

/// The component whose output drives the first motor, directly or through actuators; `None` if there is no such component
/// or no motor.
#[must_use]
pub fn controller<'a>(components: &'a [(String, Fmu)], wires: &[Wire]) -> Option<&'a str> {
    let is_motor =
        |wire: &&Wire| components[wire.to.component].1.description().variables[wire.to.variable].name == "tau1_cmd";
    let is_controller = |wire: &&Wire| !instruments::ACTUATORS.is(&components[wire.from.component].1);
    wires.iter().filter(is_motor).find(is_controller).map(|wire| components[wire.from.component].0.as_str())
}

/// Output limits of the plant's two motors and of the actuator at the object, from its parameters: `k_l·(k_m − m_l)`
/// and `k_r·(k_M − m_r)`, eqs. (18) to (20). `None` for an FMU without these parameters or with ideal actuators.
#[must_use]
pub fn actuator_limits(plant: &mut Instance) -> [Option<Limits>; 3] {
    [limits_of(plant, 1), limits_of(plant, 1), limits_of(plant, 2)]
}

fn limits_of(plant: &mut Instance, channel: u8) -> Option<Limits> {
    let description = plant.description();
    let model = description.variable("actuator_model");
    let ideal = model.and_then(|model| {
        let ideal = model.items().iter().find(|item| item.name == "ideal")?;
        Some((model.value_reference, ideal.value))
    });
    let mut references = [0; 6];
    for (reference, name) in references.iter_mut().zip(["k_M", "k_m", "m_r", "m_l", "k_r", "k_l"]) {
        *reference = description.variable(&format!("{name}{channel}"))?.value_reference;
    }
    if let Some((reference, ideal)) = ideal {
        let mut model = [0];
        plant.get_integer(&[reference], &mut model).ok()?;
        if model[0] == ideal {
            return None;
        }
    }
    let mut values = [0.0; 6];
    plant.get_real(&references, &mut values).ok()?;
    let [k_max, k_min, m_r, m_l, k_r, k_l] = values;
    Some(Limits { low: k_l * (k_min - m_l), high: k_r * (k_max - m_r) })
}

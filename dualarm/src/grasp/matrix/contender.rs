//! The columns of the matrix: controllers with settings.

use std::path::{Path, PathBuf};

use super::case::CaseError;
use crate::grasp::kind::read_scenario;
use crate::grasp::scenarios::{BuiltIn, built_in};
use crate::grasp::{CONTROLLERS, Controller, NABFC, NABFC_R, NABFC_R_FAST, PD, PD_TUNED, PDS, PDS_TUNED, PID, PLANT};
use fmi2_cosim::files::has_extension;
use fmi2_cosim::names::{closest, suggestion_and};
use fmi2_cosim::scenario::Scenario;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::system::Located;

/// The columns, and the step in s of those that are unstable at the cases' 1 ms.
pub const CONTENDERS: [(Controller, Option<f64>); 8] = [
    (NABFC_R, None),
    (NABFC_R_FAST, None),
    (NABFC, None),
    (PID, None),
    (PD_TUNED, None),
    (PDS_TUNED, None),
    (PDS, Some(PAPER_STEP)),
    (PD, Some(PAPER_STEP)),
];

/// Presets from `dualarm tune`, found by a search over all cases at once, in the folder `scenarios/tuned`.
pub const PRESETS: &[BuiltIn] = built_in!["scenarios/tuned": "pid-all", "pds-all"];

/// A step at which PD and PDS are stable with the paper's gains (from 0.26 ms on PD is not), in s.
const PAPER_STEP: f64 = 2e-4;

/// What follows the controller's name in the titles of presets that a search writes.
pub const FOUND: &str = " with gains from a search";

/// A controller FMU with settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Contender {
    /// The name that a user types.
    pub key: String,
    /// The title in tables.
    pub title: String,
    /// File of the FMU, in the folder of the FMUs or at its own path.
    pub fmu: PathBuf,
    /// The settings that select this controller in the FMU.
    pub settings: Vec<Setting>,
    /// Communication step in s instead of the case's.
    pub step: Option<f64>,
}

/// Why there is no contender.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ContenderError {
    /// No controller has this name.
    #[error(
        "there is no controller \"{name}\"{}",
        suggestion_and(.similar, &format!("the controllers are {known}, or write a preset (.toml) or an FMU (.fmu)"))
    )]
    Unknown {
        /// The name as the user wrote it.
        name: String,
        /// Names that come close.
        similar: Vec<String>,
        /// All names.
        known: String,
    },
    /// The preset names no controller.
    #[error("{0} names no controller: fmus must be the plant and one controller")]
    NoController(String),
    /// The preset cannot be read.
    #[error(transparent)]
    Preset(#[from] CaseError),
}

impl From<(Controller, Option<f64>)> for Contender {
    fn from((controller, step): (Controller, Option<f64>)) -> Self {
        Self {
            key: controller.key.into(),
            title: short(&controller),
            fmu: controller.fmu.into(),
            settings: controller.settings().collect(),
            step,
        }
    }
}

/// A short title that fits above a column.
fn short(controller: &Controller) -> String {
    match controller.key {
        "nabfc" => "NABFC, paper's law".into(),
        "nabfc-r-fast" => "NABFC-R, fast".into(),
        "pd" | "pds" => format!("{}, paper", controller.title),
        _ => controller.title.into(),
    }
}

impl Contender {
    /// All built-in contenders.
    ///
    /// # Errors
    /// None in a released tool: a test reads all presets.
    pub fn all() -> Result<Vec<Self>, ContenderError> {
        let mut all: Vec<Self> = CONTENDERS.into_iter().map(Self::from).collect();
        let place = all.iter().position(|contender| contender.step.is_some()).unwrap_or(all.len());
        let presets = PRESETS.iter().map(Self::built_in).collect::<Result<Vec<_>, _>>()?;
        all.splice(place..place, presets);
        Ok(all)
    }

    fn built_in(file: &BuiltIn) -> Result<Self, ContenderError> {
        Self::preset(file.name, file.scenario().map_err(CaseError::from)?)
    }

    /// Its settings for the component of that name: they mean no variable of the same name elsewhere.
    pub(crate) fn settings_in(&self, component: &str) -> impl Iterator<Item = Located<Setting>> {
        self.settings.iter().map(move |setting| {
            let Setting { target, value } = setting;
            let target = if target.contains('.') { target.clone() } else { format!("{component}.{target}") };
            Located::nowhere(Setting::new(target, value.clone()))
        })
    }

    /// Adds the key to the title where several have the same one, as presets of one controller have.
    pub fn distinguish(contenders: &mut [Self]) {
        let titles: Vec<String> = contenders.iter().map(|contender| contender.title.clone()).collect();
        let is_named = |key: &str| Self::names().any(|name| name == key);
        for contender in contenders {
            let is_taken = titles.iter().filter(|title| **title == contender.title).count() > 1;
            if is_taken && !is_named(&contender.key) {
                let title = format!("{} ({})", contender.title.trim_end_matches(FOUND), contender.key);
                contender.title = if titles.contains(&title) { contender.key.clone() } else { title };
            }
        }
    }

    /// The controller of a scenario, with its parameters.
    fn preset(name: &str, scenario: Scenario) -> Result<Self, ContenderError> {
        let fmu = scenario.fmus.iter().find(|fmu| fmu.file_name().is_some_and(|file| file != PLANT));
        let fmu = fmu.ok_or_else(|| ContenderError::NoController(name.to_owned()))?.clone();
        let settings = scenario.settings.into_iter().map(|setting| setting.item).collect();
        Ok(Self { key: name.to_owned(), title: scenario.title, fmu, settings, step: scenario.experiment.step })
    }

    /// The names that are built in.
    pub fn names() -> impl Iterator<Item = &'static str> {
        CONTROLLERS.iter().map(|controller| controller.key).chain(PRESETS.iter().map(|file| file.name))
    }

    /// Whether a user means a file, a preset or an FMU, not a name.
    #[must_use]
    pub fn is_file(name: &str) -> bool {
        ["toml", "fmu"].iter().any(|extension| has_extension(Path::new(name), extension))
    }

    /// The contender a user names: a controller by name, a preset or scenario (`.toml`) with its controller and parameters,
    /// or a controller FMU as it is.
    ///
    /// # Errors
    /// When there is none.
    pub fn find(name: &str) -> Result<Self, ContenderError> {
        if let Some(contender) = CONTENDERS.into_iter().find(|(controller, _)| controller.key == name) {
            return Ok(contender.into());
        }
        if let Some(file) = PRESETS.iter().find(|file| file.name == name) {
            return Self::built_in(file);
        }
        if let Some(controller) = Controller::find(name) {
            return Ok((*controller, None).into());
        }
        let path = Path::new(name);
        let key = || path.file_stem().map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned());
        if has_extension(path, "fmu") {
            return Ok(Self { key: key(), title: key(), fmu: path.into(), settings: Vec::new(), step: None });
        }
        if has_extension(path, "toml") {
            return Self::preset(&key(), read_scenario(path).map_err(CaseError::from)?.0);
        }
        Err(ContenderError::Unknown {
            name: name.to_owned(),
            similar: closest(name, Self::names()).into_iter().map(str::to_owned).collect(),
            known: Self::names().collect::<Vec<_>>().join(", "),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contenders_are_found_by_name_file_and_fmu() {
        assert_eq!(Contender::find("pd").unwrap().step, Some(PAPER_STEP));
        assert!(Contender::all().unwrap().iter().any(|contender| contender.key == "pds-all"));
        assert_eq!(Contender::find("mine/law.fmu").unwrap().key, "law");
        let folder = tempfile::tempdir().unwrap();
        let preset = folder.path().join("mine.toml");
        let text = "title = \"x\"\nfmus = [\"DualArmPlant.fmu\", \"PdController.fmu\"]\n[parameters]\nkp = 12.0\n";
        std::fs::write(&preset, text).unwrap();
        let found = Contender::find(preset.to_str().unwrap()).unwrap();
        assert_eq!((found.key.as_str(), found.fmu.as_path()), ("mine", Path::new("PdController.fmu")));
        assert_eq!(found.settings, [Setting::new("kp", 12.0)]);
        let message = Contender::find("pidd").unwrap_err().to_string();
        assert!(message.contains("did you mean pid") && !message.contains("?;"), "{message}");
    }

    #[test]
    fn presets_with_one_title_are_told_apart_by_their_files() {
        let named = |key: &str, title: &str| Contender {
            key: key.into(),
            title: title.into(),
            ..Contender::find("pid").unwrap()
        };
        let found = "PID with gains from a search";
        let mut all =
            [named("a", found), named("b", found), named("pid", "PID"), named("mine", "PID"), named("c", "C")];
        Contender::distinguish(&mut all);
        assert_eq!(all.map(|contender| contender.title), ["PID (a)", "PID (b)", "PID", "PID (mine)", "C"]);
        let mut alone = [named("a", found)];
        Contender::distinguish(&mut alone);
        assert_eq!(alone[0].title, found);
    }
}

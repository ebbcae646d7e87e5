//! The scenarios that are compiled in, and the exchange of a scenario's controller.

use std::path::{Path, absolute};

use super::matrix::Contender;
use super::{CONTROLLERS, Controller};
use fmi2_cosim::names::{closest, suggestion_and};
use fmi2_cosim::scenario::{Scenario, ScenarioError};
use fmi2_cosim::settings::Setting;
use fmi2_cosim::system::Located;

/// A scenario file that is compiled in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltIn {
    /// The file's stem: the name that a user types.
    pub name: &'static str,
    /// The folder it comes from.
    pub folder: &'static str,
    /// The file.
    pub text: &'static str,
}

/// There is no built-in scenario of this name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no scenario \"{name}\"{}",
    suggestion_and(.similar, "`dualarm simulate --list` lists them, a file of your own ends in .toml")
)]
pub struct UnknownScenario {
    /// The name as the user wrote it.
    pub name: String,
    /// Names that come close.
    pub similar: Vec<String>,
}

/// The scenario has no controller that another one could replace.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("--controller: this scenario runs none of {}", .known.join(", "))]
pub struct NoController {
    /// The controllers that can be replaced.
    pub known: Vec<&'static str>,
}

impl NoController {
    fn new() -> Self {
        let mut known: Vec<_> = CONTROLLERS.iter().map(|known| known.fmu).collect();
        known.dedup();
        Self { known }
    }
}

/// Scenario files of a folder beside `scenarios`, compiled in.
macro_rules! built_in {
    ($folder:literal: $($name:literal),* $(,)?) => {
        &[$($crate::grasp::scenarios::BuiltIn {
            name: $name,
            folder: $folder,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../", $folder, "/", $name, ".toml")),
        }),*]
    };
}
pub(crate) use built_in;

/// The files of the folder `scenarios`, compiled into the tool; the paper's three come first.
pub const BUILT_IN: &[BuiltIn] = built_in![
    "scenarios":
    "nabfc",
    "pds",
    "pd",
    "nabfc-fast",
    "nabfc-r",
    "nabfc-r-fast",
    "nabfc-r-certified",
    "pds-tuned",
    "pd-tuned",
    "pid",
    "preload",
    "unknown-mass",
    "friction",
    "viscous-damping",
    "saturation",
    "raw-dead-zone",
    "disturbance-pulse",
    "loss-of-contact",
    "approach",
    "soft-fruit",
    "snatch",
    "drop",
    "small-preload",
    "change-of-reference",
    "stiff-arms",
    "wrong-stiffness",
    "noise",
    "encoders",
    "delay",
];

impl BuiltIn {
    /// The built-in scenario of that name.
    ///
    /// # Errors
    /// When there is none.
    pub fn find(name: &str) -> Result<Self, UnknownScenario> {
        let names = || BUILT_IN.iter().map(|built_in| built_in.name);
        BUILT_IN.iter().find(|built_in| built_in.name == name).copied().ok_or_else(|| UnknownScenario {
            name: name.to_owned(),
            similar: closest(name, names()).into_iter().map(str::to_owned).collect(),
        })
    }

    /// The scenario in the file.
    ///
    /// # Errors
    /// None in a released tool: a test reads all of them.
    pub fn scenario(&self) -> Result<Scenario, ScenarioError> {
        Scenario::parse(&format!("{}/{}.toml", self.folder, self.name), self.text)
    }
}

/// Whether a file is one of the project's controllers, which another one can replace.
pub(crate) fn is_controller(file: &Path) -> bool {
    CONTROLLERS.iter().any(|known| file.file_name().is_some_and(|name| name == known.fmu))
}

/// Whether a setting selects a controller's law or gains: it is removed together with a controller that is replaced.
pub(crate) fn says_which_law(setting: &Located<Setting>) -> bool {
    ["law", "preset"].contains(&setting.item.target.as_str())
}

/// The title of a scenario with another controller. It may name its own one, which does not run then.
fn with_instead(title: &str, controller: &str) -> String {
    let mut words = title.split(|letter: char| !letter.is_alphanumeric());
    if words.any(|word| CONTROLLERS.iter().any(|known| known.title == word)) {
        format!("{title}, with {controller} instead")
    } else {
        format!("{title} ({controller})")
    }
}

/// The scenario with its controller replaced by another one.
///
/// # Errors
/// When the scenario has no controller.
pub fn with_controller(mut scenario: Scenario, controller: &Controller) -> Result<Scenario, NoController> {
    let Some(replaced) = scenario.fmus.iter_mut().find(|file| is_controller(file)) else {
        return Err(NoController::new());
    };
    replaced.set_file_name(controller.fmu);
    scenario.title = with_instead(&scenario.title, controller.title);
    scenario.settings.retain(|setting| !says_which_law(setting));
    scenario.settings.splice(0..0, controller.settings().map(Located::nowhere));
    Ok(scenario)
}

/// The scenario with its controller replaced by a contender's, and the place of its component. The contender's settings belong
/// to this component.
///
/// # Errors
/// When the scenario has no controller.
pub fn with_contender(mut scenario: Scenario, contender: &Contender) -> Result<(Scenario, usize), NoController> {
    let place = scenario.fmus.iter().position(|file| is_controller(file)).ok_or_else(NoController::new)?;
    let replaced = &mut scenario.fmus[place];
    match absolute(&contender.fmu) {
        // The scenario's file may be in another folder.
        Ok(file) if file.is_file() => *replaced = file,
        _ => replaced.set_file_name(&contender.fmu),
    }
    scenario.title = with_instead(&scenario.title, &contender.title);
    scenario.settings.retain(|setting| !says_which_law(setting));
    Ok((scenario, place))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;
    use crate::grasp::{NABFC_FAST, PD, PLANT};

    #[test]
    fn every_file_of_the_folder_is_built_in_and_says_what_it_is() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios");
        let mut files: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
            .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
            .collect();
        let mut names: Vec<_> = BUILT_IN.iter().map(|built_in| built_in.name).collect();
        files.sort();
        names.sort_unstable();
        assert_eq!(files, names);
        for built_in in BUILT_IN {
            let scenario = built_in.scenario().unwrap();
            assert!(scenario.title.chars().count() <= 60, "{}: one line", built_in.name);
            assert!(scenario.description.len() > 80, "{}: says what it shows", built_in.name);
        }
    }

    #[test]
    fn a_title_names_the_controller_that_runs() {
        let titled = |title: &str| {
            let nabfc = BUILT_IN.iter().find(|built_in| built_in.name == "nabfc");
            let mut scenario = nabfc.unwrap().scenario().unwrap();
            scenario.title = title.to_owned();
            with_controller(scenario, &PD).unwrap().title
        };
        assert_eq!(titled("The paper's scenario I: NABFC"), "The paper's scenario I: NABFC, with PD instead");
        assert_eq!(titled("Weak actuators"), "Weak actuators (PD)");
    }

    #[test]
    fn every_controller_has_the_papers_case() {
        for controller in CONTROLLERS {
            let scenario = BuiltIn::find(controller.key).unwrap().scenario().unwrap();
            assert_eq!(scenario.fmus, [Path::new(PLANT), Path::new(controller.fmu)]);
            let settings: Vec<_> = scenario.settings.iter().map(|setting| setting.item.clone()).collect();
            assert_eq!(settings, controller.settings().collect::<Vec<_>>());
        }
    }

    #[test]
    fn unknown_names_are_answered_with_known_ones() {
        let message = BuiltIn::find("pre-load").unwrap_err().to_string();
        assert!(message.contains("no scenario \"pre-load\"; did you mean preload?"), "{message}");
    }

    #[test]
    fn another_controller_takes_the_place_of_the_first() {
        let scenario = BuiltIn::find("preload").unwrap().scenario().unwrap();
        let fast = with_controller(scenario.clone(), &NABFC_FAST).unwrap();
        assert_eq!(fast.fmus[1], Path::new("NabfcController.fmu"));
        assert_eq!(fast.settings[1].item, Setting::new("preset", "fast"));
        assert_eq!(fast.settings[2..], scenario.settings[..]);
        let mut alone = scenario;
        alone.fmus.truncate(1);
        let message = with_controller(alone, &PD).unwrap_err().to_string();
        assert_eq!(
            message,
            "--controller: this scenario runs none of NabfcController.fmu, PdsController.fmu, PdController.fmu"
        );
    }
}

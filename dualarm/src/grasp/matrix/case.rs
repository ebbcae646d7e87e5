//! The rows of the matrix: scenario files.

use std::path::Path;

use crate::grasp::kind::read_scenario;
use crate::grasp::scenarios::{BuiltIn, built_in};
use fmi2_cosim::files::has_extension;
use fmi2_cosim::names::{closest, suggestion_and};
use fmi2_cosim::scenario::{Scenario, ScenarioError};

/// The files of the folder `scenarios/matrix`, in the order of the rows.
pub const CASES: &[BuiltIn] = built_in![
    "scenarios/matrix":
    "undisturbed",
    "hub-torque",
    "object-force",
    "friction",
    "dead-zones",
    "light",
    "heavy-2",
    "heavy-5",
    "heavy-10",
    "heavy-hubs",
    "short",
    "long",
    "longest",
    "soft",
    "stiff",
    "delay-2",
    "delay-5",
    "little-damping",
    "encoders",
    "noise",
    "wrong-stiffness",
];

/// The files of the folder `scenarios/contact`: grasps that can open. They are rows of the matrix only on request.
pub const CONTACT: &[BuiltIn] =
    built_in!["scenarios/contact": "touching", "preloaded", "led", "gap", "bouncing", "soft-object", "jerk"];

/// A plant and its experiment.
#[derive(Debug, Clone)]
pub struct Case {
    /// The name that a user types: the file's stem.
    pub key: String,
    /// How to run it; its controller gives way to that of the cell.
    pub scenario: Scenario,
    /// The text of the file.
    pub text: String,
}

/// Why there is no case.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CaseError {
    /// No case has this name.
    #[error(
        "there is no case \"{name}\"{}",
        suggestion_and(.similar, &format!("the cases are {known}, a file of your own ends in .toml"))
    )]
    Unknown {
        /// The name as the user wrote it.
        name: String,
        /// Names that come close.
        similar: Vec<String>,
        /// All names.
        known: String,
    },
    /// The file is no scenario.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
}

impl Case {
    /// All built-in cases.
    ///
    /// # Errors
    /// None in a released tool: a test reads all of them.
    pub fn all() -> Result<Vec<Self>, CaseError> {
        CASES.iter().map(Self::built_in).collect()
    }

    /// All cases of grasps that can open.
    ///
    /// # Errors
    /// None in a released tool: a test reads all of them.
    pub fn contact() -> Result<Vec<Self>, CaseError> {
        CONTACT.iter().map(Self::built_in).collect()
    }

    /// Whether the tips can leave the object in this case.
    #[must_use]
    pub fn opens(&self) -> bool {
        self.scenario.settings.iter().any(|setting| setting.item.target.ends_with("contact_model"))
    }

    fn built_in(file: &BuiltIn) -> Result<Self, CaseError> {
        Ok(Self { key: file.name.to_owned(), scenario: file.scenario()?, text: file.text.to_owned() })
    }

    /// The case a user names: a built-in one, or a scenario file.
    ///
    /// # Errors
    /// When there is none, or the file is not a scenario.
    pub fn find(name: &str) -> Result<Self, CaseError> {
        if let Some(file) = CASES.iter().chain(CONTACT).find(|file| file.name == name) {
            return Self::built_in(file);
        }
        let path = Path::new(name);
        if has_extension(path, "toml") {
            let (scenario, text) = read_scenario(path)?;
            let key = path.file_stem().map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned());
            return Ok(Self { key, scenario, text });
        }
        let known = || CASES.iter().chain(CONTACT).map(|file| file.name);
        Err(CaseError::Unknown {
            name: name.to_owned(),
            similar: closest(name, known()).into_iter().map(str::to_owned).collect(),
            known: known().collect::<Vec<_>>().join(", "),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn every_file_of_the_folder_is_a_case() {
        for (folder, cases) in [("matrix", Case::all().unwrap()), ("contact", Case::contact().unwrap())] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios").join(folder);
            let mut files: Vec<_> = fs::read_dir(folder)
                .unwrap()
                .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
                .collect();
            files.sort();
            let mut cases: Vec<_> = cases.into_iter().map(|case| case.key).collect();
            cases.sort();
            assert_eq!(files, cases);
        }
        for case in Case::all().unwrap().into_iter().chain(Case::contact().unwrap()) {
            assert!(case.scenario.title.chars().count() <= 28, "{}: fits into its row", case.key);
            assert!(case.scenario.description.len() > 60, "{}: says what it is", case.key);
            assert!(case.scenario.experiment.stop.is_some() && case.scenario.experiment.step.is_some());
        }
    }

    #[test]
    fn unknown_cases_are_answered_with_known_ones() {
        let message = Case::find("frictoin").unwrap_err().to_string();
        assert!(message.contains("no case \"frictoin\"; did you mean friction?"), "{message}");
        assert!(message.contains("undisturbed, hub-torque"), "{message}");
    }
}

//! The kinds of files that end in `.toml`. All of them are TOML with a title, so one is easily given to the command that wants the
//! other.

use std::path::Path;

use fmi2_cosim::files::read_text;
use fmi2_cosim::scenario::{Scenario, ScenarioError};

/// A kind of file, found by the keys that only it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A scenario, also a case or a preset: FMUs that run together once.
    Scenario,
    /// A study: one system, many runs.
    Study,
}

impl Kind {
    /// The kind of a text; `None` if it is neither, or no TOML.
    #[must_use]
    pub fn of(text: &str) -> Option<Self> {
        let table: toml::Table = text.parse().ok()?;
        let has_any = |keys: &[&str]| keys.iter().any(|key| table.contains_key(*key));
        match (has_any(&["fmus", "inputs"]), has_any(&["system", "controllers", "method", "draws", "vary"])) {
            (true, false) => Some(Self::Scenario),
            (false, true) => Some(Self::Study),
            _ => None,
        }
    }

    /// What the file is, and which command takes it.
    #[must_use]
    pub fn remedy(self, file: &str) -> String {
        match self {
            Self::Scenario => format!(
                "this is a scenario: `dualarm simulate {file}` runs it. A study names the scenario that it runs: system = \"…\" \
                 (docs/studies.md)"
            ),
            Self::Study => format!("this is a study: `dualarm sweep {file}` makes its runs"),
        }
    }
}

/// Reads a scenario file, and returns its text, too.
///
/// # Errors
/// As [`Scenario::read_with_text`]; of a study the message says that it is one.
pub fn read_scenario(path: &Path) -> Result<(Scenario, String), ScenarioError> {
    Scenario::read_with_text(path).map_err(|error| match error {
        ScenarioError::Content { file, line, column, message } => {
            let is_study = read_text(path).is_ok_and(|text| Kind::of(&text) == Some(Kind::Study));
            let message = if is_study { Kind::Study.remedy(&file) } else { message };
            ScenarioError::Content { file, line, column, message }
        }
        other => other,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_apart_even_with_mistakes_in_them() {
        for (text, kind) in [
            ("title = 'x'\nfmus = ['a.fmu']", Some(Kind::Scenario)),
            ("title = 'x'\nfmu = ['a.fmu']\n[inputs]\nu = 1", Some(Kind::Scenario)),
            ("title = 'x'\nsystem = 'pd'\nmethod = 'grid'", Some(Kind::Study)),
            ("title = 'x'\n[vary]\nM = [1]", Some(Kind::Study)),
            ("title = 'x'\n[parameters]\nM = 1", None),
            ("fmus = ['a.fmu']\nsystem = 'pd'", None),
            ("no toml", None),
        ] {
            assert_eq!(Kind::of(text), kind, "{text}");
        }
    }
}

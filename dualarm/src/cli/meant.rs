//! What a user may have meant with a name or a file that a command does not find.

use std::path::{Path, PathBuf};

use crate::grasp::matrix::case::CONTACT;
use crate::grasp::matrix::{CASES, Contender};
use crate::grasp::scenarios::BUILT_IN;
use fmi2_cosim::files::has_extension;

/// What a name is that is no scenario; `None` if it is nothing known.
pub fn instead_of_scenario(name: &str) -> Option<String> {
    if Contender::names().any(|known| known == name) {
        return Some(format!("{name} is a controller: `dualarm simulate --controller {name}` runs it"));
    }
    let case = CASES.iter().chain(CONTACT).find(|case| case.name == name)?;
    let folder = case.folder.trim_start_matches("scenarios/");
    Some(format!(
        "{name} is a case of the comparison: `dualarm compare --cases {name}` runs all controllers in it, `dualarm scenario \
         {folder}/{name} > {name}.toml` makes a scenario of it"
    ))
}

/// A sentence about a file that is not there: a scenario that is built in, or an FMU in `folder`, the one of FMUs. `None` if there is
/// such a file, or nothing is known.
pub fn instead_of_file(file: &Path, folder: &Path) -> Option<String> {
    if file.exists() {
        return None;
    }
    let known = if has_extension(file, "toml") {
        let stem = file.file_stem()?.to_str()?;
        BUILT_IN.iter().find(|built_in| built_in.name == stem)?;
        format!("the scenario that is built in is called {stem}, without .toml")
    } else {
        let with_ending = |path: &Path| PathBuf::from(format!("{}.fmu", path.display()));
        let there = folder.join(file.file_name()?);
        let candidates = [with_ending(file), with_ending(&there), there];
        format!("did you mean {}?", candidates.iter().find(|candidate| candidate.is_file())?.display())
    };
    Some(format!("there is no file {}; {known}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_files_of_others_are_known() {
        assert!(instead_of_scenario("pid-all").unwrap().contains("--controller pid-all"));
        let case = instead_of_scenario("gap").unwrap();
        assert!(case.contains("--cases gap") && case.contains("dualarm scenario contact/gap > gap.toml"), "{case}");
        assert_eq!(instead_of_scenario("xyz"), None);
        let folder = tempfile::tempdir().unwrap();
        let fmu = folder.path().join("Lag.fmu");
        std::fs::write(&fmu, "").unwrap();
        for name in ["nowhere/Lag.fmu", "nowhere/Lag"] {
            let said = instead_of_file(Path::new(name), folder.path()).unwrap();
            assert_eq!(said, format!("there is no file {name}; did you mean {}?", fmu.display()));
        }
        assert_eq!(instead_of_file(&fmu, folder.path()), None);
        assert_eq!(instead_of_file(Path::new("nowhere/Gain.fmu"), folder.path()), None);
        let said = instead_of_file(Path::new("nowhere/friction.toml"), folder.path()).unwrap();
        assert!(said.ends_with("is called friction, without .toml"), "{said}");
    }
}

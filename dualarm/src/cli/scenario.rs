//! `dualarm scenario`

use clap::Args;

use super::{Failure, print, print_error};
use crate::build;
use crate::grasp::matrix::{case, contender};
use crate::grasp::scenarios::{BUILT_IN, BuiltIn, UnknownScenario};
use fmi2_cosim::names::closest;

const AFTER_HELP: &str = "\
The scenarios are files that are compiled in, so the tool has them wherever it runs. What is printed is the file; FMUs that it \
names are looked for beside a file of your own, then in the folder of --fmus.

Examples:
  dualarm scenario                          all names
  dualarm scenario friction                 the file
  dualarm scenario friction > mine.toml     one to start from,
  dualarm simulate mine.toml                which runs as it is
  dualarm scenario matrix/delay-5           a case of `compare --matrix`";

/// Arguments of `dualarm scenario`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Name of a scenario; matrix/NAME and tuned/NAME are cases and presets of the matrix
    #[arg(value_name = "SCENARIO")]
    name: Option<String>,
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    let Some(name) = &arguments.name else {
        all().for_each(|file| print(&format!("{}\n", full_name(file))));
        return Ok(());
    };
    let file = all().find(|file| full_name(file) == *name).ok_or_else(|| {
        let names: Vec<String> = all().map(full_name).collect();
        let similar = closest(name, names.iter().map(String::as_str)).into_iter().map(str::to_owned).collect();
        UnknownScenario { name: name.clone(), similar }
    })?;
    if !quiet {
        let place = format!("{}/{}.toml", file.folder, file.name);
        let here = build::repository().map(|root| root.join(&place)).filter(|path| path.is_file());
        let place = here.map_or_else(|| format!("{place} of the repository"), |path| path.display().to_string());
        print_error(&format!("{place}, as compiled into dualarm {}\n", env!("CARGO_PKG_VERSION")));
    }
    print(file.text);
    Ok(())
}

/// Every file that is compiled in.
fn all() -> impl Iterator<Item = &'static BuiltIn> {
    BUILT_IN.iter().chain(case::CASES).chain(case::CONTACT).chain(contender::PRESETS)
}

/// The name as a user types it, with its folder below `scenarios` if there is one.
fn full_name(file: &BuiltIn) -> String {
    let folder = file.folder.strip_prefix("scenarios/").map(|folder| format!("{folder}/")).unwrap_or_default();
    folder + file.name
}

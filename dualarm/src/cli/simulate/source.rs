//! The system to be simulated: converts the command line's arguments to a [`System`].

use std::path::{Path, PathBuf};

use crate::cli::Failure;
use crate::cli::meant::{instead_of_file, instead_of_scenario};
use crate::grasp::kind::read_scenario;
use crate::grasp::matrix::Contender;
use crate::grasp::scenarios::{self, BuiltIn, NoController, UnknownScenario};
use crate::grasp::{self, Controller};
use fmi2_cosim::files::has_extension;
use fmi2_cosim::scenario::ScenarioError;
use fmi2_cosim::ssp::Package;
use fmi2_cosim::ssp::package::{is_ssp, split_variant};
use fmi2_cosim::system::{System, SystemError};
use fmi2_import::Fmu;

/// Reads the description and unpacks the FMUs. `words` are the user's arguments without an option, `fmus` is the folder of
/// the packaged FMUs.
pub fn system(words: &[PathBuf], controller: Option<&str>, fmus: &Path) -> Result<System, Failure> {
    if let [word] = words
        && has_extension(word, "toml")
        && let Some(message) = instead_of_file(word, fmus)
    {
        return Err(Failure::failed(message));
    }
    if let Some(name) = controller
        && Controller::find(name).is_none()
    {
        return with_preset(words, name, fmus);
    }
    let controller = controller.and_then(Controller::find);
    let scenario = match (words, controller) {
        ([], None) => BuiltIn::find(grasp::NABFC.key)?.scenario()?,
        // The paper's case with this controller has its own stop time.
        ([], Some(controller)) => return Ok(BuiltIn::find(controller.key)?.scenario()?.system(fmus)?),
        ([word], _) if has_extension(word, "toml") => read_scenario(word)?.0,
        ([word], None) if is_ssp(word) => return Ok(Package::open(word)?.system()?),
        ([word], _) if is_name(word) => built_in(word, fmus)?.scenario()?,
        (files, None) => return of_fmus(files, fmus),
        (_, Some(_)) => return Err(no_scenario()),
    };
    let scenario = match controller {
        Some(controller) => scenarios::with_controller(scenario, controller)?,
        None => scenario,
    };
    Ok(scenario.system(fmus)?)
}

/// A scenario, by default the paper's case, with the controller of a preset, or with a controller FMU, as in `compare`: the
/// preset's settings reach the controller only, and the scenario's own are stronger.
fn with_preset(words: &[PathBuf], name: &str, fmus: &Path) -> Result<System, Failure> {
    let scenario = match words {
        // Title and description are about that scenario's own controller.
        [] => {
            let mut scenario = BuiltIn::find(grasp::NABFC.key)?.scenario()?;
            (scenario.title, scenario.description) = ("The paper's case".into(), String::new());
            scenario
        }
        [word] if has_extension(word, "toml") => read_scenario(word)?.0,
        [word] if is_name(word) => built_in(word, fmus)?.scenario()?,
        _ => return Err(no_scenario()),
    };
    let contender = Contender::find(name)?;
    let (scenario, place) = scenarios::with_contender(scenario, &contender)?;
    let mut system = scenario.system(fmus)?;
    let component = system.components[place].0.clone();
    system.settings.splice(0..0, contender.settings_in(&component));
    Ok(system)
}

/// The scenario that a word names.
fn built_in(word: &Path, fmus: &Path) -> Result<BuiltIn, Failure> {
    let unknown = |unknown: UnknownScenario| instead_of_file(word, fmus).map_or_else(|| unknown.into(), Failure::usage);
    BuiltIn::find(&word.to_string_lossy()).map_err(unknown)
}

fn no_scenario() -> Failure {
    Failure::usage("--controller cannot be used with .fmu and .ssp files, only with a scenario")
}

fn of_fmus(files: &[PathBuf], fmus: &Path) -> Result<System, Failure> {
    if let Some(name) = files.iter().find(|file| is_name(file)) {
        return Err(Failure::usage(match BuiltIn::find(&name.to_string_lossy()) {
            Ok(BuiltIn { name, .. }) => format!(
                "{name} is a scenario; one runs at a time, alone. To compare: `dualarm compare`, or write each with -o and overlay \
                 them with `dualarm report a.csv b.csv`. Another controller in a scenario: --controller"
            ),
            Err(unknown) => {
                let known = instead_of_scenario(&unknown.name).or_else(|| instead_of_file(name, fmus));
                known.unwrap_or_else(|| format!("{unknown}; FMUs end in .fmu"))
            }
        }));
    }
    if let Some(scenario) = files.iter().find(|file| has_extension(file, "toml")) {
        let message = format!("{} is a scenario; it runs alone, without other files", scenario.display());
        return Err(Failure::usage(message));
    }
    if let Some(package) = files.iter().find(|file| is_ssp(file)) {
        let message = format!("{} is a system of its own; it runs alone, without other files", package.display());
        return Err(Failure::usage(message));
    }
    if let Some(message) = files.iter().find_map(|file| instead_of_file(file, fmus)) {
        return Err(Failure::failed(message));
    }
    Ok(System::of_fmus(&Fmu::unpack_all(files)?))
}

/// The files that a run reads, which must stay as they are.
pub fn inputs(words: &[PathBuf], system: &System) -> Vec<PathBuf> {
    let fmus = system.components.iter().map(|(_, fmu)| fmu.path());
    let words = words.iter().map(|word| split_variant(word).0);
    words.chain(fmus.map(Path::to_owned)).collect()
}

/// A bare word that is no file can only be the name of a scenario.
fn is_name(word: &Path) -> bool {
    word.extension().is_none() && word.components().count() == 1 && !word.exists()
}

impl From<ScenarioError> for Failure {
    fn from(error: ScenarioError) -> Self {
        match error {
            ScenarioError::Content { .. } | ScenarioError::Table { .. } => Self::usage(error),
            ScenarioError::NoFmu { .. } => {
                Self::failed(format!("{error}; `dualarm package` makes the FMUs, --fmus says where they are"))
            }
            _ => Self::failed(error),
        }
    }
}

impl From<UnknownScenario> for Failure {
    fn from(error: UnknownScenario) -> Self {
        Self::usage(instead_of_scenario(&error.name).unwrap_or_else(|| error.to_string()))
    }
}

impl From<NoController> for Failure {
    fn from(error: NoController) -> Self {
        Self::usage(error)
    }
}

impl From<SystemError> for Failure {
    fn from(error: SystemError) -> Self {
        match error {
            SystemError::Setting { .. } => Self::usage(error),
            _ => Self::failed(error),
        }
    }
}

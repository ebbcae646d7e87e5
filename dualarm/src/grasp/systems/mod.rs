//! The project's own systems: the plant with each of its controllers, composed from the descriptions of the FMUs.
//!
//! Limits of other tools determine the default structure:
//!
//! * Ecos 0.7 and `libcosim` (of libcosimpy 0.0.6) stop at connections of the system's own connectors and at enumeration
//!   parameters. So references and disturbances are connectors of the system only in the variant [`DRIVEN`], and
//!   enumerations keep the start values of the FMUs.
//! * fmpy 0.3 sets every input that has a connector, and unconnected ones to zero. So inputs without a source have no
//!   connector, and the references keep their start values.
//! * `OMSimulator` 2 stops at `<SystemGeometry>` and requires identifiers as names. The drawing needs no canvas of its own:
//!   all connections are straight lines between the two boxes.

mod drawing;
mod error;
mod instrumented;
mod parameters;
mod structure;
mod units;

use std::io;
use std::path::{Path, PathBuf};

use crate::grasp::instruments::{ACTUATORS, INSTRUMENTS};
use crate::grasp::scenarios::{BuiltIn, with_controller};
use crate::grasp::{self, Controller};
use fmi2_cosim::files::{FileSet, WriteError};
use fmi2_cosim::ssp::package::{self, DEFAULT_STRUCTURE};
use fmi2_cosim::ssp::parameters::ParameterSet;
use fmi2_cosim::ssp::structure::{Binding, ComponentElement, Origin, SystemStructure, Values};
use fmi2_cosim::ssp::write;
use fmi2_import::{Fmu, ModelDescription};
use parameters::{paper_set, settings_set};
use structure::driven;

pub use error::ComposeError;

/// A grasp to package: the plant with one controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grasp {
    /// The controller.
    pub controller: Controller,
    /// The [built-in scenario](BuiltIn) of the default structure, which uses the start values of the FMUs. It is not the
    /// controller's own scenario if that one chooses another law.
    scenario: &'static str,
    /// Communication step size in s that is stable with one step of delay between the FMUs, as in most tools.
    step: f64,
    /// Variants with other parameters: name of the variant and of the [built-in scenario](BuiltIn) they come from.
    presets: &'static [(&'static str, &'static str)],
    /// The controller of the variant with sensors and actuators. They sample at 1 kHz, at which PD and PDS with the paper's
    /// gains are unstable; these two have other gains there.
    instrumented: Controller,
}

/// All grasps.
pub const GRASPS: [Grasp; 3] = [
    Grasp {
        controller: grasp::NABFC,
        scenario: "nabfc-r",
        step: 1e-4,
        presets: &[
            (PRELOAD, "preload"),
            ("Fast", "nabfc-r-fast"),
            ("Certified", "nabfc-r-certified"),
            ("Paper", "nabfc"),
        ],
        instrumented: grasp::NABFC_R,
    },
    Grasp {
        controller: grasp::PDS,
        scenario: "pds",
        step: 1e-4,
        presets: &[(PRELOAD, "preload"), ("Tuned", "pds-tuned")],
        instrumented: grasp::PDS_TUNED,
    },
    // With 0.1 ms and a delay, the hub gain excites the arms' higher bending modes.
    Grasp {
        controller: grasp::PD,
        scenario: "pd",
        step: 5e-5,
        presets: &[(PRELOAD, "preload"), ("Tuned", "pd-tuned"), ("Integral", "pid")],
        instrumented: grasp::PD_TUNED,
    },
];

/// The variant with references and disturbances as inputs of the system and contact forces as outputs.
pub const DRIVEN: &str = "Driven";
/// The variant that starts with a small contact force.
pub const PRELOAD: &str = "Preload";
/// The variant with sensors and actuators between plant and controller.
pub const INSTRUMENTED: &str = "Instruments";
/// Name of the parameter sets that the default structure binds to its components.
pub const PAPER: &str = "paper";

/// `OMSimulator` requires one; the FMUs do not use it.
const TOLERANCE: f64 = 1e-4;

/// Names of the two components.
const PLANT: &str = "plant";
const CONTROLLER: &str = "controller";
/// Both, in the order of their descriptions.
const COMPONENTS: [&str; 2] = [PLANT, CONTROLLER];

/// Outputs that are shown though no component needs them.
const SHOWN: [&str; 2] = ["contact_force1", "contact_force2"];

/// Distance of neighbouring connectors in the drawing.
const PITCH: f64 = 10.0;
/// Width of the boxes, and of the space between them and around them.
const WIDTH: f64 = 80.0;

/// A text file of a package: its path, and its content.
pub type TextFile = (String, String);

/// Composes all packages from the FMUs in a folder, and writes them there as `.ssp` files.
///
/// # Errors
/// When an FMU is missing or cannot be used, or a package cannot be written.
pub fn write_packages(folder: &Path) -> Result<Vec<PathBuf>, ComposeError> {
    let packages = FileSet::new();
    let mut written = Vec::new();
    for grasp in GRASPS {
        let mut fmus = Vec::new();
        let mut descriptions = Vec::new();
        for file in grasp.fmus() {
            let path = folder.join(file);
            descriptions.push(Fmu::read_description(&path)?);
            fmus.push((file.to_owned(), read_file(&path)?));
        }
        let texts = grasp.describe(&descriptions.iter().collect::<Vec<_>>())?;
        let path = folder.join(format!("{}.ssp", grasp.name()));
        let bytes = archive(&texts, &fmus).map_err(|source| WriteError { path: path.clone(), source })?;
        packages.write(&path, bytes)?;
        written.push(path);
    }
    packages.appear()?;
    Ok(written)
}

/// Composes the structures and parameter sets of all packages from the FMUs' descriptions in a folder, `NAME.xml`.
/// Returns their paths below that folder with their contents.
///
/// # Errors
/// When a description is missing or cannot be used.
pub fn describe_packages(folder: &Path) -> Result<Vec<TextFile>, ComposeError> {
    let description = |file: &str| {
        let path = folder.join(Path::new(file).with_extension("xml"));
        let bytes = read_file(&path)?;
        ModelDescription::from_bytes(&bytes).map_err(|source| ComposeError::Description { path, source })
    };
    let mut texts = Vec::new();
    for grasp in GRASPS {
        let descriptions = grasp.fmus().into_iter().map(description).collect::<Result<Vec<_>, _>>()?;
        let files = grasp.describe(&descriptions.iter().collect::<Vec<_>>())?;
        texts.extend(files.into_iter().map(|(path, text)| (format!("{}/{path}", grasp.name()), text)));
    }
    Ok(texts)
}

/// The package, from its text files and its FMUs (file name and content).
fn archive(texts: &[TextFile], fmus: &[(String, Vec<u8>)]) -> io::Result<Vec<u8>> {
    let fmus = fmus.iter().map(|(name, content)| (fmu_path(name), content.as_slice())).collect::<Vec<_>>();
    let texts = texts.iter().map(|(path, text)| (path.as_str(), text.as_bytes()));
    package::archive(texts.chain(fmus.iter().map(|(path, content)| (path.as_str(), *content))))
}

fn read_file(path: &Path) -> Result<Vec<u8>, ComposeError> {
    std::fs::read(path).map_err(|source| ComposeError::Read { path: path.to_owned(), source })
}

impl Grasp {
    /// Name of the package, without extension.
    #[must_use]
    pub fn name(&self) -> String {
        format!("DualArmGrasp-{}", self.controller.title)
    }

    /// Files of the FMUs that it needs: plant and controller, sensors and actuators.
    fn fmus(&self) -> Vec<&'static str> {
        vec![grasp::PLANT, self.controller.fmu, INSTRUMENTS.fmu, ACTUATORS.fmu]
    }

    /// The structures and parameter sets, from the descriptions of those FMUs.
    fn describe(&self, all: &[&ModelDescription]) -> Result<Vec<TextFile>, ComposeError> {
        let descriptions = &all[..COMPONENTS.len()];
        let closed = self.structure(descriptions)?;
        let mut files = Vec::new();
        let mut add_structure = |variant: &str, mut structure: SystemStructure, set: Option<ParameterSet>| {
            if let Some(set) = set {
                let path = format!("resources/{}.ssv", variant.to_lowercase());
                structure.system.bindings.push(file_binding(path.clone()));
                files.push((path, write::parameter_set(&set)));
            }
            files.push((format!("{variant}.ssd"), write::system_structure(&structure)));
        };
        let default = DEFAULT_STRUCTURE.trim_end_matches(".ssd");
        add_structure(default, closed.clone(), None);
        let (driven, start_values) = driven(closed.clone(), descriptions);
        add_structure(DRIVEN, driven, Some(start_values));

        for (variant, scenario) in self.presets {
            let scenario = BuiltIn::find(scenario)?.scenario()?;
            let mut structure = closed.clone();
            structure.name = format!("{}_{variant}", closed.name);
            structure.description = Some(scenario.title.clone());
            add_structure(variant, structure, Some(settings_set(variant, &scenario, &COMPONENTS, descriptions)?));
        }
        let mut components = closed.system.components.clone();
        let scenario = with_controller(BuiltIn::find(instrumented::SCENARIO)?.scenario()?, &self.instrumented)?;
        let structure = instrumented::structure(closed, &scenario, all);
        let is_between = |component: &&ComponentElement| !COMPONENTS.contains(&component.name.as_str());
        components.extend(structure.system.components.iter().filter(is_between).cloned());
        let set = settings_set(INSTRUMENTED, &scenario, &instrumented::COMPONENTS, all)?;
        add_structure(INSTRUMENTED, structure, Some(set));
        for (component, description) in components.iter().zip(all) {
            let set = paper_set(description, &component.connectors);
            files.push((paper_set_path(description), write::parameter_set(&set)));
        }
        files.sort();
        Ok(files)
    }
}

/// The author and the tool, as documents of this tool state them.
#[must_use]
pub fn origin() -> Origin {
    Origin {
        license: Some(env!("CARGO_PKG_LICENSE").into()),
        generation_tool: Some(concat!("dualarm ", env!("CARGO_PKG_VERSION")).into()),
    }
}

fn fmu_path(file_name: &str) -> String {
    format!("resources/{file_name}")
}

fn paper_set_path(description: &ModelDescription) -> String {
    format!("resources/{}.ssv", description.model_name)
}

fn file_binding(path: String) -> Binding {
    Binding { values: Values::File(path), ..Binding::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The default structure does not set a law but uses the start values of the FMUs, so its title must be that of a
    /// scenario that sets nothing else.
    #[test]
    fn the_title_is_of_what_runs() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
        for grasp in GRASPS {
            let read = |file: &str| std::fs::read(folder.join(file).with_extension("xml")).unwrap();
            let files = grasp.fmus();
            let all: Vec<_> = files.iter().map(|file| ModelDescription::from_bytes(&read(file)).unwrap()).collect();
            let scenario = BuiltIn::find(grasp.scenario).unwrap().scenario().unwrap();
            assert_eq!(scenario.fmus, files[..2].iter().map(PathBuf::from).collect::<Vec<_>>());
            let set = settings_set("", &scenario, &COMPONENTS, &[&all[0], &all[1]]).unwrap();
            for set in set.parameters {
                let variable = all[1].variable(set.name.strip_prefix("controller.").unwrap()).unwrap();
                assert_eq!(
                    Some(variable.with_name(set.value)),
                    variable.start().map(|start| variable.with_name(start))
                );
            }
        }
    }
}

//! The project's own systems: the plant with each of its controllers, composed from the descriptions of the FMUs.
//!
//! What other tools can read shapes the default structure:
//!
//! * Ecos 0.7 and `libcosim` (of libcosimpy 0.0.6) stop at connections of the system's own connectors and at enumeration parameters; so
//!   references and disturbances are connectors of the system in the variant [`DRIVEN`] only, and enumerations are left
//!   to the start values of the FMUs.
//! * fmpy 0.3 sets every input that has a connector, unconnected ones to zero, so inputs without a source have no
//!   connector: the references keep their start values.
//! * `OMSimulator` 2 stops at `<SystemGeometry>` and wants identifiers as names. The drawing needs no canvas of its own:
//!   all connections are straight lines between the two boxes.

mod drawing;
mod instrumented;
mod parameters;
mod units;

use std::io;
use std::path::{Path, PathBuf};

use crate::grasp::instruments::{ACTUATORS, INSTRUMENTS};
use crate::grasp::scenarios::{BuiltIn, UnknownScenario};
use crate::grasp::{self, Controller};
use drawing::draw;
use fmi2_cosim::files::{FileSet, WriteError};
use fmi2_cosim::scenario::ScenarioError;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::ssp::package::{self, DEFAULT_STRUCTURE};
use fmi2_cosim::ssp::parameters::ParameterSet;
use fmi2_cosim::ssp::structure::{
    Binding, Component, Connection, Connector, DefaultExperiment, End, Kind, Line, Origin, System, SystemStructure,
    Values,
};
use fmi2_cosim::ssp::write;
use fmi2_cosim::wiring::{WiringError, wire_by_name};
use fmi2_import::description::DescriptionError;
use fmi2_import::{Causality, Fmu, FmuError, ModelDescription, Variable};
use parameters::{paper_set, parameter, parameter_units, settings_set};
use units::{set_units, units_of};

/// A grasp to package: the plant with one controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grasp {
    /// The controller.
    pub controller: Controller,
    /// Communication step size in s that bears one step of delay between the FMUs, as most tools exchange signals.
    step: f64,
    /// Variants with other parameters: name of the variant and of the [built-in scenario](BuiltIn) they come from.
    presets: &'static [(&'static str, &'static str)],
    /// Whether there is a variant with sensors and actuators. They sample at 1 kHz, at which PD and PDS with the paper's gains
    /// are unstable.
    instrumented: bool,
}

/// All grasps.
pub const GRASPS: [Grasp; 3] = [
    Grasp {
        controller: grasp::NABFC,
        step: 1e-4,
        presets: &[(PRELOAD, "preload"), ("Fast", "nabfc-fast")],
        instrumented: true,
    },
    Grasp { controller: grasp::PDS, step: 1e-4, presets: &[(PRELOAD, "preload")], instrumented: false },
    // With 0.1 ms and a delay, the hub gain excites the arms' higher bending modes.
    Grasp { controller: grasp::PD, step: 5e-5, presets: &[(PRELOAD, "preload")], instrumented: false },
];

/// The variant with references and disturbances as inputs of the system and contact forces as outputs.
pub const DRIVEN: &str = "Driven";
/// The variant that starts with a small contact force.
pub const PRELOAD: &str = "Preload";
/// The variant with sensors and actuators between plant and controller.
pub const INSTRUMENTED: &str = "Instruments";
/// Name of the parameter sets that the default structure binds to its components.
pub const PAPER: &str = "paper";

/// Why a system cannot be composed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ComposeError {
    /// Equal names do not say what to connect.
    #[error(transparent)]
    Wiring(#[from] WiringError),
    /// A built-in scenario is not there.
    #[error(transparent)]
    Unknown(#[from] UnknownScenario),
    /// A built-in scenario cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A scenario sets what neither FMU has, or to what its type does not allow.
    #[error("the scenario \"{scenario}\" sets {setting}, which fits no variable of the FMUs")]
    Setting {
        /// Title of the scenario.
        scenario: String,
        /// The setting.
        setting: Setting,
    },
    /// An FMU cannot be used.
    #[error(transparent)]
    Fmu(#[from] FmuError),
    /// A file cannot be read.
    #[error("cannot read {}: {source}; `dualarm package` and `cargo xtask describe` make it", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A description cannot be used.
    #[error("cannot use {}: {source}", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: DescriptionError,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// `OMSimulator` wants one; the FMUs have no use for it.
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
/// When an FMU is not there or cannot be used, or a package cannot be written.
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
/// When a description is not there or cannot be used.
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
        let between = [INSTRUMENTS.fmu, ACTUATORS.fmu].into_iter().filter(|_| self.instrumented);
        [grasp::PLANT, self.controller.fmu].into_iter().chain(between).collect()
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
        if self.instrumented {
            let scenario = BuiltIn::find(instrumented::SCENARIO)?.scenario()?;
            let structure = instrumented::structure(closed, &scenario, all);
            let is_between = |component: &&Component| !COMPONENTS.contains(&component.name.as_str());
            components.extend(structure.system.components.iter().filter(is_between).cloned());
            let set = settings_set(INSTRUMENTED, &scenario, &instrumented::COMPONENTS, all)?;
            add_structure(INSTRUMENTED, structure, Some(set));
        }
        for (component, description) in components.iter().zip(all) {
            let set = paper_set(description, &component.connectors);
            files.push((paper_set_path(description), write::parameter_set(&set)));
        }
        files.sort();
        Ok(files)
    }

    /// The default structure: two components, connected by equal names.
    fn structure(&self, descriptions: &[&ModelDescription]) -> Result<SystemStructure, ComposeError> {
        let scenario = BuiltIn::find(self.controller.key)?.scenario()?;
        let names = COMPONENTS;
        let named: Vec<_> = names.into_iter().zip(descriptions.iter().copied()).collect();
        let connections: Vec<Connection> = wire_by_name(&named)?
            .wires
            .iter()
            .map(|wire| {
                let end = |terminal: fmi2_cosim::wiring::Terminal| {
                    let variable = &descriptions[terminal.component].variables[terminal.variable];
                    End::of(names[terminal.component], &variable.name)
                };
                Connection {
                    start: end(wire.from),
                    end: end(wire.to),
                    suppress_unit_conversion: false,
                    line: Line::default(),
                }
            })
            .collect();
        let components: Vec<_> = names
            .iter()
            .zip(descriptions)
            .map(|(name, description)| {
                let is_connected = |variable: &&Variable| {
                    let end = End::of(name, &variable.name);
                    connections.iter().any(|connection| connection.start == end || connection.end == end)
                };
                let variables = description
                    .variables
                    .iter()
                    .filter(|variable| is_connected(variable) || SHOWN.contains(&variable.name.as_str()));
                Component {
                    name: (*name).to_owned(),
                    description: description.description.clone(),
                    source: fmu_path(&format!("{}.fmu", description.model_name)),
                    connectors: variables.filter_map(connector).collect(),
                    extent: None,
                    bindings: vec![file_binding(paper_set_path(description))],
                    line: Line::default(),
                }
            })
            .collect();
        let mut structure = SystemStructure {
            name: self.name().replace('-', "_"),
            description: Some(scenario.title),
            system: System {
                name: "DualArmGrasp".into(),
                description: Some("The arms with the object between them, and the controller".into()),
                components,
                connections,
                ..System::default()
            },
            experiment: DefaultExperiment {
                start: Some(0.0),
                stop: scenario.experiment.stop,
                step: Some(self.step),
                tolerance: Some(TOLERANCE),
            },
            origin: origin(),
            ..SystemStructure::default()
        };
        draw(&mut structure.system);
        set_units(&mut structure, descriptions);
        Ok(structure)
    }
}

/// What the documents of this tool say about who wrote them.
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

/// The connector of an input or output.
fn connector(variable: &Variable) -> Option<Connector> {
    let kind = match variable.causality {
        Causality::Input => Kind::Input,
        Causality::Output => Kind::Output,
        _ => return None,
    };
    Some(Connector {
        name: variable.name.clone(),
        kind,
        base_type: Some(variable.base_type()),
        unit: variable.unit().map(str::to_owned),
        description: variable.description.clone(),
        position: None,
        line: Line::default(),
    })
}

/// The variant in which all inputs that the components leave open are inputs of the system, and the shown outputs its
/// outputs; with the start values of those inputs.
fn driven(closed: SystemStructure, descriptions: &[&ModelDescription]) -> (SystemStructure, ParameterSet) {
    let mut structure = closed;
    structure.name = format!("{}_{DRIVEN}", structure.name);
    structure.description =
        Some("References and disturbances are inputs of the system, the contact forces its outputs".into());
    let system = &mut structure.system;
    let mut start_values = ParameterSet {
        name: DRIVEN.to_lowercase(),
        description: Some("Start values of the system's inputs: those of the FMUs".into()),
        origin: origin(),
        ..ParameterSet::default()
    };
    for (component, description) in system.components.iter_mut().zip(descriptions) {
        let is_free = |variable: &&Variable| {
            variable.causality == Causality::Input
                && !component.connectors.iter().any(|connector| connector.name == variable.name)
        };
        let free: Vec<&Variable> = description.variables.iter().filter(is_free).collect();
        component.connectors.extend(free.iter().copied().filter_map(connector));
        start_values.parameters.extend(free.iter().copied().filter_map(parameter));
        let outer = component.connectors.iter().filter(|connector| {
            free.iter().any(|variable| variable.name == connector.name) || SHOWN.contains(&connector.name.as_str())
        });
        for connector in outer {
            let (inside, outside) = (End::of(&component.name, &connector.name), End::system(&connector.name));
            let (start, end) = if connector.kind == Kind::Input { (outside, inside) } else { (inside, outside) };
            let line = Line::default();
            system.connections.push(Connection { start, end, suppress_unit_conversion: false, line });
            system.connectors.push(connector.clone());
        }
    }
    start_values.units = units_of(descriptions, &parameter_units(&start_values));
    draw(system);
    set_units(&mut structure, descriptions);
    (structure, start_values)
}

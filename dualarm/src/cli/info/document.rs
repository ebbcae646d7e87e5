//! The description of an FMU for users. Serialised, it is the document of `--json`; `docs/tool.md` describes the keys.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::Value;

use fmi2_import::description::{CoSimulation, Item};
use fmi2_import::{Contents, Fmu, FmuError, Initial, ModelDescription, Variable as Described, VariableType};

#[derive(Serialize)]
#[allow(clippy::struct_excessive_bools)] // what JSON shows
pub struct Document {
    command: &'static str,
    version: &'static str,
    pub file: PathBuf,
    /// Size of the file.
    pub bytes: u64,
    pub fmi_version: String,
    pub model_name: String,
    pub model_version: Option<String>,
    pub description: Option<String>,
    pub author: Option<String>,
    pub copyright: Option<String>,
    pub license: Option<String>,
    pub generation_tool: Option<String>,
    pub generation_date: Option<String>,
    pub guid: String,
    pub interfaces: Vec<&'static str>,
    /// Folders below `binaries`.
    pub platforms: Vec<String>,
    pub has_sources: bool,
    pub has_documentation: bool,
    pub runs_here: bool,
    /// Whether that was tried, and not only read off the file.
    pub was_loaded: bool,
    /// Why it does not.
    pub obstacle: Option<String>,
    pub capabilities: Option<Capabilities>,
    /// Of the model exchange interface.
    pub continuous_states: usize,
    pub event_indicators: u32,
    pub default_experiment: DefaultExperiment,
    /// Declared enumerations.
    pub types: Vec<Enumeration>,
    pub variables: Vec<Variable>,
}

/// An enumeration and the names of its items.
#[derive(Serialize)]
pub struct Enumeration {
    pub name: String,
    pub items: Vec<String>,
}

/// Of the co-simulation interface, under the standard's names.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
#[allow(clippy::struct_excessive_bools)] // the standard's flags
pub struct Capabilities {
    pub needs_execution_tool: bool,
    pub can_handle_variable_communication_step_size: bool,
    pub can_interpolate_inputs: bool,
    pub max_output_derivative_order: u32,
    pub can_run_asynchronously: bool,
    pub can_be_instantiated_only_once_per_process: bool,
    #[serde(rename = "canGetAndSetFMUstate")]
    pub can_get_and_set_fmu_state: bool,
    #[serde(rename = "canSerializeFMUstate")]
    pub can_serialize_fmu_state: bool,
    pub provides_directional_derivative: bool,
}

/// In s, but for the tolerance.
#[derive(Serialize)]
pub struct DefaultExperiment {
    pub start: Option<f64>,
    pub stop: Option<f64>,
    pub step: Option<f64>,
    pub tolerance: Option<f64>,
}

#[derive(Serialize)]
pub struct Variable {
    pub name: String,
    #[serde(rename = "type")]
    pub kind: &'static str,
    pub causality: &'static str,
    pub variability: &'static str,
    pub initial: Option<&'static str>,
    pub unit: Option<String>,
    pub display_unit: Option<String>,
    pub start: Option<Value>,
    pub min: Option<Value>,
    pub max: Option<Value>,
    /// Name of the declared type of an enumeration.
    pub declared_type: Option<String>,
    /// Of an enumeration, if they are not too many; all are in the document's `types`.
    pub items: Vec<String>,
    pub description: Option<String>,
}

impl Document {
    /// Everything about an FMU; `load` also loads its library, if there is one for this platform.
    pub fn of(file: &Path, load: bool) -> Result<Self, FmuError> {
        let contents = Fmu::inspect(file)?;
        let platforms = contents.platforms().into_iter().map(str::to_owned).collect();
        let (has_sources, has_documentation) = (contents.has("sources/"), contents.has("documentation/"));
        let obstacle = obstacle(file, &contents, load);
        let model = contents.description;
        let variables = model.variables.iter().map(|variable| Variable::of(variable, &model)).collect();
        let interfaces = [
            model.co_simulation.is_some().then_some("co-simulation"),
            model.model_exchange.is_some().then_some("model exchange"),
        ];
        Ok(Self {
            command: "info",
            version: env!("CARGO_PKG_VERSION"),
            file: file.to_owned(),
            bytes: fs::metadata(file).map_or(0, |metadata| metadata.len()),
            interfaces: interfaces.into_iter().flatten().collect(),
            platforms,
            has_sources,
            has_documentation,
            runs_here: obstacle.is_none(),
            was_loaded: load,
            obstacle,
            capabilities: model.co_simulation.as_ref().map(Capabilities::of),
            continuous_states: model.structure.derivatives.len(),
            event_indicators: model.number_of_event_indicators,
            default_experiment: DefaultExperiment {
                start: model.default_experiment.start_time,
                stop: model.default_experiment.stop_time,
                step: model.default_experiment.step_size,
                tolerance: model.default_experiment.tolerance,
            },
            types: model
                .types
                .iter()
                .filter(|kind| !kind.items.is_empty())
                .map(|kind| Enumeration { name: kind.name.clone(), items: item_names(&kind.items) })
                .collect(),
            variables,
            fmi_version: model.fmi_version,
            model_name: model.model_name,
            model_version: model.version,
            description: model.description,
            author: model.author,
            copyright: model.copyright,
            license: model.license,
            generation_tool: model.generation_tool,
            generation_date: model.generation_date_and_time,
            guid: model.guid,
        })
    }

    /// The variables of one causality.
    pub fn with_causality(&self, causality: &str) -> impl Iterator<Item = &Variable> {
        self.variables.iter().filter(move |variable| variable.causality == causality)
    }
}

/// Why `dualarm simulate` could not run it here, judged by the files, or by loading the library, which runs code of the
/// FMU.
fn obstacle(file: &Path, contents: &Contents, load: bool) -> Option<String> {
    if contents.description.co_simulation.is_none() {
        return Some("it has only the model exchange interface; this tool runs co-simulation FMUs".into());
    }
    let look = || {
        Fmu::check_library(file)?;
        if load { Fmu::open(file).map(drop) } else { Ok(()) }
    };
    match look() {
        Ok(()) => None,
        Err(FmuError::NoBinary { wanted, .. }) => Some(format!("it has no {wanted}")),
        Err(FmuError::Library { library, source, .. }) => Some(format!("{library}: {source}")),
        Err(other) => Some(other.to_string()),
    }
}

impl Capabilities {
    fn of(interface: &CoSimulation) -> Self {
        Self {
            needs_execution_tool: interface.needs_execution_tool,
            can_handle_variable_communication_step_size: interface.can_handle_variable_communication_step_size,
            can_interpolate_inputs: interface.can_interpolate_inputs,
            max_output_derivative_order: interface.max_output_derivative_order,
            can_run_asynchronously: interface.can_run_asynchronously,
            can_be_instantiated_only_once_per_process: interface.can_be_instantiated_only_once_per_process,
            can_get_and_set_fmu_state: interface.can_get_and_set_fmu_state,
            can_serialize_fmu_state: interface.can_serialize_fmu_state,
            provides_directional_derivative: interface.provides_directional_derivative,
        }
    }
}

impl Variable {
    fn of(variable: &Described, model: &ModelDescription) -> Self {
        let (min, max) = match &variable.kind {
            VariableType::Real(real) => (real.min.map(Value::from), real.max.map(Value::from)),
            VariableType::Integer { min, max, .. } => (min.map(Value::from), max.map(Value::from)),
            _ => (None, None),
        };
        let display_unit = match &variable.kind {
            VariableType::Real(real) => real.display_unit.clone(),
            _ => None,
        };
        Self {
            name: variable.name.clone(),
            kind: variable.base_type().name(),
            causality: variable.causality.name(),
            variability: variable.variability.name(),
            initial: variable.initial.map(Initial::name),
            unit: variable.unit().map(str::to_owned),
            display_unit,
            start: variable.start().map(|start| json(variable.with_name(start))),
            min,
            max,
            declared_type: match variable.kind {
                VariableType::Enumeration { declared_type: Some(index), .. } => Some(model.types[index].name.clone()),
                _ => None,
            },
            items: if variable.items().len() > MAX_ITEMS { Vec::new() } else { item_names(variable.items()) },
            description: variable.description.clone(),
        }
    }
}

/// Items that are repeated for every variable of an enumeration.
const MAX_ITEMS: usize = 100;

fn item_names(items: &[Item]) -> Vec<String> {
    items.iter().map(|item| item.name.clone()).collect()
}

fn json(value: fmi2_import::Value) -> Value {
    match value {
        fmi2_import::Value::Real(number) => number.into(),
        fmi2_import::Value::Integer(number) => number.into(),
        fmi2_import::Value::Boolean(truth) => truth.into(),
        fmi2_import::Value::Text(text) => text.into(),
    }
}

//! `modelDescription.xml`: the description of an FMU (FMI 2.0.x, section 2.2).

mod by_name;
mod error;
mod parse;
mod variable;

use std::sync::Arc;

use by_name::ByName;
pub use error::DescriptionError;
pub use variable::{BaseType, Causality, Initial, Item, RealAttributes, Variability, Variable, VariableType};

/// The description of an FMU. Parts for model exchange only are kept if they may interest a user.
#[derive(Debug, Clone, Default)]
pub struct ModelDescription {
    /// `fmiVersion`, always `2.0`.
    pub fmi_version: String,
    /// The author's name for the model.
    pub model_name: String,
    /// Identifies the description; the library checks it at instantiation.
    pub guid: String,
    /// One sentence about the model.
    pub description: Option<String>,
    /// The author of the model.
    pub author: Option<String>,
    /// The model's own version.
    pub version: Option<String>,
    /// Copyright notice.
    pub copyright: Option<String>,
    /// Licence of the model.
    pub license: Option<String>,
    /// The tool that wrote the FMU.
    pub generation_tool: Option<String>,
    /// The date and time of its generation, as written.
    pub generation_date_and_time: Option<String>,
    /// How dots and brackets in variable names are to be read.
    pub naming: Naming,
    /// Number of event indicators (model exchange).
    pub number_of_event_indicators: u32,
    /// The co-simulation interface, if the FMU has one.
    pub co_simulation: Option<CoSimulation>,
    /// The library's name for model exchange, if the FMU has that interface.
    pub model_exchange: Option<String>,
    /// Declared units, in the order of the file.
    pub units: Vec<Unit>,
    /// Declared types, in the order of the file.
    pub types: Vec<TypeDefinition>,
    /// Categories the FMU logs in: name and description.
    pub log_categories: Vec<(String, Option<String>)>,
    /// Settings the author suggests.
    pub default_experiment: DefaultExperiment,
    /// All variables, in the order of the file; [`Unknown::index`] counts in this order.
    pub variables: Vec<Variable>,
    /// The outputs, derivatives and initial unknowns, and their dependencies.
    pub structure: ModelStructure,
    by_name: ByName,
}

/// The attributes of `<BaseUnit>`, in the order of [`Unit::exponents`].
pub const BASE_UNITS: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// How variable names are to be read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Naming {
    /// Names are plain strings.
    #[default]
    Flat,
    /// Dots and brackets form a hierarchy.
    Structured,
}

/// Capabilities of the co-simulation interface. A missing attribute means "no", as in the standard.
#[derive(Debug, Clone, Default)]
#[allow(clippy::struct_excessive_bools)] // the standard's flags, under the standard's names
pub struct CoSimulation {
    /// File name of the library, without extension.
    pub model_identifier: String,
    /// The FMU only talks to a tool that must be installed.
    pub needs_execution_tool: bool,
    /// Steps of different length may be mixed.
    pub can_handle_variable_communication_step_size: bool,
    /// The slave extrapolates inputs from given derivatives.
    pub can_interpolate_inputs: bool,
    /// Highest order of output derivatives.
    pub max_output_derivative_order: u32,
    /// `fmi2DoStep` may return `fmi2Pending`.
    pub can_run_asynchronously: bool,
    /// A second instance in the same process is refused.
    pub can_be_instantiated_only_once_per_process: bool,
    /// The slave manages its memory itself.
    pub can_not_use_memory_management_functions: bool,
    /// The state can be saved and restored.
    pub can_get_and_set_fmu_state: bool,
    /// A saved state can be serialised and deserialised.
    pub can_serialize_fmu_state: bool,
    /// Directional derivatives are offered.
    pub provides_directional_derivative: bool,
}

/// Settings for a simulation the author suggests.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DefaultExperiment {
    /// Start time in s.
    pub start_time: Option<f64>,
    /// Stop time in s.
    pub stop_time: Option<f64>,
    /// Relative tolerance.
    pub tolerance: Option<f64>,
    /// Communication step size in s.
    pub step_size: Option<f64>,
}

/// A unit, its SI base units and the units it may be displayed in.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Unit {
    /// Name that variables refer to.
    pub name: String,
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    pub exponents: [i32; 8],
    /// Value in base units = factor · value + offset.
    pub factor: f64,
    /// See [`Unit::factor`].
    pub offset: f64,
    /// Whether the file gives base units at all.
    pub has_base_unit: bool,
    /// Display units: displayed value = factor · value + offset.
    pub display_units: Vec<DisplayUnit>,
}

/// A unit for display: displayed value = factor · value + offset.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DisplayUnit {
    /// Name that variables refer to.
    pub name: String,
    /// See the type.
    pub factor: f64,
    /// See the type.
    pub offset: f64,
}

/// A declared type that variables share.
#[derive(Debug, Clone)]
pub struct TypeDefinition {
    /// Name that variables refer to.
    pub name: String,
    /// One sentence about the type.
    pub description: Option<String>,
    /// Base type and its defaults.
    pub kind: VariableType,
    /// For enumerations: the items.
    pub items: Arc<[Item]>,
}

/// Which variables are outputs, derivatives and initial unknowns.
#[derive(Debug, Clone, Default)]
pub struct ModelStructure {
    /// All outputs.
    pub outputs: Vec<Unknown>,
    /// All state derivatives.
    pub derivatives: Vec<Unknown>,
    /// The variables that the model computes during initialisation.
    pub initial_unknowns: Vec<Unknown>,
}

/// A variable that the model computes, with its dependencies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// Index (from 0) into [`ModelDescription::variables`].
    pub index: usize,
    /// Indices of the inputs (and states) it depends on directly; `None` means "on all of them". Unknowns that stand side by side share
    /// equal ones.
    pub dependencies: Option<Arc<[usize]>>,
}

impl ModelDescription {
    /// The variable of that name.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.index_of(name).map(|index| &self.variables[index])
    }

    /// The index (from 0) of the variable of that name.
    #[must_use]
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.by_name.index_of(name, &self.variables)
    }

    /// All variables of one causality, in the order of the file.
    pub fn with_causality(&self, causality: Causality) -> impl Iterator<Item = &Variable> {
        self.variables.iter().filter(move |variable| variable.causality == causality)
    }
}

//! `modelDescription.xml`: what an FMU says about itself (FMI 2.0.x, section 2.2).

use std::collections::HashMap;

use roxmltree::{Document, Node};

/// What an FMU says about itself. Model-exchange-only parts are kept where a user may want to read them.
#[derive(Debug, Clone, Default)]
pub struct ModelDescription {
    /// `fmiVersion`, always `2.0`.
    pub fmi_version: String,
    /// Name of the model as the author knows it.
    pub model_name: String,
    /// Identifies the description; the library checks it at instantiation.
    pub guid: String,
    /// One sentence about the model.
    pub description: Option<String>,
    /// Who wrote the model.
    pub author: Option<String>,
    /// The model's own version.
    pub version: Option<String>,
    /// Copyright notice.
    pub copyright: Option<String>,
    /// Licence of the model.
    pub license: Option<String>,
    /// The tool that wrote the FMU.
    pub generation_tool: Option<String>,
    /// When it did, as written.
    pub generation_date_and_time: Option<String>,
    /// How dots and brackets in variable names are meant.
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
    /// Which variables are outputs, derivatives and initial unknowns, and what they depend on.
    pub structure: ModelStructure,
    by_name: HashMap<String, usize>,
}

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
    /// Saved state can become bytes and return.
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
    pub items: Vec<Item>,
}

/// One item of an enumeration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// Name of the item.
    pub name: String,
    /// Value that crosses the C interface.
    pub value: i32,
    /// One sentence about the item.
    pub description: Option<String>,
}

/// One variable.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// Handle for the C interface; several variables of one base type may share it.
    pub value_reference: u32,
    /// One sentence about the variable.
    pub description: Option<String>,
    /// Its role.
    pub causality: Causality,
    /// When its value may change.
    pub variability: Variability,
    /// How its initial value comes about; `None` where the standard defines none (inputs, independent).
    pub initial: Option<Initial>,
    /// Base type with start value, unit and range.
    pub kind: VariableType,
}

/// A variable's role.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set by the user before (or, if tunable, during) the simulation.
    Parameter,
    /// Follows from other parameters.
    CalculatedParameter,
    /// Set by another model or the user during the simulation.
    Input,
    /// Offered to other models.
    Output,
    /// Internal.
    Local,
    /// The independent variable, time.
    Independent,
}

/// When a variable's value may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Never.
    Constant,
    /// Not after initialisation.
    Fixed,
    /// Between steps, by the user.
    Tunable,
    /// At events.
    Discrete,
    /// Always.
    Continuous,
}

/// How an initial value comes about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// The start value holds.
    Exact,
    /// The start value is a guess.
    Approx,
    /// The model computes it.
    Calculated,
}

/// A variable's base type with its attributes.
#[derive(Debug, Clone, PartialEq)]
pub enum VariableType {
    /// A real number.
    Real(RealAttributes),
    /// A 32-bit integer.
    Integer {
        /// Start value.
        start: Option<i32>,
        /// Smallest value.
        min: Option<i32>,
        /// Largest value.
        max: Option<i32>,
    },
    /// True or false.
    Boolean {
        /// Start value.
        start: Option<bool>,
    },
    /// Text.
    String {
        /// Start value.
        start: Option<String>,
    },
    /// One of the items of a declared type.
    Enumeration {
        /// Index into [`ModelDescription::types`].
        declared_type: Option<usize>,
        /// Start value.
        start: Option<i32>,
    },
}

/// Attributes of a real variable; those it inherits from its declared type are filled in.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RealAttributes {
    /// Start value.
    pub start: Option<f64>,
    /// Unit, a name in [`ModelDescription::units`].
    pub unit: Option<String>,
    /// Unit for display.
    pub display_unit: Option<String>,
    /// Physical quantity.
    pub quantity: Option<String>,
    /// Smallest value.
    pub min: Option<f64>,
    /// Largest value.
    pub max: Option<f64>,
    /// Usual size.
    pub nominal: Option<f64>,
    /// Index (from 0) of the variable this one is the time derivative of.
    pub derivative: Option<usize>,
    /// Differences matter, not the absolute value.
    pub relative_quantity: bool,
}

/// The base types that cross the C interface by functions of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaseType {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer`.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
    /// `fmi2String`.
    String,
    /// `fmi2Integer` with named values.
    Enumeration,
}

/// Which variables are outputs, derivatives and initial unknowns.
#[derive(Debug, Clone, Default)]
pub struct ModelStructure {
    /// All outputs.
    pub outputs: Vec<Unknown>,
    /// All state derivatives.
    pub derivatives: Vec<Unknown>,
    /// What the model computes during initialisation.
    pub initial_unknowns: Vec<Unknown>,
}

/// A variable the model computes, with what it depends on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unknown {
    /// Index (from 0) into [`ModelDescription::variables`].
    pub index: usize,
    /// Indices of the inputs (and states) it depends on directly; `None` means "on all of them".
    pub dependencies: Option<Vec<usize>>,
}

/// Why a `modelDescription.xml` cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// Not UTF-8, which FMI 2.0 prescribes.
    #[error("it is not UTF-8 text, which FMI 2.0 prescribes")]
    Encoding,
    /// Not well-formed XML.
    #[error("it is not well-formed XML: {0}")]
    Xml(#[from] roxmltree::Error),
    /// Some other XML document.
    #[error("its root element is <{0}>, not <fmiModelDescription>")]
    Root(String),
    /// Another version of the standard.
    #[error("it is written for FMI {0}; this tool imports FMI 2.0 (export the model again as FMI 2.0 co-simulation)")]
    Version(String),
    /// A required attribute is absent.
    #[error("line {line}: <{element}> lacks the attribute \"{attribute}\"")]
    Missing {
        /// Element that should have it.
        element: String,
        /// The attribute.
        attribute: &'static str,
        /// Line in the file.
        line: u32,
    },
    /// An attribute's value makes no sense.
    #[error("line {line}: {attribute}=\"{value}\" is not {expected}")]
    Value {
        /// The attribute.
        attribute: String,
        /// Its value.
        value: String,
        /// What it should be.
        expected: &'static str,
        /// Line in the file.
        line: u32,
    },
    /// A variable has no base type.
    #[error("line {line}: variable \"{name}\" has no type (Real, Integer, Boolean, String or Enumeration)")]
    NoType {
        /// The variable.
        name: String,
        /// Line in the file.
        line: u32,
    },
    /// Two variables of one name.
    #[error("two variables are called \"{0}\"")]
    Duplicate(String),
}

type Result<T> = std::result::Result<T, DescriptionError>;

impl ModelDescription {
    /// Reads the bytes of a `modelDescription.xml`.
    ///
    /// # Errors
    /// When the text is not an FMI 2.0 description, with the line and what is wrong with it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let text = std::str::from_utf8(bytes).map_err(|_| DescriptionError::Encoding)?;
        Self::parse(text.trim_start_matches('\u{feff}'))
    }

    /// Reads the text of a `modelDescription.xml`.
    ///
    /// # Errors
    /// When the text is not an FMI 2.0 description, with the line and what is wrong with it.
    pub fn parse(xml: &str) -> Result<Self> {
        let document = Document::parse(xml)?;
        let root = document.root_element();
        if root.tag_name().name() != "fmiModelDescription" {
            return Err(DescriptionError::Root(root.tag_name().name().to_owned()));
        }
        let fmi_version = required(root, "fmiVersion")?.to_owned();
        if fmi_version != "2.0" {
            return Err(DescriptionError::Version(fmi_version));
        }

        let types = children(root, "TypeDefinitions", "SimpleType").map(type_definition).collect::<Result<Vec<_>>>()?;
        let variables = children(root, "ModelVariables", "ScalarVariable")
            .map(|node| variable(node, &types))
            .collect::<Result<Vec<_>>>()?;
        let mut by_name = HashMap::with_capacity(variables.len());
        for (index, variable) in variables.iter().enumerate() {
            if by_name.insert(variable.name.clone(), index).is_some() {
                return Err(DescriptionError::Duplicate(variable.name.clone()));
            }
        }

        let count = variables.len();
        Ok(Self {
            fmi_version,
            model_name: required(root, "modelName")?.to_owned(),
            guid: required(root, "guid")?.to_owned(),
            description: text(root, "description"),
            author: text(root, "author"),
            version: text(root, "version"),
            copyright: text(root, "copyright"),
            license: text(root, "license"),
            generation_tool: text(root, "generationTool"),
            generation_date_and_time: text(root, "generationDateAndTime"),
            naming: match root.attribute("variableNamingConvention") {
                Some("structured") => Naming::Structured,
                _ => Naming::Flat,
            },
            number_of_event_indicators: number(root, "numberOfEventIndicators")?.unwrap_or(0),
            co_simulation: child(root, "CoSimulation").map(co_simulation).transpose()?,
            model_exchange: child(root, "ModelExchange")
                .map(|node| required(node, "modelIdentifier").map(str::to_owned))
                .transpose()?,
            units: children(root, "UnitDefinitions", "Unit").map(unit).collect::<Result<_>>()?,
            types,
            log_categories: children(root, "LogCategories", "Category")
                .map(|node| Ok((required(node, "name")?.to_owned(), text(node, "description"))))
                .collect::<Result<_>>()?,
            default_experiment: child(root, "DefaultExperiment")
                .map(default_experiment)
                .transpose()?
                .unwrap_or_default(),
            structure: ModelStructure {
                outputs: unknowns(root, "Outputs", count)?,
                derivatives: unknowns(root, "Derivatives", count)?,
                initial_unknowns: unknowns(root, "InitialUnknowns", count)?,
            },
            variables,
            by_name,
        })
    }

    /// The variable of that name.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.index_of(name).map(|index| &self.variables[index])
    }

    /// The index (from 0) of the variable of that name.
    #[must_use]
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }

    /// All variables of one causality, in the order of the file.
    pub fn with_causality(&self, causality: Causality) -> impl Iterator<Item = &Variable> {
        self.variables.iter().filter(move |variable| variable.causality == causality)
    }

    /// The items of an enumeration variable; empty for every other type.
    #[must_use]
    pub fn items(&self, variable: &Variable) -> &[Item] {
        match variable.kind {
            VariableType::Enumeration { declared_type: Some(index), .. } => &self.types[index].items,
            _ => &[],
        }
    }
}

impl Variable {
    /// Base type.
    #[must_use]
    pub fn base_type(&self) -> BaseType {
        self.kind.base_type()
    }

    /// Unit of a real variable.
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        match &self.kind {
            VariableType::Real(real) => real.unit.as_deref(),
            _ => None,
        }
    }

    /// Whether a user may set it before initialisation: parameters, inputs, and whatever has a start value that counts.
    #[must_use]
    pub fn is_settable(&self) -> bool {
        self.variability != Variability::Constant
            && (self.causality == Causality::Input || matches!(self.initial, Some(Initial::Exact | Initial::Approx)))
    }
}

impl VariableType {
    /// Base type.
    #[must_use]
    pub fn base_type(&self) -> BaseType {
        match self {
            Self::Real(_) => BaseType::Real,
            Self::Integer { .. } => BaseType::Integer,
            Self::Boolean { .. } => BaseType::Boolean,
            Self::String { .. } => BaseType::String,
            Self::Enumeration { .. } => BaseType::Enumeration,
        }
    }
}

fn co_simulation(node: Node) -> Result<CoSimulation> {
    Ok(CoSimulation {
        model_identifier: required(node, "modelIdentifier")?.to_owned(),
        needs_execution_tool: flag(node, "needsExecutionTool")?,
        can_handle_variable_communication_step_size: flag(node, "canHandleVariableCommunicationStepSize")?,
        can_interpolate_inputs: flag(node, "canInterpolateInputs")?,
        max_output_derivative_order: number(node, "maxOutputDerivativeOrder")?.unwrap_or(0),
        can_run_asynchronously: flag(node, "canRunAsynchronuously")?, // the standard's spelling
        can_be_instantiated_only_once_per_process: flag(node, "canBeInstantiatedOnlyOncePerProcess")?,
        can_not_use_memory_management_functions: flag(node, "canNotUseMemoryManagementFunctions")?,
        can_get_and_set_fmu_state: flag(node, "canGetAndSetFMUstate")?,
        can_serialize_fmu_state: flag(node, "canSerializeFMUstate")?,
        provides_directional_derivative: flag(node, "providesDirectionalDerivative")?,
    })
}

fn default_experiment(node: Node) -> Result<DefaultExperiment> {
    Ok(DefaultExperiment {
        start_time: number(node, "startTime")?,
        stop_time: number(node, "stopTime")?,
        tolerance: number(node, "tolerance")?,
        step_size: number(node, "stepSize")?,
    })
}

fn unit(node: Node) -> Result<Unit> {
    let base = child(node, "BaseUnit");
    let mut exponents = [0; 8];
    if let Some(base) = base {
        for (exponent, symbol) in exponents.iter_mut().zip(["kg", "m", "s", "A", "K", "mol", "cd", "rad"]) {
            *exponent = number(base, symbol)?.unwrap_or(0);
        }
    }
    let scale = |node: Option<Node>| -> Result<(f64, f64)> {
        let Some(node) = node else { return Ok((1.0, 0.0)) };
        Ok((number(node, "factor")?.unwrap_or(1.0), number(node, "offset")?.unwrap_or(0.0)))
    };
    let (factor, offset) = scale(base)?;
    let display_units = elements(node, "DisplayUnit")
        .map(|node| {
            let (factor, offset) = scale(Some(node))?;
            Ok(DisplayUnit { name: required(node, "name")?.to_owned(), factor, offset })
        })
        .collect::<Result<_>>()?;
    Ok(Unit {
        name: required(node, "name")?.to_owned(),
        exponents,
        factor,
        offset,
        has_base_unit: base.is_some(),
        display_units,
    })
}

fn type_definition(node: Node) -> Result<TypeDefinition> {
    let name = required(node, "name")?;
    let Some(kind_node) = type_element(node) else {
        return Err(DescriptionError::NoType { name: name.to_owned(), line: line(node) });
    };
    let items = elements(kind_node, "Item")
        .map(|item| {
            Ok(Item {
                name: required(item, "name")?.to_owned(),
                value: parsed(item, "value", required(item, "value")?)?,
                description: text(item, "description"),
            })
        })
        .collect::<Result<_>>()?;
    Ok(TypeDefinition {
        name: name.to_owned(),
        description: text(node, "description"),
        kind: variable_type(kind_node, &[])?,
        items,
    })
}

fn variable(node: Node, types: &[TypeDefinition]) -> Result<Variable> {
    let name = required(node, "name")?;
    let Some(kind_node) = type_element(node) else {
        return Err(DescriptionError::NoType { name: name.to_owned(), line: line(node) });
    };
    let kind = variable_type(kind_node, types)?;
    let causality = choice(
        node,
        "causality",
        "a causality",
        Causality::Local,
        &[
            ("parameter", Causality::Parameter),
            ("calculatedParameter", Causality::CalculatedParameter),
            ("input", Causality::Input),
            ("output", Causality::Output),
            ("local", Causality::Local),
            ("independent", Causality::Independent),
        ],
    )?;
    // Only reals can be continuous; for them it is the default.
    let usual = if kind.base_type() == BaseType::Real { Variability::Continuous } else { Variability::Discrete };
    let variability = choice(
        node,
        "variability",
        "a variability",
        usual,
        &[
            ("constant", Variability::Constant),
            ("fixed", Variability::Fixed),
            ("tunable", Variability::Tunable),
            ("discrete", Variability::Discrete),
            ("continuous", Variability::Continuous),
        ],
    )?;
    let initial = match node.attribute("initial") {
        None => default_initial(causality, variability),
        Some(_) => Some(choice(
            node,
            "initial",
            "exact, approx or calculated",
            Initial::Exact,
            &[("exact", Initial::Exact), ("approx", Initial::Approx), ("calculated", Initial::Calculated)],
        )?),
    };
    Ok(Variable {
        name: name.to_owned(),
        value_reference: parsed(node, "valueReference", required(node, "valueReference")?)?,
        description: text(node, "description"),
        causality,
        variability,
        initial,
        kind,
    })
}

/// The standard's table of defaults for `initial` (section 2.2.7).
fn default_initial(causality: Causality, variability: Variability) -> Option<Initial> {
    match (causality, variability) {
        (Causality::Input | Causality::Independent, _) => None,
        (Causality::Parameter, _) | (_, Variability::Constant) => Some(Initial::Exact),
        _ => Some(Initial::Calculated),
    }
}

fn variable_type(node: Node, types: &[TypeDefinition]) -> Result<VariableType> {
    let declared = node.attribute("declaredType").and_then(|name| types.iter().position(|kind| kind.name == name));
    let base = declared.map(|index| &types[index].kind);
    Ok(match node.tag_name().name() {
        "Real" => {
            let empty = RealAttributes::default();
            let inherited = match base {
                Some(VariableType::Real(real)) => real,
                _ => &empty,
            };
            VariableType::Real(RealAttributes {
                start: number(node, "start")?,
                unit: text(node, "unit").or_else(|| inherited.unit.clone()),
                display_unit: text(node, "displayUnit").or_else(|| inherited.display_unit.clone()),
                quantity: text(node, "quantity").or_else(|| inherited.quantity.clone()),
                min: number(node, "min")?.or(inherited.min),
                max: number(node, "max")?.or(inherited.max),
                nominal: number(node, "nominal")?.or(inherited.nominal),
                derivative: number::<usize>(node, "derivative")?.and_then(|index| index.checked_sub(1)),
                relative_quantity: flag(node, "relativeQuantity")? || inherited.relative_quantity,
            })
        }
        "Integer" => {
            let (inherited_min, inherited_max) = match base {
                Some(VariableType::Integer { min, max, .. }) => (*min, *max),
                _ => (None, None),
            };
            VariableType::Integer {
                start: number(node, "start")?,
                min: number(node, "min")?.or(inherited_min),
                max: number(node, "max")?.or(inherited_max),
            }
        }
        "Boolean" => VariableType::Boolean { start: node.attribute("start").map(|_| flag(node, "start")).transpose()? },
        "Enumeration" => VariableType::Enumeration { declared_type: declared, start: number(node, "start")? },
        _ => VariableType::String { start: text(node, "start") },
    })
}

fn unknowns(root: Node, list: &str, count: usize) -> Result<Vec<Unknown>> {
    let in_range = |node: Node, attribute: &'static str, value: &str| match value.parse::<usize>() {
        Ok(index) if (1..=count).contains(&index) => Ok(index - 1),
        _ => Err(DescriptionError::Value {
            attribute: attribute.to_owned(),
            value: value.to_owned(),
            expected: "the index of a variable (they count from 1)",
            line: line(node),
        }),
    };
    let Some(list) = child(root, "ModelStructure").and_then(|structure| child(structure, list)) else {
        return Ok(Vec::new());
    };
    elements(list, "Unknown")
        .map(|node| {
            let dependencies = node
                .attribute("dependencies")
                .map(|indices| {
                    indices.split_ascii_whitespace().map(|index| in_range(node, "dependencies", index)).collect()
                })
                .transpose()?;
            Ok(Unknown { index: in_range(node, "index", required(node, "index")?)?, dependencies })
        })
        .collect()
}

fn type_element<'a, 'input>(node: Node<'a, 'input>) -> Option<Node<'a, 'input>> {
    node.children()
        .find(|child| matches!(child.tag_name().name(), "Real" | "Integer" | "Boolean" | "String" | "Enumeration"))
}

fn elements<'a, 'input>(node: Node<'a, 'input>, name: &str) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| child.tag_name().name() == name)
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    elements(node, name).next()
}

fn children<'a, 'input>(root: Node<'a, 'input>, list: &str, name: &str) -> impl Iterator<Item = Node<'a, 'input>> {
    child(root, list).into_iter().flat_map(move |list| elements(list, name))
}

fn text(node: Node, attribute: &str) -> Option<String> {
    node.attribute(attribute).map(str::to_owned)
}

fn required<'a>(node: Node<'a, '_>, attribute: &'static str) -> Result<&'a str> {
    node.attribute(attribute).ok_or_else(|| DescriptionError::Missing {
        element: node.tag_name().name().to_owned(),
        attribute,
        line: line(node),
    })
}

fn number<T: Number>(node: Node, attribute: &str) -> Result<Option<T>> {
    node.attribute(attribute).map(|value| parsed(node, attribute, value)).transpose()
}

fn parsed<T: Number>(node: Node, attribute: &str, value: &str) -> Result<T> {
    value.trim().parse().map_err(|_| DescriptionError::Value {
        attribute: attribute.to_owned(),
        value: value.to_owned(),
        expected: T::EXPECTED,
        line: line(node),
    })
}

fn flag(node: Node, attribute: &str) -> Result<bool> {
    let choices = [("true", true), ("1", true), ("false", false), ("0", false)];
    choice(node, attribute, "true or false", false, &choices)
}

fn choice<T: Copy>(
    node: Node,
    attribute: &str,
    expected: &'static str,
    default: T,
    choices: &[(&str, T)],
) -> Result<T> {
    let Some(value) = node.attribute(attribute) else { return Ok(default) };
    choices.iter().find(|(name, _)| *name == value.trim()).map(|&(_, choice)| choice).ok_or_else(|| {
        DescriptionError::Value { attribute: attribute.to_owned(), value: value.to_owned(), expected, line: line(node) }
    })
}

fn line(node: Node) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// Numbers of the description, with the words an error needs.
trait Number: std::str::FromStr {
    const EXPECTED: &'static str;
}
impl Number for f64 {
    const EXPECTED: &'static str = "a number";
}
impl Number for i32 {
    const EXPECTED: &'static str = "a 32-bit integer";
}
impl Number for u32 {
    const EXPECTED: &'static str = "a non-negative 32-bit integer";
}
impl Number for usize {
    const EXPECTED: &'static str = "a non-negative integer";
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Sample" guid="{1}" variableNamingConvention="structured"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <CoSimulation modelIdentifier="Sample" canHandleVariableCommunicationStepSize="true" maxOutputDerivativeOrder="1"
      canRunAsynchronuously="0"><SourceFiles><File name="a.c"/></SourceFiles></CoSimulation>
  <UnitDefinitions>
    <Unit name="N.m"><BaseUnit kg="1" m="2" s="-2"/></Unit>
    <Unit name="rad"><BaseUnit rad="1"/><DisplayUnit name="deg" factor="57.29577951308232"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Angle"><Real unit="rad" displayUnit="deg" min="-4"/></SimpleType>
    <SimpleType name="Mode"><Enumeration><Item name="slow" value="1"/><Item name="fast" value="2"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <LogCategories><Category name="logStatusError" description="Errors"/></LogCategories>
  <DefaultExperiment stopTime="5" stepSize="1e-4"/>
  <VendorAnnotations><Tool name="x"><Real/></Tool></VendorAnnotations>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real declaredType="Angle" start="0"/></ScalarVariable>
    <ScalarVariable name="arm.y[1]" valueReference="1" causality="output"><Annotations><Tool name="y"/></Annotations><Real derivative="1"/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="0" causality="parameter" variability="fixed"><Enumeration declaredType="Mode" start="2"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="1" variability="constant"><Integer start="-3"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="2" causality="output" variability="discrete" initial="exact"><Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="file" valueReference="3" causality="parameter" variability="tunable"><String start="a &lt; b"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2" dependencies=""/><Unknown index="5" dependencies="1 2"/><Unknown index="5"/></Outputs></ModelStructure>
</fmiModelDescription>"#;

    #[test]
    fn reads_every_part_of_a_description() {
        let model = ModelDescription::from_bytes(format!("\u{feff}{SAMPLE}").as_bytes()).unwrap();
        assert_eq!((model.model_name.as_str(), model.guid.as_str()), ("Sample", "{1}"));
        assert_eq!(model.naming, Naming::Structured);
        let interface = model.co_simulation.as_ref().unwrap();
        assert!(interface.can_handle_variable_communication_step_size && !interface.can_run_asynchronously);
        assert_eq!(interface.max_output_derivative_order, 1);
        assert_eq!(model.units[0].exponents, [1, 2, -2, 0, 0, 0, 0, 0]);
        assert_eq!(model.units[1].display_units[0].name, "deg");
        assert_eq!(model.default_experiment.step_size, Some(1e-4));
        assert_eq!(model.default_experiment.start_time, None);

        let VariableType::Real(real) = &model.variable("u").unwrap().kind else { panic!("u is real") };
        assert_eq!((real.unit.as_deref(), real.min, real.start), (Some("rad"), Some(-4.0), Some(0.0)));
        let y = model.variable("arm.y[1]").unwrap();
        assert_eq!(y.initial, Some(Initial::Calculated));
        assert!(!y.is_settable());
        assert!(matches!(&y.kind, VariableType::Real(real) if real.derivative == Some(0)));
        let mode = model.variable("mode").unwrap();
        assert_eq!(model.items(mode)[1].name, "fast");
        assert!(mode.is_settable());
        assert!(!model.variable("n").unwrap().is_settable());
        assert_eq!(model.variable("file").unwrap().kind, VariableType::String { start: Some("a < b".into()) });

        let dependencies: Vec<_> = model.structure.outputs.iter().map(|u| u.dependencies.clone()).collect();
        assert_eq!(dependencies, [Some(vec![]), Some(vec![0, 1]), None]);
    }

    #[test]
    fn says_what_is_wrong_and_where() {
        let cases = [
            ("fmiVersion=\"2.0\"", "fmiVersion=\"3.0\"", "written for FMI 3.0"),
            ("fmiModelDescription", "fmuDescription", "root element is <fmuDescription>"),
            (" guid=\"{1}\"", "", "lacks the attribute \"guid\""),
            ("valueReference=\"3\"", "valueReference=\"-3\"", "line 23: valueReference=\"-3\" is not a non-negative"),
            ("dependencies=\"1 2\"", "dependencies=\"1 7\"", "index of a variable"),
            ("name=\"on\"", "name=\"n\"", "two variables are called \"n\""),
            ("start=\"true\"", "start=\"yes\"", "start=\"yes\" is not true or false"),
            ("<Real derivative=\"1\"/>", "", "\"arm.y[1]\" has no type"),
            ("</ModelVariables>", "", "well-formed"),
        ];
        for (from, to, expected) in cases {
            let message = ModelDescription::parse(&SAMPLE.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains(expected), "{message:?} should contain {expected:?}");
        }
        assert!(matches!(ModelDescription::from_bytes(&[0xff, 0xfe]), Err(DescriptionError::Encoding)));
    }
}

//! `modelDescription.xml` to values.

mod variable;

use std::collections::HashMap;
use std::sync::Arc;

use super::{
    BASE_UNITS, ByName, CoSimulation, DefaultExperiment, DescriptionError, DisplayUnit, ModelDescription,
    ModelStructure, Naming, Unit, Unknown,
};
use crate::document;
use crate::tree::Tree;
use crate::xml::{Element, child, children, elements, number, optional, required, truth, wrong};
use variable::{type_definition, variable};

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
        match Tree::of(xml) {
            Some(tree) => Self::read(tree.root()),
            None => Self::read(document::parse(xml)?.root_element()),
        }
    }

    fn read<'a>(root: impl Element<'a>) -> Result<Self> {
        if root.name() != "fmiModelDescription" {
            return Err(DescriptionError::Root(root.name().to_owned()));
        }
        let fmi_version = required(root, "fmiVersion")?.to_owned();
        if fmi_version != "2.0" {
            return Err(DescriptionError::Version(fmi_version));
        }

        let types = children(root, "TypeDefinitions", "SimpleType").map(type_definition).collect::<Result<Vec<_>>>()?;
        let units = children(root, "UnitDefinitions", "Unit").map(unit).collect::<Result<Vec<_>>>()?;
        consistent("the unit", units.iter().map(|unit| (unit.name.as_str(), unit)))?;
        consistent("the type", types.iter().map(|kind| (kind.name.as_str(), (&kind.kind, &kind.items))))?;
        for kind in &types {
            let items = kind.items.iter().map(|item| (item.name.as_str(), item.value));
            consistent("an item of an enumeration", items)?;
        }
        let types_by_name: HashMap<_, _> = types.iter().map(|kind| kind.name.as_str()).zip(0..).collect();
        let known_types = (types.as_slice(), &types_by_name);
        let nodes = || children(root, "ModelVariables", "ScalarVariable");
        let mut variables = Vec::with_capacity(nodes().count());
        for node in nodes() {
            variables.push(variable(node, known_types)?);
        }
        let by_name =
            ByName::of(&variables).map_err(|again| DescriptionError::Duplicate(variables[again].name.clone()))?;
        let count = variables.len();
        Ok(Self {
            fmi_version,
            model_name: required(root, "modelName")?.to_owned(),
            guid: required(root, "guid")?.to_owned(),
            description: optional(root, "description"),
            author: optional(root, "author"),
            version: optional(root, "version"),
            copyright: optional(root, "copyright"),
            license: optional(root, "license"),
            generation_tool: optional(root, "generationTool"),
            generation_date_and_time: optional(root, "generationDateAndTime"),
            naming: match root.attribute("variableNamingConvention") {
                Some("structured") => Naming::Structured,
                _ => Naming::Flat,
            },
            number_of_event_indicators: number(root, "numberOfEventIndicators")?.unwrap_or(0),
            co_simulation: child(root, "CoSimulation").map(co_simulation).transpose()?,
            model_exchange: child(root, "ModelExchange")
                .map(|node| required(node, "modelIdentifier").map(str::to_owned))
                .transpose()?,
            units,
            types,
            log_categories: children(root, "LogCategories", "Category")
                .map(|node| Ok((required(node, "name")?.to_owned(), optional(node, "description"))))
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
}

/// Names are keys: equal names must have equal definitions.
fn consistent<'a, T: PartialEq + Copy>(what: &'static str, named: impl Iterator<Item = (&'a str, T)>) -> Result<()> {
    let mut known = HashMap::new();
    for (name, meaning) in named {
        if *known.entry(name).or_insert(meaning) != meaning {
            return Err(DescriptionError::Contradiction { what, name: name.to_owned() });
        }
    }
    Ok(())
}

fn co_simulation<'a>(node: impl Element<'a>) -> Result<CoSimulation> {
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

fn default_experiment<'a>(node: impl Element<'a>) -> Result<DefaultExperiment> {
    Ok(DefaultExperiment {
        start_time: number(node, "startTime")?,
        stop_time: number(node, "stopTime")?,
        tolerance: number(node, "tolerance")?,
        step_size: number(node, "stepSize")?,
    })
}

fn unit<'a, N: Element<'a>>(node: N) -> Result<Unit> {
    let base = child(node, "BaseUnit");
    let mut exponents = [0; 8];
    if let Some(base) = base {
        for (exponent, symbol) in exponents.iter_mut().zip(BASE_UNITS) {
            *exponent = number(base, symbol)?.unwrap_or(0);
        }
    }
    let scale = |node: Option<N>| -> Result<(f64, f64)> {
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

fn unknowns<'a, N: Element<'a>>(root: N, list: &str, count: usize) -> Result<Vec<Unknown>> {
    let in_range = |node: N, attribute: &'static str, value: &str| match value.parse::<usize>() {
        Ok(index) if (1..=count).contains(&index) => Ok(index - 1),
        _ => Err(wrong(node, attribute, value, "the index of a variable (they count from 1)")),
    };
    let Some(list) = child(root, "ModelStructure").and_then(|structure| child(structure, list)) else {
        return Ok(Vec::new());
    };
    // Unknowns that depend on all of many variables stand side by side.
    let mut before: (&str, Arc<[usize]>) = ("", Arc::default());
    let unknown = |node: N| {
        let dependencies = node.attribute("dependencies");
        if let Some(text) = dependencies.filter(|text| *text != before.0) {
            let indices = text.split_ascii_whitespace().map(|index| in_range(node, "dependencies", index));
            before = (text, indices.collect::<std::result::Result<_, _>>()?);
        }
        let dependencies = dependencies.map(|_| Arc::clone(&before.1));
        Ok(Unknown { index: in_range(node, "index", required(node, "index")?)?, dependencies })
    };
    elements(list, "Unknown").map(unknown).collect()
}

/// An attribute for a capability of the FMU; a missing one means "no".
fn flag<'a>(node: impl Element<'a>, attribute: &str) -> Result<bool> {
    Ok(truth(node, attribute)?.unwrap_or(false))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{Initial, VariableType};

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

    /// The same, as the general parser reads it and as the short way does.
    fn samples() -> [String; 2] {
        let usual = SAMPLE.replace("xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"", "");
        assert!(Tree::of(SAMPLE).is_none() && Tree::of(&usual).is_some());
        [SAMPLE.to_owned(), usual]
    }

    #[test]
    fn reads_every_part_of_a_description() {
        for sample in samples() {
            has_every_part(&ModelDescription::from_bytes(format!("\u{feff}{sample}").as_bytes()).unwrap());
        }
    }

    fn has_every_part(model: &ModelDescription) {
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
        assert_eq!(mode.items()[1].name, "fast");
        assert!(mode.is_settable());
        assert!(!model.variable("n").unwrap().is_settable());
        assert_eq!(model.variable("file").unwrap().kind, VariableType::String { start: Some("a < b".into()) });

        let dependencies: Vec<_> = model.structure.outputs.iter().map(|u| u.dependencies.clone()).collect();
        assert_eq!(dependencies, [Some([].into()), Some([0, 1].into()), None]);
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
            ("<Unit name=\"N.m\">", "<Unit name=\"rad\">", "the unit \"rad\" is defined in two ways"),
            ("<SimpleType name=\"Angle\">", "<SimpleType name=\"Mode\">", "the type \"Mode\" is defined in two ways"),
            ("name=\"fast\"", "name=\"slow\"", "an item of an enumeration \"slow\" is defined in two ways"),
            ("start=\"true\"", "start=\"yes\"", "start=\"yes\" is not true or false"),
            ("<Real derivative=\"1\"/>", "", "\"arm.y[1]\" has no type"),
            ("</ModelVariables>", "", "well-formed"),
        ];
        for (from, to, expected) in cases {
            for sample in samples() {
                let message = ModelDescription::parse(&sample.replace(from, to)).unwrap_err().to_string();
                assert!(message.contains(expected), "{message:?} should contain {expected:?}");
            }
        }
        assert!(matches!(ModelDescription::from_bytes(&[0xff, 0xfe]), Err(DescriptionError::Encoding)));
    }
}

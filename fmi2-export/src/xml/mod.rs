//! `modelDescription.xml` (FMI 2.0.4, sections 2.2, 3.3 and 4.3), generated from the declarations.

mod structure;

use std::collections::{BTreeMap, HashMap};

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesStart, Event};
use uuid::Uuid;

use crate::categories::CATEGORIES;
use crate::interface::{Interface, Kind, VariableFacts, number};
use crate::layout::DeclarationError;
use crate::model::Model;
use crate::naming::is_structured;
use crate::unit::{BASE_UNITS, Unit};
use crate::variable::Causality;
use structure::model_structure;

/// Namespace of the GUIDs: a version 5 UUID of the text "fmi2-export" in the DNS-less nil namespace.
const NAMESPACE: Uuid = Uuid::from_u128(0x6f1d_3b5e_52a9_5c4b_9d0e_8a3c_71f2_46d7);

/// A model's description: the XML file and what the C interface needs of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Description {
    /// `modelName` and `modelIdentifier`.
    pub name: &'static str,
    /// The GUID: a fingerprint (version 5 UUID) of everything else in the description.
    pub guid: String,
    /// The text of `modelDescription.xml`.
    pub xml: String,
}

/// Generates the description of `M`. The same declarations always give the same text.
///
/// # Errors
/// If the declarations contradict themselves; all problems are listed.
pub fn describe<M: Model>() -> Result<Description, DeclarationError> {
    Ok(describe_interface(&Interface::of::<M>()?))
}

pub(crate) fn describe_interface(interface: &Interface) -> Description {
    let anonymous = render(interface, "");
    let guid = format!("{{{}}}", Uuid::new_v5(&NAMESPACE, anonymous.as_bytes()));
    Description { name: interface.info.name, xml: render(interface, &guid), guid }
}

/// `generationTool`.
pub const GENERATION_TOOL: &str = concat!("fmi2-export ", env!("CARGO_PKG_VERSION"));

/// Attributes of an element, in order; optional ones can be absent.
type Attributes<'a> = Vec<(&'a str, String)>;

struct Xml(Writer<Vec<u8>>);

impl Xml {
    fn event(&mut self, event: Event<'_>) {
        // Writing to memory cannot fail.
        let _ = self.0.write_event(event);
    }

    fn start<'n>(name: &'n str, attributes: &[(&str, String)]) -> BytesStart<'n> {
        let mut start = BytesStart::new(name);
        for (key, value) in attributes {
            start.push_attribute((*key, value.as_str()));
        }
        start
    }

    fn empty(&mut self, name: &str, attributes: &[(&str, String)]) {
        self.event(Event::Empty(Self::start(name, attributes)));
    }

    fn element(&mut self, name: &str, attributes: &[(&str, String)], content: impl FnOnce(&mut Self)) {
        let start = Self::start(name, attributes);
        let end = start.to_end().into_owned();
        self.event(Event::Start(start));
        content(self);
        self.event(Event::End(end));
    }
}

fn render(interface: &Interface, guid: &str) -> String {
    let info = interface.info;
    let mut xml = Xml(Writer::new_with_indent(Vec::new(), b' ', 2));
    xml.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
    let mut root: Attributes<'_> =
        vec![("fmiVersion", "2.0".into()), ("modelName", info.name.into()), ("guid", guid.into())];
    for (key, value) in [
        ("description", info.description),
        ("author", info.author),
        ("version", info.version),
        ("copyright", info.copyright),
        ("license", info.license),
    ] {
        if !value.is_empty() {
            root.push((key, value.into()));
        }
    }
    root.push(("generationTool", GENERATION_TOOL.into()));
    let structured = interface.variables.iter().all(|variable| is_structured(&variable.name));
    root.push(("variableNamingConvention", if structured { "structured" } else { "flat" }.into()));
    let indicators = interface.exchange.as_ref().map_or(0, |exchange| exchange.event_indicators);
    root.push(("numberOfEventIndicators", indicators.to_string()));
    xml.element("fmiModelDescription", &root, |xml| {
        model_exchange(xml, interface);
        co_simulation(xml, interface);
        unit_definitions(xml, interface);
        type_definitions(xml, interface);
        xml.element("LogCategories", &[], |xml| {
            for (name, description) in CATEGORIES {
                xml.empty("Category", &[("name", name.into()), ("description", description.into())]);
            }
        });
        let experiment = info.default_experiment;
        let mut attributes =
            vec![("startTime", number(experiment.start_time)), ("stopTime", number(experiment.stop_time))];
        attributes.extend(experiment.tolerance.map(|tolerance| ("tolerance", number(tolerance))));
        attributes.push(("stepSize", number(experiment.step_size)));
        xml.empty("DefaultExperiment", &attributes);
        model_variables(xml, interface);
        model_structure(xml, interface);
    });
    let mut text = String::from_utf8(xml.0.into_inner()).unwrap_or_default();
    text.push('\n');
    text
}

fn model_exchange(xml: &mut Xml, interface: &Interface) {
    let Some(exchange) = &interface.exchange else { return };
    let yes = || "true".to_owned();
    let mut attributes = vec![("modelIdentifier", interface.info.name.to_owned())];
    if exchange.completed_step_not_needed {
        attributes.push(("completedIntegratorStepNotNeeded", yes()));
    }
    attributes.push(("canNotUseMemoryManagementFunctions", yes()));
    attributes.push(("canGetAndSetFMUstate", yes()));
    attributes.push(("canSerializeFMUstate", yes()));
    if interface.info.directional_derivatives {
        attributes.push(("providesDirectionalDerivative", yes()));
    }
    xml.empty("ModelExchange", &attributes);
}

fn co_simulation(xml: &mut Xml, interface: &Interface) {
    let yes = || "true".to_owned();
    let mut attributes = vec![
        ("modelIdentifier", interface.info.name.to_owned()),
        ("canHandleVariableCommunicationStepSize", yes()),
        ("canNotUseMemoryManagementFunctions", yes()),
        ("canGetAndSetFMUstate", yes()),
        ("canSerializeFMUstate", yes()),
    ];
    if interface.interpolates_inputs {
        attributes.push(("canInterpolateInputs", yes()));
    }
    if interface.has_rates {
        attributes.push(("maxOutputDerivativeOrder", "1".into()));
    }
    if interface.info.directional_derivatives {
        attributes.push(("providesDirectionalDerivative", yes()));
    }
    xml.empty("CoSimulation", &attributes);
}

fn unit_definitions(xml: &mut Xml, interface: &Interface) {
    let mut units: BTreeMap<&str, (&Unit, BTreeMap<&str, f64>)> = BTreeMap::new();
    for variable in &interface.variables {
        let Some(unit) = &variable.unit else { continue };
        let (_, display) = units.entry(&unit.name).or_insert((unit, BTreeMap::new()));
        display.extend(variable.display_unit.as_ref().map(|d| (d.name.as_str(), d.factor)));
    }
    if units.is_empty() {
        return;
    }
    xml.element("UnitDefinitions", &[], |xml| {
        for (unit, display) in units.values() {
            xml.element("Unit", &[("name", unit.name.clone())], |xml| {
                let mut base: Attributes<'_> = BASE_UNITS
                    .iter()
                    .zip(unit.exponents)
                    .filter(|(_, exponent)| *exponent != 0)
                    .map(|(name, exponent)| (*name, exponent.to_string()))
                    .collect();
                if unit.factor.to_bits() != 1.0_f64.to_bits() {
                    base.push(("factor", number(unit.factor)));
                }
                if unit.offset != 0.0 {
                    base.push(("offset", number(unit.offset)));
                }
                xml.empty("BaseUnit", &base);
                for (name, factor) in display {
                    xml.empty("DisplayUnit", &[("name", (*name).into()), ("factor", number(*factor))]);
                }
            });
        }
    });
}

fn type_definitions(xml: &mut Xml, interface: &Interface) {
    if interface.enumerations.is_empty() {
        return;
    }
    xml.element("TypeDefinitions", &[], |xml| {
        for kind in &interface.enumerations {
            let attributes = vec![("name", kind.name.into()), ("description", kind.description.into())];
            xml.element("SimpleType", &attributes, |xml| {
                xml.element("Enumeration", &[], |xml| {
                    for (i, (name, description)) in kind.items.iter().enumerate() {
                        let attributes = vec![
                            ("name", (*name).into()),
                            ("value", (i + 1).to_string()),
                            ("description", (*description).into()),
                        ];
                        xml.empty("Item", &attributes);
                    }
                });
            });
        }
    });
}

fn model_variables(xml: &mut Xml, interface: &Interface) {
    let states = interface.variables.iter().enumerate().filter(|(_, variable)| variable.is_state);
    let place_of: HashMap<&str, usize> = states.map(|(place, variable)| (variable.name.as_str(), place)).collect();
    xml.element("ModelVariables", &[], |xml| {
        for variable in &interface.variables {
            let mut attributes = vec![
                ("name", variable.name.clone()),
                ("valueReference", variable.reference.index.to_string()),
                ("description", variable.description.clone()),
                ("causality", variable.causality.name().into()),
                ("variability", variable.variability.name().into()),
            ];
            match variable.causality {
                Causality::Parameter => attributes.push(("initial", "exact".into())),
                Causality::Output | Causality::Local => attributes.push(("initial", "calculated".into())),
                // An input has no attribute `initial`: its start value is always exact.
                Causality::Input => {}
            }
            xml.element("ScalarVariable", &attributes, |xml| {
                let (name, mut attributes) = type_element(variable);
                if let Some(state) = variable.derivative_of.as_deref().and_then(|state| place_of.get(state)) {
                    attributes.push(("derivative", (state + 1).to_string()));
                }
                xml.empty(name, &attributes);
            });
        }
    });
}

/// `<Real>`, `<Integer>`, … of a variable, with its start value if it is given rather than computed.
fn type_element(variable: &VariableFacts) -> (&'static str, Attributes<'static>) {
    let mut attributes: Attributes<'static> = Vec::new();
    attributes.extend(variable.unit.as_ref().map(|unit| ("unit", unit.name.clone())));
    attributes.extend(variable.display_unit.as_ref().map(|display| ("displayUnit", display.name.clone())));
    let name = match variable.kind {
        Kind::Real => "Real",
        Kind::Integer => "Integer",
        Kind::Boolean => "Boolean",
        Kind::String => "String",
        Kind::Enumeration(kind) => {
            attributes.push(("declaredType", kind.name.into()));
            "Enumeration"
        }
    };
    if matches!(variable.kind, Kind::Real | Kind::Integer) {
        attributes.extend(variable.min.map(|v| ("min", variable.number(v))));
        attributes.extend(variable.max.map(|v| ("max", variable.number(v))));
    }
    if variable.kind == Kind::Real {
        attributes.extend(variable.nominal.map(|v| ("nominal", number(v))));
    }
    attributes.extend(variable.start.clone().map(|start| ("start", start)));
    (name, attributes)
}

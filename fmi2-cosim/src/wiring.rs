//! Connections between components: outputs, the inputs that they drive, and the rules for a valid connection.
//!
//! The rules ([`fit`]) are the same for connections by name and for those that a file describes. A signal keeps its type,
//! except that integers may drive reals, and integers and items of enumerations may drive each other. Reals are converted
//! between units of the same quantity.

use std::collections::{BTreeSet, HashMap};

use fmi2_import::description::BaseType;
use fmi2_import::{Causality, ModelDescription, Variable, VariableType};

use crate::units::{Conversion, UnitMismatch, Units};

/// One connection, from an output to an input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wire {
    /// The output.
    pub from: Terminal,
    /// The input.
    pub to: Terminal,
    /// The conversion of its values; `None` if they are passed unchanged.
    pub conversion: Option<Conversion>,
}

/// One variable of one component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Terminal {
    /// Index of the component.
    pub component: usize,
    /// Index of the variable in its description.
    pub variable: usize,
}

/// Connections, and remarks on them for the user.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Wiring {
    /// The connections.
    pub wires: Vec<Wire>,
    /// Connections that a user may not expect, in sentences.
    pub remarks: Vec<String>,
}

/// Why components cannot be connected by name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WiringError {
    /// Two components have an output with the name of a third one's input.
    #[error("both {first} and {second} offer \"{name}\", which {wanting} wants; only one of them can be connected")]
    Ambiguous {
        /// Name of the signal.
        name: String,
        /// One component with this output.
        first: String,
        /// Another one.
        second: String,
        /// The component with this input.
        wanting: String,
    },
    /// An output and an input have the same name, but the output cannot drive the input.
    #[error("{from} and {to} have one name but cannot be connected: {source}; connect them in an SSP, or rename one")]
    Misfit {
        /// The output, `Component.name`.
        from: String,
        /// The input, `Component.name`.
        to: String,
        /// Why.
        source: Misfit,
    },
}

/// Why an output cannot drive an input.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Misfit {
    /// Values of one type cannot be converted to the other.
    #[error("one is {from:?}, the other {to:?}")]
    Types {
        /// Type of the output.
        from: BaseType,
        /// Type of the input.
        to: BaseType,
    },
    /// This tool does not connect strings.
    #[error("this tool does not connect string variables")]
    Text,
    /// Units that do not fit.
    #[error(transparent)]
    Units(#[from] UnitMismatch),
}

/// A variable with the units of its description.
pub type InUnits<'a> = (&'a Variable, &'a Units<'a>);

/// A doubt about a connection of reals: their units are not defined.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Doubt {
    /// Two names, of which at least one is not defined in base units.
    Differ(String, String),
    /// One name that the two FMUs do not both define in base units.
    Undefined(String),
}

/// The doubts about connections, for the user.
#[derive(Debug, Clone, Default)]
pub(crate) struct Doubts {
    remarks: Vec<String>,
    undefined: BTreeSet<String>,
    connections: usize,
}

impl Doubts {
    /// Adds one about the connection between two variables, `Component.name`.
    pub(crate) fn add(&mut self, doubt: Doubt, from: &str, to: &str) {
        match doubt {
            Doubt::Differ(from_unit, to_unit) => self.remarks.push(format!(
                "{from} → {to}: in {from_unit} and {to_unit}, which the FMUs do not define in base units: values pass as \
                 they are"
            )),
            Doubt::Undefined(unit) => {
                self.undefined.insert(unit);
                self.connections += 1;
            }
        }
    }

    /// In sentences; those about names that agree in one.
    pub(crate) fn into_remarks(self) -> Vec<String> {
        const SHOWN: usize = 5;
        let Self { mut remarks, undefined, connections } = self;
        if !undefined.is_empty() {
            let mut names: Vec<_> = undefined.iter().take(SHOWN).map(String::as_str).collect();
            if undefined.len() > SHOWN {
                names.push("…");
            }
            remarks.push(format!(
                "units that not both FMUs of a connection define in base units ({}): the values of {connections} \
                 connection{} pass as they are, since the names agree",
                names.join(", "),
                if connections == 1 { "" } else { "s" }
            ));
        }
        remarks
    }
}

/// The conversion of values from an output to an input, and doubts about it.
///
/// # Errors
/// When the output cannot drive the input.
pub fn fit(from: InUnits, to: InUnits) -> Result<(Option<Conversion>, Option<Doubt>), Misfit> {
    use BaseType::{Boolean, Enumeration, Integer, Real, String};
    match (from.0.base_type(), to.0.base_type()) {
        (Real, Real) => {}
        (Integer, Real | Integer | Enumeration) | (Enumeration, Integer | Enumeration) | (Boolean, Boolean) => {
            return Ok((None, None));
        }
        (String, String) => return Err(Misfit::Text),
        (from, to) => return Err(Misfit::Types { from, to }),
    }
    let (Some(from_unit), Some(to_unit)) = (from.0.unit(), to.0.unit()) else { return Ok((None, None)) };
    if let (Some(defined_from), Some(defined_to)) = (from.1.named(from_unit), to.1.named(to_unit)) {
        let are_differences = (is_difference(from.0), is_difference(to.0));
        return Ok((Conversion::between(defined_from, defined_to, are_differences)?, None));
    }
    let doubt = if from_unit == to_unit {
        Doubt::Undefined(from_unit.to_owned())
    } else {
        Doubt::Differ(from_unit.to_owned(), to_unit.to_owned())
    };
    Ok((None, Some(doubt)))
}

fn is_difference(variable: &Variable) -> bool {
    matches!(&variable.kind, VariableType::Real(real) if real.relative_quantity)
}

/// Connects every input to the output of the same name of another component. Inputs without such an output stay free.
///
/// # Errors
/// When two outputs have the name of one input, or an output of the same name cannot drive it.
pub fn wire_by_name(components: &[(&str, &ModelDescription)]) -> Result<Wiring, WiringError> {
    let units: Vec<_> = components.iter().map(|(_, description)| Units::of(description)).collect();
    let mut offers: HashMap<&str, Vec<Terminal>> = HashMap::new();
    for (component, (_, description)) in components.iter().enumerate() {
        for (index, variable) in description.variables.iter().enumerate() {
            if variable.causality == Causality::Output {
                offers.entry(&variable.name).or_default().push(Terminal { component, variable: index });
            }
        }
    }
    let variable = |terminal: Terminal| &components[terminal.component].1.variables[terminal.variable];
    let name = |terminal: Terminal| format!("{}.{}", components[terminal.component].0, variable(terminal).name);
    let (mut wiring, mut doubts) = (Wiring::default(), Doubts::default());
    for (component, (wanting, description)) in components.iter().enumerate() {
        for (index, input) in description.variables.iter().enumerate() {
            if input.causality != Causality::Input {
                continue;
            }
            let named = offers.get(input.name.as_str()).map_or(&[][..], Vec::as_slice);
            let mut others = named.iter().copied().filter(|offer| offer.component != component);
            let Some(from) = others.next() else { continue };
            if let Some(second) = others.next() {
                return Err(WiringError::Ambiguous {
                    name: input.name.clone(),
                    first: components[from.component].0.to_owned(),
                    second: components[second.component].0.to_owned(),
                    wanting: (*wanting).to_owned(),
                });
            }
            let to = Terminal { component, variable: index };
            match fit((variable(from), &units[from.component]), (input, &units[component])) {
                Ok((conversion, doubt)) => {
                    wiring.wires.push(Wire { from, to, conversion });
                    if let Some(doubt) = doubt {
                        doubts.add(doubt, &name(from), &name(to));
                    }
                }
                Err(Misfit::Text) => {
                    let remark = format!("{} → {}: {}", name(from), name(to), Misfit::Text);
                    wiring.remarks.push(remark);
                }
                Err(source) => return Err(WiringError::Misfit { from: name(from), to: name(to), source }),
            }
        }
    }
    wiring.remarks.extend(doubts.into_remarks());
    Ok(wiring)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A description with these variables, each `causality name type-and-attributes`.
    fn model(variables: &[&str]) -> ModelDescription {
        let variables = variables.iter().enumerate().map(|(reference, text)| {
            let mut words = text.splitn(3, ' ');
            let (causality, name, kind) = (words.next().unwrap(), words.next().unwrap(), words.next().unwrap());
            let variability = if kind.starts_with("Real") { "continuous" } else { "discrete" };
            format!(
                r#"<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" variability="{variability}"><{kind}/></ScalarVariable>"#
            )
        });
        let xml = format!(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><UnitDefinitions>
            <Unit name="rad"><BaseUnit rad="1"/></Unit><Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit>
            <Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit><Unit name="bushel"/>
            </UnitDefinitions><ModelVariables>{}</ModelVariables></fmiModelDescription>"#,
            variables.collect::<Vec<_>>().concat()
        );
        ModelDescription::parse(&xml).unwrap()
    }

    fn wire(from: &str, to: &str) -> Result<Wiring, WiringError> {
        wire_by_name(&[("A", &model(&[from])), ("B", &model(&[to]))])
    }

    #[test]
    fn units_that_measure_the_same_are_converted() {
        let converted = |from: &str, to: &str, value: f64| {
            let wiring = wire(from, to).unwrap();
            assert!(wiring.remarks.is_empty());
            wiring.wires[0].conversion.map_or(value, |conversion| conversion.apply(value))
        };
        let (rad, deg) = (r#"output x Real unit="rad""#, r#"output x Real unit="deg""#);
        assert!((converted(rad, r#"input x Real unit="deg""#, std::f64::consts::PI) - 180.0).abs() < 1e-12);
        assert!((converted(deg, r#"input x Real unit="rad""#, 180.0) - std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(converted(rad, r#"input x Real unit="rad""#, 0.1).to_bits(), 0.1_f64.to_bits());
        assert_eq!(converted(rad, "input x Real", 0.1), 0.1);
        assert_eq!(converted("output x Integer", r#"input x Real unit="N""#, 3.0), 3.0);
    }

    #[test]
    fn what_does_not_fit_is_refused_and_never_left_out() {
        for (from, to, expected) in [
            (r#"output x Real unit="rad""#, r#"input x Real unit="N""#, "rad cannot be converted to N"),
            ("output x Real", "input x Integer", "one is Real, the other Integer"),
            ("output x Boolean", "input x Real", "one is Boolean, the other Real"),
            ("output x String", "input x Integer", "one is String, the other Integer"),
            ("output x Real", "input x Enumeration", "one is Real, the other Enumeration"),
        ] {
            let message = wire(from, to).unwrap_err().to_string();
            assert!(message.starts_with("A.x and B.x have one name") && message.contains(expected), "{message}");
        }
        let text = wire("output x String", "input x String").unwrap();
        assert_eq!((text.wires.len(), text.remarks.len()), (0, 1));
        let unknown = wire(r#"output x Real unit="bushel""#, r#"input x Real unit="rad""#).unwrap();
        assert!(unknown.remarks[0].starts_with("A.x → B.x: in bushel and rad, which the FMUs do not define"));
        let same = wire(r#"output x Real unit="bushel""#, r#"input x Real unit="bushel""#).unwrap();
        assert_eq!((same.wires.len(), same.remarks.len()), (1, 1));
        assert!(same.remarks[0].contains("(bushel): the values of 1 connection pass as they are"), "{same:?}");
    }
}

//! Parameter sets (SSV), mappings of their names, enumerations and units.

use super::{credit, describe};
use crate::ssp::namespace;
use crate::ssp::parameters::{ParameterSet, ParameterValue, Reference};
use crate::ssp::structure::{Mapping, MappingEntry};
use crate::ssp::xml::{Attributes, Xml, number};
use fmi2_import::Value;
use fmi2_import::description::{BASE_UNITS, Item, Unit};

/// The text of an `.ssv` file.
#[must_use]
pub fn parameter_set(set: &ParameterSet) -> String {
    let mut root = vec![("xmlns:ssc", namespace::SSC.to_owned()), ("xmlns:ssv", namespace::SSV.to_owned())];
    root.extend(set_attributes(set));
    Xml::document("ssv:ParameterSet", &root, |xml| set_content(xml, set))
}

/// Which parameters of a set mean which of the system.
pub(super) fn parameter_mapping(xml: &mut Xml, mapping: &Mapping) {
    match mapping {
        Mapping::File(source) => xml.empty("ssd:ParameterMapping", &[("source", source.clone())]),
        Mapping::Inline(entries) => xml.element("ssd:ParameterMapping", &[], |xml| {
            let root = [("xmlns:ssm", namespace::SSM.to_owned()), ("version", "1.0".to_owned())];
            xml.element("ssm:ParameterMapping", &root, |xml| {
                for entry in entries {
                    mapping_entry(xml, entry);
                }
            });
        }),
    }
}

fn mapping_entry(xml: &mut Xml, entry: &MappingEntry) {
    let attributes = [("source", entry.source.clone()), ("target", entry.target.clone())];
    match entry.linear {
        None => xml.empty("ssm:MappingEntry", &attributes),
        Some((factor, offset)) => xml.element("ssm:MappingEntry", &attributes, |xml| {
            xml.empty("ssc:LinearTransformation", &[("factor", number(factor)), ("offset", number(offset))]);
        }),
    }
}

/// The attributes of a parameter set.
pub(super) fn set_attributes(set: &ParameterSet) -> Attributes<'static> {
    let mut attributes = vec![("version", "1.0".to_owned()), ("name", set.name.clone())];
    describe(&mut attributes, set.description.as_ref());
    credit(&mut attributes, &set.origin);
    attributes
}

/// Parameters, and the units and enumerations that they refer to.
pub(super) fn set_content(xml: &mut Xml, set: &ParameterSet) {
    xml.element("ssv:Parameters", &[], |xml| {
        for parameter in &set.parameters {
            xml.element("ssv:Parameter", &[("name", parameter.name.clone())], |xml| parameter_value(xml, parameter));
        }
    });
    if !set.enumerations.is_empty() {
        xml.element("ssv:Enumerations", &[], |xml| {
            for (name, items) in &set.enumerations {
                enumeration(xml, name, items);
            }
        });
    }
    units(xml, "ssv:Units", &set.units);
}

fn parameter_value(xml: &mut Xml, ParameterValue { value, refers_to, .. }: &ParameterValue) {
    let element = match (value, refers_to) {
        (_, Reference::Enumeration(_)) => "ssv:Enumeration",
        (Value::Real(_), _) => "ssv:Real",
        (Value::Integer(_), _) => "ssv:Integer",
        (Value::Boolean(_), _) => "ssv:Boolean",
        (Value::Text(_), _) => "ssv:String",
    };
    let text = if let Value::Real(value) = value { number(*value) } else { value.to_string() };
    let mut attributes = vec![("value", text)];
    match refers_to {
        Reference::Nothing | Reference::Enumeration(None) => {}
        Reference::Unit(unit) => attributes.push(("unit", unit.clone())),
        Reference::Enumeration(Some(name)) => attributes.push(("name", name.clone())),
    }
    xml.empty(element, &attributes);
}

fn enumeration(xml: &mut Xml, name: &str, items: &[Item]) {
    xml.element("ssc:Enumeration", &[("name", name.into())], |xml| {
        for item in items {
            xml.empty("ssc:Item", &[("name", item.name.clone()), ("value", item.value.to_string())]);
        }
    });
}

/// The units that connectors or parameters refer to.
pub(super) fn units(xml: &mut Xml, element: &str, units: &[Unit]) {
    if units.is_empty() {
        return;
    }
    xml.element(element, &[], |xml| {
        for unit in units {
            xml.element("ssc:Unit", &[("name", unit.name.clone())], |xml| {
                let exponents = BASE_UNITS.iter().zip(unit.exponents);
                let mut attributes: Attributes<'_> = exponents
                    .filter(|(_, exponent)| *exponent != 0)
                    .map(|(name, exponent)| (*name, exponent.to_string()))
                    .collect();
                if unit.factor != 1.0 {
                    attributes.push(("factor", number(unit.factor)));
                }
                if unit.offset != 0.0 {
                    attributes.push(("offset", number(unit.offset)));
                }
                xml.empty("ssc:BaseUnit", &attributes);
            });
        }
    });
}

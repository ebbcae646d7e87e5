//! `<SimpleType>` and `<ScalarVariable>`.

use std::collections::HashMap;
use std::sync::Arc;

use super::{Result, flag};
use crate::description::{
    BaseType, Causality, DescriptionError, Initial, Item, RealAttributes, TypeDefinition, Variability, Variable,
    VariableType,
};
use crate::xml::{Element, choice, elements, line, needed, number, optional, required, truth};

pub(super) fn type_definition<'a>(node: impl Element<'a>) -> Result<TypeDefinition> {
    let name = required(node, "name")?;
    let Some(kind_node) = type_element(node) else {
        return Err(DescriptionError::NoType { name: name.to_owned(), line: line(node) });
    };
    let items = elements(kind_node, "Item")
        .map(|item| {
            Ok(Item {
                name: required(item, "name")?.to_owned(),
                value: needed(item, "value")?,
                description: optional(item, "description"),
            })
        })
        .collect::<Result<_>>()?;
    Ok(TypeDefinition {
        name: name.to_owned(),
        description: optional(node, "description"),
        kind: variable_type(kind_node, (&[], &HashMap::new()))?,
        items,
    })
}

/// Declared types, and the index of each by its name.
pub(super) type Types<'a> = (&'a [TypeDefinition], &'a HashMap<&'a str, usize>);

pub(super) fn variable<'a>(node: impl Element<'a>, types: Types) -> Result<Variable> {
    let name = required(node, "name")?;
    let Some(kind_node) = type_element(node) else {
        return Err(DescriptionError::NoType { name: name.to_owned(), line: line(node) });
    };
    let kind = variable_type(kind_node, types)?;
    let causality = choice(node, "causality", "a causality", Causality::from_name)?.unwrap_or(Causality::Local);
    // Only reals can be continuous; for them it is the default.
    let usual = if kind.base_type() == BaseType::Real { Variability::Continuous } else { Variability::Discrete };
    let variability = choice(node, "variability", "a variability", Variability::from_name)?.unwrap_or(usual);
    let initial = choice(node, "initial", "exact, approx or calculated", Initial::from_name)?;
    let initial = initial.or_else(|| default_initial(causality, variability));
    Ok(Variable {
        name: name.to_owned(),
        value_reference: needed(node, "valueReference")?,
        description: optional(node, "description"),
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

fn variable_type<'a>(node: impl Element<'a>, (types, by_name): Types) -> Result<VariableType> {
    let declared = node.attribute("declaredType").and_then(|name| by_name.get(name).copied());
    let base = declared.map(|index| &types[index].kind);
    Ok(match node.name() {
        "Real" => {
            let empty = RealAttributes::default();
            let inherited = match base {
                Some(VariableType::Real(real)) => real,
                _ => &empty,
            };
            VariableType::Real(RealAttributes {
                start: number(node, "start")?,
                unit: optional(node, "unit").or_else(|| inherited.unit.clone()),
                display_unit: optional(node, "displayUnit").or_else(|| inherited.display_unit.clone()),
                quantity: optional(node, "quantity").or_else(|| inherited.quantity.clone()),
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
        "Boolean" => VariableType::Boolean { start: truth(node, "start")? },
        "Enumeration" => VariableType::Enumeration {
            declared_type: declared,
            items: declared.map(|index| Arc::clone(&types[index].items)).unwrap_or_default(),
            start: number(node, "start")?,
        },
        _ => VariableType::String { start: optional(node, "start") },
    })
}

fn type_element<'a, N: Element<'a>>(node: N) -> Option<N> {
    node.children().find(|child| BaseType::from_name(child.name()).is_some())
}

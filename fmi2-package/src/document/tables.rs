//! Tables of the page: variables by causality, enumerations, units, capabilities.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use fmi2_export::packaging::{BASE_UNITS, Interface, Kind, VariableFacts, in_base_units, log_categories};
use fmi2_export::{Causality, Unit, Variability};
use quick_xml::escape::escape;

use super::states;

/// Heading and remark of each group of variables, in the order of the page.
const GROUPS: [(Causality, Option<Variability>, &str, &str); 5] = [
    (Causality::Input, None, "Inputs", "Set by the importing tool before each step."),
    (
        Causality::Output,
        None,
        "Outputs",
        "Computed by the model. “Follows” names the inputs that an output follows at once, \
     without a step in between.",
    ),
    (Causality::Local, None, "Local variables", "Computed by the model, for looking at."),
    (Causality::Parameter, Some(Variability::Tunable), "Tunable parameters", "Can be changed at any time."),
    (Causality::Parameter, Some(Variability::Fixed), "Parameters", "Can be set until initialization mode is left."),
];

/// All variables.
pub fn variables(html: &mut String, interface: &Interface) {
    html.push_str("<h2 id=\"variables\">Variables</h2>\n");
    for (causality, variability, heading, remark) in GROUPS {
        let belongs = |v: &&VariableFacts| {
            v.causality == causality
                && variability.is_none_or(|variability| v.variability == variability)
                && !states::has(v)
        };
        let group: Vec<&VariableFacts> = interface.variables.iter().filter(belongs).collect();
        if group.is_empty() {
            continue;
        }
        let columns = Columns {
            range: group.iter().any(|variable| !range(variable).is_empty()),
            start: matches!(causality, Causality::Input | Causality::Parameter),
        };
        let range = if columns.range { "<th scope=\"col\">Range</th>" } else { "" };
        let start = if columns.start { "<th scope=\"col\">Start</th>" } else { "" };
        let _ = writeln!(
            html,
            "<h3>{heading}</h3>\n<p>{remark}</p>\n<table class=\"variables\">\n<thead><tr><th scope=\"col\">Name</th>\
             <th scope=\"col\">Description</th><th scope=\"col\">Unit</th>{range}{start}</tr></thead>\n\
             <tbody>"
        );
        for variable in group {
            row(html, variable, columns);
        }
        html.push_str("</tbody>\n</table>\n");
    }
    states::table(html, interface);
    enumerations(html, interface);
}

/// Columns that only some groups have.
#[derive(Clone, Copy)]
pub struct Columns {
    pub range: bool,
    pub start: bool,
}

pub fn row(html: &mut String, variable: &VariableFacts, columns: Columns) {
    let direct: Vec<&str> = variable.depends_on.iter().map(|(input, _)| input.as_str()).collect();
    let _ = write!(
        html,
        "<tr><th scope=\"row\" class=\"name\"><code>{}</code></th><td class=\"description\">{}",
        escape(&variable.name),
        escape(&variable.description)
    );
    if !direct.is_empty() {
        let _ = write!(html, " <span class=\"direct\">Follows <code>{}</code></span>", escape(direct.join(", ")));
    }
    if variable.is_state {
        html.push_str(" <span class=\"state\">Continuous state</span>");
    }
    let _ = write!(html, "</td><td class=\"unit\">{}</td>", escape(unit(variable)));
    if columns.range {
        let _ = write!(html, "<td class=\"range\" data-label=\"Range\">{}</td>", escape(range(variable)));
    }
    if columns.start {
        let _ = write!(html, "<td class=\"start\" data-label=\"Start\">{}</td>", start(variable));
    }
    html.push_str("</tr>\n");
}

/// The unit, or for a variable without one its type.
fn unit(variable: &VariableFacts) -> String {
    match (&variable.unit, variable.kind) {
        (Some(unit), _) => unit.name().to_owned(),
        (None, Kind::Real) => "1".to_owned(),
        (None, Kind::Integer) => "Integer".to_owned(),
        (None, Kind::Boolean) => "Boolean".to_owned(),
        (None, Kind::String) => "String".to_owned(),
        (None, Kind::Enumeration(kind)) => kind.name.to_owned(),
    }
}

fn range(variable: &VariableFacts) -> String {
    if let Kind::Enumeration(kind) = variable.kind {
        return format!("1 … {}", kind.items.len());
    }
    match (variable.min, variable.max) {
        (Some(min), Some(max)) => format!("{} … {}", exact(min), exact(max)),
        (Some(min), None) => format!("≥ {}", exact(min)),
        (None, Some(max)) => format!("≤ {}", exact(max)),
        (None, None) => String::new(),
    }
}

/// The start value, with the name of the item or the value in the display unit beside it.
fn start(variable: &VariableFacts) -> String {
    let Some(start) = &variable.start else { return String::new() };
    let given = match (variable.kind, start.parse()) {
        (Kind::Real, Ok(value)) => exact(value),
        _ => start.clone(),
    };
    let mut html = format!("<code>{}</code>", escape(given));
    let shown = match (variable.kind, &variable.display_unit) {
        (Kind::Enumeration(kind), _) => {
            let index = start.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
            index.and_then(|index| kind.items.get(index)).map(|(name, _)| (*name).to_owned())
        }
        (Kind::Real, Some(display)) => start
            .parse::<f64>()
            .ok()
            .filter(|value| *value != 0.0)
            .map(|value| format!("{} {}", significant(value * display.factor), display.name)),
        _ => None,
    };
    if let Some(shown) = shown {
        let _ = write!(html, " <span class=\"shown\">({})</span>", escape(&shown));
    }
    html
}

/// The shortest text that reads back as the same number, in the usual notation: `0`, `0.3`, `1e9`.
fn exact(value: f64) -> String {
    if value == 0.0 || (1e-4..1e5).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

/// A number rounded to six digits for readers.
fn significant(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

fn enumerations(html: &mut String, interface: &Interface) {
    for kind in &interface.enumerations {
        let _ = writeln!(
            html,
            "<h3>Enumeration <code>{}</code></h3>\n<p>{}</p>\n<table class=\"items\">\n<thead><tr>\
             <th scope=\"col\">Value</th><th scope=\"col\">Item</th><th scope=\"col\">Description</th></tr></thead>\n<tbody>",
            escape(kind.name),
            escape(kind.description)
        );
        for (i, (name, description)) in kind.items.iter().enumerate() {
            let _ = writeln!(
                html,
                "<tr><td>{}</td><th scope=\"row\" class=\"name\"><code>{}</code></th><td>{}</td></tr>",
                i + 1,
                escape(*name),
                escape(*description)
            );
        }
        html.push_str("</tbody>\n</table>\n");
    }
}

/// Units with their SI base units and the units for display.
pub fn units(html: &mut String, interface: &Interface) {
    let mut units: BTreeMap<&str, (&Unit, BTreeMap<&str, f64>)> = BTreeMap::new();
    for variable in &interface.variables {
        let Some(unit) = &variable.unit else { continue };
        let (_, shown) = units.entry(unit.name()).or_insert((unit, BTreeMap::new()));
        shown.extend(variable.display_unit.as_ref().map(|display| (display.name.as_str(), display.factor)));
    }
    if units.is_empty() {
        return;
    }
    html.push_str(
        "<h3>Units</h3>\n<table class=\"units\">\n<thead><tr><th scope=\"col\">Unit</th><th scope=\"col\">In base units</th>\
         <th scope=\"col\">Shown as</th></tr></thead>\n<tbody>\n",
    );
    for (name, (unit, shown)) in units {
        let shown: Vec<String> =
            shown.iter().map(|(name, factor)| format!("{} {name}", significant(*factor))).collect();
        let shown = if shown.is_empty() { String::new() } else { format!("1 {name} = {}", shown.join(" = ")) };
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\" class=\"name\"><code>{}</code></th><td>{}</td><td>{}</td></tr>",
            escape(name),
            base_units(unit),
            escape(&shown)
        );
    }
    html.push_str("</tbody>\n</table>\n");
}

fn base_units(unit: &Unit) -> String {
    let (exponents, factor, offset) = in_base_units(unit);
    let mut parts = Vec::new();
    if factor.to_bits() != 1.0_f64.to_bits() {
        parts.push(significant(factor).to_string());
    }
    for (name, exponent) in BASE_UNITS.iter().zip(exponents).filter(|(_, exponent)| *exponent != 0) {
        let power = exponent.to_string().replace('-', "\u{2212}");
        parts.push(if exponent == 1 { (*name).to_owned() } else { format!("{name}<sup>{power}</sup>") });
    }
    let mut text = if parts.is_empty() { "1".to_owned() } else { parts.join("\u{2009}·\u{2009}") };
    if offset != 0.0 {
        let _ = write!(text, ", plus {}", significant(offset));
    }
    text
}

/// The capabilities in `<CoSimulation>` and `<ModelExchange>`.
pub fn capabilities(interface: &Interface) -> Vec<(&'static str, String)> {
    let yes = |can: bool| if can { "yes" } else { "no" }.to_owned();
    let categories = log_categories().collect::<Vec<_>>().join(", ");
    let mut rows = Vec::new();
    if let Some(exchange) = &interface.exchange {
        let (states, indicators) = (exchange.states.len(), exchange.event_indicators);
        let text = format!("{states} continuous states, {indicators} event indicators");
        rows.push(("Model exchange", text));
    }
    rows.extend([
        ("Variable communication step size", yes(true)),
        ("Ramps of inputs over a step", yes(interface.interpolates_inputs)),
        ("Time derivatives of outputs", if interface.has_rates { "order 1".to_owned() } else { yes(false) }),
        ("Directional derivatives", yes(interface.info.directional_derivatives)),
        ("Saving, restoring and serialising states", yes(true)),
        ("Instances in one process", "any number".to_owned()),
        ("Log categories", categories),
    ]);
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_numbers_are_short_and_exact() {
        let numbers = [
            (0.0, "0"),
            (1e9, "1e9"),
            (-1e-9, "-1e-9"),
            (99_999.5, "99999.5"),
            (1.0, "1"),
            (0.1 + 0.2, "0.30000000000000004"),
        ];
        for (value, text) in numbers {
            assert_eq!(exact(value), text);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
    }

    #[test]
    fn numbers_for_people_have_six_digits() {
        assert_eq!(significant(0.052_359_877_559_829_88 * 57.295_779_513_082_32).to_string(), "3");
        assert_eq!(significant(-1e-7 / 3.0).to_string(), "-0.0000000333333");
    }
}

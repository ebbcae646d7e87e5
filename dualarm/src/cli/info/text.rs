//! An FMU for people: facts, then a table per causality.

use std::borrow::Cow;
use std::fmt::Write;

use serde_json::Value;

use crate::cli::printable::one_line;
use crate::cli::process;

use super::document::{Capabilities, Document, Variable};

/// The largest width of lines: that of the terminal, or none if the output goes elsewhere (`| grep`).
pub fn width() -> Option<usize> {
    terminal_size::terminal_size_of(process::standard_output()).map(|(width, _)| usize::from(width.0))
}

/// The most important facts; with all variables on request.
pub fn summary(document: &Document, all: bool, width: Option<usize>) -> String {
    let version = document.model_version.as_ref().map(|version| format!(" {version}")).unwrap_or_default();
    let mut text = one_line(&format!("{}{version}", document.model_name)).into_owned() + "\n";
    if let Some(description) = &document.description {
        let _ = writeln!(text, "{}", one_line(description));
    }
    text.push('\n');
    let facts = facts(document);
    let rows = facts.into_iter().map(|(name, value)| vec![format!("  {name}"), value]).collect();
    text += &table(&[], rows, width);
    if all {
        text += "\nVariables\n";
        let rows = document.variables.iter().map(full_row).collect();
        text +=
            &table(&["name", "type", "causality", "variability", "unit", "start", "range", "description"], rows, width);
        return text;
    }
    for (causality, heading) in [("input", "Inputs"), ("output", "Outputs"), ("parameter", "Parameters")] {
        let rows: Vec<_> = document.with_causality(causality).map(|variable| row(variable, causality)).collect();
        if !rows.is_empty() {
            let header: &[&str] = match causality {
                "output" => &["name", "unit", "range", "description"],
                _ => &["name", "unit", "start", "range", "description"],
            };
            let _ = write!(text, "\n{heading}\n{}", table(header, rows, width));
        }
    }
    text
}

fn facts(document: &Document) -> Vec<(&'static str, String)> {
    let mut facts = vec![
        ("file", format!("{}, {:.2} MB", document.file.display(), document.bytes as f64 / 1e6)),
        ("FMI", format!("{}, {}", document.fmi_version, document.interfaces.join(" and "))),
    ];
    let made =
        [&document.generation_tool, &document.generation_date].into_iter().flatten().cloned().collect::<Vec<_>>();
    let optional = [
        ("made by", Some(made.join(", ")).filter(|made| !made.is_empty())),
        ("author", document.author.clone()),
        ("copyright", document.copyright.clone()),
        ("licence", document.license.clone()),
    ];
    facts.extend(optional.into_iter().filter_map(|(name, value)| Some((name, value?))));
    facts.push(("GUID", document.guid.clone()));
    let platforms = if document.platforms.is_empty() { "none".into() } else { document.platforms.join(", ") };
    let extras = [("sources", document.has_sources), ("documentation", document.has_documentation)];
    let extras: Vec<_> = extras.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect();
    facts.push(("libraries for", platforms));
    if !extras.is_empty() {
        facts.push(("also has", extras.join(", ")));
    }
    let needs_tool = document.capabilities.as_ref().is_some_and(|capabilities| capabilities.needs_execution_tool);
    let runs_here = match &document.obstacle {
        Some(obstacle) => format!("no: {obstacle}"),
        None if needs_tool => "if the tool it was made with is installed".into(),
        None => "yes".into(),
    };
    facts.push(("runs here", runs_here));
    if document.obstacle.is_none() && !document.was_loaded {
        facts.push(("", "judged by the library file alone; --load tries it".into()));
    }
    if needs_tool {
        facts.push(("needs", "the tool it was made with".into()));
    }
    if let Some(capabilities) = &document.capabilities {
        facts.push(("can", capable(capabilities)));
    }
    if document.interfaces.contains(&"model exchange") {
        let (states, indicators) = (document.continuous_states, document.event_indicators);
        facts.push((
            "equations",
            format!("{}, {}", count(states, "state"), count(indicators as usize, "event indicator")),
        ));
    }
    facts.push(("default run", default_run(document)));
    facts.push(("variables", counts(document)));
    facts
}

fn capable(capabilities: &Capabilities) -> String {
    let order = capabilities.max_output_derivative_order;
    let derivatives = format!("output derivatives up to order {order}");
    let can = [
        ("steps of any size", capabilities.can_handle_variable_communication_step_size),
        ("input derivatives", capabilities.can_interpolate_inputs),
        (derivatives.as_str(), order > 0),
        ("saved states", capabilities.can_get_and_set_fmu_state && !capabilities.can_serialize_fmu_state),
        ("saved states, also as bytes", capabilities.can_serialize_fmu_state),
        ("directional derivatives", capabilities.provides_directional_derivative),
        ("asynchronous steps", capabilities.can_run_asynchronously),
        ("only one instance per process", capabilities.can_be_instantiated_only_once_per_process),
    ];
    let can: Vec<_> = can.into_iter().filter(|(_, can)| *can).map(|(name, _)| name).collect();
    if can.is_empty() { "steps of equal size, and nothing optional".into() } else { can.join(", ") }
}

fn default_run(document: &Document) -> String {
    let experiment = &document.default_experiment;
    let parts = [
        experiment.start.map(|start| format!("from {start} s")),
        experiment.stop.map(|stop| format!("to {stop} s")),
        experiment.step.map(|step| format!("step {step} s")),
        experiment.tolerance.map(|tolerance| format!("tolerance {tolerance:e}")),
    ];
    let parts: Vec<_> = parts.into_iter().flatten().collect();
    if parts.is_empty() { "not given".into() } else { parts.join(", ") }
}

fn counts(document: &Document) -> String {
    let causalities = [
        ("input", "input"),
        ("output", "output"),
        ("parameter", "parameter"),
        ("calculatedParameter", "calculated parameter"),
        ("local", "internal one"),
        ("independent", "independent one"),
    ];
    let counts: Vec<_> = causalities
        .into_iter()
        .map(|(causality, name)| (document.with_causality(causality).count(), name))
        .filter(|(number, _)| *number > 0)
        .map(|(number, name)| count(number, name))
        .collect();
    if counts.is_empty() { "none".into() } else { counts.join(", ") }
}

fn count(number: usize, name: &str) -> String {
    format!("{number} {name}{}", if number == 1 { "" } else { "s" })
}

fn row(variable: &Variable, causality: &str) -> Vec<String> {
    let mut row = vec![variable.name.clone(), unit(variable)];
    if causality != "output" {
        row.push(variable.start.as_ref().map(shown).unwrap_or_default());
    }
    row.extend([range(variable), description(variable)]);
    row
}

fn full_row(variable: &Variable) -> Vec<String> {
    vec![
        variable.name.clone(),
        variable.kind.into(),
        variable.causality.into(),
        variable.variability.into(),
        unit(variable),
        variable.start.as_ref().map(shown).unwrap_or_default(),
        range(variable),
        description(variable),
    ]
}

fn unit(variable: &Variable) -> String {
    variable.unit.clone().unwrap_or_default()
}

fn description(variable: &Variable) -> String {
    let items = match &variable.declared_type {
        _ if !variable.items.is_empty() => format!(" ({})", variable.items.join(", ")),
        Some(name) => format!(" (of type {name}, --json lists its items)"),
        None => String::new(),
    };
    format!("{}{items}", variable.description.as_deref().unwrap_or_default()).trim_start().to_owned()
}

/// A value without JSON's quotation marks; large and small numbers with an exponent.
fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) => match number.as_f64() {
            Some(value) if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) => format!("{value:e}"),
            Some(value) => value.to_string(),
            None => number.to_string(),
        },
        other => other.to_string(),
    }
}

fn range(variable: &Variable) -> String {
    match (&variable.min, &variable.max) {
        (None, None) => String::new(),
        (Some(min), None) => format!(">= {}", shown(min)),
        (None, Some(max)) => format!("<= {}", shown(max)),
        (Some(min), Some(max)) => format!("{} .. {}", shown(min), shown(max)),
    }
}

/// Rows in aligned columns. A text that does not fit into `width` continues in the last column on further lines.
pub fn table(header: &[&str], mut rows: Vec<Vec<String>>, width: Option<usize>) -> String {
    const GAP: usize = 2;
    /// Narrower than this a column is no help any more.
    const LEAST: usize = 24;
    /// Cells that are wider stick out of their column instead of pushing all others aside.
    const WIDEST: usize = 60;
    if !header.is_empty() {
        rows.insert(0, header.iter().map(|&heading| heading.to_owned()).collect());
    }
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    for cell in rows.iter_mut().flatten() {
        if let Cow::Owned(shown) = one_line(cell) {
            *cell = shown;
        }
    }
    let widths_of = |column: usize| rows.iter().map(move |row| row[column].chars().count());
    let wide = |column: usize| widths_of(column).filter(|width| *width <= WIDEST).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(wide).collect();
    let indent: usize = widths.iter().take(columns.saturating_sub(1)).map(|width| width + GAP).sum();
    let room = width.map_or(usize::MAX, |width| width.saturating_sub(indent).max(LEAST));
    let mut text = String::new();
    for (index, row) in rows.iter().enumerate() {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(&widths).take(columns - 1) {
            line += cell;
            line += &" ".repeat(width.saturating_sub(cell.chars().count()) + GAP);
        }
        for (part, words) in wrapped(&row[columns - 1], room).into_iter().enumerate() {
            if part > 0 {
                line = " ".repeat(indent);
            }
            let _ = writeln!(text, "{}", format!("{line}{words}").trim_end());
        }
        if index == 0 && !header.is_empty() {
            let rules: Vec<_> = widths.iter().map(|width| "─".repeat((*width).min(room))).collect();
            let _ = writeln!(text, "{}", rules.join(&" ".repeat(GAP)));
        }
    }
    text
}

/// The lines of a text that is broken between words.
fn wrapped(text: &str, room: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("there is always a line");
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() <= room {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_aligned_and_wrap_in_the_last_column() {
        let rows = vec![
            vec!["theta1".into(), "rad".into(), "Angle of the first hub, from the rest position".into()],
            vec!["y".into(), String::new(), "Short".into()],
        ];
        let narrow = table(&["name", "unit", "description"], rows.clone(), Some(40));
        let lines: Vec<_> = narrow.lines().collect();
        assert!(lines.iter().all(|line| line.chars().count() <= 40), "{narrow}");
        assert_eq!(lines[2], "theta1  rad   Angle of the first hub,");
        assert_eq!(lines[3], "              from the rest position");
        assert_eq!(lines[4], "y             Short");
        let wide = table(&["name", "unit", "description"], rows, None);
        assert_eq!(wide.lines().count(), 4);
    }

    #[test]
    fn values_are_shown_as_people_write_them() {
        let shown = [0.3, 1e-9, 1e9, 0.0, 250_000.0].map(|value| shown(&Value::from(value)));
        assert_eq!(shown, ["0.3", "1e-9", "1e9", "0", "250000"]);
    }
}

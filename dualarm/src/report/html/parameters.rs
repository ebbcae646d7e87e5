//! How the runs of the page were made: the parameters of their models.

use std::fmt::Write;

use super::markup::escape;
use super::run::Run;
use crate::report::parameters::{ModelParameters, ReportedParameter};
use fmi2_import::Value;

/// How the runs were made: the notes of each, the differences from the defaults, and every parameter of every model.
#[must_use]
pub fn all(runs: &[Run], setup: &str) -> String {
    let mut html = if setup.is_empty() { String::new() } else { format!("<p>{}</p>", escape(setup)) };
    if runs.iter().any(|run| !run.notes.is_empty()) {
        html += "<ul class=\"runs\">";
        for (index, run) in runs.iter().enumerate().filter(|(_, run)| !run.notes.is_empty()) {
            let notes = escape(&run.notes.join(" "));
            let title = escape(&run.title);
            let _ = write!(html, "<li><i class=\"swatch run-{index}\"></i><b>{title}</b>: {notes}</li>");
        }
        html += "</ul>";
    }
    html += &changed(runs);
    let mut shown: Vec<&ModelParameters> = Vec::new();
    for run in runs {
        for model in &run.models {
            if shown.contains(&model) {
                continue;
            }
            let is_again = shown.iter().any(|other| other.model == model.model);
            shown.push(model);
            let of = if is_again { format!(" in the run of {}", run.title) } else { String::new() };
            html += &all_of(model, &of);
        }
    }
    if html.is_empty() {
        return html;
    }
    format!(
        "<section aria-labelledby=\"parameters-title\"><h2 id=\"parameters-title\">How it was run</h2>{html}</section>"
    )
}

/// The parameters that do not have their default values, in the runs where that is so.
fn changed(runs: &[Run]) -> String {
    let mut rows: Vec<(&str, &ReportedParameter, Vec<Option<&Value>>)> = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        for model in &run.models {
            for parameter in model.changed() {
                let known = rows.iter().position(|(name, row, _)| *name == model.model && row.name == parameter.name);
                let place = known.unwrap_or_else(|| {
                    rows.push((&model.model, parameter, vec![None; runs.len()]));
                    rows.len() - 1
                });
                rows[place].2[index] = Some(&parameter.value);
            }
        }
    }
    let are_known = runs.iter().any(|run| !run.models.is_empty());
    if rows.is_empty() {
        return if are_known { "<p>Every parameter has its default value.</p>".into() } else { String::new() };
    }
    let mut html = String::from(
        "<h3>What differs from the defaults</h3><div class=\"wide\" tabindex=\"0\" role=\"region\" \
         aria-label=\"Parameters that differ from their defaults\"><table class=\"changed\"><thead><tr><th scope=\"col\">Name</th>\
         <th scope=\"col\">Default</th>",
    );
    for (index, run) in runs.iter().enumerate() {
        let title = if runs.len() == 1 { "Here".into() } else { escape(&run.title) };
        let _ = write!(html, "<th scope=\"col\"><i class=\"swatch run-{index}\"></i>{title}</th>");
    }
    html += "<th scope=\"col\">Unit</th><th scope=\"col\">Meaning</th></tr></thead><tbody>";
    for (model, ReportedParameter { name, default, unit, description, .. }, values) in rows {
        let default = default.as_ref().map(shown).unwrap_or_default();
        let _ = write!(
            html,
            "<tr><th scope=\"row\"><code>{}</code> <span class=\"soft\">{}</span></th><td>{}</td>",
            escape(name),
            escape(model),
            escape(&default)
        );
        for value in values {
            let text = value.map_or_else(|| "–".to_owned(), |value| format!("<b>{}</b>", escape(&shown(value))));
            let _ = write!(html, "<td>{text}</td>");
        }
        let unit = unit.as_deref().unwrap_or_default();
        let _ = write!(html, "<td>{}</td><td class=\"text\">{}</td></tr>", escape(unit), escape(description));
    }
    html += "</tbody></table></div>";
    if runs.len() > 1 {
        html += "<p class=\"soft\">–: as by default, or the model is not in that run.</p>";
    }
    html
}

/// At most this many parameters of one model are listed.
const MOST: usize = 1000;

/// A model's parameters, folded.
fn all_of(model: &ModelParameters, of: &str) -> String {
    let mut html = format!(
        "<details><summary>{}<span class=\"soft\">{}</span></summary><p>{}</p><div class=\"wide\" tabindex=\"0\" \
         role=\"region\" aria-label=\"Parameters of {0}{1}\"><table class=\"parameters\"><thead><tr><th scope=\"col\">\
         Name</th><th scope=\"col\">Value</th><th scope=\"col\">Unit</th><th scope=\"col\">Meaning</th></tr></thead>\
         <tbody>",
        escape(&model.model),
        escape(of),
        escape(&model.description)
    );
    for ReportedParameter { name, value, unit, description, .. } in model.parameters.iter().take(MOST) {
        let unit = unit.as_deref().unwrap_or_default();
        let cells = [shown(value).as_str(), unit, description].map(|cell| format!("<td>{}</td>", escape(cell)));
        let _ = write!(html, "<tr><th scope=\"row\"><code>{}</code></th>{}</tr>", escape(name), cells.concat());
    }
    html += "</tbody></table></div>";
    if let Some(more) = model.parameters.len().checked_sub(MOST).filter(|more| *more > 0) {
        let _ = write!(html, "<p class=\"soft\">… and {more} more.</p>");
    }
    html + "</details>"
}

/// A value as people write it.
fn shown(value: &Value) -> String {
    match value {
        Value::Real(value) => real(*value),
        other => other.to_string(),
    }
}

/// The shortest digits that read back exactly, with an exponent where there would be many zeros.
fn real(value: f64) -> String {
    let size = value.abs();
    let text = if value == 0.0 || (1e-4..1e6).contains(&size) { format!("{value}") } else { format!("{value:e}") };
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exact() {
        assert_eq!(
            [0.0, 0.115, -2.1, 0.0073, 1e-6, 2.5e9].map(real),
            ["0", "0.115", "−2.1", "0.0073", "1e−6", "2.5e9"]
        );
    }
}

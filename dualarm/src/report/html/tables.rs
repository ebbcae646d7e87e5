//! The tables of the page: metrics side by side, and the parameters of every model.

use std::fmt::Write;

use super::markup::escape;
use crate::grasp::matrix::Matrix;
use crate::grasp::metrics::{EffortMetrics, ForceMetrics};
use crate::report::figures::Outcome;
use crate::report::figures::text::number;
use crate::report::matrix::{LEGEND, figure};
use crate::report::parameters::{ModelParameters, Parameter};
use fmi2_import::Value;

/// The matrix of controllers and cases, as a section of the page.
#[must_use]
pub fn matrix(matrix: &Matrix) -> String {
    format!(
        "<section aria-labelledby=\"matrix-title\"><h2 id=\"matrix-title\">Who settles, and when</h2>\
         <div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Controllers in all cases\">{}</div>\
         <p class=\"soft\">{} All numbers: <a href=\"matrix.md\">matrix.md</a>, <a href=\"matrix.csv\">matrix.csv</a>.</p>\
         </section>",
        figure::svg(matrix),
        escape(&LEGEND.replace('*', ""))
    )
}

/// A group of rows of the metrics table.
struct Group {
    heading: &'static str,
    rows: Vec<(String, Vec<String>)>,
}

/// The metrics, one column per controller.
#[must_use]
pub fn metrics(outcomes: &[Outcome]) -> String {
    let mut html = String::from("<table class=\"metrics\"><thead><tr><td></td>");
    for (index, outcome) in outcomes.iter().enumerate() {
        let title = escape(outcome.scenario.title);
        let _ = write!(html, "<th scope=\"col\"><span class=\"swatch run-{index}\"></span>{title}</th>");
    }
    html += "</tr></thead>";
    for Group { heading, rows } in groups(outcomes) {
        let columns = outcomes.len() + 1;
        let _ =
            write!(html, "<tbody><tr><th class=\"group\" colspan=\"{columns}\" scope=\"rowgroup\">{heading}</th></tr>");
        for (name, cells) in rows {
            let cells: Vec<String> = cells.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
            let _ = write!(html, "<tr><th scope=\"row\">{}</th>{}</tr>", escape(&name), cells.concat());
        }
        html += "</tbody>";
    }
    html + "</table>"
}

fn groups(outcomes: &[Outcome]) -> Vec<Group> {
    let row = |name: String, cell: &dyn Fn(&Outcome) -> String| (name, outcomes.iter().map(cell).collect());
    let forces = (0..2).map(|arm| {
        let force = |name: &str, cell: fn(&ForceMetrics) -> String| {
            row(name.to_owned(), &move |outcome| cell(&outcome.metrics.forces[arm]))
        };
        let mut rows = vec![
            force("settling time, ±2 % (s)", |force| seconds(force.settling_2)),
            force("settling time, ±5 % (s)", |force| seconds(force.settling_5)),
            force("overshoot (%)", |force| number(force.overshoot, 2)),
            force("steady error (mN)", |force| number(1e3 * force.steady_error, 2)),
        ];
        if arm == 0 {
            rows.insert(0, row("settling, says the paper".into(), &|outcome| unbroken(outcome.scenario.paper)));
        }
        Group { heading: ["Contact force f₁", "Contact force f₂"][arm], rows }
    });
    let controls = [("Torque τ₁", "N·m"), ("Torque τ₂", "N·m"), ("Force u", "N")];
    let efforts = controls.into_iter().enumerate().map(|(index, (heading, unit))| {
        let effort = |name: &str, cell: &dyn Fn(&EffortMetrics) -> String| {
            row(name.to_owned(), &|outcome| cell(&outcome.metrics.efforts[index]))
        };
        Group {
            heading,
            rows: vec![
                effort(&format!("peak ({unit})"), &|effort| number(effort.peak, 4)),
                effort(&format!("rms ({unit})"), &|effort| number(effort.rms, 4)),
                effort("in saturation (ms)", &|effort| {
                    effort.saturated.map_or("–".into(), |time| number(1e3 * time, 1))
                }),
            ],
        }
    });
    forces.chain(efforts).collect()
}

/// A time whose unit stays with its number where the cell is narrow.
fn unbroken(time: &str) -> String {
    time.strip_suffix(" s").map_or_else(|| time.to_owned(), |number| format!("{number}\u{a0}s"))
}

fn seconds(time: Option<f64>) -> String {
    time.map_or("not settled".into(), |time| number(time, 3))
}

/// Every model's parameters, each model once unless its values differ between the runs.
#[must_use]
pub fn parameters(outcomes: &[Outcome]) -> String {
    let mut shown: Vec<&ModelParameters> = Vec::new();
    let mut html = String::new();
    for outcome in outcomes {
        for model in &outcome.models {
            if shown.contains(&model) {
                continue;
            }
            let is_again = shown.iter().any(|other| other.model == model.model);
            shown.push(model);
            let run = if is_again { format!(" in the run of {}", outcome.scenario.title) } else { String::new() };
            let _ = write!(
                html,
                "<details><summary>{}<span class=\"soft\">{}</span></summary><p>{}</p><div class=\"wide\" tabindex=\"0\" \
                 role=\"region\" aria-label=\"Parameters of {0}\"><table class=\"parameters\"><thead><tr><th scope=\"col\">\
                 Name</th><th scope=\"col\">Value</th><th scope=\"col\">Unit</th><th scope=\"col\">Meaning</th></tr></thead>\
                 <tbody>",
                escape(&model.model),
                escape(&run),
                escape(&model.description)
            );
            for Parameter { name, value, unit, description } in &model.parameters {
                let value = match value {
                    Value::Real(value) => real(*value),
                    other => other.to_string(),
                };
                let unit = unit.as_deref().unwrap_or_default();
                let cells = [value.as_str(), unit, description].map(|cell| format!("<td>{}</td>", escape(cell)));
                let _ = write!(html, "<tr><th scope=\"row\"><code>{}</code></th>{}</tr>", escape(name), cells.concat());
            }
            html += "</tbody></table></div></details>";
        }
    }
    html
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

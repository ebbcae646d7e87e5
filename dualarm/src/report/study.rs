//! The page of a study: all its runs in one file, to look for common features.
//!
//! A scatter plot and parallel coordinates show the same runs; a click on one shows its row and the command that simulates
//! it again. The page's own markup and scripts are in `assets/report/study/`, the style sheet is that of `html`.

use serde_json::{Value, json};

use super::html::{escape, fill, head, json_in_script};
use crate::sweep::plan::Plan;
use crate::sweep::study::Range;
use crate::sweep::summary::{Group, Rate};
use crate::sweep::table::{Field, Kind, Layout, unit};

const TEMPLATE: &str = include_str!("../../assets/report/study/page.html");
const STYLE: &str = include_str!("../../assets/report/study/style.css");
const SCRIPTS: [&str; 6] = [
    include_str!("../../assets/report/theme.js"),
    include_str!("../../assets/report/study/data.js"),
    include_str!("../../assets/report/study/scatter.js"),
    include_str!("../../assets/report/study/parallel.js"),
    include_str!("../../assets/report/study/details.js"),
    include_str!("../../assets/report/study/main.js"),
];

/// Rows that a page has at most: a browser draws so many at once.
const MOST_ROWS: u64 = 20_000;

/// The rows that a page shows: all, or every so many of them.
#[derive(Debug)]
pub struct Rows {
    stride: u64,
    columns: Vec<Vec<Value>>,
}

impl Rows {
    /// For a study of so many runs.
    #[must_use]
    pub fn new(runs: u64) -> Self {
        Self { stride: runs.div_ceil(MOST_ROWS).max(1), columns: Vec::new() }
    }

    /// Offers the next row, from 0.
    pub fn add(&mut self, index: u64, fields: &[Field]) {
        if !index.is_multiple_of(self.stride) {
            return;
        }
        self.columns.resize(fields.len(), Vec::new());
        for (column, field) in self.columns.iter_mut().zip(fields) {
            column.push(match field {
                Field::None => Value::Null,
                Field::Integer(value) => (*value).into(),
                Field::Real(value) => digits(*value),
                Field::Boolean(value) => (*value).into(),
                Field::Text(value) => value.as_str().into(),
            });
        }
    }
}

/// Six digits are enough for a figure; the file of the rows has all. A value that JSON cannot represent becomes null.
fn digits(value: f64) -> Value {
    format!("{value:.5e}").parse::<f64>().map_or(Value::Null, Value::from)
}

/// The content of the page.
pub struct Page<'a> {
    /// The study.
    pub plan: &'a Plan,
    /// The meaning of the columns.
    pub layout: &'a Layout<'a>,
    /// The rows.
    pub rows: &'a Rows,
    /// The summary of the rows.
    pub groups: &'a [Group],
    /// The command that makes a run of this study, without the run.
    pub command: &'a str,
}

/// The file's content.
#[must_use]
pub fn html(page: &Page) -> String {
    let study = &page.plan.study;
    let runs: u64 = page.groups.iter().map(|group| group.runs).sum();
    let shown = match page.rows.stride {
        1 => format!("{runs} runs."),
        stride => format!("{runs} runs, of which every {stride}th is drawn."),
    };
    fill(TEMPLATE, |name| {
        Some(match name {
            "head" => head(&study.title, &study.description, STYLE),
            "shown" => shown.clone(),
            "summary" => summary(page.groups),
            "data" => json_in_script(&data(page)),
            "scripts" => SCRIPTS.join("\n"),
            _ => return None,
        })
    })
}

fn data(page: &Page) -> Value {
    let vary = page.plan.sampler.vary();
    let role = |name: &str| match name {
        "run" | "draw" | "controller" | "status" | "error" | "success" => name.to_owned(),
        _ if vary.iter().any(|varied| varied.name == name) => "parameter".into(),
        _ => "figure".into(),
    };
    let logarithmic =
        |name: &str| vary.iter().any(|varied| varied.name == name && matches!(varied.range, Range::Logarithmic { .. }));
    let columns = page.layout.columns().iter().enumerate().map(|(index, column)| {
        json!({
            "name": column.name,
            "role": role(&column.name),
            "number": matches!(column.kind, Kind::Integer | Kind::Real),
            "unit": unit(&column.name),
            "log": logarithmic(&column.name),
            "values": page.rows.columns.get(index).cloned().unwrap_or_default(),
        })
    });
    json!({ "command": page.command, "columns": columns.collect::<Vec<_>>() })
}

/// The table of controllers.
fn summary(groups: &[Group]) -> String {
    let row = |group: &Group| {
        let name = escape(group.controller.as_deref().unwrap_or("all runs"));
        let success = group.success_rate.map_or_else(
            || "–".to_owned(),
            |Rate { share, low, high }| format!("{:.1} % ({:.1} – {:.1} %)", 100.0 * share, 100.0 * low, 100.0 * high),
        );
        let Group { runs, failed, .. } = group;
        format!("<tr><th scope=\"row\">{name}</th><td>{runs}</td><td>{failed}</td><td>{success}</td></tr>")
    };
    let rows: String = groups.iter().map(row).collect();
    format!(
        "<table><thead><tr><th scope=\"row\">controller</th><th>runs</th><th>failed</th><th>success, 95 % interval</th></tr>\
         </thead><tbody>{rows}</tbody></table>"
    )
}

//! The outcome of a study, for users and for programs.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;
use serde_json::{Map, Value};

use crate::cli::printable::one_line;
use crate::cli::{Failure, json, width};
use crate::report::TextTable;
use crate::sweep::Row;
use crate::sweep::figures::GRASP;
use crate::sweep::plan::Plan;
use crate::sweep::summary::{Distribution, Group};
use crate::sweep::table::{Field, Layout};

/// The outcome of a study.
pub struct Outcome<'a> {
    pub plan: &'a Plan,
    pub groups: &'a [Group],
    pub output: &'a Path,
    pub state: &'a Path,
    pub report: Option<&'a Path>,
    /// How many runs were made now.
    pub done: u64,
    pub seconds: f64,
}

/// The document of `--json`; `docs/tool.md` describes the keys.
#[derive(Serialize)]
struct Document<'a> {
    command: &'static str,
    version: &'static str,
    title: &'a str,
    /// In s.
    wall_time: f64,
    runs: u64,
    simulated: u64,
    groups: &'a [Group],
    output: &'a Path,
    state: &'a Path,
    report: Option<&'a Path>,
}

#[derive(Serialize)]
struct RowDocument<'a> {
    command: &'static str,
    version: &'static str,
    row: Map<String, Value>,
    output: &'a Path,
}

/// The figures of a grasp that the terminal shows: names, headings, factors.
const SHOWN: [(&str, &str, f64); 4] = [
    ("settling_rms", "settled [s]", 1.0),
    ("overshoot", "overshoot [%]", 1.0),
    ("steady_error", "steady error [mN]", 1e3),
    ("contact_loss", "contact lost [ms]", 1e3),
];

impl Outcome<'_> {
    fn runs(&self) -> u64 {
        self.groups.iter().map(|group| group.runs).sum()
    }

    /// Prints it for machines.
    pub fn print_json(&self) -> Result<(), Failure> {
        json::print(&Document {
            command: "sweep",
            version: env!("CARGO_PKG_VERSION"),
            title: &self.plan.study.title,
            wall_time: self.seconds,
            runs: self.runs(),
            simulated: self.done,
            groups: self.groups,
            output: self.output,
            state: self.state,
            report: self.report,
        })
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{}\n{} runs, {} of them now, in {:.1} s",
            one_line(&self.plan.study.title),
            self.runs(),
            self.done,
            self.seconds
        );
        if self.done > 0 {
            let _ = write!(text, " ({:.2} ms a run)", 1e3 * self.seconds / self.done as f64);
        }
        text += "\n\n";
        text += &self.table().to_terminal(width());
        text += "\n";
        for file in [Some(self.output), self.report].into_iter().flatten() {
            let _ = writeln!(text, "{}", file.display());
        }
        text
    }

    fn table(&self) -> TextTable {
        // If there are many outputs, the user should look at the file.
        const MOST: usize = 6;
        let is_grasp = self.groups.iter().any(|group| group.figures.iter().any(|figure| figure.name == GRASP[0].0));
        let mut table = TextTable::default();
        let head = |text: &str| text.to_owned();
        table.header = vec![head("controller"), head("runs"), head("failed")];
        let has_rates = self.groups.iter().any(|group| group.success_rate.is_some());
        if has_rates {
            table.header.push(head("success, 95 % interval"));
        }
        let names: Vec<(String, String, f64)> = if is_grasp {
            SHOWN.iter().map(|(name, heading, factor)| (head(name), head(heading), *factor)).collect()
        } else {
            let figures = self.groups.first().into_iter().flat_map(|group| &group.figures);
            figures.take(MOST).map(|figure| (figure.name.clone(), figure.name.clone(), 1.0)).collect()
        };
        table.header.extend(names.iter().map(|(_, heading, _)| heading.clone()));
        for group in self.groups {
            let mut row = vec![
                group.controller.as_deref().map_or_else(|| head("–"), |title| one_line(title).into_owned()),
                group.runs.to_string(),
                group.failed.to_string(),
            ];
            if has_rates {
                // A controller without a run in a part of a study has none.
                row.push(group.success_rate.map_or_else(
                    || head("–"),
                    |rate| format!("{:.1} % ({:.1} – {:.1})", 100.0 * rate.share, 100.0 * rate.low, 100.0 * rate.high),
                ));
            }
            for (name, _, factor) in &names {
                let figure = group.figures.iter().find(|figure| figure.name == *name);
                // What has no run settles neither soon nor never.
                let figure = figure.filter(|_| group.runs > 0);
                row.push(figure.map_or_else(|| head("–"), |figure| spread(figure, *factor)));
            }
            table.rows.push(row);
        }
        table
    }
}

/// Median, and the range of nine tenths of the runs. Where a run does not settle, it never does; other figures can only be missing.
fn spread(figure: &Distribution, factor: f64) -> String {
    let missing = if figure.name.starts_with("settling") { "never" } else { "–" };
    let number = |value: Option<f64>| value.map_or_else(|| missing.to_owned(), |value| short(factor * value));
    format!("{} ({} – {})", number(figure.median), number(figure.p05), number(figure.p95))
}

/// Three digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = if size >= 100.0 {
        0
    } else if size >= 10.0 {
        1
    } else if size >= 1.0 {
        2
    } else {
        3
    };
    format!("{value:.digits$}")
}

/// One row, a line for each of its columns.
pub fn row_text(layout: &Layout, row: &Row) -> String {
    let width = layout.columns().iter().map(|column| column.name.chars().count()).max().unwrap_or_default();
    let mut text = String::new();
    for (column, field) in layout.columns().iter().zip(layout.fields(row)) {
        let value = match field {
            Field::None => "–".to_owned(),
            Field::Integer(value) => value.to_string(),
            Field::Real(value) => value.to_string(),
            Field::Boolean(value) => value.to_string(),
            Field::Text(value) => one_line(&value).into_owned(),
        };
        let _ = writeln!(text, "  {:<width$}  {value}", one_line(&column.name));
    }
    text
}

/// Prints one row for machines.
pub fn print_row_json(layout: &Layout, row: &Row, output: &Path) -> Result<(), Failure> {
    let value = |field: Field| match field {
        Field::None => Value::Null,
        Field::Integer(value) => value.into(),
        Field::Real(value) => value.into(),
        Field::Boolean(value) => value.into(),
        Field::Text(value) => value.into(),
    };
    let row =
        layout.columns().iter().zip(layout.fields(row)).map(|(column, field)| (column.name.clone(), value(field)));
    json::print(&RowDocument { command: "sweep --run", version: env!("CARGO_PKG_VERSION"), row: row.collect(), output })
}

//! `results/report.html`: the comparison as one file that needs nothing else, neither network nor server.
//!
//! The page's own markup, style and scripts are in `assets/report/`, the plotting library in `assets/uplot/`. The scripts
//! are put one after the other into one module, in the order of `SCRIPTS`: each knows those before it. Tables come
//! ready from here, so they are there without JavaScript, too; curves and the animation are drawn from the packed rows.

mod markup;
mod pack;
pub mod rows;
mod tables;

use serde_json::json;

use crate::grasp::matrix::Matrix;
use crate::grasp::metrics::Metrics;
use crate::report::figures::Outcome;
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::record::Table;
pub(crate) use markup::escape;
use markup::{fill, json_in_script};
use pack::{Packer, Scale};

const TEMPLATE: &str = include_str!("../../../assets/report/page.html");
const STYLES: [&str; 2] =
    [include_str!("../../../assets/uplot/uPlot.min.css"), include_str!("../../../assets/report/style.css")];
const LIBRARY: &str = include_str!("../../../assets/uplot/uPlot.iife.min.js");
const LICENCE: &str = include_str!("../../../assets/uplot/LICENSE");
const SCRIPTS: [&str; 11] = [
    include_str!("../../../assets/report/unpack.js"),
    include_str!("../../../assets/report/data.js"),
    include_str!("../../../assets/report/theme.js"),
    include_str!("../../../assets/report/clock.js"),
    include_str!("../../../assets/report/scene.js"),
    include_str!("../../../assets/report/plot.js"),
    include_str!("../../../assets/report/mouse.js"),
    include_str!("../../../assets/report/touch.js"),
    include_str!("../../../assets/report/charts.js"),
    include_str!("../../../assets/report/controls.js"),
    include_str!("../../../assets/report/main.js"),
];

/// The signals the page draws; what a run does not have is left out.
const SIGNALS: &[&str] = &[
    "contact_force1",
    "contact_force2",
    "theta1",
    "theta2",
    "y_object",
    "tau1",
    "tau2",
    "u",
    "energy",
    "theta1_d",
    "theta2_d",
    "y_object_d",
    "lambda2_d",
];

/// Whether the page draws a signal.
#[must_use]
pub fn wants(signal: &str) -> bool {
    SIGNALS.contains(&signal) || signal.starts_with("deflection1[") || signal.starts_with("deflection2[")
}

/// What the page shows.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// The results, in the order of the page.
    pub outcomes: &'a [Outcome],
    /// For each of them the rows that [`rows::Rows`] kept.
    pub rows: &'a [Table],
    /// The communication points of the runs.
    pub grid: &'a TimeGrid,
    /// How the runs were made, in one or two sentences.
    pub setup: &'a str,
    /// Controllers in many cases, shown first.
    pub matrix: Option<&'a Matrix>,
}

impl Page<'_> {
    /// The file's content.
    ///
    /// # Panics
    /// Never: the template and what fills it belong together.
    #[must_use]
    pub fn to_html(&self) -> String {
        fill(TEMPLATE, |name| {
            Some(match name {
                "style" => STYLES.join("\n"),
                "setup" => escape(self.setup),
                "matrix" => self.matrix.map_or_else(String::new, tables::matrix),
                "metrics" => tables::metrics(self.outcomes),
                "parameters" => tables::parameters(self.outcomes),
                "rows" => self.rows_text(),
                "data" => json_in_script(&self.data()),
                "library" => LIBRARY.to_owned(),
                "library-version" => library_version().to_owned(),
                "library-licence" => escape(LICENCE),
                "scripts" => SCRIPTS.join("\n"),
                _ => return None,
            })
        })
    }

    /// Which rows the page has, for its reader.
    fn rows_text(&self) -> String {
        let interval = rows::interval(self.grid.stop() - self.grid.start()).max(self.grid.step());
        let [step, early, interval] = [self.grid.step(), rows::EVERY_STEP_UNTIL, interval].map(milliseconds);
        format!(
            "Curves and animation hold every communication step ({step} ms) of the first {early} ms and one row per \
             {interval} ms after it, with values to a millionth of each signal\u{2019}s range; metrics are of every step, \
             and the CSV files have all digits."
        )
    }

    fn data(&self) -> serde_json::Value {
        let times = self.rows.first().map_or(&[][..], Table::times);
        // A thousandth of a step, unless that would be too many of them.
        let (start, duration) = (self.grid.start(), self.grid.stop() - self.grid.start());
        let time_scale = Scale { low: start, quantum: (1e-3 * self.grid.step()).max(duration / f64::from(1 << 30)) };
        let mut packer = Packer::new();
        packer.add_with(time_scale, times);
        let time = json!({
            "rows": times.len(),
            "columns": [column("time", time_scale)],
            "packed": packer.finish(),
        });
        let runs: Vec<_> = self.outcomes.iter().zip(self.rows).map(|(outcome, rows)| run(outcome, rows)).collect();
        let plant = self.outcomes.first().and_then(|outcome| outcome.models.first());
        let length = |name| plant.and_then(|plant| plant.real(name));
        json!({ "time": time, "arm": length("l"), "object": length("L"), "runs": runs })
    }
}

/// A time in s as ms, without the digits that only rounding puts there.
fn milliseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e3
}

/// As the library's first line says: `/*! … (v1.6.32) */`.
fn library_version() -> &'static str {
    LIBRARY.split_once("(v").and_then(|(_, rest)| rest.split_once(')')).map_or("", |(version, _)| version)
}

fn run(outcome: &Outcome, rows: &Table) -> serde_json::Value {
    let mut packer = Packer::new();
    let columns: Vec<_> = rows
        .columns()
        .iter()
        .filter_map(|signal| Some(column(&signal.name, packer.add(&rows.column(&signal.name)?))))
        .collect();
    json!({
        "key": outcome.scenario.key,
        "title": outcome.scenario.title,
        "settling": Metrics::settling_2(&outcome.metrics),
        "data": { "rows": rows.times().len(), "columns": columns, "packed": packer.finish() },
    })
}

fn column(name: &str, scale: Scale) -> serde_json::Value {
    json!({ "name": name, "low": scale.low, "quantum": scale.quantum })
}

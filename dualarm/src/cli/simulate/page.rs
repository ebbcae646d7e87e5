//! `--report`: the page of one run.

use std::io;
use std::path::Path;

use super::monitor;
use crate::cli::{Failure, report};
use crate::report::html::rows::{self, Rows};
use crate::report::html::signals::with_decades;
use crate::report::html::{self, Packed, Page};
use crate::report::parameters::ModelParameters;
use fmi2_cosim::master::Master;
use fmi2_cosim::record::{Column, Points, Sink, Table};
use fmi2_cosim::run::{Observer, Run};
use fmi2_cosim::system::System;
use grasp_merit::metrics::Metrics;

/// Follows a run together with the other observers. If there shall be a page, it keeps the page's rows and reads the models'
/// parameters.
pub struct Watch {
    /// The other observers.
    pub others: monitor::Watch,
    /// The rows of the page, which differ from those of the output.
    pub rows: Option<Rows>,
    /// The parameters of the models.
    pub models: Vec<ModelParameters>,
}

impl Watch {
    pub fn new(others: monitor::Watch, rows: Option<Rows>) -> Self {
        Self { others, rows, models: Vec::new() }
    }
}

impl Observer for Watch {
    fn begin(&mut self, master: &mut Master, columns: &[Column]) -> Vec<String> {
        let mut remarks = self.others.begin(master, columns);
        let components = if self.rows.is_some() { master.names().count() } else { 0 };
        for index in 0..components {
            match ModelParameters::of(master.instance(index)) {
                Ok(model) => self.models.push(model),
                Err(error) => remarks.push(format!("the page lacks parameters: {error}")),
            }
        }
        remarks
    }

    fn follows(&self, column: &Column) -> bool {
        self.others.follows(column)
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        self.others.points(points)
    }

    fn rows(&mut self) -> Option<&mut dyn Sink> {
        self.rows.as_mut().map(|rows| rows as &mut dyn Sink)
    }

    fn conclude(&mut self) -> Vec<String> {
        self.others.conclude()
    }
}

/// The page's rows with columns that were monitored at other times, interpolated linearly.
pub fn with_columns(rows: Table, more: Option<&Table>) -> Table {
    let Some(more) = more.filter(|more| !more.times().is_empty()) else { return rows };
    let columns = rows.columns().iter().chain(more.columns()).cloned().collect();
    let monitored: Vec<&[f64]> = (0..more.columns().len()).map(|index| more.column_at(index)).collect();
    let times = more.times();
    let mut all = Table::new(columns);
    for (time, values) in rows.rows() {
        let after = times.partition_point(|known| *known < time).min(times.len() - 1);
        let before = if times[after] > time { after.saturating_sub(1) } else { after };
        let way = times[after] - times[before];
        let share = if way > 0.0 { (time - times[before]) / way } else { 0.0 };
        let at = monitored.iter().map(|column| column[before] + share * (column[after] - column[before]));
        let row: Vec<f64> = values.into_iter().chain(at).collect();
        // Memory takes every row.
        let _ = all.row(time, &row);
    }
    with_decades(all)
}

/// A run that is over, for its page.
pub struct Made<'a> {
    pub system: &'a System,
    pub run: &'a Run,
    pub rows: Table,
    pub metrics: Option<&'a Metrics>,
    pub models: Vec<ModelParameters>,
    pub master: &'a Master,
    /// The component that the metrics judge.
    pub controller: Option<&'a str>,
    /// The verdict of `--monitor`.
    pub verdict: Option<&'a str>,
}

impl Made<'_> {
    /// Writes the page.
    pub fn write(self, path: &Path) -> Result<(), Failure> {
        let names: Vec<&str> = self.system.components.iter().map(|(name, _)| name.as_str()).collect();
        let title = self.system.title.clone().unwrap_or_else(|| names.join(" + "));
        let key = path.file_stem().map_or_else(|| "run".into(), |stem| stem.to_string_lossy().into_owned());
        let run = html::Run {
            key,
            title: self.controller.map_or_else(|| title.clone(), str::to_owned),
            paper: String::new(),
            metrics: self.metrics.cloned(),
            notes: self.notes(&names),
            rows: Packed::of(&self.rows, &self.models),
            models: self.models,
        };
        let page = Page {
            title,
            lead: self.system.description.clone(),
            rows: rows::sentence(&self.run.grid),
            runs: &[run],
            ..Page::default()
        };
        report::write(&page, path)
    }

    /// Notes on the run: models, step, settings.
    fn notes(&self, names: &[&str]) -> Vec<String> {
        let Run { grid, coupling, .. } = self.run;
        let mut notes = vec![format!(
            "{}, co-simulated by dualarm {} through their FMI 2.0 interface: step {} s, {} coupling, from {} s to {} s.",
            names.join(" with "),
            env!("CARGO_PKG_VERSION"),
            grid.step(),
            coupling.title(),
            grid.start(),
            grid.stop()
        )];
        let settings = self.master.settings();
        let set: Vec<_> = settings
            .map(|setting| {
                let unit = setting.variable.unit_in_text().map(|unit| format!(" {unit}")).unwrap_or_default();
                let value = setting.variable.with_name(setting.value.clone());
                format!("{}.{} = {value}{unit}", setting.component, setting.variable.name)
            })
            .collect();
        if !set.is_empty() {
            notes.push(format!("Set: {}.", set.join(", ")));
        }
        notes.extend(self.verdict.map(|verdict| format!("Monitored: {verdict}.")));
        notes
    }
}

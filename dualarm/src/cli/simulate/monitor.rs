//! `--monitor`: further columns, and their figure.

use std::io;
use std::path::Path;

use clap::ValueEnum;
use fmi2_cosim::files::FileSet;
use fmi2_cosim::master::Master;
use fmi2_cosim::record::{Column, Points, Sink, Table};
use fmi2_cosim::run::{Observer, Run};

use super::output::{Output, is_standard_output};
use crate::cli::Failure;
use crate::grasp::{GraspWatch, LyapunovWatch, Recorded};
use charts::chart::{Curve, Figure, Panel, palette};

/// What is monitored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MonitorName {
    /// H and its parts of (67)-(69), or those of the root-strain law, with the claimed bound
    Lyapunov,
}

/// All observers of a run.
pub struct Watch {
    pub grasp: GraspWatch,
    pub lyapunov: Option<LyapunovWatch>,
}

/// Rows during a run: they go to the output, or are kept until their further columns are known.
pub enum Rows {
    Now(Output),
    Later(Output, Table),
}

impl Watch {
    /// # Errors
    /// When the monitor lacks a signal.
    pub fn new(monitor: Option<MonitorName>, columns: &[Column], run: &Run) -> Result<Self, Failure> {
        let lyapunov = match monitor {
            None => None,
            Some(MonitorName::Lyapunov) => {
                Some(LyapunovWatch::new(columns, run.interval, run.grid.stop()).map_err(Failure::usage)?)
            }
        };
        Ok(Self { grasp: GraspWatch::default(), lyapunov })
    }

    /// The columns of the output.
    pub fn columns(&self, columns: &[Column]) -> Vec<Column> {
        let more = self.lyapunov.as_ref().map(|_| LyapunovWatch::columns()).unwrap_or_default();
        columns.iter().cloned().chain(more).collect()
    }

    /// Where rows go while the run lasts.
    pub fn rows(&self, output: Output, columns: &[Column]) -> Rows {
        match self.lyapunov {
            None => Rows::Now(output),
            Some(_) => Rows::Later(output, Table::new(columns.to_vec())),
        }
    }
}

impl Rows {
    /// The output, and the kept rows.
    pub fn parts(self) -> (Output, Option<Table>) {
        match self {
            Self::Now(output) => (output, None),
            Self::Later(output, table) => (output, Some(table)),
        }
    }
}

impl Sink for Rows {
    fn wants(&mut self, time: f64) -> bool {
        match self {
            Self::Now(output) => output.wants(time),
            Self::Later(..) => true,
        }
    }

    fn idle(&mut self) -> f64 {
        match self {
            Self::Now(output) => output.idle(),
            Self::Later(..) => f64::NEG_INFINITY,
        }
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        match self {
            Self::Now(output) => output.row(time, values),
            Self::Later(_, table) => table.row(time, values),
        }
    }
}

impl Observer for Watch {
    fn begin(&mut self, master: &mut Master, columns: &[Column]) -> Vec<String> {
        if let Some(lyapunov) = &mut self.lyapunov {
            lyapunov.begin(master, columns);
        }
        self.grasp.begin(master, columns)
    }

    fn follows(&self, column: &Column) -> bool {
        self.grasp.follows(column) || self.lyapunov.as_ref().is_some_and(|lyapunov| lyapunov.follows(column))
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        self.grasp.points(points)?;
        self.lyapunov.as_mut().map_or(Ok(()), |lyapunov| lyapunov.points(points))
    }

    fn conclude(&mut self) -> Vec<String> {
        self.grasp.conclude()
    }
}

/// Writes the kept rows with their further columns, and the figure beside the file at `path`. Returns these columns and the
/// verdict.
pub fn complete(
    lyapunov: Option<LyapunovWatch>,
    mut output: Output,
    kept: Option<Table>,
    path: Option<&Path>,
) -> Result<(Output, Option<(Table, String)>), Failure> {
    let (Some(lyapunov), Some(kept)) = (lyapunov, kept) else { return Ok((output, None)) };
    let Recorded { table, verdict } = lyapunov.finish()?;
    for ((time, values), (_, more)) in kept.rows().zip(table.rows()) {
        let all: Vec<f64> = values.into_iter().chain(more).collect();
        if let Err(error) = output.row(time, &all) {
            return Err(output.failure(error));
        }
    }
    if let Some(path) = path.filter(|path| !is_standard_output(path)) {
        let written = FileSet::new();
        written.write(path.with_extension("lyapunov.svg"), figure(&table).to_svg())?;
        written.appear()?;
    }
    Ok((output, Some((table, verdict))))
}

/// Decadic logarithms of H, its bound and its parts over time: exponentials are lines.
fn figure(table: &Table) -> Figure {
    let curve = |name: &str, label: &str, color, wide| {
        let values = table.column(name).unwrap_or_default();
        let points = table.times().iter().zip(values).filter(|(_, value)| **value > 1e-15 && value.is_finite());
        Curve { name: label.into(), color, wide, points: points.map(|(time, value)| (*time, value.log10())).collect() }
    };
    let times = table.times();
    let x_range = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(1.0));
    let panel = |curves: Vec<Curve>, y_label: &str, x_label: Option<String>| Panel {
        x_label,
        y_label: y_label.into(),
        x_range,
        curves,
        ..Panel::default()
    };
    let top = vec![
        curve("lyapunov_H", "H", palette::BLUE, false),
        curve("lyapunov_bound", "bound", palette::VERMILION, false),
    ];
    let parts = vec![
        curve("lyapunov_E", "E", palette::GREEN, false),
        curve("lyapunov_V_o", "V_o", palette::PURPLE, false),
        curve("lyapunov_V_I1", "V_I1", palette::BLUE, true),
        curve("lyapunov_V_I2", "V_I2", palette::VERMILION, true),
    ];
    Figure {
        title: "Lyapunov function along the run".into(),
        size: (760, 520),
        rows: vec![vec![panel(top, "log H", None)], vec![panel(parts, "log of its parts", Some("Time (s)".into()))]],
    }
}

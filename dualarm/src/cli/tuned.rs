//! `dualarm tune --report`: the page of a search. It shows the first case before and after, gains, every case, and the
//! progress of the search.

use std::path::Path;

use super::{Failure, report};
use crate::grasp::actuator_limits;
use crate::grasp::matrix::{Cell, Lab};
use crate::report::TextTable;
use crate::report::figures::NamedFigure;
use crate::report::html::rows::{self, Rows};
use crate::report::html::{Packed, Page, Run, tables};
use crate::report::matrix::lines;
use crate::report::parameters::ModelParameters;
use crate::tune::{Best, Task};
use charts::chart::{Curve, Figure, Panel, palette};
use charts::text::number;
use fmi2_cosim::record::Follow;
use grasp_merit::metrics::{Metrics, SIGNALS};

/// A search that is over.
pub struct Tuned<'a> {
    pub task: &'a Task,
    pub lab: &'a Lab,
    pub best: &'a Best,
    /// Of the cases, with the best gains.
    pub found: &'a [Option<Cell>],
    /// The best objective after each evaluation.
    pub history: &'a [f64],
    /// The command that repeats the search, with one option per line.
    pub command: String,
}

impl Tuned<'_> {
    /// Writes the page.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let Self { task, best, .. } = self;
        let start: Vec<f64> = task.dimensions.iter().map(|dimension| dimension.start).collect();
        let mut runs = Vec::new();
        let mut said = String::new();
        for (key, title, values) in [("start", "before", &start), ("found", "after the search", &best.values)] {
            // Gains to begin with may be so bad that nothing comes of them.
            if let Ok((run, sentence)) = self.run(key, title, values) {
                runs.push(run);
                said = sentence;
            }
        }
        let case = task.cases.first().map_or("", |case| case.scenario.title.as_str());
        let page = Page {
            title: format!("{}: gains from a search", task.contender.title),
            lead: format!(
                "Objective {} after {} evaluations, found by number {}. Shown in motion is the case \u{201c}{case}\u{201d}.",
                number(best.cost, 3),
                task.evaluations,
                best.evaluation
            ),
            runs: &runs,
            rows: said,
            tables: tables::section("Gains", &self.gains())
                + &tables::section("Cases, after the search", &self.cases())
                + &tables::command("Repeat it with", &self.command),
            figures: &[self.progress().draw()],
            ..Page::default()
        };
        report::write(&page, path)
    }

    /// The first case with these gains, and which of its rows the page has.
    fn run(&self, key: &str, title: &str, values: &[f64]) -> Result<(Run, String), Failure> {
        let Some(case) = self.task.cases.first() else { return Err(Failure::failed("there is no case")) };
        let mut said = String::new();
        let ((shown, judged), mut master) =
            self.lab.observe(case, &self.task.with(values), &SIGNALS, |grid, columns| {
                said = rows::sentence(grid);
                (Rows::new(grid, columns), Follow::new(columns, |name| SIGNALS.contains(&name)))
            })?;
        let models = (0..master.names().count()).map(|index| ModelParameters::of(master.instance(index)));
        let models = models.collect::<Result<Vec<_>, _>>()?;
        let limits = actuator_limits(master.instance(0));
        let metrics = Metrics::of(judged.table(), limits).ok();
        let rows = Packed::of(&shown.into_table(), &models);
        let run = Run { key: key.into(), title: title.into(), rows, metrics, models, ..Run::default() };
        Ok((run, said))
    }

    fn gains(&self) -> TextTable {
        let header = ["gain", "before", "after", "from", "to"].map(str::to_owned).into();
        let row = |(dimension, value): (&crate::tune::dimension::Dimension, &f64)| {
            let numbers = [dimension.start, *value, dimension.low, dimension.high].map(|value| format!("{value}"));
            std::iter::once(dimension.names.join(", ")).chain(numbers).collect()
        };
        TextTable { header, rows: self.task.dimensions.iter().zip(&self.best.values).map(row).collect() }
    }

    fn cases(&self) -> TextTable {
        let header = ["case", "settles", "beside it", "ratio to the limit"].map(str::to_owned).into();
        let row = |(number_of_case, (case, cell)): (usize, (&crate::grasp::matrix::Case, &Option<Cell>))| {
            let (first, second) = lines(&cell.ok_or_else(String::new));
            let ratio =
                cell.map_or("failed".into(), |cell| number(self.task.objective.ratio(number_of_case, &cell), 2));
            vec![case.scenario.title.clone(), first, second, ratio]
        };
        TextTable { header, rows: (0..).zip(self.task.cases.iter().zip(self.found)).map(row).collect() }
    }

    /// The best objective over the evaluations.
    fn progress(&self) -> NamedFigure {
        // A ratio; the first ones can be thousands of the last.
        let height = |cost: f64| cost.max(1e-9).log10();
        let points = self.history.iter().enumerate().map(|(index, cost)| (index as f64 + 1.0, height(*cost))).collect();
        let panel = Panel {
            x_label: Some("Evaluation".into()),
            y_label: "log₁₀ of the best objective".into(),
            x_range: (1.0, (self.history.len() as f64).max(2.0)),
            curves: vec![Curve { name: String::new(), color: palette::BLUE, wide: false, points }],
            ..Panel::default()
        };
        let caption = "The way of the search";
        NamedFigure {
            name: "search".into(),
            caption: caption.into(),
            note: "The decadic logarithm of the best objective that was found so far.".into(),
            figure: Figure { title: caption.into(), size: (720, 320), rows: vec![vec![panel]] },
        }
    }
}

//! What a search has found, for people and as a document.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use crate::grasp::matrix::Cell;
use crate::tune::dimension::Dimension;
use crate::tune::{Best, Task};

/// The document of `--json`; `docs/tool.md` describes the keys.
#[derive(Serialize)]
pub(super) struct Document<'a> {
    command: &'static str,
    version: &'static str,
    controller: &'a str,
    /// In s.
    wall_time: f64,
    cost: f64,
    evaluation: usize,
    evaluations: usize,
    seed: u64,
    parameters: Vec<ParameterDocument<'a>>,
    cases: Vec<CaseDocument<'a>>,
    preset: &'a Path,
}

#[derive(Serialize)]
struct ParameterDocument<'a> {
    name: &'a str,
    value: f64,
    low: f64,
    high: f64,
}

#[derive(Serialize)]
struct CaseDocument<'a> {
    case: &'a str,
    ratio: Option<f64>,
    /// In s or N.
    goal: Option<f64>,
    #[serde(flatten)]
    cell: Option<&'a Cell>,
}

pub(super) fn summary(task: &Task, best: &Best, found: &[Option<Cell>]) -> String {
    let (cost, evaluations) = (best.cost, task.evaluations);
    let mut text = match best.evaluation {
        1 if evaluations > 1 => {
            format!(
                "objective {cost:.4}, that of the start: none of {evaluations} evaluations was better, more may be\n\n"
            )
        }
        evaluation => format!("objective {cost:.4}, found by evaluation {evaluation} of {evaluations}\n\n"),
    };
    for (dimension, value) in task.dimensions.iter().zip(&best.values) {
        let at_edge = *value <= dimension.low || *value >= dimension.high;
        let remark = if at_edge { "  at the edge of its range" } else { "" };
        let _ = writeln!(text, "  {:<24} {value}{remark}", dimension.names.join(", "));
    }
    text += "\n";
    for (number, (case, cell)) in (0..).zip(task.cases.iter().zip(found)) {
        let (first, second) = crate::report::matrix::lines(&cell.ok_or_else(String::new));
        let ratio = cell.map_or("failed".into(), |cell| format!("ratio {:.2}", task.objective.ratio(number, &cell)));
        let missed = cell.map(|cell| task.objective.missed(number, &cell)).filter(|missed| *missed > 1.0);
        let goal = missed.map(|missed| format!(", {missed:.3} times its goal")).unwrap_or_default();
        let _ = writeln!(text, "  {:<30} {first:>8}  {second:<10} {ratio}{goal}", case.scenario.title);
    }
    text + "\n"
}

pub(super) fn document<'a>(
    task: &'a Task,
    best: &Best,
    found: &'a [Option<Cell>],
    seconds: f64,
    preset: &'a Path,
) -> Document<'a> {
    let parameters = task.dimensions.iter().zip(&best.values).flat_map(|(dimension, value)| {
        let Dimension { names, low, high, .. } = dimension;
        names.iter().map(|name| ParameterDocument { name, value: *value, low: *low, high: *high })
    });
    let cases = (0..).zip(task.cases.iter().zip(found)).map(|(number, (case, cell))| CaseDocument {
        case: &case.key,
        ratio: cell.as_ref().map(|cell| task.objective.ratio(number, cell)),
        goal: task.objective.goal(number).map(|goal| goal.value),
        cell: cell.as_ref(),
    });
    Document {
        command: "tune",
        version: env!("CARGO_PKG_VERSION"),
        controller: &task.contender.key,
        wall_time: seconds,
        cost: best.cost,
        evaluation: best.evaluation,
        evaluations: task.evaluations,
        seed: task.seed,
        parameters: parameters.collect(),
        cases: cases.collect(),
        preset,
    }
}

//! The matrix as tables, data and a [figure].

pub mod contact;
pub mod figure;

use serde::Serialize;

use crate::grasp::matrix::{Case, Cell, Judged, Matrix};
use crate::report::TextTable;
use charts::text::number;
use grasp_merit::merit::Merit;

/// The explanation of the matrix, in sentences.
const LEGEND: &str = "Time in s until forces, angles and position, all of (17), stay within 2 % of their travel; below it \
    the overshoot of the force where that is more than 2 %, and under *never* the force error that is left. The last rows, \
    where sensors or a wrong model keep the force from settling, give its rms error instead. *Limit* is the shortest \
    time that the actuators allow while contact is kept and no force overshoots, behind the stroke what it is if the arms \
    only go along.";

/// The same where all grasps can open.
const OPEN_LEGEND: &str = "Time in s until forces, angles and position, all of (17), stay within 2 % of their travel; below it the \
    overshoot of the force where that is more than 2 %, and under *never* the force error that is left. *Limit* is that of a \
    grasp that never opens: the shortest time that the actuators allow while contact is kept and no force overshoots, behind \
    the stroke what it is if the arms only go along.";

/// The heading where not every grasp can open.
const CLOSED: &str = "Who settles, and when";

/// Whether the grasp can open in every case.
fn opens(matrix: &Matrix) -> bool {
    matrix.cases.iter().all(Case::opens)
}

/// The heading of the matrix and of what belongs to it.
#[must_use]
pub fn title(matrix: &Matrix) -> &'static str {
    if opens(matrix) { "Who holds a grasp that can open" } else { CLOSED }
}

/// What its cells say, in sentences.
#[must_use]
pub fn legend(matrix: &Matrix) -> &'static str {
    if opens(matrix) { OPEN_LEGEND } else { LEGEND }
}

/// Smallest overshoot in % that a cell shows.
const OVERSHOOT: f64 = 2.0;

/// The two lines of a cell.
#[must_use]
pub fn lines(cell: &Result<Cell, String>) -> (String, String) {
    let Ok(cell) = cell else { return ("–".into(), String::new()) };
    let Merit { settling, overshoot, error_rms, .. } = cell.merit;
    match (cell.judged, settling) {
        (Judged::Error, _) => (millinewtons(error_rms), String::new()),
        (Judged::Settling, None) => ("never".into(), millinewtons(error_rms)),
        (Judged::Settling, Some(time)) if overshoot > OVERSHOOT => {
            (seconds(time), format!("+{} %", number(overshoot, 0)))
        }
        (Judged::Settling, Some(time)) => (seconds(time), String::new()),
    }
}

fn seconds(time: f64) -> String {
    number(time, if time < 10.0 { 2 } else { 1 })
}

fn millinewtons(force: f64) -> String {
    let force = 1e3 * force;
    if force.is_nan() {
        return "–".into();
    }
    format!("{} mN", number(force, usize::from(force < 99.95)))
}

/// The matrix as a table of texts, one line per cell.
#[must_use]
pub fn table(matrix: &Matrix) -> TextTable {
    let mut header = vec!["case".to_owned()];
    header.extend(matrix.contenders.iter().map(|contender| contender.title.clone()));
    header.push("limit".into());
    let row = |(index, case): (usize, &Case)| {
        let mut row = vec![case.scenario.title.clone()];
        row.extend(matrix.cells[index].iter().map(|cell| {
            let (first, second) = lines(cell);
            if second.is_empty() { first } else { format!("{first} ({second})") }
        }));
        row.push(matrix.limits(index).map_or("–".into(), |limits| limits.map(seconds).join(" / ")));
        row
    };
    TextTable { header, rows: matrix.cases.iter().enumerate().map(row).collect() }
}

/// The table with its explanation, as Markdown, and the tables of contacts if grasps can open.
#[must_use]
pub fn markdown(matrix: &Matrix) -> String {
    format!("{}\n\n{}{}", legend(matrix), table(matrix).to_markdown(), contact::markdown(matrix))
}

/// Everything in plain names and SI units, one line per cell; absent values are empty.
#[must_use]
pub fn csv(matrix: &Matrix) -> String {
    const COLUMNS: &str = "case,controller,judged,settling_s,settling_forces_s,settling_angles_s,settling_position_s,\
        overshoot_percent,steady_error_N,error_rms_N,peak_torque_Nm,peak_force_N,saturated_s,tension_N,held_from_s,lost_s,\
        drops,impacts,peak_contact_N,limit_s,own_limit_s,failure";
    let optional = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let header: Vec<String> = COLUMNS.split(',').map(Into::into).collect();
    let width = header.len();
    let mut rows = vec![header];
    for (case, cells) in matrix.cases.iter().zip(&matrix.cells) {
        for (contender, cell) in matrix.contenders.iter().zip(cells) {
            let mut row = vec![case.key.clone(), contender.key.clone()];
            match cell {
                Ok(Cell { judged, merit, impacts, limit, own_limit, .. }) => row.extend([
                    match judged {
                        Judged::Settling => "settling".to_owned(),
                        Judged::Error => "error".to_owned(),
                    },
                    optional(merit.settling),
                    optional(merit.settling_forces),
                    optional(merit.settling_angles),
                    optional(merit.settling_position),
                    merit.overshoot.to_string(),
                    merit.steady_error.to_string(),
                    merit.error_rms.to_string(),
                    merit.peak_torque.to_string(),
                    merit.peak_force.to_string(),
                    merit.saturated.to_string(),
                    merit.tension.to_string(),
                    optional(merit.grip.held_from),
                    merit.grip.lost.to_string(),
                    merit.grip.drops.to_string(),
                    impacts.map_or(String::new(), |impacts| impacts.to_string()),
                    merit.grip.peak.to_string(),
                    limit.to_string(),
                    own_limit.to_string(),
                    String::new(),
                ]),
                Err(reason) => {
                    row.resize(width - 1, String::new());
                    row.push(reason.replace(['"', '\n'], " "));
                }
            }
            rows.push(row);
        }
    }
    crate::report::csv(rows)
}

/// One cell of [`documents`].
#[derive(Debug, Serialize)]
pub struct CellDocument<'a> {
    case: &'a str,
    controller: &'a str,
    #[serde(flatten)]
    cell: Option<&'a Cell>,
    failure: Option<&'a str>,
}

/// The cells with the keys of their case and controller, row by row.
#[must_use]
pub fn documents(matrix: &Matrix) -> Vec<CellDocument<'_>> {
    let rows = matrix.cases.iter().zip(&matrix.cells);
    rows.flat_map(|(case, cells)| {
        matrix.contenders.iter().zip(cells).map(|(contender, cell)| CellDocument {
            case: &case.key,
            controller: &contender.key,
            cell: cell.as_ref().ok(),
            failure: cell.as_ref().err().map(String::as_str),
        })
    })
    .collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::grasp::matrix::Contender;
    use grasp_merit::merit::Grip;

    /// Two rows of two: settled and overshooting, never and failed.
    pub fn example() -> Matrix {
        let merit = Merit {
            settling: Some(0.15),
            settling_forces: Some(0.15),
            settling_angles: Some(0.1),
            settling_position: Some(0.1),
            overshoot: 0.1,
            steady_error: 0.0,
            error_rms: 0.01,
            peak_torque: 1.0,
            peak_force: 0.3,
            saturated: 0.0,
            tension: 0.0,
            grip: Grip { held_from: Some(0.0), lost: 0.0, drops: 0, peak: 0.5 },
        };
        let cell = |settling, overshoot| {
            let merit = Merit { settling, overshoot, ..merit };
            let (limit, own_limit) = (0.05, 0.08);
            let judged = Judged::Settling;
            Ok(Cell { judged, merit, impacts: Some(0), limit, own_limit, target: 0.5, stop: 6.0 })
        };
        Matrix {
            cases: Case::all().unwrap().into_iter().take(2).collect(),
            contenders: Contender::all().unwrap().into_iter().take(2).collect(),
            cells: vec![vec![cell(Some(0.15), 0.1), cell(Some(0.31), 31.0)], vec![cell(None, 0.0), Err("a, b".into())]],
        }
    }

    #[test]
    fn every_cell_is_in_table_and_data() {
        let matrix = example();
        let text = markdown(&matrix);
        assert!(text.contains("| undisturbed | 0.15 | 0.31 (+31 %) | 0.05 / 0.08 |"), "{text}");
        assert!(text.contains("| never (10.0 mN) | – | 0.05 / 0.08 |"), "{text}");
        let csv = csv(&matrix);
        let commas: Vec<_> = csv.lines().map(|line| line.replace("\"a, b\"", "").matches(',').count()).collect();
        assert_eq!(commas, [21; 5], "{csv}");
        let json = serde_json::to_value(documents(&matrix)).unwrap();
        assert_eq!(json[1]["merit"]["overshoot"], 31.0);
        assert_eq!((&json[2]["merit"]["settling"], &json[3]["failure"]), (&serde_json::Value::Null, &"a, b".into()));
    }
}

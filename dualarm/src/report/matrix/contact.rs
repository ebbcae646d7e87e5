//! The contacts in the cases in which a grasp can open.

use crate::grasp::matrix::{Cell, Matrix};
use crate::report::TextTable;
use charts::text::number;

/// One figure of all cells: its title, its meaning, and the text in a cell.
struct Figure {
    title: &'static str,
    meaning: &'static str,
    text: fn(&Cell) -> String,
}

const FIGURES: [Figure; 4] = [
    Figure {
        title: "Held from, in s",
        meaning: "When both tips first press, as communication points show it.",
        text: |cell| cell.merit.grip.held_from.map_or("never".into(), |time| number(time, 3)),
    },
    Figure {
        title: "Lost again, in ms",
        meaning: "Time after that in which not both tips press; in brackets how often it begins.",
        text: |Cell { merit, .. }| match merit.grip.drops {
            0 => "0".into(),
            drops => format!("{} ({drops}×)", number(1e3 * merit.grip.lost, 0)),
        },
    },
    Figure {
        title: "Impacts",
        meaning: "How often a tip comes onto the object, counted inside of steps too.",
        text: |cell| cell.impacts.map_or("–".into(), |impacts| impacts.to_string()),
    },
    Figure {
        title: "Peak force, in N",
        meaning: "The largest contact force. What an impact of rigid bodies hands over at once is no force.",
        text: |cell| number(cell.merit.grip.peak, 2),
    },
];

/// The tables, each with title and explanation; empty without a case in which the grasp can open.
#[must_use]
pub fn tables(matrix: &Matrix) -> Vec<(&'static str, &'static str, TextTable)> {
    let opening: Vec<_> = matrix.cases.iter().zip(&matrix.cells).filter(|(case, _)| case.opens()).collect();
    if opening.is_empty() {
        return Vec::new();
    }
    let header = || ["case"].into_iter().chain(matrix.contenders.iter().map(|contender| contender.title.as_str()));
    let table = |figure: &Figure| {
        let text = |cell: &Result<Cell, String>| cell.as_ref().map_or_else(|_| "–".into(), figure.text);
        let rows = opening
            .iter()
            .map(|(case, cells)| [case.scenario.title.clone()].into_iter().chain(cells.iter().map(text)).collect());
        (
            figure.title,
            figure.meaning,
            TextTable { header: header().map(str::to_owned).collect(), rows: rows.collect() },
        )
    };
    FIGURES.iter().map(table).collect()
}

/// The tables as Markdown, after a line that is empty; nothing without them.
#[must_use]
pub fn markdown(matrix: &Matrix) -> String {
    let table = |(title, meaning, table): (&str, &str, TextTable)| {
        format!("\n**{title}.** {meaning}\n\n{}", table.to_markdown())
    };
    tables(matrix).into_iter().map(table).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::example;
    use super::*;
    use crate::grasp::matrix::Case;

    #[test]
    fn only_grasps_that_can_open_have_tables() {
        let mut matrix = example();
        assert_eq!(markdown(&matrix), "");
        matrix.cases = Case::contact().unwrap().into_iter().take(2).collect();
        let text = markdown(&matrix);
        assert_eq!(tables(&matrix).len(), 4);
        assert!(text.contains("| just touching | 0 | 0 |") && text.contains("| 0.50 | – |"), "{text}");
    }
}

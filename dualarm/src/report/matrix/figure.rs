//! The matrix as a picture: one coloured cell per controller and case, readable in ten seconds.

use std::fmt::Write;

use super::{lines, opens};
use crate::grasp::matrix::{Cell, Matrix};
use crate::report::html::escape;
use charts::text::{self, FAMILIES, with_shifts};

const CELL: (f64, f64) = (78.0, 34.0);
/// Least and most room for the names of cases.
const LABELS: f64 = 196.0;
const MOST_LABELS: f64 = 360.0;
/// So many lines of a name fit above a column.
const NAME_LINES: usize = 4;
const HEADER: f64 = 104.0;
const MARGIN: f64 = 16.0;
/// Room for the title.
const TITLE: f64 = 40.0;
const LIMIT: f64 = 84.0;
/// How much wider than the embedded font, regular and bold, the widest one is that a browser takes if it has no font of the list: `DejaVu` Sans.
const WIDER: [f64; 2] = [1.08, 1.17];

/// Ratio to the best of the row, and its colour: colours that colour-blind readers can distinguish.
const SCALE: [(f64, [f64; 3]); 4] = [
    (1.0, [140.0, 197.0, 232.0]),
    (1.6, [214.0, 234.0, 246.0]),
    (2.5, [250.0, 244.0, 230.0]),
    (8.0, [244.0, 178.0, 104.0]),
];
const NEVER: &str = "#C2410C";
/// Ratios whose colours the key shows; none: what never settles.
const SHADES: [(Option<f64>, &str); 5] =
    [(Some(1.0), "best"), (Some(1.6), "1.6 ×"), (Some(2.5), "2.5 ×"), (Some(8.0), "8 × and more"), (None, "never")];
const NOTES: &str = "Time until forces, angles and position stay within 2 % of their travel; small: overshoot of the force above 2 %, or the rms error that is left. In mN: rms error.";
const HEADING: &str = "Who settles, and when (s)";
/// Both where every grasp can open.
const OPEN_HEADING: &str = "Who settles in a grasp that can open, and when (s)";
const OPEN_NOTES: &str = "Time until forces, angles and position stay within 2 % of their travel; small: overshoot of the force above 2 %, or the rms error that is left. The limit is that of a grasp that never opens.";
const EMPTY: &str = "#EEF0F3";
const INK: &str = "#22262E";
const SOFT: &str = "#5B6370";

/// Errors below this value, in N, count as equal.
const EXACT: f64 = 1e-3;

/// The figure as SVG; `titled` unless there is a heading above it.
#[must_use]
pub fn svg(matrix: &Matrix, titled: bool) -> String {
    let label = |title: &str| shortened(title, 12.0, false, MOST_LABELS - 12.0);
    let names: Vec<String> = matrix.cases.iter().map(|case| label(&case.scenario.title)).collect();
    let labels = names.iter().map(|name| room(name, 12.0, false) + 12.0);
    let labels = labels.fold(LABELS, f64::max).ceil();
    let left = |column: usize| MARGIN + labels + column as f64 * CELL.0;
    let key = SHADES.map(|(_, label)| key_width(label)).iter().sum::<f64>();
    let width = (left(matrix.contenders.len()) + LIMIT).max(MARGIN + key).ceil() + MARGIN;
    let notes = wrapped(if opens(matrix) { OPEN_NOTES } else { NOTES }, width - 2.0 * MARGIN, 10.5, false);
    let bottom = HEADER + matrix.cases.len() as f64 * CELL.1 + 60.0 + 14.0 * notes.len() as f64;
    let top = if titled { 0.0 } else { TITLE };
    let height = bottom - top;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 {top} {width} {height}\" \
         font-family=\"{FAMILIES}\" fill=\"{INK}\">\n<rect y=\"{top}\" width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    if titled {
        write_text(
            &mut svg,
            (MARGIN, 26.0),
            15.0,
            "start",
            true,
            INK,
            if opens(matrix) { OPEN_HEADING } else { HEADING },
        );
    }
    for (column, contender) in matrix.contenders.iter().enumerate() {
        let x = left(column) + 0.5 * CELL.0;
        let mut lines = wrapped(&contender.title, CELL.0 - 4.0, 12.0, true);
        if lines.len() > NAME_LINES {
            lines.truncate(NAME_LINES);
            lines[NAME_LINES - 1] += " \u{2026}";
        }
        for (line, words) in lines.iter().rev().enumerate() {
            let words = &shortened(words, 12.0, true, CELL.0 - 4.0);
            write_text(&mut svg, (x, HEADER - 10.0 - 15.0 * line as f64), 12.0, "middle", true, INK, words);
        }
    }
    let x = left(matrix.contenders.len()) + 0.5 * LIMIT;
    for (line, words) in ["the arms", "without", "limit, with /", "physical"].into_iter().enumerate() {
        write_text(&mut svg, (x, HEADER - 10.0 - 15.0 * line as f64), 11.0, "middle", false, SOFT, words);
    }
    for (row, name) in names.iter().enumerate() {
        let y = HEADER + row as f64 * CELL.1;
        write_text(&mut svg, (MARGIN + labels - 10.0, y + 21.0), 12.0, "end", false, INK, name);
        for column in 0..matrix.contenders.len() {
            write_cell(&mut svg, matrix, row, column, (left(column), y));
        }
        if let Some(limits) = matrix.limits(row) {
            let words = limits.map(|limit| text::number(limit, 2)).join(" / ");
            write_text(&mut svg, (x, y + 21.0), 11.0, "middle", false, SOFT, &words);
        }
    }
    let y = HEADER + matrix.cases.len() as f64 * CELL.1 + 24.0;
    // Below the cells, if it fits there.
    let x = if left(0) + key + MARGIN <= width { left(0) } else { MARGIN };
    write_key(&mut svg, (x, y));
    for (line, words) in notes.iter().enumerate() {
        write_text(&mut svg, (MARGIN, y + 36.0 + 14.0 * line as f64), 10.5, "start", false, SOFT, words);
    }
    with_shifts(&(svg + "</svg>\n"))
}

fn write_cell(svg: &mut String, matrix: &Matrix, row: usize, column: usize, (x, y): (f64, f64)) {
    let cell = &matrix.cells[row][column];
    let value = cell.as_ref().ok().map(Cell::value);
    let (fill, ink) = match (value, matrix.best(row)) {
        (None, _) => (EMPTY.to_owned(), SOFT),
        (Some(Some(value)), Some(best)) => (shade(value.max(EXACT) / best.max(EXACT)), INK),
        _ => (NEVER.to_owned(), "white"),
    };
    let (width, height) = (CELL.0 - 2.0, CELL.1 - 2.0);
    let _ = writeln!(
        svg,
        "<rect x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\" rx=\"3\" fill=\"{fill}\"/>",
        x + 1.0,
        y + 1.0
    );
    let (first, second) = lines(cell);
    let is_best =
        matches!((value, matrix.best(row)), (Some(Some(value)), Some(best)) if value <= 1.1 * best.max(EXACT));
    let middle = x + 0.5 * CELL.0;
    let baseline = y + if second.is_empty() { 21.5 } else { 16.0 };
    write_text(svg, (middle, baseline), 13.0, "middle", is_best, ink, &first);
    if !second.is_empty() {
        write_text(svg, (middle, y + 28.0), 9.5, "middle", false, ink, &second);
    }
}

fn key_width(label: &str) -> f64 {
    44.0 + room(label, 11.0, false)
}

fn write_key(svg: &mut String, (mut x, y): (f64, f64)) {
    for (ratio, label) in SHADES {
        let fill = ratio.map_or_else(|| NEVER.to_owned(), shade);
        let _ = writeln!(svg, "<rect x=\"{x}\" y=\"{y}\" width=\"22\" height=\"14\" rx=\"3\" fill=\"{fill}\"/>");
        write_text(svg, (x + 28.0, y + 11.5), 11.0, "start", false, INK, label);
        x += key_width(label);
    }
}

fn write_text(svg: &mut String, (x, y): (f64, f64), size: f64, anchor: &str, bold: bool, ink: &str, words: &str) {
    let weight = if bold { " font-weight=\"bold\"" } else { "" };
    let _ = writeln!(
        svg,
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\"{weight} fill=\"{ink}\">{}</text>",
        escape(words)
    );
}

/// The width of a text in px, in the widest font that a browser may take.
fn room(text: &str, size: f64, bold: bool) -> f64 {
    WIDER[usize::from(bold)] * text::width(text, size, bold)
}

/// A text that needs no more [`room`] than this: the beginning with an ellipsis, if it has to be.
fn shortened(words: &str, size: f64, bold: bool, width: f64) -> String {
    text::shortened(words, size, bold, width / WIDER[usize::from(bold)]).into_owned()
}

/// Words in lines that are no wider than `width`, if each word is not.
fn wrapped(words: &str, width: f64, size: f64, bold: bool) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split(' ') {
        match lines.last_mut() {
            Some(line) if room(&format!("{line} {word}"), size, bold) <= width => {
                *line = format!("{line} {word}");
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Colour of a value that is `ratio` times the best.
fn shade(ratio: f64) -> String {
    let last = SCALE[SCALE.len() - 1];
    let upper = SCALE.iter().position(|(at, _)| ratio <= *at);
    let color = match upper {
        Some(0) => SCALE[0].1,
        None => last.1,
        Some(upper) => {
            let ((low, from), (high, to)) = (SCALE[upper - 1], SCALE[upper]);
            let share = (ratio / low).ln() / (high / low).ln();
            [0, 1, 2].map(|index| from[index] + share * (to[index] - from[index]))
        }
    };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and 255
    let [red, green, blue] = color.map(|part| part.round() as u8);
    format!("#{red:02X}{green:02X}{blue:02X}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::matrix::{Case, Contender};

    #[test]
    fn the_picture_is_sound_and_says_every_cell() {
        let svg = svg(&super::super::tests::example(), true);
        let document = roxmltree::Document::parse(&svg).unwrap();
        let words: Vec<_> = document.descendants().filter_map(|node| node.text()).map(str::trim).collect();
        for expected in ["undisturbed", "0.15", "0.31", "+31 %", "never", "10.0 mN", "–"] {
            assert!(words.contains(&expected), "{expected} is missing");
        }
        assert_eq!(text::missing(&words.concat().replace('\n', "")), Vec::<char>::new());
    }

    /// Texts beside each other, as wide as in the widest font: each has its own part of the picture.
    #[test]
    fn texts_have_room_in_the_widest_font() {
        let mut matrix = super::super::tests::example();
        matrix.contenders = Contender::all().unwrap();
        let cells = |row: &Vec<_>| row.iter().cloned().cycle().take(matrix.contenders.len()).collect();
        matrix.cells = matrix.cells.iter().map(cells).collect();
        let svg = svg(&matrix, true);
        let document = roxmltree::Document::parse(&svg).unwrap();
        let whole: f64 = document.root_element().attribute("width").unwrap().parse().unwrap();
        let mut texts: Vec<(String, f64, f64)> = Vec::new();
        for node in document.descendants().filter(|node| node.has_tag_name("text")) {
            let number = |name| node.attribute(name).unwrap().parse::<f64>().unwrap();
            let words: String =
                node.descendants().filter(roxmltree::Node::is_text).filter_map(|part| part.text()).collect();
            let width = room(&words, number("font-size"), node.has_attribute("font-weight"));
            let begin = number("x")
                - match node.attribute("text-anchor") {
                    Some("middle") => 0.5 * width,
                    Some("end") => width,
                    _ => 0.0,
                };
            assert!(begin >= 0.0 && begin + width <= whole, "{words} leaves the picture");
            texts.push((node.attribute("y").unwrap().to_owned(), begin, begin + width));
        }
        texts.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for pair in texts.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            assert!(pair[0].2 + 2.0 <= pair[1].1, "{pair:?}");
        }
    }

    #[test]
    fn a_matrix_says_what_its_cases_are() {
        let mut matrix = super::super::tests::example();
        let closed = svg(&matrix, true);
        assert!(closed.contains("Who settles, and when (s)") && closed.contains("In mN: rms error"));
        matrix.cases = Case::contact().unwrap().into_iter().take(2).collect();
        let open = svg(&matrix, true);
        assert!(open.contains("grasp that can open") && !open.contains("In mN: rms error"), "{open}");
    }

    #[test]
    fn shades_go_from_the_best_to_the_worst() {
        assert_eq!((shade(1.0), shade(100.0)), ("#8CC5E8".to_owned(), "#F4B268".to_owned()));
        assert_ne!(shade(1.3), shade(2.0));
    }
}

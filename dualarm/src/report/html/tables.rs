//! The tables of the page: the result, metrics side by side, and the figures.

use std::fmt::Write;

use super::markup::escape;
use super::run::Run;
use crate::grasp::matrix::{Matrices, Matrix};
use crate::report::TextTable;
use crate::report::figures::Drawn;
use crate::report::matrix::{contact, figure, legend, title};
use charts::text::number;
use grasp_merit::metrics::{EffortMetrics, ForceMetrics, Metrics};

/// A table of texts as a section of the page.
#[must_use]
pub fn section(title: &str, table: &TextTable) -> String {
    let mut html = format!(
        "<section><h2>{0}</h2><div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\"><table><thead><tr>",
        escape(title)
    );
    for heading in &table.header {
        let _ = write!(html, "<th scope=\"col\">{}</th>", escape(heading));
    }
    html += "</tr></thead><tbody>";
    for row in &table.rows {
        html += "<tr>";
        for (column, cell) in row.iter().enumerate() {
            let cell = escape(cell);
            let (open, close) = if column == 0 { ("<th scope=\"row\">", "</th>") } else { ("<td>", "</td>") };
            html.extend([open, cell.as_str(), close]);
        }
        html += "</tr>";
    }
    html + "</tbody></table></div></section>"
}

/// The matrices of controllers and cases, as sections of the page.
#[must_use]
pub fn matrices(matrices: &Matrices) -> String {
    let closed = matrix("matrix", &matrices.closed);
    let contact = |contact| matrix("contact", contact);
    closed + &matrices.contact.as_ref().map_or_else(String::new, contact)
}

/// A command to be typed again, as a section of the page.
#[must_use]
pub fn command(title: &str, text: &str) -> String {
    format!("<section><h2>{}</h2><pre class=\"command\">{}</pre></section>", escape(title), escape(text))
}

fn matrix(id: &str, matrix: &Matrix) -> String {
    let title = title(matrix);
    let mut contacts = String::new();
    for (title, meaning, table) in contact::tables(matrix) {
        let _ = write!(contacts, "{}<p class=\"soft\">{}</p>", section(title, &table), escape(meaning));
    }
    format!(
        "<section aria-labelledby=\"{id}-title\"><h2 id=\"{id}-title\">{title}</h2>\
         <div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{title}: controllers in all cases\">{}</div>\
         <p class=\"soft\">{}</p>\
         </section>{contacts}",
        figure::svg(matrix, false),
        escape(&legend(matrix).replace('*', ""))
    )
}

/// The main results in large type: one card per run that has metrics.
#[must_use]
pub fn headline(runs: &[Run]) -> String {
    let card = |(index, run): (usize, &Run)| {
        let settling = run.metrics.as_ref()?.settling_2();
        let time = settling.map_or("does not settle".into(), |time| format!("{}\u{a0}s", number(time, decimals(time))));
        let paper =
            if run.paper.is_empty() { String::new() } else { format!("<span>paper: {}</span>", escape(&run.paper)) };
        Some(format!(
            "<li class=\"run-{index}\"><span class=\"name\"><i class=\"swatch\"></i>{}</span><b>{time}</b>{paper}</li>",
            escape(&run.title)
        ))
    };
    let cards: String = runs.iter().enumerate().filter_map(card).collect();
    if cards.is_empty() {
        return cards;
    }
    format!(
        "<section class=\"result\" aria-labelledby=\"result-title\"><h2 id=\"result-title\">Time until both contact forces stay \
         within ±2 % of their target</h2><ul>{cards}</ul></section>"
    )
}

/// Digits after the point of a time in s, so that three of them count.
fn decimals(time: f64) -> usize {
    match time {
        time if time >= 10.0 => 1,
        time if time >= 1.0 => 2,
        _ => 3,
    }
}

/// A group of rows of the metrics table.
struct Group {
    heading: &'static str,
    rows: Vec<(String, Vec<String>)>,
}

/// Why a time in saturation is not there.
const UNKNOWN_LIMITS: &str = " In saturation: \u{2013} where the limits of the actuator are not known; they are parameters of the \
                              plant, which a file of results does not hold.";

/// The metrics, one column per run, as a section of the page; nothing if no run has any.
#[must_use]
pub fn metrics(runs: &[Run]) -> String {
    if runs.iter().all(|run| run.metrics.is_none()) {
        return String::new();
    }
    let mut html = String::from("<table class=\"metrics\"><thead><tr><td></td>");
    for (index, run) in runs.iter().enumerate() {
        let title = escape(&run.title);
        let _ = write!(html, "<th scope=\"col\"><span class=\"swatch run-{index}\"></span>{title}</th>");
    }
    html += "</tr></thead>";
    for Group { heading, rows } in groups(runs) {
        let columns = runs.len() + 1;
        let _ =
            write!(html, "<tbody><tr><th class=\"group\" colspan=\"{columns}\" scope=\"rowgroup\">{heading}</th></tr>");
        for (name, cells) in rows {
            let cells: Vec<String> = cells.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
            let _ = write!(html, "<tr><th scope=\"row\">{}</th>{}</tr>", escape(&name), cells.concat());
        }
        html += "</tbody>";
    }
    let mut efforts = runs.iter().filter_map(|run| run.metrics.as_ref()).flat_map(|metrics| &metrics.efforts);
    let limits = if efforts.all(|effort| effort.saturated.is_some()) { "" } else { UNKNOWN_LIMITS };
    format!(
        "<section aria-labelledby=\"metrics-title\"><h2 id=\"metrics-title\">Metrics</h2>\
         <div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Metrics\">{html}</table></div>\
         <p class=\"soft\">Settling time: after it the force stays within the band around its target. Overshoot: in % of the \
         way from the first value to the target. Steady error: mean over the last 5 % of the run. Control effort: outputs of \
         the actuators over the whole run.{limits}</p></section>"
    )
}

fn groups(runs: &[Run]) -> Vec<Group> {
    let row = |name: String, cell: &dyn Fn(&Metrics) -> String| {
        (name, runs.iter().map(|run| run.metrics.as_ref().map_or("–".into(), cell)).collect())
    };
    let forces = (0..2).map(|arm| {
        let force = |name: &str, cell: fn(&ForceMetrics) -> String| {
            row(name.to_owned(), &move |metrics| cell(&metrics.forces[arm]))
        };
        let mut rows = vec![
            force("settling time, ±2 % (s)", |force| seconds(force.settling_2)),
            force("settling time, ±5 % (s)", |force| seconds(force.settling_5)),
            force("overshoot (%)", |force| number(force.overshoot, 2)),
            force("steady error (mN)", |force| number(1e3 * force.steady_error, 2)),
        ];
        if arm == 0 && runs.iter().any(|run| !run.paper.is_empty()) {
            let says = runs.iter().map(|run| unbroken(&run.paper)).collect();
            rows.insert(0, ("settling, says the paper".into(), says));
        }
        Group { heading: ["Contact force f₁", "Contact force f₂"][arm], rows }
    });
    let controls = [("Torque τ₁", "N·m"), ("Torque τ₂", "N·m"), ("Force u", "N")];
    let efforts = controls.into_iter().enumerate().map(|(index, (heading, unit))| {
        let effort = |name: &str, cell: &dyn Fn(&EffortMetrics) -> String| {
            row(name.to_owned(), &|metrics| cell(&metrics.efforts[index]))
        };
        Group {
            heading,
            rows: vec![
                effort(&format!("peak ({unit})"), &|effort| number(effort.peak, 4)),
                effort(&format!("rms ({unit})"), &|effort| number(effort.rms, 4)),
                effort("in saturation (ms)", &|effort| {
                    effort.saturated.map_or("–".into(), |time| number(1e3 * time, 1))
                }),
            ],
        }
    });
    forces.chain(efforts).collect()
}

/// A time whose unit is not separated from its number in a narrow cell.
fn unbroken(time: &str) -> String {
    time.strip_suffix(" s").map_or_else(|| time.to_owned(), |number| format!("{number}\u{a0}s"))
}

fn seconds(time: Option<f64>) -> String {
    time.map_or("not settled".into(), |time| number(time, 3))
}

/// The paper's figures, folded, or a single one, each to be taken away.
#[must_use]
pub fn figures(figures: &[Drawn]) -> String {
    if figures.is_empty() {
        return String::new();
    }
    let open = if figures.len() == 1 { " open" } else { "" };
    let mut html = format!(
        "<section aria-labelledby=\"figures-title\"><h2 id=\"figures-title\">Figures</h2><details class=\"figures\"{open}><summary>",
    );
    html += &match figures {
        [one] => escape(&one.caption),
        _ => "Figs. 2 to 18 as the paper numbers them, and the controllers in one picture".to_owned(),
    };
    html += "</summary><div class=\"drawn\">";
    for Drawn { name, caption, note, svg } in figures {
        let _ = write!(
            html,
            "<figure data-name=\"{name}\">{svg}<figcaption><strong>{}</strong> {} <span class=\"take\"></span></figcaption></figure>",
            escape(caption),
            escape(note)
        );
    }
    html + "</div></details></section>"
}

//! Tables and the report of a comparison: the [`matrix`] of controllers and cases, the paper's runs with their [`figures`],
//! and the same as an interactive page ([`html`]) with the models' [`parameters`]; the page of a [`study`].

pub mod figures;
pub mod html;
pub mod matrix;
pub mod parameters;
pub mod study;

use std::fmt::Write;

use crate::grasp::matrix::Matrices;
use crate::report::figures::{Drawn, PaperRun};
use charts::text::number;
use grasp_merit::metrics::{EffortMetrics, ForceMetrics, Metrics};

/// A table of texts: a header and rows.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TextTable {
    /// Column headings.
    pub header: Vec<String>,
    /// Rows as long as the header.
    pub rows: Vec<Vec<String>>,
}

impl TextTable {
    fn new(header: &[&str]) -> Self {
        Self { header: header.iter().map(|&heading| heading.to_owned()).collect(), rows: Vec::new() }
    }

    /// For a terminal of `width` columns: aligned columns, names to the left, numbers to the right. Headings take several
    /// lines if that helps; columns that still do not fit follow below, with the first column repeated.
    #[must_use]
    pub fn to_terminal(&self, width: usize) -> String {
        const GAP: usize = 2;
        let length = |text: &str| text.chars().count();
        let cells = |column: usize| self.rows.iter().map(|row| length(&row[column])).max().unwrap_or(0);
        let whole: Vec<usize> = (0..self.header.len()).map(|at| cells(at).max(length(&self.header[at]))).collect();
        let words = |column: usize| self.header[column].split(' ').map(length).max().unwrap_or(0);
        let narrow: Vec<usize> = (0..self.header.len()).map(|at| cells(at).max(words(at))).collect();
        let total = |widths: &[usize]| widths.iter().map(|width| width + GAP).sum::<usize>().saturating_sub(GAP);
        let widths = if total(&whole) <= width { whole } else { narrow };
        let mut blocks: Vec<Vec<usize>> = Vec::new();
        let mut block: Vec<usize> = Vec::new();
        let mut used = 0;
        for column in 0..widths.len() {
            if used > 0 && used + GAP + widths[column] > width && block.len() > 1 {
                blocks.push(std::mem::replace(&mut block, vec![0]));
                used = widths[0];
            }
            used += widths[column] + if used > 0 { GAP } else { 0 };
            block.push(column);
        }
        blocks.push(block);
        let blocks = blocks.iter().map(|block| self.block(block, &widths));
        blocks.collect::<Vec<_>>().join("\n")
    }

    /// Some columns with these widths.
    fn block(&self, columns: &[usize], widths: &[usize]) -> String {
        let headings: Vec<Vec<String>> = columns.iter().map(|&at| wrapped(&self.header[at], widths[at])).collect();
        let height = headings.iter().map(Vec::len).max().unwrap_or(0);
        let heading = |line: usize| {
            let cells =
                headings.iter().map(|lines| (line + lines.len()).checked_sub(height).map(|at| lines[at].as_str()));
            cells.map(Option::unwrap_or_default).collect::<Vec<&str>>()
        };
        let rules: Vec<String> = columns.iter().map(|&at| "─".repeat(widths[at])).collect();
        let mut text = String::new();
        let mut write = |cells: &[&str]| {
            let cells = cells.iter().zip(columns).map(|(cell, &at)| {
                let width = widths[at];
                if at < 2 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
            let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join("  ").trim_end());
        };
        for line in 0..height {
            write(&heading(line));
        }
        write(&rules.iter().map(String::as_str).collect::<Vec<_>>());
        for row in &self.rows {
            write(&columns.iter().map(|&at| row[at].as_str()).collect::<Vec<_>>());
        }
        text
    }

    /// As a Markdown table.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let mut text = String::new();
        for (index, line) in self.lines().enumerate() {
            let _ = writeln!(text, "| {} |", line.join(" | "));
            if index == 0 {
                let rules: Vec<&str> = (0..line.len()).map(|column| if column < 2 { ":--" } else { "--:" }).collect();
                let _ = writeln!(text, "|{}|", rules.join("|"));
            }
        }
        text
    }

    fn lines(&self) -> impl Iterator<Item = &Vec<String>> {
        std::iter::once(&self.header).chain(&self.rows)
    }
}

/// A text in lines that are no longer than `width`, if its words are not.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Settling of the contact forces; `paper` adds the paper's statement.
#[must_use]
pub fn force_table<'a>(results: impl IntoIterator<Item = (&'a str, &'a Metrics, &'a str)>) -> TextTable {
    let mut table = TextTable::new(&[
        "controller",
        "contact force",
        "settling 2 %",
        "settling 5 %",
        "overshoot",
        "steady error",
        "paper",
    ]);
    for (title, metrics, paper) in results {
        for (arm, force) in metrics.forces.iter().enumerate() {
            let first = arm == 0;
            table.rows.push(vec![
                if first { title.to_owned() } else { String::new() },
                format!("arm {}", arm + 1),
                seconds(force.settling_2),
                seconds(force.settling_5),
                format!("{} %", number(force.overshoot, 2)),
                format!("{} mN", number(1e3 * force.steady_error, 2)),
                if first { paper.to_owned() } else { String::new() },
            ]);
        }
    }
    table
}

/// Effort of the actuators.
#[must_use]
pub fn effort_table<'a>(results: impl IntoIterator<Item = (&'a str, &'a Metrics)>) -> TextTable {
    let mut table = TextTable::new(&["controller", "control", "peak", "rms", "in saturation"]);
    for (title, metrics) in results {
        for (index, (effort, (name, unit))) in metrics.efforts.iter().zip(CONTROLS).enumerate() {
            table.rows.push(vec![
                if index == 0 { title.to_owned() } else { String::new() },
                name.to_owned(),
                format!("{} {unit}", number(effort.peak, 4)),
                format!("{} {unit}", number(effort.rms, 4)),
                effort.saturated.map_or("–".into(), |time| format!("{} ms", number(1e3 * time, 1))),
            ]);
        }
    }
    table
}

const CONTROLS: [(&str, &str); 3] = [("τ₁", "N·m"), ("τ₂", "N·m"), ("u", "N")];

fn seconds(time: Option<f64>) -> String {
    time.map_or("not settled".into(), |time| format!("{} s", number(time, 3)))
}

/// All metrics as CSV with plain names and SI units, one line per scenario; absent values are empty.
#[must_use]
pub fn metrics_csv<'a>(results: impl IntoIterator<Item = (&'a str, &'a Metrics)>) -> String {
    let mut header = vec!["controller".to_owned()];
    for arm in 1..=2 {
        for name in ["target_N", "settling_2_s", "settling_5_s", "overshoot_percent", "steady_error_N"] {
            header.push(format!("force{arm}_{name}"));
        }
    }
    for (signal, unit) in [("tau1", "Nm"), ("tau2", "Nm"), ("u", "N")] {
        header.extend([
            format!("{signal}_peak_{unit}"),
            format!("{signal}_rms_{unit}"),
            format!("{signal}_saturated_s"),
        ]);
    }
    let optional = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let mut rows = vec![header];
    for (title, metrics) in results {
        let mut line = vec![title.to_owned()];
        for force in &metrics.forces {
            let ForceMetrics { target, settling_2, settling_5, overshoot, steady_error } = *force;
            line.extend([target.to_string(), optional(settling_2), optional(settling_5)]);
            line.extend([overshoot.to_string(), steady_error.to_string()]);
        }
        for effort in &metrics.efforts {
            let EffortMetrics { peak, rms, saturated } = *effort;
            line.extend([peak.to_string(), rms.to_string(), optional(saturated)]);
        }
        rows.push(line);
    }
    csv(rows)
}

/// Rows as comma-separated values (RFC 4180).
#[must_use]
pub fn csv(rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        // Writing to memory cannot fail, and all rows of a table have the same length.
        let _ = writer.write_record(row);
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// The metrics of a comparison as Markdown.
#[must_use]
pub fn metrics_markdown(runs: &[PaperRun]) -> String {
    let (forces, efforts) = tables(runs);
    format!(
        "## Contact forces\n\n\
         Settling: time after which the force stays within the band around its target. Overshoot: in % of the way from \
         the first value to the target. Steady error: mean over the last 5 % of the run. Last column: what the paper \
         states.\n\n{}\n\
         ## Control effort\n\n\
         Outputs of the actuators over the whole run.\n\n{}",
        forces.to_markdown(),
        efforts.to_markdown()
    )
}

/// Force and effort table of a comparison.
#[must_use]
pub fn tables(runs: &[PaperRun]) -> (TextTable, TextTable) {
    let forces = runs.iter().map(|run| (run.scenario.title, &run.metrics, run.scenario.paper));
    let efforts = runs.iter().map(|run| (run.scenario.title, &run.metrics));
    (force_table(forces), effort_table(efforts))
}

/// The report: the matrix if there is one, the setup of the paper's runs, their metrics, every figure. `setup` describes
/// how the runs were made.
#[must_use]
pub fn report(runs: &[PaperRun], figures: &[Drawn], setup: &str, matrix: Option<&Matrices>) -> String {
    let lead = matrix.map_or_else(String::new, |matrix| {
        let contact = matrix.contact.as_ref().map_or_else(String::new, |contact| {
            format!(
                "\n## {}\n\n![Settling times of all controllers in grasps that can open](contact.svg)\n\n{}",
                matrix::title(contact),
                matrix::markdown(contact)
            )
        });
        format!(
            "## {}\n\n![Settling times of all controllers in all cases](matrix.svg)\n\n{}{contact}\n## The paper's runs\n\n",
            matrix::title(&matrix.closed),
            matrix::markdown(&matrix.closed)
        )
    });
    let mut text = format!(
        "# Grasping with two flexible arms: NABFC, PDS and PD\n\n{lead}{setup}\n\n\
         [report.html](report.html) shows the same runs to play with: the arms in motion, curves to zoom into, the parameters \
         of every model.\n\n{}",
        metrics_markdown(runs).replace("\n## ", "\n### ").replacen("## ", "### ", 1)
    );
    text += "\n## Figures\n\n\
             Numbers are those of the paper. Each figure is there as SVG and PNG. Where curves are bands, they vibrate: \
             PD and PDS hardly damp the antisymmetric bending of the two arms, at about 90 Hz.\n";
    for figure in figures {
        let Drawn { name, caption, note, .. } = figure;
        let _ = write!(text, "\n### {caption}\n\n![{caption}](figures/{name}.svg)\n\n{note}\n");
    }
    text += "\n## Data\n\n";
    for run in runs {
        let (title, key) = (run.scenario.title, run.scenario.key);
        let _ = writeln!(text, "* [{key}.csv]({key}.csv): all outputs of plant and controller, {title}");
    }
    text += "* [metrics.csv](metrics.csv): the tables above in full digits\n";
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_aligned_and_valid_markdown() {
        let force =
            ForceMetrics { target: 0.5, settling_2: Some(0.38), settling_5: None, overshoot: 0.1, steady_error: -2e-5 };
        let effort = EffortMetrics { peak: 2.0, rms: 0.1, saturated: None };
        let metrics = Metrics { forces: [force; 2], efforts: [effort; 3] };
        let table = force_table([("NABFC", &metrics, "less than 0.5 s")]);
        let terminal = table.to_terminal(120);
        let lines: Vec<_> = terminal.lines().collect();
        assert_eq!(lines[2].find("0.380 s"), lines[3].find("0.380 s"));
        assert!(lines[2].contains("\u{2212}0.02 mN") && lines[2].ends_with("less than 0.5 s"));
        let narrow = table.to_terminal(80);
        assert!(narrow.lines().all(|line| line.chars().count() <= 80), "{narrow}");
        let lines: Vec<_> = narrow.lines().collect();
        assert!(lines[0].contains("contact") && lines[1].contains("force"), "headings go over two lines:\n{narrow}");
        let mut wide = TextTable::new(&["case", "one controller", "another one", "limit"]);
        wide.rows.push(["undisturbed", "0.15 (7 %)", "never", "0.04"].map(str::to_owned).into());
        assert_eq!(
            wide.to_terminal(28),
            "             one\ncase         controller\n───────────  ──────────\nundisturbed  0.15 (7 %)\n\n             another\n\
             case             one  limit\n───────────  ───────  ─────\nundisturbed    never   0.04\n"
        );
        assert!(table.to_markdown().lines().all(|line| line.matches('|').count() == 8));
        let csv = metrics_csv([("NABFC", &metrics)]);
        let columns: Vec<_> = csv.lines().map(|line| line.matches(',').count()).collect();
        assert_eq!(columns, [19, 19]);
        assert!(csv.contains(",0.38,,0.1,-0.00002,"), "{csv}");
    }
}

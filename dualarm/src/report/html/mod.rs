//! A page that shows runs: one file that needs neither network nor server.
//!
//! The page's own markup, style and scripts are in `assets/report/`, the plotting library in `assets/uplot/`. The scripts
//! are concatenated into one module, in the order of `SCRIPTS`: each can use those before it. Tables are generated here, so
//! they are visible without JavaScript, too; scripts draw curves and the animation from the packed rows. A run of a grasp
//! has an animation; every run has curves of all its signals.

mod markup;
mod packed;
mod parameters;
pub mod rows;
mod run;
pub mod signals;
pub mod tables;

use crate::grasp::matrix::Matrices;
use crate::report::figures::Drawn;
pub(crate) use markup::escape;
pub(crate) use markup::{fill, in_script, json_in_script};
pub use packed::Packed;
pub use run::Run;

const HEAD: &str = include_str!("../../../assets/report/head.html");
const TEMPLATE: &str = include_str!("../../../assets/report/page.html");
/// Parts of the page that some pages lack.
const MOTION: &str = include_str!("../../../assets/report/motion.html");
const SIGNALS: &str = include_str!("../../../assets/report/signals.html");
const READING: &str = include_str!("../../../assets/report/reading.html");
const TRANSPORT: &str = include_str!("../../../assets/report/transport.html");
const EXAGGERATION: &str = include_str!("../../../assets/report/exaggeration.html");
const STYLES: [&str; 3] = [
    include_str!("../../../assets/uplot/uPlot.min.css"),
    include_str!("../../../assets/report/style.css"),
    include_str!("../../../assets/report/print.css"),
];
const LIBRARY: &str = include_str!("../../../assets/uplot/uPlot.iife.min.js");
const LICENCE: &str = include_str!("../../../assets/uplot/LICENSE");
const SCRIPTS: [&str; 16] = [
    include_str!("../../../assets/report/unpack.js"),
    include_str!("../../../assets/report/data.js"),
    include_str!("../../../assets/report/theme.js"),
    include_str!("../../../assets/report/clock.js"),
    include_str!("../../../assets/report/frame.js"),
    include_str!("../../../assets/report/scene.js"),
    include_str!("../../../assets/report/trace.js"),
    include_str!("../../../assets/report/plot.js"),
    include_str!("../../../assets/report/drawing.js"),
    include_str!("../../../assets/report/files.js"),
    include_str!("../../../assets/report/mouse.js"),
    include_str!("../../../assets/report/touch.js"),
    include_str!("../../../assets/report/catalogue.js"),
    include_str!("../../../assets/report/charts.js"),
    include_str!("../../../assets/report/controls.js"),
    include_str!("../../../assets/report/main.js"),
];

/// The content of the page.
#[derive(Debug, Clone, Default)]
pub struct Page<'a> {
    /// The heading.
    pub title: String,
    /// An introduction, in a few sentences.
    pub lead: String,
    /// The runs, in the order of the page.
    pub runs: &'a [Run],
    /// How all of them were made, in one or two sentences.
    pub setup: String,
    /// Which rows of them the page has, in a sentence.
    pub rows: String,
    /// Controllers in many cases.
    pub matrix: Option<&'a Matrices>,
    /// Figures to take away.
    pub figures: &'a [Drawn],
    /// Tables of the caller's, as sections.
    pub tables: String,
    /// Files beside the page, and their descriptions.
    pub files: Vec<(String, String)>,
}

impl Page<'_> {
    /// The file's content.
    ///
    /// # Panics
    /// Never: the templates and their values belong together.
    #[must_use]
    pub fn to_html(&self) -> String {
        let has_motion = self.runs.iter().any(Run::is_grasp);
        let if_runs = |part: &str| if self.runs.is_empty() { String::new() } else { part.to_owned() };
        let if_motion = |part: &str| if has_motion { part.to_owned() } else { String::new() };
        let exaggeration = if_motion(EXAGGERATION);
        let transport = fill(TRANSPORT, |name| (name == "exaggeration").then(|| exaggeration.clone()));
        fill(TEMPLATE, |name| {
            Some(match name {
                "head" => head(&self.title, &self.lead, ""),
                "headline" => tables::headline(self.runs),
                "motion" => if_motion(MOTION),
                "signals" => if_runs(SIGNALS),
                "matrix" => self.matrix.map_or_else(String::new, tables::matrices),
                "metrics" => tables::metrics(self.runs),
                "tables" => self.tables.clone(),
                "figures" => tables::figures(self.figures),
                "parameters" => parameters::all(self.runs, &self.setup),
                "reading" => if_motion(READING),
                "rows" => escape(&self.rows),
                "files" => self.files_text(),
                "transport" => if_runs(&transport),
                "data" => in_script(format!(
                    "{{\"runs\":[{}]}}",
                    self.runs.iter().map(Run::data).collect::<Vec<_>>().join(",")
                )),
                "library" => LIBRARY.to_owned(),
                "library-version" => library_version().to_owned(),
                "library-licence" => escape(LICENCE),
                "scripts" => SCRIPTS.join("\n"),
                _ => return None,
            })
        })
    }

    /// The files that lie beside the page.
    fn files_text(&self) -> String {
        let links: Vec<String> = self
            .files
            .iter()
            .map(|(file, what)| format!("<a href=\"{0}\">{0}</a>: {1}", escape(file), escape(what)))
            .collect();
        if links.is_empty() {
            return String::new();
        }
        format!("<dt>Files beside this one</dt><dd>{}.</dd>", links.join("; "))
    }
}

/// The beginning of every page: title, lead, style sheet. `style` holds additional rules of the page.
pub(crate) fn head(title: &str, lead: &str, style: &str) -> String {
    fill(HEAD, |name| {
        Some(match name {
            "title" => escape(title),
            "lead" => escape(lead),
            "style" => STYLES.join("\n") + style,
            _ => return None,
        })
    })
}

/// From the first line of the library: `/*! … (v1.6.32) */`.
fn library_version() -> &'static str {
    LIBRARY.split_once("(v").and_then(|(_, rest)| rest.split_once(')')).map_or("", |(version, _)| version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_page_is_whole_also_without_runs_and_with_hostile_texts() {
        let empty = Page { title: "<script>".into(), ..Page::default() }.to_html();
        assert!(empty.contains("<title>&lt;script&gt;</title>") && !empty.contains("id=\"transport\""));
        let runs = [Run { title: "</script><b>".into(), notes: vec!["<i>".into()], ..Run::default() }];
        let page = Page { runs: &runs, ..Page::default() }.to_html();
        assert!(
            page.contains("id=\"transport\"") && !page.contains("id=\"exaggeration\""),
            "nothing moves without a grasp"
        );
        assert!(!page.contains("</script><b>") && !page.contains("<i>"));
    }
}

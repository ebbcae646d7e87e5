//! `documentation/index.html` and the files around it (FMI 2.0.4, section 2.3), generated from the same declarations as
//! the XML and from what the model's author wrote. The page is one file without scripts that loads nothing from
//! anywhere; the style sheet stands in it, formulas are `MathML`, charts SVG.

mod articles;
mod chart;
mod states;
mod tables;
mod text;

use std::fmt::Write as _;

use fmi2_export::packaging::{GENERATION_TOOL, Interface, Kind, VariableFacts, interface, number};
use fmi2_export::{Description, ExportedModel, Resources};
use quick_xml::escape::escape;
use tempfile::TempDir;

use self::chart::Chart;
use crate::platform::{PLATFORMS, Platform};
use crate::response::{self, Run};
use crate::{Document, File, PackageError, Response, requirements};

pub const INDEX: &str = "documentation/index.html";
const ICON: &str = "model.png";
const LICENSE: &str = "documentation/licenses/license.txt";
const RESULTS: &str = "documentation/response.csv";
const INPUTS: &str = "documentation/response_in.csv";
const BESIDE: &str = "documentation/response_beside.csv";
/// The licences of the crates that the library is linked from.
pub const LINKED_LICENSES: &str = "documentation/licenses/linked-crates.txt";
/// Where else the archive has files, which are not the author's.
const OURS: [&str; 5] = ["modelDescription.xml", "binaries/", "sources/", LINKED_LICENSES, requirements::PATH];

/// Where an archive comes from and what it is for.
pub struct Origin {
    package: &'static str,
    platforms: Vec<&'static Platform>,
}

impl Origin {
    /// The crate of the models, and the platforms that the archive has libraries for.
    pub fn new(package: &'static str, mut platforms: Vec<&'static Platform>) -> Self {
        platforms.sort_by_key(|platform| PLATFORMS.iter().position(|known| known == *platform));
        platforms.dedup();
        Self { package, platforms }
    }

    fn folders(&self) -> String {
        self.platforms.iter().map(|platform| platform.folder).collect::<Vec<_>>().join(", ")
    }

    /// An attribute of the page by which a later packaging knows whose archive it would replace.
    fn mark(&self) -> String {
        if self.package.is_empty() { String::new() } else { format!(" {MARK}\"{}\"", escape(self.package)) }
    }
}

const MARK: &str = "data-crate=";

/// The crate that a page is from, if it says so.
pub fn crate_of(page: &str) -> Option<&str> {
    page.split_once(MARK)?.1.split('"').nth(1)
}

/// The files of an archive besides description and library.
///
/// # Errors
/// If the document is at odds with the model or the standard.
pub fn files(
    model: &'static dyn ExportedModel,
    description: &Description,
    document: &Document<'_>,
    origin: &Origin,
) -> Result<Vec<(String, Vec<u8>)>, PackageError> {
    let interface = interface(model)?;
    let wrong = |problem| PackageError::Document { model: description.name, problem };
    let text = text::read(document.text).map_err(|error| wrong(articles::not_understood(&error)))?;
    // Before any of them is written anywhere.
    let no_path =
        |path: &str| wrong(format!("{path:?} cannot be the path of a further file: it is taken, or no relative path"));
    if let Some(file) = document.files.iter().find(|file| !is_relative(file.path)) {
        return Err(no_path(file.path));
    }
    let run = match &document.response {
        Some(wanted) => {
            // The model may read files that its archive will carry.
            let folder =
                unpacked(document.files).map_err(|error| wrong(format!("cannot unpack its resources: {error}")))?;
            let run = response::run(model, &interface, wanted, &Resources::at(folder.path()))
                .map_err(|source| PackageError::Response { model: description.name, source })?;
            Some((*wanted, run))
        }
        None => None,
    };
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    if !document.icon.is_empty() {
        if !document.icon.starts_with(b"\x89PNG\r\n\x1a\n") {
            return Err(wrong("the icon is no PNG, which FMI 2.0 wants model.png to be".into()));
        }
        files.push((ICON.into(), document.icon.to_vec()));
    }
    let page = Page { interface: &interface, description, document, origin, text: &text, run: run.as_ref() };
    files.push((INDEX.into(), page.to_html().map_err(wrong)?.into_bytes()));
    if !document.license.is_empty() {
        files.push((LICENSE.into(), document.license.into()));
    }
    if let Some((_, run)) = &run {
        files.push((RESULTS.into(), run.results_csv().into_bytes()));
        files.extend(run.inputs_csv().map(|csv| (INPUTS.into(), csv.into_bytes())));
        files.extend(run.beside_csv().map(|csv| (BESIDE.into(), csv.into_bytes())));
    }
    for file in document.files {
        let path = file.path;
        if OURS.iter().any(|ours| path.starts_with(ours)) || files.iter().any(|(taken, _)| taken == path) {
            return Err(no_path(path));
        }
        files.push((path.into(), file.content.to_vec()));
    }
    articles::add(&mut files, description.name, document.articles).map_err(wrong)?;
    if let Some(dead) = text.links.iter().find(|target| !articles::leads_somewhere(&files, target)) {
        return Err(wrong(format!(
            "its text has a link to {dead:?}, which is no address and no file of documentation/"
        )));
    }
    for image in &text.images {
        if !files.iter().any(|(path, _)| path.strip_prefix("documentation/") == Some(image.as_str())) {
            return Err(wrong(format!("the image {image} is not among its files as documentation/{image}")));
        }
    }
    Ok(files)
}

/// Whether an archive can have a file of this path.
fn is_relative(path: &str) -> bool {
    path.split('/').all(|part| !matches!(part, "" | "." | "..")) && !path.contains(['\\', ':'])
}

/// The files below `resources/` in a folder of their own.
fn unpacked(files: &[File<'_>]) -> std::io::Result<TempDir> {
    let folder = TempDir::new()?;
    for file in files {
        let Some(path) = file.path.strip_prefix("resources/") else { continue };
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap_or(folder.path()))?;
        std::fs::write(path, file.content)?;
    }
    Ok(folder)
}

/// How every page begins; `attributes` are those of its first element.
fn head(title: &str, attributes: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"{attributes}>\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <meta name=\"generator\" content=\"{GENERATION_TOOL}\"/>\n<title>{}</title>\n\
         <style>\n{}</style>\n</head>\n",
        escape(title),
        include_str!("style.css")
    )
}

struct Page<'a> {
    interface: &'a Interface,
    description: &'a Description,
    document: &'a Document<'a>,
    origin: &'a Origin,
    text: &'a text::Text,
    run: Option<&'a (Response<'a>, Run<'a>)>,
}

impl Page<'_> {
    fn to_html(&self) -> Result<String, String> {
        let mut html = head(self.description.name, &self.origin.mark()) + "<body>\n";
        self.header(&mut html);
        self.contents(&mut html);
        html.push_str("<main>\n");
        html.push_str(&self.text.html);
        self.response(&mut html)?;
        tables::variables(&mut html, self.interface);
        self.use_of_it(&mut html);
        self.license(&mut html);
        let _ = write!(
            html,
            "</main>\n<footer>Generated by {GENERATION_TOOL} from the declarations of the model, as its \
             <code>modelDescription.xml</code>.</footer>\n</body>\n</html>\n"
        );
        Ok(html)
    }

    fn header(&self, html: &mut String) {
        let info = &self.interface.info;
        html.push_str("<header>\n");
        if !self.document.icon.is_empty() {
            let _ = writeln!(html, "<img src=\"../{ICON}\" alt=\"\"/>");
        }
        let what = if self.interface.exchange.is_some() { "co-simulation and model-exchange" } else { "co-simulation" };
        let mut kind = vec![format!("FMI 2.0 {what} FMU")];
        if !info.version.is_empty() {
            kind.push(format!("version {}", info.version));
        }
        kind.extend([info.author, info.copyright].into_iter().filter(|text| !text.is_empty()).map(str::to_owned));
        if !info.license.is_empty() {
            kind.push(format!("licence {}", info.license));
        }
        let _ = writeln!(
            html,
            "<div>\n<h1>{}</h1>\n<p class=\"lead\">{}</p>\n<p class=\"kind\">{}</p>\n</div>\n</header>",
            escape(info.name),
            escape(info.description),
            escape(kind.join(" · "))
        );
    }

    fn contents(&self, html: &mut String) {
        let headings = self.text.headings.iter().map(|(id, title)| (id.as_str(), title.as_str()));
        let mut entries: Vec<(&str, &str)> = headings.collect();
        if self.run.is_some() {
            entries.push(("response", "Response"));
        }
        entries.extend([("variables", "Variables"), ("use", "Use")]);
        if self.has_license() {
            entries.push(("license", "Licence"));
        }
        html.push_str("<nav aria-label=\"Contents\"><ul>\n");
        for (id, title) in entries {
            let _ = writeln!(html, "<li><a href=\"#{id}\">{}</a></li>", escape(title));
        }
        html.push_str("</ul></nav>\n");
    }

    fn response(&self, html: &mut String) -> Result<(), String> {
        let Some((response, run)) = self.run else { return Ok(()) };
        html.push_str("<h2 id=\"response\">Response</h2>\n<figure>\n<div class=\"panels\">\n");
        for (panel, shown) in response.panels.iter().zip(&run.panels) {
            let (unit, factor) = shown.first().map_or(("", 1.0), |series| series.unit);
            let title = escape(panel.title);
            let _ = write!(html, "<div>\n<h3>{title}");
            if !matches!(unit, "" | "1") {
                let _ = write!(html, " <span>({})</span>", escape(unit));
            }
            html.push_str("</h3>\n<p class=\"legend\">");
            for (i, series) in shown.iter().enumerate() {
                let _ = write!(html, "<span class=\"c{}\"><code>{}</code></span>", i + 1, escape(series.name));
            }
            html.push_str("</p>\n");
            let scaled = |values: &Vec<f64>| values.iter().map(|value| factor * value).collect();
            let curves: Vec<Vec<f64>> = shown.iter().map(|series| scaled(&series.values)).collect();
            if let Some(series) = shown.iter().zip(&curves).find(|(_, curve)| !curve.iter().all(|v| v.is_finite())) {
                return Err(format!("{} is not finite in the response", series.0.name));
            }
            let names: Vec<&str> = shown.iter().map(|series| series.name).collect();
            let label = format!("{}: {} over time", panel.title, names.join(", "));
            html.push_str(&Chart { times: &run.times, curves: &curves, label: &label }.to_svg());
            html.push_str("</div>\n");
        }
        let caption = text::read(response.caption)
            .map_err(|error| format!("the formula ${}$ in the response's caption is not understood", error.formula))?;
        let _ = writeln!(html, "</div>\n<figcaption>\n{}</figcaption>\n</figure>", caption.html);
        let _ = writeln!(
            html,
            "<p>The curves were computed by the packaging program, which runs the same code as the FMU with a \
             communication step of {} s; the numbers are in <a href=\"response.csv\"><code>{RESULTS}</code></a>{}. To \
             repeat it from the FMU with <a href=\"https://fmpy.readthedocs.io\">FMPy</a>{}:</p>\n\
             <pre class=\"command\"><code>{}</code></pre>",
            response.step_size,
            if run.beside_csv().is_none() {
                String::new()
            } else {
                format!(", those of what is around it in <a href=\"response_beside.csv\"><code>{BESIDE}</code></a>")
            },
            if run.inputs.is_empty() { "" } else { ", where the FMU and what it contains lie side by side" },
            escape(self.command(response, run))
        );
        Ok(())
    }

    /// The command that makes the same results from the FMU.
    fn command(&self, response: &Response<'_>, run: &Run<'_>) -> String {
        let mut command = format!(
            "fmpy simulate {}.fmu --stop-time {} --output-interval {}",
            self.description.name, response.stop_time, response.step_size
        );
        if !response.start.is_empty() {
            command.push_str(" --start-values");
            for (name, value) in response.start {
                let is_boolean = |variable: &VariableFacts| variable.name == *name && variable.kind == Kind::Boolean;
                let is_boolean = self.interface.variables.iter().any(is_boolean);
                let value = if is_boolean { (*value != 0.0).to_string() } else { value.to_string() };
                let _ = write!(command, " {} {value}", quoted(name));
            }
        }
        if !run.inputs.is_empty() {
            let _ = write!(command, " --input-file {INPUTS}");
        }
        command.push_str(" --output-variables");
        for series in run.panels.iter().flatten().filter(|series| series.is_of_model()) {
            let _ = write!(command, " {}", quoted(series.name));
        }
        command + " --show-plot"
    }

    fn use_of_it(&self, html: &mut String) {
        let experiment = &self.interface.info.default_experiment;
        html.push_str("<h2 id=\"use\">Use</h2>\n");
        let mut rows: Vec<(&str, String)> = vec![(
            "Default experiment",
            format!(
                "from {} s to {} s, communication step {} s",
                experiment.start_time, experiment.stop_time, experiment.step_size
            ),
        )];
        if let Some(tolerance) = experiment.tolerance {
            rows.push(("Relative tolerance", number(tolerance)));
        }
        rows.extend(tables::capabilities(self.interface));
        rows.push(("Binary for", self.origin.folders()));
        rows.push(("Generation tool", GENERATION_TOOL.to_owned()));
        let command = if self.document.command.is_empty() { "cargo fmi2 package" } else { self.document.command };
        rows.push(("Made by", command.to_owned()));
        rows.push(("GUID", self.description.guid.clone()));
        html.push_str("<table class=\"facts\">\n<tbody>\n");
        for (what, value) in rows {
            let _ = writeln!(html, "<tr><th scope=\"row\">{what}</th><td>{}</td></tr>", escape(&value));
        }
        html.push_str("</tbody>\n</table>\n");
        tables::units(html, self.interface);
    }

    fn has_license(&self) -> bool {
        !self.document.license.is_empty() || !self.interface.info.license.is_empty()
    }

    fn license(&self, html: &mut String) {
        if !self.has_license() {
            return;
        }
        html.push_str("<h2 id=\"license\">Licence</h2>\n");
        if !self.interface.info.license.is_empty() {
            let _ = writeln!(html, "<p>{}</p>", escape(self.interface.info.license));
        }
        if !self.document.license.is_empty() {
            let _ = writeln!(
                html,
                "<details><summary>The full text, also in <a href=\"licenses/license.txt\"><code>{LICENSE}</code></a>\
                 </summary>\n<pre class=\"command\">{}</pre></details>",
                escape(self.document.license)
            );
        }
    }
}

/// A name as an argument of a shell's command.
fn quoted(name: &str) -> String {
    if name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '-')) {
        name.to_owned()
    } else {
        format!("'{}'", name.replace('\'', "'\\''"))
    }
}

//! Further pages of the documentation, and a check of links: none may lead to a file that the archive does not have.

use quick_xml::escape::escape;

use super::page::head;
use super::text::{self, FormulaError};
use super::{INDEX, is_relative};
use crate::Article;

type Files = [(String, Vec<u8>)];

/// Adds a page for each article. Articles may link to each other and to all other files.
///
/// # Errors
/// A fault of one of them.
pub fn add(files: &mut Vec<(String, Vec<u8>)>, model: &str, articles: &[Article<'_>]) -> Result<(), String> {
    for Article { path, .. } in articles {
        let is_page = path.starts_with("documentation/")
            && path.rsplit_once('.').is_some_and(|(_, extension)| extension == "html")
            && is_relative(path);
        if !is_page || files.iter().any(|(taken, _)| taken == path) {
            return Err(format!("{path:?} cannot be the path of an article: documentation/NAME.html, not taken yet"));
        }
        files.push(((*path).into(), Vec::new()));
    }
    for article in articles {
        let text = text::read_where(article.text, &|target| leads_somewhere(files, target))
            .map_err(|error| not_understood(&error))?;
        let html = page(model, article, &text.html);
        files.iter_mut().filter(|(path, _)| path == article.path).for_each(|(_, old)| *old = html.clone().into_bytes());
    }
    Ok(())
}

/// Whether a link in the documentation's pages leads to an anchor in the page, to an address, or to a file of the archive.
pub fn leads_somewhere(files: &Files, target: &str) -> bool {
    let is_address = ["https:", "http:", "mailto:"].iter().any(|scheme| target.starts_with(scheme));
    let file = target.split('#').next().unwrap_or_default();
    let is_file = |path: &str| path.strip_prefix("documentation/") == Some(file);
    is_address || file.is_empty() || files.iter().any(|(path, _)| is_file(path))
}

pub fn not_understood(error: &FormulaError) -> String {
    format!("the formula ${}$ is not understood: {}", error.formula, error.reason.replace('\n', " "))
}

fn page(model: &str, article: &Article<'_>, html: &str) -> String {
    let index = INDEX.trim_start_matches("documentation/");
    format!(
        "{}<body>\n<main>\n<p class=\"kind\"><a href=\"{index}\">{model}</a> · {}</p>\n{html}</main>\n</body>\n</html>\n",
        head(&format!("{}: {model}", article.title), ""),
        escape(article.about)
    )
}

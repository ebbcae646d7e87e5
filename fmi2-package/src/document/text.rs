//! Converts the author's text from Markdown with LaTeX formulas to HTML with `MathML`, which browsers show without scripts,
//! fonts or a network.

use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd};
use pulldown_latex::config::DisplayMode;
use pulldown_latex::{RenderConfig, Storage, push_mathml};

/// A text as HTML.
pub struct Text {
    /// Elements for the page's body.
    pub html: String,
    /// Identifiers and titles of the second-level headings.
    pub headings: Vec<(String, String)>,
    /// Addresses of the images.
    pub images: Vec<String>,
    /// Targets of its links.
    pub links: Vec<String>,
}

/// A formula that is not valid LaTeX.
#[derive(Debug)]
pub struct FormulaError {
    /// The formula.
    pub formula: String,
    /// The fault.
    pub reason: String,
}

/// Reads Markdown. HTML in it is shown as text: only the program writes the page's markup.
///
/// # Errors
/// The first formula that is not valid LaTeX.
pub fn read(markdown: &str) -> Result<Text, FormulaError> {
    read_where(markdown, &|_| true)
}

/// The same for a text whose links and images have other targets where it is written: pairs of there and here.
///
/// # Errors
/// As [`read`].
pub fn read_from(markdown: &str, links: &[(&str, &str)]) -> Result<Text, FormulaError> {
    read_with(markdown, links, &|_| true)
}

/// The same for a text from another place: a link to a file that does not exist here becomes plain text.
///
/// # Errors
/// As [`read`].
pub fn read_where(markdown: &str, is_here: &dyn Fn(&str) -> bool) -> Result<Text, FormulaError> {
    read_with(markdown, &[], is_here)
}

fn read_with(markdown: &str, links: &[(&str, &str)], is_here: &dyn Fn(&str) -> bool) -> Result<Text, FormulaError> {
    let options = Options::ENABLE_TABLES | Options::ENABLE_MATH | Options::ENABLE_FOOTNOTES;
    let mut text = Text { html: String::new(), headings: Vec::new(), images: Vec::new(), links: Vec::new() };
    // Whether the present link has an existing target. Links are never nested.
    let mut is_link = true;
    let mut events = Vec::new();
    // Where the heading being read began, and its title so far.
    let mut heading: Option<(usize, String)> = None;
    for mut event in Parser::new_ext(markdown, options) {
        if let Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) = &mut event
            && let Some((_, here)) = links.iter().find(|(there, _)| *there == &**dest_url)
        {
            *dest_url = CowStr::from((*here).to_owned());
        }
        match &event {
            Event::Start(Tag::Heading { level: HeadingLevel::H2, .. }) => heading = Some((events.len(), String::new())),
            Event::Text(part) | Event::Code(part) => {
                if let Some((_, title)) = &mut heading {
                    title.push_str(part);
                }
            }
            Event::End(TagEnd::Heading(HeadingLevel::H2)) => {
                if let Some((start, title)) = heading.take() {
                    let id = identifier(&title);
                    if let Event::Start(Tag::Heading { id: slot, .. }) = &mut events[start] {
                        *slot = Some(CowStr::from(id.clone()));
                    }
                    text.headings.push((id, title));
                }
            }
            Event::Start(Tag::Image { dest_url, .. }) => text.images.push(dest_url.to_string()),
            Event::Start(Tag::Link { dest_url, .. }) => {
                is_link = is_here(dest_url);
                text.links.push(dest_url.to_string());
            }
            _ => {}
        }
        if !is_link && matches!(event, Event::Start(Tag::Link { .. }) | Event::End(TagEnd::Link)) {
            continue;
        }
        events.push(match event {
            Event::InlineMath(formula) => Event::InlineHtml(mathml(&formula, DisplayMode::Inline)?.into()),
            Event::DisplayMath(formula) => {
                // Formulas that are wider than a phone can be scrolled.
                let math = mathml(&formula, DisplayMode::Block)?;
                Event::InlineHtml(format!("<span class=\"formula\">{math}</span>").into())
            }
            Event::Html(html) | Event::InlineHtml(html) => Event::Text(html),
            other => other,
        });
    }
    pulldown_cmark::html::push_html(&mut text.html, events.into_iter());
    Ok(text)
}

fn mathml(formula: &str, display_mode: DisplayMode) -> Result<String, FormulaError> {
    let error = |reason: String| FormulaError { formula: formula.to_owned(), reason };
    let storage = Storage::new();
    // The writer shows errors in the page; here they stop the packaging.
    let events = pulldown_latex::Parser::new(formula, &storage)
        .collect::<Result<Vec<_>, _>>()
        .map_err(|reason| error(reason.to_string()))?;
    let mut html = String::new();
    let events = events.into_iter().map(Ok::<_, pulldown_latex::ParserError>);
    let config = RenderConfig { display_mode, ..RenderConfig::default() };
    push_mathml(&mut html, events, config).map_err(|reason| error(reason.to_string()))?;
    // pulldown-latex 0.8 writes HTML that is not valid XML: it escapes its own entity, but not the symbols < and &, and
    // omits the space before an attribute.
    let repairs = [
        ("&amp;nbsp;", "\u{a0}"),
        ("&nbsp;", "\u{a0}"),
        ("><</", ">&lt;</"),
        (">&</", ">&amp;</"),
        ("\"minsize=", "\" minsize="),
    ];
    Ok(repairs.iter().fold(html, |html, (wrong, right)| html.replace(wrong, right)))
}

/// A heading's title as an identifier: `What it models` becomes `what-it-models`.
fn identifier(title: &str) -> String {
    let words = title.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    format!("text-{}", words.map(str::to_lowercase).collect::<Vec<_>>().join("-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_to_what_is_not_here_are_only_their_texts() {
        let text = read_where("[a](a.html) [*b*](b.md#x) [c](#c)\n", &|target| target != "b.md#x").unwrap();
        assert_eq!(text.html, "<p><a href=\"a.html\">a</a> <em>b</em> <a href=\"#c\">c</a></p>\n");
        assert_eq!(text.links, ["a.html", "b.md#x", "#c"]);
    }

    #[test]
    fn links_of_the_text_s_own_place_lead_to_files_here() {
        let links = [("../docs/a.md", "a.html"), ("../docs/b.svg", "b.svg")];
        let text = read_from("[a](../docs/a.md) ![b](../docs/b.svg) [c](c.md)\n", &links).unwrap();
        assert_eq!((text.links, text.images), (vec!["a.html".to_owned(), "c.md".into()], vec!["b.svg".to_owned()]));
        assert!(text.html.contains("href=\"a.html\"") && text.html.contains("src=\"b.svg\""), "{}", text.html);
    }

    #[test]
    fn formulas_become_mathml_and_headings_can_be_linked_to() {
        let text = read("## The *beam* `EI`\nWith $\\dot x$:\n$$EI\\, w''(0) = -\\lambda l$$\n").unwrap();
        assert_eq!(text.headings, [("text-the-beam-ei".to_owned(), "The beam EI".to_owned())]);
        assert!(text.html.contains("<h2 id=\"text-the-beam-ei\">"));
        assert!(text.html.contains("<math display=\"inline\">") && text.html.contains("<math display=\"block\">"));
        assert!(text.html.contains('λ') && !text.html.contains('$'), "{}", text.html);
    }

    #[test]
    fn formulas_are_well_formed_xml() {
        let html = read("$\\bigl( a \\ b~c \\bigr)\\ \\text{if } x<1 \\& y$").unwrap().html;
        let mut reader = quick_xml::Reader::from_str(&html);
        loop {
            match reader.read_event().expect(&html) {
                quick_xml::events::Event::Eof => break,
                quick_xml::events::Event::Start(element) | quick_xml::events::Event::Empty(element) => {
                    assert!(element.attributes().all(|attribute| attribute.is_ok()), "{html}");
                }
                _ => {}
            }
        }
        assert!(!html.contains("nbsp"), "{html}");
    }

    #[test]
    fn html_is_shown_and_not_done() {
        let html = read("<script>alert(1)</script>\n\nand <b>this</b> & $a<b$").unwrap().html;
        assert!(!html.contains("<script") && !html.contains("<b>") && html.contains("&lt;script&gt;"), "{html}");
    }

    #[test]
    fn what_is_no_formula_is_named() {
        let error = read("$\\frac{1}$ and more").err().unwrap();
        assert_eq!(error.formula, "\\frac{1}");
        assert!(!error.reason.is_empty());
    }
}

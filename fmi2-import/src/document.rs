//! XML documents, with limits so that a small file cannot take hours or all memory, and the lines of their elements.
//! The readers of descriptions, SSP documents and scenarios share this module; it is not part of the stable interface.

use roxmltree::{Document, Node, ParsingOptions};

/// Largest number of elements and pieces of text in a document. A description of half a million variables has half as many.
pub const MAX_NODES: u32 = 5_000_000;
/// Attributes of one element: the parser compares each with all others.
pub const MAX_ATTRIBUTES: usize = 256;
/// Elements inside each other.
pub const MAX_DEPTH: usize = 256;
/// Namespaces that are declared around an element.
pub const MAX_NAMESPACES: usize = 256;

/// Why a text is not read as XML.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum XmlError {
    /// Not well-formed.
    #[error("it is not well-formed XML: {0}")]
    Syntax(roxmltree::Error),
    /// More of something than any document needs.
    #[error("line {line}: there are more than {most} {what}; this tool does not read such documents")]
    Limit {
        /// The limited quantity.
        what: &'static str,
        /// How many may be.
        most: usize,
        /// Line in the file.
        line: usize,
    },
}

/// Parses a text.
///
/// # Errors
/// When it is not well-formed, has a document type definition, or exceeds a limit of this module.
pub fn parse(text: &str) -> Result<Document<'_>, XmlError> {
    check_limits(text)?;
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::NodesLimitReached => {
            XmlError::Limit { what: "elements and texts", most: MAX_NODES as usize, line: 1 }
        }
        other => XmlError::Syntax(other),
    })
}

/// Where the lines of a text begin. Asking the document itself counts them from its start each time.
#[derive(Debug, Clone, Default)]
pub struct Lines(Vec<usize>);

impl Lines {
    /// The lines of a text.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Self(std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect())
    }

    /// The line (from 1) that the byte `offset` is in.
    #[must_use]
    pub fn line(&self, offset: usize) -> usize {
        self.0.partition_point(|begin| *begin <= offset)
    }

    /// The line (from 1) where a node of the text's document begins.
    #[must_use]
    pub fn of_node(&self, node: Node) -> u32 {
        u32::try_from(self.line(node.range().start)).unwrap_or(u32::MAX)
    }

    /// Line and column (from 1, in characters) of the byte `offset` of the text these are the lines of.
    #[must_use]
    pub fn position(&self, text: &str, offset: usize) -> (usize, usize) {
        let line = self.line(offset);
        let begin = self.0[line - 1];
        let column = text.get(begin..offset).map_or(0, |before| before.chars().count());
        (line, column + 1)
    }
}

/// Counts everything for which the parser needs more than linear time. The parser itself refuses a text that is not
/// well-formed.
fn check_limits(text: &str) -> Result<(), XmlError> {
    let limit = |what, most, rest: &str| {
        let before = &text[..text.len() - rest.len()];
        Err(XmlError::Limit { what, most, line: before.matches('\n').count() + 1 })
    };
    let mut namespaces: Vec<usize> = Vec::new(); // of the elements around, each with all that are around it
    let mut rest = text;
    while let Some(at) = rest.find('<') {
        rest = &rest[at..];
        let special = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("</", ">"), ("<!", ">")];
        if let Some((begin, end)) = special.into_iter().find(|(begin, _)| rest.starts_with(begin)) {
            if begin == "</" {
                namespaces.pop();
            }
            let Some(at) = rest[begin.len()..].find(end) else { return Ok(()) };
            rest = &rest[begin.len() + at + end.len()..];
            continue;
        }
        let Some(tag) = Tag::of(rest) else { return Ok(()) };
        if tag.attributes > MAX_ATTRIBUTES {
            return limit("attributes in one element", MAX_ATTRIBUTES, rest);
        }
        let around = namespaces.last().copied().unwrap_or(0) + tag.namespaces;
        if around > MAX_NAMESPACES {
            return limit("namespaces around one element", MAX_NAMESPACES, rest);
        }
        if !tag.is_empty {
            namespaces.push(around);
            if namespaces.len() > MAX_DEPTH {
                return limit("elements inside each other", MAX_DEPTH, rest);
            }
        }
        rest = &rest[tag.length..];
    }
    Ok(())
}

/// The text between `<` and `>`.
struct Tag {
    length: usize,
    attributes: usize,
    namespaces: usize,
    is_empty: bool,
}

impl Tag {
    fn of(text: &str) -> Option<Self> {
        let bytes = text.as_bytes();
        let (mut at, mut attributes, mut namespaces) = (0, 0, 0);
        while let Some(&byte) = bytes.get(at) {
            match byte {
                // Values are long: lists of hundreds of variables.
                b'"' | b'\'' => at += 1 + text[at + 1..].find(char::from(byte))?,
                b'=' => attributes += 1,
                b'x' if bytes[at - 1].is_ascii_whitespace() && bytes[at..].starts_with(b"xmlns") => namespaces += 1,
                b'>' => return Some(Self { length: at + 1, attributes, namespaces, is_empty: bytes[at - 1] == b'/' }),
                _ => {}
            }
            at += 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        parse(text).err().map(|error| error.to_string()).unwrap_or_default()
    }

    #[test]
    fn what_would_take_hours_is_refused_at_once() {
        let attributes = |count: usize| (0..count).map(|index| format!(" a{index}='>'")).collect::<Vec<_>>().concat();
        assert!(parse(&format!("<a><!-- <b> --><![CDATA[<c>]]><b{}/></a>", attributes(MAX_ATTRIBUTES))).is_ok());
        assert!(
            message(&format!("<a>\n<b{}/></a>", attributes(100_000)))
                .starts_with("line 2: there are more than 256 attributes")
        );

        let nested = |depth: usize, inside: &str| {
            let begin: Vec<_> = (0..depth).map(|index| format!("<a xmlns:n{index}{inside}='n{index}'>")).collect();
            begin.concat() + &"</a>".repeat(depth)
        };
        assert!(parse(&nested(MAX_DEPTH, "")).is_ok());
        assert!(message(&nested(MAX_DEPTH + 1, "")).contains("namespaces around one element"));
        let deep = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
        assert!(message(&deep).contains("more than 256 elements inside each other"));
        let siblings = "<b xmlns:n='n'></b>".repeat(1000);
        assert!(parse(&format!("<a>{siblings}</a>")).is_ok());
        assert!(message("<a><!-- </a>").starts_with("it is not well-formed XML"));
        assert!(message("<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>").contains("not well-formed"));
    }

    #[test]
    fn lines_are_those_of_the_document() {
        let text = "<a>\n <b/>\n\n<c\n d=''/></a>";
        let (document, lines) = (parse(text).unwrap(), Lines::of(text));
        for node in document.descendants() {
            let expected = document.text_pos_at(node.range().start);
            assert_eq!(lines.of_node(node), expected.row);
            let (line, column) = lines.position(text, node.range().start);
            assert_eq!((line, column), (expected.row as usize, expected.col as usize));
        }
    }
}

//! A short way to read the usual description: elements with attributes, and nothing between them but blanks and comments.
//!
//! A text that has anything else, or any fault, is left to the general parser, which reads it or says what is wrong and where. So
//! this one may give up whenever something is rare; but what it reads, it reads as the general parser does (tested).

use std::borrow::Cow;

use crate::xml::Element;

/// Elements inside each other, and attributes of one element. Both are well below what the general parser allows.
const MAX_DEPTH: usize = 64;
const MAX_ATTRIBUTES: usize = 64;
/// Elements of a document, well below what the general parser allows.
const MAX_ELEMENTS: usize = 1_000_000;

/// A document whose texts are those of the file.
pub(crate) struct Tree<'a> {
    text: &'a str,
    /// In the order of their beginnings.
    entries: Vec<Entry<'a>>,
    attributes: Vec<(&'a str, Cow<'a, str>)>,
}

struct Entry<'a> {
    name: &'a str,
    /// Where it begins in the text.
    offset: usize,
    /// Its attributes end before this one; they begin where those of the element before end.
    attributes: usize,
    /// The elements inside it end before this one.
    inside: usize,
}

/// An element of a [`Tree`].
#[derive(Clone, Copy)]
pub(crate) struct TreeElement<'a> {
    tree: &'a Tree<'a>,
    index: usize,
}

impl<'a> Tree<'a> {
    /// Reads a text; `None` if that is a matter of the general parser.
    pub fn of(text: &'a str) -> Option<Self> {
        let mut reader = Reader { text, at: 0 };
        let mut tree = Self { text, entries: Vec::new(), attributes: Vec::new() };
        reader.declaration()?;
        let mut open: Vec<usize> = Vec::with_capacity(MAX_DEPTH);
        loop {
            reader.blanks();
            let offset = reader.at;
            if reader.skip("<!--") {
                reader.comment()?;
            } else if reader.skip("</") {
                let closed = open.pop()?;
                tree.entries[closed].inside = tree.entries.len();
                if !reader.skip(tree.entries[closed].name) || !reader.skip(">") {
                    return None;
                }
            } else if reader.skip("<") {
                let is_second_root = open.is_empty() && !tree.entries.is_empty();
                if is_second_root || open.len() == MAX_DEPTH || tree.entries.len() == MAX_ELEMENTS {
                    return None;
                }
                let index = tree.entries.len();
                let name = reader.name()?;
                let is_closed = reader.attributes(&mut tree.attributes)?;
                tree.entries.push(Entry { name, offset, attributes: tree.attributes.len(), inside: index + 1 });
                if !is_closed {
                    open.push(index);
                }
            } else {
                let is_whole = reader.at == text.len() && open.is_empty() && !tree.entries.is_empty();
                return is_whole.then_some(tree);
            }
        }
    }

    /// The element around all others.
    pub fn root(&'a self) -> TreeElement<'a> {
        TreeElement { tree: self, index: 0 }
    }
}

impl<'a> Element<'a> for TreeElement<'a> {
    fn name(self) -> &'a str {
        self.tree.entries[self.index].name
    }

    fn attribute(self, name: &str) -> Option<&'a str> {
        let entries = &self.tree.entries;
        let begin = self.index.checked_sub(1).map_or(0, |before| entries[before].attributes);
        let mut attributes = self.tree.attributes[begin..entries[self.index].attributes].iter();
        attributes.find(|(known, _)| *known == name).map(|(_, value)| &**value)
    }

    fn children(self) -> impl Iterator<Item = Self> {
        let Self { tree, index } = self;
        let mut next = index + 1;
        std::iter::from_fn(move || {
            let child = (next < tree.entries[index].inside).then_some(Self { tree, index: next })?;
            next = tree.entries[next].inside;
            Some(child)
        })
    }

    fn line(self) -> u32 {
        let before = &self.tree.text[..self.tree.entries[self.index].offset];
        u32::try_from(before.matches('\n').count() + 1).unwrap_or(u32::MAX)
    }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    /// Goes on behind this text, if it is next.
    fn skip(&mut self, expected: &str) -> bool {
        let is_next = self.text.as_bytes()[self.at..].starts_with(expected.as_bytes());
        self.at += if is_next { expected.len() } else { 0 };
        is_next
    }

    fn blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\n' | b'\t' | b'\r')) {
            self.at += 1;
        }
    }

    /// The usual first line, if there is one.
    fn declaration(&mut self) -> Option<()> {
        if self.skip("<?") {
            let usual = [r#"xml version="1.0" encoding="UTF-8"?>"#, r#"xml version="1.0" encoding="utf-8"?>"#];
            return usual.iter().any(|usual| self.skip(usual)).then_some(());
        }
        Some(())
    }

    /// The rest of a comment.
    fn comment(&mut self) -> Option<()> {
        let length = self.text[self.at..].find("--")?;
        let comment = &self.text[self.at..self.at + length];
        let is_usual = |byte: u8| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~');
        self.at += length + 2;
        (comment.bytes().all(is_usual) && self.skip(">")).then_some(())
    }

    /// A name without a namespace.
    fn name(&mut self) -> Option<&'a str> {
        let begin = self.at;
        while matches!(self.peek(), Some(b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_' | b'-' | b'.')) {
            self.at += 1;
        }
        let name = &self.text[begin..self.at];
        let can_begin = name.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_');
        (can_begin && name != "xmlns").then_some(name)
    }

    /// The attributes of an element, and the end of its tag. Whether it is the end of the element, too.
    fn attributes(&mut self, attributes: &mut Vec<(&'a str, Cow<'a, str>)>) -> Option<bool> {
        let begin = attributes.len();
        loop {
            let before = self.at;
            self.blanks();
            if self.skip("/>") {
                return Some(true);
            }
            if self.skip(">") {
                return Some(false);
            }
            if self.at == before || attributes.len() - begin == MAX_ATTRIBUTES {
                return None;
            }
            let name = self.name()?;
            if !self.skip("=\"") || attributes[begin..].iter().any(|(known, _)| *known == name) {
                return None;
            }
            attributes.push((name, self.value()?));
        }
    }

    /// The rest of an attribute's value.
    fn value(&mut self) -> Option<Cow<'a, str>> {
        let begin = self.at;
        let mut has_entities = false;
        loop {
            let rest = &self.text.as_bytes()[self.at..];
            self.at += rest.iter().position(|byte| ENDS[usize::from(*byte)])?;
            match self.text.as_bytes()[self.at] {
                b'"' => break,
                b'&' => has_entities = true,
                // Blanks other than spaces become spaces; nothing else of this is allowed.
                _ => return None,
            }
            self.at += 1;
        }
        let value = &self.text[begin..self.at];
        self.at += 1;
        if !value.is_ascii() && value.contains(['\u{fffe}', '\u{ffff}']) {
            return None;
        }
        if has_entities { resolved(value).map(Cow::Owned) } else { Some(Cow::Borrowed(value)) }
    }
}

/// The bytes at which the plain text of an attribute's value ends.
const ENDS: [bool; 256] = {
    let mut ends = [false; 256];
    let mut control = 0;
    while control < 0x20 {
        ends[control] = true;
        control += 1;
    }
    (ends[b'"' as usize], ends[b'&' as usize], ends[b'<' as usize]) = (true, true, true);
    ends
};

/// The value with characters in place of XML's own entities.
fn resolved(value: &str) -> Option<String> {
    const ENTITIES: [(&str, char); 5] = [("amp;", '&'), ("lt;", '<'), ("gt;", '>'), ("quot;", '"'), ("apos;", '\'')];
    let mut pieces = value.split('&');
    let mut text = String::with_capacity(value.len());
    text.push_str(pieces.next()?);
    for piece in pieces {
        let (rest, character) =
            ENTITIES.iter().find_map(|(name, character)| Some((piece.strip_prefix(name)?, *character)))?;
        text.push(character);
        text.push_str(rest);
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;
    use crate::document;

    const USUAL: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<!-- one -->
<a b="1 &lt; 2" c-1="µ &quot;">
  <b.c/><d _e="x/>"><f/>

  <!-- two --></d>
</a>
"#;

    /// Everything of an element.
    fn shown<'a>(element: impl Element<'a>, text: &mut String) {
        let attributes = ["b", "c-1", "_e", "x", "xb", "bx"].map(|name| element.attribute(name));
        write!(text, "{} {} {attributes:?} [", element.name(), element.line()).unwrap();
        element.children().filter(|child| !child.name().is_empty()).for_each(|child| shown(child, text));
        *text += "]";
    }

    /// Reads a text both ways. Whether the short way does.
    fn is_read_alike(text: &str) -> bool {
        let Some(tree) = Tree::of(text) else { return false };
        let document = document::parse(text).unwrap_or_else(|error| panic!("{text:?} is read, but {error}"));
        let (mut short, mut general) = (String::new(), String::new());
        shown(tree.root(), &mut short);
        shown(document.root_element(), &mut general);
        assert_eq!(short, general, "{text}");
        true
    }

    #[test]
    fn what_is_usual_is_read() {
        assert!(is_read_alike(USUAL));
        for rare in ["", " ", "<a/><b/>", "<a></b>", "<a>", "</a>", "<a>text</a>", "<a b='1'/>", "<a xmlns=\"u\"/>"] {
            assert!(!is_read_alike(rare), "{rare}");
        }
    }

    /// Whatever happens to a text, what is still read is read as before.
    #[test]
    fn the_general_parser_agrees() {
        let pieces = [
            "",
            "<",
            ">",
            "/",
            "&",
            ";",
            "\"",
            "'",
            "=",
            " ",
            "\n",
            "\r\n",
            "\t",
            "\0",
            "-",
            "--",
            "-->",
            "<!--",
            "x",
            ":",
            "1",
            "µ",
            "\u{fffe}",
            "&amp;",
            "&#10;",
            "<x/>",
            "]]>",
            "<![CDATA[",
            "<?x?>",
            "<!DOCTYPE a>",
            "xmlns",
            " b=\"2\"",
            "\u{7f}",
            "\u{85}",
        ];
        let (mut read, mut left) = (0, 0);
        let places: Vec<usize> = (0..=USUAL.len()).filter(|place| USUAL.is_char_boundary(*place)).collect();
        for (index, &from) in places.iter().enumerate() {
            for &to in places[index..].iter().take(3) {
                for piece in pieces {
                    let changed = [&USUAL[..from], piece, &USUAL[to..]].concat();
                    *(if is_read_alike(&changed) { &mut read } else { &mut left }) += 1;
                }
            }
        }
        assert!(read > 1000 && left > 1000, "{read} texts are read, {left} are left to the general parser");
    }
}

//! A short way to read the usual description: elements with attributes, and nothing between them but blanks and comments.
//!
//! A text that has anything else, or any fault, is left to the general parser, which reads it or says what is wrong and where. So
//! this one may give up whenever something is rare; but what it reads, it reads as the general parser does (tested).

mod reader;

use crate::xml::Element;
use reader::Reader;

/// Elements inside each other, well below what the general parser allows.
const MAX_DEPTH: usize = 64;
/// Elements of a document, well below what the general parser allows.
const MAX_ELEMENTS: usize = 1_000_000;

/// A document whose texts are those of the file. It is as small as can be: half of the time that reading takes would be for memory
/// that nobody had touched before.
pub(crate) struct Tree<'a> {
    text: &'a str,
    /// In the order of their beginnings.
    entries: Vec<Entry>,
    attributes: Vec<Attribute>,
    /// Values that are not in the text as they are, one behind the other. Their places are counted as if they stood behind the text.
    resolved: String,
}

struct Entry {
    /// Its name in the text; it begins one byte before.
    name: Span,
    /// Its attributes end before this one; they begin where those of the element before end.
    attributes: u32,
    /// The elements inside it end before this one.
    inside: u32,
}

struct Attribute {
    /// Where its name begins in the text.
    name: u32,
    mark: Mark,
    value: Span,
}

impl Attribute {
    /// Whether this is its name, which has this mark.
    #[inline]
    fn is(&self, text: &str, mark: Mark, name: &[u8]) -> bool {
        let begin = self.name as usize;
        self.mark == mark && text.as_bytes()[begin..begin + name.len()] == *name
    }
}

/// The length of a name, and three bytes of it: names that differ mostly differ in this, which is compared at once.
#[derive(Clone, Copy, PartialEq)]
struct Mark([u8; 4]);

impl Mark {
    /// None if the name has no byte, or too many.
    #[inline]
    fn of(name: &[u8]) -> Option<Self> {
        let (first, last) = (name.first()?, name.last()?);
        Some(Self([u8::try_from(name.len()).ok()?, *first, name[name.len() / 2], *last]))
    }
}

/// A part of a text, in bytes.
#[derive(Clone, Copy)]
struct Span {
    begin: u32,
    end: u32,
}

impl Span {
    fn of(self, text: &str) -> &str {
        &text[self.begin as usize..self.end as usize]
    }

    fn bytes(self, text: &str) -> &[u8] {
        &text.as_bytes()[self.begin as usize..self.end as usize]
    }
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
        // Places in it, and behind it in what is made of it, are numbers of 32 bits; each entity is shorter than its text.
        u32::try_from(text.len().checked_mul(2)?).ok()?;
        let mut reader = Reader { text, at: 0 };
        // As many as a description of our own has in a text of this length, and a little more.
        let (entries, attributes) = (Vec::with_capacity(text.len() / 120), Vec::with_capacity(text.len() / 40));
        let mut tree = Self { text, entries, attributes, resolved: String::new() };
        reader.declaration()?;
        let mut open: Vec<usize> = Vec::with_capacity(MAX_DEPTH);
        loop {
            reader.blanks();
            if !reader.skip("<") {
                let is_whole = reader.at == text.len() && open.is_empty() && !tree.entries.is_empty();
                return is_whole.then_some(tree);
            }
            if reader.skip("!--") {
                reader.comment()?;
            } else if reader.skip("/") {
                let closed = open.pop()?;
                tree.entries[closed].inside = number(tree.entries.len());
                if !reader.skip(tree.entries[closed].name.of(text)) || !reader.skip(">") {
                    return None;
                }
            } else {
                let is_second_root = open.is_empty() && !tree.entries.is_empty();
                if is_second_root || open.len() == MAX_DEPTH || tree.entries.len() == MAX_ELEMENTS {
                    return None;
                }
                let index = tree.entries.len();
                let name = reader.name()?;
                let is_closed = reader.attributes(&mut tree.attributes, &mut tree.resolved)?;
                tree.entries.push(Entry { name, attributes: number(tree.attributes.len()), inside: number(index + 1) });
                if !is_closed {
                    open.push(index);
                }
            }
        }
    }

    /// The element around all others.
    pub fn root(&'a self) -> TreeElement<'a> {
        TreeElement { tree: self, index: 0 }
    }
}

/// A place in a text whose length is a number of 32 bits, or how much there is of something in it.
fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

impl<'a> Element<'a> for TreeElement<'a> {
    fn name(self) -> &'a str {
        self.tree.entries[self.index].name.of(self.tree.text)
    }

    fn attribute(self, name: &str) -> Option<&'a str> {
        let Tree { text, entries, attributes, resolved } = self.tree;
        let begin = self.index.checked_sub(1).map_or(0, |before| entries[before].attributes);
        let mut attributes = attributes[begin as usize..entries[self.index].attributes as usize].iter();
        let mark = Mark::of(name.as_bytes())?;
        let Span { begin, end } = attributes.find(|attribute| attribute.is(text, mark, name.as_bytes()))?.value;
        let (begin, end) = (begin as usize, end as usize);
        let behind = begin.checked_sub(text.len());
        Some(behind.map_or_else(|| &text[begin..end], |behind| &resolved[behind..end - text.len()]))
    }

    fn children(self) -> impl Iterator<Item = Self> {
        let Self { tree, index } = self;
        let mut next = index + 1;
        std::iter::from_fn(move || {
            let child = (next < tree.entries[index].inside as usize).then_some(Self { tree, index: next })?;
            next = tree.entries[next].inside as usize;
            Some(child)
        })
    }

    fn line(self) -> u32 {
        let before = &self.tree.text[..self.tree.entries[self.index].name.begin as usize];
        number(before.matches('\n').count() + 1)
    }
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

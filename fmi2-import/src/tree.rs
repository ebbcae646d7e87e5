//! A short way to read the usual description: elements with attributes, and nothing between them but blanks and comments.
//!
//! A text that has anything else, or any fault, is left to the general parser, which reads it or says what is wrong and where. So
//! this one may give up whenever something is rare; but what it reads, it reads as the general parser does (tested).

use crate::xml::Element;

/// Elements inside each other, and attributes of one element. Both are well below what the general parser allows.
const MAX_DEPTH: usize = 64;
const MAX_ATTRIBUTES: usize = 64;
/// Elements of a document, well below what the general parser allows.
const MAX_ELEMENTS: usize = 1_000_000;

/// A document whose texts are those of the file. It is as small as can be: half of the time that reading takes would be for memory
/// that nobody had touched before.
pub(crate) struct Tree<'a> {
    text: &'a str,
    /// In the order of their beginnings.
    entries: Vec<Entry>,
    attributes: Vec<Attribute>,
    /// Values that are not in the text as they are, one behind the other.
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
    name: Span,
    value: Span,
    /// Whether the value is in [`Tree::resolved`] and not in the text.
    is_resolved: bool,
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

    fn is(self, text: &str, word: &str) -> bool {
        text.as_bytes()[self.begin as usize..self.end as usize] == *word.as_bytes()
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
        // Places in it, and in what is made of it, are numbers of 32 bits; each entity is shorter than its text.
        u32::try_from(text.len()).ok()?;
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
        let found = attributes.find(|attribute| attribute.name.is(text, name))?;
        Some(found.value.of(if found.is_resolved { resolved } else { text }))
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

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl Reader<'_> {
    /// Goes on behind this text, if it is next.
    #[inline]
    fn skip(&mut self, expected: &str) -> bool {
        let is_next = self.text.as_bytes()[self.at..].starts_with(expected.as_bytes());
        self.at += if is_next { expected.len() } else { 0 };
        is_next
    }

    /// Goes on behind all bytes that have this bit in [`KINDS`].
    #[inline]
    fn skip_all(&mut self, kind: u8) {
        let rest = &self.text.as_bytes()[self.at..];
        self.at += rest.iter().position(|byte| KINDS[usize::from(*byte)] & kind == 0).unwrap_or(rest.len());
    }

    fn blanks(&mut self) {
        self.skip_all(BLANK);
    }

    /// The part of the text from `begin` to here.
    fn span(&self, begin: usize) -> Span {
        Span { begin: number(begin), end: number(self.at) }
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
    fn name(&mut self) -> Option<Span> {
        let begin = self.at;
        self.skip_all(NAME);
        let name = &self.text.as_bytes()[begin..self.at];
        let can_begin = name.first().is_some_and(|first| first.is_ascii_alphabetic() || *first == b'_');
        (can_begin && name != b"xmlns").then(|| self.span(begin))
    }

    /// The attributes of an element, and the end of its tag. Whether it is the end of the element, too.
    fn attributes(&mut self, attributes: &mut Vec<Attribute>, resolved: &mut String) -> Option<bool> {
        let begin = attributes.len();
        loop {
            let before = self.at;
            self.blanks();
            if self.skip(">") {
                return Some(false);
            }
            if self.skip("/>") {
                return Some(true);
            }
            if self.at == before || attributes.len() - begin == MAX_ATTRIBUTES {
                return None;
            }
            let name = self.name()?;
            let word = name.of(self.text);
            if !self.skip("=\"") || attributes[begin..].iter().any(|known| known.name.is(self.text, word)) {
                return None;
            }
            let (value, is_resolved) = self.value(resolved)?;
            attributes.push(Attribute { name, value, is_resolved });
        }
    }

    /// The rest of an attribute's value. Whether it is in the text with `resolved` entities.
    fn value(&mut self, resolved: &mut String) -> Option<(Span, bool)> {
        let begin = self.at;
        let mut has_entities = false;
        loop {
            self.skip_all(VALUE);
            match self.text.as_bytes().get(self.at)? {
                b'"' => break,
                b'&' => has_entities = true,
                // Blanks other than spaces become spaces; nothing else of this is allowed.
                _ => return None,
            }
            self.at += 1;
        }
        let span = self.span(begin);
        let value = span.of(self.text);
        self.at += 1;
        if !value.is_ascii() && value.contains(['\u{fffe}', '\u{ffff}']) {
            return None;
        }
        if has_entities {
            let begin = resolved.len();
            resolve(value, resolved)?;
            return Some((Span { begin: number(begin), end: number(resolved.len()) }, true));
        }
        Some((span, false))
    }
}

/// What a byte can be part of: blanks between attributes and elements, a name, the plain text of an attribute's value.
const KINDS: [u8; 256] = {
    let mut kinds = [0; 256];
    let mut byte = 0_u8;
    loop {
        let kind = &mut kinds[byte as usize];
        if matches!(byte, b' ' | b'\n' | b'\t' | b'\r') {
            *kind |= BLANK;
        }
        if byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'.') {
            *kind |= NAME;
        }
        if byte >= b' ' && !matches!(byte, b'"' | b'&' | b'<') {
            *kind |= VALUE;
        }
        match byte.checked_add(1) {
            Some(next) => byte = next,
            None => break kinds,
        }
    }
};
const BLANK: u8 = 1;
const NAME: u8 = 2;
const VALUE: u8 = 4;

/// Appends the value with characters in place of XML's own entities.
fn resolve(value: &str, text: &mut String) -> Option<()> {
    const ENTITIES: [(&str, char); 5] = [("amp;", '&'), ("lt;", '<'), ("gt;", '>'), ("quot;", '"'), ("apos;", '\'')];
    let mut pieces = value.split('&');
    text.push_str(pieces.next()?);
    for piece in pieces {
        let (rest, character) =
            ENTITIES.iter().find_map(|(name, character)| Some((piece.strip_prefix(name)?, *character)))?;
        text.push(character);
        text.push_str(rest);
    }
    Some(())
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

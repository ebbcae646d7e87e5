//! The text of a document, from one piece of an element to the next.

use super::{Attribute, Mark, Span, number};

/// Attributes of one element, well below what the general parser allows.
const MAX_ATTRIBUTES: usize = 64;

/// A text and a place in it, in bytes.
pub(super) struct Reader<'a> {
    pub text: &'a str,
    pub at: usize,
}

impl Reader<'_> {
    /// Goes on behind this text, if it is next.
    #[inline]
    pub fn skip(&mut self, expected: &str) -> bool {
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

    pub fn blanks(&mut self) {
        self.skip_all(BLANK);
    }

    /// The part of the text from `begin` to here.
    fn span(&self, begin: usize) -> Span {
        Span { begin: number(begin), end: number(self.at) }
    }

    /// The usual first line, if there is one.
    pub fn declaration(&mut self) -> Option<()> {
        if self.skip("<?") {
            let usual = [r#"xml version="1.0" encoding="UTF-8"?>"#, r#"xml version="1.0" encoding="utf-8"?>"#];
            return usual.iter().any(|usual| self.skip(usual)).then_some(());
        }
        Some(())
    }

    /// The rest of a comment.
    pub fn comment(&mut self) -> Option<()> {
        let length = self.text[self.at..].find("--")?;
        let comment = &self.text[self.at..self.at + length];
        let is_usual = |byte: u8| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~');
        self.at += length + 2;
        (comment.bytes().all(is_usual) && self.skip(">")).then_some(())
    }

    /// A name without a namespace.
    pub fn name(&mut self) -> Option<Span> {
        let begin = self.at;
        self.skip_all(NAME);
        let name = &self.text.as_bytes()[begin..self.at];
        let can_begin = name.first().is_some_and(|first| first.is_ascii_alphabetic() || *first == b'_');
        (can_begin && name != b"xmlns").then(|| self.span(begin))
    }

    /// The attributes of an element, and the end of its tag. Whether it is the end of the element, too.
    pub fn attributes(&mut self, attributes: &mut Vec<Attribute>, resolved: &mut String) -> Option<bool> {
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
            let word = name.bytes(self.text);
            let mark = Mark::of(word)?;
            if !self.skip("=\"") || attributes[begin..].iter().any(|known| known.is(self.text, mark, word)) {
                return None;
            }
            let value = self.value(resolved)?;
            attributes.push(Attribute { name: name.begin, mark, value });
        }
    }

    /// The rest of an attribute's value, whose entities are `resolved`.
    fn value(&mut self, resolved: &mut String) -> Option<Span> {
        let begin = self.at;
        let mut has_entities = false;
        loop {
            self.skip_plain();
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
            let begin = self.text.len() + resolved.len();
            resolve(value, resolved)?;
            return Some(Span { begin: number(begin), end: number(self.text.len() + resolved.len()) });
        }
        Some(span)
    }

    /// Goes on behind the plain text of a value: to its end, an entity, or what may not be there.
    #[inline]
    fn skip_plain(&mut self) {
        let mut rest = &self.text.as_bytes()[self.at..];
        while let Some((eight, behind)) = rest.split_first_chunk() {
            let found = first_special(u64::from_le_bytes(*eight));
            self.at += found;
            if found < eight.len() {
                return;
            }
            rest = behind;
        }
        self.at += rest.iter().position(|byte| is_special(*byte)).unwrap_or(rest.len());
    }
}

/// Whether a byte is not plain text of a value: it ends one, or begins an entity, or may not be there.
fn is_special(byte: u8) -> bool {
    byte < b' ' || matches!(byte, b'"' | b'&' | b'<')
}

/// How many of eight bytes are before the first one that [is special](is_special); the bytes are digits of the number, the lowest first.
///
/// Of x − 1 and not x the upper bit is set where a byte x is zero, and where a lower byte has borrowed, which is then the one that is
/// looked for. The same with 32 instead of 1 finds bytes below 32.
#[inline]
fn first_special(bytes: u64) -> usize {
    const ONES: u64 = u64::MAX / 255;
    let below = |bytes: u64, least: u8| bytes.wrapping_sub(ONES * u64::from(least)) & !bytes;
    let is = |byte: u8| below(bytes ^ (ONES * u64::from(byte)), 1);
    let special = (below(bytes, b' ') | is(b'"') | is(b'&') | is(b'<')) & (ONES << 7);
    special.trailing_zeros() as usize / 8
}

/// What a byte can be part of: blanks between attributes and elements, a name.
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
        match byte.checked_add(1) {
            Some(next) => byte = next,
            None => break kinds,
        }
    }
};
const BLANK: u8 = 1;
const NAME: u8 = 2;

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
    use super::*;

    /// Whatever stands beside it.
    #[test]
    fn eight_bytes_are_looked_at_like_one() {
        for other in [b' ', b'!', b'#', b'\'', b';', b'=', b'a', 0x7f, 0x80, 0xa2, 0xff] {
            for (place, byte) in (0..8).flat_map(|place| (0..=255).map(move |byte| (place, byte))) {
                let mut bytes = [other; 8];
                bytes[place] = byte;
                for behind in [other, b'"', b'&', b'<', 0, 0x1f] {
                    bytes[7] = if place < 7 { behind } else { byte };
                    let expected = bytes.iter().position(|byte| is_special(*byte)).unwrap_or(8);
                    assert_eq!(first_special(u64::from_le_bytes(bytes)), expected, "{bytes:x?}");
                }
            }
        }
    }
}

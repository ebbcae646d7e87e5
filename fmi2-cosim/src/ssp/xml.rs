//! Indented XML in memory.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesStart, Event};

/// Attributes of an element, in order.
pub type Attributes<'a> = Vec<(&'a str, String)>;

/// A document in the making.
pub struct Xml(Writer<Vec<u8>>);

impl Xml {
    /// A document with one root element.
    pub fn document(root: &str, attributes: &[(&str, String)], content: impl FnOnce(&mut Self)) -> String {
        let mut xml = Self(Writer::new_with_indent(Vec::new(), b' ', 2));
        xml.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
        xml.element(root, attributes, content);
        let mut text = String::from_utf8(xml.0.into_inner()).unwrap_or_default();
        text.push('\n');
        text
    }

    fn event(&mut self, event: Event<'_>) {
        // Writing to memory cannot fail.
        let _ = self.0.write_event(event);
    }

    fn start<'n>(name: &'n str, attributes: &[(&str, String)]) -> BytesStart<'n> {
        let mut start = BytesStart::new(name);
        for (key, value) in attributes {
            start.push_attribute((*key, value.as_str()));
        }
        start
    }

    /// An element without content.
    pub fn empty(&mut self, name: &str, attributes: &[(&str, String)]) {
        self.event(Event::Empty(Self::start(name, attributes)));
    }

    /// An element with content.
    pub fn element(&mut self, name: &str, attributes: &[(&str, String)], content: impl FnOnce(&mut Self)) {
        let start = Self::start(name, attributes);
        let end = start.to_end().into_owned();
        self.event(Event::Start(start));
        content(self);
        self.event(Event::End(end));
    }
}

/// The shortest decimal that reads back as the same number.
pub fn number(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

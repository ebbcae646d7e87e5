//! Attributes and children of XML elements, with errors that name the line. The readers of descriptions and of SSP
//! documents share this module; it is not part of the stable interface.

use roxmltree::Node;

/// An element, in a document of any kind.
pub trait Element<'a>: Copy {
    /// Its name, without namespace.
    fn name(self) -> &'a str;
    /// The value of an attribute.
    fn attribute(self, name: &str) -> Option<&'a str>;
    /// What is inside it. Texts may be there as elements without a name.
    fn children(self) -> impl Iterator<Item = Self>;
    /// The line it begins in, from 1.
    fn line(self) -> u32;
}

impl<'a> Element<'a> for Node<'a, '_> {
    fn name(self) -> &'a str {
        self.tag_name().name()
    }

    fn attribute(self, name: &str) -> Option<&'a str> {
        Node::attribute(&self, name)
    }

    fn children(self) -> impl Iterator<Item = Self> {
        Node::children(&self)
    }

    fn line(self) -> u32 {
        self.document().text_pos_at(self.range().start).row
    }
}

/// A fault of an element.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// A required attribute or child is absent.
    #[error("line {line}: <{element}> lacks {what}")]
    Missing {
        /// Element that should have it.
        element: String,
        /// The missing attribute or child.
        what: String,
        /// Line in the file, from 1.
        line: u32,
    },
    /// An attribute's value makes no sense.
    #[error("line {line}: {attribute}=\"{value}\" is not {expected}")]
    Value {
        /// The attribute.
        attribute: String,
        /// Its value.
        value: String,
        /// The expected value, in words.
        expected: &'static str,
        /// Line in the file, from 1.
        line: u32,
    },
}

type Result<T> = std::result::Result<T, Fault>;

/// An element lacks something.
#[must_use]
pub fn missing<'a>(node: impl Element<'a>, what: impl Into<String>) -> Fault {
    Fault::Missing { element: node.name().to_owned(), what: what.into(), line: node.line() }
}

/// An attribute has this value, and something else is expected.
#[must_use]
pub fn wrong<'a>(node: impl Element<'a>, attribute: &str, value: &str, expected: &'static str) -> Fault {
    Fault::Value { attribute: attribute.to_owned(), value: value.to_owned(), expected, line: node.line() }
}

/// The line an element begins in, from 1.
#[must_use]
pub fn line<'a>(node: impl Element<'a>) -> u32 {
    node.line()
}

/// The children of this name.
pub fn elements<'a, N: Element<'a>>(node: N, name: &str) -> impl Iterator<Item = N> {
    node.children().filter(move |child| child.name() == name)
}

/// The first child of this name.
#[must_use]
pub fn child<'a, N: Element<'a>>(node: N, name: &str) -> Option<N> {
    elements(node, name).next()
}

/// All elements inside the child `list`; empty if that child is missing.
pub fn listed<'a, 'input>(node: Node<'a, 'input>, list: &str) -> impl Iterator<Item = Node<'a, 'input>> {
    child(node, list).into_iter().flat_map(Element::children).filter(Node::is_element)
}

/// The elements of this name inside the child `list`; empty if that child is missing.
pub fn children<'a, N: Element<'a>>(node: N, list: &str, name: &str) -> impl Iterator<Item = N> {
    child(node, list).into_iter().flat_map(move |list| elements(list, name))
}

/// The text of an optional attribute.
#[must_use]
pub fn optional<'a>(node: impl Element<'a>, attribute: &str) -> Option<String> {
    node.attribute(attribute).map(str::to_owned)
}

/// The text of a required attribute.
///
/// # Errors
/// When it is absent.
pub fn required<'a>(node: impl Element<'a>, attribute: &str) -> Result<&'a str> {
    node.attribute(attribute).ok_or_else(|| missing(node, format!("the attribute \"{attribute}\"")))
}

/// An optional number.
///
/// # Errors
/// When the attribute is not a number.
pub fn number<'a, T: Number>(node: impl Element<'a>, attribute: &str) -> Result<Option<T>> {
    node.attribute(attribute).map(|value| parsed(node, attribute, value)).transpose()
}

/// A required number.
///
/// # Errors
/// When the attribute is absent or not a number.
pub fn needed<'a, T: Number>(node: impl Element<'a>, attribute: &str) -> Result<T> {
    parsed(node, attribute, required(node, attribute)?)
}

fn parsed<'a, T: Number>(node: impl Element<'a>, attribute: &str, value: &str) -> Result<T> {
    trimmed(value).parse().map_err(|_| wrong(node, attribute, value, T::EXPECTED))
}

/// The text without blanks around it, which it hardly ever has.
fn trimmed(text: &str) -> &str {
    match text.as_bytes() {
        [first, .., last] if first.is_ascii_graphic() && last.is_ascii_graphic() => text,
        _ => text.trim(),
    }
}

/// An optional attribute with one of several words, which `parse` recognises.
///
/// # Errors
/// When it is none of these words.
pub fn choice<'a, T>(
    node: impl Element<'a>,
    attribute: &str,
    expected: &'static str,
    parse: impl FnOnce(&str) -> Option<T>,
) -> Result<Option<T>> {
    let choose = |value: &str| parse(trimmed(value)).ok_or_else(|| wrong(node, attribute, value, expected));
    node.attribute(attribute).map(choose).transpose()
}

/// An optional truth value.
///
/// # Errors
/// When the attribute is not a truth value.
pub fn truth<'a>(node: impl Element<'a>, attribute: &str) -> Result<Option<bool>> {
    choice(node, attribute, "true or false", crate::value::truth)
}

/// Numbers in attributes, with the words an error needs.
pub trait Number: std::str::FromStr {
    /// The expected value, in words.
    const EXPECTED: &'static str;
}
impl Number for f64 {
    const EXPECTED: &'static str = "a number";
}
impl Number for i32 {
    const EXPECTED: &'static str = "a 32-bit integer";
}
impl Number for u32 {
    const EXPECTED: &'static str = "a non-negative 32-bit integer";
}
impl Number for usize {
    const EXPECTED: &'static str = "a non-negative integer";
}

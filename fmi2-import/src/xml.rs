//! Attributes and children of XML elements, with errors that name the line. The readers of descriptions and of SSP
//! documents share this module; it is not part of the stable interface.

use roxmltree::Node;

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
pub fn missing(node: Node, what: impl Into<String>) -> Fault {
    Fault::Missing { element: node.tag_name().name().to_owned(), what: what.into(), line: line(node) }
}

/// An attribute has this value, and something else is expected.
#[must_use]
pub fn wrong(node: Node, attribute: &str, value: &str, expected: &'static str) -> Fault {
    Fault::Value { attribute: attribute.to_owned(), value: value.to_owned(), expected, line: line(node) }
}

/// The line an element begins in, from 1.
#[must_use]
pub fn line(node: Node) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

/// The children of this name.
pub fn elements<'a, 'input>(node: Node<'a, 'input>, name: &str) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| child.tag_name().name() == name)
}

/// The first child of this name.
#[must_use]
pub fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    elements(node, name).next()
}

/// All elements inside the child `list`; empty if that child is missing.
pub fn listed<'a, 'input>(node: Node<'a, 'input>, list: &str) -> impl Iterator<Item = Node<'a, 'input>> {
    child(node, list).into_iter().flat_map(|list| list.children()).filter(Node::is_element)
}

/// The elements of this name inside the child `list`; empty if that child is missing.
pub fn children<'a, 'input>(node: Node<'a, 'input>, list: &str, name: &str) -> impl Iterator<Item = Node<'a, 'input>> {
    child(node, list).into_iter().flat_map(move |list| elements(list, name))
}

/// The text of an optional attribute.
#[must_use]
pub fn optional(node: Node, attribute: &str) -> Option<String> {
    node.attribute(attribute).map(str::to_owned)
}

/// The text of a required attribute.
///
/// # Errors
/// When it is absent.
pub fn required<'a>(node: Node<'a, '_>, attribute: &str) -> Result<&'a str> {
    node.attribute(attribute).ok_or_else(|| missing(node, format!("the attribute \"{attribute}\"")))
}

/// An optional number.
///
/// # Errors
/// When the attribute is not a number.
pub fn number<T: Number>(node: Node, attribute: &str) -> Result<Option<T>> {
    node.attribute(attribute).map(|value| parsed(node, attribute, value)).transpose()
}

/// A required number.
///
/// # Errors
/// When the attribute is absent or not a number.
pub fn needed<T: Number>(node: Node, attribute: &str) -> Result<T> {
    parsed(node, attribute, required(node, attribute)?)
}

fn parsed<T: Number>(node: Node, attribute: &str, value: &str) -> Result<T> {
    value.trim().parse().map_err(|_| wrong(node, attribute, value, T::EXPECTED))
}

/// An optional attribute with one of several words, which `parse` recognises.
///
/// # Errors
/// When it is none of these words.
pub fn choice<T>(
    node: Node,
    attribute: &str,
    expected: &'static str,
    parse: impl FnOnce(&str) -> Option<T>,
) -> Result<Option<T>> {
    let choose = |value: &str| parse(value.trim()).ok_or_else(|| wrong(node, attribute, value, expected));
    node.attribute(attribute).map(choose).transpose()
}

/// An optional truth value.
///
/// # Errors
/// When the attribute is not a truth value.
pub fn truth(node: Node, attribute: &str) -> Result<Option<bool>> {
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

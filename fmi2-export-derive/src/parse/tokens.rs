//! Values, names and comments, as written in the source.

use proc_macro2::{TokenStream, TokenTree};
use syn::meta::ParseNestedMeta;
use syn::{Attribute, Error, Expr, ExprLit, Ident, Lit, Meta, Result, Token};

/// The tokens after the `=`, up to the next comma: an expression. The compiler reads it, so syn need not.
pub(super) fn expression(meta: &ParseNestedMeta<'_>) -> Result<TokenStream> {
    let input = meta.value()?;
    let mut tokens = TokenStream::new();
    while !input.is_empty() && !input.peek(Token![,]) {
        tokens.extend([input.parse::<TokenTree>()?]);
    }
    if tokens.is_empty() { Err(input.error("a value is missing")) } else { Ok(tokens) }
}

/// `(a, b)`: names of fields.
pub(super) fn fields(meta: &ParseNestedMeta<'_>) -> Result<Vec<Ident>> {
    let mut found = Vec::new();
    meta.parse_nested_meta(|meta| {
        found.push(meta.path.require_ident()?.clone());
        Ok(())
    })?;
    Ok(found)
}

/// The name before the `=` or the parenthesis.
pub(super) fn key(meta: &ParseNestedMeta<'_>) -> String {
    meta.path.get_ident().map(Ident::to_string).unwrap_or_default()
}

/// That there is no such key, and which there are.
pub(super) fn unknown(meta: &ParseNestedMeta<'_>, what: &str, keys: &[&str]) -> Error {
    meta.error(format!("{what} takes {}", keys.join(", ")))
}

/// The comment's first paragraph, in one line.
pub(super) fn first_paragraph(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(meta) if meta.path.is_ident("doc") => match &meta.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    });
    // An empty line of a comment is an empty attribute, and a block comment one with several lines.
    let lines: Vec<String> = lines.collect::<Vec<_>>().join("\n").lines().map(|line| line.trim().to_owned()).collect();
    let begun = lines.iter().skip_while(|line| line.is_empty());
    let paragraph = begun.take_while(|line| !line.is_empty()).cloned().collect::<Vec<_>>().join(" ");
    // A comment is a sentence, a description a label.
    match paragraph.strip_suffix('.') {
        Some(label) if !label.contains(". ") => label.to_owned(),
        _ => paragraph,
    }
}

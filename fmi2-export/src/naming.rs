//! The convention that variable names follow (FMI 2.0.4, section 2.2.9).

/// Whether a name is one of `variableNamingConvention="structured"`: `arm[1].'tip mass'`, `der(x,2)`.
pub(crate) fn is_structured(name: &str) -> bool {
    let inner = name.strip_prefix("der(").and_then(|rest| rest.strip_suffix(')'));
    let Some(inner) = inner else { return identifier(name) == Some("") };
    match identifier(inner) {
        Some("") => true,
        Some(rest) => rest.strip_prefix(',').and_then(number) == Some(""),
        None => false,
    }
}

// Each of these takes what it is named after from the text's beginning and gives the rest.

fn identifier(mut text: &str) -> Option<&str> {
    loop {
        text = basic_name(text)?;
        if let Some(mut rest) = text.strip_prefix('[') {
            rest = number(rest)?;
            while let Some(next) = rest.strip_prefix(',') {
                rest = number(next)?;
            }
            text = rest.strip_prefix(']')?;
        }
        match text.strip_prefix('.') {
            Some(rest) => text = rest,
            None => return Some(text),
        }
    }
}

fn basic_name(text: &str) -> Option<&str> {
    if let Some(quoted) = text.strip_prefix('\'') {
        return quoted_name(quoted);
    }
    let rest = text.strip_prefix(|c: char| c.is_ascii_alphabetic() || c == '_')?;
    Some(rest.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_'))
}

fn quoted_name(text: &str) -> Option<&str> {
    let mut characters = text.char_indices();
    while let Some((at, c)) = characters.next() {
        match c {
            '\'' => return (at > 0).then(|| &text[at + 1..]),
            '\\' => _ = characters.next().filter(|(_, c)| "'\"?\\abfnrtv".contains(*c))?,
            ' ' | '!' | '#'..='&' | '('..='[' | ']'..='_' | 'a'..='~' => {}
            _ => return None,
        }
    }
    None
}

fn number(text: &str) -> Option<&str> {
    let rest = text.trim_start_matches(|c: char| c.is_ascii_digit());
    (rest.len() < text.len()).then_some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structured_names_are_told_from_others() {
        for name in
            ["x", "_1", "robot.axis.'motor #234'", "der(pipe[3,4].T[14],2)", "der(x)", r"'\'a\\b'", "der", "a[1]"]
        {
            assert!(is_structured(name), "{name}");
        }
        for name in [
            "",
            "a b",
            "1a",
            "a.",
            ".a",
            "a[]",
            "a[1",
            "a[1,]",
            "der(x",
            "der(x,)",
            "der(x,-1)",
            "''",
            "'a",
            r"'\q'",
            "ä",
            "a[1]b",
        ] {
            assert!(!is_structured(name), "{name}");
        }
    }
}

//! Texts of files and FMUs as a terminal may see them.

use std::borrow::Cow;

/// Characters that make a terminal do something, or show a text in another order than it has.
fn is_command(character: char) -> bool {
    character.is_control()
        || matches!(character, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text with control characters, other than line ends and tabs, in a form to be read: `\u{1b}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |character| is_command(character) && !matches!(character, '\n' | '\t'))
}

/// The same for what has to stay on one line.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_command)
}

fn escaped(text: &str, is_unwanted: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_unwanted) {
        return text.into();
    }
    let mut result = String::with_capacity(text.len());
    for character in text.chars() {
        if is_unwanted(character) {
            result.extend(character.escape_default());
        } else {
            result.push(character);
        }
    }
    result.into()
}

/// JSON with all control characters in JSON's own escapes; it allows some of them as they are.
pub fn printable_json(text: &str) -> Cow<'_, str> {
    use std::fmt::Write;
    let is_unwanted = |character: char| is_command(character) && character != '\n';
    if !text.contains(is_unwanted) {
        return text.into();
    }
    let mut result = String::with_capacity(text.len());
    for character in text.chars() {
        if is_unwanted(character) {
            let _ = write!(result, "\\u{:04x}", u32::from(character));
        } else {
            result.push(character);
        }
    }
    result.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_terminal_obeys_gets_through() {
        assert_eq!(
            printable("größer\t\u{1b}[2J\r\n\u{7f}\u{9b}1m\u{202e}"),
            "größer\t\\u{1b}[2J\\r\n\\u{7f}\\u{9b}1m\\u{202e}"
        );
        assert_eq!(one_line("a\nb"), "a\\nb");
        assert!(matches!(printable("plain"), Cow::Borrowed("plain")));
        let json = printable_json("{\n\"a\": \"\u{9b}1m\u{7f}\"}").into_owned();
        assert_eq!(json, "{\n\"a\": \"\\u009b1m\\u007f\"}");
    }
}

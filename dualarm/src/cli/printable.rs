//! Texts of files and FMUs as a terminal may see them.

use std::borrow::Cow;

/// Characters that control a terminal, change the direction of text, or are invisible, so that two names look alike:
/// control and format characters, line separators, fillers, variation selectors, and unassigned characters of Unicode.
/// Letters of all scripts, their accents and spaces are kept.
fn is_unwanted(character: char) -> bool {
    if character.is_ascii() {
        return character.is_ascii_control();
    }
    let is_space = matches!(character, '\u{a0}' | '\u{2000}'..='\u{200a}' | '\u{202f}' | '\u{205f}' | '\u{3000}');
    let is_blank = matches!(
        character,
        '\u{34f}'
            | '\u{115f}'
            | '\u{1160}'
            | '\u{17b4}'
            | '\u{17b5}'
            | '\u{180b}'..='\u{180f}'
            | '\u{2800}'
            | '\u{3164}'
            | '\u{fe00}'..='\u{fe0f}'
            | '\u{ffa0}'
            | '\u{e0100}'..='\u{e01ef}'
    );
    // Characters that the standard library would escape, which no letter is. Each is tested as the second character of a text, so that accents
    // are kept.
    let is_shown = || [' ', character].iter().collect::<String>().escape_debug().count() == 2;
    is_blank || !(character.is_alphanumeric() || is_space || is_shown())
}

/// The text with control characters, other than line ends and tabs, in a form to be read: `\u{1b}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, |character| is_unwanted(character) && !matches!(character, '\n' | '\t'))
}

/// The same for a text that has to stay on one line.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, is_unwanted)
}

fn escaped(text: &str, is_replaced: impl Fn(char) -> bool) -> Cow<'_, str> {
    // To look at a letter takes a while, and the lines in tables are hundreds of the same.
    let mut known = ' ';
    let is_kept = |character| {
        let is_kept = character == known || !is_replaced(character);
        known = character;
        is_kept
    };
    if text.chars().all(is_kept) {
        return text.into();
    }
    let mut result = String::with_capacity(text.len());
    for character in text.chars() {
        if is_replaced(character) {
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
    let is_replaced = |character: char| is_unwanted(character) && character != '\n';
    if !text.contains(is_replaced) {
        return text.into();
    }
    let mut result = String::with_capacity(text.len());
    for character in text.chars() {
        if is_replaced(character) {
            for unit in character.encode_utf16(&mut [0; 2]) {
                let _ = write!(result, "\\u{unit:04x}");
            }
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
        for hidden in
            "\u{ad}\u{61c}\u{200b}\u{200d}\u{2028}\u{2029}\u{2060}\u{2066}\u{feff}\u{fff9}\u{e0041}\u{e000}\u{3164}"
                .chars()
        {
            assert!(one_line(&format!("a{hidden}b")).is_ascii(), "{hidden:?}");
        }
        let shown = "τ₁ = 3 N·m, 20 °C, Größe, e\u{301}, 速度, हिन्दी, עברית, 😀, a\u{a0}b";
        assert_eq!(one_line(shown), shown);
        assert!(matches!(printable("plain"), Cow::Borrowed("plain")));
        let json = printable_json("{\n\"a\": \"\u{9b}1m\u{7f}\"}").into_owned();
        assert_eq!(json, "{\n\"a\": \"\\u009b1m\\u007f\"}");
        assert_eq!(printable_json("\u{e0001}\u{2028}"), "\\udb40\\udc01\\u2028");
    }
}

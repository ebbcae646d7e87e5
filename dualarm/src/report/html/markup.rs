//! Text inside HTML.

use std::borrow::Cow;

/// A text so that nothing in it is markup, between tags or inside a quoted attribute. Control characters, which XML cannot
/// contain, are replaced.
#[must_use]
pub fn escape(text: &str) -> String {
    let is_forbidden =
        |c: char| c.is_control() && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}');
    // HTML 4 does not define &apos;.
    quick_xml::escape::escape(text).replace("&apos;", "&#39;").replace(is_forbidden, "\u{fffd}")
}

/// JSON that is safe inside a `<script>` element: without `<` it cannot close the element or open a comment.
#[must_use]
pub fn json_in_script(json: &serde_json::Value) -> String {
    in_script(json.to_string())
}

/// The same of JSON that is text already.
#[must_use]
pub fn in_script(json: String) -> String {
    if json.contains('<') { json.replace('<', "\\u003c") } else { json }
}

/// Replaces every `{{name}}` of a template by `value(name)`; inserted texts are not searched for further names.
///
/// # Errors
/// When the template contains a name that `value` does not define, or does not close a name.
pub fn fill(template: &str, value: impl Fn(&str) -> Option<String>) -> String {
    let mut parts = template.split("{{");
    // Some are long: what is filled in is put together once.
    let mut filled = vec![Cow::Borrowed(parts.next().unwrap_or_default())];
    for part in parts {
        let (name, rest) = part.split_once("}}").expect("the page's template closes every name");
        let text = value(name).unwrap_or_else(|| panic!("the page's template knows no {name}"));
        filled.extend([Cow::Owned(text), Cow::Borrowed(rest)]);
    }
    filled.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_text_stays_text() {
        assert_eq!(escape("<b title='\"'>&"), "&lt;b title=&#39;&quot;&#39;&gt;&amp;");
        let json = json_in_script(&serde_json::json!({ "a": "</script><!--<script>" }));
        assert!(!json.contains('<'), "{json}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&json).unwrap()["a"], "</script><!--<script>");
    }

    #[test]
    fn what_is_filled_in_is_not_a_template() {
        let value = |name: &str| (name == "a").then(|| "{{b}}".to_owned());
        assert_eq!(fill("x {{a}} y {{a}}", value), "x {{b}} y {{b}}");
    }
}

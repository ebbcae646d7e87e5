//! Suggestions for misspelt names, and unused names.

/// "; did you mean …?", or nothing.
#[must_use]
pub fn suggestion(similar: &[String]) -> String {
    match similar {
        [] => String::new(),
        names => format!("; did you mean {}?", alternatives(names)),
    }
}

/// The same, with a further sentence behind the question.
#[must_use]
pub fn suggestion_and(similar: &[String], rest: &str) -> String {
    if similar.is_empty() {
        return format!("; {rest}");
    }
    let mut letters = rest.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    format!("{} {first}{}", suggestion(similar), letters.as_str())
}

/// "a", "a or b", "a, b or c".
fn alternatives(names: &[String]) -> String {
    match names {
        [several @ .., last] if !several.is_empty() => format!("{} or {last}", several.join(", ")),
        _ => names.concat(),
    }
}

/// A number in the usual notation: the fewest digits that read back, with an exponent if it is very large or small.
#[must_use]
pub fn number(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// The candidates that are closest to a misspelt name, best first; empty if none is close. Names of hundreds of letters are
/// not compared, because the time of a comparison is proportional to the product of the two lengths.
#[must_use]
pub fn closest<'a>(wanted: &str, candidates: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    const SHOWN: usize = 3;
    const ALIKE: f64 = 0.8;
    const LONGEST: usize = 100;
    let wanted = wanted.to_lowercase();
    let mut best: Vec<(f64, &str)> = Vec::with_capacity(SHOWN + 1);
    if wanted.len() > LONGEST {
        return Vec::new();
    }
    for candidate in candidates.filter(|candidate| candidate.len() <= LONGEST) {
        let score = strsim::jaro_winkler(&wanted, &candidate.to_lowercase());
        let is_better = best.len() < SHOWN || best.last().is_some_and(|(worst, _)| score > *worst);
        if score >= ALIKE && is_better && !best.iter().any(|(_, known)| *known == candidate) {
            best.push((score, candidate));
            best.sort_by(|a, b| b.0.total_cmp(&a.0));
            best.truncate(SHOWN);
        }
    }
    best.into_iter().map(|(_, name)| name).collect()
}

/// The candidate that comes closest, if one is close.
#[must_use]
pub fn best<'a>(wanted: &str, candidates: impl Iterator<Item = &'a str>) -> Option<String> {
    closest(wanted, candidates).first().map(ToString::to_string)
}

/// Adds "did you mean" to serde's message about an unknown name, which quotes the name and then every valid one in
/// backticks.
#[must_use]
pub fn with_suggestion(message: &str) -> String {
    let message = message.trim_end();
    if !message.starts_with("unknown ") {
        return message.to_owned();
    }
    let mut quoted = message.split('`').skip(1).step_by(2);
    let Some(wrong) = quoted.next() else { return message.to_owned() };
    let similar: Vec<_> = closest(wrong, quoted).into_iter().take(1).map(str::to_owned).collect();
    format!("{message}{}", suggestion(&similar))
}

/// The name, or else the name with the first number from 2 on that is not taken.
pub(crate) fn free_name(name: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let (mut candidate, mut number) = (name.to_owned(), 2_u64);
    while is_taken(&candidate) {
        candidate = format!("{name}_{number}");
        number += 1;
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_user_may_have_meant_is_one_question() {
        let names = ["a", "b", "c"].map(str::to_owned);
        let said = |count: usize| suggestion(&names[..count]);
        assert_eq!(said(0), "");
        assert_eq!(said(1), "; did you mean a?");
        assert_eq!(said(2), "; did you mean a or b?");
        assert_eq!(said(3), "; did you mean a, b or c?");
        assert_eq!(suggestion_and(&names[..1], "the names are a, b"), "; did you mean a? The names are a, b");
        assert_eq!(suggestion_and(&[], "the names are a, b"), "; the names are a, b");
    }
}

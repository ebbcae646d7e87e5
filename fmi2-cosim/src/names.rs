//! Misspelt names: what the user may have meant.

/// "; did you mean …?", or nothing.
#[must_use]
pub fn suggestion(similar: &[String]) -> String {
    match similar {
        [] => String::new(),
        names => format!("; did you mean {}?", names.join(" or ")),
    }
}

/// The candidates that come closest to a misspelt name, best first; none if none is close.
#[must_use]
pub fn closest<'a>(wanted: &str, candidates: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    const SHOWN: usize = 3;
    const ALIKE: f64 = 0.8;
    let mut found: Vec<(f64, &str)> = Vec::new();
    for candidate in candidates {
        let score = strsim::jaro_winkler(&wanted.to_lowercase(), &candidate.to_lowercase());
        if score >= ALIKE && !found.iter().any(|(_, known)| *known == candidate) {
            found.push((score, candidate));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().take(SHOWN).map(|(_, name)| name).collect()
}

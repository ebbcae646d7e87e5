//! Which column of a file has the times.

use super::read::Values;

/// Whether a column of this name is the one of times.
pub(super) fn is_time(name: &str) -> bool {
    ["time", "t"].contains(&name.to_lowercase().as_str())
}

/// Whether a column is the one of times by its name.
pub(super) fn is_named_time((column, values): &Values) -> bool {
    values.is_some() && is_time(&column.name)
}

/// Units of time, and what is written for none, as of a time that is divided by another.
const TIMES: [&str; 23] = [
    "", "-", "1", "s", "sec", "secs", "second", "seconds", "ms", "us", "µs", "μs", "ns", "min", "mins", "minute",
    "minutes", "h", "hour", "hours", "d", "day", "days",
];

/// Why the first column of numbers cannot be the one of times, if none is called so.
pub(super) fn no_times(columns: &[Values]) -> Option<String> {
    let (first, times) = columns.iter().find_map(|(column, values)| Some((column, values.as_ref()?)))?;
    if let Some(unit) = &first.unit {
        let is_of_time = TIMES.contains(&unit.trim_end_matches('.').to_lowercase().as_str());
        let reason = || format!("no column is called time, and the first one, \"{}\", has the unit {unit}", first.name);
        return (!is_of_time).then(reason);
    }
    let (text, _) = columns.iter().find(|(_, values)| values.is_none())?;
    // Texts may stand beside times, as a phase or a note; beside numbers of rows they make the table one of something else.
    let name = first.name.to_lowercase();
    let says_time = ["time", "zeit"].iter().any(|word| name.contains(word));
    let ascend = times.is_sorted_by(|before, after| before < after);
    let count_rows = times.windows(2).all(|pair| pair[1] - pair[0] == 1.0);
    if says_time || ascend && !count_rows {
        return None;
    }
    if let Some((column, _)) = columns.iter().find(|(column, _)| is_time(&column.name)) {
        return Some(format!("the column \"{}\" holds texts, not numbers", column.name));
    }
    Some(format!(
        "no column is called time, and the column \"{}\" holds texts: this is no table of values over time",
        text.name
    ))
}

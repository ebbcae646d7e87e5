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

/// Units of time.
const TIMES: [&str; 10] = ["s", "sec", "ms", "us", "µs", "μs", "ns", "min", "h", "d"];

/// Why the first column cannot be the one of times, if no column of numbers is called so.
pub(super) fn no_times(columns: &[Values]) -> Option<String> {
    if let Some((column, _)) = columns.iter().find(|(column, _)| is_time(&column.name)) {
        return Some(format!("the column \"{}\" holds texts, not numbers", column.name));
    }
    let strings = columns.iter().find(|(_, values)| values.is_none()).map(|(column, _)| &column.name);
    if let Some(name) = strings {
        return Some(format!(
            "no column is called time, and the column \"{name}\" holds texts: this is no table of values over time"
        ));
    }
    let first = &columns.first()?.0;
    let unit = first.unit.as_ref().filter(|unit| !TIMES.contains(&unit.as_str()))?;
    Some(format!("no column is called time, and the first one, \"{}\", has the unit {unit}", first.name))
}

//! The signals that the page knows by name: those of a grasp.

use std::collections::HashMap;

use crate::report::figures::SIGNALS;
use fmi2_cosim::record::Table;

/// Signals that the picture or a chart of its own shows beside those of the [figures](SIGNALS).
const MORE: [&str; 8] = [
    "y_object",
    "tau1_cmd_sent",
    "tau2_cmd_sent",
    "u_cmd_sent",
    "energy",
    "y_object_d",
    "tip_deflection1",
    "tip_deflection2",
];

/// Whether the page has a place of its own for a signal.
#[must_use]
pub fn is_known(signal: &str) -> bool {
    SIGNALS.contains(&signal)
        || MORE.contains(&signal)
        || signal.starts_with("deflection1[")
        || signal.starts_with("deflection2[")
}

/// Other tools write `system.plant.theta1` for what this one calls `theta1`. Gives such columns the plain name, where only one
/// of them claims it.
pub fn rename_known(table: &mut Table) {
    let mut claims: HashMap<String, Vec<usize>> = HashMap::new();
    for (index, column) in table.columns().iter().enumerate() {
        let plain = column.name.rsplit(['.', '/']).next().unwrap_or_default();
        if is_known(plain) {
            claims.entry(plain.to_owned()).or_default().push(index);
        }
    }
    for (plain, indices) in claims {
        if let [index] = indices[..] {
            table.rename(index, plain);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi2_cosim::record::Column;

    #[test]
    fn signals_of_other_tools_get_their_plain_names() {
        let names = ["a.plant.theta1", "a/plant/deflection1[2]", "x.theta2", "y.theta2", "u", "b.u", "T.body"];
        let mut table = Table::new(names.map(|name| Column { name: name.into(), ..Column::default() }).to_vec());
        rename_known(&mut table);
        let names: Vec<_> = table.columns().iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["theta1", "deflection1[2]", "x.theta2", "y.theta2", "u", "b.u", "T.body"]);
    }
}

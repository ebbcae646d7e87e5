//! The signals that the page recognises by name: those of a grasp.

use std::collections::HashMap;

use crate::report::figures::SIGNALS;
use fmi2_cosim::record::{Column, Sink, Table};

/// Signals that the picture or a chart of its own shows beside those of the [figures](SIGNALS).
const MORE: [&str; 16] = [
    "y_object",
    "tau1_cmd_sent",
    "tau2_cmd_sent",
    "u_cmd_sent",
    "energy",
    "y_object_d",
    "tip_deflection1",
    "tip_deflection2",
    "gap1",
    "gap2",
    "in_contact",
    "impacts1",
    "impacts2",
    "indentation1",
    "indentation2",
    "impact_loss",
];

/// Whether the page has a place of its own for a signal.
#[must_use]
pub fn is_known(signal: &str) -> bool {
    SIGNALS.contains(&signal)
        || MORE.contains(&signal)
        || signal.starts_with("deflection1[")
        || signal.starts_with("deflection2[")
}

/// Columns of `--monitor` fall by many powers of ten. A page shows the decadic logarithm of each such column without
/// negative values, under a name that says so. Exponentials are then straight lines.
#[must_use]
pub fn with_decades(table: Table) -> Table {
    let is_decaying = |(index, column): (usize, &Column)| {
        column.name.starts_with(MONITORED) && table.column_at(index).iter().all(|value| *value >= 0.0 || value.is_nan())
    };
    let decades: Vec<bool> = table.columns().iter().enumerate().map(is_decaying).collect();
    if !decades.contains(&true) {
        return table;
    }
    let column = |(column, is_decaying): (&Column, &bool)| match is_decaying {
        true => Column { name: format!("log10_{}", column.name), unit: None, ..column.clone() },
        false => column.clone(),
    };
    let mut shown = Table::new(table.columns().iter().zip(&decades).map(column).collect());
    for (time, values) in table.rows() {
        let value = |(value, is_decaying): (&f64, &bool)| if *is_decaying { value.log10() } else { *value };
        let row: Vec<f64> = values.iter().zip(&decades).map(value).collect();
        // Memory takes every row.
        let _ = shown.row(time, &row);
    }
    shown
}

/// How the columns of `--monitor` begin.
const MONITORED: &str = "lyapunov_";

/// Other tools write `system.plant.theta1` instead of `theta1`. Gives such columns the plain name, if only one column has
/// it.
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

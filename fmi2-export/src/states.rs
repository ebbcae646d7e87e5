//! Tables of continuous states, as crates of equations have them.

use std::sync::Arc;

use parameter_table::StateVariable;

use crate::exchange::ModelExchange;
use crate::variables::{Evaluation, Variables};

impl<M: ModelExchange> Variables<M> {
    /// Declares a table of continuous states as local variables, and after them their time derivatives, called `der(NAME)`.
    ///
    /// Each evaluation fills in the field after it, which has as many elements as the table has rows.
    pub fn states(
        &mut self,
        table: &[StateVariable],
        evaluation: Evaluation,
        values: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
        rate_evaluation: Evaluation,
        rates: impl Fn(&mut M) -> &mut [f64] + Send + Sync + 'static,
    ) {
        let (values, rates) = (Arc::new(values), Arc::new(rates));
        let mut model = M::default();
        let (found, expected) = ((values(&mut model).len(), rates(&mut model).len()), table.len());
        for (i, row) in table.iter().enumerate() {
            let values = Arc::clone(&values);
            let state = self.local(row.name.as_str(), evaluation, move |m| &mut values(m)[i]).state();
            let state = state.nominal(row.nominal).description(&row.description);
            let state = if has_unit(row) { state.unit(row.unit) } else { state };
            if found != (expected, expected) {
                let mistake = format!("the table has {expected} rows, but there are {found:?} values and rates");
                state.variables[0].mistakes.push(mistake);
            }
        }
        for (i, row) in table.iter().enumerate() {
            let rates = Arc::clone(&rates);
            let rate = self.local(format!("der({})", row.name), rate_evaluation, move |m| &mut rates(m)[i]);
            let rate = rate.derivative_of(&row.name).description(&format!("Time derivative of {}", row.name));
            if has_unit(row) {
                rate.unit(&per_second(row.unit));
            }
        }
    }
}

/// Whether a state is more than a pure number, in a unit that there is.
fn has_unit(row: &StateVariable) -> bool {
    !matches!(row.unit, "" | "1")
}

/// The unit of a quantity's rate, as people write it.
fn per_second(unit: &str) -> String {
    if unit == "J" {
        return "W".to_owned();
    }
    if let Some(rest) = unit.strip_suffix(".s") {
        return rest.to_owned();
    }
    match unit.rsplit_once("/s") {
        Some((rest, power)) if power.is_empty() || power.bytes().all(|digit| digit.is_ascii_digit()) => {
            format!("{rest}/s{}", power.parse().unwrap_or(1) + 1)
        }
        _ => format!("{unit}/s"),
    }
}

#[cfg(test)]
mod tests {
    use super::per_second;
    use crate::unit::Unit;

    #[test]
    fn the_unit_of_a_rate_is_that_of_the_quantity_per_second() {
        for (unit, rate) in [
            ("m", "m/s"),
            ("m/s", "m/s2"),
            ("m/s2", "m/s3"),
            ("N.m", "N.m/s"),
            ("N2.s", "N2"),
            ("J", "W"),
            ("kg.m2", "kg.m2/s"),
            ("rad/s", "rad/s2"),
        ] {
            assert_eq!(per_second(unit), rate);
            let [unit, rate] = [unit, rate].map(|text| text.parse::<Unit>().unwrap());
            assert!(rate.is_per_second_of(&unit));
        }
    }
}

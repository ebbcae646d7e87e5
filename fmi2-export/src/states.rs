//! Tables of continuous states, as crates of equations have them.

use parameter_table::StateVariable;

use crate::access::Scalar;
use crate::declarations::{Declarations, Role};
use crate::exchange::{Exchange, ModelExchange};
use crate::place::Place;
use crate::variable::Causality;
use crate::variables::{Evaluation, Variables, length};

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
        let found = (length(&mut self.declared, &values), length(&mut self.declared, &rates));
        let exchange = Exchange::of::<M>();
        self.declared.states(
            table,
            exchange,
            found,
            [evaluation, rate_evaluation],
            [&Place::array(values), &Place::array(rates)],
        );
    }
}

impl Declarations {
    fn states(
        &mut self,
        table: &[StateVariable],
        exchange: &'static Exchange,
        found: (usize, usize),
        [evaluation, rate_evaluation]: [Evaluation; 2],
        [values, rates]: [&Place; 2],
    ) {
        let expected = table.len();
        let number = |place: &Place, i: usize| f64::access(place.element(i, size_of::<f64>()));
        for (i, row) in table.iter().enumerate() {
            let role = Role::computed(Causality::Local, evaluation);
            let state = self.add(row.name.clone(), None, role, number(values, i));
            self.state(state, exchange);
            self.nominal(state, row.nominal);
            self.description(state, &row.description);
            if has_unit(row) {
                self.unit(state, row.unit);
            }
            if found != (expected, expected) {
                let mistake = format!("the table has {expected} rows, but there are {found:?} values and rates");
                self.list[state].mistakes.push(mistake);
            }
        }
        for (i, row) in table.iter().enumerate() {
            let role = Role::computed(Causality::Local, rate_evaluation);
            let rate = self.add(format!("der({})", row.name), None, role, number(rates, i));
            self.derivative_of(rate, &row.name);
            if self.brief {
                continue;
            }
            self.description(rate, &format!("Time derivative of {}", row.name));
            if has_unit(row) {
                self.unit(rate, &per_second(row.unit));
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
    match unit.rsplit_once('/').and_then(|(rest, last)| Some((rest, last.strip_prefix('s')?))) {
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

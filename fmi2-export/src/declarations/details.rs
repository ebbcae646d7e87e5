//! What is said of variables once they are declared: of those from the `first` on.

use super::Declarations;
use crate::exchange::Exchange;
use crate::place::Place;
use crate::unit::{DisplayUnit, Unit};
use crate::variable::{Causality, DependencyKind, Variability, Variable};
use crate::variables::Evaluation;

impl Declarations {
    /// Changes the variables from the `first` on.
    fn each(&mut self, first: usize, change: &mut dyn FnMut(&mut Variable)) {
        self.list[first..].iter_mut().for_each(change);
    }

    /// Changes what only people and the description need.
    fn tell(&mut self, first: usize, change: &mut dyn FnMut(&mut Variable)) {
        if !self.brief {
            self.each(first, change);
        }
    }

    #[inline(never)]
    pub fn description(&mut self, first: usize, text: &str) {
        self.tell(first, &mut |v| v.description = v.numbered(text));
    }

    #[inline(never)]
    pub fn unit(&mut self, first: usize, expression: &str) {
        self.tell(first, &mut |v| match expression.parse() {
            Ok(unit) => v.unit = Some(unit),
            Err(error) => v.mistakes.push(error.to_string()),
        });
    }

    #[inline(never)]
    pub fn other_unit(&mut self, first: usize, unit: &Unit) {
        self.tell(first, &mut |v| v.unit = Some(unit.clone()));
    }

    #[inline(never)]
    pub fn display_unit(&mut self, first: usize, name: &str, factor: f64) {
        self.tell(first, &mut |v| v.display_unit = Some(DisplayUnit { name: name.to_owned(), factor }));
    }

    #[inline(never)]
    pub fn display_degrees(&mut self, first: usize) {
        self.tell(first, &mut |v| match v.unit.as_ref().and_then(DisplayUnit::degrees) {
            Some(degrees) => v.display_unit = Some(degrees),
            None => v
                .mistakes
                .push("degrees are shown of angles and their rates, so say a unit such as rad/s before".into()),
        });
    }

    /// An infinite end is none.
    #[inline(never)]
    pub fn range(&mut self, first: usize, min: f64, max: f64) {
        let (min, max) = (Some(min).filter(|v| *v != f64::NEG_INFINITY), Some(max).filter(|v| *v != f64::INFINITY));
        self.each(first, &mut |v| (v.min, v.max) = (min, max));
    }

    #[inline(never)]
    pub fn min(&mut self, first: usize, min: f64) {
        self.each(first, &mut |v| v.min = Some(min).filter(|v| *v != f64::NEG_INFINITY));
    }

    #[inline(never)]
    pub fn nominal(&mut self, first: usize, nominal: f64) {
        self.each(first, &mut |v| v.nominal = Some(nominal));
    }

    #[inline(never)]
    pub fn discrete(&mut self, first: usize) {
        self.each(first, &mut |v| match v.causality {
            Causality::Parameter => v.mistakes.push("a parameter is fixed or tunable, not discrete".into()),
            Causality::Input | Causality::Output | Causality::Local => v.variability = Variability::Discrete,
        });
    }

    #[inline(never)]
    pub fn tunable(&mut self, first: usize) {
        self.each(first, &mut |v| match v.causality {
            Causality::Parameter => v.variability = Variability::Tunable,
            Causality::Input | Causality::Output | Causality::Local => {
                v.mistakes.push("only a parameter is tunable".into());
            }
        });
    }

    #[inline(never)]
    pub fn depends(&mut self, first: usize, inputs: &[String], kind: DependencyKind) {
        self.each(first, &mut |v| {
            let its: Vec<_> = inputs.iter().map(|input| (v.numbered(input), kind)).collect();
            v.depends_on.extend(its);
        });
    }

    #[inline(never)]
    pub fn starts(&mut self, first: usize, inputs: &[String]) {
        self.tell(first, &mut |v| {
            let its: Vec<_> = inputs.iter().map(|input| v.numbered(input)).collect();
            v.starts_from.extend(its);
        });
    }

    #[inline(never)]
    pub fn depends_states(&mut self, first: usize, states: &[String]) {
        self.tell(first, &mut |v| {
            let its: Vec<_> = states.iter().map(|state| v.numbered(state)).collect();
            v.depends_on_states.get_or_insert_default().extend(its);
        });
    }

    #[inline(never)]
    pub fn ramp(&mut self, first: usize, place: Place) {
        let place = place.behind(self.part.1);
        self.each(first, &mut |v| v.ramp = Some(place.clone()));
    }

    #[inline(never)]
    pub fn rate(&mut self, first: usize, evaluation: Evaluation, place: Place) {
        let place = place.behind(self.part.1);
        self.each(first, &mut |v| v.rate = Some((place.clone(), evaluation)));
    }

    #[inline(never)]
    pub fn ramps(&mut self, first: usize, array: Place, length: usize) {
        self.each_of(first, "slopes", array, length, &mut |v, place| v.ramp = Some(place));
    }

    #[inline(never)]
    pub fn rates(&mut self, first: usize, evaluation: Evaluation, array: Place, length: usize) {
        self.each_of(first, "rates", array, length, &mut |v, place| v.rate = Some((place, evaluation)));
    }

    /// Gives each variable its element of an array of numbers.
    fn each_of(
        &mut self,
        first: usize,
        what: &str,
        array: Place,
        length: usize,
        give: &mut dyn FnMut(&mut Variable, Place),
    ) {
        let (array, count) = (array.behind(self.part.1), self.list.len() - first);
        let mut i = 0;
        self.each(first, &mut |v| {
            give(v, array.element(i, size_of::<f64>()));
            i += 1;
            if length != count {
                v.mistakes.push(format!("it is one of {count}, but there are {length} {what}"));
            }
        });
    }

    #[inline(never)]
    pub fn state(&mut self, first: usize, exchange: &'static Exchange) {
        self.offer(exchange);
        self.each(first, &mut |v| v.is_state = true);
    }

    #[inline(never)]
    pub fn derivative_of(&mut self, first: usize, state: &str) {
        self.each(first, &mut |v| v.derivative_of = Some(v.numbered(state)));
    }
}

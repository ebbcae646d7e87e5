//! What has been declared of a model, its type forgotten: what [`Variables`](crate::Variables) and
//! [`VariableBuilder`](crate::VariableBuilder) fill in.
//!
//! Declarations are long lists of calls, run once for a library, of which there is one for each of its models. So what the calls do
//! is here, compiled once, and a call is no more than that.

mod details;

use std::any::TypeId;
use std::mem;
use std::ptr;
use std::sync::Arc;

use parameter_table::{Owner, Parameter, replaced};

use crate::access::Access;
use crate::any_model::{AnyModel, fresh};
use crate::exchange::Exchange;
use crate::info::Info;
use crate::model::Model;
use crate::place::Place;
use crate::variable::{Causality, Variability, Variable};
use crate::variables::{Evaluation, Variables};
use crate::view::{Declared, Evaluate, NumbersOf, View};

/// Declares the rows of a table for one of several parts: its owner, number and place.
type RowsOfOne<'a> = dyn FnMut(&mut Declarations, Owner<'_>, Option<usize>, &Place) + 'a;

/// What has been declared of a model.
pub(crate) struct Declarations {
    pub info: Info,
    pub model: TypeId,
    /// What is being declared: the model or, while a part of it is, the type of that part, and where it is in the model.
    part: (TypeId, usize),
    pub list: Vec<Variable>,
    pub evaluations: Vec<Evaluate>,
    /// What a host that integrates calls, once anything of it has been declared.
    pub exchange: Option<&'static Exchange>,
    pub indicators: Option<Indicators>,
    pub time: Option<Place>,
    /// A model with its default values.
    pub sample: Box<dyn AnyModel>,
    /// What only people and the description need of a variable is left out: what it is, its units, and
    /// what it depends on besides inputs at once.
    pub brief: bool,
}

/// What fills in the event indicators, and where they are.
pub(crate) struct Indicators {
    pub evaluation: Evaluation,
    pub array: Arc<NumbersOf>,
    /// How many there are.
    pub count: usize,
}

/// What a variable is to the host, and what computes it.
#[derive(Clone, Copy)]
pub(crate) struct Role {
    pub causality: Causality,
    /// Of numbers; whatever is no number can only jump.
    pub variability: Variability,
    pub evaluation: Option<Evaluation>,
}

impl Role {
    pub const INPUT: Self =
        Self { causality: Causality::Input, variability: Variability::Continuous, evaluation: None };
    pub const PARAMETER: Self =
        Self { causality: Causality::Parameter, variability: Variability::Fixed, evaluation: None };

    pub const fn computed(causality: Causality, evaluation: Evaluation) -> Self {
        Self { causality, variability: Variability::Continuous, evaluation: Some(evaluation) }
    }
}

impl Declarations {
    pub fn of<M: Model>() -> Self {
        Self::made::<M>(false)
    }

    /// What instances need. It is not to be checked: descriptions would be found to be missing.
    pub fn brief<M: Model>() -> Self {
        Self::made::<M>(true)
    }

    fn made<M: Model>(brief: bool) -> Self {
        let mut variables = Variables::<M>::new(Self::none(M::INFO, TypeId::of::<M>(), fresh::<M>(), brief));
        M::variables(&mut variables);
        variables.declared
    }

    fn none(info: Info, model: TypeId, sample: Box<dyn AnyModel>, brief: bool) -> Self {
        Self {
            info,
            model,
            part: (model, 0),
            list: Vec::new(),
            evaluations: Vec::new(),
            exchange: None,
            indicators: None,
            time: None,
            sample,
            brief,
        }
    }

    /// The values that variables have by default.
    pub fn defaults(&mut self) -> View<'_> {
        let (variables, evaluations) = (self.list.as_slice(), self.evaluations.as_slice());
        View::of(Declared { model: self.model, variables, evaluations, reals: &[] }, &mut *self.sample)
    }

    /// The model with its default values, or the part that is being declared.
    pub fn sample<M: 'static>(&mut self) -> &mut M {
        let (part, offset) = self.part;
        assert!(part == TypeId::of::<M>(), "a part of another model");
        // SAFETY: a value of this type is there: that is asserted of models, and `Field` promises it of parts.
        unsafe { &mut *ptr::from_mut(&mut *self.sample).byte_add(offset).cast() }
    }

    /// Declares a part of the model, then the model again.
    pub fn part(&mut self, part: TypeId, offset: usize, declare: &mut dyn FnMut(&mut Self)) {
        let whole = self.part;
        self.part = (part, whole.1 + offset);
        declare(self);
        self.part = whole;
    }

    /// # Panics
    /// If a part of the model is being declared.
    fn of_the_whole(&self, what: &str) {
        assert!(self.part == (self.model, 0), "{what} are the whole model's: declare them outside of its parts");
    }

    pub fn evaluation<M>(&mut self, evaluation: fn(&mut M)) -> Evaluation {
        // SAFETY: references and pointers to types with a size are passed alike. It is called with models of this type only:
        // see `View`.
        self.add_evaluation(unsafe { mem::transmute::<fn(&mut M), Evaluate>(evaluation) })
    }

    #[inline(never)]
    fn add_evaluation(&mut self, evaluation: Evaluate) -> Evaluation {
        self.of_the_whole("evaluations");
        self.evaluations.push(evaluation);
        Evaluation(self.evaluations.len() - 1)
    }

    #[inline(never)]
    pub fn time(&mut self, place: Place) {
        self.time = Some(place.behind(self.part.1));
    }

    #[inline(never)]
    pub fn offer(&mut self, exchange: &'static Exchange) {
        self.of_the_whole("states and event indicators");
        self.exchange = Some(exchange);
    }

    /// Declares one variable at this place; where it is in the list.
    #[inline(never)]
    pub fn one(&mut self, name: String, role: Role, place: Place, access: fn(Place) -> Access) -> usize {
        self.add(name, None, role, access(place.behind(self.part.1)))
    }

    /// Declares the elements of an array, each of so many bytes; where the first is in the list.
    #[inline(never)]
    pub fn elements(
        &mut self,
        name: &str,
        role: Role,
        array: Place,
        length: usize,
        size: usize,
        access: fn(Place) -> Access,
    ) -> usize {
        let (array, first) = (array.behind(self.part.1), self.list.len());
        let pattern = if replaced(name, "{}", "") == name { format!("{name}[{{}}]") } else { name.to_owned() };
        for i in 0..length {
            self.add(numbered(&pattern, i + 1), Some(i + 1), role, access(array.element(i, size)));
        }
        first
    }

    /// Declares a table of parameters of each of several elements of an array, each of so many bytes; `rows` declares those of one.
    #[inline(never)]
    pub fn family(&mut self, array: &Place, length: usize, size: usize, rows: &mut RowsOfOne<'_>) {
        for i in 0..length {
            let number = (i + 1).to_string();
            rows(self, Owner::named(&number), Some(i + 1), &array.element(i, size));
        }
    }

    /// Declares a table of parameters of a part of the model, which is at this place.
    #[inline(never)]
    pub fn rows<T>(&mut self, table: &[Parameter<T>], owner: Owner<'_>, number: Option<usize>, part: &Place) {
        for row in table {
            let &Parameter { name, unit, range, description, field } = row;
            self.row(&Parameter { name, unit, range, description, field: nowhere }, owner, number, part.then(field));
        }
    }

    #[inline(never)]
    fn row(&mut self, row: &Parameter<f64>, owner: Owner<'_>, number: Option<usize>, place: Place) {
        let place = place.behind(self.part.1);
        let first = self.add(row.name_of(owner), number, Role::PARAMETER, Access::Real(place));
        self.range(first, row.range.min, row.range.max);
        if self.brief {
            return;
        }
        self.description(first, &row.description_of(owner));
        if !row.unit.is_empty() {
            self.unit(first, &row.unit_of(owner));
        }
    }

    /// Declares one variable; where it is in the list.
    #[inline(never)]
    pub fn add(&mut self, name: String, number: Option<usize>, role: Role, access: Access) -> usize {
        let variability = match (role.variability, &access) {
            (Variability::Continuous, Access::Real(_)) => Variability::Continuous,
            (Variability::Continuous, _) => Variability::Discrete,
            (other, _) => other,
        };
        let first = self.list.len();
        self.list.push(Variable {
            name,
            number,
            description: String::new(),
            causality: role.causality,
            variability,
            access,
            unit: None,
            display_unit: None,
            min: None,
            max: None,
            nominal: None,
            depends_on: Vec::new(),
            starts_from: Vec::new(),
            evaluation: role.evaluation,
            ramp: None,
            rate: None,
            is_state: false,
            derivative_of: None,
            depends_on_states: None,
            mistakes: Vec::new(),
        });
        first
    }
}

impl Variable {
    /// A text in which `{}` stands for the variable's number, if it has one.
    fn numbered(&self, text: &str) -> String {
        self.number.map_or_else(|| text.to_owned(), |number| numbered(text, number))
    }
}

/// The field of a row whose place is given beside it.
fn nowhere(owner: &mut f64) -> &mut f64 {
    owner
}

/// The text for one element of an array.
fn numbered(text: &str, number: usize) -> String {
    replaced(text, "{}", &number.to_string())
}

#[cfg(test)]
mod tests;

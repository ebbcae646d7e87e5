//! The result: one row per run, in the order of runs, as Parquet or CSV.
//!
//! | column | type | |
//! |:--|:--|:--|
//! | `run`, `draw` | integers | runs of one draw have the same values |
//! | `controller` | text | if the study names controllers |
//! | a parameter's name | number, integer, truth value or text | the drawn value |
//! | `status`, `error` | texts | `ok`, or the status of the run and its reason |
//! | `success` | truth value | if the study defines success |
//! | a figure's name | number, or nothing | |

mod results;

use fmi2_import::Value;

use super::figures::GRASP;
use super::plan::Plan;
use super::study::{Bound, Method, Range};
use super::{Row, Status};
pub use results::Results;

/// The type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// 64-bit integers.
    Integer,
    /// Doubles.
    Real,
    /// Truth values.
    Boolean,
    /// Texts.
    Text,
}

/// A column of the result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: Kind,
    /// Whether it may hold nothing.
    pub optional: bool,
}

/// One field of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Field {
    /// Nothing.
    None,
    /// An integer.
    Integer(i64),
    /// A number.
    Real(f64),
    /// A truth value.
    Boolean(bool),
    /// A text.
    Text(String),
}

/// The columns of a study's result and how rows fill them.
pub struct Layout<'a> {
    plan: &'a Plan,
    columns: Vec<Column>,
    /// For each bound of success the place of its figure.
    bounds: Vec<usize>,
    figures: usize,
}

impl<'a> Layout<'a> {
    /// For a study whose rows have these figures.
    #[must_use]
    pub fn new(plan: &'a Plan, figures: &[String]) -> Self {
        let column = |name: &str, kind, optional| Column { name: name.to_owned(), kind, optional };
        let mut columns = vec![column("run", Kind::Integer, false), column("draw", Kind::Integer, false)];
        if !plan.contenders.is_empty() {
            columns.push(column("controller", Kind::Text, false));
        }
        for (index, varied) in plan.sampler.vary().iter().enumerate() {
            columns.push(column(&varied.name, kind(plan, index, &varied.range), false));
        }
        columns.push(column("status", Kind::Text, false));
        columns.push(column("error", Kind::Text, true));
        if !plan.study.success.is_empty() {
            columns.push(column("success", Kind::Boolean, false));
        }
        columns.extend(figures.iter().map(|figure| column(figure, Kind::Real, true)));
        let place = |bound: &Bound| figures.iter().position(|figure| *figure == bound.figure);
        let bounds = plan.study.success.iter().filter_map(place).collect();
        Self { plan, columns, bounds, figures: figures.len() }
    }

    /// The columns.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Whether a run is a success; `None` if the study does not define success.
    #[must_use]
    pub fn success(&self, row: &Row) -> Option<bool> {
        let bounds = &self.plan.study.success;
        let holds = || self.bounds.iter().zip(bounds).all(|(place, bound)| bound.holds(row.figure(*place)));
        (!bounds.is_empty()).then(|| row.status == Status::Ok && holds())
    }

    /// The fields of a row.
    #[must_use]
    pub fn fields(&self, row: &Row) -> Vec<Field> {
        let draw = self.plan.draw(row.run);
        #[allow(clippy::cast_possible_wrap)] // there are at most ten million
        let mut fields = vec![Field::Integer(row.run as i64), Field::Integer(draw as i64)];
        fields.extend(self.plan.controller(row.run).map(|controller| Field::Text(controller.to_owned())));
        for value in self.plan.sampler.values(draw) {
            let kind = self.columns[fields.len()].kind;
            fields.push(match value {
                Value::Integer(value) if kind == Kind::Integer => Field::Integer(value.into()),
                Value::Integer(value) if kind == Kind::Real => Field::Real(value.into()),
                Value::Real(value) if kind == Kind::Real => Field::Real(value),
                Value::Boolean(value) if kind == Kind::Boolean => Field::Boolean(value),
                other => Field::Text(other.to_string()),
            });
        }
        fields.push(Field::Text(row.status.name().to_owned()));
        fields.push(row.error.clone().map_or(Field::None, Field::Text));
        fields.extend(self.success(row).map(Field::Boolean));
        fields.extend((0..self.figures).map(|place| row.figure(place).map_or(Field::None, Field::Real)));
        fields
    }
}

/// The type of a parameter's column.
fn kind(plan: &Plan, index: usize, range: &Range) -> Kind {
    let of = |values: &mut dyn Iterator<Item = Value>| {
        let mut kind = None;
        for value in values {
            let next = match value {
                Value::Real(_) => Kind::Real,
                Value::Integer(_) => Kind::Integer,
                Value::Boolean(_) => Kind::Boolean,
                Value::Text(_) => Kind::Text,
            };
            kind = Some(match (kind, next) {
                (None, next) => next,
                (Some(kind), next) if kind == next => kind,
                (Some(Kind::Real | Kind::Integer), Kind::Real | Kind::Integer) => Kind::Real,
                _ => Kind::Text,
            });
        }
        kind.unwrap_or(Kind::Real)
    };
    match range {
        Range::Seed => Kind::Integer,
        Range::Values(values) => of(&mut values.iter().cloned()),
        Range::Column => of(&mut (0..plan.sampler.draws()).map(|draw| plan.sampler.values(draw)[index].clone())),
        Range::Linear { .. } | Range::Logarithmic { .. } | Range::Normal { .. }
            if plan.study.method == Method::Table =>
        {
            of(&mut (0..plan.sampler.draws()).map(|draw| plan.sampler.values(draw)[index].clone()))
        }
        _ => Kind::Real,
    }
}

/// The unit of a figure of a grasp.
#[must_use]
pub fn unit(name: &str) -> Option<&'static str> {
    GRASP.iter().find(|(figure, _, _)| *figure == name).map(|(_, unit, _)| *unit)
}

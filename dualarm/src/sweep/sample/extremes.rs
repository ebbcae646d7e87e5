//! Values that no draw goes beyond, so that a range which an FMU does not allow is found before the first run.

use fmi2_import::Value;

use super::Sampler;
use crate::sweep::study::{Coordinates, Method, Range, Varied};

impl Sampler {
    /// For each parameter values between which those of all draws are, or all its values where they have no order.
    #[must_use]
    pub fn extremes(&self) -> Vec<Vec<Value>> {
        let has_ends = |range: &Range| {
            matches!(range, Range::Linear { .. } | Range::Logarithmic { .. } | Range::Values(_) | Range::Seed)
        };
        let is_table = self.method == Method::Table && self.coordinates == Coordinates::Values;
        let mut drawn: Vec<Vec<Value>> = vec![Vec::new(); self.vary.len()];
        if is_table || self.vary.iter().any(|varied| !has_ends(&varied.range)) {
            for draw in 0..self.draws {
                for (known, value) in drawn.iter_mut().zip(self.values(draw)) {
                    widen(known, value);
                }
            }
        }
        let of_parameter = |(varied, drawn): (&Varied, Vec<Value>)| match &varied.range {
            _ if is_table && varied.range != Range::Seed => drawn,
            Range::Linear { low, high } | Range::Logarithmic { low, high } => vec![(*low).into(), (*high).into()],
            Range::Values(values) => values.clone(),
            Range::Seed => vec![Value::Integer(0), Value::Integer(i32::MAX)],
            Range::Normal { .. } | Range::Column => drawn,
        };
        self.vary.iter().zip(drawn).map(of_parameter).collect()
    }
}

/// Puts a value among the smallest number, the largest one and all else that is no number.
fn widen(known: &mut Vec<Value>, value: Value) {
    let Value::Real(number) = value else {
        if !known.contains(&value) {
            known.push(value);
        }
        return;
    };
    let is_beyond = |other: &Value, order: std::cmp::Ordering| matches!(other, Value::Real(other) if number.total_cmp(other) == order);
    let numbers: Vec<usize> = (0..known.len()).filter(|&at| matches!(known[at], Value::Real(_))).collect();
    match numbers[..] {
        [] => known.extend([Value::Real(number), Value::Real(number)]),
        [low, ..] if is_beyond(&known[low], std::cmp::Ordering::Less) => known[low] = number.into(),
        [_, high, ..] if is_beyond(&known[high], std::cmp::Ordering::Greater) => known[high] = number.into(),
        _ => {}
    }
}

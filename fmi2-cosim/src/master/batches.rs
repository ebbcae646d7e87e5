//! Lists of variables, and the calls that get or set them.
//!
//! Many FMUs have a short way for variables whose references follow each other, ours among them: a check and a copy for all at once. So
//! a list is in that order as far as it can be, and a long row of references that follow each other is a call of its own if the list has
//! more than that.

use fmi2_import::{CallError, Calls, ValueReference};

use super::bus::Signal;

/// So many variables in a row are worth a call of their own. A call costs about as much as two variables that are looked for one by one.
const LONG: usize = 3;

/// The references of some variables.
#[derive(Debug, Default, Clone)]
pub(super) struct Batches {
    references: Vec<ValueReference>,
    /// How many of the references each call has.
    calls: Vec<usize>,
}

impl FromIterator<ValueReference> for Batches {
    fn from_iter<I: IntoIterator<Item = ValueReference>>(references: I) -> Self {
        let references: Vec<_> = references.into_iter().collect();
        let mut calls: Vec<usize> = Vec::new();
        let mut is_after_short = false;
        for row in rows(&references) {
            let is_short = row.len() < LONG;
            match calls.last_mut() {
                Some(last) if is_short && is_after_short => *last += row.len(),
                _ => calls.push(row.len()),
            }
            is_after_short = is_short;
        }
        Self { references, calls }
    }
}

impl Batches {
    pub fn is_empty(&self) -> bool {
        self.references.is_empty()
    }

    pub fn len(&self) -> usize {
        self.references.len()
    }

    /// The place of a reference in the list.
    pub fn position(&self, reference: ValueReference) -> Option<usize> {
        self.references.iter().position(|known| *known == reference)
    }

    /// The first ones and these, in this order.
    pub fn with(&self, count: usize, others: impl IntoIterator<Item = ValueReference>) -> Self {
        self.references[..count].iter().copied().chain(others).collect()
    }

    /// Fetches the variables.
    #[allow(clippy::inline_always)] // As a call of its own it would be a third of what a call of an FMU costs the master.
    #[inline(always)]
    pub fn get<T: Signal>(&self, slave: &mut Calls, values: &mut [T]) -> Result<(), CallError> {
        let (mut references, mut values) = (&self.references[..], values);
        for count in &self.calls {
            let (wanted, here);
            (wanted, references) = references.split_at(*count);
            (here, values) = values.split_at_mut(*count);
            T::get(slave, wanted, here)?;
        }
        Ok(())
    }

    /// Sets the variables.
    #[allow(clippy::inline_always)] // As above.
    #[inline(always)]
    pub fn set<T: Signal>(&self, slave: &mut Calls, values: &[T]) -> Result<(), CallError> {
        let (mut references, mut values) = (&self.references[..], values);
        for count in &self.calls {
            let (wanted, these);
            (wanted, references) = references.split_at(*count);
            (these, values) = values.split_at(*count);
            T::set(slave, wanted, these)?;
        }
        Ok(())
    }
}

/// Puts what has references into the order for few and short calls: long rows first, then all others. If a reference is there twice, the
/// order stays as it is: of two values for one variable the last counts.
pub(super) fn arrange<T: Copy>(list: &mut Vec<T>, reference: impl Fn(&T) -> ValueReference) {
    let mut sorted = list.clone();
    sorted.sort_by_key(&reference);
    let references: Vec<_> = sorted.iter().map(reference).collect();
    if references.windows(2).any(|two| two[0] == two[1]) {
        return;
    }
    list.clear();
    for is_long in [true, false] {
        let mut rest = &sorted[..];
        for row in rows(&references) {
            let (row, others) = rest.split_at(row.len());
            rest = others;
            if (row.len() >= LONG) == is_long {
                list.extend_from_slice(row);
            }
        }
    }
}

/// The references in rows that follow each other.
fn rows(references: &[ValueReference]) -> impl Iterator<Item = &[ValueReference]> {
    references.chunk_by(|one, next| one.checked_add(1) == Some(*next))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The order of these references, and how many each call has.
    fn arranged(list: &[ValueReference]) -> (Vec<ValueReference>, Vec<usize>) {
        let mut list = list.to_vec();
        arrange(&mut list, |reference| *reference);
        let Batches { references, calls } = list.into_iter().collect();
        assert_eq!(references.len(), calls.iter().sum::<usize>());
        (references, calls)
    }

    #[test]
    fn long_rows_are_calls_of_their_own() {
        assert_eq!(arranged(&[]), (vec![], vec![]));
        assert_eq!(arranged(&[3, 9, 1]), (vec![1, 3, 9], vec![3]));
        assert_eq!(arranged(&[17, 16, 18]), (vec![16, 17, 18], vec![3]));
        assert_eq!(arranged(&[22, 17, 16, 18]), (vec![16, 17, 18, 22], vec![3, 1]));
        assert_eq!(arranged(&[9, 1, 7, 3, 5, 11]), (vec![1, 3, 5, 7, 9, 11], vec![6]));
        assert_eq!(arranged(&[5, 9, 4, 1]), (vec![1, 4, 5, 9], vec![4]));
        let mut scattered: Vec<_> = (6..18).chain([30, 29, 2]).collect();
        assert_eq!(arranged(&scattered), ((6..18).chain([2, 29, 30]).collect(), vec![12, 3]));
        scattered.extend(40..46);
        assert_eq!(arranged(&scattered), ((6..18).chain(40..46).chain([2, 29, 30]).collect(), vec![12, 6, 3]));
        assert_eq!(arranged(&[u32::MAX, 0]), (vec![0, u32::MAX], vec![2]));
    }

    /// Two names of one variable: of two values for it the last one counts.
    #[test]
    fn the_order_of_equal_references_stays() {
        let list = [7, 6, 5, 4, 3, 2, 7];
        assert_eq!(arranged(&list), (list.to_vec(), vec![7]));
    }
}

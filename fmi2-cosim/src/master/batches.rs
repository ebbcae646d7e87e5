//! Lists of variables, and the calls that get or set them.
//!
//! Many FMUs have a short way for variables whose references follow each other, ours among them: a check and a copy for all at once. So
//! a list is in that order as far as it can be, and a long row of references that follow each other is a call of its own if the list has
//! more than that.

use fmi2_import::{CallError, Calls, Status, ValueReference};

use super::bus::Signal;

/// So many variables in a row are worth a call of their own. A call costs about as much as two variables that are looked for one by one.
const LONG: usize = 3;

/// Variables that one call gets or sets. Their values are neighbours among the signals.
#[derive(Debug)]
pub(super) struct Call {
    references: Box<[ValueReference]>,
    first: usize,
}

impl Call {
    /// Of variables whose values begin at this place.
    fn new(references: &[ValueReference], first: usize) -> Self {
        Self { references: references.into(), first }
    }

    /// Fetches the variables.
    #[allow(clippy::inline_always)] // As a call of its own it would be a third of what a call of an FMU costs the master.
    #[inline(always)]
    pub fn get<T: Signal>(&self, slave: &mut Calls, signals: &mut [T]) -> Result<Status, CallError> {
        T::get(slave, &self.references, &mut signals[self.first..][..self.references.len()])
    }

    /// Sets the variables.
    #[allow(clippy::inline_always)] // As above.
    #[inline(always)]
    pub fn set<T: Signal>(&self, slave: &mut Calls, signals: &[T]) -> Result<Status, CallError> {
        T::set(slave, &self.references, &signals[self.first..][..self.references.len()])
    }

    /// Where the value of a variable is, if it is one of these.
    pub fn place(&self, reference: ValueReference) -> Option<usize> {
        Some(self.first + self.references.iter().position(|known| *known == reference)?)
    }

    /// Where the values are.
    pub fn places(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.references.len()
    }

    /// Moves it to other values, as many.
    pub fn move_to(&mut self, first: usize) {
        self.first = first;
    }
}

/// The calls for these variables, whose values lie in this order from `first` on.
pub(super) fn calls(references: &[ValueReference], first: usize) -> Vec<Call> {
    let mut counts: Vec<usize> = Vec::new();
    let mut is_after_short = false;
    for row in rows(references) {
        let is_short = row.len() < LONG;
        match counts.last_mut() {
            Some(last) if is_short && is_after_short => *last += row.len(),
            _ => counts.push(row.len()),
        }
        is_after_short = is_short;
    }
    let mut done = 0;
    let call = |count| {
        let begin = done;
        done += count;
        Call::new(&references[begin..done], first + begin)
    };
    counts.into_iter().map(call).collect()
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
        let calls = calls(&list, 7);
        // Each call has its part of the list, at its place.
        assert!(calls.iter().flat_map(Call::places).eq(7..7 + list.len()));
        assert!(calls.iter().flat_map(|call| &call.references).eq(&list));
        (list, calls.iter().map(|call| call.references.len()).collect())
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

//! The gains of a law by name, although several structs own them.

use parameter_table::{Admissible, InvalidParameter, Parameter, Range, replaced};

/// All gains of a law.
///
/// [`tables`](Self::tables) and [`preset`](Self::preset) are the only lists of what belongs to a law and of its built-in sets:
/// declarations, checks and tools go through them.
pub trait GainSet: Copy + 'static {
    /// Shows all tables, in the order in which an interface declares them.
    fn tables(to: &mut impl Tables<Self>);

    /// The built-in set of this name. `None` if there is no such set; so for `parameters`, with which the parameters hold.
    fn preset(name: &str) -> Option<Self>;

    /// All gains that are real numbers, by their names in the interface, in SI units.
    fn values(self) -> Vec<(String, f64)> {
        let mut list = List { gains: self, values: Vec::new() };
        Self::tables(&mut list);
        list.values
    }

    /// Gives the gain of that name a value; whether there is one.
    ///
    /// # Errors
    /// The value is not a number in its range; the gain is then unchanged.
    fn set(&mut self, name: &str, value: f64) -> Result<bool, InvalidParameter> {
        let mut setter = Setter { gains: self, name, value, result: Ok(false) };
        Self::tables(&mut setter);
        setter.result
    }

    /// Checks all gains that are real numbers against their ranges.
    ///
    /// # Errors
    /// The first that is not a number in its range.
    fn check(&self) -> Result<(), InvalidParameter> {
        let mut checker = Checker { gains: *self, verdict: Verdict(Ok(())) };
        Self::tables(&mut checker);
        checker.verdict.0
    }
}

/// Takes the tables of a law's gains `G`, each with the way to its owner.
pub trait Tables<G> {
    /// A table with one owner.
    fn one<T: Copy + 'static>(
        &mut self,
        changes: Changes,
        table: &'static [Parameter<T>],
        owner: impl Fn(&mut G) -> &mut T + Copy + Send + Sync + 'static,
    );

    /// A table of each arm. In its texts `{}` stands for the arm's number, from 1.
    fn per_arm<T: Copy + 'static>(
        &mut self,
        changes: Changes,
        table: &'static [Parameter<T>],
        owners: impl Fn(&mut G) -> &mut [T; 2] + Copy + Send + Sync + 'static,
    );

    /// Where the choice of what learns the disturbances is in the order, which is in no table.
    fn learner(&mut self) {}
}

/// When the gains of a table may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Changes {
    /// While the law runs.
    Always,
    /// Before it starts.
    AtStart,
}

struct List<G> {
    gains: G,
    values: Vec<(String, f64)>,
}

impl<G> Tables<G> for List<G> {
    fn one<T: Copy>(&mut self, _: Changes, table: &'static [Parameter<T>], owner: impl Fn(&mut G) -> &mut T) {
        let owner = owner(&mut self.gains);
        self.values.extend(table.iter().map(|row| (row.name.to_owned(), *(row.field)(owner))));
    }

    fn per_arm<T: Copy>(&mut self, _: Changes, table: &'static [Parameter<T>], owners: impl Fn(&mut G) -> &mut [T; 2]) {
        for (number, owner) in (1..).zip(owners(&mut self.gains)) {
            self.values.extend(table.iter().map(|row| (name_of_arm(row, number), *(row.field)(owner))));
        }
    }
}

struct Setter<'a, G> {
    gains: &'a mut G,
    name: &'a str,
    value: f64,
    result: Result<bool, InvalidParameter>,
}

impl<G> Setter<'_, G> {
    fn set<T>(name: &str, value: f64, row: &Parameter<T>, owner: &mut T) -> Result<bool, InvalidParameter> {
        Admissible::Within(row.range).check(name, value)?;
        *(row.field)(owner) = value;
        Ok(true)
    }
}

impl<G> Tables<G> for Setter<'_, G> {
    fn one<T: Copy>(&mut self, _: Changes, table: &'static [Parameter<T>], owner: impl Fn(&mut G) -> &mut T) {
        if let Some(row) = table.iter().find(|row| row.name == self.name) {
            self.result = Self::set(self.name, self.value, row, owner(self.gains));
        }
    }

    fn per_arm<T: Copy>(&mut self, _: Changes, table: &'static [Parameter<T>], owners: impl Fn(&mut G) -> &mut [T; 2]) {
        for (number, owner) in (1..).zip(owners(self.gains)) {
            if let Some(row) = table.iter().find(|row| name_of_arm(row, number) == self.name) {
                self.result = Self::set(self.name, self.value, row, owner);
            }
        }
    }
}

struct Checker<G> {
    gains: G,
    verdict: Verdict,
}

/// The first value that is not in its range. Compiled once for all tables, since it is part of every library.
struct Verdict(Result<(), InvalidParameter>);

impl Verdict {
    #[inline(never)]
    fn look(&mut self, name: &str, arm: &str, range: Range, value: f64) {
        if self.0.is_ok() && !range.contains(value) {
            let (name, admissible) = (replaced(name, "{}", arm), Admissible::Within(range));
            self.0 = Err(InvalidParameter { name, value, admissible });
        }
    }
}

impl<G> Tables<G> for Checker<G> {
    fn one<T: Copy>(&mut self, _: Changes, table: &'static [Parameter<T>], owner: impl Fn(&mut G) -> &mut T) {
        let owner = owner(&mut self.gains);
        for row in table {
            self.verdict.look(row.name, "{}", row.range, *(row.field)(owner));
        }
    }

    fn per_arm<T: Copy>(&mut self, _: Changes, table: &'static [Parameter<T>], owners: impl Fn(&mut G) -> &mut [T; 2]) {
        for (arm, owner) in ["1", "2"].into_iter().zip(owners(&mut self.gains)) {
            for row in table {
                self.verdict.look(row.name, arm, row.range, *(row.field)(owner));
            }
        }
    }
}

fn name_of_arm<T>(row: &Parameter<T>, number: usize) -> String {
    replaced(row.name, "{}", &number.to_string())
}

#![doc = include_str!("../README.md")]

mod range;
mod state;

pub use range::{Admissible, InvalidParameter, Range};
pub use state::StateVariable;

/// A real parameter of an owner `T`, as a row of a table.
///
/// In its texts `{}` stands for the [`Owner`].
#[derive(Debug)]
pub struct Parameter<T> {
    /// Its name.
    pub name: &'static str,
    /// Its SI unit in FMI's notation, for example `N.m2`; `1` for a pure number, empty for none.
    pub unit: &'static str,
    /// The values it may take.
    pub range: Range,
    /// Its description, in one line.
    pub description: &'static str,
    /// Where it is.
    pub field: fn(&mut T) -> &mut f64,
}

// Derived implementations would demand the same of `T`.
impl<T> Clone for Parameter<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Parameter<T> {}

impl<T> Parameter<T> {
    /// Its name for this owner.
    #[must_use]
    pub fn name_of(&self, owner: Owner<'_>) -> String {
        replaced(self.name, "{}", owner.name)
    }

    /// Its unit for this owner.
    #[must_use]
    pub fn unit_of(&self, owner: Owner<'_>) -> String {
        replaced(self.unit, "{}", owner.unit)
    }

    /// Its description for this owner.
    #[must_use]
    pub fn description_of(&self, owner: Owner<'_>) -> String {
        replaced(self.description, "{}", owner.called)
    }
}

/// The owner of a parameter, which replaces `{}` in the texts of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner<'a> {
    /// In names: `theta` makes `theta_offset` of `{}_offset`.
    pub name: &'a str,
    /// In units: the owner's own, of which `{}/s` is a rate.
    pub unit: &'a str,
    /// In descriptions.
    pub called: &'a str,
}

impl<'a> Owner<'a> {
    /// A single owner: `{}` is kept.
    pub const ALONE: Owner<'static> = Owner { name: "{}", unit: "{}", called: "{}" };

    /// An owner with the same designation in all texts: a number in a family, or a name.
    #[must_use]
    pub const fn named(name: &'a str) -> Self {
        Self { name, unit: name, called: name }
    }
}

/// The text with all occurrences of `what`, which must not be empty, replaced.
///
/// As `str::replace`, but for texts of some dozens of bytes: that comes with a search for long ones, 9 kB of code in each library.
#[must_use]
#[inline(never)]
pub fn replaced(text: &str, what: &str, by: &str) -> String {
    let mut result = String::with_capacity(text.len() + by.len());
    let mut rest = text;
    // What is found in UTF-8 begins and ends between characters.
    while let Some(at) = rest.as_bytes().windows(what.len()).position(|bytes| bytes == what.as_bytes()) {
        result.push_str(&rest[..at]);
        result.push_str(by);
        rest = &rest[at + what.len()..];
    }
    result.push_str(rest);
    result
}

/// A row of a table: name, unit, range, description, path of the field.
#[macro_export]
macro_rules! parameter {
    ($name:expr, $unit:expr, $range:expr, $description:expr, $($field:tt)+) => {
        $crate::Parameter {
            name: $name,
            unit: $unit,
            range: $range,
            description: $description,
            field: |owner| &mut owner.$($field)+,
        }
    };
}

/// Checks all parameters of a single owner, in the order of their table.
///
/// # Errors
/// The first parameter that is not a number in its range.
pub fn check<T: Clone>(table: &[Parameter<T>], owner: &T) -> Result<(), InvalidParameter> {
    check_of(Owner::ALONE, table, owner)
}

/// Checks all parameters of several owners, the first one's first. Their names get the owners' numbers, from 1.
///
/// # Errors
/// The first parameter that is not a number in its range.
pub fn check_family<T: Clone>(table: &[Parameter<T>], owners: &[T]) -> Result<(), InvalidParameter> {
    (1..).zip(owners).try_for_each(|(number, owner): (usize, _)| {
        let number = number.to_string();
        check_of(Owner::named(&number), table, owner)
    })
}

/// Checks all parameters of this owner, in the order of their table.
///
/// # Errors
/// The first parameter that is not a number in its range.
pub fn check_of<T: Clone>(who: Owner<'_>, table: &[Parameter<T>], owner: &T) -> Result<(), InvalidParameter> {
    // The table gives access to a field only for writing, and a copy may be written.
    let mut owner = owner.clone();
    table.iter().try_for_each(|row| {
        let value = *(row.field)(&mut owner);
        if row.range.contains(value) {
            return Ok(());
        }
        Err(InvalidParameter { name: row.name_of(who), value, admissible: Admissible::Within(row.range) })
    })
}

#[cfg(test)]
mod tests {
    use super::replaced;

    #[test]
    fn texts_are_replaced_as_the_standard_library_does() {
        for (text, what, by) in [
            ("theta{}_dot of {}", "{}", "1"),
            ("", "{}", "1"),
            ("{}{}", "{}", "{}"),
            ("{{}}", "{}", ""),
            ("ϑ{}·", "{}", "ä"),
            ("rad/srad", "rad", "deg"),
            ("aaa", "aa", "b"),
        ] {
            assert_eq!(replaced(text, what, by), text.replace(what, by));
        }
    }
}

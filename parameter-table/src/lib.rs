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
        self.name.replace("{}", owner.name)
    }

    /// Its unit for this owner.
    #[must_use]
    pub fn unit_of(&self, owner: Owner<'_>) -> String {
        self.unit.replace("{}", owner.unit)
    }

    /// Its description for this owner.
    #[must_use]
    pub fn description_of(&self, owner: Owner<'_>) -> String {
        self.description.replace("{}", owner.called)
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

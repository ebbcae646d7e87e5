//! Parameters as rows of a table: name, unit, range, meaning and place, each said once.
//!
//! A model keeps its parameters in plain structs and lists them in tables. The tables check values, and whoever shows the
//! model to the world declares its variables from them. So a range stands in one place only, and no parameter can be
//! declared and not checked.
//!
//! ```
//! use grasp_parameter::{Parameter, Range, check_family, parameter};
//!
//! #[derive(Clone)]
//! struct Arm {
//!     rigidity: f64,
//! }
//!
//! const ARM: [Parameter<Arm>; 1] =
//!     [parameter!("EI{}", "N.m2", Range::new(1e-9, 1e9), "Flexural rigidity of arm {}", rigidity)];
//!
//! let arms = [Arm { rigidity: 0.115 }, Arm { rigidity: -1.0 }];
//! let error = check_family(&ARM, &arms).unwrap_err();
//! assert_eq!(error.name, "EI2");
//! assert_eq!(error.to_string(), "parameter EI2 = -1 is not admissible: it must be between 1e-9 and 1000000000.0");
//! ```

mod range;

pub use range::{Admissible, InvalidParameter, Range};

/// A real parameter of an owner `T`.
#[derive(Debug)]
pub struct Parameter<T> {
    /// Its name. In a family of owners, `{}` stands for the owner's number, counted from 1.
    pub name: &'static str,
    /// Its SI unit as FMI writes it, for example `N.m2`; `1` for a pure number.
    pub unit: &'static str,
    /// The values it may take.
    pub range: Range,
    /// What it is, in one line. In a family, `{}` stands for the owner's number.
    pub description: &'static str,
    /// Where it is.
    pub field: fn(&mut T) -> &mut f64,
}

// Derived, they would ask the same of `T`.
impl<T> Clone for Parameter<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Parameter<T> {}

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

/// Checks all parameters of an owner, in the order of their table.
///
/// # Errors
/// The first parameter that is not a number in its range.
pub fn check<T: Clone>(table: &[Parameter<T>], owner: &T) -> Result<(), InvalidParameter> {
    check_named(table, owner, str::to_owned)
}

/// Checks all parameters of several owners, the first one's first. Their names get the owners' numbers.
///
/// # Errors
/// The first parameter that is not a number in its range.
pub fn check_family<T: Clone>(table: &[Parameter<T>], owners: &[T]) -> Result<(), InvalidParameter> {
    (1..).zip(owners).try_for_each(|(number, owner): (usize, _)| {
        check_named(table, owner, |name| name.replace("{}", &number.to_string()))
    })
}

fn check_named<T: Clone>(
    table: &[Parameter<T>],
    owner: &T,
    name: impl Fn(&str) -> String,
) -> Result<(), InvalidParameter> {
    // The table knows the way to a field that is to be written; a copy may be.
    let mut owner = owner.clone();
    table.iter().try_for_each(|row| {
        let value = *(row.field)(&mut owner);
        if row.range.contains(value) {
            return Ok(());
        }
        Err(InvalidParameter { name: name(row.name), value, admissible: Admissible::Within(row.range) })
    })
}

#[cfg(feature = "fmi2-export")]
impl<T> From<Parameter<T>> for fmi2_export::Parameter<T> {
    fn from(Parameter { name, unit, range: Range { min, max }, description, field }: Parameter<T>) -> Self {
        Self { name, unit, min, max, description, field }
    }
}

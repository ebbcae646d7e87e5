//! Tables of parameters.

/// A real parameter of a part `T` of a model, as a row of a table.
///
/// A crate of equations that knows nothing of FMI can keep such a table in a type of its own, for its own checks; the
/// model that exports it maps the rows:
///
/// ```
/// # use fmi2_export::{Parameter, Variables};
/// # #[derive(Default)] struct Model { arms: [Arm; 2] }
/// #[derive(Default)]
/// struct Arm { rigidity: f64, mass: f64 }
///
/// const ARM: [Parameter<Arm>; 2] = [
///     Parameter {
///         name: "EI{}",
///         unit: "N.m2",
///         min: 1e-9,
///         max: 1e9,
///         description: "Flexural rigidity of arm {}",
///         field: |arm| &mut arm.rigidity,
///     },
///     Parameter {
///         name: "m{}",
///         unit: "kg",
///         min: 1e-9,
///         max: 1e9,
///         description: "Mass of arm {}",
///         field: |arm| &mut arm.mass,
///     },
/// ];
///
/// # fn variables(variables: &mut Variables<Model>) {
/// // EI1, m1, EI2, m2.
/// variables.parameter_family(ARM, |m| &mut m.arms);
/// # }
/// ```
#[derive(Debug)]
pub struct Parameter<T> {
    /// Its name. In a family, `{}` stands for the element's number.
    pub name: &'static str,
    /// Its unit as [`VariableBuilder::unit`](crate::VariableBuilder::unit) reads it: `1` for a pure number, empty for none.
    pub unit: &'static str,
    /// The least admissible value; −∞ for none.
    pub min: f64,
    /// The greatest admissible value; ∞ for none.
    pub max: f64,
    /// What it is, in one line. In a family, `{}` stands for the element's number.
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

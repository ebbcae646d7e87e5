//! A row of a table of continuous states.

/// A continuous state of a system of differential equations: its description for solvers and readers.
#[derive(Clone, Debug, PartialEq)]
pub struct StateVariable {
    /// Its name.
    pub name: String,
    /// Its SI unit in FMI's notation; `1` for a pure number, empty where no unit with integer exponents fits.
    pub unit: &'static str,
    /// A typical magnitude, from which a solver takes absolute tolerances.
    pub nominal: f64,
    /// Its description, in one line.
    pub description: String,
}

impl StateVariable {
    /// A row.
    #[must_use]
    pub fn new(name: impl Into<String>, unit: &'static str, nominal: f64, description: impl Into<String>) -> Self {
        Self { name: name.into(), unit, nominal, description: description.into() }
    }
}

//! Units: which ones can be converted to each other, and how.

use std::collections::HashMap;

use fmi2_import::description::Unit;
use fmi2_import::{ModelDescription, Variable, VariableType};

/// Turns values in one unit into values in another: `(factor · value + offset) / divisor`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    factor: f64,
    offset: f64,
    divisor: f64,
}

/// Why values cannot be converted from one unit to another.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UnitMismatch {
    /// They measure different quantities.
    #[error("{from} cannot be converted to {to}: their base units differ")]
    Dimension {
        /// The unit of the values.
        from: String,
        /// The wanted unit.
        to: String,
    },
    /// A factor or an offset that allows no conversion.
    #[error("the definition of the unit {0} has a factor of zero, or a factor or an offset that is not finite")]
    Definition(String),
}

impl Conversion {
    /// From values in `from` to values in `to`; `None` if they are equal. A difference of values has no offset.
    ///
    /// # Errors
    /// When the units measure different quantities, or cannot be used.
    pub fn between(from: &Unit, to: &Unit, are_differences: (bool, bool)) -> Result<Option<Self>, UnitMismatch> {
        if from.exponents != to.exponents {
            return Err(UnitMismatch::Dimension { from: from.name.clone(), to: to.name.clone() });
        }
        for unit in [from, to] {
            if !(unit.factor.is_finite() && unit.factor != 0.0 && unit.offset.is_finite()) {
                return Err(UnitMismatch::Definition(unit.name.clone()));
            }
        }
        let offset = |unit: &Unit, is_difference: bool| if is_difference { 0.0 } else { unit.offset };
        let offset = offset(from, are_differences.0) - offset(to, are_differences.1);
        let is_same = from.factor == to.factor && offset == 0.0;
        Ok((!is_same).then_some(Self { factor: from.factor, offset, divisor: to.factor }))
    }

    /// A value in the new unit.
    #[must_use]
    pub fn apply(&self, value: f64) -> f64 {
        (self.factor * value + self.offset) / self.divisor
    }
}

/// The units of a description that are defined in base units, by name.
#[derive(Debug, Clone, Default)]
pub struct Units<'a>(HashMap<&'a str, &'a Unit>);

impl<'a> Units<'a> {
    /// Those of a description.
    #[must_use]
    pub fn of(description: &'a ModelDescription) -> Self {
        Self::among(&description.units)
    }

    /// Those of a list.
    #[must_use]
    pub fn among(units: &'a [Unit]) -> Self {
        Self(units.iter().filter(|unit| unit.has_base_unit).map(|unit| (unit.name.as_str(), unit)).collect())
    }

    /// The unit of that name.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<&'a Unit> {
        self.0.get(name).copied()
    }

    /// All names.
    pub fn names(&self) -> impl Iterator<Item = &'a str> {
        self.0.keys().copied()
    }

    /// A number in a unit as the value of a variable: in the variable's own unit, its display units, or any unit of the
    /// same description for the same quantity. `None` if the unit is not known.
    ///
    /// # Errors
    /// When the unit measures another quantity.
    #[must_use]
    pub fn value_for(&self, variable: &Variable, number: f64, unit: &str) -> Option<Result<f64, UnitMismatch>> {
        let VariableType::Real(real) = &variable.kind else { return None };
        let own = real.unit.as_deref()?;
        if own == unit {
            return Some(Ok(number));
        }
        let own = self.named(own)?;
        if let Some(display) = own.display_units.iter().find(|display| display.name == unit) {
            let offset = if real.relative_quantity { 0.0 } else { display.offset };
            let value = (number - offset) / display.factor;
            let is_usable = display.factor != 0.0 && value.is_finite();
            return Some(if is_usable { Ok(value) } else { Err(UnitMismatch::Definition(unit.to_owned())) });
        }
        let conversion = Conversion::between(self.named(unit)?, own, (real.relative_quantity, real.relative_quantity));
        Some(conversion.map(|conversion| conversion.map_or(number, |conversion| conversion.apply(number))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(name: &str, exponent: i32, factor: f64, offset: f64) -> Unit {
        let exponents = [0, 0, 0, 0, exponent, 0, 0, 0];
        Unit { name: name.into(), exponents, factor, offset, has_base_unit: true, ..Unit::default() }
    }

    #[test]
    fn values_are_converted_by_their_base_units() {
        let (kelvin, celsius) = (unit("K", 1, 1.0, 0.0), unit("degC", 1, 1.0, 273.15));
        let fahrenheit = unit("degF", 1, 5.0 / 9.0, 459.67 * 5.0 / 9.0);
        let convert = |from, to, value| Conversion::between(from, to, (false, false)).unwrap().unwrap().apply(value);
        // ITS-90: water boils at 99.974 °C, which 0 °C = 32 °F and a ratio of 9/5 make 211.9532 °F.
        assert!((convert(&celsius, &fahrenheit, 99.974) - 211.9532).abs() < 1e-10);
        assert!((convert(&celsius, &kelvin, 99.974) - 373.124).abs() < 1e-12);
        assert_eq!(Conversion::between(&celsius, &celsius, (false, false)), Ok(None));
        assert_eq!(Conversion::between(&celsius, &kelvin, (true, true)), Ok(None), "a difference of 1 °C is 1 K");
    }

    #[test]
    fn what_cannot_be_converted_is_refused() {
        let (kelvin, square) = (unit("K", 1, 1.0, 0.0), unit("K2", 2, 1.0, 0.0));
        let message = |from: &Unit, to: &Unit| Conversion::between(from, to, (false, false)).unwrap_err().to_string();
        assert_eq!(message(&kelvin, &square), "K cannot be converted to K2: their base units differ");
        for (factor, offset) in [(0.0, 0.0), (f64::NAN, 0.0), (f64::INFINITY, 0.0), (1.0, f64::NAN)] {
            assert!(message(&kelvin, &unit("bad", 1, factor, offset)).contains("the unit bad"));
        }
    }
}

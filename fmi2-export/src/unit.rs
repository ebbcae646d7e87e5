//! Physical units, as `<UnitDefinitions>` describes them (FMI 2.0.4, section 2.2.2).

use std::str::FromStr;

use parameter_table::replaced;

/// A unit with its exponents of the SI base units and rad, and a factor and an offset to them: a value `v` in this unit
/// is `factor * v + offset` in the base units.
///
/// Coherent SI units are best given by their expression in Modelica's notation, from which the exponents follow:
///
/// ```
/// use fmi2_export::Unit;
/// let damping: Unit = "N.m.s/rad".parse()?;
/// assert_eq!(damping, Unit::new("N.m.s/rad").kg(1).m(2).s(-1).rad(-1));
/// assert!("N.furlong".parse::<Unit>().is_err());
/// # Ok::<(), fmi2_export::UnitError>(())
/// ```
///
/// Anything else is spelled out:
///
/// ```
/// # use fmi2_export::Unit;
/// let celsius = Unit::new("degC").kelvin(1).offset(273.15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    pub(crate) name: String,
    pub(crate) exponents: Exponents,
    pub(crate) factor: f64,
    pub(crate) offset: f64,
}

/// Exponents in the order of [`BASE_UNITS`].
type Exponents = [i32; 8];

/// Attribute names of `<BaseUnit>`.
pub const BASE_UNITS: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// Coherent derived units that may occur in an expression.
const DERIVED: [(&str, Exponents); 12] = [
    ("N", [1, 1, -2, 0, 0, 0, 0, 0]),
    ("J", [1, 2, -2, 0, 0, 0, 0, 0]),
    ("W", [1, 2, -3, 0, 0, 0, 0, 0]),
    ("Pa", [1, -1, -2, 0, 0, 0, 0, 0]),
    ("Hz", [0, 0, -1, 0, 0, 0, 0, 0]),
    ("C", [0, 0, 1, 1, 0, 0, 0, 0]),
    ("V", [1, 2, -3, -1, 0, 0, 0, 0]),
    ("F", [-1, -2, 4, 2, 0, 0, 0, 0]),
    ("Ohm", [1, 2, -3, -2, 0, 0, 0, 0]),
    ("S", [-1, -2, 3, 2, 0, 0, 0, 0]),
    ("H", [1, 2, -2, -2, 0, 0, 0, 0]),
    ("T", [1, 0, -2, -1, 0, 0, 0, 0]),
];

/// How tools may show a value: `factor * v` for a value v in the variable's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Name.
    pub name: String,
    /// How many of it one of the variable's unit is.
    pub factor: f64,
}

impl DisplayUnit {
    /// Degrees for an angle in rad, deg/s for its rate, and so on; `None` for what is no angle.
    pub(crate) fn degrees(unit: &Unit) -> Option<Self> {
        let [kg, m, _, ampere, kelvin, mol, cd, rad] = unit.exponents;
        let is_coherent = unit.factor.to_bits() == 1.0_f64.to_bits() && unit.offset == 0.0;
        let is_angle = rad == 1 && [kg, m, ampere, kelvin, mol, cd] == [0; 6];
        let is_once = replaced(&unit.name, "rad", "").len() + "rad".len() == unit.name.len();
        (is_coherent && is_angle && is_once)
            .then(|| Self { name: replaced(&unit.name, "rad", "deg"), factor: 180.0 / std::f64::consts::PI })
    }
}

macro_rules! exponent {
    ($($method:ident $index:literal $what:literal),*) => { $(
        #[doc = concat!("Sets the exponent of the ", $what, ".")]
        #[must_use]
        pub const fn $method(mut self, exponent: i32) -> Self {
            self.exponents[$index] = exponent;
            self
        }
    )* };
}

impl Unit {
    /// A unit of this name that is, until exponents are given, dimensionless.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), exponents: [0; 8], factor: 1.0, offset: 0.0 }
    }

    exponent!(kg 0 "kilogram", m 1 "metre", s 2 "second", ampere 3 "ampere", kelvin 4 "kelvin", mol 5 "mole",
        cd 6 "candela", rad 7 "radian");

    /// Sets the factor to the base units, e.g. 1000 for km.
    #[must_use]
    pub const fn factor(mut self, factor: f64) -> Self {
        self.factor = factor;
        self
    }

    /// Sets the offset to the base units, e.g. 273.15 for °C.
    #[must_use]
    pub const fn offset(mut self, offset: f64) -> Self {
        self.offset = offset;
        self
    }

    /// Whether it is another unit per second, whatever the two are called.
    pub(crate) fn is_per_second_of(&self, other: &Self) -> bool {
        const SECOND: usize = 2;
        let mut exponents = other.exponents;
        exponents[SECOND] -= 1;
        self.exponents == exponents && self.factor.to_bits() == other.factor.to_bits()
    }

    /// The unit's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// An expression that is not a product of SI units.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unit {expression:?}: {part:?} is not understood; write e.g. \"kg.m2/s\", or spell the unit out with Unit::new"
)]
pub struct UnitError {
    /// The whole expression.
    pub expression: String,
    /// The part that was not understood.
    pub part: String,
}

impl FromStr for Unit {
    type Err = UnitError;

    /// Reads a unit expression of the Modelica Language Specification (chapter 19): `N.m`, `m/s2`, `1/(m2.s)`.
    fn from_str(expression: &str) -> Result<Self, UnitError> {
        let error = |part: &str| UnitError { expression: expression.to_owned(), part: part.to_owned() };
        let (numerator, denominator) = match expression.split_once('/') {
            Some((numerator, denominator)) => (numerator, Some(denominator)),
            None => (expression, None),
        };
        let mut unit = Self::new(expression);
        for (product, sign) in [(Some(numerator), 1), (denominator, -1)] {
            let Some(product) = product else { continue };
            let several = product.contains('.');
            let inner = match product.strip_prefix('(').map(|rest| rest.strip_suffix(')')) {
                Some(Some(inner)) => inner,
                Some(None) => return Err(error(product)),
                // a/b.c would be read differently by different people: the notation asks for a/(b.c).
                None if several && sign < 0 => return Err(error(product)),
                None => product,
            };
            if inner == "1" && sign > 0 {
                continue;
            }
            for part in inner.split('.') {
                let (symbol, power) = symbol_and_power(part).ok_or_else(|| error(part))?;
                let its = exponents_of(symbol).ok_or_else(|| error(part))?;
                for (total, exponent) in unit.exponents.iter_mut().zip(its) {
                    *total += sign * power * exponent;
                }
            }
        }
        Ok(unit)
    }
}

/// `m2` is m to the power of 2, `s-1` is s to the power of −1.
fn symbol_and_power(part: &str) -> Option<(&str, i32)> {
    let end = part.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(part.len());
    let (symbol, power) = part.split_at(end);
    let power = if power.is_empty() { 1 } else { power.parse().ok().filter(|p: &i32| p.abs() < 100)? };
    Some((symbol, power))
}

fn exponents_of(symbol: &str) -> Option<Exponents> {
    if let Some(i) = BASE_UNITS.iter().position(|base| *base == symbol) {
        let mut exponents = [0; 8];
        exponents[i] = 1;
        return Some(exponents);
    }
    DERIVED.iter().find(|(name, _)| *name == symbol).map(|(_, exponents)| *exponents)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exponents(expression: &str) -> Exponents {
        expression.parse::<Unit>().unwrap().exponents
    }

    #[test]
    fn expressions_give_the_exponents_of_their_definitions() {
        assert_eq!(exponents("1"), [0; 8]);
        assert_eq!(exponents("N.m"), exponents("J"));
        assert_eq!(exponents("J/s"), exponents("W"));
        assert_eq!(exponents("kg.m.s-2"), exponents("N"));
        assert_eq!(exponents("1/(m2.s)"), [0, -2, -1, 0, 0, 0, 0, 0]);
        assert_eq!(exponents("V/A"), exponents("Ohm"));
        assert_eq!(exponents("T.m2"), exponents("V.s"));
    }

    #[test]
    fn angles_and_their_rates_are_shown_in_degrees() {
        let shown = |expression: &str| DisplayUnit::degrees(&expression.parse().unwrap()).map(|shown| shown.name);
        for (unit, degrees) in [("rad", "deg"), ("rad/s", "deg/s"), ("rad/s2", "deg/s2"), ("rad.s-1", "deg.s-1")] {
            assert_eq!(shown(unit).as_deref(), Some(degrees));
        }
        for unit in ["1", "1/s", "N.m/rad", "rad2", "rad.m", "N.m.s/rad"] {
            assert_eq!(shown(unit), None, "{unit}");
        }
        assert_eq!(DisplayUnit::degrees(&Unit::new("rad").rad(1).factor(2.0)), None);
    }

    #[test]
    fn other_expressions_are_refused() {
        for wrong in ["", "N m", "N.", "m/s/s", "m/s.kg", "(m", "m/(s", "furlong", "m2.5", "m999999999999", "/s", "1/1"]
        {
            assert!(wrong.parse::<Unit>().is_err(), "{wrong}");
        }
    }
}

//! The exact values of the checks: data of the tool (`dualarm/data/verify`), compiled in, so that `dualarm verify` needs no
//! source tree. `tests/oracle` computes them.

use std::sync::LazyLock;

use serde_json::Value;

use super::rig::{Settings, settings};
use fmi2_cosim::settings::Setting;

/// Eigenvalues and step responses of the exact model: `python -m tests.oracle`.
pub static EXACT: LazyLock<Value> = LazyLock::new(|| parse(include_str!("../../data/verify/values.json")));
/// Closed loops solved as one ODE: `python -m tests.oracle.monolith`.
pub static MONOLITH: LazyLock<Value> = LazyLock::new(|| parse(include_str!("../../data/verify/closed_loop.json")));

fn parse(text: &str) -> Value {
    serde_json::from_str(text).expect("the compiled-in values are valid JSON: a test reads them")
}

/// A number in a document.
///
/// # Panics
/// When the value is not a number.
#[must_use]
pub fn number(value: &Value) -> f64 {
    value.as_f64().expect("the compiled-in values have numbers here")
}

/// The entries of an object.
pub fn entries(value: &Value) -> impl Iterator<Item = (&str, &Value)> {
    value.as_object().into_iter().flatten().map(|(name, value)| (name.as_str(), value))
}

/// The elements of an array.
pub fn elements(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

/// A complex number \[1/s\].
pub type Pole = nalgebra::Complex<f64>;

/// The listed eigenvalues of a loop, those with Im ≥ 0.
#[must_use]
pub fn poles(loop_name: &str) -> Vec<Pole> {
    elements(&EXACT["eigenvalues"][loop_name]["values"])
        .map(|pair| Pole::new(number(&pair[0]), number(&pair[1])))
        .collect()
}

/// One of the oracle's plants as start values of the FMU; ideal actuators.
#[must_use]
pub fn plant(name: &str, uncertainties: bool, order: u32) -> Settings {
    let plant = &EXACT["plants"][name];
    let mut values = settings([("M", number(&plant["M"])), ("kelvin_voigt", number(&plant["kelvin_voigt"]))]);
    for (key, arms) in [("EI", ["EI1", "EI2"]), ("rho", ["rho1", "rho2"]), ("J", ["J1", "J2"]), ("m_tip", ["m1", "m2"])]
    {
        values.extend(settings((0..2).map(|arm| (arms[arm], number(&plant[key][arm])))));
    }
    for name in ["root_uncertainty", "tip_uncertainty"] {
        values.extend(settings([(name, if uncertainties { number(&plant[name]) } else { 0.0 })]));
    }
    values.push(Setting::new("order", f64::from(order)));
    values.push(Setting::new("actuator_model", "ideal"));
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_compiled_in_values_are_there() {
        assert!(poles("paper_free").len() > 10);
        assert_eq!(entries(&MONOLITH["cases"]).count(), 6);
        assert!(plant("unequal", true, 8).iter().any(|setting| *setting == Setting::new("EI2", 0.2)));
    }
}

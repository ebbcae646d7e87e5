//! A dimension of a search: a parameter, or several with the same value, in a range.

use std::fmt;

use super::start::Start;
use fmi2_cosim::names::{closest, suggestion};
use fmi2_import::{ModelDescription, Variability, Variable, VariableType};

/// One or more parameters with one value.
#[derive(Debug, Clone, PartialEq)]
pub struct Dimension {
    /// The parameters.
    pub names: Vec<String>,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Whether ratios count, not differences.
    pub logarithmic: bool,
    /// Where the search begins.
    pub start: f64,
    /// Smallest and largest allowed value, if the user gave no range: the range is then a decade on both sides of the
    /// start.
    pub bounds: Option<[f64; 2]>,
}

/// Why something is no dimension.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DimensionError {
    /// It is not written like one.
    #[error(
        "--parameter {text}: {problem}; write NAME=LOW..HIGH, NAME1+NAME2=LOW..HIGH for one value of both, and :linear behind a range that is not to be searched by ratios"
    )]
    Form {
        /// As written.
        text: String,
        /// The fault.
        problem: String,
    },
    /// The controller has no such parameter.
    #[error("--parameter {name}: {model} has no real parameter of this name{}", suggestion(.similar))]
    Unknown {
        /// As written.
        name: String,
        /// The controller.
        model: String,
        /// Names that come close.
        similar: Vec<String>,
    },
    /// Nothing is left to vary.
    #[error("{0} has no gains that could be tuned by themselves; name some with --parameter NAME=LOW..HIGH")]
    Nothing(String),
}

/// By how much a gain may change from its start, either way, when no range is given.
const DECADE: f64 = 10.0;

/// Tunable parameters that are not gains: the controller's model of the plant, and its connections.
const NO_GAINS: [&str; 14] = [
    "EI1",
    "EI2",
    "l",
    "L",
    "tau_limit",
    "u_limit",
    "sat_limit",
    "W_max",
    "U1_max",
    "U2_max",
    "r_mass_min",
    "r_mass_max",
    "r_inertia_min",
    "r_inertia_max",
];

impl Dimension {
    /// `NAME=LOW..HIGH`, several names with `+`, optionally `:linear` at the end. Without a range it is from a tenth of
    /// the value that the controller has to ten times that.
    ///
    /// # Errors
    /// When the text has another form, or the controller has no such parameter.
    pub fn parse(text: &str, begin: &Start) -> Result<Self, DimensionError> {
        let form = |problem: &str| DimensionError::Form { text: text.to_owned(), problem: problem.to_owned() };
        let (names, range) = text.split_once('=').map_or((text, None), |(names, range)| (names, Some(range)));
        let names: Vec<String> = names.split('+').map(|name| name.trim().to_owned()).collect();
        for name in &names {
            exists(name, begin.description)?;
        }
        let value = begin.value(&names);
        let Some(range) = range else {
            let anything = [0.0, f64::INFINITY];
            return Self::around(names, value, anything)
                .ok_or_else(|| form(&format!("it begins at {value}, which has no ratios, so it needs a range")));
        };
        let (range, logarithmic) = range.strip_suffix(":linear").map_or((range, true), |range| (range, false));
        let (low, high) = range.split_once("..").ok_or_else(|| form("there is no \"..\" in its range"))?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let (Some(low), Some(high)) = (number(low), number(high)) else { return Err(form("an end is no number")) };
        if low >= high {
            return Err(form("the range is empty"));
        }
        if logarithmic && low <= 0.0 {
            return Err(form("ratios need positive ends"));
        }
        let middle = short(if logarithmic { (low * high).sqrt() } else { 0.5 * (low + high) });
        let start = if (low..=high).contains(&value) { value } else { middle };
        Ok(Self { names, low, high, logarithmic, start, bounds: None })
    }

    /// Begins the search at a value, if it is in the user's range; a default range moves to the value.
    pub fn begin(&mut self, value: Option<f64>) {
        if let (Some([min, max]), Some(value)) = (self.bounds, value.filter(|value| *value > 0.0)) {
            (self.low, self.high) = (min.max(short(value / DECADE)), max.min(short(value * DECADE)));
        }
        self.start = value.filter(|value| (self.low..=self.high).contains(value)).unwrap_or(self.start);
    }

    fn around(names: Vec<String>, start: f64, bounds: [f64; 2]) -> Option<Self> {
        let mut dimension = Self { names, low: 0.0, high: 0.0, logarithmic: true, start, bounds: Some(bounds) };
        dimension.begin(Some(start));
        (start > 0.0).then_some(dimension)
    }

    /// The gains of a controller: its tunable real parameters that begin at positive values; those of both arms together.
    /// `wanted` selects those in use.
    ///
    /// # Errors
    /// When there are none.
    pub fn gains(begin: &Start, wanted: impl Fn(&str) -> bool) -> Result<Vec<Self>, DimensionError> {
        let description = begin.description;
        let is_gain = |variable: &&Variable| {
            variable.variability == Variability::Tunable
                && !NO_GAINS.contains(&variable.name.as_str())
                && !variable.name.starts_with("observer_")
                && wanted(&variable.name)
        };
        let mut dimensions: Vec<Self> = Vec::new();
        for variable in description.variables.iter().filter(is_gain) {
            let VariableType::Real(attributes) = &variable.kind else { continue };
            let start = begin.value(std::slice::from_ref(&variable.name));
            if start <= 0.0 {
                continue;
            }
            let twin = variable.name.strip_suffix('2').map(|stem| format!("{stem}1"));
            let group = dimensions.iter_mut().find(|dimension| twin.as_ref() == dimension.names.first());
            if let Some(group) = group.filter(|group| begin.are_alike(&group.names[0], &variable.name)) {
                group.names.push(variable.name.clone());
                group.begin(Some(begin.value(&group.names)));
                continue;
            }
            let bounds = [attributes.min.unwrap_or(0.0), attributes.max.unwrap_or(f64::INFINITY)];
            dimensions.extend(Self::around(vec![variable.name.clone()], start, bounds));
        }
        if dimensions.is_empty() {
            Err(DimensionError::Nothing(description.model_name.clone()))
        } else {
            Ok(dimensions)
        }
    }

    /// The value at a coordinate between 0 and 1, with four digits: more are not needed for gains, and presets stay
    /// readable.
    #[must_use]
    pub fn value(&self, coordinate: f64) -> f64 {
        let at = coordinate.clamp(0.0, 1.0);
        let exact = if self.logarithmic {
            self.low * (at * (self.high / self.low).ln()).exp()
        } else {
            self.low + at * (self.high - self.low)
        };
        format!("{exact:.3e}").parse().unwrap_or(exact).clamp(self.low, self.high)
    }

    /// The coordinate of the start.
    #[must_use]
    pub fn start_coordinate(&self) -> f64 {
        let Self { low, high, start, .. } = *self;
        let at = if self.logarithmic { (start / low).ln() / (high / low).ln() } else { (start - low) / (high - low) };
        at.clamp(0.0, 1.0)
    }
}

/// The value with twelve digits, without the further digits of binary arithmetic: users read and type the ends of ranges.
fn short(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

fn exists(name: &str, description: &ModelDescription) -> Result<(), DimensionError> {
    let reals = || description.variables.iter().filter(|variable| matches!(variable.kind, VariableType::Real(_)));
    let settable = || reals().filter(|variable| variable.is_settable());
    if settable().any(|variable| variable.name == name) {
        return Ok(());
    }
    Err(DimensionError::Unknown {
        name: name.to_owned(),
        model: description.model_name.clone(),
        similar: closest(name, settable().map(|variable| variable.name.as_str()))
            .into_iter()
            .map(str::to_owned)
            .collect(),
    })
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}..{}", self.names.join("+"), self.low, self.high)?;
        if self.logarithmic { Ok(()) } else { f.write_str(":linear") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dimension(logarithmic: bool) -> Dimension {
        Dimension { names: vec!["k".into()], low: 1.0, high: 100.0, logarithmic, start: 10.0, bounds: None }
    }

    #[test]
    fn a_search_begins_where_it_is_told_within_the_range() {
        let mut dimension = dimension(true);
        dimension.begin(Some(50.0));
        dimension.begin(Some(500.0));
        dimension.begin(None);
        assert_eq!(dimension.start, 50.0);
    }

    #[test]
    fn a_range_that_nobody_gave_is_around_where_the_search_begins() {
        let mut dimension = Dimension::around(vec!["k".into()], 10.0, [2.0, 3000.0]).unwrap();
        assert_eq!([dimension.low, dimension.high, dimension.start], [2.0, 100.0, 10.0]);
        dimension.begin(Some(500.0));
        assert_eq!([dimension.low, dimension.high, dimension.start], [50.0, 3000.0, 500.0]);
        // A tenth of it is 0.8507999999999999 in binary.
        dimension.begin(Some(8.508));
        assert_eq!([dimension.low, dimension.high], [2.0, 85.08]);
        let around = Dimension::around(vec!["k".into()], 8.508, [0.0, 90.0]).unwrap();
        assert_eq!(around.to_string(), "k=0.8508..85.08");
        dimension.begin(Some(500.0));
        // A value that allows no ratios, or is out of bounds, changes nothing.
        for value in [0.0, -1.0] {
            dimension.begin(Some(value));
            assert_eq!([dimension.low, dimension.high, dimension.start], [50.0, 3000.0, 500.0]);
        }
    }

    #[test]
    fn coordinates_span_the_range_by_ratio_or_by_difference() {
        assert_eq!([0.0, 0.5, 1.0].map(|at| dimension(true).value(at)), [1.0, 10.0, 100.0]);
        assert_eq!([0.0, 0.5, 1.0, 7.0].map(|at| dimension(false).value(at)), [1.0, 50.5, 100.0, 100.0]);
        assert!((dimension(true).start_coordinate() - 0.5).abs() < 1e-12);
        assert!((dimension(false).start_coordinate() - 1.0 / 11.0).abs() < 1e-12);
        assert_eq!(dimension(true).value(1.0 / 3.0), 4.642);
        assert_eq!(
            (dimension(true).to_string(), dimension(false).to_string()),
            ("k=1..100".into(), "k=1..100:linear".into())
        );
    }
}

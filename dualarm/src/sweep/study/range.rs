//! The range or distribution of a parameter.

use std::fmt;

use fmi2_cosim::system::SourceLine;
use fmi2_import::Value;
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};

use super::Method;
use super::file::value_of;

/// Names of columns that every result has.
const RESERVED: [&str; 6] = ["run", "draw", "controller", "status", "error", "success"];

/// A parameter, or several that one number drives.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// The column's name.
    pub name: String,
    /// Variables as settings name them, and the factor that each has on the number: 1 or −1.
    pub targets: Vec<(String, f64)>,
    /// Its range.
    pub range: Range,
    /// How many values a grid takes of it.
    pub count: u64,
    /// Its place, for messages.
    pub place: SourceLine,
}

/// The range or distribution of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Range {
    /// All numbers between two, alike.
    Linear {
        /// Smallest.
        low: f64,
        /// Largest.
        high: f64,
    },
    /// The same, but with the logarithm alike.
    Logarithmic {
        /// Smallest, positive.
        low: f64,
        /// Largest.
        high: f64,
    },
    /// A normal distribution, cut off at the ends.
    Normal {
        /// Its mean before it is cut.
        mean: f64,
        /// Its standard deviation before it is cut.
        sd: f64,
        /// Smallest; −∞ for none.
        low: f64,
        /// Largest; ∞ for none.
        high: f64,
    },
    /// One of these.
    Values(Vec<Value>),
    /// A whole number that no other draw has, but by chance: for seeds of noise.
    Seed,
    /// Whatever the table of points has.
    Column,
}

/// A list of values, or a table.
pub(super) struct RangeEntry(RangeTable);

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct RangeTable {
    low: Option<f64>,
    high: Option<f64>,
    scale: Option<Scale>,
    count: Option<u64>,
    mean: Option<f64>,
    sd: Option<f64>,
    values: Option<Vec<toml::Value>>,
    #[serde(default)]
    seed: bool,
    names: Option<Vec<String>>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Scale {
    Linear,
    Log,
}

impl<'de> Deserialize<'de> for RangeEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = RangeEntry;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of values, or a table such as { low = 1, high = 2 }")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<RangeEntry, A::Error> {
                let values = Deserialize::deserialize(SeqAccessDeserializer::new(seq))?;
                Ok(RangeEntry(RangeTable { values: Some(values), ..RangeTable::default() }))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RangeEntry, A::Error> {
                Deserialize::deserialize(MapAccessDeserializer::new(map)).map(RangeEntry)
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// The parameter of an entry; `method` determines the keys that it must have.
pub(super) fn varied(
    name: String,
    RangeEntry(table): RangeEntry,
    method: Method,
    place: SourceLine,
) -> Result<Varied, String> {
    if RESERVED.contains(&name.as_str()) {
        return Err(format!(
            "{name} is the name of a column of its own; give it another name and write names = [\"{name}\"]"
        ));
    }
    let targets = match table.names.clone() {
        None => vec![(name.clone(), 1.0)],
        Some(names) if names.is_empty() => return Err("names is empty".into()),
        Some(names) => names.into_iter().map(signed).collect(),
    };
    let count = table.count;
    if count == Some(0) {
        return Err("count must be at least 1".into());
    }
    let range = table.range()?;
    let count = match &range {
        Range::Values(values) => values.len() as u64,
        Range::Seed => count.unwrap_or(1),
        _ if method == Method::Grid => {
            count.ok_or_else(|| format!("{name} needs count: how many values shall the grid have of it?"))?
        }
        _ => 1,
    };
    let is_number = |value: &Value| matches!(value, Value::Real(_) | Value::Integer(_));
    if let Range::Values(values) = &range
        && targets.iter().any(|(_, sign)| *sign < 0.0)
        && !values.iter().all(is_number)
    {
        return Err("a minus before a name needs numbers".into());
    }
    if method != Method::Table && range == Range::Column {
        return Err("a range needs low and high, mean and sd, values, or seed = true".into());
    }
    Ok(Varied { name, targets, range, count, place })
}

/// A name with a minus before it gets the opposite number.
fn signed(name: String) -> (String, f64) {
    match name.strip_prefix('-') {
        Some(name) => (name.to_owned(), -1.0),
        None => (name, 1.0),
    }
}

impl RangeTable {
    fn range(self) -> Result<Range, String> {
        let Self { low, high, scale, mean, sd, values, seed, .. } = self;
        let numbers = [low, high, mean, sd];
        if numbers.iter().flatten().any(|number| !number.is_finite()) {
            return Err("a range needs finite numbers".into());
        }
        let has_range = numbers.iter().any(Option::is_some) || scale.is_some();
        if seed {
            return if has_range || values.is_some() {
                Err("seed = true draws a number by itself, without a range".into())
            } else {
                Ok(Range::Seed)
            };
        }
        if let Some(values) = values {
            if has_range {
                return Err("values and a range exclude each other".into());
            }
            if values.is_empty() {
                return Err("values is empty".into());
            }
            return Ok(Range::Values(values.into_iter().map(value_of).collect::<Result<_, _>>()?));
        }
        if let (Some(low), Some(high)) = (low, high)
            && low >= high
        {
            return Err(format!("low must be below high, but {low} is not below {high}"));
        }
        match (low, high, mean, sd) {
            (None, None, None, None) if scale.is_none() => Ok(Range::Column),
            (Some(low), Some(high), None, None) if scale == Some(Scale::Log) => {
                if low <= 0.0 {
                    return Err("a range by ratios needs a positive low".into());
                }
                Ok(Range::Logarithmic { low, high })
            }
            (Some(low), Some(high), None, None) => Ok(Range::Linear { low, high }),
            (low, high, Some(mean), Some(sd)) => {
                if sd <= 0.0 {
                    return Err("sd must be a positive number".into());
                }
                if scale == Some(Scale::Log) {
                    return Err("a normal distribution has no scale".into());
                }
                let (low, high) = (low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY));
                // Beyond eight standard deviations nothing is left to draw from.
                if low > mean + 8.0 * sd || high < mean - 8.0 * sd {
                    return Err("low and high leave nothing of the normal distribution".into());
                }
                Ok(Range::Normal { mean, sd, low, high })
            }
            (_, _, Some(_), None) | (_, _, None, Some(_)) => Err("a normal distribution needs mean and sd".into()),
            _ => Err("a range needs low and high".into()),
        }
    }
}

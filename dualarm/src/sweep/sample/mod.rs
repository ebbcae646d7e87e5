//! Points: the values of a draw.
//!
//! Every draw is a function of the study and the draw's index alone, so it does not matter where and when it is computed.
//! Random numbers are `ChaCha8` (RFC 8439's cipher with eight rounds) with the study's seed and one stream per draw. A unit
//! coordinate u per parameter becomes a value of its range by inversion of the distribution, with logarithms and
//! exponentials that are the same on every platform.
//!
//! * Latin hypercube: M. D. `McKay`, R. J. Beckman, W. J. Conover, *Technometrics* 21 (1979) 239–245,
//!   doi:10.1080/00401706.1979.10489755; strata are permuted by Fisher and Yates.
//! * Sobol: Owen-scrambled by hashing, B. Burley, *Journal of Computer Graphics Techniques* 9 (2020) no. 4, with the
//!   direction numbers of S. Joe and F. Y. Kuo. The first 2ᵏ points are a net, so draws are best a power of two.

mod normal;
mod probes;

use fmi2_cosim::system::SourceLine;
use fmi2_import::Value;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::points::Points;
use super::study::{Coordinates, Method, Range, Study, Varied};

/// Why there are no points.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SampleError {
    /// More runs than can be kept apart.
    #[error("{runs} runs are more than {} in one study", MOST_RUNS)]
    TooManyRuns {
        /// How many there would be.
        runs: u128,
    },
    /// The sequence ends.
    #[error(
        "method = \"sobol\" has at most {} draws of {} parameters; use \"latin-hypercube\" or \"random\"",
        SOBOL_DRAWS,
        sobol_burley::NUM_DIMENSIONS
    )]
    SobolEnds,
    /// The table lacks a parameter.
    #[error("{place}: {table} has no column \"{name}\"; it has {columns}")]
    NoColumn {
        /// The place of the parameter.
        place: String,
        /// The file.
        table: String,
        /// The parameter.
        name: String,
        /// The existing columns.
        columns: String,
    },
    /// A number that does not fit its parameter.
    #[error("{table}, row {row}, column \"{name}\": {problem}")]
    Cell {
        /// The file.
        table: String,
        /// Row, from 1, the header not counted.
        row: usize,
        /// The parameter.
        name: String,
        /// The fault.
        problem: String,
    },
}

/// The result is put together from an index of all runs: 8 bytes for each of them.
pub const MOST_RUNS: u64 = 10_000_000;
const SOBOL_DRAWS: u64 = 1 << 16;

/// The points of a study.
#[derive(Debug, Clone)]
pub struct Sampler {
    method: Method,
    seed: u64,
    draws: u64,
    vary: Vec<Varied>,
    /// Of a Latin hypercube: the stratum of each draw, by parameter.
    strata: Vec<Vec<u32>>,
    /// Of a table: the column of each parameter.
    columns: Vec<Vec<Value>>,
    coordinates: Coordinates,
}

impl Sampler {
    /// The points of a study; `points` is its table, if the method is [`Method::Table`].
    ///
    /// # Errors
    /// When there are too many, or the table does not fit.
    pub fn new(study: &Study, points: Option<Points>) -> Result<Self, SampleError> {
        let mut vary = study.vary.clone();
        let mut columns = Vec::new();
        let draws = match study.method {
            Method::Grid => vary.iter().map(|varied| u128::from(varied.count)).product(),
            Method::Table => {
                let points = points.unwrap_or_default();
                if vary.is_empty() {
                    vary = points.columns.iter().map(|(name, _)| of_column(name, &points.file)).collect();
                }
                columns =
                    vary.iter().map(|varied| column(varied, &points, study.coordinates)).collect::<Result<_, _>>()?;
                points.rows as u128
            }
            _ => u128::from(study.draws.unwrap_or_default()),
        };
        let runs = draws.saturating_mul(u128::from(study.runs_per_draw()));
        if runs > u128::from(MOST_RUNS) {
            return Err(SampleError::TooManyRuns { runs });
        }
        #[allow(clippy::cast_possible_truncation)] // not more than the runs
        let draws = draws as u64;
        let dimensions = vary.len() as u64;
        if study.method == Method::Sobol
            && (draws > SOBOL_DRAWS || dimensions > u64::from(sobol_burley::NUM_DIMENSIONS))
        {
            return Err(SampleError::SobolEnds);
        }
        let strata = match study.method {
            Method::LatinHypercube => {
                (0..dimensions).map(|dimension| permutation(study.seed, dimension, draws)).collect()
            }
            _ => Vec::new(),
        };
        let Study { method, seed, coordinates, .. } = *study;
        Ok(Self { method, seed, draws, vary, strata, columns, coordinates })
    }

    /// How many draws there are.
    #[must_use]
    pub fn draws(&self) -> u64 {
        self.draws
    }

    /// The parameters, in the order of [`Sampler::values`].
    #[must_use]
    pub fn vary(&self) -> &[Varied] {
        &self.vary
    }

    /// The values of a draw.
    #[must_use]
    pub fn values(&self, draw: u64) -> Vec<Value> {
        let mut random = stream(self.seed, Purpose::Coordinates, draw);
        let mut seeds = stream(self.seed, Purpose::Seeds, draw);
        let mut radix = draw;
        // The last parameter of a grid changes fastest.
        let mut digits = vec![0; self.vary.len()];
        for (digit, varied) in digits.iter_mut().zip(&self.vary).rev() {
            *digit = radix % varied.count;
            radix /= varied.count;
        }
        let value = |(index, varied): (usize, &Varied)| {
            let (uniform, seed) = (open_unit(random.next_u64()), seeds.next_u32() >> 1);
            if varied.range == Range::Seed {
                return Value::Integer(i32::try_from(seed).unwrap_or(i32::MAX));
            }
            #[allow(clippy::cast_possible_truncation)] // both have few enough, see `new`
            let coordinate = match self.method {
                Method::Grid => on_grid(&varied.range, digits[index], varied.count),
                Method::LatinHypercube => (f64::from(self.strata[index][draw as usize]) + uniform) / self.draws as f64,
                Method::Sobol => {
                    let scramble = stream(self.seed, Purpose::Scramble, 0).next_u32();
                    // The middle of the 24 bits that a sample has.
                    f64::from(sobol_burley::sample(draw as u32, index as u32, scramble)) + 0.5 / f64::from(1 << 24)
                }
                Method::Random => uniform,
                Method::Table => {
                    let cell = &self.columns[index][draw as usize];
                    match (self.coordinates, cell) {
                        (Coordinates::Unit, Value::Real(coordinate)) => *coordinate,
                        _ => return cell.clone(),
                    }
                }
            };
            at(&varied.range, coordinate)
        };
        self.vary.iter().enumerate().map(value).collect()
    }
}

/// A column as a parameter.
fn of_column(name: &str, file: &str) -> Varied {
    let targets = vec![(name.to_owned(), 1.0)];
    Varied {
        name: name.to_owned(),
        targets,
        range: Range::Column,
        count: 1,
        place: SourceLine { file: file.into(), line: 1 },
    }
}

fn column(varied: &Varied, points: &Points, coordinates: Coordinates) -> Result<Vec<Value>, SampleError> {
    if varied.range == Range::Seed {
        return Ok(Vec::new());
    }
    let Some((_, column)) = points.columns.iter().find(|(name, _)| *name == varied.name) else {
        return Err(SampleError::NoColumn {
            place: varied.place.to_string(),
            table: points.file.clone(),
            name: varied.name.clone(),
            columns: points.columns.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", "),
        });
    };
    let cell = |row: usize, problem: String| SampleError::Cell {
        table: points.file.clone(),
        row: row + 1,
        name: varied.name.clone(),
        problem,
    };
    if coordinates == Coordinates::Unit {
        if varied.range == Range::Column {
            return Err(cell(0, "a coordinate from 0 to 1 needs a range in [vary]".into()));
        }
        let is_unit = |value: &Value| matches!(value, Value::Real(number) if (0.0..=1.0).contains(number));
        if let Some(row) = column.iter().position(|value| !is_unit(value)) {
            return Err(cell(row, format!("a number from 0 to 1 is needed, not {}", column[row])));
        }
    } else if varied.targets.iter().any(|(_, sign)| *sign < 0.0)
        && let Some(row) = column.iter().position(|value| !matches!(value, Value::Real(_)))
    {
        return Err(cell(row, format!("a minus before a name needs a number, not {}", column[row])));
    }
    Ok(column.clone())
}

/// The purposes of random numbers; each has a key of its own.
enum Purpose {
    Coordinates,
    Seeds,
    Strata,
    Scramble,
}

fn stream(seed: u64, purpose: Purpose, index: u64) -> ChaCha8Rng {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8] = purpose as u8;
    let mut random = ChaCha8Rng::from_seed(key);
    random.set_stream(index);
    random
}

/// 52 bits and a half: never 0 or 1, and exact as a double.
fn open_unit(bits: u64) -> f64 {
    ((bits >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
}

/// The numbers below `count` in random order.
fn permutation(seed: u64, dimension: u64, count: u64) -> Vec<u32> {
    let mut random = stream(seed, Purpose::Strata, dimension);
    #[allow(clippy::cast_possible_truncation)] // at most `MOST_RUNS`
    let mut order: Vec<u32> = (0..count as u32).collect();
    for last in (1..order.len()).rev() {
        // The upper half of a product: uniform to 1 in 2⁴⁰ for such small numbers.
        let below = (u128::from(random.next_u64()) * (last as u128 + 1)) >> 64;
        #[allow(clippy::cast_possible_truncation)] // at most `last`
        order.swap(last, below as usize);
    }
    order
}

/// The coordinate of a grid's value: ends included where a range has ends.
fn on_grid(range: &Range, digit: u64, count: u64) -> f64 {
    match range {
        Range::Linear { .. } | Range::Logarithmic { .. } if count > 1 => digit as f64 / (count - 1) as f64,
        _ => (digit as f64 + 0.5) / count as f64,
    }
}

/// The value at a coordinate from 0 to 1.
fn at(range: &Range, coordinate: f64) -> Value {
    Value::Real(match range {
        Range::Linear { low, high } => (low + coordinate * (high - low)).clamp(*low, *high),
        Range::Logarithmic { low, high } => (low * libm::exp(coordinate * libm::log(high / low))).clamp(*low, *high),
        Range::Normal { mean, sd, low, high } => {
            let [first, last] = [low, high].map(|end| normal::distribution((end - mean) / sd));
            (mean + sd * normal::quantile(first + coordinate * (last - first))).clamp(*low, *high)
        }
        Range::Values(values) => {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and the last
            let index = (coordinate * values.len() as f64) as usize;
            return values[index.min(values.len() - 1)].clone();
        }
        Range::Seed | Range::Column => unreachable!("has no coordinate"),
    })
}

#[cfg(test)]
mod tests;

//! A control law near an operating point, as a sampled linear system with the signals of its FMU.
//!
//! ```text
//! x⁺ = A x + B y,    u = C x + D y,
//! ```
//!
//! where the inputs y are held over the step and the commands u are those of the same instant. The law serialises its
//! variables by name ([`serde`]); the variables that a step changes are its state. A, B and C are central differences of
//! the law's own step and commands, accurate to about 1e-9; D is exact.

use grasp_control::{INPUT_NAMES, INPUTS, Inputs, Law, StepError};
use grasp_plant::nalgebra::{DMatrix, DVector};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Inputs of every law, in the order of their FMUs.
pub const LAW_INPUTS: [&str; INPUTS] = INPUT_NAMES;
/// Units of [`LAW_INPUTS`].
pub const LAW_INPUT_UNITS: [&str; INPUTS] =
    ["rad", "rad", "rad/s", "rad/s", "m", "m/s", "N.m", "N.m", "N", "N", "N/s", "N/s", "N.m/s", "N.m/s", "N", "rad"];
/// Commands of every law.
pub const COMMANDS: [&str; 3] = ["tau1_cmd", "tau2_cmd", "u_cmd"];

/// The linear system.
#[derive(Clone, Debug)]
pub struct SampledLaw {
    /// A.
    pub a: DMatrix<f64>,
    /// B, 16 columns.
    pub b: DMatrix<f64>,
    /// C, 3 rows.
    pub c: DMatrix<f64>,
    /// D, 3 × 16.
    pub d: DMatrix<f64>,
    /// Names of the states: where the law stores them.
    pub states: Vec<String>,
}

/// Why a law has no linear system.
#[derive(Debug, thiserror::Error)]
pub enum LawError {
    /// The step is refused.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The law holds a number that can't be written down.
    #[error("the law's state can't be read: {0}")]
    State(#[from] serde_json::Error),
}

/// Places of all real numbers of a value.
fn numbers(value: &Value, place: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(number) if number.is_f64() => found.push(place.to_owned()),
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                numbers(item, &format!("{place}/{index}"), found);
            }
        }
        Value::Object(items) => {
            for (name, item) in items {
                numbers(item, &format!("{place}/{name}"), found);
            }
        }
        _ => {}
    }
}

fn at(value: &Value, places: &[String]) -> DVector<f64> {
    DVector::from_fn(places.len(), |i, _| value.pointer(&places[i]).and_then(Value::as_f64).unwrap_or(f64::NAN))
}

/// How far a number of this size is moved.
fn nudge(value: f64) -> f64 {
    1e-6 * value.abs().max(1.0)
}

impl SampledLaw {
    /// The law in its present state, with these inputs, for steps of `h` \[s\].
    ///
    /// # Errors
    /// The law refuses the step or can't be serialised.
    pub fn new<L: Law + Clone + Serialize + DeserializeOwned>(
        law: &L,
        inputs: &Inputs,
        h: f64,
    ) -> Result<Self, LawError> {
        let here = serde_json::to_value(law)?;
        let point = inputs.to_array();
        // The numbers that move, found by two steps with all inputs slightly changed; with large changes integrals may
        // stand still at a limit.
        let mut all = Vec::new();
        numbers(&here, "", &mut all);
        let mut moved = law.clone();
        for round in 1..=2 {
            let elsewhere = std::array::from_fn(|i| point[i] + 1e-6 * f64::from(round) * (1.0 + 0.1 * i as f64));
            moved.step(h, &Inputs::from_array(elsewhere), &Inputs::HELD)?;
        }
        let there = serde_json::to_value(&moved)?;
        let states: Vec<_> = all.into_iter().filter(|place| here.pointer(place) != there.pointer(place)).collect();

        let start = at(&here, &states);
        let stepped = |law: &L, inputs: &[f64; INPUTS]| -> Result<DVector<f64>, LawError> {
            let mut law = law.clone();
            law.step(h, &Inputs::from_array(*inputs), &Inputs::HELD)?;
            Ok(at(&serde_json::to_value(&law)?, &states))
        };
        let n = states.len();
        let (mut a, mut c) = (DMatrix::zeros(n, n), DMatrix::zeros(3, n));
        for (column, place) in states.iter().enumerate() {
            let step = nudge(start[column]);
            let moved = |by: f64| -> Result<L, LawError> {
                let mut value = here.clone();
                if let Some(number) = value.pointer_mut(place) {
                    *number = Value::from(start[column] + by);
                }
                Ok(serde_json::from_value(value)?)
            };
            let (mut up, mut down) = (moved(step)?, moved(-step)?);
            a.set_column(column, &((stepped(&up, &point)? - stepped(&down, &point)?) / (2.0 * step)));
            let (high, low) = (up.commands(inputs).to_array(), down.commands(inputs).to_array());
            for row in 0..3 {
                c[(row, column)] = (high[row] - low[row]) / (2.0 * step);
            }
        }
        let mut b = DMatrix::zeros(n, INPUTS);
        for column in 0..INPUTS {
            let step = nudge(point[column]);
            let moved = |by: f64| {
                let mut inputs = point;
                inputs[column] += by;
                stepped(law, &inputs)
            };
            b.set_column(column, &((moved(step)? - moved(-step)?) / (2.0 * step)));
        }
        let jacobian = law.clone().jacobian(inputs);
        let rows = [jacobian.tau[0], jacobian.tau[1], jacobian.u];
        let d = DMatrix::from_fn(3, INPUTS, |row, column| rows[row][column]);
        let names = states.iter().map(|place| place.trim_start_matches('/').replace('/', ".")).collect();
        Ok(Self { a, b, c, d, states: names })
    }

    /// The part that influences the commands, by the pattern of zeros. The other states (filters of estimates that at this
    /// point do not influence a command) only receive signals, and are stable by themselves.
    fn heard(&self) -> Self {
        let n = self.a.nrows();
        let mut heard: Vec<usize> = (0..n).filter(|i| self.c.column(*i).iter().any(|share| *share != 0.0)).collect();
        let mut next = 0;
        while let Some(&row) = heard.get(next) {
            next += 1;
            let fresh: Vec<_> = (0..n).filter(|i| self.a[(row, *i)] != 0.0 && !heard.contains(i)).collect();
            heard.extend(fresh);
        }
        heard.sort_unstable();
        Self {
            a: self.a.select_rows(&heard).select_columns(&heard),
            b: self.b.select_rows(&heard),
            c: self.c.select_columns(&heard),
            d: self.d.clone(),
            states: heard.iter().map(|i| self.states[*i].clone()).collect(),
        }
    }

    /// The part that the inputs influence and that influences the commands. States that inputs do not change to first order
    /// (estimates that learn from squares, weights in directions in which nothing is learnt) have no effect on a loop's
    /// stability at this point.
    #[must_use]
    pub fn reachable(&self) -> Self {
        let heard = self.heard();
        let n = heard.a.nrows();
        let mut basis: Vec<DVector<f64>> = Vec::new();
        let mut next: Vec<DVector<f64>> = (0..heard.b.ncols()).map(|i| heard.b.column(i).into_owned()).collect();
        while !next.is_empty() && basis.len() < n {
            let mut fresh = Vec::new();
            for mut vector in next {
                let size = vector.norm();
                // Rounding of the differences in `new`.
                if size < 1e-8 {
                    continue;
                }
                vector /= size;
                for _ in 0..2 {
                    for known in &basis {
                        let share = known.dot(&vector);
                        vector.axpy(-share, known, 1.0);
                    }
                }
                let left = vector.norm();
                if left > 1e-7 {
                    vector /= left;
                    basis.push(vector.clone());
                    fresh.push(&heard.a * vector);
                }
            }
            next = fresh;
        }
        if basis.is_empty() {
            return Self {
                a: DMatrix::zeros(0, 0),
                b: DMatrix::zeros(0, INPUTS),
                c: DMatrix::zeros(3, 0),
                d: self.d.clone(),
                states: Vec::new(),
            };
        }
        let t = DMatrix::from_columns(&basis);
        let states = (1..=basis.len()).map(|i| format!("r{i}")).collect();
        Self {
            a: t.transpose() * &heard.a * &t,
            b: t.transpose() * &heard.b,
            c: &heard.c * &t,
            d: self.d.clone(),
            states,
        }
    }
}

//! `--monitor lyapunov`: the Lyapunov functions of a grasp's controller along a run.

// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]

mod given;

use std::io;

use fmi2_cosim::master::Master;
use fmi2_cosim::record::{Column, Every, Kind, Points, Sink, Table};
use fmi2_cosim::run::Observer;
use grasp_certify::monitor::{COLUMNS, Integrals, Mirror, PaperLaw, RootLaw, Sample};

use super::{NABFC, PLANT};
use given::settings;

/// Outputs that are needed, in the order in which [`LyapunovWatch::read`] takes them.
const NEEDED: [&str; 36] = [
    "theta1",
    "theta2",
    "y_object",
    "theta1_d",
    "theta2_d",
    "y_object_d",
    "theta1_dot",
    "theta2_dot",
    "y_object_dot",
    "root_moment1",
    "root_moment2",
    "tip_shear1",
    "tip_shear2",
    "lambda2_d",
    "s1",
    "s2",
    "s",
    "U1_norm",
    "U2_norm",
    "W_norm",
    "pi1_hat",
    "pi2_hat",
    "epsilon_hat",
    "J1_hat",
    "J2_hat",
    "m_hat",
    "root_moment1_dot",
    "root_moment2_dot",
    "tip_shear1_dot",
    "tip_shear2_dot",
    "hub_uncertainty1",
    "hub_uncertainty2",
    "object_uncertainty",
    "tau1_cmd",
    "tau2_cmd",
    "u_cmd",
];

/// The largest relative difference between the loads of a run and those of the mirror; above it, the plant of the run is
/// another one.
const FAITHFUL: f64 = 0.02;

/// The values of a row.
#[derive(Clone, Copy, Default)]
struct Row {
    time: f64,
    sample: Sample,
    /// Rates of M̃_1, M̃_2 and of ΣQ.
    load_rate: [f64; 3],
    uncertainty: [f64; 3],
    command: [f64; 3],
}

/// The law whose functions are recorded.
enum Functions {
    Paper(Box<PaperLaw>),
    Root(Box<RootLaw>),
}

/// Why there is nothing to record.
#[derive(Debug, thiserror::Error)]
#[error("--monitor lyapunov: {0}")]
pub struct NoFunctions(String);

/// Follows a run.
pub struct LyapunovWatch {
    indices: [usize; NEEDED.len()],
    state: Option<(Mirror, Functions)>,
    obstacle: Option<String>,
    previous: Option<Row>,
    /// Largest |Δ_1|, |Δ_2|, |Δ̄| so far.
    disturbance: [f64; 3],
    rows: Every<Table>,
    /// The samples from which rows are made, for functions that depend on the whole run.
    samples: Vec<(Sample, Integrals)>,
}

/// The results.
pub struct Recorded {
    /// The columns `lyapunov_…`, at the times of the run's rows.
    pub table: Table,
    /// The verdict, in a sentence or two.
    pub verdict: String,
}

impl LyapunovWatch {
    /// For a run with these columns, with rows `interval` s apart.
    ///
    /// # Errors
    /// When a signal is missing.
    pub fn new(columns: &[Column], interval: f64, stop: f64) -> Result<Self, NoFunctions> {
        let mut indices = [0; NEEDED.len()];
        for (place, name) in indices.iter_mut().zip(NEEDED) {
            *place = columns.iter().position(|column| column.name == name).ok_or_else(|| {
                let names = [PLANT, NABFC.fmu].map(|file| file.trim_end_matches(".fmu"));
                NoFunctions(format!("this system has no output {name}; it takes one {} and one {}", names[0], names[1]))
            })?;
        }
        let rows = Every::new(interval, stop, Table::new(Self::columns()));
        let (state, obstacle, previous, samples) = (None, None, None, Vec::new());
        Ok(Self { indices, state, obstacle, previous, disturbance: [0.0; 3], rows, samples })
    }

    /// The columns it adds.
    #[must_use]
    pub fn columns() -> Vec<Column> {
        let column =
            |(name, unit): &(&str, &str)| Column { name: (*name).into(), unit: Some((*unit).into()), kind: Kind::Real };
        COLUMNS.iter().map(column).collect()
    }

    /// The functions along the run.
    ///
    /// # Errors
    /// When there were no rows, or the plant is another one.
    pub fn finish(self) -> Result<Recorded, NoFunctions> {
        if let Some(obstacle) = self.obstacle {
            return Err(NoFunctions(obstacle));
        }
        let Some((mirror, functions)) = self.state else { return Err(NoFunctions("the run never began".into())) };
        let deviation = mirror.deviation();
        if deviation.is_nan() || deviation > FAITHFUL {
            return Err(NoFunctions(format!(
                "the plant of the run is not the one that its parameters describe: its loads differ by {:.1} %",
                100.0 * deviation
            )));
        }
        let table = self.rows.sink;
        Ok(match functions {
            Functions::Root(law) => of_root(&law, table),
            Functions::Paper(law) => of_paper(&law, &table, &self.samples, self.disturbance),
        })
    }

    fn read(&self, time: f64, values: &[f64]) -> Row {
        let v = self.indices.map(|index| values[index]);
        let sample = Sample {
            error: [v[0] - v[3], v[1] - v[4], v[2] - v[5]],
            rate: [v[6], v[7], v[8]],
            load: [v[9], v[10], v[11], v[12]],
            lambda: [-v[13], v[13]],
            surface: [v[14], v[15], v[16]],
            weights: [v[17], v[18], v[19]],
            bound: [v[20], v[21], v[22]],
            inertia: [v[23], v[24], v[25]],
        };
        Row {
            time,
            sample,
            load_rate: [v[26], v[27], v[28] + v[29]],
            uncertainty: [v[30], v[31], v[32]],
            command: [v[33], v[34], v[35]],
        }
    }

    fn follow(&mut self, row: &Row) -> Result<[f64; COLUMNS.len()], String> {
        let Some((mirror, functions)) = &mut self.state else { return Ok([0.0; COLUMNS.len()]) };
        let previous = self.previous.unwrap_or(*row);
        let h = row.time - previous.time;
        if h > 0.0 {
            mirror.step(h, &row.sample).map_err(|error| error.to_string())?;
            let force = mirror.force();
            for (i, force) in force.into_iter().enumerate() {
                // The forces beside the command: the built-in uncertainty at both ends of the step, and the difference
                // between the command and what the actuator and disturbances made of it.
                let extra = force - previous.command[i];
                let largest = (extra + previous.uncertainty[i]).abs().max((extra + row.uncertainty[i]).abs());
                self.disturbance[i] = self.disturbance[i].max(largest);
            }
        }
        Ok(match functions {
            Functions::Paper(_) => [0.0; COLUMNS.len()],
            Functions::Root(law) => {
                law.values(mirror, h, [&previous.sample, &row.sample], [previous.load_rate, row.load_rate])
            }
        })
    }

    fn prepare(master: &mut Master) -> Result<(Mirror, Functions), String> {
        let (settings, law) = settings(master)?;
        let mirror = Mirror::new(&settings.plant).map_err(|error| error.to_string())?;
        let functions = if law == "root_strain" {
            let root = RootLaw::new(&settings).ok_or(
                "these gains of the root-strain law have no certificate (`dualarm certify`), so no H is known for them",
            )?;
            Functions::Root(Box::new(root))
        } else {
            Functions::Paper(Box::new(PaperLaw::new(&settings)))
        };
        Ok((mirror, functions))
    }
}

fn of_root(law: &RootLaw, table: Table) -> Recorded {
    let [h, bound] = ["lyapunov_H", "lyapunov_bound"].map(|name| table.column(name).unwrap_or_default());
    let ratios = h.iter().zip(bound).map(|(h, bound)| h / bound);
    let worst = ratios.filter(|ratio| ratio.is_finite()).fold(0.0, f64::max);
    let verdict = format!(
        "the certified bound {} (phi = {:.3} 1/s, with D(t) of all that the law does beyond its core): H is at most {worst:.3} of it",
        if worst <= 1.0 + 1e-6 { "holds" } else { "is violated" },
        law.phi(),
    );
    Recorded { table, verdict }
}

fn of_paper(law: &PaperLaw, times: &Table, samples: &[(Sample, Integrals)], disturbance: [f64; 3]) -> Recorded {
    let mut table = Table::new(LyapunovWatch::columns());
    let mut first = None;
    let mut held = true;
    for (time, (sample, integrals)) in times.times().iter().zip(samples) {
        let [h, e, c, v_o, v_1, v_2] = law.values(integrals, sample, disturbance);
        let (start, h_0) = *first.get_or_insert((*time, h));
        let bound = law.bound(h_0, time - start, disturbance).unwrap_or(f64::INFINITY);
        held &= h <= bound;
        // A table takes every row.
        let _ = table.row(*time, &[h, e, c, v_o, v_1, v_2, 0.0, bound]);
    }
    let h = table.column("lyapunov_H").unwrap_or_default();
    let rises = h.windows(2).filter(|pair| pair[1] > pair[0] * (1.0 + 1e-9)).count();
    let claim = match law.bound(0.0, f64::INFINITY, disturbance) {
        Some(last) => {
            let begun = h.first().copied().unwrap_or_default();
            let word = if held { "holds" } else { "is violated" };
            format!("(90) {word}: H starts at {begun:.3e}, and the bound ends at {last:.3e}")
        }
        None => "(90) claims nothing: no constants satisfy (82)-(88) for these gains; H is that of the smallest beta_1 that any gains \
                 allow"
            .to_owned(),
    };
    let [d1, d2, d] = disturbance;
    let verdict = format!(
        "{claim}; H rises in {rises} of {} intervals; |Delta_1|, |Delta_2| <= {d1:.3}, {d2:.3} N.m, |Delta| <= {d:.3} N",
        h.len().saturating_sub(1)
    );
    Recorded { table, verdict }
}

impl Observer for LyapunovWatch {
    fn begin(&mut self, master: &mut Master, _: &[Column]) -> Vec<String> {
        match Self::prepare(master) {
            Ok(state) => self.state = Some(state),
            Err(obstacle) => self.obstacle = Some(obstacle),
        }
        Vec::new()
    }

    fn follows(&self, column: &Column) -> bool {
        NEEDED.contains(&column.name.as_str())
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        let mut row = vec![0.0; self.indices.iter().max().map_or(0, |last| last + 1)];
        points.times().iter().enumerate().try_for_each(|(point, time)| {
            points.put(point, &mut row);
            self.take(*time, &row)
        })
    }

    fn conclude(&mut self) -> Vec<String> {
        Vec::new()
    }
}

impl LyapunovWatch {
    /// Goes on to the next communication point.
    fn take(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        let row = self.read(time, values);
        match self.follow(&row) {
            Ok(functions) => {
                let before = self.rows.sink.times().len();
                self.rows.row(time, &functions)?;
                if let Some((mirror, Functions::Paper(_))) = &self.state
                    && self.rows.sink.times().len() > before
                {
                    self.samples.push((row.sample, mirror.integrals(&row.sample)));
                }
            }
            Err(obstacle) => self.obstacle = Some(obstacle),
        }
        self.previous = Some(row);
        Ok(())
    }
}

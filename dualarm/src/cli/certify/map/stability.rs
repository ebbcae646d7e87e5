//! Which sampled loops are stable.

use std::fmt;

use grasp_certify::sampled::Coupled;
use grasp_certify::settings::Settings;
use grasp_plant::Plant;
use serde::Serialize;

use super::Chart;
use super::draw::{Cells, cells};
use crate::cli::Failure;
use crate::cli::linearise::law;
use crate::grasp::Controller;

/// Steps of delay.
const DELAYS: [usize; 4] = [0, 1, 2, 3];
/// Steps that are examined \[s\], and the ratio from one to the next.
const SHORTEST: f64 = 2e-5;
const LONGEST: f64 = 5e-3;
const RATIO: f64 = 1.06;
/// Above 1 by more than the rounding error of an eigenvalue on the circle.
const UNSTABLE: f64 = 1.0 + 1e-10;

/// The spectral radius of one step.
fn radius(
    coupled: &Coupled,
    controller: &Controller,
    settings: &Settings,
    h: f64,
    delay: usize,
) -> Result<f64, Failure> {
    let mut law = law::of(controller, settings).map_err(Failure::usage)?;
    let inputs = law.at_target(settings);
    let linear = law.linear(&inputs, h).map_err(Failure::failed)?.reachable();
    Ok(coupled.spectral_radius(&linear, delay))
}

/// `--map steps`.
#[derive(Serialize)]
pub struct Steps {
    command: &'static str,
    map: &'static str,
    /// The range of steps that was examined \[s\].
    examined: [f64; 2],
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    controller: &'static str,
    title: &'static str,
    /// By steps of delay: the first unstable step \[s\]; `None` if every examined step is stable.
    first_unstable: [Option<f64>; DELAYS.len()],
}

impl Steps {
    pub fn new(controllers: &[Controller], settings: &Settings) -> Result<Self, Failure> {
        let plant = Plant::new(settings.plant.clone()).map_err(Failure::usage)?;
        let at = |controller: &Controller, h: f64, delay: usize| {
            radius(&Coupled::new(&plant, h), controller, settings, h, delay)
        };
        let mut rows = Vec::new();
        for controller in controllers {
            let mut first_unstable = [None; DELAYS.len()];
            let mut h = SHORTEST;
            while h < LONGEST && first_unstable.contains(&None) {
                let coupled = Coupled::new(&plant, h);
                let mut law = law::of(controller, settings).map_err(Failure::usage)?;
                let inputs = law.at_target(settings);
                let linear = law.linear(&inputs, h).map_err(Failure::failed)?.reachable();
                for (place, delay) in first_unstable.iter_mut().zip(DELAYS) {
                    if place.is_none() && coupled.spectral_radius(&linear, delay) > UNSTABLE {
                        let (mut low, mut high) = (h / RATIO, h);
                        while high - low > 1e-4 * low {
                            let middle = 0.5 * (low + high);
                            if at(controller, middle, delay)? > UNSTABLE { high = middle } else { low = middle }
                        }
                        *place = Some(high);
                    }
                }
                h *= RATIO;
            }
            rows.push(Row { controller: controller.key, title: controller.title, first_unstable });
        }
        Ok(Self { command: "certify", map: "steps", examined: [SHORTEST, LONGEST], rows })
    }
}

impl fmt::Display for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "First unstable step in ms, commands this many steps late ({:.2} to {} ms examined):",
            1e3 * SHORTEST,
            1e3 * LONGEST
        )?;
        writeln!(f, "{:<24}{:>10}{:>10}{:>10}{:>10}", "", "at once", "1", "2", "3")?;
        for row in &self.rows {
            write!(f, "{:<24}", row.title)?;
            for step in row.first_unstable {
                match step {
                    Some(step) => write!(f, "{:>10.4}", 1e3 * step)?,
                    None => write!(f, "{:>10}", "none")?,
                }
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

impl Chart for Steps {
    fn svg(&self) -> Option<String> {
        None
    }
}

/// `--map gains`.
#[derive(Serialize)]
pub struct Gains {
    command: &'static str,
    map: &'static str,
    /// Steps \[s\].
    steps: Vec<f64>,
    /// Factors of all feedback gains.
    factors: Vec<f64>,
    panels: Vec<Panel>,
}

#[derive(Serialize)]
struct Panel {
    controller: &'static str,
    title: &'static str,
    delay: usize,
    /// Spectral radius by step, then by factor.
    radius: Vec<Vec<f64>>,
}

/// Delays that have a panel.
const SHOWN: usize = 3;

impl Gains {
    pub fn new(controllers: &[Controller], settings: &Settings) -> Result<Self, Failure> {
        let plant = Plant::new(settings.plant.clone()).map_err(Failure::usage)?;
        let spaced = |from: f64, to: f64, count: u32| -> Vec<f64> {
            (0..count).map(|i| from * (to / from).powf(f64::from(i) / f64::from(count - 1))).collect()
        };
        let (steps, factors) = (spaced(SHORTEST, LONGEST, 37), spaced(0.1, 10.0, 21));
        let mut panels: Vec<Panel> = Vec::new();
        for controller in controllers {
            for delay in 0..SHOWN {
                panels.push(Panel { controller: controller.key, title: controller.title, delay, radius: Vec::new() });
            }
        }
        // The networks' integrals are slow beside everything here, and hundreds of weights take minutes.
        let bare = Settings { paper: settings.paper.without_networks(), ..settings.clone() };
        for h in &steps {
            let coupled = Coupled::new(&plant, *h);
            for (controller, panels) in controllers.iter().zip(panels.chunks_mut(SHOWN)) {
                let mut columns = vec![Vec::new(); SHOWN];
                for factor in &factors {
                    let settings = Settings { gain_factor: *factor, ..bare.clone() };
                    let mut law = law::of(controller, &settings).map_err(Failure::usage)?;
                    let inputs = law.at_target(&settings);
                    let linear = law.linear(&inputs, *h).map_err(Failure::failed)?.reachable();
                    for (delay, column) in columns.iter_mut().enumerate() {
                        column.push(coupled.spectral_radius(&linear, delay));
                    }
                }
                for (panel, column) in panels.iter_mut().zip(columns) {
                    panel.radius.push(column);
                }
            }
        }
        Ok(Self { command: "certify", map: "gains", steps, factors, panels })
    }
}

impl fmt::Display for Gains {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Share of the map that is stable (--out map.svg draws it, --json has all radii):")?;
        for panel in &self.panels {
            let all = panel.radius.iter().flatten();
            let stable = all.clone().filter(|radius| **radius <= UNSTABLE).count();
            let late = if panel.delay == 0 { "at once".to_owned() } else { format!("{} late", panel.delay) };
            writeln!(f, "{:<24}{late:>9} {:>5.1} %", panel.title, 100.0 * stable as f64 / all.count() as f64)?;
        }
        Ok(())
    }
}

impl Chart for Gains {
    fn svg(&self) -> Option<String> {
        let panels: Vec<_> = self
            .panels
            .iter()
            .map(|panel| Cells {
                heading: match panel.delay {
                    0 => format!("{}, at once", panel.title),
                    delay => format!("{}, {delay} late", panel.title),
                },
                // Amplitudes' rate of growth.
                values: panel
                    .radius
                    .iter()
                    .zip(&self.steps)
                    .map(|(column, h)| {
                        column
                            .iter()
                            .map(|radius| if *radius > UNSTABLE { f64::INFINITY } else { radius.ln() / h })
                            .collect()
                    })
                    .collect(),
            })
            .collect();
        Some(cells(&panels, SHOWN, &self.steps, &self.factors))
    }
}

//! FMUs on a bench: start values, free inputs held at will, outputs read at will.

use super::VerifyError;
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Coupling, Master};
use fmi2_cosim::settings::Setting;
use fmi2_import::{Fmu, ValueReference};

/// More steps than any check takes.
const LONG_ENOUGH: f64 = 1e6;

/// Start values by name.
pub type Settings = Vec<Setting>;

/// Names and values as settings.
pub fn settings<'a>(values: impl IntoIterator<Item = (&'a str, f64)>) -> Settings {
    values.into_iter().map(|(name, value)| Setting::new(name, value)).collect()
}

/// FMUs that run together, Gauss–Seidel in their order, stepped with one step size.
pub struct Rig {
    master: Master,
    step: f64,
    done: u64,
}

/// Variables of one component.
#[derive(Debug, Clone)]
pub struct Port {
    component: usize,
    references: Vec<ValueReference>,
}

impl Rig {
    /// Instances with their start values, before initialisation.
    fn prepare(fmus: &[&Fmu], settings: &Settings) -> Result<Master, VerifyError> {
        let fmus: Vec<Fmu> = fmus.iter().map(|&fmu| fmu.clone()).collect();
        let mut master = Master::new(&fmus, Coupling::GaussSeidel)?;
        for setting in settings {
            master.apply(setting)?;
        }
        Ok(master)
    }

    /// Initialised FMUs at t = 0.
    ///
    /// # Errors
    /// When an FMU refuses.
    pub fn new(fmus: &[&Fmu], settings: &Settings, step: f64) -> Result<Self, VerifyError> {
        let mut master = Self::prepare(fmus, settings)?;
        // FMUs refuse steps beyond the stop time.
        let grid = TimeGrid::new(0.0, LONG_ENOUGH * step, step);
        master.initialize(&grid.unwrap_or_else(|_| unreachable!("the bench's steps are positive")))?;
        Ok(Self { master, step, done: 0 })
    }

    /// Runs to `stop` and returns these outputs every `interval` s, one vector per row; first the time.
    ///
    /// # Errors
    /// When an FMU refuses.
    pub fn record(
        fmus: &[&Fmu],
        settings: &Settings,
        (stop, step, interval): (f64, f64, f64),
        names: &[&str],
    ) -> Result<Vec<Vec<f64>>, VerifyError> {
        let mut master = Self::prepare(fmus, settings)?;
        let grid = TimeGrid::new(0.0, stop, step).unwrap_or_else(|_| unreachable!("the bench's steps are positive"));
        master.initialize(&grid)?;
        let mut table = fmi2_cosim::record::Table::new(master.record(|name| names.contains(&name)));
        master.run(&grid, interval, &mut table, &mut |_| ())?;
        let place = |name: &&str| {
            let found = table.columns().iter().position(|column| column.name == *name);
            found.ok_or_else(|| VerifyError::Variable((*name).to_owned()))
        };
        let places = names.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        let row = |(time, values): (f64, Vec<f64>)| {
            std::iter::once(time).chain(places.iter().map(|&place| values[place])).collect()
        };
        Ok(table.rows().map(row).collect())
    }

    /// Variables of one component by name.
    ///
    /// # Errors
    /// When it lacks one.
    pub fn port(&mut self, component: usize, names: &[&str]) -> Result<Port, VerifyError> {
        let description = self.master.instance(component).description();
        let reference = |name: &&str| {
            let found = description.variable(name).map(|variable| variable.value_reference);
            found.ok_or_else(|| VerifyError::Variable((*name).to_owned()))
        };
        Ok(Port { component, references: names.iter().map(reference).collect::<Result<_, _>>()? })
    }

    /// Hands values to free inputs.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn set(&mut self, port: &Port, values: &[f64]) -> Result<(), VerifyError> {
        self.master.instance(port.component).set_real(&port.references, values)?;
        Ok(())
    }

    /// Values now.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn get(&mut self, port: &Port) -> Result<Vec<f64>, VerifyError> {
        let mut values = vec![0.0; port.references.len()];
        self.master.instance(port.component).get_real(&port.references, &mut values)?;
        Ok(values)
    }

    /// Time derivatives now.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn rates(&mut self, port: &Port) -> Result<Vec<f64>, VerifyError> {
        let orders = vec![1; port.references.len()];
        let mut values = vec![0.0; port.references.len()];
        self.master.instance(port.component).output_derivatives(&port.references, &orders, &mut values)?;
        Ok(values)
    }

    /// Does a number of steps.
    ///
    /// # Errors
    /// When an FMU does not complete one.
    pub fn advance(&mut self, steps: u64) -> Result<(), VerifyError> {
        for _ in 0..steps {
            self.master.step(self.done as f64 * self.step, self.step)?;
            self.done += 1;
        }
        Ok(())
    }
}

//! `dualarm verify`: compares the packaged FMUs with exact and independent solutions, through their C interface.
//!
//! * [`plant`]: eigenvalues, step responses and static deflection, compared with the exact solution of the beam equations;
//! * [`conservation`]: the constraint (12), the energy balance with every source of work, the momentum;
//! * [`closed_loop`]: closed-loop poles, and co-simulations against plant and controller solved as one stiff ODE.
//!
//! The exact values are data of the tool, made by `tests/oracle` (in Python, with another discretisation or none), see
//! [`oracle`]. [`identify`] finds eigenvalues from responses, [`rig`] runs FMUs.

pub mod closed_loop;
pub mod conservation;
pub mod identify;
pub mod oracle;
pub mod plant;
pub mod rig;

use std::fmt::Write;
use std::iter;
use std::path::Path;

use crate::grasp;
use crate::report::figures::NamedFigure;
use crate::report::{TextTable, csv};
use fmi2_cosim::master::MasterError;
use fmi2_cosim::settings::SettingError;
use fmi2_import::{CallError, Fmu, FmuError};

/// Why the checks could not be made at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// An FMU cannot be opened.
    #[error(transparent)]
    Fmu(#[from] FmuError),
    /// A co-simulation failed.
    #[error(transparent)]
    Master(#[from] MasterError),
    /// A call failed.
    #[error(transparent)]
    Call(#[from] CallError),
    /// A start value was refused.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// An FMU lacks a variable.
    #[error("no component has a variable {0}")]
    Variable(String),
}

/// The subject of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// The plant against the exact solution.
    Plant,
    /// Quantities that are constant, or change only by the supplied amount.
    Conservation,
    /// Plant and controller together.
    ClosedLoop,
}

impl Subject {
    /// All subjects in the order of the report.
    pub const ALL: [Self; 3] = [Self::Plant, Self::Conservation, Self::ClosedLoop];

    /// Heading in the report.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Plant => "Plant against the exact solution",
            Self::Conservation => "Conservation",
            Self::ClosedLoop => "Closed loop",
        }
    }
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// Group it belongs to.
    pub subject: Subject,
    /// A description of the check.
    pub what: String,
    /// The exact or independent value, written out.
    pub exact: String,
    /// The value of the FMU, written out.
    pub found: String,
    /// Error, in the unit of the bound.
    pub error: f64,
    /// The error must not be larger.
    pub bound: f64,
    /// Unit of error and bound: "1" for relative ones.
    pub unit: &'static str,
}

impl Check {
    /// Whether the bound holds; a NaN does not.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.error <= self.bound
    }
}

/// All checks, and the figure of spectral convergence.
#[derive(Debug, Clone)]
pub struct Verification {
    /// The rows.
    pub checks: Vec<Check>,
    /// Convergence over the order.
    pub figure: NamedFigure,
}

/// The FMUs under test.
#[derive(Clone)]
pub struct Fmus {
    /// `DualArmPlant.fmu`.
    pub plant: Fmu,
    /// `NabfcController.fmu`, `PdsController.fmu`, `PdController.fmu`.
    pub controllers: [Fmu; 3],
}

impl Fmus {
    /// Opens the packaged FMUs of a folder.
    ///
    /// # Errors
    /// When one is missing or damaged.
    pub fn open(folder: &Path) -> Result<Self, FmuError> {
        let open = |file: &str| Fmu::open(folder.join(file));
        let [nabfc, pds, pd] = grasp::PAPER.map(|controller| controller.fmu);
        Ok(Self { plant: open(grasp::PLANT)?, controllers: [open(nabfc)?, open(pds)?, open(pd)?] })
    }

    /// The FMU of a controller by its model name.
    ///
    /// # Errors
    /// When there is none.
    pub fn controller(&self, name: &str) -> Result<&Fmu, VerifyError> {
        let found = self.controllers.iter().find(|fmu| fmu.description().model_name == name);
        found.ok_or_else(|| VerifyError::Variable(name.to_owned()))
    }
}

/// Makes all checks; `progress` is called with the present activity.
///
/// # Errors
/// When an FMU fails. A broken bound is no error here: see [`Check::passes`].
pub fn verify(fmus: &Fmus, progress: &mut dyn FnMut(&str)) -> Result<Verification, VerifyError> {
    let mut checks = Vec::new();
    progress("plant: eigenvalues");
    checks.extend(plant::eigenvalues(fmus)?);
    progress("plant: step responses, static deflection");
    checks.extend(plant::step_responses(fmus)?);
    checks.extend(plant::static_deflections(fmus)?);
    progress("conservation");
    checks.extend(conservation::checks(fmus)?);
    progress("closed loop: poles");
    checks.extend(closed_loop::poles(fmus)?);
    progress("closed loop: monolithic solutions");
    checks.extend(closed_loop::against_monolith(fmus)?);
    progress("convergence over the order");
    let (figure, convergence) = plant::convergence(fmus)?;
    checks.extend(convergence);
    checks.sort_by_key(|check| Subject::ALL.iter().position(|subject| *subject == check.subject));
    Ok(Verification { checks, figure })
}

const HEADER: [&str; 6] = ["what was checked", "exact or independent value", "FMU gave", "error", "bound", "pass"];

impl Verification {
    /// Number of broken bounds.
    #[must_use]
    pub fn failures(&self) -> usize {
        self.checks.iter().filter(|check| !check.passes()).count()
    }

    /// One table per subject.
    pub fn tables(&self) -> impl Iterator<Item = (&'static str, TextTable)> {
        Subject::ALL.into_iter().map(|subject| {
            let rows = self.checks.iter().filter(|check| check.subject == subject).map(row).collect();
            (subject.title(), TextTable { header: HEADER.map(str::to_owned).into(), rows })
        })
    }

    /// The tables in Markdown.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let mut text = String::from("# Verification\n\nMade by `dualarm verify` from the packaged FMUs.\n");
        for (title, table) in self.tables() {
            let _ = write!(text, "\n## {title}\n\n{}", table.to_markdown());
        }
        let NamedFigure { name, caption, note, .. } = &self.figure;
        let _ = write!(text, "\n## Convergence\n\n![{caption}](figures/{name}.svg)\n\n{note}\n");
        text
    }

    /// All rows as CSV with errors and bounds in full digits.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let header = ["subject", "check", "exact", "found", "error", "bound", "unit", "pass"].map(str::to_owned);
        let rows = self.checks.iter().map(|check| {
            let Check { subject, what, exact, found, error, bound, unit } = check;
            let [what, exact, found] = [what, exact, found].map(Clone::clone);
            let (error, bound) = (format!("{error:e}"), format!("{bound:e}"));
            vec![subject.title().into(), what, exact, found, error, bound, (*unit).into(), check.passes().to_string()]
        });
        csv(iter::once(header.to_vec()).chain(rows))
    }
}

fn row(check: &Check) -> Vec<String> {
    let with_unit = |value: f64| match check.unit {
        "1" => format!("{value:.1e}"),
        unit => format!("{value:.1e} {unit}"),
    };
    vec![
        check.what.clone(),
        check.exact.clone(),
        check.found.clone(),
        with_unit(check.error),
        with_unit(check.bound),
        if check.passes() { "yes" } else { "NO" }.to_owned(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_without_a_number_does_not_pass() {
        let check = Check {
            subject: Subject::Plant,
            what: "x".into(),
            exact: "1".into(),
            found: "NaN".into(),
            error: f64::NAN,
            bound: 1.0,
            unit: "1",
        };
        assert!(!check.passes());
        assert!(Check { error: 1.0, ..check }.passes());
    }
}

//! `dualarm compare`: the matrix of controllers and cases.

use std::collections::HashSet;

use clap::Args;

use super::progress::Progress;
use super::{Failure, print_error};
use crate::grasp::matrix::case::CaseError;
use crate::grasp::matrix::contender::ContenderError;
use crate::grasp::matrix::{Case, CellError, Contender, Lab, Matrices, Matrix};

/// Which controllers run in which cases.
#[derive(Debug, Clone, Default, Args)]
pub struct MatrixChoice {
    /// Run every controller in every case only, without the paper's runs
    #[arg(long, conflicts_with = "no_matrix")]
    matrix: bool,
    /// Run the paper's three scenarios only
    #[arg(long, conflicts_with_all = ["cases", "controllers"])]
    no_matrix: bool,
    /// Only these cases: names of the files in scenarios/matrix or scenarios/contact, all of the latter by `contact`, or scenario
    /// files (.toml) of your own
    #[arg(long, value_name = "CASE", value_delimiter = ',')]
    cases: Vec<String>,
    /// Only these controllers: names as for `simulate --controller`, presets or scenarios (.toml), controller FMUs (.fmu)
    #[arg(long, value_name = "CONTROLLER", value_delimiter = ',')]
    controllers: Vec<String>,
}

impl MatrixChoice {
    /// Whether the paper's runs are left out.
    pub fn is_alone(&self) -> bool {
        self.matrix || !self.cases.is_empty() || !self.controllers.is_empty()
    }
}

/// The cases that a user names; all without names.
pub fn cases(names: &[String]) -> Result<Vec<Case>, Failure> {
    let found: Result<Vec<Case>, _> = if names.is_empty() {
        Case::all()
    } else {
        names.iter().map(|name| named(name)).collect::<Result<Vec<_>, _>>().map(|cases| cases.concat())
    };
    found.map_err(Failure::from)
}

/// The cases of a name.
fn named(name: &str) -> Result<Vec<Case>, CaseError> {
    if name == "contact" { Case::contact() } else { Case::find(name).map(|case| vec![case]) }
}

/// Checks that names of rows and columns are unique.
fn unique<'a>(what: &str, mut keys: impl Iterator<Item = &'a str>) -> Result<(), Failure> {
    let mut seen = HashSet::new();
    match keys.find(|key| !seen.insert(*key)) {
        None => Ok(()),
        Some(key) => Err(Failure::usage(format!(
            "two {what} are called {key}, and the results could not be told apart: name each once, and files differently"
        ))),
    }
}

/// What the user chose, found and not yet run.
pub struct Chosen {
    cases: Vec<Case>,
    /// If no cases are named, those of grasps that can open: they form a matrix of their own.
    contact: Option<Vec<Case>>,
    contenders: Vec<Contender>,
}

impl MatrixChoice {
    /// Reads the files of cases and controllers; `None` if the user wants no matrix.
    pub fn chosen(&self) -> Result<Option<Chosen>, Failure> {
        if self.no_matrix {
            return Ok(None);
        }
        let cases = cases(&self.cases)?;
        unique("cases", cases.iter().map(|case| case.key.as_str()))?;
        let mut contenders = if self.controllers.is_empty() {
            Contender::all()?
        } else {
            self.controllers.iter().map(|name| Contender::find(name)).collect::<Result<_, _>>()?
        };
        unique("controllers", contenders.iter().map(|contender: &Contender| contender.key.as_str()))?;
        Contender::distinguish(&mut contenders);
        let contact = if self.cases.is_empty() { Some(Case::contact()?) } else { None };
        Ok(Some(Chosen { cases, contact, contenders }))
    }
}

impl Chosen {
    /// Checks that everything can run, as far as that is known before.
    pub fn check(&self, lab: &Lab) -> Result<(), Failure> {
        for cases in [Some(&self.cases), self.contact.as_ref()].into_iter().flatten() {
            Matrix::check(lab, cases, &self.contenders)?;
        }
        Ok(())
    }

    /// Runs the cells.
    pub fn run(self, lab: &Lab, quiet: bool) -> Result<Matrices, Failure> {
        let Self { cases, contact, contenders } = self;
        let contact_contenders = contact.as_ref().map(|_| contenders.clone()).unwrap_or_default();
        let closed = run_cases(cases, contenders, lab, quiet)?;
        let contact = contact.map(|cases| run_cases(cases, contact_contenders, lab, quiet)).transpose()?;
        Ok(Matrices { closed, contact })
    }
}

/// The failure of a comparison with rows or columns in which nothing ran.
pub fn complete(matrices: &Matrices) -> Result<(), Failure> {
    let failed: Vec<&str> =
        [Some(&matrices.closed), matrices.contact.as_ref()].into_iter().flatten().flat_map(Matrix::failed).collect();
    if failed.is_empty() {
        return Ok(());
    }
    let failed = failed.join(", ");
    Err(Failure::failed(format!("every run failed of {failed}: see the warnings. All other results are written")))
}

fn run_cases(cases: Vec<Case>, contenders: Vec<Contender>, lab: &Lab, quiet: bool) -> Result<Matrix, Failure> {
    let bar = Progress::new(quiet).bar("matrix", (cases.len() * contenders.len()) as u64);
    let matrix = Matrix::run(lab, cases, contenders, &|| bar.inc(1))?;
    bar.finish_and_clear();
    for (case, cells) in matrix.cases.iter().zip(&matrix.cells) {
        for (contender, cell) in matrix.contenders.iter().zip(cells) {
            if let Err(reason) = cell {
                print_error(&format!("warning: {} in the case {}: {reason}\n", contender.key, case.key));
            }
        }
    }
    Ok(matrix)
}

impl From<CaseError> for Failure {
    fn from(error: CaseError) -> Self {
        match error {
            CaseError::Scenario(error) => error.into(),
            CaseError::Unknown { .. } => Self::usage(error),
        }
    }
}

impl From<CellError> for Failure {
    fn from(error: CellError) -> Self {
        match error {
            CellError::Scenario(error) => error.into(),
            CellError::Never(_) | CellError::NoController(_) => Self::usage(error),
            _ => Self::failed(error),
        }
    }
}

impl From<ContenderError> for Failure {
    fn from(error: ContenderError) -> Self {
        match error {
            ContenderError::Preset(error) => error.into(),
            _ => Self::usage(error),
        }
    }
}

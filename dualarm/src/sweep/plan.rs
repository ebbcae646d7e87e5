//! The definition of each run, from the study alone, without any FMU.

use std::ops::Range;
use std::path::Path;

use super::SweepError;
use super::points::Points;
use super::sample::Sampler;
use super::study::{Coordinates, Entrant, Method, Study, Varied};
use crate::grasp::matrix::Contender;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::system::Located;
use fmi2_import::Value;

/// A study with its points and controllers.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The study.
    pub study: Study,
    /// The controllers that each draw runs with, if it does with any.
    pub contenders: Vec<Contender>,
    /// The points.
    pub sampler: Sampler,
    /// The file of the points, if there is one.
    pub points: Option<std::path::PathBuf>,
}

/// Points that the command line brings instead of the study's.
#[derive(Debug, Clone, Copy)]
pub struct OtherPoints<'a> {
    /// The file.
    pub file: &'a Path,
    /// The kind of its numbers.
    pub coordinates: Coordinates,
}

impl Plan {
    /// Reads a study, its points and its presets.
    ///
    /// # Errors
    /// When one of them cannot be read or does not fit.
    pub fn read(file: &Path, other: Option<OtherPoints>) -> Result<Self, SweepError> {
        let mut study = Study::read(file)?;
        let mut table = study.points.as_ref().map(|points| study.path(points));
        if let Some(OtherPoints { file, coordinates }) = other {
            (study.method, study.draws, study.coordinates) = (Method::Table, None, coordinates);
            table = Some(file.to_owned());
        }
        let points = table.as_deref().map(Points::read).transpose()?;
        let contender = |entrant: &Entrant| -> Result<Contender, SweepError> {
            let beside = study.path(Path::new(&entrant.name));
            let name = if beside.is_file() { beside.to_string_lossy().into_owned() } else { entrant.name.clone() };
            let mut contender = Contender::find(&name)?;
            contender.step = entrant.step.or(contender.step);
            if let Some(title) = &entrant.title {
                contender.title.clone_from(title);
            }
            Ok(contender)
        };
        let mut contenders = study.entrants.iter().map(contender).collect::<Result<Vec<_>, _>>()?;
        // Tables group runs by these titles.
        Contender::distinguish(&mut contenders);
        let sampler = Sampler::new(&study, points)?;
        Ok(Self { study, contenders, sampler, points: table })
    }

    /// All runs.
    #[must_use]
    pub fn runs(&self) -> Range<u64> {
        0..self.sampler.draws() * self.study.runs_per_draw()
    }

    /// The draw that a run belongs to. All runs of a draw have the same values.
    #[must_use]
    pub fn draw(&self, run: u64) -> u64 {
        run / self.study.runs_per_draw()
    }

    /// The controller of a run, by its place.
    #[must_use]
    pub fn entrant(&self, run: u64) -> usize {
        usize::try_from(run % self.study.runs_per_draw()).unwrap_or_default()
    }

    /// The name of a run's controller in tables.
    #[must_use]
    pub fn controller(&self, run: u64) -> Option<&str> {
        self.contenders.get(self.entrant(run)).map(|contender| contender.title.as_str())
    }

    /// The settings of a draw, with their places in the study file.
    pub fn settings(&self, draw: u64) -> impl Iterator<Item = Located<Setting>> {
        let values = self.sampler.values(draw);
        self.sampler.vary().iter().zip(values).flat_map(|(varied, value)| settings(varied, value))
    }
}

/// The settings that a value of a parameter makes.
pub fn settings(varied: &Varied, value: Value) -> impl Iterator<Item = Located<Setting>> {
    varied.targets.iter().map(move |(target, sign)| {
        let value = match &value {
            Value::Real(number) => Value::Real(sign * number),
            Value::Integer(number) if *sign < 0.0 => Value::Integer(-number),
            other => other.clone(),
        };
        Located { item: Setting::new(target.clone(), value), place: Some(varied.place.clone()) }
    })
}

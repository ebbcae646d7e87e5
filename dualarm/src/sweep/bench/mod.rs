//! Where runs are made: the FMUs of a study, opened once.

mod setup;

use std::collections::BTreeSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::figures::{Gauge, Wanted};
use super::plan::Plan;
use super::study::{Method, Source};
use super::{Figure, Row, Status, SweepError};
use crate::TOOL;
use crate::grasp::matrix::Lab;
use fmi2_cosim::record::FileSink;
use fmi2_cosim::run::Run;
use fmi2_cosim::ssp::Package;
use fmi2_cosim::ssp::package::{is_ssp, split_variant};
use fmi2_cosim::system::{Located, System};
use fmi2_import::Fmu;
use setup::{case, check, track, wanted};

/// The FMUs of a study and how they run.
pub struct Bench {
    plan: Plan,
    /// One for each controller, or one.
    tracks: Vec<Track>,
    wanted: Wanted,
    /// The files that the results depend on.
    files: Vec<PathBuf>,
    /// Unpacked FMUs of an SSP vanish with it.
    _package: Option<Package>,
}

struct Track {
    system: System,
    run: Run,
}

impl Bench {
    /// Opens the FMUs of a plan, those without a path from the folder `fmus`, and checks that every name exists.
    ///
    /// # Errors
    /// When an FMU or a name cannot be used, so that no run could.
    pub fn open(plan: Plan, fmus: &Path) -> Result<Self, SweepError> {
        let study = &plan.study;
        let mut files = BTreeSet::new();
        let mut package = None;
        let mut systems = Vec::new();
        match &study.system {
            Source::Fmus(paths) => {
                let found = |path: &PathBuf| {
                    let beside = study.path(path);
                    if beside.exists() { beside } else { fmus.join(path) }
                };
                let opened = Fmu::unpack_all(&paths.iter().map(found).collect::<Vec<_>>())?;
                systems.push(System::of_fmus(&opened));
            }
            Source::Named(name) if is_ssp(Path::new(name)) => {
                let path = study.path(Path::new(name));
                let opened = Package::open(&path)?;
                files.insert(split_variant(&path).0);
                systems.push(opened.system()?);
                package = Some(opened);
            }
            Source::Named(name) => {
                let case = case(&study.path(Path::new(name)), name)?;
                if case.key.is_empty() {
                    files.insert(study.path(Path::new(name)));
                }
                if plan.contenders.is_empty() {
                    systems.push(case.scenario.system(fmus)?);
                } else {
                    let lab = Lab::new(fmus);
                    for contender in &plan.contenders {
                        systems.push(lab.system(&case, contender)?.0);
                    }
                }
            }
        }
        if package.is_some() && !plan.contenders.is_empty() {
            let message =
                "controllers take the place of a scenario's controller, but system is an SSP; write a scenario";
            return Err(SweepError::Usage(message.into()));
        }
        let mut tracks = Vec::new();
        for (index, system) in systems.into_iter().enumerate() {
            tracks.push(track(system, &plan, index)?);
        }
        let wanted = wanted(&tracks[0].system, &plan)?;
        for (index, track) in tracks.iter().enumerate() {
            check(track, &plan, index)?;
        }
        if package.is_none() {
            files
                .extend(tracks.iter().flat_map(|track| &track.system.components).map(|(_, fmu)| fmu.path().to_owned()));
        }
        files.extend(plan.points.clone());
        Ok(Self { plan, tracks, wanted, files: files.into_iter().collect(), _package: package })
    }

    /// The plan of the runs.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Names of the figures of a row.
    #[must_use]
    pub fn figures(&self) -> Vec<String> {
        self.wanted.names()
    }

    /// The files that are read, which must stay as they are.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Whether one process can have only one instance of an FMU.
    #[must_use]
    pub fn is_only_once(&self) -> bool {
        let mut fmus = self.tracks.iter().flat_map(|track| &track.system.components);
        fmus.any(|(_, fmu)| {
            let interface = fmu.description().co_simulation.as_ref();
            interface.is_some_and(|interface| interface.can_be_instantiated_only_once_per_process)
        })
    }

    /// The fingerprint of the study, so that rows of another study are not taken for its own. Files count by their content,
    /// because FMUs with the same interface may have different laws.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn fingerprint(&self) -> Result<Value, SweepError> {
        let study = &self.plan.study;
        let mut files = Vec::new();
        for path in &self.files {
            let content = fs::read(path).map_err(|source| SweepError::State { path: path.clone(), source })?;
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
            files.push(json!([name, content.len(), crc32fast::hash(&content)]));
        }
        // More draws of a random or Sobol sequence go on; those of the other methods are other points.
        let goes_on = matches!(study.method, Method::Random | Method::Sobol);
        let vary = self.plan.sampler.vary().iter().map(|varied| {
            json!([varied.name, format!("{:?}", varied.targets), format!("{:?}", varied.range), varied.count])
        });
        let track = |(index, track): (usize, &Track)| {
            let title = self.plan.contenders.get(index).map(|contender| contender.title.as_str());
            let settings = track.system.settings.iter().map(|setting| setting.item.to_string());
            let Run { grid, coupling, .. } = track.run;
            json!({
                "controller": title,
                "components": track.system.components.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
                "settings": settings.collect::<Vec<_>>(),
                "inputs": format!("{:?}", track.system.inputs.iter().map(|input| &input.item).collect::<Vec<_>>()),
                "connections": format!("{:?}", track.system.connections),
                "start": grid.start(), "stop": grid.stop(), "step": grid.step(), "coupling": coupling,
                "tolerance": track.system.experiment.tolerance,
            })
        };
        Ok(json!({
            "version": env!("CARGO_PKG_VERSION"),
            "seed": study.seed,
            "method": study.method,
            "coordinates": study.coordinates,
            "draws": if goes_on { None } else { Some(self.plan.sampler.draws()) },
            "vary": vary.collect::<Vec<_>>(),
            "systems": self.tracks.iter().enumerate().map(track).collect::<Vec<_>>(),
            "figures": self.figures(),
            "files": files,
        }))
    }

    /// Makes a run; `trajectory` is the file for its rows. A failure becomes the content of the row.
    #[must_use]
    pub fn run(&self, run: u64, trajectory: Option<&Path>) -> Row {
        match catch_unwind(AssertUnwindSafe(|| self.simulate(run, trajectory))) {
            Ok(Ok(row)) => row,
            Ok(Err(error)) => Row::without_figures(run, Status::Failed, error),
            Err(_) => Row::without_figures(run, Status::Failed, "the tool panicked"),
        }
    }

    fn simulate(&self, run: u64, trajectory: Option<&Path>) -> Result<Row, String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let Track { system, run: how } = &self.tracks[self.plan.entrant(run)];
        let mut master = system.master(how.coupling).map_err(|error| text(&error))?;
        for Located { item, .. } in self.plan.settings(self.plan.draw(run)) {
            master.apply(&item).map_err(|error| text(&error))?;
        }
        let columns = master.record(|name| trajectory.is_some() || self.wanted.needs(name));
        let mut rows =
            trajectory.map(|path| FileSink::new(path, &columns, TOOL)).transpose().map_err(|error| text(&error))?;
        let mut gauge = Gauge::new(&self.wanted);
        let result = how.execute(system, &mut master, &columns, &mut rows, &mut gauge, &mut |_| ());
        let results = result.map_err(|error| text(&error))?;
        if let Some(rows) = rows {
            rows.finish().map_err(|error| text(&error))?;
        }
        let (status, error) = match results.ended {
            None => (Status::Ok, None),
            Some(ended) => {
                (Status::Ended, Some(format!("{} ended it at t = {} s: {}", ended.component, ended.time, ended.source)))
            }
        };
        let figures = gauge.figures().into_iter().map(|figure| figure.map(Figure)).collect();
        Ok(Row { run, status, error, figures })
    }
}

//! From the study to systems that run, checked.

use std::path::Path;

use super::Track;
use crate::grasp::instruments;
use crate::grasp::kind::read_scenario;
use crate::grasp::matrix::{CASES, Case};
use crate::grasp::scenarios::BuiltIn;
use crate::sweep::SweepError;
use crate::sweep::figures::Wanted;
use crate::sweep::plan::{Plan, settings};
use crate::sweep::sample::SampleError;
use fmi2_cosim::files::has_extension;
use fmi2_cosim::master::Coupling;
use fmi2_cosim::names::{closest, suggestion};
use fmi2_cosim::record::Column;
use fmi2_cosim::run::Run;
use fmi2_cosim::settings::SettingError;
use fmi2_cosim::system::{Located, RunOptions, System, SystemError};
use grasp_merit::merit::SIGNALS;

/// The scenario that a study means; its key is empty if it comes from a file.
pub(super) fn case(path: &Path, name: &str) -> Result<Case, SweepError> {
    if has_extension(path, "toml") {
        let (scenario, text) = read_scenario(path)?;
        return Ok(Case { key: String::new(), scenario, text });
    }
    // As for `simulate`; names of cases are accepted, too.
    let file = match BuiltIn::find(name) {
        Ok(scenario) => scenario,
        Err(unknown) => *CASES.iter().find(|case| case.name == name).ok_or(unknown)?,
    };
    Ok(Case { key: name.to_owned(), scenario: file.scenario()?, text: file.text.to_owned() })
}

pub(super) fn track(mut system: System, plan: &Plan, index: usize) -> Result<Track, SweepError> {
    let usage = |error: &dyn std::fmt::Display| SweepError::Usage(error.to_string());
    instruments::connect(&mut system).map_err(|error| usage(&error))?;
    system.settings.extend(plan.study.parameters.iter().cloned());
    if let Some(entrant) = plan.study.entrants.get(index) {
        system.settings.extend(entrant.parameters.iter().cloned());
    }
    let (own, suggested) = (plan.study.experiment, system.experiment);
    let step = plan.contenders.get(index).and_then(|contender| contender.step);
    system.experiment = RunOptions {
        start: own.start.or(suggested.start),
        stop: own.stop.or(suggested.stop),
        step: step.or(own.step).or(suggested.step),
        tolerance: own.tolerance.or(suggested.tolerance),
        coupling: own.coupling.or(suggested.coupling),
        interval: own.interval.or(suggested.interval),
    };
    let run = Run::of(&system.experiment, &system).map_err(|error| usage(&error))?;
    Ok(Track { system, run })
}

/// The outputs that runs of a system record.
pub(super) fn wanted(system: &System, plan: &Plan) -> Result<Wanted, SweepError> {
    let outputs = &plan.study.outputs;
    let columns: Vec<Column> =
        system.master(Coupling::default()).map_err(|error| setting(plan, 0, error))?.record(|_| true);
    let names = || columns.iter().map(|column| column.name.as_str());
    for output in outputs {
        if !names().any(|name| name == output) {
            let similar: Vec<_> = closest(output, names()).into_iter().map(str::to_owned).collect();
            let message =
                format!("outputs: no FMU has an output \"{output}\" that is a number{}", suggestion(&similar));
            return Err(SweepError::Usage(message));
        }
    }
    let grasp = SIGNALS.iter().all(|signal| names().any(|name| name == *signal));
    let wanted = Wanted { grasp, outputs: outputs.clone() };
    let figures = wanted.names();
    if figures.is_empty() {
        let message = "nothing is looked at: the system is no grasp, so name outputs = [\"…\"] whose last, smallest, largest, \
                       mean and rms values each run shall report";
        return Err(SweepError::Usage(message.into()));
    }
    for bound in &plan.study.success {
        if !figures.contains(&bound.figure) {
            let similar: Vec<_> =
                closest(&bound.figure, figures.iter().map(String::as_str)).into_iter().map(str::to_owned).collect();
            let message = format!("{}: there is no figure \"{}\"{}", bound.place, bound.figure, suggestion(&similar));
            return Err(SweepError::Usage(message));
        }
    }
    if let Some(varied) = plan.sampler.vary().iter().find(|varied| figures.contains(&varied.name)) {
        let message = format!(
            "{}: {} is also the name of a figure; give it another name and write names",
            varied.place, varied.name
        );
        return Err(SweepError::Usage(message));
    }
    Ok(wanted)
}

/// Checks that every name means a variable which can be set, and that its description allows the values that are drawn, but for
/// tails of distributions. Each run checks whether the FMU accepts its values, too.
pub(super) fn check(track: &Track, plan: &Plan, index: usize) -> Result<(), SweepError> {
    let master = track.system.master(track.run.coupling).map_err(|error| setting(plan, index, error))?;
    let sampler = &plan.sampler;
    if sampler.draws() == 0 {
        return Err(SweepError::Usage("there is no run: the table of points has no row".into()));
    }
    for (parameter, varied) in sampler.vary().iter().enumerate() {
        let refusal = |value| {
            settings(varied, value).find_map(|Located { item, place }| Some((master.check(&item).err()?, place)))
        };
        for (row, value) in sampler.probes(parameter).enumerate() {
            let Some((source, place)) = refusal(value) else { continue };
            // An end that no draw reaches does no harm: a mass from 0 on.
            if sampler.drawn_ends(parameter).is_some_and(|ends| ends.into_iter().all(|end| refusal(end).is_none())) {
                continue;
            }
            return Err(match (&source, &plan.points) {
                (SettingError::Value { .. } | SettingError::Range { .. }, Some(table))
                    if sampler.is_from_table(parameter) =>
                {
                    let (table, name) = (table.display().to_string(), varied.name.clone());
                    SampleError::Cell { table, row: row + 1, name, problem: source.to_string() }.into()
                }
                _ => setting(plan, index, SystemError::Setting { place, source: Box::new(source) }),
            });
        }
    }
    Ok(())
}

fn setting(plan: &Plan, index: usize, source: SystemError) -> SweepError {
    let controller = plan.contenders.get(index).map(|contender| contender.title.clone());
    SweepError::Setting { controller, source: Box::new(source) }
}

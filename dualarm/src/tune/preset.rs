//! The result of a search: a scenario that runs with the gains (TOML), and the same as a parameter set (SSV).

use std::fmt::Write;

use super::{Best, Task};
use crate::grasp::PLANT;
use crate::grasp::matrix::contender::FOUND;
use crate::grasp::systems::origin;
use fmi2_cosim::settings::Setting;
use fmi2_cosim::ssp::parameters::{ParameterSet, ParameterValue};
use fmi2_cosim::ssp::structure::Line;
use fmi2_cosim::ssp::write;
use fmi2_import::{ModelDescription, Value};

/// A scenario of the paper's case with these gains, which `compare --controllers` accepts as a controller, too.
#[must_use]
pub fn toml(task: &Task, best: &Best, command: &str, description: &ModelDescription) -> String {
    let fmu = task.contender.fmu.display();
    let cases: Vec<_> = task.cases.iter().map(|case| case.key.as_str()).collect();
    let mut text = format!(
        "title = \"{}{FOUND}\"\ndescription = \"\"\"\nMade by: {command}\nObjective {:.4}, found by \
         evaluation {} of {} with seed {}, over the cases {}.\n\"\"\"\nfmus = [\"{PLANT}\", \"{fmu}\"]\n\n[experiment]\nstop = \
         2\nstep = 1e-3\n\n[parameters]\n",
        task.contender.title.trim_end_matches(FOUND).replace(['"', '\\'], " "),
        best.cost,
        best.evaluation,
        task.evaluations,
        task.seed,
        cases.join(", ")
    );
    for setting in fixed(task) {
        let value = match (&setting.value, real(setting, description)) {
            (_, Some(number)) => format!("{number:?}"),
            // A JSON string is a TOML string.
            (Value::Text(text), None) => serde_json::Value::from(text.as_str()).to_string(),
            (number_or_truth, None) => number_or_truth.to_string(),
        };
        let _ = writeln!(text, "{} = {value}", setting.target);
    }
    for (dimension, value) in task.dimensions.iter().zip(&best.values) {
        for name in &dimension.names {
            let _ = writeln!(text, "{name} = {value:?}");
        }
    }
    text
}

/// What is set and stays, each parameter once: what is set and varied only says where the search began, and of several values the
/// last one holds.
fn fixed(task: &Task) -> impl Iterator<Item = &Setting> {
    let settings = &task.contender.settings;
    let varied = |name: &String| task.dimensions.iter().any(|dimension| dimension.names.contains(name));
    let holds = move |(place, setting): &(usize, &Setting)| {
        !varied(&setting.target) && !settings[place + 1..].iter().any(|later| later.target == setting.target)
    };
    settings.iter().enumerate().filter(holds).map(|(_, setting)| setting)
}

/// The number that a setting gives a real parameter, also as a text of the command line.
fn real(setting: &Setting, description: &ModelDescription) -> Option<f64> {
    match description.variable(&setting.target)?.value(&setting.value) {
        Ok(Value::Real(number)) => Some(number),
        _ => None,
    }
}

/// The gains as a parameter set of the controller, with the real parameters that were set and stay.
#[must_use]
pub fn ssv(task: &Task, best: &Best, description: &ModelDescription) -> String {
    let mut set = ParameterSet {
        name: task.contender.key.clone(),
        description: Some(format!("Gains of {} from a search", description.model_name)),
        origin: origin(),
        ..ParameterSet::default()
    };
    let stay = fixed(task).filter_map(|setting| Some((&setting.target, real(setting, description)?)));
    let found = task.dimensions.iter().zip(&best.values);
    let found = found.flat_map(|(dimension, value)| dimension.names.iter().map(move |name| (name, *value)));
    for (name, value) in stay.chain(found) {
        let unit = description.variable(name).and_then(|variable| variable.unit()).map(str::to_owned);
        let declared = description.units.iter().find(|declared| Some(&declared.name) == unit.as_ref());
        if let Some(declared) = declared.filter(|unit| !set.units.iter().any(|known| known.name == unit.name)) {
            set.units.push(declared.clone());
        }
        let refers_to = declared.map(|unit| unit.name.clone()).into();
        set.parameters.push(ParameterValue {
            name: name.clone(),
            value: value.into(),
            refers_to,
            line: Line::default(),
        });
    }
    write::parameter_set(&set)
}

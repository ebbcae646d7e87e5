//! What a search leaves: a scenario that runs with the gains (TOML), and the same as a parameter set (SSV).

use std::fmt::Write;

use super::{Best, Task};
use crate::grasp::PLANT;
use crate::grasp::systems::origin;
use fmi2_cosim::ssp::parameters::{ParameterSet, ParameterValue};
use fmi2_cosim::ssp::structure::Line;
use fmi2_cosim::ssp::write;
use fmi2_import::{ModelDescription, Value};

/// A scenario of the paper's case with these gains, which `compare --controllers` takes as a controller, too.
#[must_use]
pub fn toml(task: &Task, best: &Best, command: &str) -> String {
    let fmu = task.contender.fmu.display();
    let cases: Vec<_> = task.cases.iter().map(|case| case.key.as_str()).collect();
    let mut text = format!(
        "title = \"{} with gains from a search\"\ndescription = \"\"\"\nMade by: {command}\nObjective {:.4}, found by \
         evaluation {} of {} with seed {}, over the cases {}.\n\"\"\"\nfmus = [\"{PLANT}\", \"{fmu}\"]\n\n[experiment]\nstop = \
         2\nstep = 1e-3\n\n[parameters]\n",
        task.contender.title.replace(['"', '\\'], " "),
        best.cost,
        best.evaluation,
        task.evaluations,
        task.seed,
        cases.join(", ")
    );
    // What is set and varied only says where the search began.
    let varied = |name: &String| task.dimensions.iter().any(|dimension| dimension.names.contains(name));
    for setting in task.contender.settings.iter().filter(|setting| !varied(&setting.target)) {
        let value = match &setting.value {
            // A JSON string is a TOML string.
            Value::Text(text) => serde_json::Value::from(text.as_str()).to_string(),
            number_or_truth => number_or_truth.to_string(),
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

/// The gains as a parameter set of the controller.
#[must_use]
pub fn ssv(task: &Task, best: &Best, description: &ModelDescription) -> String {
    let mut set = ParameterSet {
        name: task.contender.key.clone(),
        description: Some(format!("Gains of {} from a search", description.model_name)),
        origin: origin(),
        ..ParameterSet::default()
    };
    for (dimension, value) in task.dimensions.iter().zip(&best.values) {
        for name in &dimension.names {
            let unit = description.variable(name).and_then(|variable| variable.unit()).map(str::to_owned);
            let declared = description.units.iter().find(|declared| Some(&declared.name) == unit.as_ref());
            if let Some(declared) = declared.filter(|unit| !set.units.iter().any(|known| known.name == unit.name)) {
                set.units.push(declared.clone());
            }
            let refers_to = declared.map(|unit| unit.name.clone()).into();
            set.parameters.push(ParameterValue {
                name: name.clone(),
                value: (*value).into(),
                refers_to,
                line: Line::default(),
            });
        }
    }
    write::parameter_set(&set)
}

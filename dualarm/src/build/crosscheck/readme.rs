//! The README beside each released FMU.

use std::fmt::Write as _;

use super::{INTERVAL, STEP, SoloExperiment};
use fmi2_cosim::record::Table;
use fmi2_import::ModelDescription;

/// The page.
pub fn text(description: &ModelDescription, experiment: &SoloExperiment, inputs: &Table) -> String {
    let model = experiment.model;
    let or_none = |text: &Option<String>| text.clone().unwrap_or_else(|| "none".into());
    format!(
        "# {model}\n\n{}\n\n{}\n\n\
         | file | what it is |\n|---|---|\n\
         | `{model}.fmu` | FMI {} for co-simulation; model version {}, GUID `{}`, licence {}. It needs no licence check, \
         no installed tool and no files; `documentation/index.html` inside describes it |\n\
         | `{model}_in.csv` | all inputs; between the rows they are straight lines |\n\
         | `{model}_ref.csv` | the solution, a row every {INTERVAL} s |\n\
         | `{model}_ref.opt` | how it was made: communication step {STEP} s from 0 s to {:?} s |\n\n\
         The solution is that of `dualarm`, the master of the project the FMU comes from, which hands over the slopes of \
         the inputs with their values (`fmi2SetRealInputDerivatives`): {model} interpolates them exactly. An importer that \
         holds the inputs over each step is half a step late; if it reads outputs before it hands over the inputs of the \
         same instant, outputs that follow inputs at once are a whole step late.\n\n\
         ## Inputs\n\n{}\n## Outputs\n\n{}\n\
         Exported by {}. Made with `dualarm package --cross-check`. Licence: {}.\n",
        or_none(&description.description),
        experiment.story,
        description.fmi_version,
        or_none(&description.version),
        description.guid,
        or_none(&description.license),
        experiment.stop,
        variables(description, inputs.columns().iter().map(|column| column.name.as_str())),
        variables(description, experiment.outputs.iter().copied()),
        or_none(&description.generation_tool),
        or_none(&description.license),
    )
}

/// A table of variables.
fn variables<'a>(description: &ModelDescription, names: impl Iterator<Item = &'a str>) -> String {
    let mut text = String::from("| variable | unit | what it is |\n|---|---|---|\n");
    for name in names {
        let variable = description.variable(name);
        let unit = variable.and_then(|variable| variable.unit()).unwrap_or_default();
        let what = variable.and_then(|variable| variable.description.as_deref()).unwrap_or_default();
        let _ = writeln!(text, "| `{name}` | {unit} | {what} |");
    }
    text
}

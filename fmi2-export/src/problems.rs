//! What can be wrong with a model's declarations: everything that would make the description contradict itself, the
//! standard or XML.

use std::collections::{HashMap, HashSet};

use crate::access::{Access, EnumerationKind};
use crate::declarations::Declarations;
use crate::info::Info;
use crate::variable::{Causality, Variability, Variable};
use crate::view::Value;

/// Everything that is wrong with the declarations.
pub(crate) fn problems(declared: &mut Declarations) -> Vec<String> {
    let mut problems = Vec::new();
    info_problems(&declared.info, &mut problems);
    let starts = start_problems(declared);
    let (list, evaluations) = (&declared.list, declared.evaluations.len());
    if list.is_empty() {
        problems.push("no variables are declared".into());
    }
    if evaluations > 64 {
        problems.push(format!("{evaluations} evaluations declared, at most 64 are possible"));
    }
    let mut seen = HashMap::new();
    for (variable, start) in list.iter().zip(starts) {
        let name = &variable.name;
        if name.is_empty() || name.chars().any(char::is_control) {
            problems.push(format!("variable name {name:?} is empty or has control characters"));
        }
        if name == "time" {
            problems.push("no variable can be called time: tools record the time under this name".into());
        }
        if seen.insert(name.as_str(), variable.causality).is_some() {
            problems.push(format!("variable {name} is declared twice"));
        }
        if variable.description.is_empty() {
            problems.push(format!("variable {name} has no description"));
        }
        text_problem("variable name", name, &mut problems);
        text_problem("description", &variable.description, &mut problems);
        if variable.evaluation.is_some_and(|e| e.0 >= evaluations)
            || variable.rate.as_ref().is_some_and(|(_, e)| e.0 >= evaluations)
        {
            problems.push(format!("variable {name} names an evaluation of another model"));
        }
        let numeric = variable.unit.is_some() || variable.ramp.is_some() || variable.rate.is_some();
        if numeric && !matches!(variable.access, Access::Real(_)) {
            problems.push(format!("variable {name} is no Real: it can have no unit, ramp or rate"));
        }
        if variable.ramp.is_some() && variable.causality != Causality::Input {
            problems.push(format!("variable {name} has a ramp, but is no input"));
        }
        if variable.rate.is_some() && variable.causality != Causality::Output {
            problems.push(format!("variable {name} has a rate, but is no output"));
        }
        if variable.variability == Variability::Discrete && (variable.ramp.is_some() || variable.rate.is_some()) {
            problems.push(format!("variable {name} is discrete: it can have no ramp or rate"));
        }
        problems.extend(variable.mistakes.iter().map(|mistake| format!("variable {name}: {mistake}")));
        value_problems(variable, &mut problems);
        problems.extend(start);
    }
    for variable in list {
        for input in variable.depends_on.iter().map(|(input, _)| input).chain(&variable.starts_from) {
            if seen.get(input.as_str()) != Some(&Causality::Input) {
                problems.push(format!("variable {} depends on {input}, which is not an input", variable.name));
            }
        }
    }
    state_problems(list, &mut problems);
    unit_problems(list, &mut problems);
    enumeration_problems(list, &seen, &mut problems);
    if declared.indicators.as_ref().is_some_and(|indicators| indicators.evaluation.0 >= evaluations) {
        problems.push("the event indicators name an evaluation of another model".into());
    }
    problems
}

fn info_problems(info: &Info, problems: &mut Vec<String>) {
    if !is_c_identifier(info.name) {
        problems.push(format!("the name {:?} is not a C identifier", info.name));
    }
    if is_device(info.name) {
        problems.push(format!("no file can be called {}: Windows takes it for a device", info.name));
    }
    for text in [info.description, info.author, info.version, info.copyright, info.license] {
        text_problem("text", text, problems);
    }
    let experiment = info.default_experiment;
    let times = [experiment.start_time, experiment.stop_time];
    let positive = [Some(experiment.step_size), experiment.tolerance];
    if !(times.iter().all(|time| time.is_finite())
        && positive.iter().flatten().all(|value| value.is_finite() && *value > 0.0))
    {
        problems.push("the default experiment needs finite times, a positive step size and tolerance".into());
    }
}

/// Bounds and nominal value.
fn value_problems(variable: &Variable, problems: &mut Vec<String>) {
    let name = &variable.name;
    let (min, max) = range(variable);
    if !(min <= max && [variable.min, variable.max].iter().flatten().all(|bound| bound.is_finite())) {
        problems.push(format!("the range [{min}, {max}] of variable {name} is empty or not a number"));
    }
    let whole = |bound: &f64| bound.fract() == 0.0 && f64::from(i32::MIN) <= *bound && *bound <= f64::from(i32::MAX);
    if matches!(variable.access, Access::Integer(..)) && ![variable.min, variable.max].iter().flatten().all(whole) {
        problems.push(format!("the range [{min}, {max}] of variable {name} is not one of 32-bit integers"));
    }
    if variable.nominal.is_some_and(|nominal| !(nominal.is_finite() && nominal != 0.0)) {
        problems.push(format!("the nominal value of variable {name} is zero or not finite"));
    }
}

fn range(variable: &Variable) -> (f64, f64) {
    (variable.min.unwrap_or(f64::NEG_INFINITY), variable.max.unwrap_or(f64::INFINITY))
}

/// What is wrong with the start value of each variable that has one.
fn start_problems(declared: &mut Declarations) -> Vec<Option<String>> {
    let starts: Vec<Start> = {
        let count = declared.list.len();
        let mut defaults = declared.defaults();
        (0..count).map(|i| Start::of(defaults.value(i))).collect()
    };
    declared.list.iter().zip(starts).map(|(variable, start)| start_problem(variable, start)).collect()
}

/// A start value, as far as it can be wrong.
enum Start {
    Number(f64),
    Text(String),
    Wrong(String),
    Right,
}

impl Start {
    fn of(value: Value<'_>) -> Self {
        match value {
            Value::Real(start) => Self::Number(start),
            Value::Integer(start) => start.map_or_else(Self::Wrong, |start| Self::Number(start.into())),
            Value::Enumeration(start) => start.map_or_else(Self::Wrong, |_| Self::Right),
            Value::String(start) => Self::Text(start.to_owned()),
            Value::Boolean(_) => Self::Right,
        }
    }
}

fn start_problem(variable: &Variable, start: Start) -> Option<String> {
    let (name, (min, max)) = (&variable.name, range(variable));
    if !matches!(variable.causality, Causality::Input | Causality::Parameter) {
        return None;
    }
    match start {
        Start::Number(start) => (!(start.is_finite() && min <= start && start <= max))
            .then(|| format!("start value {start} of variable {name} is not in [{min}, {max}]")),
        Start::Text(start) => {
            let mut problems = Vec::new();
            text_problem("start value", &start, &mut problems);
            problems.pop()
        }
        Start::Wrong(why) => Some(format!("start value of variable {name}: {why}")),
        Start::Right => None,
    }
}

/// Continuous states and their time derivatives.
fn state_problems(list: &[Variable], problems: &mut Vec<String>) {
    let states: HashMap<&str, &Variable> =
        list.iter().filter(|v| v.is_state).map(|variable| (variable.name.as_str(), variable)).collect();
    let mut derivatives: HashMap<&str, &str> = HashMap::new();
    for variable in list {
        let name = &variable.name;
        let is_computed = matches!(variable.causality, Causality::Output | Causality::Local);
        let can_be_one = is_computed && variable.variability == Variability::Continuous;
        if (variable.is_state || variable.derivative_of.is_some()) && !can_be_one {
            problems.push(format!(
                "variable {name} is no continuous output or local variable: it can be no state and no derivative of one"
            ));
        }
        for state in variable.depends_on_states.iter().flatten() {
            if !states.contains_key(state.as_str()) {
                problems.push(format!("variable {name} depends on {state}, which is not a state"));
            }
        }
        let Some(of) = &variable.derivative_of else { continue };
        let Some(state) = states.get(of.as_str()) else {
            problems.push(format!("variable {name} is the derivative of {of}, which is not a state"));
            continue;
        };
        if let Some(other) = derivatives.insert(of, name) {
            problems.push(format!("variables {other} and {name} are both the derivative of {of}"));
        }
        if let (Some(unit), Some(rate)) = (&state.unit, &variable.unit)
            && !rate.is_per_second_of(unit)
        {
            let (unit, rate) = (unit.name(), rate.name());
            problems.push(format!("the unit {rate} of {name} is not that of {of}, {unit}, per second"));
        }
    }
    for name in states.keys().filter(|name| !derivatives.contains_key(**name)) {
        problems.push(format!("state {name} has no derivative"));
    }
}

fn unit_problems(list: &[Variable], problems: &mut Vec<String>) {
    let factor_is_wrong = |factor: f64| !(factor.is_finite() && factor != 0.0);
    let mut units = HashMap::new();
    let mut display_units = HashMap::new();
    for variable in list {
        if let Some(unit) = &variable.unit {
            if *units.entry(unit.name()).or_insert(unit) != unit {
                problems.push(format!("unit {} is defined in two ways", unit.name()));
            }
            if factor_is_wrong(unit.factor) || !unit.offset.is_finite() {
                problems.push(format!("unit {} has no usable factor or offset", unit.name()));
            }
            text_problem("unit", unit.name(), problems);
        }
        if let Some(display) = &variable.display_unit {
            match &variable.unit {
                None => problems.push(format!("variable {} has a display unit, but no unit", variable.name)),
                Some(unit) => {
                    let key = (unit.name(), display.name.as_str());
                    if display_units.insert(key, display.factor).is_some_and(|factor| factor != display.factor) {
                        problems.push(format!("display unit {} of {} is defined in two ways", key.1, key.0));
                    }
                }
            }
            if factor_is_wrong(display.factor) {
                problems.push(format!("display unit {} has no usable factor", display.name));
            }
            text_problem("display unit", &display.name, problems);
        }
    }
}

fn enumeration_problems(list: &[Variable], variables: &HashMap<&str, Causality>, problems: &mut Vec<String>) {
    let mut kinds: HashMap<&str, EnumerationKind> = HashMap::new();
    for variable in list {
        let Access::Enumeration(.., kind) = &variable.access else { continue };
        if let Some(known) = kinds.insert(kind.name, *kind) {
            if known != *kind {
                problems.push(format!("enumeration {} is defined in two ways", kind.name));
            }
            continue;
        }
        if variables.contains_key(kind.name) {
            problems.push(format!("{} is both an enumeration and a variable", kind.name));
        }
        let names: HashSet<&str> = kind.items.iter().map(|(name, _)| *name).collect();
        if names.len() != kind.items.len() || names.is_empty() {
            problems.push(format!("enumeration {} has no items, or two of the same name", kind.name));
        }
        for text in [kind.name, kind.description].into_iter().chain(kind.items.iter().flat_map(|i| [i.0, i.1])) {
            text_problem("text of an enumeration", text, problems);
        }
    }
}

/// Some characters cannot be in XML 1.0, in whatever way they are escaped.
fn text_problem(what: &str, text: &str, problems: &mut Vec<String>) {
    let allowed = |c: char| matches!(c, '\t' | '\n' | '\r' | ' '..='\u{fffd}' | '\u{10000}'..);
    if !text.chars().all(allowed) {
        problems.push(format!("{what} {text:?} has characters that XML does not allow"));
    }
}

/// Names that no file can have on Windows, with whatever ending.
fn is_device(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let numbered = name.strip_prefix("com").or(name.strip_prefix("lpt"));
    matches!(name.as_str(), "con" | "prn" | "aux" | "nul")
        || numbered.is_some_and(|n| n.len() == 1 && "123456789".contains(n))
}

fn is_c_identifier(name: &str) -> bool {
    let mut characters = name.chars();
    characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && characters.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_models_become_names_of_files_and_functions() {
        assert!(["Pump", "_1", "console", "com10", "com"].iter().all(|name| is_c_identifier(name) && !is_device(name)));
        assert!(["con", "NUL", "Com1", "lpt9"].iter().all(|name| is_device(name)));
        assert!(!["", "1a", "a-b", "ä", "a.b", "a/b"].iter().any(|name| is_c_identifier(name)));
    }
}

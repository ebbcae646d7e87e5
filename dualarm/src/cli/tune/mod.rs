//! `dualarm tune`

mod outcome;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use indicatif::ProgressStyle;

use super::fmus::FmuFolder;
use super::progress::Progress;
use super::tuned::Tuned;
use super::{Failure, json, matrix, numbers, print, report};
use crate::grasp::matrix::{self as cells, Case, CellError, Contender, Lab};
use crate::tune::dimension::{Dimension, DimensionError};
use crate::tune::start::Start;
use crate::tune::{Goal, Limits, Objective, Task, TuneError, preset};
use fmi2_cosim::files::FileSet;
use fmi2_cosim::names::{closest, suggestion};
use fmi2_cosim::settings::Setting;
use outcome::{document, summary};

const AFTER_HELP: &str = "\
Objective: in each case the time until forces, angles and position have settled, over the physical limit (at least \
0.1 s), or the rms force error over 2 % of the target (at least 0.4) where noise is what matters; the geometric mean of these ratios, \
with the worst one counting more. Broken limits make a ratio larger, and a missed goal counts ten times what speed does, until it is \
missed by a factor of two. A delay margin is a case: delay-2, delay-5.

The search (CMA-ES) depends on cases, parameters, limits and seed only, not on the number of workers. Interrupted, it \
goes on where it was when the same command is given again; with more evaluations, too.

Examples:
  dualarm tune --controller pd-tuned             the gains of PD, each within
                                                 a decade of where it begins: at
                                                 that controller's, or at --set
  dualarm tune -c pid -p kp=50..20000 -p kv=2..500 -p ki=5..50000 \\
    -p kp1+kp2=5..500 -p kv1+kv2=0.2..20 -p ki1+ki2=1..5000
  dualarm tune -c my_law.fmu -p gain=0.1..10 --cases undisturbed,mine.toml
  dualarm tune -c nabfc-r --max-torque 1 --evaluations 1000 --seed 3
  dualarm tune -c pid --cases undisturbed,long,noise --worst 0 \\
    --goal undisturbed=0.2/2,long=0.9/10,noise=7e-3
                                                 what must hold: settled within
                                                 0.2 s at 2 % of overshoot,
                                                 0.9 s at 10 %, 7 mN under noise
  dualarm compare --controllers results/tuned-pid.toml,pid
                                                 what came of it, in every case";

/// The cases a controller is tuned for unless the user names others: one of each kind.
const DEFAULT_CASES: [&str; 11] = [
    "undisturbed",
    "hub-torque",
    "object-force",
    "dead-zones",
    "light",
    "heavy-5",
    "short",
    "long",
    "stiff",
    "delay-2",
    "noise",
];

/// Arguments of `dualarm tune`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Controller: a name as for `simulate --controller`, a preset or scenario (.toml), or a controller FMU (.fmu)
    #[arg(long, short, value_name = "CONTROLLER")]
    controller: String,
    /// Vary this parameter; repeatable [default: all tunable gains that begin at a positive value, arms alike]
    #[arg(long = "parameter", short, value_name = "NAME[+NAME…][=LOW..HIGH[:linear]]")]
    parameters: Vec<String>,
    /// Give a parameter of the controller another value, which stays, or from which the search begins if it varies; repeatable
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    settings: Vec<Setting>,
    /// End every case at this time in s at the latest: a search does not need to see how long nothing happens
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    stop: Option<f64>,
    /// Judge it in these cases: names of the files in scenarios/matrix, or scenario files (.toml); one that is named twice counts twice [default: one of each kind]
    #[arg(long, value_name = "CASE", value_delimiter = ',')]
    cases: Vec<String>,
    /// What must hold in a case: settled in VALUE seconds, or an rms error of VALUE newtons where noise is what matters, with
    /// at most OVERSHOOT % of the forces' target [default: as --max-overshoot]; repeatable
    #[arg(long = "goal", value_name = "CASE=VALUE[/OVERSHOOT]", value_delimiter = ',')]
    goals: Vec<String>,
    /// How often to evaluate the objective
    #[arg(long, default_value_t = 400, value_name = "COUNT", value_parser = numbers::count)]
    evaluations: usize,
    /// Seed of the search
    #[arg(long, default_value_t = 1, value_name = "NUMBER", value_parser = numbers::index)]
    seed: u64,
    /// How much the worst case counts beside the mean of all, from 0 to 1
    #[arg(long, default_value_t = 0.3, value_name = "SHARE", value_parser = share)]
    worst: f64,
    /// Largest overshoot of the forces in %
    #[arg(long, default_value_t = 2.0, value_name = "PERCENT", value_parser = positive)]
    max_overshoot: f64,
    /// Largest torque of a hub in N.m [default: what the plant allows]
    #[arg(long, value_name = "TORQUE", value_parser = positive)]
    max_torque: Option<f64>,
    /// Longest time of an actuator at its limits in s
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    max_saturated: Option<f64>,
    /// Largest tension between arm and object in N: contact is kept
    #[arg(long, value_name = "FORCE", value_parser = positive)]
    max_tension: Option<f64>,
    /// Threads [default: as many as there are processors]
    #[arg(long, value_name = "COUNT", value_parser = numbers::count)]
    workers: Option<usize>,
    /// Write the preset to this file, as a scenario, and beside it as .ssv [default: results/tuned-CONTROLLER.toml]
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Keep the state of the search in this file [default: beside the preset]
    #[arg(long, value_name = "FILE")]
    state: Option<PathBuf>,
    /// Write a page to this file (.html): the first case before and after, gains, cases, the way of the search; missing folders
    /// are created
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    #[command(flatten)]
    folder: FmuFolder,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    let value = numbers::number(text)?;
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err("a positive number is needed".into()) }
}

fn share(text: &str) -> Result<f64, String> {
    let value = numbers::number(text)?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err("a number from 0 to 1 is needed".into()) }
}

/// The goal of each case.
fn goals(texts: &[String], cases: &[Case]) -> Result<Vec<Option<Goal>>, Failure> {
    let mut goals = vec![None; cases.len()];
    for text in texts {
        let refuse = |problem: &str| {
            Failure::usage(format!(
                "--goal {text}: {problem}; write CASE=VALUE or CASE=VALUE/OVERSHOOT, as undisturbed=0.2/2"
            ))
        };
        let (key, goal) = text.split_once('=').ok_or_else(|| refuse("there is no \"=\""))?;
        let (value, overshoot) = goal.split_once('/').map_or((goal, None), |(value, rest)| (value, Some(rest)));
        let number = |text: &str| positive(text.trim()).map_err(|problem| refuse(&problem));
        let goal = Goal { value: number(value)?, overshoot: overshoot.map(number).transpose()? };
        let mut places = (0..cases.len()).filter(|case| cases[*case].key == key.trim()).peekable();
        if places.peek().is_none() {
            let similar = closest(key.trim(), cases.iter().map(|case| case.key.as_str()));
            let similar: Vec<String> = similar.into_iter().map(str::to_owned).collect();
            return Err(refuse(&format!("the search has no case of this name{}", suggestion(&similar))));
        }
        for case in places {
            if goals[case].replace(goal).is_some_and(|other| other != goal) {
                return Err(refuse("this case has another goal already"));
            }
        }
    }
    Ok(goals)
}

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    let begin = Instant::now();
    let lab = Lab::new(&arguments.folder.fmus);
    let task = task(arguments, &lab)?;
    if let Some(page) = &arguments.report {
        report::check(page, &[])?;
    }
    task.check(&lab)?;
    if let Some(out) = arguments.out.as_ref().filter(|out| out.extension().is_none_or(|extension| extension != "toml"))
    {
        let out = out.display();
        return Err(Failure::usage(format!(
            "cannot write the gains to {out}: its name must end in .toml, as other commands ask for ({out}.toml, say)"
        )));
    }
    let key = &task.contender.key;
    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from(format!("results/tuned-{key}.toml")));
    let state = arguments.state.clone().unwrap_or_else(|| out.with_extension("jsonl"));
    let workers = arguments.workers.unwrap_or_else(cells::workers);
    let bar = Progress::new(quiet).bar(&task.contender.title, task.evaluations as u64);
    let style = ProgressStyle::with_template("{prefix:<22} {bar:36.cyan/dim} {percent:>3} %  {eta}  {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("━━─"));
    let mut history = Vec::new();
    let best = task.run(&lab, &state, workers, &mut |evaluation, best| {
        history.push(best.cost);
        bar.set_position(evaluation as u64);
        bar.set_message(format!("best {:.4}", best.cost));
    })?;
    bar.finish_and_clear();

    let fmu = lab.fmu(&task.contender.fmu).map_err(CellError::from)?;
    let results = FileSet::new();
    results.write(&out, preset::toml(&task, &best, &command(arguments, &task).join(" "), fmu.description()))?;
    results.write(out.with_extension("ssv"), preset::ssv(&task, &best, fmu.description()))?;
    results.appear()?;
    let found = task.cells(&lab, &best.values, workers)?;
    if let Some(path) = &arguments.report {
        let (task, lab, best) = (&task, &lab, &best);
        let command = command(arguments, task).join(" \\\n  ");
        Tuned { task, lab, best, found: &found, history: &history, command }.write(path)?;
    }
    let seconds = begin.elapsed().as_secs_f64();
    if arguments.json {
        return json::print(&document(&task, &best, &found, seconds, &out));
    }
    if !quiet {
        print(&summary(&task, &best, &found));
        let page = arguments.report.as_ref().map(|page| format!(", {}", page.display())).unwrap_or_default();
        print(&format!("{} and .ssv{page}, in {seconds:.1} s\n", out.display()));
    }
    Ok(())
}

fn task(arguments: &Arguments, lab: &Lab) -> Result<Task, Failure> {
    if arguments.evaluations == 0 {
        return Err(Failure::usage("--evaluations must be at least 1"));
    }
    let mut contender = Contender::find(&arguments.controller)?;
    let fmu = lab.fmu(&contender.fmu).map_err(CellError::from)?;
    let description = fmu.description();
    let start = Start::new(description, &contender.settings, &arguments.settings);
    contender.settings = start.settings().cloned().collect();
    let mut dimensions = if arguments.parameters.is_empty() {
        // The two laws of NABFC have separate gains in one FMU; a controller without a choice of laws uses all its gains.
        let has_laws = description.variables.iter().any(|variable| variable.name == "law");
        Dimension::gains(&start, |name| !has_laws || name.starts_with("r_") == start.is_root_strain())?
    } else {
        let parse = |text: &String| Dimension::parse(text, &start);
        arguments.parameters.iter().map(parse).collect::<Result<_, _>>()?
    };
    // If a parameter is both set and varied, its search begins at the set value.
    for Setting { target, value } in &contender.settings {
        let value = value.to_string().parse().ok();
        for dimension in dimensions.iter_mut().filter(|dimension| dimension.names.contains(target)) {
            dimension.begin(value);
        }
    }
    let named = DEFAULT_CASES.map(str::to_owned);
    let mut cases = matrix::cases(if arguments.cases.is_empty() { &named } else { &arguments.cases })?;
    for case in &mut cases {
        let stop = &mut case.scenario.experiment.stop;
        *stop = arguments.stop.map_or(*stop, |latest| Some(stop.map_or(latest, |stop| stop.min(latest))));
    }
    let limits = Limits {
        overshoot: arguments.max_overshoot,
        torque: arguments.max_torque,
        saturated: arguments.max_saturated,
        tension: arguments.max_tension,
    };
    let goals = goals(&arguments.goals, &cases)?;
    let objective = Objective { worst: arguments.worst, limits, goals };
    Ok(Task { contender, dimensions, cases, objective, evaluations: arguments.evaluations, seed: arguments.seed })
}

/// The command that repeats the search, option by option.
fn command(arguments: &Arguments, task: &Task) -> Vec<String> {
    let mut words = vec![format!("dualarm tune --controller {}", arguments.controller)];
    words.extend(task.dimensions.iter().map(|dimension| format!("--parameter {dimension}")));
    words.extend(arguments.settings.iter().map(|setting| format!("--set {setting}")));
    if !arguments.cases.is_empty() {
        words.push(format!("--cases {}", arguments.cases.join(",")));
    }
    words.extend(arguments.stop.map(|stop| format!("--stop {stop}")));
    if !arguments.goals.is_empty() {
        words.push(format!("--goal {}", arguments.goals.join(",")));
    }
    words
        .push(format!("--evaluations {} --seed {} --worst {}", arguments.evaluations, arguments.seed, arguments.worst));
    words.push(format!("--max-overshoot {}", arguments.max_overshoot));
    let limits =
        [("torque", arguments.max_torque), ("saturated", arguments.max_saturated), ("tension", arguments.max_tension)];
    words.extend(limits.iter().filter_map(|(name, limit)| Some(format!("--max-{name} {}", (*limit)?))));
    for word in &mut words {
        word.retain(|letter| !['"', '\\'].contains(&letter));
    }
    words
}

impl From<TuneError> for Failure {
    fn from(error: TuneError) -> Self {
        match error {
            TuneError::Cell(error) => error.into(),
            TuneError::Dimension(error) => error.into(),
            error => Self::failed(error),
        }
    }
}

impl From<DimensionError> for Failure {
    fn from(error: DimensionError) -> Self {
        Self::usage(error)
    }
}

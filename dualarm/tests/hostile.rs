//! FMUs that misbehave towards the process they are loaded into: results are kept, nothing is lost in silence, exit codes
//! tell. The slave is `fixtures/hostile.c`.
#![cfg(unix)]

#[path = "../../fmi2-import/tests/support/mod.rs"]
mod support;

use std::fs;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;
use support::archive;
use tempfile::TempDir;

/// The description of the slave, as a model of this name.
fn description(model: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="hostile">
  <CoSimulation modelIdentifier="Hostile" canHandleVariableCommunicationStepSize="true"/>
  <UnitDefinitions><Unit name="rad"><BaseUnit rad="1"/></Unit>
    <Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit><Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="slow" value="1"/><Item name="fast" value="2"/></Enumeration></SimpleType></TypeDefinitions>
  <DefaultExperiment stopTime="1" stepSize="0.1" tolerance="1e-5"/>
  <ModelVariables>
    <ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="tolerance" valueReference="1" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="u" valueReference="2" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="words" valueReference="0" causality="output" variability="discrete"><String/></ScalarVariable>
    <!-- more -->
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="1"/><Unknown index="2"/><Unknown index="4"/></Outputs></ModelStructure>
</fmiModelDescription>"#
    )
}

/// Compiles the slave; `None` (with a message) without a C compiler.
fn library() -> Option<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/hostile.c");
    let library = folder.path().join("hostile.so");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let mut command = Command::new(&compiler);
    match command.args(["-shared", "-fPIC", "-O1", "-o"]).arg(&library).arg(source).output() {
        Err(error) => {
            eprintln!("SKIPPED: the C compiler \"{compiler}\" cannot be run ({error})");
            None
        }
        Ok(output) => {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            Some(fs::read(library).unwrap())
        }
    }
}

/// A folder with FMUs of these models, their variables changed by `change`, and a folder for temporary files.
fn fixtures(models: &[&str], change: impl Fn(&str, String) -> String) -> Option<TempDir> {
    let library = library()?;
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("tmp")).unwrap();
    for model in models {
        let entry = format!("binaries/{}/Hostile{}", fmi2_import::platform(), std::env::consts::DLL_SUFFIX);
        let description = change(model, description(model));
        let entries = [("modelDescription.xml", description.as_bytes()), (entry.as_str(), library.as_slice())];
        archive(&folder.path().join(format!("{model}.fmu")), &entries);
    }
    Some(folder)
}

fn hostile() -> Option<TempDir> {
    fixtures(&["Hostile"], |_, text| text)
}

fn command(folder: &Path, behaviour: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dualarm"));
    command.current_dir(folder).env("HOSTILE", behaviour).env("TMPDIR", folder.join("tmp")).args(arguments);
    command
}

fn run(folder: &Path, behaviour: &str, arguments: &[&str]) -> Output {
    command(folder, behaviour, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The times of a CSV file, as they are written.
fn times(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    text.lines().skip(1).map(|line| line.split(',').next().unwrap().to_owned()).collect()
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_slave_that_ends_the_simulation_leaves_its_results() {
    let Some(folder) = hostile() else { return };
    let done = run(folder.path(), "end", &["simulate", "Hostile.fmu", "-o", "a.csv", "--interval", "0.2"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(text(&done.stdout).contains("Hostile ended the simulation at t = 0.5 s"), "{}", text(&done.stdout));
    assert_eq!(times(&folder.path().join("a.csv")), ["0", "0.2", "0.4", "0.5"]);

    let done = run(folder.path(), "end", &["simulate", "Hostile.fmu", "-o", "a.csv", "--interval", "0", "--json"]);
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["ended"]["component"], "Hostile");
    assert_eq!((&document["ended"]["time"], &document["final"]["y"]), (&Value::from(0.5), &Value::from(0.5)));
    assert_eq!(times(&folder.path().join("a.csv")), ["0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
    assert_eq!(document["experiment"]["steps"], 5, "those that were done");
    let done = run(folder.path(), "end", &["simulate", "Hostile.fmu"]);
    assert!(text(&done.stdout).contains("5 steps of 0.1 s up to t = 0.5 s"), "{}", text(&done.stdout));
}

#[test]
fn nobody_gets_further_than_the_step_leads() {
    let Some(folder) = hostile() else { return };
    let done =
        run(folder.path(), "end,boast", &["simulate", "Hostile.fmu", "-o", "a.csv", "--interval", "0", "--json"]);
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!((&document["ended"]["time"], &document["final"]["y"]), (&Value::from(0.5), &Value::from(0.5)));
    assert!(document["warnings"][0].as_str().unwrap().contains("says that it got to t = 1000000 s"), "{document}");
    assert_eq!(times(&folder.path().join("a.csv")).last().unwrap(), "0.5");
}

#[test]
fn tolerances_that_are_none_are_said() {
    for wrong in ["0", "-1", "NaN", "INF"] {
        let with = |_: &str, text: String| text.replace("tolerance=\"1e-5\"", &format!("tolerance=\"{wrong}\""));
        let Some(folder) = fixtures(&["Hostile"], with) else { return };
        let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--json"]);
        assert!(done.status.success(), "{}", text(&done.stderr));
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(document["final"]["tolerance"], -1.0, "{wrong}: the slave is given none");
        assert!(document["warnings"][0].as_str().unwrap().contains("is no positive number"), "{document}");
        let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--json", "--tolerance", "1e-3"]);
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(
            (&document["final"]["tolerance"], &document["warnings"]),
            (&Value::from(1e-3), &Value::Array(vec![]))
        );
    }
}

/// Values that no computation with another environment gives: a third in steps, the smallest numbers.
#[test]
fn the_floating_point_environment_is_the_tools_own() {
    let Some(folder) = fixtures(&["Hostile"], |_, text| text.replace("name=\"u\"", "name=\"v\"")) else { return };
    let rows = |behaviour: &str| {
        let arguments = ["simulate", "Hostile.fmu", "--set", "v=1e-310", "--stop", "1", "--step", "0.03", "-o", "-"];
        let done = run(folder.path(), behaviour, &[&arguments[..], &["--interval", "0"]].concat());
        assert!(done.status.success(), "{behaviour}: {}", text(&done.stderr));
        text(&done.stdout)
    };
    let usual = rows("");
    for behaviour in ["upward", "flush", "trap", "upward,flush,trap"] {
        // The slave adds times itself, in the environment that it wants.
        let times = |rows: &str| rows.lines().map(|row| row.split(',').next().unwrap().to_owned()).collect::<Vec<_>>();
        assert_eq!(times(&rows(behaviour)), times(&usual), "{behaviour}");
    }
}

#[test]
fn new_files_have_the_permissions_that_the_user_wants() {
    use std::os::unix::fs::PermissionsExt;
    let Some(folder) = hostile() else { return };
    let mode = |behaviour: &str, file: &str| {
        let done = run(folder.path(), behaviour, &["simulate", "Hostile.fmu", "-o", file]);
        assert!(done.status.success(), "{}", text(&done.stderr));
        let file = folder.path().join(file);
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        (mode(&file), mode(file.parent().unwrap()))
    };
    assert_eq!(mode("", "one/a.csv"), mode("umask", "two/a.csv"));
}

#[test]
fn the_tolerance_is_that_of_the_option_or_the_scenario_or_the_fmu() {
    let Some(folder) = hostile() else { return };
    let tolerance = |what: &str, options: &[&str]| {
        let done = run(folder.path(), "", &[&["simulate", what, "--json"], options].concat());
        assert!(done.status.success(), "{}", text(&done.stderr));
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        document["final"]["tolerance"].as_f64().unwrap()
    };
    assert_eq!(tolerance("Hostile.fmu", &[]), 1e-5);
    assert_eq!(tolerance("Hostile.fmu", &["--tolerance", "1e-7"]), 1e-7);
    let scenario = "title = \"t\"\nfmus = [\"Hostile.fmu\"]\n[experiment]\ntolerance = 1e-6\n";
    fs::write(folder.path().join("s.toml"), scenario).unwrap();
    assert_eq!(tolerance("s.toml", &[]), 1e-6);
    assert_eq!(tolerance("s.toml", &["--tolerance", "1e-8"]), 1e-8);
    for wrong in ["0", "-1", "nan", "inf"] {
        let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--tolerance", wrong]);
        assert_eq!(done.status.code(), Some(2), "{wrong}");
        assert!(text(&done.stderr).contains("the tolerance must be a positive number"));
    }
}

#[test]
fn messages_arrive_whatever_environment_the_slave_hands_back() {
    let Some(folder) = hostile() else { return };
    let done = run(folder.path(), "odd-environment", &["simulate", "Hostile.fmu", "--json"]);
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    let warnings: Vec<_> = document["warnings"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
    assert_eq!(warnings, ["Hostile: from nowhere", "Hostile: from one", "Hostile: from two"]);
}

#[test]
fn results_are_where_the_user_wants_them_whatever_the_current_folder_becomes() {
    let Some(folder) = fixtures(&["Hostile", "Second"], |_, text| text.replace("name=\"u\"", "name=\"v\"")) else {
        return;
    };
    let arguments = ["simulate", "Hostile.fmu", "Second.fmu", "-o", "out/a.csv"];
    let done = run(folder.path(), "chdir", &arguments);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert_eq!(times(&folder.path().join("out/a.csv")).len(), 11);
    assert_eq!(files(&folder.path().join("tmp")), [""; 0], "temporary files are gone");
}

#[test]
fn standard_output_is_the_tools_alone() {
    let Some(folder) = hostile() else { return };
    for behaviour in ["print", "print,close", "close"] {
        let rows = run(folder.path(), behaviour, &["simulate", "Hostile.fmu", "-o", "-"]);
        assert!(rows.status.success(), "{behaviour}: {}", text(&rows.stderr));
        assert_eq!(text(&rows.stdout).lines().count(), 12, "{behaviour}");
        assert!(!text(&rows.stdout).contains("NOISE"));
        let json = run(folder.path(), behaviour, &["simulate", "Hostile.fmu", "--json", "-o", "a.csv"]);
        assert_eq!(serde_json::from_slice::<Value>(&json.stdout).unwrap()["command"], "simulate", "{behaviour}");
    }
    let done = run(folder.path(), "print", &["simulate", "Hostile.fmu", "-o", "-"]);
    assert!(text(&done.stderr).contains("NOISE"), "what FMUs print is not lost");
}

#[test]
fn a_standard_output_that_is_closed_is_a_failure() {
    let Some(folder) = hostile() else { return };
    let runs: [&[&str]; 6] = [
        &["--help"],
        &["--version"],
        &["simulate", "--help"],
        &["info", "Hostile.fmu"],
        &["simulate", "Hostile.fmu"],
        &["simulate", "Hostile.fmu", "-o", "-"],
    ];
    for arguments in runs {
        let mut command = command(folder.path(), "", arguments);
        let close = || {
            // SAFETY: closes a descriptor, which involves no memory.
            unsafe { libc::close(1) };
            Ok(())
        };
        // SAFETY: between fork and exec only a system call is made.
        unsafe { command.pre_exec(close) };
        let done = command.stdout(Stdio::null()).output().unwrap();
        assert_eq!(done.status.code(), Some(1), "{arguments:?}");
        assert_eq!(text(&done.stderr), "error: cannot write to standard output: it is closed\n", "{arguments:?}");
    }
    let mut quiet = command(folder.path(), "", &["simulate", "Hostile.fmu", "--quiet", "-o", "a.csv"]);
    assert!(quiet.status().unwrap().success(), "who has nothing to print needs no output");
}

#[test]
fn a_result_that_cannot_be_kept_is_a_failure() {
    let Some(folder) = hostile() else { return };
    for output in ["a.csv", "a.parquet", "-"] {
        let done = run(folder.path(), "close-all", &["simulate", "Hostile.fmu", "-o", output]);
        assert!(!done.status.success(), "{output}: {}", text(&done.stdout));
        assert!(!folder.path().join(output).exists());
    }
}

#[test]
fn a_finished_result_survives_the_end_of_the_fmu_and_the_exit_code_tells() {
    let Some(folder) = hostile() else { return };
    let ends = [
        ("exit-terminate", "an FMU ended the process"),
        ("exit-free", "an FMU ended the process"),
        ("fail-terminate", "fmi2Terminate returned fmi2Error"),
        ("hang-terminate", "did not end within 10s; the results are complete"),
        ("hang-free", "did not end within 10s; the results are complete"),
        ("_exit-terminate", "an FMU ended the process"),
        ("_exit-free", "an FMU ended the process"),
        ("abort-free", "an FMU crashed the process (SIGABRT)"),
        ("crash-free", "an FMU crashed the process (SIGSEGV)"),
        ("hang-at-exit", "did not let the process end within 10s"),
    ];
    thread::scope(|scope| {
        for (behaviour, expected) in ends {
            let folder = folder.path();
            scope.spawn(move || {
                let file = format!("{behaviour}.csv");
                let done = run(folder, behaviour, &["simulate", "Hostile.fmu", "--json", "-o", &file]);
                assert_eq!(done.status.code(), Some(1), "{behaviour}");
                assert!(text(&done.stderr).contains(expected), "{behaviour}: {}", text(&done.stderr));
                assert_eq!(times(&folder.join(file)).len(), 11, "{behaviour}");
                assert!(serde_json::from_slice::<Value>(&done.stdout).is_ok(), "{behaviour}");
            });
        }
    });
}

#[test]
fn an_fmu_that_exits_early_is_a_failure_and_leaves_nothing() {
    let Some(folder) = hostile() else { return };
    for (behaviour, expected) in [
        ("exit-step", "an FMU ended the process"),
        ("_exit-step", "an FMU ended the process"),
        ("abort-step", "an FMU crashed the process (SIGABRT)"),
        ("crash-step", "an FMU crashed the process (SIGSEGV)"),
        ("crash-step,close-all", "an FMU crashed the process"),
    ] {
        let done = run(folder.path(), behaviour, &["simulate", "Hostile.fmu", "-o", "out/a.csv"]);
        assert_eq!(done.status.code(), Some(1), "{behaviour}");
        assert!(text(&done.stderr).contains(expected), "{behaviour}: {}", text(&done.stderr));
        assert_eq!(files(folder.path()), ["Hostile.fmu", "tmp"], "{behaviour}");
        assert_eq!(files(&folder.path().join("tmp")), [""; 0], "{behaviour}");
    }
}

#[test]
fn what_the_descriptions_tell_is_found_before_code_runs() {
    let Some(folder) = fixtures(&["Hostile"], |_, text| {
        let more = r#"<ScalarVariable name="k" valueReference="2" causality="parameter" variability="fixed"><Real start="1" min="0" max="2"/></ScalarVariable>
        <ScalarVariable name="n" valueReference="9" causality="parameter" variability="fixed"><Integer start="1" min="1"/></ScalarVariable>"#;
        text.replace("canHandleVariableCommunicationStepSize=\"true\"", "").replace("<!-- more -->", more)
    }) else {
        return;
    };
    let mark = folder.path().join("mark");
    let scenario = "title = \"t\"\nfmus = [\"Hostile.fmu\"]\n[parameters]\nk = 3\n";
    fs::write(folder.path().join("s.toml"), scenario).unwrap();
    for (arguments, code, expected) in [
        (&["Hostile.fmu", "--set", "kk=1"][..], 2, "there is no variable \"kk\""),
        (&["Hostile.fmu", "--set", "k=fast"], 2, "Hostile.k needs a number, not \"fast\""),
        (&["Hostile.fmu", "--set", "k=-1"], 2, "Hostile.k must be from 0 to 2, not -1"),
        (&["Hostile.fmu", "--set", "n=0"], 2, "Hostile.n must be at least 1, not 0"),
        (&["Hostile.fmu", "--set", "n=0.5"], 2, "Hostile.n needs an integer"),
        (&["Hostile.fmu", "--set", "y=1"], 2, "it is an output that the FMU computes"),
        (&["Hostile.fmu", "--stop", "-1"], 2, "must lie behind the start time"),
        (&["Hostile.fmu", "--stop", "0.95"], 1, "Hostile can only do steps of equal size"),
        (&["s.toml"], 2, "s.toml:4: Hostile.k must be from 0 to 2, not 3"),
    ] {
        let mut command = command(folder.path(), "mark", &[&["simulate"], arguments].concat());
        let done = command.env("HOSTILE_MARK", &mark).output().unwrap();
        assert_eq!(done.status.code(), Some(code), "{arguments:?}: {}", text(&done.stderr));
        assert!(text(&done.stderr).contains(expected), "{}", text(&done.stderr));
        assert!(!mark.exists(), "{arguments:?}");
    }
}

#[test]
fn info_runs_no_code_unless_asked() {
    let Some(folder) = hostile() else { return };
    let mark = folder.path().join("mark");
    let info = |options: &[&str]| {
        let mut command = command(folder.path(), "mark", &[&["info", "Hostile.fmu", "--json"], options].concat());
        let done = command.env("HOSTILE_MARK", &mark).output().unwrap();
        let document: Value = serde_json::from_slice(&done.stdout).unwrap();
        (document["runs_here"].as_bool().unwrap(), document["was_loaded"].as_bool().unwrap(), mark.exists())
    };
    assert_eq!(info(&[]), (true, false, false));
    assert_eq!(info(&["--load"]), (true, true, true));
    // It unpacks nothing either: there is no place for it.
    fs::remove_file(&mark).unwrap();
    fs::remove_dir(folder.path().join("tmp")).unwrap();
    assert_eq!(info(&[]), (true, false, false));
}

/// A run that does not end by itself, with a file under construction.
fn start(folder: &Path, behaviour: &str, arguments: &[&str]) -> Child {
    let mut command = command(folder, behaviour, arguments);
    // Whoever runs the tests in the background has them ignore interrupts, and the tool obeys that.
    let heed = || {
        for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGHUP] {
            // SAFETY: gives a signal its usual meaning, which involves no memory.
            unsafe { libc::signal(signal, libc::SIG_DFL) };
        }
        Ok(())
    };
    // SAFETY: between fork and exec only a system call is made.
    unsafe { command.pre_exec(heed) };
    let child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let deadline = Instant::now() + Duration::from_secs(60);
    let is_at_work = || files(&folder.join("out")).iter().any(|name| name.contains(".part"));
    while !(folder.join("out").exists() && is_at_work()) {
        assert!(Instant::now() < deadline, "the run does not begin");
        thread::sleep(Duration::from_millis(10));
    }
    child
}

#[test]
fn an_interrupted_run_leaves_what_was_there() {
    let Some(folder) = hostile() else { return };
    fs::create_dir(folder.path().join("out")).unwrap();
    fs::write(folder.path().join("out/a.csv"), "old").unwrap();
    let all = [("INT", 2), ("TERM", 15), ("HUP", 1)];
    let cases = all.map(|signal| ("hang-step", signal)).into_iter().chain([("hang-step,deaf", all[1])]);
    for (behaviour, (signal, number)) in cases {
        let mut child = start(folder.path(), behaviour, &["simulate", "Hostile.fmu", "-o", "out/a.csv"]);
        let kill = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
        assert!(kill.success());
        assert_eq!(child.wait().unwrap().signal(), Some(number), "a shell sees why it ended");
        assert_eq!(files(&folder.path().join("out")), ["a.csv"]);
        assert_eq!(fs::read_to_string(folder.path().join("out/a.csv")).unwrap(), "old");
        assert_eq!(files(&folder.path().join("tmp")), [""; 0], "{signal}");
    }
}

/// The process that works notices when the one that watches is killed.
#[cfg(target_os = "linux")]
#[test]
fn nothing_stays_when_the_watching_process_is_killed() {
    let Some(folder) = hostile() else { return };
    let mut child = start(folder.path(), "hang-step", &["simulate", "Hostile.fmu", "-o", "out/a.csv"]);
    child.kill().unwrap();
    assert_eq!(child.wait().unwrap().signal(), Some(9));
    let deadline = Instant::now() + Duration::from_secs(60);
    while folder.path().join("out").exists() || !files(&folder.path().join("tmp")).is_empty() {
        assert!(Instant::now() < deadline, "{:?}", files(folder.path()));
        thread::sleep(Duration::from_millis(10));
    }
}

/// One input, named as the other FMU's output `y`, with this type.
fn pair(from: &str, to: &str) -> Option<TempDir> {
    fixtures(&["From", "To"], |model, text| {
        let (own, kind) = if model == "From" { ("y", from) } else { ("u", to) };
        let variability = if kind.starts_with("Real") { "" } else { " variability=\"discrete\"" };
        let text = if model == "From" {
            text.replace("name=\"u\"", "name=\"v\"")
        } else {
            text.replace("name=\"y\"", "name=\"z\"")
                .replace("name=\"tolerance\"", "name=\"t\"")
                .replace("name=\"words\"", "name=\"w\"")
        };
        let (reference, causality) = if model == "From" { (0, "output") } else { (2, "input") };
        let former = if model == "From" { "<Real/>" } else { "<Real start=\"0\"/>" };
        let before =
            format!(r#"<ScalarVariable name="{own}" valueReference="{reference}" causality="{causality}">{former}"#);
        assert!(text.contains(&before), "{text}");
        let after = format!(
            r#"<ScalarVariable name="y" valueReference="{reference}" causality="{causality}"{variability}><{kind}/>"#
        );
        // What the input got comes out again.
        let echo = r#"<ScalarVariable name="got" valueReference="2" causality="output"><Real/></ScalarVariable>"#;
        let text = text.replace(&before, &after);
        if model == "To" { text.replace("<!-- more -->", echo) } else { text }
    })
}

#[test]
fn connections_by_name_convert_or_are_refused() {
    let Some(folder) = pair(r#"Real unit="rad""#, r#"Real start="0" unit="deg""#) else { return };
    let arguments = ["simulate", "From.fmu", "To.fmu", "--json"];
    let done = run(folder.path(), "", &arguments);
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    let got = document["final"]["got"].as_f64().unwrap();
    assert!((got - 1_f64.to_degrees()).abs() < 1e-12, "1 rad after 1 s: {got}");

    for (from, to, expected) in [
        (r#"Real unit="rad""#, r#"Real start="0" unit="N""#, "rad cannot be converted to N"),
        ("Real", r#"Integer start="0""#, "one is Real, the other Integer"),
        ("Boolean", r#"Real start="0""#, "one is Boolean, the other Real"),
    ] {
        let Some(folder) = pair(from, to) else { return };
        let done = run(folder.path(), "", &arguments);
        assert_eq!(done.status.code(), Some(1));
        let message = text(&done.stderr);
        assert!(message.contains("From.y and To.y have one name") && message.contains(expected), "{message}");
    }
}

#[test]
fn what_can_be_there_only_once_is() {
    let only_once = |_: &str, text: String| {
        text.replace("<CoSimulation ", "<CoSimulation canBeInstantiatedOnlyOncePerProcess=\"true\" ")
            .replace("name=\"u\"", "name=\"v\"")
    };
    let Some(folder) = fixtures(&["Hostile"], only_once) else { return };
    assert!(run(folder.path(), "", &["simulate", "Hostile.fmu"]).status.success());
    let twice = run(folder.path(), "", &["simulate", "Hostile.fmu", "Hostile.fmu"]);
    assert_eq!(twice.status.code(), Some(1));
    assert!(text(&twice.stderr).contains("Hostile and Hostile_2 are the same FMU"), "{}", text(&twice.stderr));
}

#[test]
fn names_of_columns_and_components_are_unique() {
    let models = |model: &str, text: String| {
        let name = if model == "Third" { "A_2" } else { "A" };
        text.replace(&format!("modelName=\"{model}\""), &format!("modelName=\"{name}\""))
            .replace("name=\"u\"", "name=\"v\"")
            .replace("name=\"y\"", "name=\"time\"")
    };
    let Some(folder) = fixtures(&["First", "Second", "Third"], models) else { return };
    let fmus = ["simulate", "First.fmu", "Second.fmu", "Third.fmu", "-o"];
    let done = run(folder.path(), "", &[&fmus[..], &["a.csv", "--json"]].concat());
    assert!(done.status.success(), "{}", text(&done.stderr));
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    let names: Vec<_> = (0..3).map(|index| document["components"][index]["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["A", "A_3", "A_2"]);
    let header = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let header = header.lines().next().unwrap();
    assert_eq!(header, "time,A.time,A.tolerance,A_3.time,A_3.tolerance,A_2.time,A_2.tolerance");
    let alone = run(folder.path(), "", &["simulate", "First.fmu", "-o", "-"]);
    assert!(text(&alone.stdout).starts_with("time,A.time,tolerance\n"));
}

#[test]
fn the_output_is_no_input_and_no_format_the_tool_does_not_write() {
    let Some(folder) = hostile() else { return };
    let before = fs::read(folder.path().join("Hostile.fmu")).unwrap();
    std::os::unix::fs::symlink("Hostile.fmu", folder.path().join("link.csv")).unwrap();
    fs::hard_link(folder.path().join("Hostile.fmu"), folder.path().join("hard.csv")).unwrap();
    for output in ["Hostile.fmu", "./Hostile.fmu", "link.csv", "hard.csv", "a.xlsx", "a.mat", "a.json"] {
        let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "-o", output]);
        assert_eq!(done.status.code(), Some(2), "{output}: {}", text(&done.stderr));
        assert_eq!(fs::read(folder.path().join("Hostile.fmu")).unwrap(), before);
    }
    let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "-o", "link.csv"]);
    assert!(text(&done.stderr).contains("would overwrite Hostile.fmu, which this run reads"), "{}", text(&done.stderr));
}

#[test]
fn what_rows_leave_out_is_said() {
    let Some(folder) = hostile() else { return };
    let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "-o", "a.csv"]);
    assert!(text(&done.stdout).contains("texts, which rows leave out (--json has their last values): words"));
    assert!(text(&done.stdout).contains("open inputs: Hostile.u"), "{}", text(&done.stdout));
    let json = run(folder.path(), "", &["simulate", "Hostile.fmu", "--json"]);
    let document: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((&document["final"]["words"], &document["texts"][0]), (&Value::from("text"), &Value::from("words")));

    let none = |_: &str, text: String| {
        text.replace("causality=\"output\"", "causality=\"local\"")
            .replace("<ModelStructure>", "<ModelStructure/><!--")
            .replace("</ModelStructure>", "-->")
    };
    let Some(folder) = fixtures(&["Hostile"], none) else { return };
    let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "-o", "a.csv"]);
    assert!(text(&done.stdout).contains("no FMU has an output that is a number: rows have only times"));
}

#[test]
fn no_control_character_of_a_file_reaches_the_terminal() {
    let odd = |_: &str, text: String| {
        text.replace(
            "modelName=\"Hostile\"",
            "modelName=\"Ho&#x9b;2J&#10;error: &#9;stile\" description=\"a&#x202e;b&#127;\"",
        )
        .replace("name=\"y\"", "name=\"y&#x85;&#13;\"")
    };
    let Some(folder) = fixtures(&["Hostile"], odd) else { return };
    let is_harmless = |bytes: &[u8]| !text(bytes).contains(|letter: char| letter.is_control() && letter != '\n');
    let runs: [&[&str]; 5] = [
        &["info", "Hostile.fmu"],
        &["info", "Hostile.fmu", "--json"],
        &["simulate", "Hostile.fmu"],
        &["simulate", "Hostile.fmu", "--json"],
        &["simulate", "Hostile.fmu", "--set", "Ho.u=1"],
    ];
    for arguments in runs {
        let done = run(folder.path(), "", arguments);
        assert!(is_harmless(&done.stdout) && is_harmless(&done.stderr), "{arguments:?}: {}", text(&done.stdout));
        assert!(!text(&done.stdout).contains('\u{202e}'));
    }
    let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--set", "Ho.u=1"]);
    assert_eq!(
        text(&done.stderr).lines().filter(|line| line.starts_with("error:")).count(),
        1,
        "no message in a message"
    );
}

/// Names of any length: wider than any format allows, and too long to be compared letter by letter.
#[test]
fn texts_of_any_length_are_read() {
    let long = "n".repeat(100_000);
    let odd = |_: &str, text: String| {
        let unit = format!("<Unit name=\"{long}\"/></UnitDefinitions>");
        text.replace("</UnitDefinitions>", &unit)
            .replace("name=\"y\"", &format!("name=\"{long}\""))
            .replace("<Real/>", &format!("<Real unit=\"{long}\"/>"))
            .replace("modelName=\"Hostile\"", &format!("modelName=\"{long}\" version=\"{long}\""))
    };
    let Some(folder) = fixtures(&["Hostile"], odd) else { return };
    for arguments in
        [&["info", "Hostile.fmu"][..], &["info", "Hostile.fmu", "--variables"], &["simulate", "Hostile.fmu"]]
    {
        let done = run(folder.path(), "", arguments);
        assert!(done.status.success(), "{arguments:?}: {}", text(&done.stderr));
    }
    let wrong = format!("{long}x=1");
    let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--set", &wrong]);
    assert_eq!(done.status.code(), Some(2));
}

#[test]
fn pipes_are_no_input() {
    let Some(folder) = hostile() else { return };
    let made = Command::new("mkfifo").current_dir(folder.path()).args(["p.fmu", "p.ssp", "p.toml"]).status();
    if !made.is_ok_and(|status| status.success()) {
        return;
    }
    for arguments in [["info", "p.fmu"], ["simulate", "p.fmu"], ["simulate", "p.ssp"], ["simulate", "p.toml"]] {
        let done = run(folder.path(), "", &arguments);
        assert!(text(&done.stderr).contains("it is a pipe or a device, not a file"), "{}", text(&done.stderr));
    }
}

/// An enumeration and an angle that are inputs, and what they got.
fn with_inputs() -> Option<TempDir> {
    let more = r#"<ScalarVariable name="mode" valueReference="9" causality="input" variability="discrete"><Enumeration declaredType="Mode" start="1"/></ScalarVariable>
    <ScalarVariable name="got" valueReference="9" causality="output" variability="discrete"><Enumeration declaredType="Mode"/></ScalarVariable>
    <ScalarVariable name="angle" valueReference="2" causality="parameter" variability="fixed"><Real start="0" unit="rad"/></ScalarVariable>
    <ScalarVariable name="turned" valueReference="2" causality="output"><Real unit="rad"/></ScalarVariable>"#;
    fixtures(&["Hostile"], |_, text| text.replace("<!-- more -->", more).replace("name=\"u\"", "name=\"v\""))
}

#[test]
fn items_of_enumerations_go_by_name_in_steps() {
    let Some(folder) = with_inputs() else { return };
    let run_steps = |points: &str| {
        let scenario = format!("title = \"t\"\nfmus = [\"Hostile.fmu\"]\n[inputs]\nmode.steps = {points}\n");
        fs::write(folder.path().join("s.toml"), scenario).unwrap();
        run(folder.path(), "", &["simulate", "s.toml", "-o", "a.csv", "--interval", "0"])
    };
    let done = run_steps(r#"[[0, "slow"], [0.45, "fast"], [0.85, 1]]"#);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let rows = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let column = rows.lines().next().unwrap().split(',').position(|name| name == "got").unwrap();
    let got: Vec<_> = rows.lines().skip(1).map(|row| row.split(',').nth(column).unwrap().to_owned()).collect();
    assert_eq!(got, ["1", "1", "1", "1", "1", "2", "2", "2", "2", "1", "1"]);
    let done = run_steps(r#"[[0, "slow"], [0.5, "quick"]]"#);
    assert_eq!(done.status.code(), Some(2));
    let message = text(&done.stderr);
    assert!(
        message.contains("s.toml:4") && message.contains("one of slow, fast is needed, not \"quick\""),
        "{message}"
    );
}

#[test]
fn numbers_may_have_their_unit_behind_them() {
    let Some(folder) = with_inputs() else { return };
    let turned = |value: &str| {
        let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--json", "--set", &format!("angle={value}")]);
        assert!(done.status.success(), "{value}: {}", text(&done.stderr));
        serde_json::from_slice::<Value>(&done.stdout).unwrap()["final"]["turned"].as_f64().unwrap()
    };
    for value in ["3deg", "3 deg", "3.0e0deg", "+3 deg"] {
        assert!((turned(value) - 3_f64.to_radians()).abs() < 1e-16, "{value}");
    }
    assert_eq!([turned("0.5rad"), turned("0.5")], [0.5, 0.5]);
    for (value, expected) in
        [("3N", "N cannot be converted to rad"), ("3 miles", "a number in rad"), ("deg", "a number in rad")]
    {
        let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--set", &format!("angle={value}")]);
        assert_eq!(done.status.code(), Some(2), "{value}");
        assert!(text(&done.stderr).contains(expected), "{}", text(&done.stderr));
    }
}

/// Forty thousand keys: the place of each is known at once. Counting lines from the start each time took 40 s.
#[test]
fn large_scenarios_are_read_in_no_time() {
    let Some(folder) = hostile() else { return };
    let keys: Vec<_> = (0..40_000).map(|index| format!("unknown_{index} = {index}\n")).collect();
    let scenario = format!("title = \"t\"\nfmus = [\"Hostile.fmu\"]\n[parameters]\n{}", keys.concat());
    fs::write(folder.path().join("s.toml"), scenario).unwrap();
    let done = run(folder.path(), "", &["simulate", "s.toml"]);
    assert!(text(&done.stderr).contains("s.toml:4: there is no variable \"unknown_0\""), "{}", text(&done.stderr));
}

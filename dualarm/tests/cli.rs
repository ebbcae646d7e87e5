//! The command line: bad input gives one clear message and a non-zero exit code, and leaves nothing half-written.

#[path = "support/program.rs"]
mod program;
#[path = "../../fmi2-import/tests/support/mod.rs"]
mod support;

use std::fs;
use std::process::{Command, Stdio};

use program::{assert_fails, dualarm, files, fixtures, simulate, text};
use serde_json::Value;
use support::package_as;

#[test]
fn a_run_writes_its_rows_and_says_what_it_did() {
    let Some(folder) = fixtures() else { return };
    let run = simulate(folder.path(), &["--set", "K=3", "--step", "0.1", "--stop", "1", "-o", "out/a.csv"]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    assert!(text(&run.stdout).starts_with("Lag + Gain: 4 signals connected,\n  10 steps of 0.1 s up to t = 1 s"));
    let csv = fs::read_to_string(folder.path().join("out/a.csv")).unwrap();
    let lines: Vec<_> = csv.lines().collect();
    assert_eq!(lines[0], "time,y,Lag.steps,y_on,u,Gain.steps,u_on");
    assert_eq!((lines.len(), lines[1]), (12, "0,0,0,0,3,0,1"));

    let piped = simulate(folder.path(), &["--quiet", "--stop", "0.3", "--interval", "0", "--output", "-"]);
    assert_eq!(text(&piped.stdout).lines().count(), 5);
    assert!(piped.stderr.is_empty());
    // A reader that leaves early has not got the result.
    let mut child = Command::new(env!("CARGO_BIN_EXE_dualarm"))
        .current_dir(folder.path())
        .args(["simulate", "Lag.fmu", "--step", "1e-4", "--interval", "0", "-o", "-"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_fails(&output, 1, "the reader of standard output has gone before it had all rows");

    let jacobi = simulate(folder.path(), &["--coupling", "jacobi", "--quiet", "--set", "Lag.label=x=y"]);
    assert!(jacobi.status.success() && jacobi.stdout.is_empty());
}

#[test]
fn bad_numbers_and_names_are_usage_errors() {
    let Some(folder) = fixtures() else { return };
    let before = files(folder.path());
    for (arguments, expected) in [
        (["--step", "0"], "step size must be a positive number of seconds, not 0"),
        (["--step", "-1e-4"], "step size must be a positive number of seconds, not -0.0001"),
        (["--step", "NaN"], "step size must be a positive number of seconds, not NaN"),
        (["--step", "fast"], "invalid value 'fast' for '--step <SECONDS>'"),
        (["--step", "1e-300"], "too small"),
        (["--stop", "0"], "stop time (0 s) must be later than the start time (0 s)"),
        (["--stop", "-1"], "must be later than the start time"),
        (["--interval", "-1"], "the interval must be 0 or more seconds"),
        (["--coupling", "newton"], "invalid value 'newton'"),
        (["--controller", "pd"], "cannot be used with"),
        (["--set", "trouble_a=1"], "no variable \"trouble_a\" in Lag or Gain; did you mean trouble_at"),
        (["--set", "Leg.T=1"], "no component \"Leg\"; the components are Lag, Gain"),
        (["--set", "Lag.T=-1"], "Lag.T must be at least 0, not -1"),
        (["--set", "Lag.T=0"], "Lag.T=0 is refused: Lag: fmi2SetReal returned fmi2Error: T = 0 must be positive"),
        (["--step", "10"], "a step of 10 s is longer than the run from 0 s to 2 s"),
        (["--set", "T"], "expected name=value"),
        (["--set", "T=fast"], "Lag.T needs a number, not \"fast\""),
        (["--set", "y=1"], "Lag.y cannot be set: it is an output that the FMU computes"),
        (["--set", "trouble=loud"], "needs one of warning, discard, error, fatal"),
        (["--colour", "red"], "unexpected argument '--colour'"),
    ] {
        let output = simulate(folder.path(), &[&arguments[..], &["-o", "out.csv"]].concat());
        assert_fails(&output, 2, expected);
    }
    assert_fails(
        &dualarm(folder.path(), &["simulate", "--controller", "lqr"]),
        2,
        "[possible values: nabfc, nabfc-fast, nabfc-r, nabfc-r-fast, nabfc-r-certified, pds, pds-tuned, pd, pd-tuned, pid, pid-all, pds-all]",
    );
    assert_fails(
        &dualarm(folder.path(), &["simulate", "--controller", "lqr"]),
        2,
        "a file is taken, too: a controller FMU (.fmu)",
    );
    let fmus = tempfile::tempdir().unwrap();
    fs::write(fmus.path().join("Lag.fmu"), "").unwrap();
    for words in [&["Lag"][..], &["Lag", "Gain"], &["Lag", "--controller", "pid-all"]] {
        let words = [&["simulate", "--fmus", fmus.path().to_str().unwrap()], words].concat();
        assert_fails(&dualarm(folder.path(), &words), 2, "there is no file Lag; did you mean");
    }
    let picture = simulate(folder.path(), &["-o", "x.png"]);
    assert_fails(&picture, 2, "-o x.png: here -o takes a .csv or .parquet file, for the outputs over time");
    assert_fails(&picture, 2, "--report x.html");
    for command in ["compare", "verify", "package"] {
        assert_fails(
            &dualarm(folder.path(), &[command, "-o", "x.png"]),
            2,
            "this is the name of a file; a folder is wanted",
        );
    }
    let said = ["compare", "--no-package", "--fmus", "nowhere", "-o", "x.png/"];
    assert_fails(&dualarm(folder.path(), &said), 1, "nowhere");
    assert_eq!(files(folder.path()), before);
}

/// A file for another command: what it is, and which command takes it.
#[test]
fn files_of_another_kind_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let study = "title = \"x\"\nsystem = \"pd\"\nmethod = \"grid\"\n[vary]\nM = [1]\n";
    fs::write(folder.path().join("study.toml"), study).unwrap();
    fs::write(folder.path().join("run.toml"), "title = \"x\"\nfmus = [\"a.fmu\"]\n").unwrap();
    let study = "this is a study: `dualarm sweep study.toml` makes its runs";
    for words in [
        &["simulate", "study.toml"][..],
        &["simulate", "--controller", "study.toml"],
        &["compare", "--no-package", "--cases", "study.toml"],
        &["tune", "-c", "study.toml"],
    ] {
        assert_fails(&dualarm(folder.path(), words), 2, study);
    }
    assert_fails(
        &dualarm(folder.path(), &["sweep", "run.toml"]),
        2,
        "this is a scenario: `dualarm simulate run.toml` runs it. A study names the scenario",
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

/// Three different mistakes that are not wrong enough to stop a run.
#[test]
fn doubtful_runs_are_warned_about() {
    let Some(folder) = fixtures() else { return };
    let warnings = |arguments: &[&str]| {
        let run = dualarm(folder.path(), &[&["simulate"], arguments].concat());
        assert!(run.status.success(), "{}", text(&run.stderr));
        text(&run.stderr)
    };
    assert_eq!(warnings(&["Lag.fmu", "Gain.fmu", "--interval", "0.2"]), "");
    let said = warnings(&["Lag.fmu", "Gain.fmu", "--interval", "0.25"]);
    assert!(said.starts_with("warning: the interval of 0.25 s is no multiple of the step of 0.1 s"), "{said}");
    let said = warnings(&["Lag.fmu", "Lag.fmu"]);
    assert!(said.contains("warning: Lag shares no signal") && said.contains("Lag_2 shares no signal"), "{said}");
}

/// A scenario file beside its FMUs, and what may be wrong with it.
#[test]
fn scenario_files_describe_runs() {
    let Some(folder) = fixtures() else { return };
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let scenario = "title = \"A loop\"\nfmus = [\"Lag.fmu\", \"Gain.fmu\"]\n\
                    [experiment]\nstop = 1\nstep = 0.1\ninterval = 0.5\ncoupling = \"jacobi\"\n\
                    [parameters]\nK = 3\n[inputs]\nreference.steps = [[0, 1], [0.5, 2]]\n";
    fs::create_dir(folder.path().join("below")).unwrap();
    write("loop.toml", scenario);
    let run = dualarm(&folder.path().join("below"), &["simulate", "../loop.toml", "-o", "out.csv"]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    assert!(text(&run.stdout).starts_with("A loop\nLag + Gain: 4 signals connected,\n  10 steps of 0.1 s"));
    let csv = fs::read_to_string(folder.path().join("below/out.csv")).unwrap();
    let times: Vec<_> = csv.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(times, ["0", "0.5", "1"]);
    // What the command line says goes before what the file says.
    let run =
        dualarm(folder.path(), &["simulate", "loop.toml", "--stop", "0.3", "--step", "0.05", "--interval", "0.1"]);
    assert!(text(&run.stdout).contains(" 6 steps of 0.05 s up to t = 0.3 s"), "{}", text(&run.stdout));

    for (from, to, code, expected) in [
        ("stop = 1", "stp = 1", 2, "error: bad.toml:4:1: unknown field `stp`"),
        ("K = 3", "k1 = 3", 2, "error: bad.toml:9: there is no variable \"k1\" in Lag or Gain"),
        ("K = 3", "K = \"3x\"", 2, "error: bad.toml:9: Gain.K needs a number, not \"3x\""),
        ("K = 3", "\"Lag.T\" = -3", 2, "error: bad.toml:9: Lag.T must be at least 0, not -3"),
        ("K = 3", "\"Lag.T\" = 0", 2, "error: bad.toml:9: Lag.T=0 is refused"),
        ("reference", "y", 2, "error: bad.toml:11: Lag.y cannot be set: only inputs can change over time"),
        (
            "stop = 1",
            "stop = -1",
            2,
            "error: bad.toml:4:8: the stop time (-1 s) must be later than the start time (0 s)",
        ),
        ("step = 0.1", "step = 0", 2, "error: bad.toml:5:8: the step size must be a positive number"),
        ("K = 3", "reference = 3", 2, "error: bad.toml:9: reference is an input: it belongs under [inputs]"),
        (
            "reference.steps = [[0, 1], [0.5, 2]]",
            "K = 3",
            2,
            "bad.toml:11: K is no input: it belongs under [parameters]",
        ),
        ("Gain.fmu", "Gone.fmu", 1, "error: there is no Gone.fmu in this folder or dist"),
    ] {
        write("bad.toml", &scenario.replacen(from, to, 1));
        assert_fails(&dualarm(folder.path(), &["simulate", "bad.toml"]), code, expected);
    }
    let run = |words: &[&str]| dualarm(folder.path(), &[&["simulate"], words].concat());
    assert_fails(&run(&["gone.toml"]), 1, "cannot read gone.toml");
    assert_fails(&run(&["loop.toml", "Lag.fmu"]), 2, "loop.toml is a scenario; it runs alone");
    assert_fails(&run(&["loop.toml", "--controller", "pd"]), 2, "this scenario runs none of NabfcController.fmu");
    assert_fails(&run(&["pre-load"]), 2, "there is no scenario \"pre-load\"; did you mean preload?");
}

#[test]
fn foreign_files_are_named() {
    let Some(folder) = fixtures() else { return };
    fs::write(folder.path().join("notes.fmu"), "no zip").unwrap();
    let run = |file: &str| dualarm(folder.path(), &["simulate", "Lag.fmu", file]);
    assert_fails(&run("notes.fmu"), 1, "notes.fmu is not an FMU: not a readable zip archive");
    assert_fails(&run("none.fmu"), 1, "cannot read none.fmu: No such file");
    assert_fails(
        &dualarm(folder.path(), &["simulate"]),
        1,
        "there is no DualArmPlant.fmu in dist; `dualarm package` makes the FMUs",
    );

    let other = tempfile::tempdir().unwrap();
    let guid = package_as(other.path(), "Lag", |description| description.replace("{fixture}", "{x}")).unwrap();
    assert_fails(&run(guid.to_str().unwrap()), 1, "refuses to be instantiated: GUID {x} is not {fixture}");
}

/// What a fixture says about itself comes back, whatever it can do on this machine.
#[test]
fn info_describes_any_fmu() {
    let Some(folder) = fixtures() else { return };
    let info = |arguments: &[&str]| {
        let run = dualarm(folder.path(), &[&["info"], arguments].concat());
        assert!(run.status.success(), "{}", text(&run.stderr));
        text(&run.stdout)
    };
    let said = info(&["Lag.fmu"]);
    for expected in [
        "Lag\n",
        "  FMI            2.0, co-simulation\n",
        "  runs here      yes\n",
        "  can            steps of any size, saved states\n",
        "  default run    to 2 s, step 0.1 s\n",
        "  variables      3 inputs, 4 outputs, 4 parameters\n",
        "trouble_at  s     1e30",
        "(warning, discard, error, fatal)",
        ">= 0",
    ] {
        assert!(said.contains(expected), "{expected:?} in {said}");
    }
    let all = info(&["Lag.fmu", "--variables"]);
    assert!(all.contains("label") && all.contains("String") && all.contains("fixture"), "{all}");

    let exchange = |text: String| {
        let structure = "<ModelStructure><Derivatives><Unknown index=\"3\"/></Derivatives>";
        text.replace("<CoSimulation modelIdentifier=\"Lag\"", "<ModelExchange modelIdentifier=\"Lag\"")
            .replace("canHandleVariableCommunicationStepSize=\"true\" ", "")
            .replace("<ModelStructure>", structure)
            .replace("guid=", "numberOfEventIndicators=\"2\" guid=")
    };
    package_as(folder.path(), "Lag", exchange).unwrap();
    let said = info(&["Lag.fmu"]);
    for expected in
        ["2.0, model exchange\n", "no: it has only the model exchange interface", "1 state, 2 event indicators"]
    {
        assert!(said.contains(expected), "{expected:?} in {said}");
    }
    package_as(folder.path(), "Lag", |text| text.replace("modelIdentifier=\"Lag\"", "modelIdentifier=\"Elsewhere\""))
        .unwrap();
    assert!(info(&["Lag.fmu"]).contains("  runs here      no: it has no binaries/"));

    let document: Value = serde_json::from_str(&info(&["Gain.fmu", "--json"])).unwrap();
    assert_eq!(document["model_name"], "Gain");
    assert_eq!(document["runs_here"], true);
    assert_eq!(document["capabilities"]["canGetAndSetFMUstate"], true);
    let trouble =
        document["variables"].as_array().unwrap().iter().find(|variable| variable["name"] == "trouble").unwrap();
    assert_eq!((&trouble["start"], trouble["items"].as_array().unwrap().len()), (&Value::from("error"), 4));

    assert_fails(&dualarm(folder.path(), &["info", "none.fmu"]), 1, "cannot read none.fmu");
    assert_fails(&dualarm(folder.path(), &["info"]), 2, "required");
}

#[test]
fn json_is_one_document_on_standard_output() {
    let Some(folder) = fixtures() else { return };
    let run =
        simulate(folder.path(), &["--json", "--set", "K=3", "--stop", "1", "-o", "out.csv", "--interval", "0.25"]);
    assert!(run.status.success() && run.stderr.is_empty(), "{}", text(&run.stderr));
    let document: Value = serde_json::from_str(&text(&run.stdout)).unwrap();
    assert_eq!(document["command"], "simulate");
    assert_eq!(document["components"][1]["name"], "Gain");
    assert_eq!(document["connections"][0]["from"], "Gain.u");
    assert_eq!(document["connections"][0]["to"], "Lag.u");
    assert_eq!(
        (&document["experiment"]["steps"], &document["experiment"]["coupling"]),
        (&Value::from(10), &"gauss-seidel".into())
    );
    assert_eq!((&document["output"], &document["metrics"]), (&Value::from("out.csv"), &Value::Null));
    let obstacle = document["metrics_obstacle"].as_str().unwrap();
    assert!(obstacle.starts_with("no single FMU has the output contact_force1 or "), "{obstacle}");
    assert_eq!(document["warnings"].as_array().unwrap().len(), 1, "the odd interval");
    // The loop's closed form y = K/(1+K)·(1 − aⁿ) with T = 1 and steps of 0.1 s, and what kind of values there are.
    let a = (-0.1_f64).exp() - 3.0 * (1.0 - (-0.1_f64).exp());
    let y = document["final"]["y"].as_f64().unwrap();
    assert!((y - 0.75 * (1.0 - a.powi(10))).abs() < 1e-12, "{y}");
    assert_eq!((&document["final"]["Lag.steps"], &document["final"]["y_on"]), (&Value::from(10), &Value::Bool(false)));

    assert_fails(&simulate(folder.path(), &["--json", "-o", "-"]), 2, "both want standard output");
    assert_fails(&simulate(folder.path(), &["--json", "--set", "Lag.trouble_at=1"]), 1, "at t = 1 s: Lag");
}

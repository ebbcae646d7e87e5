//! What an FMU's code does to the process: it ends early, exits, hangs, changes the environment.

use super::*;

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
fn messages_arrive_whatever_environment_the_slave_hands_back() {
    let Some(folder) = hostile() else { return };
    let done = run(folder.path(), "odd-environment", &["simulate", "Hostile.fmu", "--json"]);
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    let warnings: Vec<_> = document["warnings"].as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect();
    assert_eq!(warnings, ["Hostile: from nowhere", "Hostile: from one", "Hostile: from two"]);
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

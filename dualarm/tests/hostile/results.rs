//! Where results go, and what is said when they cannot go there.

use super::*;

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

/// As with `ulimit -f`, of which a shell's default action is to kill.
#[test]
fn a_file_that_may_not_grow_further_is_said_like_a_full_disk() {
    let Some(folder) = hostile() else { return };
    let mut command = command(folder.path(), "", &["simulate", "Hostile.fmu", "-o", "out/a.csv"]);
    let limit = || {
        let none = libc::rlimit { rlim_cur: 0, rlim_max: libc::RLIM_INFINITY };
        // SAFETY: gives a limit in valid memory.
        if unsafe { libc::setrlimit(libc::RLIMIT_FSIZE, &raw const none) } == 0 {
            Ok(())
        } else {
            Err(std::io::Error::last_os_error())
        }
    };
    // SAFETY: what is called between the copy and its program allocates nothing.
    unsafe { std::os::unix::process::CommandExt::pre_exec(&mut command, limit) };
    let done = command.output().unwrap();
    assert_eq!(done.status.code(), Some(1), "{}", text(&done.stderr));
    assert!(text(&done.stderr).contains("File too large"), "{}", text(&done.stderr));
    assert_eq!(files(&folder.path().join("tmp")), [""; 0], "temporary files are gone");
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
    for page in ["page.htm", "page", "page.csv"] {
        let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--report", page]);
        assert_eq!(done.status.code(), Some(2), "{page}: {}", text(&done.stderr));
        assert!(text(&done.stderr).contains("must end in .html"), "{}", text(&done.stderr));
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
    for set in ["u=1", "Hostile.u=1"] {
        let done = run(folder.path(), "", &["simulate", "Hostile.fmu", "--set", set]);
        assert!(done.status.success() && !text(&done.stdout).contains("open inputs"), "{}", text(&done.stdout));
    }
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

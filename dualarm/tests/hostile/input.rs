//! Descriptions, connections, scenarios and texts of any kind: found out before code runs, or said.

use super::*;

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
        (&["Hostile.fmu", "--stop", "-1"], 2, "must be later than the start time"),
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

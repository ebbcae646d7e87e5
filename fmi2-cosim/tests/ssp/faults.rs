//! What is wrong with a file is said with the file, the line and the element.

use super::*;

/// A change of the structure's text and what the message must say about it.
const FAULTS: &[(&str, &str, &[&str])] = &[
    ("</ssd:System>", "</ssd:Sys>", &["SystemStructure.ssd", "not well-formed XML"]),
    ("version=\"1.0\" name", "version=\"2.0\" name", &["SSP 2.0", "reads SSP 1.0"]),
    ("ssd:SystemStructureDescription", "ssd:Other", &["<Other>, not <SystemStructureDescription>"]),
    ("startConnector=\"y\"", "startConnector=\"yy\"", &["line 30", "no connector \"yy\" of \"lag\""]),
    ("startElement=\"lag\"", "startElement=\"lagg\"", &["line 30", "no component \"lagg\"; did you mean \"lag\"?"]),
    (
        "<ssd:Connector name=\"u\" kind=\"input\">",
        "<ssd:Connector name=\"u\" kind=\"output\">",
        &["line 7", "\"u\" differs"],
    ),
    (
        "<ssd:Connector name=\"u\" kind=\"input\">",
        "<ssd:Connector name=\"u\" kind=\"inout\">",
        &["line 7", "kind inout"],
    ),
    ("<ssd:Connector name=\"u\" kind=\"input\">", "<ssd:Connector name=\"u\" kind=\"in\">", &["line 7", "kind=\"in\""]),
    (
        "<ssd:Connector name=\"u\" kind=\"input\">",
        "<ssd:Connector kind=\"input\">",
        &["line 7", "lacks the attribute \"name\""],
    ),
    (
        "<ssd:Connector name=\"u\" kind=\"input\">",
        "<ssd:Connector name=\"uu\" kind=\"input\">",
        &["connector \"u\" of \"lag\""],
    ),
    (
        "resources/Lag.fmu",
        "resources/Lagg.fmu",
        &["line 5", "no file resources/Lagg.fmu", "did you mean \"resources/Lag.fmu\"?"],
    ),
    ("resources/Lag.fmu", "../Lag.fmu", &["line 5", "../Lag.fmu", "a path inside the archive"]),
    ("resources/Lag.fmu", "%2e%2e/Lag.fmu", &["a path inside the archive"]),
    ("resources/Lag.fmu", "/etc/passwd", &["a path inside the archive"]),
    ("resources/Lag.fmu", "file:///etc/passwd", &["a path inside the archive"]),
    ("resources/Lag.fmu", "SystemStructure.ssd", &["SystemStructure.ssd is not an FMU"]),
    ("x-fmu-sharedlibrary", "x-ssp-package", &["line 5", "component \"lag\" of type application/x-ssp-package"]),
    ("implementation=\"CoSimulation\"", "implementation=\"ModelExchange\"", &["line 5", "model exchange"]),
    ("<ssd:Elements>", "<ssd:Elements><ssd:System name=\"inner\"/>", &["line 4", "nested system \"inner\""]),
    (
        "<ssd:Elements>",
        "<ssd:Elements><ssd:SignalDictionaryReference name=\"bus\" dictionary=\"d\"/>",
        &["dictionary reference \"bus\""],
    ),
    ("<ssd:Connections>", "<ssd:SignalDictionaries/><ssd:Connections>", &["signal dictionaries"]),
    ("name=\"gain\"", "name=\"lag\"", &["two components are called \"lag\""]),
    (
        "endConnector=\"y\"/>",
        "endConnector=\"y\"><ssc:LinearTransformation factor=\"2\"/></ssd:Connection>",
        &["line 30", "LinearTransformation of a connection"],
    ),
    (
        "endElement=\"gain\" endConnector=\"u\"",
        "endElement=\"lag\" endConnector=\"u\"",
        &["line 31", "lag.u and lag.u cannot be connected"],
    ),
    (
        "startConnector=\"u\" endElement=\"gain\" endConnector=\"u\"",
        "startConnector=\"y\" endElement=\"gain\" endConnector=\"y\"",
        &["line 31", "gain.y has two sources"],
    ),
];

#[test]
fn every_fault_is_named_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let text = write::system_structure(&loop_of_two());
    let Some(path) = ssp(folder.path(), &text, &[]) else { return };
    let run = |text: &str| {
        ssp(folder.path(), text, &[]).unwrap();
        Package::open(&path).and_then(|package| package.system().map(drop))
    };
    run(&text).unwrap();
    for (from, to, said) in FAULTS {
        assert!(text.contains(from), "{from}\n{text}");
        let all = from.starts_with("ssd:");
        let faulty = if all { text.replace(from, to) } else { text.replacen(from, to, 1) };
        let message = run(&faulty).expect_err(to).to_string();
        for words in *said {
            assert!(message.contains(words), "{to}: {message}");
        }
        assert!(message.contains("Loop.ssp"), "{message}");
    }
}

#[test]
fn faulty_parameters_are_named_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let mut structure = loop_of_two();
    structure.system.components[0].bindings =
        vec![Binding { values: Values::File("resources/a.ssv".into()), ..Binding::default() }];
    let structure = write::system_structure(&structure);
    let run = |ssv: &[u8]| {
        let path = ssp(folder.path(), &structure, &[("resources/a.ssv", ssv)])?;
        let system = Package::open(&path).and_then(|package| package.system());
        Some(match system {
            Ok(system) => system.master(Coupling::Jacobi).err().map(|error| error.to_string()),
            Err(error) => Some(error.to_string()),
        })
    };
    let good = write::parameter_set(&set(vec![("T", real_in(2.0, "s"))]));
    let Some(result) = run(good.as_bytes()) else { return };
    assert_eq!(result, None);
    for (from, to, said) in [
        ("value=\"2\"", "value=\"two\"", "a.ssv: line 5: value=\"two\" is not a number"),
        ("value=\"2\"", "value=\"-2\"", "a.ssv:4: lag.T must be at least 0 s, not -2"),
        ("unit=\"s\"", "unit=\"h\"", "a.ssv: line 4: there is no unit \"h\" in the document"),
        ("ssv:Real", "ssv:Binary", "line 5: the binary parameter"),
        ("<ssv:Real value=\"2\" unit=\"s\"/>", "", "line 4: <Parameter> lacks a value"),
        ("<ssv:Real value=\"2\" unit=\"s\"/>", "<ssv:String value=\"x\"/>", "lag.T needs a number in s, not \"x\""),
    ] {
        assert!(good.contains(from), "{from}\n{good}");
        let message = run(good.replace(from, to).as_bytes()).unwrap().expect(to);
        assert!(message.contains(said), "{to}: {message}");
    }
    let message = run(b"\xff").unwrap().unwrap();
    assert!(message.contains("resources/a.ssv: it is not UTF-8"), "{message}");
}

#[test]
fn damaged_and_hostile_archives_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.ssp");
    let say = |path: &Path| Package::open(path).unwrap_err().to_string();
    assert!(say(&path).contains("cannot read") && say(folder.path()).contains("it is a folder"));
    fs::write(&path, "no archive").unwrap();
    assert!(say(&path).contains("not a readable zip archive"), "{}", say(&path));
    archive(&path, &[("readme.txt", b"")]);
    assert!(say(&path).contains("has no SystemStructure.ssd at its root (it has: no .ssd file)"), "{}", say(&path));
    for evil in ["../evil.txt", "/evil.txt", "resources/../../evil.txt"] {
        archive(&path, &[("SystemStructure.ssd", b""), (evil, b"evil")]);
        assert!(say(&path).contains("points outside the archive; not unpacked"), "{}", say(&path));
    }

    let Some(whole) = ssp(folder.path(), &write::system_structure(&loop_of_two()), &[]) else { return };
    let bytes = fs::read(&whole).unwrap();
    for length in [0, 1, 100, bytes.len() / 2, bytes.len() - 1] {
        fs::write(&path, &bytes[..length]).unwrap();
        assert!(say(&path).contains("x.ssp"), "{length}: {}", say(&path));
    }
    // A flipped bit in the packed structure: the checksum notices.
    let mut flipped = bytes.clone();
    flipped[80] ^= 1;
    fs::write(&path, flipped).unwrap();
    assert!(say(&path).contains("x.ssp"), "{}", say(&path));
}

#[test]
fn a_tolerance_that_is_none_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (tolerance, remarks) in [(1e-5, 0), (0.0, 1), (-1.0, 1), (f64::NAN, 1)] {
        let mut structure = loop_of_two();
        structure.experiment =
            DefaultExperiment { step: Some(0.1), tolerance: Some(tolerance), ..structure.experiment };
        let Some(path) = ssp(folder.path(), &write::system_structure(&structure), &[]) else { return };
        let system = Package::open(&path).unwrap().system().unwrap();
        let said: Vec<_> = system.remarks.iter().filter(|remark| remark.contains("is no positive number")).collect();
        assert_eq!(
            (said.len(), system.experiment.tolerance.is_some()),
            (remarks, remarks == 0),
            "{tolerance}: {said:?}"
        );
    }
}

#[test]
fn names_that_others_refer_to_are_there_once() {
    let mut structure = loop_of_two();
    let twice = structure.system.components[0].connectors[0].clone();
    structure.system.components[0].connectors.push(twice);
    let message = read::system_structure(write::system_structure(&structure).as_bytes()).unwrap_err().to_string();
    assert!(message.ends_with("two connectors of one element are called \"u\""), "{message}");
    structure.system.components[0].connectors.truncate(2);
    structure.system.components[0].name.clear();
    let message = read::system_structure(write::system_structure(&structure).as_bytes()).unwrap_err().to_string();
    assert!(message.ends_with("one of the components has an empty name"), "{message}");
    structure.system = SystemElement::default();
    let folder = tempfile::tempdir().unwrap();
    if let Some(path) = ssp(folder.path(), &write::system_structure(&structure), &[]) {
        assert!(Package::open(&path).unwrap_err().to_string().ends_with("the system has no components"));
    }
    let twice = set(vec![("a", real(1.0)), ("b", real(1.0)), ("a", real(2.0))]);
    let message = read::parameter_set(write::parameter_set(&twice).as_bytes()).unwrap_err().to_string();
    assert!(message.ends_with("two parameters of one set are called \"a\""), "{message}");
    let units = vec![unit("mm", [0, 1, 0, 0, 0, 0, 0, 0], 1e-3, 0.0), unit("mm", [0; 8], 1.0, 0.0)];
    let set = ParameterSet { units, ..set(vec![]) };
    let message = read::parameter_set(write::parameter_set(&set).as_bytes()).unwrap_err().to_string();
    assert!(message.ends_with("two units are called \"mm\""), "{message}");
}

//! SSP files: what is written reads back, systems run as they say, and what is wrong with a file is said with the file,
//! the line and the element.

#[path = "../../fmi2-import/tests/support/mod.rs"]
mod support;

use std::fs;
use std::path::{Path, PathBuf};

use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::Coupling;
use fmi2_cosim::record::Table;
use fmi2_cosim::ssp::parameters::{ParameterSet, ParameterValue, Reference};
use fmi2_cosim::ssp::structure::{
    Binding, ComponentElement, Connection, Connector, DefaultExperiment, End, Extent, Kind, Line, Mapping,
    MappingEntry, Origin, Point, SystemElement, SystemStructure, Values,
};
use fmi2_cosim::ssp::{Package, package, read, write};
use fmi2_cosim::system;
use fmi2_import::Value;
use fmi2_import::description::{BaseType, Item, Unit};
use support::{archive, package as package_fmu, package_as};

const LINE: Line = Line(0);

fn unit(name: &str, exponents: [i32; 8], factor: f64, offset: f64) -> Unit {
    Unit { name: name.into(), exponents, factor, offset, has_base_unit: true, display_units: Vec::new() }
}

fn connector(name: &str, kind: Kind) -> Connector {
    Connector {
        name: name.into(),
        kind,
        base_type: Some(BaseType::Real),
        unit: None,
        description: None,
        position: None,
        line: LINE,
    }
}

fn connection(start: End, end: End) -> Connection {
    Connection { start, end, suppress_unit_conversion: false, line: LINE }
}

/// The lag's output to the gain and the gain's back to the lag, with a value for the gain.
fn loop_of_two() -> SystemStructure {
    let component = |name: &str, source: &str, connectors| ComponentElement {
        name: name.into(),
        source: source.into(),
        connectors,
        ..ComponentElement::default()
    };
    SystemStructure {
        name: "Loop".into(),
        system: SystemElement {
            name: "loop".into(),
            components: vec![
                component("lag", "resources/Lag.fmu", vec![connector("u", Kind::Input), connector("y", Kind::Output)]),
                component(
                    "gain",
                    "resources/Gain.fmu",
                    vec![
                        connector("y", Kind::Input),
                        connector("u", Kind::Output),
                        connector("reference", Kind::Input),
                    ],
                ),
            ],
            connections: vec![
                connection(End::of("lag", "y"), End::of("gain", "y")),
                // The ends may stand in either order.
                connection(End::of("lag", "u"), End::of("gain", "u")),
            ],
            ..SystemElement::default()
        },
        ..SystemStructure::default()
    }
}

/// A real number without a unit.
fn real(value: f64) -> (Value, Reference) {
    (value.into(), Reference::Nothing)
}

/// A real number in a unit.
fn real_in(value: f64, unit: &str) -> (Value, Reference) {
    (value.into(), Reference::Unit(unit.into()))
}

/// A value that is no real number.
fn plain(value: impl Into<Value>) -> (Value, Reference) {
    (value.into(), Reference::Nothing)
}

fn set(parameters: Vec<(&str, (Value, Reference))>) -> ParameterSet {
    let parameters = parameters.into_iter().map(|(name, (value, refers_to))| ParameterValue {
        name: name.into(),
        value,
        refers_to,
        line: LINE,
    });
    ParameterSet { name: "set".into(), parameters: parameters.collect(), ..ParameterSet::default() }
}

fn inline(set: ParameterSet) -> Binding {
    Binding { values: Values::Inline(set), ..Binding::default() }
}

/// The description of a fixture with a time constant in s, which the fixture itself leaves out.
fn with_unit(description: &str) -> String {
    let units = "<UnitDefinitions><Unit name=\"s\"><BaseUnit s=\"1\"/></Unit></UnitDefinitions><TypeDefinitions>";
    let description = description.replacen("<TypeDefinitions>", units, 1);
    description.replacen("start=\"1\" min=\"0\"", "start=\"1\" min=\"0\" unit=\"s\"", 1)
}

/// Packages the two fixtures with this structure; `None` without a C compiler.
fn ssp(folder: &Path, structure: &str, others: &[(&str, &[u8])]) -> Option<PathBuf> {
    let lag = package_as(folder, "Lag", |description| with_unit(&description))?;
    let fmus = [fs::read(lag).unwrap(), fs::read(package_fmu(folder, "Gain")?).unwrap()];
    let path = folder.join("Loop.ssp");
    let mut entries: Vec<(&str, &[u8])> = vec![
        ("SystemStructure.ssd", structure.as_bytes()),
        ("resources/Lag.fmu", &fmus[0]),
        ("resources/Gain.fmu", &fmus[1]),
    ];
    entries.extend(others);
    archive(&path, &entries);
    Some(path)
}

#[test]
fn what_is_written_reads_back() {
    let mut structure = loop_of_two();
    structure.description = Some("Quotes \" and <angles> & ampersands".into());
    structure.origin = Origin { license: Some("MIT".into()), generation_tool: Some("editor 1.0".into()) };
    structure.units =
        vec![unit("N.m", [1, 2, -2, 0, 0, 0, 0, 0], 1.0, 0.0), unit("degC", [0, 0, 0, 0, 1, 0, 0, 0], 1.0, 273.15)];
    structure.experiment =
        DefaultExperiment { start: Some(0.5), stop: Some(2.0), step: Some(5e-5), tolerance: Some(1e-5) };
    let lag = &mut structure.system.components[0];
    lag.extent = Some(Extent::new(-1.5, 0.0, 10.0, 20.25));
    lag.connectors[0].unit = Some("N.m".into());
    lag.connectors[0].position = Some(Point { x: 0.0, y: 1.0 / 3.0 });
    lag.bindings = vec![
        Binding { values: Values::File("resources/a.ssv".into()), ..Binding::default() },
        Binding {
            values: Values::Inline(ParameterSet {
                enumerations: vec![("E".into(), vec![Item { name: "one".into(), value: 1, description: None }].into())],
                units: vec![unit("mm", [0, 1, 0, 0, 0, 0, 0, 0], 1e-3, 0.0)],
                ..set(vec![
                    ("a", real_in(0.1 + 0.2, "mm")),
                    ("b", plain(-3)),
                    ("c", plain(true)),
                    ("d", plain("text")),
                    ("e", ("one".into(), Reference::Enumeration(Some("E".into())))),
                ])
            }),
            prefix: "p.".into(),
            mapping: Some(Mapping::Inline(vec![
                MappingEntry { source: "p.a".into(), target: "T".into(), linear: Some((2.0, -1.0)), line: LINE },
                MappingEntry { source: "p.b".into(), target: "n".into(), linear: None, line: LINE },
            ])),
            line: LINE,
        },
    ];
    structure.system.connectors = vec![connector("r", Kind::Input)];
    structure.system.connections.push(connection(End::system("r"), End::of("gain", "reference")));
    structure.system.canvas = Some(Extent::new(0.0, 0.0, 1.0, 1.0));
    let text = write::system_structure(&structure);
    assert_eq!(read::system_structure(text.as_bytes()).unwrap(), structure);

    let Values::Inline(set) = &structure.system.components[0].bindings[1].values else { unreachable!() };
    assert_eq!(read::parameter_set(write::parameter_set(set).as_bytes()).unwrap(), *set);
}

#[test]
fn archives_are_reproducible_and_keep_to_the_standard() {
    let entries = [("SystemStructure.ssd", &b"text"[..]), ("resources/a.fmu", b"PK")];
    let bytes = package::archive(entries).unwrap();
    assert_eq!(bytes, package::archive(entries).unwrap());
    // Local headers (SSP 1.0.1, section 3): version needed at most 2.0, no flags (no encryption, names are ASCII),
    // stored or deflated, the zip format's earliest date.
    let headers: Vec<_> = (0..bytes.len() - 30).filter(|at| bytes[*at..].starts_with(b"PK\x03\x04")).collect();
    assert_eq!(headers.len(), 2);
    for at in headers {
        let word = |offset: usize| u16::from_le_bytes([bytes[at + offset], bytes[at + offset + 1]]);
        assert!(word(4) <= 20, "version {}", word(4));
        assert_eq!(word(6), 0, "flags");
        assert!([0, 8].contains(&word(8)), "method {}", word(8));
        assert_eq!((word(10), word(12)), (0, 0x21), "1980-01-01 00:00");
    }
}

/// Rows of the loop's output y over 1 s.
fn run(path: &Path) -> Vec<f64> {
    let system = Package::open(path).unwrap().system().unwrap();
    let mut master = system.master(Coupling::GaussSeidel).unwrap();
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    let mut table = Table::new(master.record(|name| name == "y"));
    master.initialize(&grid).unwrap();
    master.run(&grid, 0.0, &mut table, &mut |_| ()).unwrap();
    table.column("y").unwrap()
}

/// T ẏ = u − y with u = K (reference − y) held over each step.
fn exact(lag: f64, gain: f64, reference: f64) -> Vec<f64> {
    let decay = (-0.1 / lag).exp();
    let mut y = 0.0;
    let mut rows = vec![y];
    for _ in 0..10 {
        let u = gain * (reference - y);
        y = decay * y + (1.0 - decay) * u;
        rows.push(y);
    }
    rows
}

fn assert_close(rows: &[f64], exact: &[f64]) {
    assert_eq!(rows.len(), exact.len());
    for (row, exact) in rows.iter().zip(exact) {
        assert!((row - exact).abs() < 1e-13, "{rows:?} is not {exact:?}");
    }
}

#[test]
fn explicit_connections_run() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = ssp(folder.path(), &write::system_structure(&loop_of_two()), &[]) else { return };
    assert_close(&run(&path), &exact(1.0, 1.0, 1.0));

    // Without the way back, the lag stays at rest: nothing is connected by its name alone.
    let mut open = loop_of_two();
    open.system.connections.pop();
    let path = ssp(folder.path(), &write::system_structure(&open), &[]).unwrap();
    assert_close(&run(&path), &[0.0; 11]);
}

#[test]
fn parameters_arrive_with_prefix_mapping_unit_and_precedence() {
    let folder = tempfile::tempdir().unwrap();
    let mut structure = loop_of_two();
    structure.system.connectors.push(connector("r", Kind::Input));
    structure.system.connections.push(connection(End::system("r"), End::of("gain", "reference")));
    let milliseconds =
        ParameterSet { units: vec![unit("ms", [0, 0, 1, 0, 0, 0, 0, 0], 1e-3, 0.0)], ..ParameterSet::default() };
    structure.system.components[0].bindings =
        vec![Binding { values: Values::File("resources/lag%20of%20a%20second.ssv".into()), ..Binding::default() }];
    structure.system.components[1].bindings = vec![
        inline(set(vec![("K", real(7.0))])),
        // The later of two bindings holds.
        Binding {
            mapping: Some(Mapping::Inline(vec![MappingEntry {
                source: "strength".into(),
                target: "K".into(),
                linear: Some((2.0, -1.0)),
                line: LINE,
            }])),
            ..inline(set(vec![("strength", real(1.25)), ("K", real(100.0))]))
        },
    ];
    structure.system.bindings = vec![
        // The system's parameters count more than the components'.
        Binding {
            prefix: "lag.".into(),
            ..inline(ParameterSet {
                parameters: set(vec![("T", real_in(500.0, "ms"))]).parameters,
                name: "fast".into(),
                ..milliseconds
            })
        },
        inline(set(vec![("r", real(3.0)), ("gain.no_such", plain(1))])),
    ];
    let slow = write::parameter_set(&set(vec![("T", real(9.0))]));
    let others = [("resources/lag of a second.ssv", slow.as_bytes())];
    let Some(path) = ssp(folder.path(), &write::system_structure(&structure), &others) else { return };
    assert_close(&run(&path), &exact(0.5, 1.5, 3.0));
    let remarks = Package::open(&path).unwrap().system().unwrap().remarks;
    assert_eq!(remarks.len(), 1, "{remarks:?}");
    assert!(remarks[0].contains("SystemStructure.ssd:") && remarks[0].contains("gain.no_such"), "{remarks:?}");
}

#[test]
fn variants_and_experiments_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut variant = loop_of_two();
    variant.experiment = DefaultExperiment { start: Some(1.0), stop: Some(3.0), step: Some(0.25), tolerance: None };
    let variant = write::system_structure(&variant);
    let others = [("Slow.ssd", variant.as_bytes())];
    let Some(path) = ssp(folder.path(), &write::system_structure(&loop_of_two()), &others) else { return };
    let experiment = |path: &Path| Package::open(path).unwrap().system().unwrap().experiment;
    let system::RunOptions { start, stop, step, .. } = experiment(&folder.path().join("Loop.ssp#Slow.ssd"));
    assert_eq!((start, stop, step), (Some(1.0), Some(3.0), Some(0.25)));
    assert_eq!(experiment(&path), system::RunOptions::default());
    let message = Package::open(folder.path().join("Loop.ssp#Fast.ssd")).unwrap_err().to_string();
    assert!(message.contains("no Fast.ssd at its root (it has: Slow.ssd, SystemStructure.ssd)"), "{message}");
}

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

/// SSP 1.0 lets integers feed enumerations; and connectors of integers stand for them.
#[test]
fn integers_feed_enumerations_and_reals() {
    let folder = tempfile::tempdir().unwrap();
    let enumeration = |text: String| {
        text.replace(
            r#"name="y_on" valueReference="0" causality="input" variability="discrete"><Boolean start="false"/>"#,
            r#"name="y_on" valueReference="0" causality="input" variability="discrete"><Enumeration declaredType="Trouble" start="1"/>"#,
        )
    };
    let (Some(lag), Some(gain)) = (package_fmu(folder.path(), "Lag"), package_as(folder.path(), "Gain", enumeration))
    else {
        return;
    };
    let mut structure = loop_of_two();
    let integer = |name: &str, kind| Connector { base_type: Some(BaseType::Integer), ..connector(name, kind) };
    structure.system.components[0].connectors.push(integer("steps", Kind::Output));
    structure.system.components[1].connectors.push(integer("y_on", Kind::Input));
    structure.system.connections.push(connection(End::of("lag", "steps"), End::of("gain", "y_on")));
    structure.system.connections.push(connection(End::of("lag", "steps"), End::of("gain", "reference")));
    let entries = [
        ("SystemStructure.ssd", write::system_structure(&structure).into_bytes()),
        ("resources/Lag.fmu", fs::read(lag).unwrap()),
        ("resources/Gain.fmu", fs::read(gain).unwrap()),
    ];
    let path = folder.path().join("Loop.ssp");
    archive(&path, &entries.each_ref().map(|(name, content)| (*name, content.as_slice())));
    let system = Package::open(&path).unwrap().system().unwrap();
    let mut master = system.master(Coupling::GaussSeidel).unwrap();
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    master.initialize(&grid).unwrap();
    let mut table = Table::new(master.record(|name| ["u", "y"].contains(&name)));
    master.run(&grid, 0.0, &mut table, &mut |_| ()).unwrap();
    let (u, y) = (table.column("u").unwrap(), table.column("y").unwrap());
    // u = K·(r − y) with K = 1 and the reference r = number of steps that the lag has done.
    assert_eq!(u.len(), 11);
    for (done, (u, y)) in (0..11_u32).map(f64::from).zip(u.iter().zip(&y)) {
        assert!((u - (done - y)).abs() < 1e-12, "{u} = {done} - {y}");
    }
}

/// Twenty components that all get the same twenty thousand values: each value goes straight to its variable. Looking for
/// every one among all components took their square in time, and texts of their own half a gigabyte.
#[test]
fn many_components_get_large_sets_in_no_time() {
    const COMPONENTS: usize = 20;
    const PARAMETERS: usize = 20_000;
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..PARAMETERS).map(|index| format!("p{index}")).collect();
    let declared = names.iter().map(|name| {
        format!("<ScalarVariable name=\"{name}\" valueReference=\"1\" causality=\"parameter\" variability=\"fixed\"><Real start=\"1\"/></ScalarVariable>")
    });
    let declared = declared.collect::<Vec<_>>().concat() + "</ModelVariables>";
    let with = |description: String| description.replace("</ModelVariables>", &declared);
    let Some(lag) = package_as(folder.path(), "Lag", with) else { return };
    let set = set(names.iter().map(|name| (name.as_str(), real(0.25))).collect());
    let mut structure = loop_of_two();
    structure.system.connections.clear();
    structure.system.components = (0..COMPONENTS)
        .map(|index| ComponentElement {
            name: format!("lag{index}"),
            source: "resources/Lag.fmu".into(),
            bindings: vec![Binding { values: Values::File("resources/large.ssv".into()), ..Binding::default() }],
            ..ComponentElement::default()
        })
        .collect();
    let path = folder.path().join("Many.ssp");
    let (structure, set) = (write::system_structure(&structure), write::parameter_set(&set));
    let lag = fs::read(lag).unwrap();
    archive(
        &path,
        &[
            ("SystemStructure.ssd", structure.as_bytes()),
            ("resources/large.ssv", set.as_bytes()),
            ("resources/Lag.fmu", &lag),
        ],
    );
    let system = Package::open(&path).unwrap().system().unwrap();
    assert_eq!(system.values.len(), COMPONENTS * PARAMETERS);
    let mut master = system.master(Coupling::Jacobi).unwrap();
    assert_eq!(master.settings().count(), COMPONENTS * PARAMETERS);
    let mut value = [0.0];
    master.instance(COMPONENTS - 1).get_real(&[1], &mut value).unwrap();
    assert_eq!(value, [0.25]);
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

/// Forty thousand parameters, bound two thousand times: read once, applied once, each line found at once. Going through
/// all of them each time would take hours.
#[test]
fn large_sets_that_are_bound_often_are_read_in_no_time() {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<String> = (0..40_000).map(|index| format!("unknown_parameter_{index}")).collect();
    let mut parameters: Vec<_> = names.iter().map(|name| (name.as_str(), real(1.0))).collect();
    parameters.push(("T", real(0.25)));
    let large = write::parameter_set(&set(parameters));
    let mut structure = loop_of_two();
    let binding = || Binding { values: Values::File("resources/large.ssv".into()), ..Binding::default() };
    structure.system.components[0].bindings = (0..2000).map(|_| binding()).collect();
    let others = [("resources/large.ssv", large.as_bytes())];
    let Some(path) = ssp(folder.path(), &write::system_structure(&structure), &others) else { return };
    let system = Package::open(&path).unwrap().system().unwrap();
    assert_eq!((system.values.len(), system.remarks.len()), (1, 40_000));
    let line = large.lines().position(|line| line.contains("\"unknown_parameter_39999\"")).unwrap() + 1;
    assert!(system.remarks.last().unwrap().contains(&format!("large.ssv:{line}: ")), "{:?}", system.remarks.last());
}

//! What is written reads back, and keeps to the standard.

use super::*;

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

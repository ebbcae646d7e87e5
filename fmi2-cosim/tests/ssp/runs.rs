//! Systems run as their files say, and large ones are read in no time.

use super::*;

/// Rows of the loop's output y over 1 s.
fn run(path: &Path) -> Vec<f64> {
    let system = Package::open(path).unwrap().system().unwrap();
    let mut master = system.master(Coupling::GaussSeidel).unwrap();
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    let mut table = Table::new(master.record(|name| name == "y"));
    master.initialize(&grid).unwrap();
    master.run(&grid, 0.0, &mut table, &mut |_| ()).unwrap();
    table.column("y").unwrap().to_vec()
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
    for (done, (u, y)) in (0..11_u32).map(f64::from).zip(u.iter().zip(y)) {
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

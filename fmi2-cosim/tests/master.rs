//! The master against closed forms: a lag T·dy/dt = u − y in a loop with u = K·(r − y).

#[path = "../../fmi2-import/tests/support/mod.rs"]
mod support;

use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Coupling, Master, MasterError};
use fmi2_cosim::record::{Points, Sink, Table};
use fmi2_cosim::settings::{Setting, SettingError};
use fmi2_cosim::signal::{Shape, Signal};
use fmi2_import::{Causality, Fmu};
use support::{package, package_as};

const T: f64 = 0.5;
const K: f64 = 3.0;

/// Lag and gain in a loop, in the given order.
fn loop_of(order: [&str; 2], coupling: Coupling) -> Option<(tempfile::TempDir, Master)> {
    loop_as(order, coupling, |_, text| text)
}

/// The same, their descriptions changed.
fn loop_as(
    order: [&str; 2],
    coupling: Coupling,
    change: impl Fn(&str, String) -> String,
) -> Option<(tempfile::TempDir, Master)> {
    let folder = tempfile::tempdir().unwrap();
    let package = |model| package_as(folder.path(), model, |text| change(model, text));
    let fmus = order.map(|model| package(model).map(|path| Fmu::open(path).unwrap()));
    let [Some(first), Some(second)] = fmus else { return None };
    let mut master = Master::new(&[first, second], coupling).unwrap();
    master.apply(&Setting::new("T", T.to_string())).unwrap();
    master.apply(&Setting::new("Gain.K", K.to_string())).unwrap();
    Some((folder, master))
}

fn run(master: &mut Master, grid: &TimeGrid, interval: f64) -> Table {
    master.initialize(grid).unwrap();
    let mut table = Table::new(master.record(|_| true));
    master.run(grid, interval, &mut table, &mut |_| ()).unwrap();
    table
}

/// The closed loop at the communication points, sample by sample; `delay` in samples.
fn expected(grid: &TimeGrid, delay: bool) -> Vec<f64> {
    let mut y = vec![0.0];
    for index in 0..grid.steps() {
        let a = (-grid.size(index) / T).exp();
        let now = *y.last().unwrap();
        let seen = if delay && y.len() > 1 { y[y.len() - 2] } else { now };
        y.push(a * now + (1.0 - a) * K * (1.0 - seen));
    }
    y
}

fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() < 1e-13, "sample {index}: {found} instead of {expected}");
    }
}

#[test]
fn gauss_seidel_adds_no_delay_in_either_order() {
    let grid = TimeGrid::new(0.0, 1.03, 0.1).unwrap(); // the last step is shorter
    for order in [["Lag", "Gain"], ["Gain", "Lag"]] {
        let Some((_folder, mut master)) = loop_of(order, Coupling::GaussSeidel) else { return };
        let table = run(&mut master, &grid, 0.0);
        let y = table.column("y").unwrap();
        assert_close(y, &expected(&grid, false));
        // Recorded commands belong to the recorded outputs of the same instant.
        let commands: Vec<_> = y.iter().map(|y| K * (1.0 - y)).collect();
        assert_close(table.column("u").unwrap(), &commands);
        assert!((table.times().last().unwrap() - 1.03).abs() < 1e-15);
    }
}

#[test]
fn jacobi_delays_commands_by_one_step_whether_or_not_rows_are_recorded() {
    let grid = TimeGrid::new(0.0, 1.03, 0.1).unwrap();
    for order in [["Lag", "Gain"], ["Gain", "Lag"]] {
        for interval in [0.0, 0.35, 1e9] {
            let Some((_folder, mut master)) = loop_of(order, Coupling::Jacobi) else { return };
            let table = run(&mut master, &grid, interval);
            let y = table.column("y").unwrap();
            let all = expected(&grid, true);
            match interval {
                0.0 => assert_close(y, &all),
                0.35 => assert_close(y, &[all[0], all[4], all[7], all[11]]),
                _ => assert_close(y, &[all[0], all[11]]),
            }
        }
    }
}

/// Without the wires of Booleans.
fn only_reals(model: &str, text: String) -> String {
    if model == "Gain" { text.replace("_on\"", "_is_on\"") } else { text }
}

/// Keeps rows, and what is followed.
struct Both {
    /// How many columns a row has.
    columns: usize,
    rows: Vec<(f64, Vec<f64>)>,
    /// The columns that are followed, at each point.
    points: Vec<(f64, Vec<Option<f64>>)>,
}

impl Sink for Both {
    fn wants(&mut self, time: f64) -> bool {
        assert!(time >= self.idle(), "it is not asked at {time} s");
        true
    }

    fn idle(&mut self) -> f64 {
        self.rows.last().map_or(f64::NEG_INFINITY, |(time, _)| time + 0.25)
    }

    fn row(&mut self, time: f64, values: &[f64]) -> std::io::Result<()> {
        self.rows.push((time, values.to_vec()));
        Ok(())
    }

    fn points(&mut self, points: &Points) -> std::io::Result<()> {
        for (point, time) in points.times().iter().enumerate() {
            let value = |column| points.column(column).map(|values| values[point]);
            self.points.push((*time, (0..self.columns).map(value).collect()));
        }
        Ok(())
    }
}

#[test]
fn what_is_followed_is_read_at_every_step_and_changes_nothing() {
    for order in [["Lag", "Gain"], ["Gain", "Lag"]] {
        for coupling in Coupling::ALL {
            for is_driven in [false, true] {
                let prepared = |change: fn(&str, String) -> String| {
                    let (folder, mut master) = loop_as(order, coupling, change)?;
                    if is_driven {
                        let steps = vec![(0.0, 1.0), (0.3, -1.0), (0.7, 0.5), (15.0, 1.5)];
                        master.drive("Gain.reference", &Signal::new(Shape::Steps, steps).unwrap()).unwrap();
                    }
                    Some((folder, master))
                };
                assert_followed(|| prepared(|_, text| text));
                assert_followed(|| prepared(only_reals));
            }
        }
    }
}

/// Whatever is followed has the values that rows have which are read at every step, and so have rows beside it.
fn assert_followed(prepared: impl Fn() -> Option<(tempfile::TempDir, Master)>) {
    // More points than are passed on at once.
    let grid = TimeGrid::new(0.0, 20.0, 0.1).unwrap();
    let Some((_folder, mut master)) = prepared() else { return };
    let all = run(&mut master, &grid, 0.0);
    // Outputs with and without wires, reals and others.
    let names: Vec<String> = all.columns().iter().map(|column| column.name.clone()).collect();
    let alone = names.iter().map(|name| vec![name.as_str()]);
    for followed in alone.chain([vec!["y", "u"], names.iter().map(String::as_str).collect()]) {
        let Some((_folder, mut master)) = prepared() else { return };
        master.initialize(&grid).unwrap();
        let columns = master.record(|_| true);
        let is_followed: Vec<bool> = columns.iter().map(|column| followed.contains(&column.name.as_str())).collect();
        master.follow(&is_followed);
        let mut both = Both { columns: columns.len(), rows: Vec::new(), points: Vec::new() };
        master.run(&grid, 0.5, &mut both, &mut |_| ()).unwrap();
        assert_eq!((both.rows.len(), both.points.len()), (41, 201));
        for ((time, values), (at, found)) in all.rows().zip(&both.points) {
            assert_eq!(at.to_bits(), time.to_bits());
            for (index, name) in names.iter().enumerate() {
                let expected = is_followed[index].then(|| values[index].to_bits());
                let found = found[index].map(f64::to_bits);
                assert_eq!(found, expected, "{name} at {time} s, of {followed:?}");
            }
        }
        for (time, values) in &both.rows {
            let (_, expected) = all.rows().find(|(at, _)| at.to_bits() == time.to_bits()).unwrap();
            assert!(values.iter().zip(&expected).all(|(found, expected)| found.to_bits() == expected.to_bits()));
        }
    }
}

#[test]
fn what_is_followed_ends_where_a_component_ends_the_simulation() {
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    for (order, change) in [["Lag", "Gain"], ["Gain", "Lag"]]
        .into_iter()
        .flat_map(|order| [(order, (|_, text| text) as fn(&str, String) -> String), (order, only_reals)])
    {
        let Some((_folder, mut master)) = loop_as(order, Coupling::GaussSeidel, change) else { return };
        master.apply(&Setting::new("Lag.trouble_at", "0.45")).unwrap();
        master.apply(&Setting::new("trouble", "discard")).unwrap();
        master.initialize(&grid).unwrap();
        let columns = master.record(|_| true);
        let followed = columns.iter().position(|column| column.name == "y").unwrap();
        master.follow(&columns.iter().map(|column| column.name == "y").collect::<Vec<_>>());
        let mut both = Both { columns: columns.len(), rows: Vec::new(), points: Vec::new() };
        let error = master.run(&grid, 10.0, &mut both, &mut |_| ()).unwrap_err();
        assert!(matches!(error, MasterError::Ended { time: 0.45, .. }), "{error}");
        let times: Vec<f64> = both.points.iter().map(|(time, _)| *time).collect();
        assert_eq!(times, [0.0, 0.1, 0.2, 0.3, 0.4, 0.45]);
        let (rows, points) = (&both.rows, &both.points);
        assert_eq!((rows[0].1[followed], rows[1].0), (points[0].1[followed].unwrap(), 0.45));
        assert_eq!(rows[1].1[followed].to_bits(), points[5].1[followed].unwrap().to_bits());
    }
}

#[test]
fn initial_signals_follow_direct_feedthrough() {
    let Some((_folder, mut master)) = loop_of(["Lag", "Gain"], Coupling::Jacobi) else { return };
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    master.apply(&Setting::new("Gain.reference", "2")).unwrap();
    let table = run(&mut master, &grid, 0.1);
    assert!((table.column("u").unwrap()[0] - K * 2.0).abs() < 1e-15);
    // Integers and booleans are recorded as well.
    assert_eq!(table.columns().iter().filter(|column| column.name.ends_with("steps")).count(), 2);
    assert_eq!(table.column("Lag.steps").unwrap()[10].to_bits(), 10.0_f64.to_bits());
}

#[test]
fn algebraic_loops_are_solved_when_they_contract_and_reported_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    // Two gains facing each other: u = K·(1 − y), y = K·(1 − u), solution K/(1 + K).
    let swapped = |text: String| {
        text.replace("\"y\"", "\"_\"")
            .replace("\"u\"", "\"y\"")
            .replace("\"_\"", "\"u\"")
            .replace("modelName=\"Gain\"", "modelName=\"Niag\"")
    };
    let Some(path) = package(folder.path(), "Gain") else { return };
    let gain = Fmu::open(path).unwrap();
    let niag = Fmu::open(package_as(folder.path(), "Gain", swapped).unwrap()).unwrap();
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();

    let mut master = Master::new(&[gain.clone(), niag.clone()], Coupling::GaussSeidel).unwrap();
    master.apply(&Setting::new("K", "0.5")).unwrap();
    let table = run(&mut master, &grid, 1.0);
    assert!((table.column("u").unwrap()[0] - 1.0 / 3.0).abs() < 1e-12);

    let mut master = Master::new(&[gain, niag], Coupling::GaussSeidel).unwrap();
    master.apply(&Setting::new("K", "1.5")).unwrap();
    let error = master.initialize(&grid).unwrap_err();
    assert!(matches!(error, MasterError::AlgebraicLoop { .. }), "{error}");
}

#[test]
fn warnings_go_on_and_everything_worse_stops_with_the_slaves_words() {
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    for (trouble, expected) in [
        ("warning", None),
        (
            "discard",
            Some(
                "at t = 0.45 s: Lag asks to end the simulation: Lag: fmi2DoStep returned fmi2Discard: trouble at t = 0.4",
            ),
        ),
        ("error", Some("at t = 0.4 s: Lag: fmi2DoStep returned fmi2Error: trouble at t = 0.4")),
        ("fatal", Some("at t = 0.4 s: Lag: fmi2DoStep returned fmi2Fatal: trouble at t = 0.4")),
    ] {
        let Some((_folder, mut master)) = loop_of(["Lag", "Gain"], Coupling::GaussSeidel) else { return };
        master.apply(&Setting::new("Lag.trouble_at", "0.45")).unwrap();
        master.apply(&Setting::new("trouble", trouble)).unwrap();
        master.initialize(&grid).unwrap();
        let result = master.run(&grid, 0.1, &mut (), &mut |_| ());
        assert_eq!(result.err().map(|error| error.to_string()).as_deref(), expected);
        if expected.is_none() {
            let log = master.finish().unwrap();
            assert_eq!(log.len(), 6);
        }
    }
}

#[test]
fn slaves_that_need_equal_steps_are_not_given_a_shorter_one() {
    let folder = tempfile::tempdir().unwrap();
    let equal = |text: String| text.replace("StepSize=\"true\"", "StepSize=\"false\"");
    let Some(path) = package_as(folder.path(), "Lag", equal) else { return };
    let fmu = Fmu::open(path).unwrap();
    let grid = TimeGrid::new(0.0, 1.05, 0.1).unwrap();
    let mut master = Master::new(std::slice::from_ref(&fmu), Coupling::Jacobi).unwrap();
    assert!(matches!(master.initialize(&grid), Err(MasterError::UnequalSteps { .. })));
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    assert!(Master::new(&[fmu], Coupling::Jacobi).unwrap().initialize(&grid).is_ok());
}

#[test]
fn components_of_one_model_get_names_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let Some(path) = package(folder.path(), "Lag") else { return };
    let lag = Fmu::open(path).unwrap();
    let gain = Fmu::open(package(folder.path(), "Gain").unwrap()).unwrap();
    let master = Master::new(&[lag.clone(), lag.clone()], Coupling::Jacobi).unwrap();
    assert_eq!(master.names().collect::<Vec<_>>(), ["Lag", "Lag_2"]);
    assert!(master.wires().is_empty());
    let error = Master::new(&[lag.clone(), lag, gain], Coupling::Jacobi).err().unwrap();
    assert_eq!(
        error.to_string(),
        "both Lag and Lag_2 offer \"y\", which Gain wants; only one of them can be connected"
    );
}

/// The reference value over time in the closed loop: the gain answers at once, as it does to any other input.
#[test]
fn driven_inputs_take_effect_at_their_communication_point() {
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    let reference = Signal::new(Shape::Steps, vec![(0.0, 1.0), (0.3, -1.0), (0.7, 0.5)]).unwrap();
    let at = |index: u64| [1.0, -1.0, 0.5][usize::from(index >= 3) + usize::from(index >= 7)];
    for order in [["Lag", "Gain"], ["Gain", "Lag"]] {
        let Some((_folder, mut master)) = loop_of(order, Coupling::GaussSeidel) else { return };
        master.drive("Gain.reference", &reference).unwrap();
        let table = run(&mut master, &grid, 0.0);
        assert!(master.warnings().is_empty());
        let a = (-0.1_f64 / T).exp();
        let mut y = vec![0.0];
        for index in 0..grid.steps() {
            let now = *y.last().unwrap();
            y.push(a * now + (1.0 - a) * K * (at(index) - now));
        }
        assert_close(table.column("y").unwrap(), &y);
        let commands: Vec<_> = (0..).zip(&y).map(|(index, y)| K * (at(index) - y)).collect();
        assert_close(table.column("u").unwrap(), &commands);
    }
}

/// A lag T·dy/dt = u − y whose input is a ramp u = t: held during each step, or as straight lines where the slave can.
#[test]
fn ramps_are_held_or_interpolated_as_the_slave_can() {
    let folder = tempfile::tempdir().unwrap();
    let ramp = Signal::new(Shape::Linear, vec![(0.0, 0.0), (1.0, 1.0)]).unwrap();
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    let a = (-0.1_f64 / T).exp();
    let mut held = vec![0.0];
    for index in 0..10_u32 {
        held.push(a * held.last().unwrap() + (1.0 - a) * f64::from(index) * 0.1);
    }
    let exact: Vec<f64> =
        (0..=10_u32).map(|index| f64::from(index) * 0.1).map(|t| t - T * (1.0 - (-t / T).exp())).collect();
    for (interpolates, expected) in [(false, held), (true, exact)] {
        let change = |text: String| {
            let capability = format!("canInterpolateInputs=\"{interpolates}\" canGetAndSetFMUstate");
            text.replace("canGetAndSetFMUstate", &capability)
        };
        let Some(path) = package_as(folder.path(), "Lag", change) else { return };
        let mut master = Master::new(&[Fmu::open(path).unwrap()], Coupling::Jacobi).unwrap();
        master.apply(&Setting::new("T", T.to_string())).unwrap();
        master.drive("u", &ramp).unwrap();
        let table = run(&mut master, &grid, 0.0);
        assert_close(table.column("y").unwrap(), &expected);
        assert_eq!(master.warnings().len(), usize::from(!interpolates), "{:?}", master.warnings());
    }
}

#[test]
fn only_free_inputs_can_be_driven_and_a_setting_ends_that() {
    let Some((_folder, mut master)) = loop_of(["Lag", "Gain"], Coupling::GaussSeidel) else { return };
    let steps = |values: [f64; 2]| Signal::new(Shape::Steps, vec![(0.0, values[0]), (0.55, values[1])]).unwrap();
    let ramp = Signal::new(Shape::Linear, vec![(0.0, 0.0), (1.0, 1.0)]).unwrap();
    for (target, signal, expected) in [
        (
            "Lag.u",
            steps([0.0, 1.0]),
            "Lag.u cannot be set: it is an input that Gain.u drives, which would replace the value; leave it out",
        ),
        ("K", steps([0.0, 1.0]), "Gain.K cannot be set: only inputs can change over time, and it is none"),
        ("referense", steps([0.0, 1.0]), "there is no variable \"referense\" in Lag or Gain; did you mean reference?"),
    ] {
        assert_eq!(master.drive(target, &signal).unwrap_err().to_string(), expected);
    }
    let folder = tempfile::tempdir().unwrap();
    let lag = Fmu::open(package(folder.path(), "Lag").unwrap()).unwrap();
    let mut alone = Master::new(&[lag], Coupling::Jacobi).unwrap();
    for (signal, expected) in [(ramp, "only real inputs can follow straight lines"), (steps([0.0, 2.0]), "not 0, 2")] {
        let message = alone.drive("u_on", &signal).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    alone.drive("u_on", &steps([0.0, 1.0])).unwrap();
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    let table = run(&mut alone, &grid, 0.0);
    let on = table.column("y_on").unwrap();
    assert_eq!(
        alone.warnings(),
        ["Lag.u_on jumps at 0.55 s, between two communication points: the jump comes with the next one"]
    );
    assert_eq!(on[..5], [on[0]; 5]);
    assert_ne!(on[6], on[5]);

    master.drive("reference", &steps([1.0, 5.0])).unwrap();
    master.apply(&Setting::new("reference", "1")).unwrap();
    let table = run(&mut master, &grid, 0.0);
    assert_close(table.column("y").unwrap(), &expected(&grid, false));
}

#[test]
fn settings_say_what_is_wrong_with_them() {
    let Some((_folder, mut master)) = loop_of(["Lag", "Gain"], Coupling::Jacobi) else { return };
    let mut error = |target: &str, value: &str| master.apply(&Setting::new(target, value)).unwrap_err();
    for (target, value, expected) in [
        ("trouble_a", "1", "there is no variable \"trouble_a\" in Lag or Gain; did you mean trouble_at or trouble?"),
        // A word of its name.
        ("at", "1", "there is no variable \"at\" in Lag or Gain; did you mean trouble_at?"),
        ("Lag.lable", "1", "there is no variable \"lable\" in Lag; did you mean Lag.label?"),
        ("Lag.K", "1", "there is no variable \"K\" in Lag; did you mean Gain.K?"),
        ("xyz", "1", "there is no variable \"xyz\" in Lag or Gain"),
        ("Gian.K", "1", "there is no component \"Gian\"; the components are Lag, Gain; did you mean Gain.K?"),
        ("Plant.K", "1", "there is no component \"Plant\"; the components are Lag, Gain"),
        ("y", "1", "Lag.y cannot be set: it is an output that the FMU computes"),
        (
            "Gain.y",
            "1",
            "Gain.y cannot be set: it is an input that Lag.y drives, which would replace the value; leave it out",
        ),
        ("trouble_at", "soon", "Lag.trouble_at needs a number in s, not \"soon\""),
        (
            "trouble_at",
            "5lightyears",
            "Lag.trouble_at needs a number in s (the FMU defines no unit \"lightyears\"), not \"5lightyears\"",
        ),
        (
            "trouble_at",
            "0.5,trouble=fatal",
            "Lag.trouble_at needs a number in s (set each of several variables by itself), not \"0.5,trouble=fatal\"",
        ),
        (
            "trouble_at",
            "0.5 trouble=fatal",
            "Lag.trouble_at needs a number in s (set each of several variables by itself), not \"0.5 trouble=fatal\"",
        ),
        ("trouble_at", "1,5", "Lag.trouble_at needs a number in s, not \"1,5\""),
        ("TROUBLE_AT", "1", "there is no variable \"TROUBLE_AT\" in Lag or Gain; did you mean trouble_at or trouble?"),
        ("trouble_at", "NaN", "Lag.trouble_at needs a number in s, not \"NaN\""),
        ("trouble", "loud", "Lag.trouble needs one of warning, discard, error, fatal, not \"loud\""),
        ("trouble", "7", "Lag.trouble needs one of warning, discard, error, fatal, not \"7\""),
    ] {
        assert_eq!(error(target, value).to_string(), expected);
    }
    assert_eq!(error("T", "-1").to_string(), "Lag.T must be at least 0, not -1");
    let refused = error("T", "0");
    assert!(matches!(refused, SettingError::Refused { .. }));
    assert_eq!(
        refused.to_string(),
        "Lag.T=0 is refused: Lag: fmi2SetReal returned fmi2Error: T = 0 must be positive, # 100 %"
    );
    let wired = |index: usize| master.wires()[index].to.component;
    assert_eq!((wired(0), wired(master.wires().len() - 1)), (0, 1));
    let inputs = master.instance(0).description().with_causality(Causality::Input).count();
    assert_eq!(inputs, 3);
}

//! The built-in sets of gains are what `dualarm tune` wrote: the files of `scenarios/tuned`, each with its command.

use grasp_control::laws::pd::PdGains;
use grasp_control::laws::pds::PdsGains;
use grasp_control::laws::root_strain::{HubGains, InertiaGains, MassGains, ObjectGains, RootStrainGains};
use parameter_table::Parameter;
use std::collections::BTreeMap;
use std::path::Path;

/// The numbers under `[parameters]`.
fn tuned(name: &str) -> BTreeMap<String, f64> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenarios/tuned/{name}.toml"));
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("dualarm tune"), "{name}: says how it was made");
    let (_, parameters) = text.split_once("[parameters]").unwrap();
    let number = |line: &str| {
        let (name, value) = line.split_once('=')?;
        Some((name.trim().to_owned(), value.trim().parse().ok()?))
    };
    parameters.lines().filter_map(number).collect()
}

/// Takes what the file says of these parameters, which must be what the gains are.
fn compare<T: Copy>(file: &mut BTreeMap<String, f64>, table: &[Parameter<T>], gains: &mut T, arm: &str) {
    for row in table {
        if let Some(value) = file.remove(&row.name.replace("{}", arm)) {
            let shipped = *(row.field)(gains);
            assert!((shipped - value).abs() <= 1e-12 * value.abs(), "{}: {shipped} is not {value}", row.name);
        }
    }
}

#[test]
fn root_strain() {
    for (name, mut gains) in [("nabfc-r", RootStrainGains::default()), ("nabfc-r-fast", RootStrainGains::fast())] {
        let mut file = tuned(name);
        assert!(file.len() >= 15, "{name}");
        compare(&mut file, ObjectGains::PARAMETERS, &mut gains.object, "");
        compare(&mut file, HubGains::PARAMETERS, &mut gains.hub[0], "1");
        compare(&mut file, HubGains::PARAMETERS, &mut gains.hub[1], "2");
        compare(&mut file, MassGains::PARAMETERS, &mut gains.mass, "");
        compare(&mut file, InertiaGains::PARAMETERS, &mut gains.inertia, "");
        compare(&mut file, RootStrainGains::PARAMETERS, &mut gains, "");
        assert!(file.is_empty(), "{name}: {file:?} is not in the preset");
    }
}

#[test]
fn pd_and_pds() {
    for (name, mut gains) in [("pd", PdGains::tuned()), ("pid", PdGains::pid())] {
        let mut file = tuned(name);
        assert!(file.len() >= 6, "{name}");
        compare(&mut file, PdGains::PARAMETERS, &mut gains, "");
        assert!(file.is_empty(), "{name}: {file:?} is not in the preset");
    }
    let mut file = tuned("pds");
    compare(&mut file, PdsGains::PARAMETERS, &mut PdsGains::tuned(), "");
    assert!(file.is_empty(), "pds: {file:?} is not in the preset");
}

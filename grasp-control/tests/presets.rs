//! Gains by name; the built-in sets of them are what `dualarm tune` wrote: the files of `scenarios/tuned`, each with its command.

use grasp_control::laws::GainSet;
use grasp_control::laws::nabfc::Gains;
use grasp_control::laws::pd::PdGains;
use grasp_control::laws::pds::PdsGains;
use grasp_control::laws::root_strain::{InertiaGains, RootStrainGains};
use std::collections::{BTreeMap, HashSet};
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

/// Each number of the file is a gain of the preset.
fn compare(name: &str, gains: Option<impl GainSet>) {
    let mut file = tuned(name);
    assert!(file.len() >= 6, "{name}");
    for (gain, shipped) in gains.expect(name).values() {
        if let Some(value) = file.remove(&gain) {
            assert!((shipped - value).abs() <= 1e-12 * value.abs(), "{name}: {gain}: {shipped} is not {value}");
        }
    }
    assert!(file.is_empty(), "{name}: {file:?} is not in the preset");
}

#[test]
fn presets_are_what_was_found() {
    compare("nabfc-r", Some(RootStrainGains::default()));
    compare("nabfc-r-fast", RootStrainGains::preset("fast"));
    compare("pd", PdGains::preset("tuned"));
    compare("pid", PdGains::preset("pid"));
    compare("pds", PdsGains::preset("tuned"));
}

/// Every gain has a name of its own, by which it can be set, to values in its range only.
fn set_all<G: GainSet>(gains: G) {
    let values = gains.values();
    let names: HashSet<_> = values.iter().map(|(name, _)| name).collect();
    assert_eq!(names.len(), values.len());
    let mut changed = gains;
    for (name, value) in &values {
        changed.set(name, f64::NAN).unwrap_err();
        assert_eq!(changed.set(name, 0.5 * value), Ok(true), "{name}");
    }
    for ((name, before), (_, after)) in values.iter().zip(changed.values()) {
        assert!((after - 0.5 * before).abs() <= 1e-15 * before.abs(), "{name}: {before} became {after}");
    }
    assert_eq!(changed.set("no_gain", 1.0), Ok(false));
}

#[test]
fn gains_are_set_by_name() {
    set_all(PdGains::default());
    set_all(PdsGains::default());
    set_all(Gains::default());
    set_all(RootStrainGains {
        inertia: InertiaGains { largest: 4.0, ..RootStrainGains::default().inertia },
        ..RootStrainGains::default()
    });
    // One per arm.
    assert!(RootStrainGains::default().values().iter().any(|(name, _)| name == "r_strain2"));
    assert_eq!(PdGains::preset("parameters"), None);
}

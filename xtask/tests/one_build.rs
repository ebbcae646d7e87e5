//! Dependencies have the same features in every build; otherwise all their dependents would be compiled again for each
//! build. Missing features belong into `workspace-hack`.

use std::collections::BTreeMap;
use std::process::Command;

/// The features of every dependency, when these crates are selected.
fn features(selection: &[&str]) -> BTreeMap<String, String> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(["tree", "--prefix", "none", "--format", "{p}|{f}", "--locked"]).args(selection);
    let output = command.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let lines = text.lines().filter_map(|line| line.trim_end_matches(" (*)").split_once('|'));
    // Crates of the workspace have a path; they are no dependencies.
    lines.filter(|(name, _)| !name.contains('/')).map(|(name, features)| (name.into(), features.into())).collect()
}

#[test]
fn every_build_gives_dependencies_the_features_that_the_test_command_gives_them() {
    let all = features(&["--workspace", "--all-features", "--edges", "normal,build,dev"]);
    assert!(all.len() > 100, "{all:?}");
    let models = "plant-fmu/package,controller-fmu/package,instruments-fmu/package";
    for selection in [
        &["--package", "dualarm", "--edges", "normal,build"][..],
        &["--package", "xtask", "--edges", "normal,build"],
        &["--workspace", "--features", models, "--edges", "normal,build"],
        &["--workspace", "--all-features", "--edges", "normal,build"],
    ] {
        for (name, own) in features(selection) {
            assert_eq!(all.get(&name), Some(&own), "{name} with {selection:?}");
        }
    }
}

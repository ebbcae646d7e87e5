//! Packaging with a stand-in for the repository: tiny crates whose programs copy a ready-made FMU.

#[path = "../../fmi2-import/tests/support/mod.rs"]
mod support;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use dualarm::build::{LIBRARIES, MODELS, Platforms, package};
use fmi2_package::platform::Platform;
use support::{archive, description};

const MAIN: &str = r#"
fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if arguments[1] == "--guids" {
        return;
    }
    let after = |option: &str| arguments.iter().skip_while(|a| *a != option).nth(1).map(std::path::PathBuf::from).unwrap();
    assert!(after("--library").is_file());
    if let Ok(message) = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/fail.txt")) {
        eprintln!("{message}");
        std::process::exit(1);
    }
    let name = concat!(env!("CARGO_PKG_NAME"), ".fmu");
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/ready.fmu"), after("--out").join(name)).unwrap();
}
"#;

fn stand_in(root: &Path) {
    let members = MODELS.iter().chain([&LIBRARIES]);
    let members = members.map(|member| format!("\"{member}\"")).collect::<Vec<_>>().join(", ");
    let workspace =
        format!("[workspace]\nresolver = \"3\"\nmembers = [{members}]\n[profile.fmu]\ninherits = \"release\"\n");
    fs::write(root.join("Cargo.toml"), workspace).unwrap();
    for model in MODELS {
        let folder = root.join(model);
        fs::create_dir_all(folder.join("src")).unwrap();
        let manifest = format!(
            "[package]\nname = \"{model}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\
             [features]\npackage = []\n[[bin]]\nname = \"{model}\"\npath = \"src/main.rs\"\nrequired-features = [\"package\"]\n"
        );
        fs::write(folder.join("Cargo.toml"), manifest).unwrap();
        fs::write(folder.join("src/lib.rs"), "").unwrap();
        fs::write(folder.join("src/main.rs"), MAIN).unwrap();
        archive(&folder.join("ready.fmu"), &[("modelDescription.xml", description("Lag").as_bytes())]);
    }
    let folder = root.join(LIBRARIES);
    fs::create_dir_all(folder.join("src")).unwrap();
    fs::create_dir_all(folder.join("examples")).unwrap();
    fs::write(folder.join("src/lib.rs"), "").unwrap();
    let name = |model: &str| model.replace('-', "_");
    let each = |text: &dyn Fn(&str) -> String| MODELS.iter().map(|model| text(model)).collect::<String>();
    let examples = each(&|model| format!("[[example]]\nname = \"{}\"\ncrate-type = [\"cdylib\"]\n", name(model)));
    let dependencies = each(&|model| format!("{model} = {{ path = \"../{model}\" }}\n"));
    let package = format!("[package]\nname = \"{LIBRARIES}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n");
    fs::write(folder.join("Cargo.toml"), format!("{package}{examples}[dependencies]\n{dependencies}")).unwrap();
    for model in MODELS.iter().map(|model| name(model)) {
        fs::write(folder.join(format!("examples/{model}.rs")), format!("pub use {model}::*;")).unwrap();
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// The build needs a target folder of its own, so this runs [`in_a_child_process`] with another environment.
#[test]
fn models_are_built_packaged_and_moved_into_place() {
    let root = tempfile::tempdir().unwrap();
    stand_in(root.path());
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "in_a_child_process", "--ignored", "--nocapture"])
        .env("CARGO_TARGET_DIR", root.path().join("target"))
        .env("STAND_IN", root.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
#[ignore = "run by models_are_built_packaged_and_moved_into_place"]
fn in_a_child_process() {
    let Some(root) = std::env::var_os("STAND_IN").map(PathBuf::from) else { return };
    let out = root.join("dist");
    let mut said = Vec::new();
    // One platform: what else could be built for here does not matter.
    let platforms = Platforms { wanted: vec![Platform::here().unwrap()], ..Platforms::default() };
    let mut run = || package(&root, &out, &platforms, None, true, &mut |doing| said.push(doing.to_owned()));

    let fmus = run().unwrap().fmus;
    let made = ["controller-fmu.fmu", "instruments-fmu.fmu", "plant-fmu.fmu"];
    assert_eq!(fmus, made.map(|name| out.join(name)));
    assert_eq!(names(&out), made);

    // A failing packager is quoted and leaves the folder as it was.
    fs::write(root.join("controller-fmu/fail.txt"), "no licence file").unwrap();
    assert_eq!(run().unwrap_err().to_string(), "packaging controller-fmu failed: no licence file");
    fs::remove_file(root.join("controller-fmu/fail.txt")).unwrap();
    archive(&root.join("plant-fmu/ready.fmu"), &[("readme.txt", b"")]);
    assert!(run().unwrap_err().to_string().contains("no modelDescription.xml"));
    fs::write(root.join("plant-fmu/src/lib.rs"), "does not compile").unwrap();
    assert!(run().unwrap_err().to_string().contains("building the FMUs failed"));
    assert_eq!(names(&out), made);
    assert_eq!(said[0], format!("building the FMU libraries of {}", root.display()));
}

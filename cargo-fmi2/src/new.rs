//! `cargo fmi2 new`: a model crate from the template.

use std::fs;
use std::path::{Path, PathBuf};

use crate::names;

/// The template's files: their paths and contents. Names and the paths of the dependencies are replaced in both.
const FILES: [(&str, &str); 6] = [
    (".gitignore", include_str!("../template/gitignore.in")),
    // Cargo would take a folder with a Cargo.toml for a crate of its own, and leave it out of this one.
    ("Cargo.toml", include_str!("../template/Cargo.toml.in")),
    ("README.md", include_str!("../template/README.md")),
    ("documentation/MyModel.md", include_str!("../template/documentation/MyModel.md")),
    ("src/lib.rs", LIBRARY),
    ("src/main.rs", include_str!("../template/src/main.rs")),
];
const LIBRARY: &str = include_str!("../template/src/lib.rs");

/// The crates of ours that the template depends on.
const OURS: [&str; 2] = ["fmi2-export", "fmi2-package"];

/// Creates a crate in the new folder `path`, named like the folder, and prints the next steps. If it fails, nothing
/// remains. `ours` is the folder of the crates on which it depends. By default they are beside this crate if that is a
/// clone, otherwise on the registry.
///
/// # Errors
/// If a crate or a model cannot have this name, or a file cannot be written.
pub fn create(path: &Path, ours: Option<&Path>) -> Result<String, String> {
    let package = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    names::check_package(&package, &dependencies())?;
    let model = names::model(&package, LIBRARY)?;
    let place = place(ours)?;
    let change = |text: &str| {
        let mut text = text.to_owned();
        for ours in OURS {
            let source = match &place {
                None => format!("version = {:?}", env!("CARGO_PKG_VERSION")),
                Some(folder) => format!("path = {:?}", plain(&folder.join(ours))),
            };
            text = text.replace(&format!("{ours} = {{ version = \"VERSION\""), &format!("{ours} = {{ {source}"));
        }
        text.replace("my-model", &package).replace("my_model", &package.replace('-', "_")).replace("MyModel", &model)
    };
    fs::create_dir(path).map_err(|error| format!("cannot create the new folder {}: {error}", path.display()))?;
    for (file, text) in FILES {
        let target = path.join(change(file));
        let written =
            target.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&target, change(text)));
        if let Err(error) = written {
            // All of it is ours: the folder did not exist.
            let _ = fs::remove_dir_all(path);
            return Err(format!("cannot write {}: {error}", target.display()));
        }
    }
    let needs = place.map_or(String::new(), |folder| {
        format!("It depends on fmi2-export and fmi2-package in {}; Cargo.toml says so.\n", plain(&folder))
    });
    Ok(format!(
        "{0} has a model that works, {model}. Next:\n\n    cd {0}\n    cargo fmi2 package     # writes dist/{model}.fmu; so does \
         cargo run --release --features package\n    cargo test --release\n\nThen make it yours: README.md there says where to \
         begin.\n{needs}",
        path.display()
    ))
}

/// The crates that the template's manifest names, and `serde`, which every model with more than plain fields adds.
fn dependencies() -> Vec<&'static str> {
    let manifest = FILES[1].1;
    let section = manifest.split("[dependencies]").nth(1).and_then(|rest| rest.split("\n[").next()).unwrap_or_default();
    section.lines().filter_map(|line| line.split_once(" = ")).map(|(name, _)| name).chain(["serde"]).collect()
}

/// The folder of the crates on which the new one depends: `wanted`, or beside this crate if that is a clone, or `None` for
/// the registry.
fn place(wanted: Option<&Path>) -> Result<Option<PathBuf>, String> {
    let has_ours = |folder: &Path| OURS.iter().all(|ours| folder.join(ours).join("Cargo.toml").is_file());
    let clone = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    match (wanted, clone) {
        (Some(folder), _) if !has_ours(folder) => {
            Err(format!("{} has no folders {} with crates in them", folder.display(), OURS.join(" and ")))
        }
        (Some(folder), _) => Ok(Some(absolute(folder)?)),
        (None, Some(clone)) if has_ours(clone) => Ok(Some(absolute(clone)?)),
        _ => Ok(None),
    }
}

fn absolute(folder: &Path) -> Result<PathBuf, String> {
    folder.canonicalize().map_err(|error| format!("cannot find {}: {error}", folder.display()))
}

/// A path as people and cargo write it, also on Windows.
fn plain(path: &Path) -> String {
    path.display().to_string().trim_start_matches(r"\\?\").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_crate_has_the_new_names_everywhere_and_never_replaces_anything() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("dc-motor");
        let said = create(&path, None).unwrap();
        assert!(said.contains("dist/DcMotor.fmu"), "{said}");
        let read = |file: &str| fs::read_to_string(path.join(file)).unwrap();
        let [manifest, library, program, readme] = ["Cargo.toml", "src/lib.rs", "src/main.rs", "README.md"].map(read);
        assert!(manifest.contains("name = \"dc-motor\"") && !manifest.contains("VERSION"), "{manifest}");
        assert!(library.contains("export!(DcMotor)") && program.contains("dc_motor::FMUS"));
        assert!(path.join("documentation/DcMotor.md").is_file() && path.join(".gitignore").is_file());
        for text in [manifest, library, program, readme] {
            let lower = text.to_lowercase();
            assert!(!["mymodel", "my-model", "my_model"].iter().any(|old| lower.contains(old)), "an old name is left");
        }
        assert!(create(&path, None).unwrap_err().contains("cannot create"));
        assert!(create(&folder.path().join("missing/dc-motor"), None).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn dependencies_come_from_the_clone_or_from_where_one_says() {
        let folder = tempfile::tempdir().unwrap();
        create(&folder.path().join("here"), None).unwrap();
        let manifest = fs::read_to_string(folder.path().join("here/Cargo.toml")).unwrap();
        // These tests run in a clone, and in the published package of this crate.
        let clone = place(None).unwrap();
        for ours in OURS {
            let source = match &clone {
                Some(clone) => format!("path = {:?}", plain(&clone.join(ours))),
                None => format!("version = {:?}", env!("CARGO_PKG_VERSION")),
            };
            assert!(manifest.contains(&format!("{ours} = {{ {source}")), "{manifest}");
        }
        let nowhere = create(&folder.path().join("there"), Some(folder.path())).unwrap_err();
        assert!(nowhere.contains("has no folders fmi2-export and fmi2-package"), "{nowhere}");
        assert!(!folder.path().join("there").exists());
    }

    #[test]
    fn what_a_crate_cannot_be_called_makes_no_folder() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["loop", "std", "serde", "fmi2-package", "step", "insulation", "string", "DcMotor"] {
            assert!(create(&folder.path().join(name), None).is_err(), "{name}");
        }
        assert!(create(Path::new(".."), None).is_err() && create(Path::new(""), None).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn no_file_of_the_template_is_forgotten() {
        fn count(folder: &Path) -> usize {
            let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
            entries.map(|path| if path.is_dir() { count(&path) } else { 1 }).sum()
        }
        assert_eq!(count(&Path::new(env!("CARGO_MANIFEST_DIR")).join("template")), FILES.len());
    }
}

//! `cargo xtask new-fmu`: a new model crate from the template of fmi2-export.

use std::fs;
use std::path::{Path, PathBuf};

/// Where the template is, from the root of the workspace, and what its files are.
const TEMPLATE: &str = "fmi2-export/template";
const FILES: [&str; 6] =
    [".gitignore", "Cargo.toml", "README.md", "documentation/MyModel.md", "src/lib.rs", "src/main.rs"];

/// Makes a crate in the new folder `path`, named as the folder, and tells what to do next. If it fails, nothing is left.
pub fn create(root: &Path, path: &Path) -> Result<String, String> {
    let package = package_name(path)?;
    let model = model_name(&package);
    let repository = root.canonicalize().map_err(|error| format!("cannot find this repository: {error}"))?;
    let repository = repository.display().to_string();
    let repository = format!("path = {:?}", repository.trim_start_matches(r"\\?\"));
    let change = |text: &str| {
        text.replace("path = \"../..", repository.trim_end_matches('"'))
            .replace("my-model", &package)
            .replace("my_model", &package.replace('-', "_"))
            .replace("MyModel", &model)
    };
    let read = |file: &str| {
        let source = root.join(TEMPLATE).join(file);
        let text = fs::read_to_string(&source).map_err(|error| format!("cannot read {}: {error}", source.display()))?;
        Ok((path.join(change(file)), change(&text)))
    };
    let files = FILES.map(read).into_iter().collect::<Result<Vec<(PathBuf, String)>, String>>()?;
    fs::create_dir(path).map_err(|error| format!("cannot create the new folder {}: {error}", path.display()))?;
    for (target, text) in files {
        let written = target.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&target, text));
        if let Err(error) = written {
            let _ = fs::remove_dir_all(path);
            return Err(format!("cannot write {}: {error}", target.display()));
        }
    }
    Ok(format!(
        "{0} has a model that works, {model}. Next:\n\n    cd {0}\n    cargo run --release --features package   # writes dist/{model}.fmu\n    \
         cargo test --release\n\nThen make it yours: README.md there says where to begin.\n",
        path.display()
    ))
}

/// The folder's name, if a crate can have it.
fn package_name(path: &Path) -> Result<String, String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(is_word) && !name.ends_with('-') {
        Ok(name)
    } else {
        Err(format!(
            "the new folder's name becomes the crate's: small letters, digits and -, as in dc-motor, not {name:?}"
        ))
    }
}

/// `dc-motor` becomes `DcMotor`.
fn model_name(package: &str) -> String {
    let capitalised = |word: &str| word[..1].to_ascii_uppercase() + &word[1..];
    package.split('-').filter(|word| !word.is_empty()).map(capitalised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names() {
        assert_eq!(model_name("dc-motor"), "DcMotor");
        assert_eq!(model_name("dc--motor-2"), "DcMotor2");
        assert_eq!(package_name(Path::new("../dc-motor")).unwrap(), "dc-motor");
        for wrong in ["DcMotor", "2nd", "dc_motor", "dc motor", "dc-", "..", ""] {
            assert!(package_name(Path::new(wrong)).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_new_crate_has_the_new_names_everywhere_and_never_replaces_anything() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let folder = std::env::temp_dir().join(format!("new-fmu-{}", std::process::id()));
        fs::create_dir(&folder).unwrap();
        let path = folder.join("dc-motor");
        let created = create(&root, &path);
        let manifest = fs::read_to_string(path.join("Cargo.toml")).unwrap_or_default();
        let library = fs::read_to_string(path.join("src/lib.rs")).unwrap_or_default();
        let program = fs::read_to_string(path.join("src/main.rs")).unwrap_or_default();
        let has_text = path.join("documentation/DcMotor.md").is_file();
        let again = create(&root, &path);
        let nowhere = create(&root, &folder.join("missing/dc-motor"));
        fs::remove_dir_all(&folder).unwrap();
        assert!(created.unwrap().contains("dist/DcMotor.fmu"));
        assert!(manifest.contains("name = \"dc-motor\"") && !manifest.contains("\".."), "{manifest}");
        assert!(library.contains("export!(DcMotor)") && program.contains("dc_motor::FMUS") && has_text);
        assert!(
            [manifest, library, program].iter().all(|text| !text.to_lowercase().contains("my")),
            "an old name is left"
        );
        assert!(again.is_err() && nowhere.is_err());
    }

    #[test]
    fn no_file_of_the_template_is_forgotten() {
        fn files(folder: &Path) -> Vec<PathBuf> {
            let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
            let ours = entries
                .filter(|path| !path.ends_with("target") && !path.ends_with("dist") && !path.ends_with("Cargo.lock"));
            ours.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
        }
        let template = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(TEMPLATE);
        let mut found = files(&template);
        found.sort();
        assert_eq!(found, FILES.map(|file| template.join(file)));
    }
}

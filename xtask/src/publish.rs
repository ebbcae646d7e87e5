//! Packages the crates for crates.io, unpacks the packages, and tests them outside the workspace.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;
use std::process::Command;

use crate::steps::{Outcome, run};
use crate::tree::Tree;

/// The step's name.
pub const STEP: &str = "Crates as they are published";

/// The crates, in the order of publication: each needs those before it only.
pub const CRATES: [&str; 6] =
    ["parameter-table", "fmi2-export-derive", "fmi2-export", "fmi2-package", "cargo-fmi2", "fmi2-import"];

/// They are compiled quickly: optimisation is not what is tested.
const OPTIMISATION: u8 = 0;

/// A crate without code that gives dependencies the same features as in the workspace, so that they are not compiled again.
const FEATURES: &str = "workspace-hack";

/// Packages the crates, unpacks them side by side, and tests the contents of the packages.
pub fn check(tree: &Tree) -> Outcome {
    let packages = CRATES.iter().flat_map(|name| ["--package", *name]);
    let mut package = tree.cargo(&["package", "--allow-dirty", "--no-verify", "--quiet"]);
    package.args(packages);
    let packaged = run(package);
    if packaged != Outcome::Passed {
        return packaged;
    }
    let folder = tree.target.join("published");
    if let Err(error) = unpack(tree, &folder) {
        return Outcome::Failed(format!("cannot unpack to {}: {error}", folder.display()));
    }
    let mut test = tree.cargo_all("test", &["--quiet"]);
    // What the packages contain is tested here, with fewer random calls, damaged states and repetitions; all of them, and the FMUs'
    // libraries, were among the Rust tests.
    let variables = [("FMI2_CALLS", "34000"), ("FMI2_BLOBS", "2000"), ("FMI2_CYCLES", "1000"), ("FMU_LIBRARIES", "")];
    test.current_dir(&folder).env("CARGO_TARGET_DIR", &tree.target).envs(variables);
    run(test)
}

/// Makes a workspace of the packages' contents.
fn unpack(tree: &Tree, folder: &Path) -> io::Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::create_dir_all(folder.join(FEATURES).join("src"))?;
    let root = fs::read_to_string(tree.root.join("Cargo.toml"))?;
    let version = version(&root).ok_or_else(|| io::Error::other("Cargo.toml has no [workspace.package] version"))?;
    for name in CRATES {
        let packed = tree.target.join("package").join(format!("{name}-{version}.crate"));
        // With the time of now: packages have one that never changes, and cargo would take the last ones' compiled code for theirs.
        let mut tar = Command::new("tar");
        tar.arg("-xzmf").arg(&packed).current_dir(folder);
        if !tar.status()?.success() {
            return Err(io::Error::other(format!("tar failed for {}", packed.display())));
        }
        fs::rename(folder.join(format!("{name}-{version}")), folder.join(name))?;
    }
    for file in ["Cargo.toml", "src/lib.rs"] {
        fs::copy(tree.root.join(FEATURES).join(file), folder.join(FEATURES).join(file))?;
    }
    // The versions that the workspace has: they have been compiled.
    fs::copy(tree.root.join("Cargo.lock"), folder.join("Cargo.lock"))?;
    fs::write(folder.join("Cargo.toml"), manifest(&root))
}

/// The workspace's manifest with only these members, which find each other here as on crates.io.
fn manifest(root: &str) -> String {
    let settings = root.find("[workspace.package]").map_or("", |at| &root[at..]);
    let members = CRATES.iter().chain([&FEATURES]).map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
    let mut settings = settings.to_owned();
    for name in CRATES {
        let section = format!("[profile.release.package.{name}]\n");
        // In place of the section that there may be: it may not stand there twice.
        if let Some(begin) = settings.find(&section) {
            let end = settings[begin + 1..].find("\n[").map_or(settings.len(), |length| begin + 1 + length + 1);
            settings.replace_range(begin..end, "");
        }
        let _ = write!(settings, "\n{section}opt-level = {OPTIMISATION}\n");
    }
    let mut text = format!("[workspace]\nresolver = \"3\"\nmembers = [{members}]\n\n{settings}\n[patch.crates-io]\n");
    for name in CRATES {
        let _ = writeln!(text, "{name} = {{ path = {name:?} }}");
    }
    text
}

/// The version that all crates have.
fn version(root: &str) -> Option<&str> {
    let (_, package) = root.split_once("[workspace.package]")?;
    package.lines().find_map(|line| line.strip_prefix("version = ")).map(|text| text.trim_matches('"'))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOT: &str = "[workspace]\nmembers = [\"a\"]\n\n[workspace.package]\nversion = \"1.2.3\"\n\n[profile.release]\nx = 1\n\n\
         [profile.release.package.fmi2-package]\ncodegen-units = 1\n\n# About another.\n[profile.release.package.other]\nopt-level = 0\n";

    #[test]
    fn the_manifest_has_other_members_and_the_same_settings() {
        let text = manifest(ROOT);
        assert!(text.contains("members = [\"parameter-table\", ") && !text.contains("\"a\""), "{text}");
        assert!(text.contains("[profile.release]\nx = 1") && text.contains("fmi2-import = { path = "), "{text}");
        assert_eq!(text.matches("[profile.release.package.fmi2-package]").count(), 1, "a section twice is no TOML");
        assert!(text.contains("[profile.release.package.other]\nopt-level = 0\n"), "{text}");
        assert_eq!(text.matches("opt-level = 0").count(), CRATES.len() + 1, "{text}");
        assert_eq!(version(ROOT), Some("1.2.3"));
    }

    /// A crate that is published first cannot need a later one, and every crate without `publish = false` is in the list.
    #[test]
    fn the_order_of_publication_is_possible_and_no_crate_is_forgotten() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let manifest = |name: &str| fs::read_to_string(root.join(name).join("Cargo.toml")).unwrap();
        for (i, name) in CRATES.iter().enumerate() {
            let needs = |other: &&&str| {
                let line = |line: &str| line.starts_with(**other) && line[other.len()..].starts_with([' ', '.']);
                manifest(name).lines().any(line)
            };
            assert_eq!(CRATES[i..].iter().find(needs), None, "{name} is published before what it needs");
        }
        let mut published: Vec<String> = fs::read_dir(root)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| root.join(name).join("src").is_dir() && !manifest(name).contains("publish = false"))
            .collect();
        published.sort();
        let mut listed = CRATES.map(str::to_owned).to_vec();
        listed.sort();
        assert_eq!(published, listed);
    }
}

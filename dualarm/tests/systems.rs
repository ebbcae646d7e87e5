//! The systems' checked-in descriptions are current.

use std::fs;
use std::path::{Path, PathBuf};

use dualarm::grasp::systems;

#[test]
fn checked_in_descriptions_are_current() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
    let mut wanted = Vec::new();
    for (path, text) in systems::describe_packages(&folder).unwrap() {
        let kept = fs::read_to_string(folder.join(&path)).unwrap_or_default();
        assert!(kept == text, "modelDescription/{path} is not current: run `cargo xtask describe`");
        wanted.push(folder.join(path));
    }
    let mut folders: Vec<PathBuf> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.retain(|path| path.is_dir());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                assert!(wanted.contains(&path), "{} belongs to no package any more", path.display());
            }
        }
    }
}

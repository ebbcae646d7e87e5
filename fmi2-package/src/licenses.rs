//! The licences of the crates that are linked into a library. Most of them demand that their text accompanies the binary.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

/// A list of the crates that are linked into the library of `root` (an identifier of a package), with the texts of their
/// licences, each text once. `metadata` is the output of `cargo metadata`.
pub fn text(metadata: &Value, root: &str) -> String {
    let packages: BTreeMap<&str, &Value> =
        list(&metadata["packages"]).iter().filter_map(|package| Some((package["id"].as_str()?, package))).collect();
    let nodes: BTreeMap<&str, &Value> =
        list(&metadata["resolve"]["nodes"]).iter().filter_map(|node| Some((node["id"].as_str()?, node))).collect();
    let mut linked: BTreeSet<&str> = BTreeSet::new();
    let mut waiting = vec![root];
    while let Some(id) = waiting.pop() {
        for dependency in nodes.get(id).map_or(&[][..], |node| list(&node["deps"])) {
            // Without dependencies of tests and of build scripts.
            let is_normal = list(&dependency["dep_kinds"]).iter().any(|kind| kind["kind"].is_null());
            let Some(id) = dependency["pkg"].as_str() else { continue };
            if is_normal && packages.get(id).is_some_and(|package| !is_macro(package)) && linked.insert(id) {
                waiting.push(id);
            }
        }
    }
    let mut crates: Vec<&Value> = linked.iter().filter_map(|id| packages.get(id).copied()).collect();
    crates.sort_by_key(|package| (package["name"].as_str(), package["version"].as_str()));
    let mut text = String::from(
        "Crates whose code the library in this archive may contain, besides the model's own. Where a crate offers several\n\
         licences, any of them will do.\n\n",
    );
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in crates {
        let name = format!("{} {}", string(&package["name"]), string(&package["version"]));
        let _ = writeln!(text, "{name}: {}", package["license"].as_str().unwrap_or("see its text below"));
        let folder = Path::new(string(&package["manifest_path"])).parent().unwrap_or(Path::new(""));
        for content in license_files(folder) {
            texts.entry(content).or_default().push(name.clone());
        }
    }
    text.push_str("The standard library of Rust (https://www.rust-lang.org): MIT OR Apache-2.0\n");
    for (content, names) in texts {
        let _ = write!(text, "\n{}\n{}\n\n{}\n", "=".repeat(80), names.join(", "), content.trim_end());
    }
    text
}

fn is_macro(package: &Value) -> bool {
    list(&package["targets"]).iter().any(|target| list(&target["kind"]).iter().any(|kind| kind == "proc-macro"))
}

/// The texts in a crate's folder, in the order of their names.
fn license_files(folder: &Path) -> Vec<String> {
    let is_license = |name: &str| {
        let name = name.to_uppercase();
        ["LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE", "UNLICENSE"]
            .iter()
            .any(|start| name.starts_with(start))
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries
        .map(|entry| entry.path())
        .filter(|path| path.is_file())
        .filter(|path| path.file_name().is_some_and(|name| is_license(&name.to_string_lossy())))
        .collect();
    names.sort();
    names.iter().filter_map(|path| fs::read_to_string(path).ok()).map(|text| text.replace("\r\n", "\n")).collect()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn string(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn what_is_linked_is_listed_with_its_texts_once() {
        let folder = tempfile::tempdir().unwrap();
        let package = |name: &str, license: Option<&str>, kind: &str, text: &str| {
            let home = folder.path().join(name);
            fs::create_dir(&home).unwrap();
            fs::write(home.join("LICENSE-MIT"), text).unwrap();
            fs::write(home.join("README"), "no licence").unwrap();
            json!({ "id": name, "name": name, "version": "1.2.3", "license": license,
                    "manifest_path": home.join("Cargo.toml"), "targets": [{ "kind": [kind] }] })
        };
        let dependency = |name: &str, kind: Option<&str>| json!({ "pkg": name, "dep_kinds": [{ "kind": kind }] });
        let metadata = json!({
            "packages": [
                package("model", Some("MIT"), "lib", "text of the model"),
                package("b", Some("MIT"), "lib", "shared text\r\n"),
                package("a", None, "lib", "shared text\n"),
                package("derive", Some("MIT"), "proc-macro", "of a macro"),
                package("tests", Some("MIT"), "lib", "of tests"),
                package("unrelated", Some("MIT"), "lib", "of nothing"),
            ],
            "resolve": { "nodes": [
                { "id": "model", "deps": [dependency("b", None), dependency("derive", None), dependency("tests", Some("dev"))] },
                { "id": "b", "deps": [dependency("a", None)] },
                { "id": "a", "deps": [dependency("b", None)] },
            ]},
        });
        let text = text(&metadata, "model");
        assert!(text.contains("a 1.2.3: see its text below\nb 1.2.3: MIT\n"), "{text}");
        assert!(text.contains("a 1.2.3, b 1.2.3\n\nshared text\n") && text.matches("shared text").count() == 1);
        for absent in ["text of the model", "of a macro", "of tests", "of nothing", "no licence"] {
            assert!(!text.contains(absent), "{absent}");
        }
    }
}

//! FMUs that were built elsewhere, for other platforms, from the same descriptions.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use fmi2_import::Fmu;
use fmi2_package::platform::Platform;

use super::PackageError;

/// An FMU from elsewhere.
#[derive(Debug)]
pub struct Merged {
    path: PathBuf,
    name: String,
    guid: String,
    folders: Vec<String>,
}

impl Merged {
    /// Those that the user names: archives, or folders of them.
    pub fn read(paths: &[PathBuf]) -> Result<Vec<Self>, PackageError> {
        let mut merged = Vec::new();
        for path in paths {
            for path in archives(path)? {
                let contents = Fmu::inspect(&path)?;
                let folders = contents.platforms().into_iter().map(str::to_owned).collect();
                let (name, guid) = (contents.description.model_name.clone(), contents.description.guid.clone());
                merged.push(Self { path, name, guid, folders });
            }
        }
        Ok(merged)
    }
}

/// An archive, or all those in a folder, sorted.
fn archives(path: &Path) -> Result<Vec<PathBuf>, PackageError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let wrong = |problem: String| PackageError::Merge { path: path.to_owned(), problem };
    let entries = fs::read_dir(path).map_err(|error| wrong(error.to_string()))?;
    let mut found: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    found.retain(|path| path.extension().is_some_and(|extension| extension == "fmu"));
    found.sort();
    if found.is_empty() { Err(wrong("there is no .fmu in it".into())) } else { Ok(found) }
}

/// Names and GUIDs of models, as a packaging program prints them.
pub fn read_guids(text: &str) -> BTreeMap<String, String> {
    let entries = text.split(';').filter_map(|entry| entry.split_once('='));
    entries.map(|(name, guid)| (name.to_owned(), guid.to_owned())).collect()
}

/// Assigns each FMU to the crate of its model: the archives for each crate's packaging program.
///
/// # Errors
/// If one belongs to no crate, with the differences.
pub fn assign(merged: &[Merged], guids: &[BTreeMap<String, String>]) -> Result<Vec<Vec<PathBuf>>, PackageError> {
    let mut archives = vec![Vec::new(); guids.len()];
    for Merged { path, name, guid, .. } in merged {
        let wrong = |problem| PackageError::Merge { path: path.clone(), problem };
        let Some(index) = guids.iter().position(|of_crate| of_crate.contains_key(name)) else {
            return Err(wrong(format!("its model {name} is none of ours")));
        };
        if guids[index][name] != *guid {
            return Err(wrong(format!(
                "its GUID is {guid}, that of {name} here is {}: it was made from another version of the sources",
                guids[index][name]
            )));
        }
        archives[index].push(path.clone());
    }
    Ok(archives)
}

/// Whether the archives have a library for this platform for each of the models.
pub fn covers(merged: &[Merged], guids: &[BTreeMap<String, String>], platform: &Platform) -> bool {
    let has = |name: &String| {
        merged.iter().any(|one| one.name == *name && one.folders.iter().any(|folder| folder == platform.folder))
    };
    guids.iter().flat_map(BTreeMap::keys).all(has)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn merged(name: &str, guid: &str, folder: &str) -> Merged {
        let path = format!("{folder}/{name}.fmu").into();
        Merged { path, name: name.into(), guid: guid.into(), folders: vec![folder.into()] }
    }

    #[test]
    fn archives_go_to_the_crate_of_their_model() {
        let guids = ["Plant={1}", "Pd={2};Pds={3}"].map(read_guids);
        let all = [merged("Pds", "{3}", "win64"), merged("Plant", "{1}", "win64"), merged("Pd", "{2}", "win64")];
        let assigned = assign(&all, &guids).unwrap();
        assert_eq!(
            assigned,
            [vec!["win64/Plant.fmu"], vec!["win64/Pds.fmu", "win64/Pd.fmu"]]
                .map(|paths| { paths.into_iter().map(PathBuf::from).collect::<Vec<_>>() })
        );
        let [win64, linux64] = ["win64", "linux64"].map(|name| Platform::named(name).unwrap());
        assert!(covers(&all, &guids, win64));
        assert!(!covers(&all[1..], &guids, win64) && !covers(&all, &guids, linux64));
    }

    #[test]
    fn what_is_not_ours_is_refused() {
        let guids = ["Plant={1}"].map(read_guids);
        for (other, reason) in
            [(merged("Pump", "{1}", "win64"), "none of ours"), (merged("Plant", "{2}", "win64"), "{2}")]
        {
            let error = assign(&[other], &guids).unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
        }
    }
}

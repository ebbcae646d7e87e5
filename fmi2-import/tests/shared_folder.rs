//! FMUs that are nothing but a library can share a folder. A process has one such folder: this test is alone in its program.

mod support;

use std::fs;
use std::path::{Path, PathBuf};

use fmi2_import::{Experiment, Fmu, Instance};
use support::{archive, description, library};

/// How many libraries are there; besides, there is the empty folder that FMUs take for their resources.
fn files(folder: &Path) -> usize {
    assert_eq!(fs::read_dir(folder.join("resources")).unwrap().count(), 0);
    fs::read_dir(folder).unwrap().count() - 1
}

fn resources(instance: &mut Instance) -> PathBuf {
    PathBuf::from(instance.get_string(1).unwrap().strip_prefix("file://").unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn libraries_that_are_alone_share_a_folder_and_leave_it_empty() {
    let folder = tempfile::tempdir().unwrap();
    let (path, shared) = (folder.path().join("lag.fmu"), folder.path().join("shared"));
    let Some(lag) = library("Lag") else { return };
    archive(&path, &[("modelDescription.xml", description("Lag").as_bytes()), ("binaries/linux64/Lag.so", lag)]);
    fs::create_dir(&shared).unwrap();
    Fmu::share_folder(&shared);

    // Several FMUs whose libraries have one name.
    let mut fmus = Fmu::unpack_all(&[&path, &path, &path]).unwrap();
    assert_eq!(files(&shared), 3);
    fmus.pop();
    assert_eq!(files(&shared), 2);
    let mut instances: Vec<_> = fmus.iter().map(|fmu| fmu.instantiate("lag").unwrap()).collect();
    drop(fmus);
    assert_eq!(files(&shared), 2, "instances use them");
    assert_eq!(resources(&mut instances[0]), shared.join("resources"));
    instances.pop();
    assert_eq!(files(&shared), 1);
    instances[0].setup_experiment(Experiment { start: 0.0, stop: None, tolerance: None }).unwrap();
    drop(instances);
    assert_eq!(files(&shared), 0);

    // One that is damaged leaves nothing, either.
    let whole = fs::read(&path).unwrap();
    let mut damaged = whole.clone();
    let library_begins = whole.windows(4).position(|bytes| bytes == b"\x7fELF");
    let place = library_begins.map_or(whole.len() / 2, |begin| begin + 64);
    damaged[place] ^= 0xff;
    fs::write(&path, damaged).unwrap();
    assert!(Fmu::unpack(&path).is_err());
    assert_eq!(files(&shared), 0);

    // Without the folder, each has its own.
    fs::write(&path, whole).unwrap();
    fs::remove_dir_all(&shared).unwrap();
    let mut instance = Fmu::open(&path).unwrap().instantiate("lag").unwrap();
    let own = resources(&mut instance);
    assert!(own.is_dir() && own != shared);
    drop(instance);
    assert!(!own.exists());
}

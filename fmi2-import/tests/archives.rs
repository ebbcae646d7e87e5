//! Archives and the libraries in them: what is no usable FMU is refused by name before anything is loaded,
//! and what odd packers wrote is read as it is meant.

mod support;

use std::fs;
use std::path::{Path, PathBuf};

use fmi2_import::Fmu;
use support::{archive, description, package};

#[test]
fn what_is_no_usable_fmu_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.fmu");
    let expect = |expected: &str| {
        let message = Fmu::open(&path).expect_err("must not open").to_string();
        assert!(message.contains(expected) && message.contains("x.fmu"), "{message:?} should contain {expected:?}");
    };
    expect("cannot read");
    fs::write(&path, "hello").unwrap();
    expect("not a readable zip archive");
    fs::write(&path, "").unwrap();
    expect("not a readable zip archive");
    archive(&path, &[("readme.txt", b"")]);
    expect("no modelDescription.xml");
    archive(&path, &[("modelDescription.xml", b"<a>")]);
    expect("not well-formed XML");

    let lag = description("Lag");
    archive(&path, &[("modelDescription.xml", lag.replace("\"2.0\"", "\"3.0\"").as_bytes())]);
    expect("written for FMI 3.0");
    archive(&path, &[("modelDescription.xml", lag.replace("CoSimulation", "ModelExchange").as_bytes())]);
    expect("only model exchange");
    archive(&path, &[("modelDescription.xml", lag.as_bytes()), ("binaries/vax/Lag.so", b"")]);
    expect("for this platform (it has: binaries/vax/Lag.so)");
    let entry = format!("binaries/linux64/Lag{}", std::env::consts::DLL_SUFFIX);
    if cfg!(target_os = "linux") {
        archive(&path, &[("modelDescription.xml", lag.as_bytes()), (&entry, b"no library")]);
        expect("the system cannot load it");
        let evil = [("modelDescription.xml", lag.as_bytes()), (&entry, b""), ("../outside.txt", b"evil")];
        archive(&path, &evil);
        expect("points outside the archive");
        assert!(!folder.path().join("outside.txt").exists());
    }
    fs::remove_file(&path).unwrap();
    fs::create_dir(&path).unwrap();
    expect("it is a folder");
}

#[test]
fn a_library_without_a_needed_function_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    // A system library loads but is no FMU.
    let Some(path) = package(folder.path(), "Lag") else { return };
    let Some(other) =
        ["/lib/x86_64-linux-gnu/libm.so.6", "/usr/lib64/libm.so.6"].iter().find_map(|path| fs::read(path).ok())
    else {
        return;
    };
    archive(&path, &[("modelDescription.xml", description("Lag").as_bytes()), ("binaries/linux64/Lag.so", &other)]);
    let message = Fmu::open(&path).unwrap_err().to_string();
    assert!(message.contains("lacks the function fmi2GetTypesPlatform"), "{message}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_library_that_is_cut_off_is_refused_before_it_kills_us() {
    let folder = tempfile::tempdir().unwrap();
    let Ok(whole) = fs::read("/proc/self/exe") else { return };
    let path = folder.path().join("x.fmu");
    let lag = description("Lag");
    for parts in 1..8 {
        let library = &whole[..whole.len() / 8 * parts];
        archive(&path, &[("modelDescription.xml", lag.as_bytes()), ("binaries/linux64/Lag.so", library)]);
        let message = Fmu::open(&path).unwrap_err().to_string();
        // Debug information belongs to no segment: without it, the test program is whole, but no library.
        assert!(message.contains("it is cut off") || message.contains("cannot load it"), "{message}");
    }
}

/// Writes an archive with the fixture's library under this name.
fn with_library(path: &Path, lag: &[u8], entries: &[(&str, &[u8])]) {
    let description = description("Lag");
    let own = [("modelDescription.xml", description.as_bytes()), ("binaries/linux64/Lag.so", lag)];
    archive(path, &[&own, entries].concat());
}

/// The fixture's library.
fn library(folder: &Path) -> Option<Vec<u8>> {
    let path = package(folder, "Lag")?;
    let mut zip = zip::ZipArchive::new(fs::File::open(path).unwrap()).unwrap();
    let mut library = Vec::new();
    std::io::Read::read_to_end(&mut zip.by_name("binaries/linux64/Lag.so").ok()?, &mut library).unwrap();
    Some(library)
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_library_for_another_machine_is_named_and_one_for_this_found() {
    let folder = tempfile::tempdir().unwrap();
    let Some(lag) = library(folder.path()) else { return };
    let path = folder.path().join("x.fmu");
    let message = |library: &[u8]| {
        with_library(&path, library, &[]);
        Fmu::open(&path).unwrap_err().to_string()
    };
    let mut foreign = lag.clone();
    foreign[18] = 183; // e_machine: AArch64
    let refused = "it is for Linux (ELF) on aarch64, and this is Linux (ELF) on x86_64";
    assert!(message(&foreign).ends_with(refused), "{}", message(&foreign));
    assert!(message(b"").ends_with("it is empty"));
    with_library(&path, &foreign, &[("binaries/x86_64-linux/Lag.so", lag.as_slice())]);
    assert!(Fmu::open(&path).is_ok(), "another folder of this platform has one that fits");
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_library_is_judged_without_being_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let Some(lag) = library(folder.path()) else { return };
    let path = folder.path().join("x.fmu");
    let check = |library: &[u8]| {
        with_library(&path, library, &[]);
        Fmu::check_library(&path).map_err(|error| error.to_string())
    };
    assert_eq!(check(&lag), Ok(()));
    assert!(check(b"no library").unwrap_err().ends_with("it is not a shared library"));
    let Ok(other) = fs::read("/proc/self/exe") else { return };
    assert!(check(&other).unwrap_err().contains("it lacks the function fmi2GetTypesPlatform"));
}

#[cfg(target_os = "linux")]
#[test]
fn archives_of_odd_packers_are_read_as_they_are_meant() {
    let folder = tempfile::tempdir().unwrap();
    let Some(lag) = library(folder.path()) else { return };
    let (path, description) = (folder.path().join("x.fmu"), description("Lag"));
    for [model, binary, resource] in [
        ["./modelDescription.xml", "./binaries/linux64/Lag.so", "./resources/table.txt"],
        ["modelDescription.xml", "binaries\\linux64\\Lag.so", "resources\\table.txt"],
        [".\\modelDescription.xml", ".\\binaries\\.\\linux64/Lag.so", "x/../resources//table.txt"],
    ] {
        archive(&path, &[(model, description.as_bytes()), (binary, &lag), (resource, b"1 2 3")]);
        let mut instance = Fmu::open(&path).unwrap().instantiate("lag").unwrap();
        let resources = instance.get_string(1).unwrap();
        let table = PathBuf::from(resources.strip_prefix("file://").unwrap()).join("table.txt");
        assert_eq!(fs::read_to_string(table).unwrap(), "1 2 3", "{binary}");
    }
    let twice = [("modelDescription.xml", description.as_bytes()), ("resources/a", b"1"), ("resources\\a", b"2")];
    archive(&path, &twice);
    let message = Fmu::open(&path).unwrap_err().to_string();
    assert!(message.contains("\"resources/a\" and \"resources\\a\" are the same file"), "{message}");
    for evil in ["..\\outside.txt", "resources\\..\\..\\outside.txt", "\\outside.txt", "C:\\outside.txt"] {
        archive(&path, &[("modelDescription.xml", description.as_bytes()), (evil, b"evil")]);
        let message = Fmu::open(&path).unwrap_err().to_string();
        assert!(message.contains("points outside the archive"), "{evil}: {message}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn archives_that_grow_beyond_all_measure_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let Some(lag) = library(folder.path()) else { return };
    let path = folder.path().join("x.fmu");
    let zeros = vec![0; 90 << 20];
    with_library(&path, &lag, &[("resources/zeros", &zeros)]);
    assert!(fs::metadata(&path).unwrap().len() < 1 << 20);
    let message = Fmu::open(&path).unwrap_err().to_string();
    assert!(message.contains("resources/zeros is too large; this tool unpacks at most"), "{message}");
    with_library(&path, &lag, &[("resources/zeros", &zeros[..60 << 20])]);
    assert!(Fmu::open(&path).is_ok());
    let bomb = [b"<fmiModelDescription>".as_slice(), &vec![b' '; 90 << 20]].concat();
    archive(&path, &[("modelDescription.xml", &bomb)]);
    assert!(Fmu::read_description(&path).unwrap_err().to_string().contains("modelDescription.xml is too large"));
}

/// The zip reader would keep the last of them; which one is meant nobody can know.
#[test]
fn two_entries_of_one_name_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.fmu");
    let lag = description("Lag");
    let model = ("modelDescription.xml", lag.as_bytes());
    // The writer refuses equal names, so they become equal in the bytes of headers and directory.
    let open = |entries: &[(&str, &[u8])], before: &[u8]| {
        archive(&path, entries);
        let mut bytes = fs::read(&path).unwrap();
        let places: Vec<_> = (0..bytes.len()).filter(|at| bytes[*at..].starts_with(b"~second")).collect();
        for at in places {
            bytes[at..at + 7].copy_from_slice(b"~former");
        }
        fs::write(&path, [before, &bytes].concat()).unwrap();
        Fmu::read_description(&path).map_err(|error| error.to_string())
    };
    for before in [b"".as_slice(), b"#!/bin/sh\n"] {
        let message = open(&[("resources/~former", b"1"), model, ("resources/~second", b"2")], before).unwrap_err();
        assert!(message.contains("it contains the entry \"resources/~former\" twice"), "{message}");
        assert!(message.contains("x.fmu"), "{message}");
        open(&[("resources/~former", b"1"), model, ("resources/a", b"2")], before).unwrap();
    }
    let message = open(&[model, ("./modelDescription.xml", lag.as_bytes())], b"").unwrap_err();
    assert!(message.contains("\"modelDescription.xml\" and \"./modelDescription.xml\" are the same file"), "{message}");
    // A folder may be there several times.
    open(&[model, ("resources~former/", b""), ("resources~second/", b"")], b"").unwrap();
}

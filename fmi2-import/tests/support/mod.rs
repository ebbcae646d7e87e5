//! Small FMUs compiled from C, for the tests.
#![allow(dead_code)] // every test file uses a part

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

pub const GUID: &str = "{fixture}";

/// The source of both models.
const SLAVE: &str = include_str!("../fixtures/slave.c");

/// The slave compiled as `Lag` or `Gain`, once per process; `None` (with a message) without a C compiler.
pub fn library(model: &str) -> Option<&'static [u8]> {
    static LAG: OnceLock<Option<Vec<u8>>> = OnceLock::new();
    static GAIN: OnceLock<Option<Vec<u8>>> = OnceLock::new();
    let library = if model == "Gain" { &GAIN } else { &LAG };
    library.get_or_init(|| compile(model == "Gain")).as_deref()
}

fn compile(as_gain: bool) -> Option<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("slave.c");
    fs::write(&source, SLAVE).unwrap();
    compile_library(&source, if as_gain { &["-DGAIN", "-lm"] } else { &["-lm"] })
}

/// A shared library of a C file; `None` (with a message) without a C compiler.
pub fn compile_library(source: &Path, options: &[&str]) -> Option<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("library");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let mut command = Command::new(&compiler);
    match command.args(["-shared", "-fPIC", "-O2", "-o"]).arg(&library).arg(source).args(options).output() {
        Err(error) => {
            eprintln!("SKIPPED: the C compiler \"{compiler}\" cannot be run ({error})");
            None
        }
        Ok(output) => {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            Some(fs::read(library).unwrap())
        }
    }
}

/// The description of `Lag` or `Gain`.
pub fn description(model: &str) -> String {
    let (input, parameter, output, dependencies) = match model {
        "Gain" => ("y", "K", "u", "1 4"),
        _ => ("u", "T", "y", ""),
    };
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="{GUID}">
  <CoSimulation modelIdentifier="{model}" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true"/>
  <TypeDefinitions><SimpleType name="Trouble"><Enumeration>
    <Item name="warning" value="1"/><Item name="discard" value="2"/><Item name="error" value="3"/><Item name="fatal" value="4"/>
  </Enumeration></SimpleType></TypeDefinitions>
  <DefaultExperiment stopTime="2" stepSize="0.1"/>
  <ModelVariables>
    <ScalarVariable name="{input}" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="{parameter}" valueReference="1" causality="parameter" variability="fixed"><Real start="1" min="0"/></ScalarVariable>
    <ScalarVariable name="{output}" valueReference="2" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="reference" valueReference="3" causality="input"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="trouble_at" valueReference="4" causality="parameter" variability="fixed"><Real start="1e30" unit="s"/></ScalarVariable>
    <ScalarVariable name="trouble" valueReference="0" causality="parameter" variability="fixed"><Enumeration declaredType="Trouble" start="3"/></ScalarVariable>
    <ScalarVariable name="steps" valueReference="1" causality="output" variability="discrete"><Integer/></ScalarVariable>
    <ScalarVariable name="{input}_on" valueReference="0" causality="input" variability="discrete"><Boolean start="false"/></ScalarVariable>
    <ScalarVariable name="{output}_on" valueReference="1" causality="output" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="label" valueReference="0" causality="parameter" variability="fixed"><String start="fixture"/></ScalarVariable>
    <ScalarVariable name="resources" valueReference="1" causality="output" variability="discrete"><String/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="3" dependencies="{dependencies}"/><Unknown index="7"/><Unknown index="9"/><Unknown index="11"/></Outputs></ModelStructure>
</fmiModelDescription>"#
    )
}

/// Writes an archive with these entries.
pub fn archive(path: &Path, entries: &[(&str, &[u8])]) {
    let mut zip = ZipWriter::new(File::create(path).unwrap());
    for (name, content) in entries {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap();
}

/// Packages `Lag` or `Gain` with a changed description.
pub fn package_as(folder: &Path, model: &str, change: impl Fn(String) -> String) -> Option<PathBuf> {
    let library = library(model)?;
    let path = folder.join(format!("{model}.fmu"));
    let platform = match std::env::consts::OS {
        "macos" => "darwin64",
        "windows" => "win64",
        _ => "linux64",
    };
    let description = change(description(model));
    archive(
        &path,
        &[
            ("modelDescription.xml", description.as_bytes()),
            (&format!("binaries/{platform}/{model}{}", std::env::consts::DLL_SUFFIX), library),
            ("resources/table.txt", b"1 2 3"),
            ("documentation/index.html", b"<p>"),
        ],
    );
    Some(path)
}

/// Packages `Lag` or `Gain`.
pub fn package(folder: &Path, model: &str) -> Option<PathBuf> {
    package_as(folder, model, |description| description)
}

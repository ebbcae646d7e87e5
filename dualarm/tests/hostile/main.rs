//! FMUs that misbehave towards the process they are loaded into: results are kept, nothing is lost in silence, exit codes
//! tell. The slave is `fixtures/hostile.c`.
#![cfg(unix)]

#[path = "../../../fmi2-import/tests/support/mod.rs"]
mod support;

mod ends;
mod input;
mod results;

use std::fs;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;
use support::{archive, compile_library};
use tempfile::TempDir;

/// The description of the slave, as a model of this name.
fn description(model: &str) -> String {
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{model}" guid="hostile">
  <CoSimulation modelIdentifier="Hostile" canHandleVariableCommunicationStepSize="true"/>
  <UnitDefinitions><Unit name="rad"><BaseUnit rad="1"/></Unit>
    <Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit><Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="slow" value="1"/><Item name="fast" value="2"/></Enumeration></SimpleType></TypeDefinitions>
  <DefaultExperiment stopTime="1" stepSize="0.1" tolerance="1e-5"/>
  <ModelVariables>
    <ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="tolerance" valueReference="1" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="u" valueReference="2" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="words" valueReference="0" causality="output" variability="discrete"><String/></ScalarVariable>
    <!-- more -->
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="1"/><Unknown index="2"/><Unknown index="4"/></Outputs></ModelStructure>
</fmiModelDescription>"#
    )
}

/// Compiles the slave; `None` (with a message) without a C compiler.
fn library() -> Option<Vec<u8>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/hostile.c");
    compile_library(&source, &["-O1"])
}

/// A folder with FMUs of these models, their variables changed by `change`, and a folder for temporary files.
fn fixtures(models: &[&str], change: impl Fn(&str, String) -> String) -> Option<TempDir> {
    let library = library()?;
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("tmp")).unwrap();
    for model in models {
        let entry = format!("binaries/{}/Hostile{}", fmi2_import::platform(), std::env::consts::DLL_SUFFIX);
        let description = change(model, description(model));
        let entries = [("modelDescription.xml", description.as_bytes()), (entry.as_str(), library.as_slice())];
        archive(&folder.path().join(format!("{model}.fmu")), &entries);
    }
    Some(folder)
}

fn hostile() -> Option<TempDir> {
    fixtures(&["Hostile"], |_, text| text)
}

fn command(folder: &Path, behaviour: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dualarm"));
    command.current_dir(folder).env("HOSTILE", behaviour).env("TMPDIR", folder.join("tmp")).args(arguments);
    command
}

fn run(folder: &Path, behaviour: &str, arguments: &[&str]) -> Output {
    command(folder, behaviour, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The times of a CSV file, as they are written.
fn times(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    text.lines().skip(1).map(|line| line.split(',').next().unwrap().to_owned()).collect()
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

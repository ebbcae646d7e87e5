//! Command line of the packaging program.

use std::path::PathBuf;

use crate::PackageError;
use crate::platform::Platform;

pub const HELP: &str = "\
Builds the FMU library of this crate and packages it.

Usage: cargo fmi2 package [OPTIONS]
       cargo run --release --features package -- [OPTIONS]

Options:
  -o, --out DIR         folder for the .fmu files [default: dist]
      --platform NAMES  build for these platforms, e.g. linux64,win64 [default: this machine's, and all others whose
                        toolchains are installed]
      --require NAMES   fail if one of these platforms is missing in the end
      --merge FILE      take the libraries for further platforms from this .fmu, which was built elsewhere from the
                        same description; can be repeated
      --library FILE    package this built library (.so, .dll, .dylib) instead of building it; can be repeated, once
                        for each platform
      --describe DIR    only write each model's description as DIR/NAME.xml
      --guids           only print the models' GUIDs, as the variable FMI2_EXPORT_GUIDS must have them where a library
                        for --library is built
  -h, --help            print this help

Toolchains:
  win64                        rustup target add x86_64-pc-windows-gnu, and mingw-w64
  linux64, for old systems     cargo-zigbuild and zig (pip install cargo-zigbuild ziglang): the library then needs glibc
                               2.17, otherwise that of this machine; documentation/externalDependencies.txt in the
                               archive says which
  aarch64-linux                rustup target add aarch64-unknown-linux-gnu, and zig as above or gcc-aarch64-linux-gnu
  darwin64, aarch64-darwin     a Mac, with rustup target add x86_64-apple-darwin or aarch64-apple-darwin

Examples:
  cargo fmi2 package                           dist/NAME.fmu for each model of the crate
  cargo fmi2 package --require linux64,win64   only if it runs on both
  cargo fmi2 package --describe descriptions   the XML, to look at or to check in
";

#[derive(Debug)]
pub enum Command {
    Help,
    Describe { out: PathBuf },
    Guids,
    Package(Options),
}

#[derive(Debug)]
pub struct Options {
    pub out: PathBuf,
    /// Libraries that were built before; if empty, they are built.
    pub libraries: Vec<PathBuf>,
    pub platforms: Vec<&'static Platform>,
    pub required: Vec<&'static Platform>,
    pub merged: Vec<PathBuf>,
}

pub fn parse() -> Result<Command, PackageError> {
    use lexopt::prelude::*;
    let usage = |error: lexopt::Error| PackageError::Usage(error.to_string());
    let mut options = Options {
        out: PathBuf::from("dist"),
        libraries: Vec::new(),
        platforms: Vec::new(),
        required: Vec::new(),
        merged: Vec::new(),
    };
    let (mut describe, mut guids) = (None, false);
    let mut parser = lexopt::Parser::from_env();
    while let Some(argument) = parser.next().map_err(usage)? {
        match argument {
            Short('h') | Long("help") => return Ok(Command::Help),
            Short('o') | Long("out") => options.out = parser.value().map_err(usage)?.into(),
            Long("library") => options.libraries.push(parser.value().map_err(usage)?.into()),
            Long("platform") => options.platforms.extend(platforms(&mut parser)?),
            Long("require") => options.required.extend(platforms(&mut parser)?),
            Long("merge") => options.merged.push(parser.value().map_err(usage)?.into()),
            Long("describe") => describe = Some(parser.value().map_err(usage)?.into()),
            Long("guids") => guids = true,
            other => return Err(usage(other.unexpected())),
        }
    }
    if !options.libraries.is_empty() && !options.platforms.is_empty() {
        return Err(PackageError::Usage(
            "--library and --platform exclude each other: a library tells its platform".into(),
        ));
    }
    Ok(match describe {
        Some(out) => Command::Describe { out },
        None if guids => Command::Guids,
        None => Command::Package(options),
    })
}

/// Names separated by commas.
fn platforms(parser: &mut lexopt::Parser) -> Result<Vec<&'static Platform>, PackageError> {
    let names = parser.value().map_err(|error| PackageError::Usage(error.to_string()))?;
    Platform::list(&names.to_string_lossy()).map_err(PackageError::Usage)
}

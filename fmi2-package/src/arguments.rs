//! Command line of the packaging program.

use std::path::PathBuf;

use crate::PackageError;

pub const HELP: &str = "\
Builds the FMU library of this crate and packages it.

Usage: cargo fmi2 package [OPTIONS]
       cargo run --release --features package -- [OPTIONS]

Options:
  -o, --out DIR       folder for the .fmu files [default: dist]
      --library FILE  package this built library (.so, .dll, .dylib) instead of building it
      --describe DIR  only write each model's description as DIR/NAME.xml
  -h, --help          print this help

Examples:
  cargo fmi2 package                           dist/NAME.fmu for each model of the crate
  cargo fmi2 package --describe descriptions   the XML, to look at or to check in
";

#[derive(Debug)]
pub enum Command {
    Help,
    Describe { out: PathBuf },
    Package { out: PathBuf, library: Option<PathBuf> },
}

pub fn parse() -> Result<Command, PackageError> {
    use lexopt::prelude::*;
    let usage = |error: lexopt::Error| PackageError::Usage(error.to_string());
    let (mut out, mut library, mut describe) = (PathBuf::from("dist"), None, None);
    let mut parser = lexopt::Parser::from_env();
    while let Some(argument) = parser.next().map_err(usage)? {
        match argument {
            Short('h') | Long("help") => return Ok(Command::Help),
            Short('o') | Long("out") => out = parser.value().map_err(usage)?.into(),
            Long("library") => library = Some(parser.value().map_err(usage)?.into()),
            Long("describe") => describe = Some(parser.value().map_err(usage)?.into()),
            other => return Err(usage(other.unexpected())),
        }
    }
    Ok(match describe {
        Some(out) => Command::Describe { out },
        None => Command::Package { out, library },
    })
}

//! The argument of `--controller`.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, PossibleValuesParser, StyledStr, TypedValueParser};
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, Command, Error};

use crate::grasp::matrix::Contender;

/// A name, which shells complete, or a file.
#[derive(Debug, Clone, Copy)]
pub struct ControllerName;

impl TypedValueParser for ControllerName {
    type Value = String;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<String, Error> {
        match value.to_str() {
            Some(file) if Contender::is_file(file) => Ok(file.to_owned()),
            _ => PossibleValuesParser::new(Contender::names()).parse_ref(command, argument, value).map_err(with_files),
        }
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(Contender::names().map(PossibleValue::new)))
    }
}

/// Says that files are taken, too.
fn with_files(mut error: Error) -> Error {
    let hint =
        "a file is taken, too: a controller FMU (.fmu), or a preset or scenario (.toml) with its controller and gains";
    error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(hint)]));
    error
}

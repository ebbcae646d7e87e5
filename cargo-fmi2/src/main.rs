//! `cargo fmi2`: makes a crate that exports a model as an FMU, and packages it.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use cargo_fmi2::{new, package};
use clap::{Parser, Subcommand};

/// How cargo calls the program: with the subcommand's name as the first argument.
#[derive(Debug, Parser)]
#[command(bin_name = "cargo")]
enum Cargo {
    /// Write a model in Rust, get an FMI 2.0 co-simulation FMU
    #[command(
        name = "fmi2",
        version,
        arg_required_else_help = true,
        after_help = "Examples:\n  \
            cargo fmi2 new ../dc-motor      a crate with a model that works, to be replaced by yours\n  \
            cargo fmi2 package              dist/NAME.fmu for each model of the crate in this folder\n\n\
            Each command has help of its own: cargo fmi2 package --help"
    )]
    Fmi2 {
        #[command(subcommand)]
        command: Command,
    },
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a crate in a new folder: a model, its tests, its documentation, its packaging program
    #[command(after_help = "Examples:\n  \
        cargo fmi2 new dc-motor                       the crate dc-motor with the model DcMotor\n  \
        cargo fmi2 new ../dc-motor --path ~/dual-arm  with the fmi2-export of a clone")]
    New {
        /// The new folder; its name becomes the crate's, and, with capital letters instead of hyphens, the model's
        folder: PathBuf,
        /// Depend on fmi2-export and fmi2-package in this folder instead of their published versions [default: where this
        /// command was built, if it was built from a clone]
        #[arg(long, value_name = "FOLDER")]
        path: Option<PathBuf>,
    },
    /// Build a crate's library and write an .fmu file for each of its models
    Package(package::Arguments),
}

fn main() -> ExitCode {
    let Cargo::Fmi2 { command } = Cargo::parse();
    let result = match command {
        Command::New { folder, path } => new::create(&folder, path.as_deref()).and_then(|next| {
            let mut out = std::io::stdout();
            let printed = out.write_all(next.as_bytes()).and_then(|()| out.flush());
            printed.map(|()| ExitCode::SUCCESS).map_err(|error| format!("cannot write to standard output: {error}"))
        }),
        Command::Package(arguments) => package::run(&arguments),
    };
    result.unwrap_or_else(|message| {
        eprintln!("error: {message}");
        ExitCode::FAILURE
    })
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cargo::command().debug_assert();
    }
}

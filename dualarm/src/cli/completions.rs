//! `dualarm completions`

use std::fmt::Write;

use clap::builder::PossibleValuesParser;
use clap::{Args, Command};
use clap_complete::Shell;

use super::print;
use crate::grasp::scenarios::BUILT_IN;

/// Where the scripts go.
const AFTER_HELP: &str = "\
Install, for example:
  dualarm completions bash > ~/.local/share/bash-completion/completions/dualarm
  dualarm completions zsh  > ~/.zfunc/_dualarm       with ~/.zfunc in $fpath
  dualarm completions fish > ~/.config/fish/completions/dualarm.fish
  dualarm completions powershell >> $PROFILE";

/// Arguments of `dualarm completions`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the script.
pub fn run(arguments: &Arguments, command: &mut Command) {
    let names = || BUILT_IN.iter().map(|built_in| built_in.name);
    // bash goes on to files where no name fits; other shells would not, so they get the names another way or not at all.
    if arguments.shell == Shell::Bash {
        for (subcommand, argument) in [("simulate", "what"), ("scenario", "name")] {
            *command = command.clone().mut_subcommand(subcommand, |subcommand| {
                subcommand.mut_arg(argument, |argument| argument.value_parser(PossibleValuesParser::new(names())))
            });
        }
    }
    // Into memory first: the generators panic when a reader closes the pipe.
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, command, "dualarm", &mut script);
    let mut script = String::from_utf8_lossy(&script).into_owned();
    if arguments.shell == Shell::Fish {
        let names = names().collect::<Vec<_>>().join(" ");
        for subcommand in ["simulate", "scenario"] {
            let _ = writeln!(
                script,
                "complete -c dualarm -n \"__fish_dualarm_using_subcommand {subcommand}\" -a \"{names}\""
            );
        }
    }
    print(&script);
}

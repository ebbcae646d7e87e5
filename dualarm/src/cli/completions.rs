//! `dualarm completions`

use std::io;

use clap::{Args, Command};
use clap_complete::Shell;

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
    clap_complete::generate(arguments.shell, command, "dualarm", &mut io::stdout());
}

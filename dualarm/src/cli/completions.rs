//! `dualarm completions`

use clap::{Args, Command};
use clap_complete::Shell;

use super::print;

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
    // Into memory first: the generators panic when a reader closes the pipe.
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, command, "dualarm", &mut script);
    print(&String::from_utf8_lossy(&script));
}

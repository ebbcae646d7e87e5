//! `dualarm completions`

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
    // With the arguments of all commands.
    command.build();
    // bash also offers files if no name fits; the other generators would offer only the names.
    if arguments.shell == Shell::Bash {
        for (subcommand, argument) in WITH_NAMES {
            *command = command.clone().mut_subcommand(subcommand, |subcommand| {
                subcommand.mut_arg(argument, |argument| argument.value_parser(PossibleValuesParser::new(names())))
            });
        }
    }
    // Into memory first: the generators panic when a reader closes the pipe.
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, command, "dualarm", &mut script);
    print(&with_names(arguments.shell, &String::from_utf8_lossy(&script)));
}

/// Subcommands, and their arguments that a scenario's name can be.
const WITH_NAMES: [(&str, &str); 2] = [("simulate", "what"), ("scenario", "name")];

fn names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|built_in| built_in.name)
}

/// A generated script with the scenarios' names, which also offers files if the shell supports both.
fn with_names(shell: Shell, script: &str) -> String {
    // After the line by which a script begins with a subcommand.
    let insert = |begin: &dyn Fn(&str) -> String, lines: &str| {
        WITH_NAMES.iter().fold(script.to_owned(), |script, (subcommand, _)| {
            let begin = begin(subcommand);
            script.replace(&begin, &format!("{begin}{lines}"))
        })
    };
    match shell {
        Shell::Zsh => {
            let function = format!(
                "\n_dualarm_scenarios() {{\n    _alternative 'scenarios:scenario:({})' 'files:file:_files'\n}}\n\n_dualarm() {{\n",
                names().collect::<Vec<_>>().join(" ")
            );
            let is_name = |line: &str| {
                WITH_NAMES.iter().any(|(_, name)| {
                    line.starts_with(&format!("'::{name} ")) || line.starts_with(&format!("'*::{name} "))
                })
            };
            let line = |line: &str| match line.rsplit_once(':') {
                Some((before, _)) if is_name(line) => format!("{before}:_dualarm_scenarios' \\\n"),
                _ => format!("{line}\n"),
            };
            script.lines().map(line).collect::<String>().replacen("\n_dualarm() {\n", &function, 1)
        }
        Shell::PowerShell => {
            let kind = "[CompletionResultType]::ParameterValue";
            let line = |name| format!("            [CompletionResult]::new('{name}', '{name}', {kind}, 'scenario')\n");
            let lines = names().map(line).collect::<Vec<_>>().concat();
            insert(&|subcommand| format!("        'dualarm;{subcommand}' {{\n"), &lines)
        }
        Shell::Elvish => {
            let lines =
                names().map(|name| format!("            cand {name} 'scenario'\n")).collect::<Vec<_>>().concat();
            insert(&|subcommand| format!("        &'dualarm;{subcommand}'= {{\n"), &lines)
        }
        Shell::Fish => {
            let names = names().collect::<Vec<_>>().join(" ");
            let line = |(subcommand, _): &(&str, &str)| {
                format!("complete -c dualarm -n \"__fish_dualarm_using_subcommand {subcommand}\" -a \"{names}\"\n")
            };
            script.to_owned() + &WITH_NAMES.iter().map(line).collect::<String>()
        }
        _ => script.to_owned(),
    }
}

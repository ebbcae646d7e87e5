//! The `dualarm` command; see `dualarm --help`.

fn main() -> std::process::ExitCode {
    dualarm::cli::main()
}

//! Packages the FMU: `cargo run -p hub-friction`.

fn main() -> std::process::ExitCode {
    fmi2_export::package::main(&hub_friction::FMUS, &[])
}

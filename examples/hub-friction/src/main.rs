//! Packages the FMU: `cargo run --release -p hub-friction --features package`.

fn main() -> std::process::ExitCode {
    fmi2_package::main(&hub_friction::FMUS, &[])
}

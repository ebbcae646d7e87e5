//! Packages the FMUs of this crate: `cargo run -p controller-fmu`.

fn main() -> std::process::ExitCode {
    fmi2_export::package::main(&controller_fmu::FMUS, &[])
}

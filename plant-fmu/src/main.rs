//! Packages the FMUs of this crate: `cargo run -p plant-fmu`.

fn main() -> std::process::ExitCode {
    fmi2_export::package::main(&plant_fmu::FMUS, &[])
}

//! Packages the FMUs of this crate: `cargo run -p instruments-fmu --features package`.

use fmi2_package::{Document, OfTime, Panel, Response};

const LICENSE: &str = include_str!("../../LICENSE");

/// A signal of a second or so, without the system's mathematics.
fn swing(time: f64) -> f64 {
    // Its zeros lie between communication points.
    let phase = ((time + 0.0123) / 0.4).fract();
    16.0 * phase * (1.0 - phase) * (0.5 - phase).signum() * (0.5 - phase).abs()
}

const SIGNALS: &[(&str, OfTime)] = &[("theta1", |t| 2e-3 * swing(t)), ("y_object", |t| 0.05 + 1e-4 * swing(t))];

const COMMANDS: &[(&str, OfTime)] = &[("tau1_cmd", swing), ("u_cmd", |t| if t < 0.05 { 0.0 } else { 0.2 })];

fn main() -> std::process::ExitCode {
    let common = Document { license: LICENSE, command: "cargo run --release -- package", ..Document::new() };
    let noise_and_steps = Response {
        caption: "A slow motion of a few milliradians and a tenth of a millimetre, as a hub encoder of 16 bits behind a low-pass \
                  and a scale with noise show it, both sampled at 1 kHz.",
        start: &[
            ("sample_time", 1e-3),
            ("theta1_lsb", std::f64::consts::TAU / 65_536.0),
            ("theta1_bandwidth", 100.0),
            ("y_object_noise", 1e-5),
        ],
        inputs: SIGNALS,
        stop_time: 0.4,
        step_size: 1e-3,
        panels: &[
            Panel { title: "Hub angle, filtered and quantised", variables: &["theta1_measured"] },
            Panel { title: "Object position, noisy", variables: &["y_object_measured"] },
        ],
        beside: &[],
    };
    let late_and_slow = Response {
        caption: "A torque through the inverse of the paper's dead zone (±0.1 N·m), whose jump a rate limit of 20 N·m/s turns into \
                  a ramp, and a step of the force that comes 10 ms late with a lag of 20 ms.",
        start: &[
            ("sample_time", 1e-3),
            ("dead_zone_inverse", 1.0),
            ("tau1_cmd_rate_limit", 20.0),
            ("u_cmd_delay", 0.01),
            ("u_cmd_bandwidth", 50.0),
        ],
        inputs: COMMANDS,
        stop_time: 0.4,
        step_size: 1e-3,
        panels: &[
            Panel { title: "Torque on hub 1", variables: &["tau1_cmd_sent"] },
            Panel { title: "Force on the object", variables: &["u_cmd_sent"] },
        ],
        beside: &[],
    };
    let documents = [
        Document {
            model: "GraspInstruments",
            text: include_str!("../documentation/GraspInstruments.md"),
            icon: include_bytes!("../documentation/GraspInstruments.png"),
            response: Some(noise_and_steps),
            ..common
        },
        Document {
            model: "GraspActuators",
            text: include_str!("../documentation/GraspActuators.md"),
            icon: include_bytes!("../documentation/GraspActuators.png"),
            response: Some(late_and_slow),
            ..common
        },
    ];
    fmi2_package::main(&instruments_fmu::FMUS, &documents)
}

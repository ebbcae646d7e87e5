//! Packages the FMUs of this crate: `cargo run --release -p controller-fmu --features package`.

use fmi2_package::{Document, OfTime, Panel, Response};
use grasp_control::{Arms, References};

const LICENSE: &str = include_str!("../../LICENSE");

/// Time constant of the approach \[s\].
const APPROACH: f64 = 0.1;

/// Share of the way from rest to the target that is done at a time, and its rate \[1/s\].
fn done(time: f64) -> f64 {
    1.0 - (-time / APPROACH).exp()
}

fn done_rate(time: f64) -> f64 {
    (-time / APPROACH).exp() / APPROACH
}

/// Hub angles of the target \[rad\].
fn theta(arm: usize) -> f64 {
    Arms::default().targets(&References::default()).theta[arm]
}

/// Shear at the tip of the target \[N\]: at rest it is the multiplier.
fn shear(arm: usize) -> f64 {
    Arms::default().targets(&References::default()).lambda[arm]
}

/// Bending moment at the root of the target \[N·m\]: the tip's shear times the arm's length.
fn moment(arm: usize) -> f64 {
    -shear(arm) * Arms::default().length
}

/// Position of the object at the start and its way to the target \[m\].
fn object() -> (f64, f64) {
    let arms = Arms::default();
    let start = 0.5 * arms.hub_distance;
    (start, arms.targets(&References::default()).y_object - start)
}

/// A quasi-static approach: hubs, object and bending go from rest to the target, in proportion.
const MOTION: &[(&str, OfTime)] = &[
    ("theta1", |t| theta(0) * done(t)),
    ("theta2", |t| theta(1) * done(t)),
    ("theta1_dot", |t| theta(0) * done_rate(t)),
    ("theta2_dot", |t| theta(1) * done_rate(t)),
    ("y_object", |t| object().0 + object().1 * done(t)),
    ("y_object_dot", |t| object().1 * done_rate(t)),
    ("root_moment1", |t| moment(0) * done(t)),
    ("root_moment2", |t| moment(1) * done(t)),
    ("tip_shear1", |t| shear(0) * done(t)),
    ("tip_shear2", |t| shear(1) * done(t)),
    ("tip_shear1_dot", |t| shear(0) * done_rate(t)),
    ("tip_shear2_dot", |t| shear(1) * done_rate(t)),
    ("root_moment1_dot", |t| moment(0) * done_rate(t)),
    ("root_moment2_dot", |t| moment(1) * done_rate(t)),
];

const COMMANDS: [Panel<'_>; 4] = [
    Panel { title: "Hub torques", variables: &["tau1_cmd", "tau2_cmd"] },
    Panel { title: "Force on the object", variables: &["u_cmd"] },
    Panel { title: "Angle errors", variables: &["e1", "e2"] },
    Panel { title: "Position error", variables: &["p"] },
];

/// A law without state: when the motion has ended, only the errors count.
const STATIC: &str = "What the law commands while the grasp comes to the paper's target on a given path, $1 - e^{-t/T}$ with \
                      $T$ = 0.1 s for all measured signals. This is the law alone, in open loop: with `DualArmPlant` the \
                      motion is its own doing. The torques end at ±0.1 N·m, which hold the grasp at rest.";

/// A law that learns from errors which, on a given path, its commands cannot change.
const ADAPTIVE: &str = "What the law commands while the grasp comes to the paper's target on a given path, $1 - e^{-t/T}$ with $T$ = 0.1 s \
     for all measured signals. This is the law alone, in open loop: with `DualArmPlant` the motion is its own doing. Here \
     the commands change nothing, so the networks take the lasting errors for a disturbance and learn a torque against it, \
     which stays when the errors are gone.";

/// The law's answer to the motion.
const fn response<'a>(caption: &'a str, panels: &'a [Panel<'a>]) -> Response<'a> {
    Response { caption, start: &[], inputs: MOTION, stop_time: 0.8, step_size: 2e-3, panels }
}

fn main() -> std::process::ExitCode {
    let [torques, force, angles, position] = COMMANDS;
    let with_estimates = [
        torques,
        force,
        angles,
        position,
        Panel { title: "Sliding variables of the hubs", variables: &["s1", "s2"] },
        Panel { title: "Sliding variable of the object", variables: &["s"] },
        Panel { title: "Norms of the hubs' network weights", variables: &["U1_norm", "U2_norm"] },
        Panel { title: "Estimated bounds of their errors", variables: &["pi1_hat", "pi2_hat"] },
    ];
    let common = Document { license: LICENSE, command: "cargo run --release -- package", ..Document::new() };
    let documents = [
        Document {
            model: "NabfcController",
            text: include_str!("../documentation/NabfcController.md"),
            icon: include_bytes!("../documentation/NabfcController.png"),
            response: Some(response(ADAPTIVE, &with_estimates)),
            ..common
        },
        Document {
            model: "PdsController",
            text: include_str!("../documentation/PdsController.md"),
            icon: include_bytes!("../documentation/PdsController.png"),
            response: Some(response(STATIC, &COMMANDS)),
            ..common
        },
        Document {
            model: "PdController",
            text: include_str!("../documentation/PdController.md"),
            icon: include_bytes!("../documentation/PdController.png"),
            response: Some(response(STATIC, &COMMANDS)),
            ..common
        },
    ];
    fmi2_package::main(&controller_fmu::FMUS, &documents)
}

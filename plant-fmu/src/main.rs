//! Packages the FMU of this crate: `cargo run --release -p plant-fmu --features package`.

use fmi2_package::{Article, Document, File, Panel, Response};

/// The sketch that docs/model.md shows, too.
const GEOMETRY: &[u8] = include_bytes!("../../docs/figures/geometry.svg");

/// Torque that each hub holds against the grasp: at rest the contact force is this over the arms' length, 0.5 N.
const SQUEEZE: f64 = 0.1;

fn main() -> std::process::ExitCode {
    let squeeze = Response {
        caption: "From rest, both motors press the tips against the object, with 0.1 N·m from $t = 0$ on. The contact forces \
                  settle at $\\tau/l$ = 0.5 N; the built-in uncertainties damp the vibration. In the first milliseconds \
                  the bending waves are still on their way to the tips.",
        start: &[("tau1_cmd", SQUEEZE), ("tau2_cmd", -SQUEEZE)],
        inputs: &[],
        stop_time: 0.5,
        step_size: 1e-3,
        panels: &[
            Panel { title: "Contact forces", variables: &["contact_force1", "contact_force2"] },
            Panel { title: "Hub angles", variables: &["theta1", "theta2"] },
            Panel { title: "Tip deflections", variables: &["tip_deflection1", "tip_deflection2"] },
            Panel { title: "Energy", variables: &["energy", "supplied_energy"] },
        ],
        beside: &[],
    };
    let plant = Document {
        model: "DualArmPlant",
        text: include_str!("../documentation/DualArmPlant.md"),
        icon: include_bytes!("../documentation/DualArmPlant.png"),
        license: include_str!("../../LICENSE"),
        command: "cargo run --release -- package",
        response: Some(squeeze),
        files: &[File { path: "documentation/geometry.svg", content: GEOMETRY }],
        articles: &[Article {
            path: "documentation/errata.html",
            title: "Where the paper needs correcting",
            about: "A document of the repository that this FMU was built from; files it names are there.",
            text: include_str!("../../docs/errata.md"),
        }],
        links: &[("../../docs/errata.md", "errata.html"), ("../../docs/figures/geometry.svg", "geometry.svg")],
    };
    fmi2_package::main(&plant_fmu::FMUS, &[plant])
}

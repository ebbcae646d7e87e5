//! Packages the FMUs of this crate: `cargo run --release -p controller-fmu --features package`.

mod grasp;

use fmi2_package::{Article, Beside, Document, Panel, Response};
use grasp::{NABFC, PD, PDS, contact_force, measurements, spacing, stop_time};

const LICENSE: &str = include_str!("../../LICENSE");

const ERRATA: Article<'_> = Article {
    path: "documentation/errata.html",
    title: "Where the paper needs correcting",
    about: "A document of the repository that this FMU was built from; files it names are there.",
    text: include_str!("../../docs/errata.md"),
};

const FORCES: Panel<'_> = Panel { title: "Contact forces", variables: &["contact_force1", "contact_force2"] };
const ANGLES: Panel<'_> = Panel { title: "Angle errors", variables: &["e1", "e2"] };
const POSITION: Panel<'_> = Panel { title: "Position error", variables: &["p"] };
const TORQUES: Panel<'_> = Panel { title: "Hub torques", variables: &["tau1_cmd", "tau2_cmd"] };
const FORCE: Panel<'_> = Panel { title: "Force on the object", variables: &["u_cmd"] };

/// The contact forces in the grasp of a law.
const fn contact<const LAW: usize>() -> [Beside<'static>; 2] {
    [
        Beside { name: "contact_force1", unit: "N", values: contact_force::<LAW, 0> },
        Beside { name: "contact_force2", unit: "N", values: contact_force::<LAW, 1> },
    ]
}

fn main() -> std::process::ExitCode {
    let (nabfc, pds, pd) = (measurements::<NABFC>(), measurements::<PDS>(), measurements::<PD>());
    let adaptive = Response {
        caption: "The grasp: this controller in a loop with `DualArmPlant`, both with their default values, step 1 ms. Both tips \
                  press with 0.5 N soon after 0.1 s. The contact forces are the plant's: no controller measures them. The mass \
                  is learnt from nothing but the motion; it really is 0.5 kg.",
        start: &[],
        inputs: &nabfc,
        stop_time: stop_time(NABFC),
        step_size: spacing(NABFC),
        panels: &[
            FORCES,
            ANGLES,
            POSITION,
            TORQUES,
            FORCE,
            Panel { title: "Estimated moving mass", variables: &["m_hat"] },
            Panel { title: "Learnt disturbances of the hubs", variables: &["U1_norm", "U2_norm"] },
            Panel { title: "Learnt disturbance of the object", variables: &["W_norm"] },
        ],
        beside: &contact::<NABFC>(),
    };
    let strain = Response {
        caption: "The grasp: this controller in a loop with `DualArmPlant`, both with their default values, step 0.1 ms, a row \
                  every 2 ms. The contact forces are the plant's: no controller measures them. At rest the torques hold \
                  ±0.1 N·m, the tips' 0.5 N on arms of 0.2 m.",
        inputs: &pds,
        stop_time: stop_time(PDS),
        step_size: spacing(PDS),
        panels: &[FORCES, ANGLES, POSITION, TORQUES, FORCE],
        beside: &contact::<PDS>(),
        ..adaptive
    };
    let rigid = Response {
        caption: "The grasp: this controller in a loop with `DualArmPlant`, both with their default values, step 0.1 ms, a row \
                  every 2 ms. Without strain the arms ring for some seconds. The contact forces are the plant's: no controller \
                  measures them.",
        inputs: &pd,
        stop_time: stop_time(PD),
        step_size: spacing(PD),
        beside: &contact::<PD>(),
        ..strain
    };
    let common = Document {
        license: LICENSE,
        command: "cargo run --release -- package",
        articles: &[ERRATA],
        links: &[("../../docs/errata.md", "errata.html")],
        ..Document::new()
    };
    let documents = [
        Document {
            model: "NabfcController",
            text: include_str!("../documentation/NabfcController.md"),
            icon: include_bytes!("../documentation/NabfcController.png"),
            response: Some(adaptive),
            ..common
        },
        Document {
            model: "PdsController",
            text: include_str!("../documentation/PdsController.md"),
            icon: include_bytes!("../documentation/PdsController.png"),
            response: Some(strain),
            ..common
        },
        Document {
            model: "PdController",
            text: include_str!("../documentation/PdController.md"),
            icon: include_bytes!("../documentation/PdController.png"),
            response: Some(rigid),
            ..common
        },
    ];
    fmi2_package::main(&controller_fmu::FMUS, &documents)
}

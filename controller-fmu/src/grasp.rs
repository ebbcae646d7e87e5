//! The grasp on the controllers' pages: the native plant and a law in a loop, each with its default values. Only the
//! packaging program uses the plant, as the user does who connects the two FMUs.
//!
//! The FMU itself computes the page's figure from the law's inputs recorded here. The contact forces, which no controller
//! measures, are shown [beside](fmi2_package::Response::beside).

use std::sync::OnceLock;

use fmi2_package::OfTime;
use grasp_control::blocks::observer::RateSource;
use grasp_control::laws::encoders::Actuation;
use grasp_control::laws::nabfc::RbfLayout;
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::laws::pds::{Limits, Pds, PdsGains};
use grasp_control::laws::root_strain::{RootStrain, RootStrainGains};
use grasp_control::{Arms, Commands, INPUT_NAMES, INPUTS, Inputs, Law, Measurements, References};
use grasp_plant::{Measured, Parameters, Plant};

/// Which law, as a constant of functions of time.
pub const NABFC: usize = 0;
/// Proportional-derivative control with strain.
pub const PDS: usize = 1;
/// The same without.
pub const PD: usize = 2;

/// How a loop is run: communication step \[s\], steps from row to row, rows.
struct Pace {
    step: f64,
    steps: u32,
    rows: u32,
}

/// The paces of the laws. PD and PDS are unstable with the longer step. They have no state, so the recorded rows determine
/// their commands completely.
const PACES: [Pace; 3] = [
    Pace { step: 1e-3, steps: 1, rows: 400 },
    Pace { step: 1e-4, steps: 20, rows: 500 },
    Pace { step: 1e-4, steps: 20, rows: 500 },
];

/// The measurements and the contact forces \[N\], at equal intervals of time.
struct Grasp {
    measured: Vec<[f64; INPUTS]>,
    contact: Vec<[f64; 2]>,
}

/// Time from row to row \[s\].
pub fn spacing(law: usize) -> f64 {
    PACES[law].step * f64::from(PACES[law].steps)
}

/// Length of the run \[s\].
pub fn stop_time(law: usize) -> f64 {
    spacing(law) * f64::from(PACES[law].rows)
}

/// The measured inputs as functions of time.
pub fn measurements<const LAW: usize>() -> [(&'static str, OfTime); 14] {
    macro_rules! columns {
        ($($column:literal)*) => { [$((INPUT_NAMES[$column], measured::<LAW, $column> as OfTime)),*] };
    }
    columns!(0 1 2 3 4 5 6 7 8 9 10 11 12 13)
}

/// Force with which an arm presses \[N\].
pub fn contact_force<const LAW: usize, const ARM: usize>(time: f64) -> f64 {
    let (grasp, row) = at::<LAW>(time);
    grasp.contact[row][ARM]
}

fn measured<const LAW: usize, const COLUMN: usize>(time: f64) -> f64 {
    let (grasp, row) = at::<LAW>(time);
    grasp.measured[row][COLUMN]
}

fn at<const LAW: usize>(time: f64) -> (&'static Grasp, usize) {
    static GRASPS: [OnceLock<Grasp>; 3] = [const { OnceLock::new() }; 3];
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // One of a few hundred rows.
    let row = (time / spacing(LAW)).round() as usize;
    (GRASPS[LAW].get_or_init(|| run(law(LAW).as_mut(), &PACES[LAW])), row)
}

/// A law with the values that its FMU has by default.
fn law(law: usize) -> Box<dyn Law> {
    const DEFAULT: &str = "the default values are in their ranges";
    let (arms, limits) = (Arms::default(), Limits::default());
    match law {
        PDS => Box::new(Pds::new(arms, PdsGains::default(), limits).expect(DEFAULT)),
        PD => Box::new(Pd::new(arms, PdGains::default(), limits).expect(DEFAULT)),
        _ => {
            let (gains, actuation) = (RootStrainGains::default(), Actuation::default());
            let law = RootStrain::new(arms, gains, actuation, RateSource::default(), &RbfLayout::default());
            Box::new(law.expect(DEFAULT))
        }
    }
}

/// The loop, as a master has it that runs the controller before the plant.
fn run(law: &mut dyn Law, pace: &Pace) -> Grasp {
    let mut plant = Plant::new(Parameters::default()).expect("the plant's default values are in their ranges");
    let mut seen = Inputs { measured: read(&plant), reference: References::default() };
    law.initialize(&seen);
    let mut commands = commanded(law.commands(&seen));
    let mut grasp = Grasp { measured: Vec::new(), contact: Vec::new() };
    for step in 0..=pace.steps * pace.rows {
        if step.is_multiple_of(pace.steps) {
            grasp.measured.push(seen.to_array());
            grasp.contact.push(plant.direct(&commands).contact_force);
        }
        law.step(pace.step, &seen, &Inputs::HELD).expect("a grasp has no huge numbers");
        commands = commanded(law.commands(&seen));
        plant.step(pace.step, &commands, &grasp_plant::Inputs::ZERO).expect("a grasp has no huge numbers");
        seen.measured = read(&plant);
    }
    grasp
}

fn commanded(Commands { tau, u }: Commands) -> grasp_plant::Inputs {
    grasp_plant::Inputs { torque_command: tau, force_command: u, ..Default::default() }
}

/// The plant's measurements as inputs of the law: names and units are the same.
fn read(plant: &Plant) -> Measurements {
    let Measured { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot } = plant.measured();
    let root_moment_dot = plant.uncertainty().root_moment_dot;
    Measurements { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot, root_moment_dot }
}

//! A controller as a sampled linear system.

use grasp_certify::controllers::{Controller as Law, ControllerError};
use grasp_certify::law::{COMMANDS, LAW_INPUT_UNITS, LAW_INPUTS, SampledLaw};
use grasp_certify::settings::Settings;
use grasp_control::Inputs;

use super::{Linear, owned};
use crate::cli::Failure;
use crate::grasp::Controller;

/// The law that makes this controller of its FMU.
pub fn of(controller: &Controller, settings: &Settings) -> Result<Law, ControllerError> {
    let choices: Vec<_> = controller.settings().map(|setting| (setting.target, setting.value.to_string())).collect();
    Law::new(controller.fmu.trim_end_matches(".fmu"), &choices, settings)
}

/// The controller near rest in the target, with `inputs` moved to other values, for steps of `h` s.
pub fn linear(
    controller: &Controller,
    settings: &Settings,
    inputs: &[(String, f64)],
    h: f64,
) -> Result<Linear, Failure> {
    let mut law = of(controller, settings).map_err(Failure::usage)?;
    let mut point = law.at_target(settings).to_array();
    for (name, value) in inputs {
        let place = LAW_INPUTS.iter().position(|known| known == name);
        let place = place.ok_or_else(|| {
            Failure::usage(format!("--at: controllers have no input \"{name}\"; they have {}", LAW_INPUTS.join(", ")))
        })?;
        point[place] = *value;
    }
    let linear = law.linear(&Inputs::from_array(point), h).map_err(Failure::failed)?;
    let SampledLaw { a, b, c, d, states } = linear;
    Ok(Linear {
        matrices: vec![("Ad", a), ("Bd", b), ("C", c), ("D", d)],
        h: Some(h),
        names: [
            ("states", states),
            ("inputs", owned(&LAW_INPUTS)),
            ("input_units", owned(&LAW_INPUT_UNITS)),
            ("outputs", owned(&COMMANDS)),
            ("output_units", owned(&["N.m", "N.m", "N"])),
        ],
    })
}

//! The parameters of the FMUs in a run.

use fmi2_cosim::master::Master;
use fmi2_import::description::BaseType;
use fmi2_import::{Causality, Instance};
use grasp_certify::settings::Settings;

use crate::grasp::{NABFC, PLANT};

/// Plant and controller as they are set, and the controller's law.
pub(super) fn settings(master: &mut Master) -> Result<(Settings, String), String> {
    let mut settings = Settings::default();
    let mut law = String::new();
    let count = master.names().count();
    // The plant comes second: where both have a parameter, the truth is the plant's.
    for wanted in [NABFC.fmu, PLANT].map(|file| file.trim_end_matches(".fmu")) {
        let place = (0..count).find(|index| master.instance(*index).description().model_name == wanted);
        let instance = master.instance(place.ok_or_else(|| format!("there is no {wanted} in this system"))?);
        take_numbers(instance, &mut settings)?;
        if instance.description().variable("law").is_some() {
            let preset = choice(instance, "preset")?;
            if preset != "parameters" {
                settings.set_preset(&preset).map_err(|error| error.to_string())?;
            }
            law = choice(instance, "law")?;
        }
        if let Some(reference) = instance.description().variable("order").map(|order| order.value_reference) {
            let mut order = [0];
            instance.get_integer(&[reference], &mut order).map_err(|error| error.to_string())?;
            settings.plant.order = usize::try_from(order[0]).unwrap_or(settings.plant.order);
        }
    }
    Ok((settings, law))
}

/// Reads all real parameters that the settings have.
fn take_numbers(instance: &mut Instance, settings: &mut Settings) -> Result<(), String> {
    let parameters: Vec<_> = instance
        .description()
        .with_causality(Causality::Parameter)
        .filter(|variable| variable.base_type() == BaseType::Real)
        .map(|variable| (variable.name.clone(), variable.value_reference))
        .collect();
    let references: Vec<_> = parameters.iter().map(|(_, reference)| *reference).collect();
    let mut values = vec![0.0; references.len()];
    instance.get_real(&references, &mut values).map_err(|error| error.to_string())?;
    for ((name, _), value) in parameters.iter().zip(values) {
        // Other parameters do not occur in the functions.
        let _ = settings.set(name, value);
    }
    Ok(())
}

/// The item of an enumeration.
fn choice(instance: &mut Instance, name: &str) -> Result<String, String> {
    let variable = instance.description().variable(name).ok_or_else(|| format!("the controller has no {name}"))?;
    let (reference, items) = (variable.value_reference, variable.items().to_vec());
    let mut value = [0];
    instance.get_integer(&[reference], &mut value).map_err(|error| error.to_string())?;
    Ok(items.iter().find(|item| item.value == value[0]).map_or_else(String::new, |item| item.name.clone()))
}

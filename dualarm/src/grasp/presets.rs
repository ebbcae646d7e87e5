//! The built-in presets of the controllers, as values of their parameters.
//!
//! A controller FMU with a preset ignores its gain parameters. A search varies these parameters, so it needs the preset's
//! gains as their values.

use grasp_control::laws::GainSet;
use grasp_control::laws::nabfc::Gains;
use grasp_control::laws::pd::PdGains;
use grasp_control::laws::pds::PdsGains;
use grasp_control::laws::root_strain::RootStrainGains;

/// The gains of a preset by the names of the parameters that it replaces, in SI units, those of one law: `root_strain`
/// selects it in `NabfcController`. `None` if the model is none of the project's, or has no such preset with gains of its own.
#[must_use]
pub fn gains(model: &str, preset: &str, root_strain: bool) -> Option<Vec<(String, f64)>> {
    match model {
        "PdController" => PdGains::preset(preset).map(GainSet::values),
        "PdsController" => PdsGains::preset(preset).map(GainSet::values),
        "NabfcController" if root_strain => RootStrainGains::preset(preset).map(GainSet::values),
        "NabfcController" => Gains::preset(preset).map(GainSet::values),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grasp::CONTROLLERS;
    use std::collections::HashSet;

    #[test]
    fn every_preset_that_a_user_can_name_has_gains() {
        for controller in CONTROLLERS {
            let settings: Vec<_> = controller.settings().collect();
            let value =
                |name: &str| settings.iter().find(|setting| setting.target == name).map(|s| s.value.to_string());
            let Some(preset) = value("preset") else { continue };
            let model = controller.fmu.trim_end_matches(".fmu");
            let gains = gains(model, &preset, value("law").as_deref() == Some("root_strain")).expect(controller.key);
            let names: HashSet<_> = gains.iter().map(|(name, _)| name).collect();
            assert!(names.len() == gains.len() && gains.len() >= 6, "{}: {gains:?}", controller.key);
        }
        let pid = gains("PdController", "pid", false).unwrap();
        assert!(pid.contains(&("ki".into(), 14_980.0)) && pid.contains(&("ki2".into(), 17.09)), "{pid:?}");
        assert_eq!(gains("PdController", "parameters", false), None);
        assert_eq!(gains("AnotherLaw", "tuned", false), None);
    }
}

//! The built-in presets of the controllers, as values of their parameters.
//!
//! A controller FMU with a preset ignores its gain parameters. A search varies these parameters, so it needs the preset's
//! gains as their values.

use grasp_control::Parameter;
use grasp_control::laws::nabfc::{self, Gains, PostureGains, RbfLayout};
use grasp_control::laws::pd::PdGains;
use grasp_control::laws::pds::PdsGains;
use grasp_control::laws::root_strain::{
    FilterGains, HubGains, InertiaGains, MassGains, NetworkGains, ObjectGains, RootStrainGains,
};

/// The gains of a preset by the names of the parameters that it replaces, in SI units, those of one law: `root_strain`
/// selects it in `NabfcController`. `None` if the model is none of the project's, or has no such preset with gains of its own.
#[must_use]
pub fn gains(model: &str, preset: &str, root_strain: bool) -> Option<Vec<(String, f64)>> {
    let mut all = Vec::new();
    match (model, preset) {
        ("PdController", _) => {
            let gains = match preset {
                "paper" => PdGains::default(),
                "tuned" => PdGains::tuned(),
                "pid" => PdGains::pid(),
                _ => return None,
            };
            add(&mut all, PdGains::PARAMETERS, &mut [gains]);
        }
        ("PdsController", _) => {
            let gains = match preset {
                "paper" => PdsGains::default(),
                "tuned" => PdsGains::tuned(),
                _ => return None,
            };
            add(&mut all, PdsGains::PARAMETERS, &mut [gains]);
        }
        ("NabfcController", "fast") if root_strain => add_root_strain(&mut all, RootStrainGains::fast()),
        ("NabfcController", "certified") if root_strain => add_root_strain(&mut all, RootStrainGains::certified()),
        ("NabfcController", "fast") => add_paper(&mut all, Gains::fast()),
        ("NabfcController", "certified") => add_paper(&mut all, Gains::default()),
        _ => return None,
    }
    Some(all)
}

fn add_root_strain(all: &mut Vec<(String, f64)>, mut gains: RootStrainGains) {
    add(all, ObjectGains::PARAMETERS, &mut [gains.object]);
    add(all, HubGains::PARAMETERS, &mut gains.hub);
    add(all, MassGains::PARAMETERS, &mut [gains.mass]);
    add(all, MassGains::FIXED, &mut [gains.mass]);
    add(all, InertiaGains::PARAMETERS, &mut [gains.inertia]);
    add(all, FilterGains::PARAMETERS, &mut [gains.filter]);
    add(all, NetworkGains::PARAMETERS, &mut [gains.networks]);
    add(all, RootStrainGains::PARAMETERS, &mut [gains]);
}

fn add_paper(all: &mut Vec<(String, f64)>, mut gains: Gains) {
    add(all, nabfc::ObjectGains::PARAMETERS, &mut [gains.object]);
    add(all, nabfc::ObjectGains::FIXED, &mut [gains.object]);
    add(all, PostureGains::PARAMETERS, &mut gains.posture);
    add(all, PostureGains::FIXED, &mut gains.posture);
    add(all, RbfLayout::PARAMETERS, &mut [gains.rbf]);
    add(all, Gains::PARAMETERS, &mut [gains]);
}

/// The rows of a table, for each owner; owners have numbers from 1.
fn add<T>(all: &mut Vec<(String, f64)>, table: &[Parameter<T>], owners: &mut [T]) {
    for (number, owner) in (1..).zip(owners) {
        let number = format!("{number}");
        all.extend(table.iter().map(|row| (row.name.replace("{}", &number), *(row.field)(owner))));
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

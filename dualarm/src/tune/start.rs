//! Where a search begins: at the values that the controller has.

use crate::grasp::presets;
use fmi2_cosim::settings::Setting;
use fmi2_import::{ModelDescription, Value, VariableType};

/// The values of a controller before a search.
#[derive(Debug, Clone)]
pub struct Start<'a> {
    /// The controller.
    pub description: &'a ModelDescription,
    /// What the contender sets by itself; the gains of its preset are among it.
    pub own: Vec<Setting>,
    /// What the user sets beside it, which is stronger.
    pub set: Vec<Setting>,
}

impl<'a> Start<'a> {
    /// The values of a contender with these settings of its own, and others `set` by the user.
    ///
    /// A built-in preset would leave the parameters unused that the search varies, so its gains become their values.
    #[must_use]
    pub fn new(description: &'a ModelDescription, own: &[Setting], set: &[Setting]) -> Self {
        let model = &description.model_name;
        // A scenario may name the component, whose name is the model's.
        let plain = |setting: &Setting| {
            let name = setting.target.strip_prefix(model).and_then(|rest| rest.strip_prefix('.'));
            Setting::new(name.unwrap_or(&setting.target), setting.value.clone())
        };
        let [own, set] = [own, set].map(|settings| settings.iter().map(plain).collect());
        let mut start = Self { description, own, set };
        let preset = start.choice("preset");
        let gains = preset.as_ref().and_then(|preset| presets::gains(model, preset, start.is_root_strain()));
        let is_known = gains.is_some() || preset.as_deref() == Some("parameters");
        // The preset of another controller, or one that this controller will refuse, is not touched.
        if is_known {
            let gains = gains.unwrap_or_default();
            let is_replaced = |name: &String| name == "preset" || gains.iter().any(|(gain, _)| gain == name);
            start.own.retain(|setting| !is_replaced(&setting.target));
            start.set.retain(|setting| setting.target != "preset");
            let other = gains.iter().filter(|(name, value)| start.declared(name) != Some(*value));
            let other: Vec<_> = other.map(|(name, value)| Setting::new(name.clone(), *value)).collect();
            start.own.extend(other);
        }
        start
    }

    /// All settings, in the order in which they are applied.
    #[must_use]
    pub fn settings(&self) -> impl DoubleEndedIterator<Item = &Setting> {
        self.own.iter().chain(&self.set)
    }

    /// Whether `NabfcController` runs its root-strain law, which is its default.
    #[must_use]
    pub fn is_root_strain(&self) -> bool {
        self.choice("law").is_none_or(|law| law == "root_strain")
    }

    /// The name that an enumeration is set to, if it is.
    fn choice(&self, name: &str) -> Option<String> {
        let value = &self.settings().rev().find(|setting| setting.target == name)?.value;
        let variable = self.description.variable(name)?;
        // An invalid value stays as it is written: the controller will refuse it.
        let value = variable.value(value).map_or_else(|_| value.clone(), |value| variable.with_name(value));
        Some(value.to_string())
    }

    /// The start value in the controller's description.
    fn declared(&self, name: &str) -> Option<f64> {
        match &self.description.variable(name)?.kind {
            VariableType::Real(attributes) => attributes.start,
            _ => None,
        }
    }

    /// The value at which parameters with one value begin: the last that one of them is given, else the first one's start
    /// value in the controller's description.
    #[must_use]
    pub fn value(&self, names: &[String]) -> f64 {
        let given = self.settings().filter(|setting| names.contains(&setting.target)).filter_map(number).next_back();
        given.or_else(|| self.declared(names.first()?)).unwrap_or_default()
    }

    /// Whether the parameters of two arms begin alike. If the user sets one of two equal ones, the value is for both.
    #[must_use]
    pub fn are_alike(&self, first: &str, second: &str) -> bool {
        let is_set = |name: &str| self.set.iter().any(|setting| setting.target == name);
        let own = Self { set: Vec::new(), ..self.clone() };
        let equal = |start: &Self| start.value(&[first.to_owned()]) == start.value(&[second.to_owned()]);
        equal(self) || (is_set(first) != is_set(second) && equal(&own))
    }
}

fn number(setting: &Setting) -> Option<f64> {
    match &setting.value {
        Value::Real(number) => Some(*number),
        other => other.to_string().parse().ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmi2_import::ModelDescription;
    use std::path::Path;

    fn description(name: &str) -> ModelDescription {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../modelDescription/{name}.xml"));
        ModelDescription::parse(&std::fs::read_to_string(file).unwrap()).unwrap()
    }

    fn settings(pairs: &[(&str, &str)]) -> Vec<Setting> {
        pairs.iter().map(|(name, value)| Setting::new(*name, *value)).collect()
    }

    fn value(start: &Start, name: &str) -> f64 {
        start.value(&[name.to_owned()])
    }

    #[test]
    fn a_preset_gives_its_gains_to_the_parameters() {
        let pd = description("PdController");
        for preset in ["pid", "4"] {
            // A gain beside a preset is unused in a run, so it is in a search.
            let start = Start::new(&pd, &settings(&[("PdController.kp", "7"), ("preset", preset)]), &[]);
            assert_eq!(["kp", "ki", "ki2"].map(|name| value(&start, name)), [1566.0, 14_980.0, 17.09]);
            assert!(start.settings().all(|setting| setting.target != "preset"));
        }
        // What the user sets is stronger than the preset, in any order.
        let set = settings(&[("kp", "500"), ("preset", "tuned")]);
        let start = Start::new(&pd, &[], &set);
        assert_eq!(["kp", "kv", "ki"].map(|name| value(&start, name)), [500.0, 23.32, 0.0]);
        // Without a preset, a file's own gains hold.
        let start = Start::new(&pd, &settings(&[("PdController.kp", "7"), ("preset", "parameters")]), &[]);
        assert_eq!((value(&start, "kp"), start.settings().count()), (7.0, 1));
        // The controller will say that there is no such preset.
        let start = Start::new(&pd, &settings(&[("preset", "tunde")]), &[]);
        assert_eq!(start.settings().count(), 1);
    }

    #[test]
    fn a_preset_of_one_law_leaves_the_other_law_alone() {
        let nabfc = description("NabfcController");
        let start = Start::new(&nabfc, &settings(&[("law", "root_strain"), ("preset", "fast")]), &[]);
        assert!(start.is_root_strain());
        assert_eq!(["r_slope", "r_strain_bandwidth", "xi1"].map(|name| value(&start, name)), [8.679, 0.0, 0.8]);
        let start = Start::new(&nabfc, &settings(&[("law", "paper"), ("preset", "fast")]), &[]);
        assert!(!start.is_root_strain());
        assert_eq!(["r_slope", "mu1", "mu2"].map(|name| value(&start, name)), [25.62, 13.0, 13.0]);
    }

    #[test]
    fn one_value_for_two_equal_arms_is_for_both() {
        let pd = description("PdController");
        let preset = settings(&[("preset", "tuned")]);
        let alike = |set: &[(&str, &str)]| Start::new(&pd, &preset, &settings(set)).are_alike("kp1", "kp2");
        assert!(alike(&[]) && alike(&[("kp1", "50")]) && alike(&[("kp2", "50")]));
        assert!(!alike(&[("kp1", "50"), ("kp2", "60")]));
        let unequal = settings(&[("kp1", "50"), ("kp2", "60")]);
        assert!(!Start::new(&pd, &unequal, &[]).are_alike("kp1", "kp2"));
    }
}

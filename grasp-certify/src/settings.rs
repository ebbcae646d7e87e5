//! Plant, gains and disturbances by the names that the FMUs give them.

use crate::Grasp;
use crate::printed;
use crate::root_strain::{Disturbance, Estimator, Port};
use grasp_control::laws::GainSet;
use grasp_control::laws::encoders::Actuation;
use grasp_control::laws::nabfc::Gains;
use grasp_control::laws::pd::PdGains;
use grasp_control::laws::pds::PdsGains;
use grasp_control::laws::root_strain::{RootStrainGains, Scaled};
use grasp_control::{Arms, InvalidParameter, Parameter, References, Targets};
use grasp_plant::{Admissible, Arm, Parameters, Start};
use std::fmt;

/// The laws and the plant to be certified.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The plant. Its built-in uncertainties are off by default: the certificates are about the undamped plant.
    pub plant: Parameters,
    /// Gains of the paper's law.
    pub paper: Gains,
    /// Gains of the root-strain law.
    pub root_strain: RootStrainGains,
    /// Gains of PD.
    pub pd: PdGains,
    /// Gains of PDS.
    pub pds: PdsGains,
    /// The actuator limits and inertias that laws use; the root-strain law uses its hub inertias.
    pub actuation: Actuation,
    /// Bounds of disturbances from outside.
    pub disturbance: Disturbance,
    /// λ_1^d and θ_1^d.
    pub references: References,
    /// Factor of all feedback gains of a [controller](crate::controllers::Controller).
    pub gain_factor: f64,
}

/// Why a value was not taken.
#[derive(Clone, Debug, PartialEq)]
pub enum SettingError {
    /// There is no such name.
    Unknown(String),
    /// The value is out of its range.
    Invalid(InvalidParameter),
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(name) => write!(
                f,
                "there is no \"{name}\" to set here: plant parameters, gains and targets have the names of the FMUs (`dualarm info`)"
            ),
            Self::Invalid(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SettingError {}

impl Default for Settings {
    fn default() -> Self {
        let plant = Parameters { root_uncertainty: 0.0, tip_uncertainty: 0.0, ..Parameters::default() };
        let actuation = Actuation { hub_inertia: plant.arms.map(|arm| arm.hub_inertia), ..Actuation::default() };
        Self {
            plant,
            paper: Gains::default(),
            root_strain: RootStrainGains::default(),
            pd: PdGains::default(),
            pds: PdsGains::default(),
            actuation,
            disturbance: Disturbance::default(),
            references: References { lambda1_ref: -0.5, theta1_ref: 3f64.to_radians() },
            gain_factor: 1.0,
        }
    }
}

/// Sets the row of that name in one of the owners, numbered from 1; whether there is one.
fn set_in<T>(table: &[Parameter<T>], owners: &mut [T], name: &str, value: f64) -> Result<bool, InvalidParameter> {
    for (number, owner) in owners.iter_mut().enumerate() {
        for row in table {
            if row.name.replace("{}", &(number + 1).to_string()) == name {
                Admissible::Within(row.range).check(name, value)?;
                *(row.field)(owner) = value;
                return Ok(true);
            }
        }
    }
    Ok(false)
}

impl Settings {
    /// Takes the gains of a preset of `NabfcController`, of both laws.
    ///
    /// # Errors
    /// An unknown name.
    pub fn set_preset(&mut self, name: &str) -> Result<(), SettingError> {
        let gains = match name {
            "parameters" => Some((Gains::default(), RootStrainGains::default())),
            _ => Gains::preset(name).zip(RootStrainGains::preset(name)),
        };
        (self.paper, self.root_strain) = gains.ok_or_else(|| SettingError::Unknown(name.to_owned()))?;
        Ok(())
    }

    /// Gives one value by name.
    ///
    /// # Errors
    /// An unknown name, a value out of its range.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), SettingError> {
        let one = std::slice::from_mut::<Parameters>;
        // PD and PDS have gains of the same names.
        let found = (|| {
            let (pd, pds) = (self.pd.set(name, value)?, self.pds.set(name, value)?);
            Ok(pd
                || pds
                || set_in(&Parameters::COMMON, one(&mut self.plant), name, value)?
                || set_in(&Arm::PARAMETERS, &mut self.plant.arms, name, value)?
                || set_in(&Start::ANGLES, std::slice::from_mut(&mut self.plant.start), name, value)?
                || set_in(&Start::OBJECT, std::slice::from_mut(&mut self.plant.start), name, value)?
                || set_in(Actuation::PARAMETERS, std::slice::from_mut(&mut self.actuation), name, value)?
                || self.paper.set(name, value)?
                || self.root_strain.set(name, value)?)
        })();
        match found {
            Err(error) => return Err(SettingError::Invalid(error)),
            Ok(true) => return Ok(()),
            Ok(false) => {}
        }
        let place = match name {
            "delta_f1" => &mut self.disturbance.size[0],
            "delta_f2" => &mut self.disturbance.size[1],
            "delta_F" => &mut self.disturbance.size[2],
            "delta_f1_dot" => &mut self.disturbance.rate[0],
            "delta_f2_dot" => &mut self.disturbance.rate[1],
            "delta_F_dot" => &mut self.disturbance.rate[2],
            "lambda1_ref" => &mut self.references.lambda1_ref,
            "theta1_ref" => &mut self.references.theta1_ref,
            _ => return Err(SettingError::Unknown(name.to_owned())),
        };
        *place = value;
        Ok(())
    }

    /// The numbers of (8)–(11).
    #[must_use]
    pub fn grasp(&self) -> Grasp {
        Grasp::from(&self.plant)
    }

    /// The static target.
    #[must_use]
    pub fn targets(&self) -> Targets {
        let ei = self.plant.arms.map(|arm| arm.ei);
        Arms { ei, length: self.plant.length, hub_distance: self.plant.object_width }.targets(&self.references)
    }

    /// Errors at the start: e_1, e_2 \[rad\], p \[m\].
    #[must_use]
    pub fn start_errors(&self) -> ([f64; 2], f64) {
        let (targets, start) = (self.targets(), &self.plant.start);
        (std::array::from_fn(|i| start.theta[i] - targets.theta[i]), start.y_object - targets.y_object)
    }

    /// The gains that (82)–(88) are about.
    #[must_use]
    pub fn printed_gains(&self) -> printed::Gains {
        let Gains { object, posture, .. } = &self.paper;
        printed::Gains {
            g: object.mu_bar + object.c1,
            k: object.k,
            g3: posture.each_ref().map(|hub| hub.mu + hub.c3),
            k_hub: posture.each_ref().map(|hub| hub.k),
        }
    }

    /// Learning rates and leakages of the paper's law.
    #[must_use]
    pub fn learning(&self) -> printed::Learning {
        let Gains { object: o, posture, .. } = &self.paper;
        printed::Learning {
            weights: [o.a1, o.a2],
            bias: [o.gamma1, o.gamma2],
            mass: [o.b1, o.b2],
            hub_weights: posture.each_ref().map(|hub| [hub.a3, hub.a4]),
            hub_bias: posture.each_ref().map(|hub| [hub.zeta1, hub.zeta2]),
            inertia: posture.each_ref().map(|hub| [hub.g1, hub.g2]),
        }
    }

    /// The paper's estimates of constants, with their ideal values: a network's weights and error bound are those of the
    /// given disturbances, the inertias are the true ones.
    #[must_use]
    pub fn estimators(&self) -> Vec<Estimator> {
        let (grasp, Gains { object: o, posture, .. }) = (self.grasp(), &self.paper);
        let [first, second, object] = self.disturbance.size;
        let one =
            |name: &str, gain: f64, leakage: f64, size: f64| Estimator { name: name.to_owned(), gain, leakage, size };
        let mut all = vec![
            one("W", o.a1, o.a2, object),
            one("epsilon_hat", o.gamma1, o.gamma2, object),
            one("m_hat", o.b1, o.b2, grasp.mass),
        ];
        for (i, (hub, size)) in posture.iter().zip([first, second]).enumerate() {
            let n = i + 1;
            all.extend([
                one(&format!("U{n}"), hub.a3, hub.a4, size),
                one(&format!("pi{n}_hat"), hub.zeta1, hub.zeta2, size),
                one(&format!("J{n}_hat"), hub.g1, hub.g2, grasp.arms[i].hub_inertia),
            ]);
        }
        all
    }

    /// The three ends under the root-strain law: hub 1, hub 2, object, with its dimensionless gains converted for these
    /// arms and for the inertias that it is set to. Built-in uncertainties are part of the ends. `None` if this is
    /// impossible: arms of different stiffness with `tip_uncertainty`, for which ΔF is no multiple of d/dt ΣQ_i.
    #[must_use]
    pub fn ports(&self) -> Option<[Port; 3]> {
        let (grasp, gains) = (self.grasp(), &self.root_strain);
        let [first, second] = grasp.arms.map(|arm| arm.ei);
        if self.plant.tip_uncertainty > 0.0 && first != second {
            return None;
        }
        let arms = Arms { ei: [first, second], length: grasp.length, ..Arms::default() };
        let scaled = Scaled::new(gains, &arms, &self.actuation);
        let assumed_mass = gains.mass.initial.clamp(gains.mass.smallest, gains.mass.largest);
        let hub = |i: usize| {
            let g = &gains.hub[i];
            Port {
                inertia: grasp.arms[i].hub_inertia,
                assumed_inertia: self.actuation.hub_inertia[i],
                slope: scaled.hub_slope[i],
                reach: scaled.hub_reach[i],
                strain: scaled.hub_strain[i] / self.actuation.hub_inertia[i],
                feedforward: g.feedforward,
                observer: g.observer,
                load_rate: self.plant.root_uncertainty,
            }
        };
        let object = Port {
            inertia: grasp.mass,
            assumed_inertia: assumed_mass,
            slope: scaled.slope,
            reach: scaled.reach,
            strain: scaled.strain / assumed_mass.sqrt(),
            feedforward: gains.object.feedforward,
            observer: gains.object.observer,
            // (EI_1+EI_2)ΣQ_i/EI_i for equal arms.
            load_rate: 2.0 * self.plant.tip_uncertainty,
        };
        Some([hub(0), hub(1), object])
    }

    /// Features of these gains of the root-strain law that the proof does not cover.
    #[must_use]
    pub fn uncovered(&self) -> Vec<&'static str> {
        let gains = &self.root_strain;
        let parts = [
            (
                gains.strain_rate_bandwidth > 0.0,
                "the low-pass on the rates of loads (r_strain_rate_bandwidth = 0 leaves it out)",
            ),
            (
                gains.strain_bandwidth > 0.0,
                "the low-pass on the root moments in the surfaces (r_strain_bandwidth = 0 leaves it out)",
            ),
            (gains.object.brake > 0.0, "the bend of the object's surface (r_brake = 0 makes it straight)"),
            (
                gains.mass.smallest < gains.mass.largest,
                "a changing estimate of the mass (equal r_mass_min and r_mass_max hold it)",
            ),
            (
                gains.inertia.smallest < gains.inertia.largest,
                "changing estimates of the hubs' inertias (r_inertia_min = r_inertia_max = 1 hold them)",
            ),
        ];
        parts.into_iter().filter_map(|(there, text)| there.then_some(text)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_name_is_known() {
        let mut settings = Settings::default();
        for (name, value) in [
            ("M", 0.4),
            ("EI2", 0.2),
            ("mu_bar", 3.0),
            ("c31", 2.0),
            ("r_slope", 9.0),
            ("r_strain2", 4.0),
            ("delta_F", 0.1),
        ] {
            settings.set(name, value).unwrap();
        }
        assert!((settings.grasp().mass - 0.6).abs() < 1e-15);
        assert_eq!(settings.printed_gains().g, 5.0);
        // In units of √(Σ3EI/l³ / r_mass_0).
        let natural = (3.0 * (0.115 + 0.2) / 0.2_f64.powi(3) / 0.5).sqrt();
        assert!((settings.ports().unwrap()[2].slope - 9.0 * natural).abs() < 1e-12);
        settings.set("r_inertia_max", 1.0).unwrap();
        settings.set("r_estimate_filter", 100.0).unwrap();
        assert!(matches!(settings.set("nonsense", 1.0), Err(SettingError::Unknown(_))));
        assert!(matches!(settings.set("EI1", -1.0), Err(SettingError::Invalid(_))));
    }

    /// The paper's start: 1.1222 mm and 3°, 3.64° (design notes).
    #[test]
    fn the_start_is_the_papers() {
        let (angle, position) = Settings::default().start_errors();
        assert!((angle[0] + 3f64.to_radians()).abs() < 1e-12 && (angle[1] - 0.063_582_151_4).abs() < 1e-9);
        assert!((position - 1.122_22e-3).abs() < 1e-8, "{position}");
    }
}

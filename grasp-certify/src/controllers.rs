//! The project's controllers by the names that the command line and the FMUs give them.

use crate::law::{LawError, SampledLaw};
use crate::settings::Settings;
use grasp_control::blocks::observer::RateSource;
use grasp_control::laws::GainSet;
use grasp_control::laws::encoders::Encoders;
use grasp_control::laws::nabfc::Nabfc;
use grasp_control::laws::pd::Pd;
use grasp_control::laws::pds::Pds;
use grasp_control::laws::root_strain::RootStrain;
use grasp_control::{Arms, Inputs, InvalidParameter, Law, Measurements};

/// A law with its gains.
#[derive(Clone, Debug)]
pub enum Controller {
    /// The paper's law.
    Paper(Box<Encoders<Nabfc>>),
    /// Root strain in the posture surfaces.
    RootStrain(Box<RootStrain>),
    /// PD with strain feedback.
    Pds(Encoders<Pds>),
    /// PD and PID.
    Pd(Encoders<Pd>),
}

/// Why there is no such controller.
#[derive(Debug, thiserror::Error)]
pub enum ControllerError {
    /// Unknown FMU, law, preset or source of rates.
    #[error("\"{0}\" is no {1} of the project's controllers")]
    Unknown(String, &'static str),
    /// A parameter is out of its range.
    #[error(transparent)]
    Invalid(#[from] InvalidParameter),
}

/// The gains of a preset, or these `parameters`.
fn chosen<G: GainSet>(preset: &str, parameters: G) -> Result<G, ControllerError> {
    if preset == "parameters" {
        return Ok(parameters);
    }
    G::preset(preset).ok_or_else(|| ControllerError::Unknown(preset.to_owned(), "preset"))
}

impl Controller {
    /// The law of an FMU (by its name without extension) with choices by name (`law`, `preset`, `rate_source`) and the
    /// numbers of `settings`, which a preset replaces as in the FMU.
    ///
    /// # Errors
    /// An unknown name, a number out of its range.
    pub fn new(fmu: &str, choices: &[(String, String)], settings: &Settings) -> Result<Self, ControllerError> {
        let choice = |name: &str, default: &'static str| {
            choices.iter().rev().find(|(known, _)| known == name).map_or(default, |(_, value)| value.as_str())
        };
        let preset = choice("preset", "parameters");
        let unknown = |value: &str, what: &'static str| ControllerError::Unknown(value.to_owned(), what);
        let source = match choice("rate_source", "measured") {
            "measured" => RateSource::Measured,
            "estimated" => RateSource::Estimated,
            other => return Err(unknown(other, "rate_source")),
        };
        let plant = &settings.plant;
        let arms = Arms { ei: plant.arms.map(|arm| arm.ei), length: plant.length, hub_distance: plant.object_width };
        let actuation = settings.actuation;
        Ok(match fmu {
            "NabfcController" => {
                let (factor, mut settings) = (settings.gain_factor, settings.clone());
                if preset != "parameters" {
                    settings.set_preset(preset).map_err(|_| unknown(preset, "preset"))?;
                }
                let (paper, root) = (&mut settings.paper, &mut settings.root_strain);
                scale(
                    factor,
                    [&mut paper.object.eta, &mut paper.object.k, &mut root.object.slope, &mut root.object.reach],
                );
                for (posture, hub) in paper.posture.iter_mut().zip(&mut root.hub) {
                    scale(factor, [&mut posture.xi, &mut posture.k, &mut hub.slope, &mut hub.reach]);
                }
                match choice("law", DEFAULT_LAW) {
                    "paper" => {
                        Self::Paper(Box::new(Encoders::new(Nabfc::new(arms, settings.paper)?, source, actuation)?))
                    }
                    "root_strain" => Self::RootStrain(Box::new(RootStrain::new(
                        arms,
                        settings.root_strain,
                        actuation,
                        source,
                        &settings.paper.rbf,
                    )?)),
                    other => return Err(unknown(other, "law")),
                }
            }
            "PdsController" => {
                let mut gains = chosen(preset, settings.pds)?;
                scale(settings.gain_factor, [&mut gains.kp, &mut gains.kv, &mut gains.ki]);
                for all in [&mut gains.kp_arm, &mut gains.kv_arm, &mut gains.ks_arm, &mut gains.ki_arm] {
                    scale(settings.gain_factor, all);
                }
                Self::Pds(Encoders::new(Pds::new(arms, gains, (&actuation).into())?, source, actuation)?)
            }
            "PdController" => {
                let mut gains = chosen(preset, settings.pd)?;
                scale(settings.gain_factor, [&mut gains.kp, &mut gains.kv, &mut gains.ki]);
                for all in [&mut gains.kp_arm, &mut gains.kv_arm, &mut gains.ki_arm] {
                    scale(settings.gain_factor, all);
                }
                Self::Pd(Encoders::new(Pd::new(arms, gains, (&actuation).into())?, source, actuation)?)
            }
            other => return Err(unknown(other, "FMU")),
        })
    }

    fn law(&mut self) -> &mut dyn Law {
        match self {
            Self::Paper(law) => &mut **law,
            Self::RootStrain(law) => &mut **law,
            Self::Pds(law) => law,
            Self::Pd(law) => law,
        }
    }

    /// Inputs at rest in the target of these settings' references.
    #[must_use]
    pub fn at_target(&mut self, settings: &Settings) -> Inputs {
        let reference = settings.references;
        let arms = *self.law().arms();
        let targets = arms.targets(&reference);
        let measured = Measurements {
            theta: targets.theta,
            y_object: targets.y_object,
            root_moment: targets.lambda.map(|lambda| -lambda * arms.length),
            tip_shear: targets.lambda,
            ..Measurements::default()
        };
        Inputs { measured, reference }
    }

    /// Puts the law into its initial state at these inputs and gives its linear system there for steps of `h` \[s\].
    ///
    /// # Errors
    /// The law refuses the step or can't be serialised.
    pub fn linear(&mut self, inputs: &Inputs, h: f64) -> Result<SampledLaw, LawError> {
        self.law().initialize(inputs);
        match self {
            Self::Paper(law) => SampledLaw::new(&**law, inputs, h),
            Self::RootStrain(law) => SampledLaw::new(&**law, inputs, h),
            Self::Pds(law) => SampledLaw::new(law, inputs, h),
            Self::Pd(law) => SampledLaw::new(law, inputs, h),
        }
    }
}

/// Multiplies gains.
fn scale<'a>(factor: f64, gains: impl IntoIterator<Item = &'a mut f64>) {
    for gain in gains {
        *gain *= factor;
    }
}

/// The default of `law` of `NabfcController` (`tests/test_linearise.py` compares).
const DEFAULT_LAW: &str = "root_strain";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampled::Coupled;
    use grasp_plant::Plant;

    fn controller(fmu: &str, choices: &[(&str, &str)]) -> Controller {
        let choices: Vec<_> = choices.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
        Controller::new(fmu, &choices, &Settings::default()).unwrap()
    }

    /// PD has no state; the root-strain law's observers have the double pole e^{−ωh} of their equations.
    #[test]
    fn states_are_found_and_named() {
        let (settings, h) = (Settings::default(), 1e-3);
        let mut pd = controller("PdController", &[]);
        let inputs = pd.at_target(&settings);
        let linear = pd.linear(&inputs, h).unwrap();
        assert!(linear.states.is_empty() && (linear.d[(2, 4)] + settings.pd.kp).abs() < 1e-12);
        let mut law = controller("NabfcController", &[("law", "root_strain")]);
        let linear = law.linear(&inputs, h).unwrap();
        let rate = linear.states.iter().position(|name| name == "observers.2.rate").expect("named");
        let learnt = linear.states.iter().position(|name| name == "observers.2.disturbance").expect("named");
        // ξ(h) = ξ_p + e^{−ωh}(1 + N h)(ξ − ξ_p) with N of the observer. The effect of the instant's Δ̂ on itself, with the
        // known force −Δ̂ of its own command, is the whole of it: e^{−ωh}(1 + ωh)(Δ̂ + F) − F with F = −Δ̂.
        assert!((linear.a[(learnt, learnt)] - 1.0).abs() < 1e-8, "{}", linear.a[(learnt, learnt)]);
        let decay = (-settings.root_strain.object.observer * h).exp();
        assert!(linear.a[(rate, rate)] < decay, "the law's own command brakes what the observer sees");
        // The sampled law with the plant is stable at 1 ms, and so is the reachable part alone.
        let plant = Plant::new(grasp_plant::Parameters::default()).unwrap();
        let coupled = Coupled::new(&plant, h);
        let radius = coupled.spectral_radius(&linear.reachable(), 0);
        assert!(radius < 1.0, "{radius}");
        assert!(linear.reachable().states.len() < linear.states.len());
    }

    /// PD by this way and by its gains has the same spectral radius.
    #[test]
    fn pd_is_the_pd_of_the_loops() {
        let settings = Settings::default();
        let mut pd = controller("PdController", &[]);
        let inputs = pd.at_target(&settings);
        let linear = pd.linear(&inputs, 1e-4).unwrap();
        let plant = Plant::new(grasp_plant::Parameters::default()).unwrap();
        let direct = crate::sampled::SampledLoop::new(
            &plant,
            &crate::LinearLoop::pds([10.0, 9.0], [60.0; 2], [55.0; 2], [0.0; 2]),
        );
        for delay in [0, 1, 3] {
            let (a, b) =
                (Coupled::new(&plant, 1e-4).spectral_radius(&linear, delay), direct.spectral_radius(1e-4, delay));
            assert!((a - b).abs() < 1e-9, "{delay}: {a} {b}");
        }
    }
}

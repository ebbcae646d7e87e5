//! The parameters by name, with unit and range: what is declared and what is checked.

use super::{FilterGains, HubGains, InertiaGains, MassGains, NetworkGains, ObjectGains, RootStrainGains};
use crate::laws::encoders::POLES;
use crate::laws::{Changes, GAIN, GainSet, Tables};
use parameter_table::{Admissible, InvalidParameter, Parameter, Range, parameter};

/// A share of an inertia.
const SHARE: Range = Range::new(0.0, 1.0);
/// Something that divides, of the magnitude of a gain.
const POSITIVE: Range = Range::new(1e-3, 1e6);
/// A share of the force limit. More than the whole of it is no brake, so a value beyond this range is one of earlier versions, which had
/// other units.
const BRAKE: Range = Range::new(0.0, 20.0);
/// Multiples of a hub's natural rate up to the beams'. An earlier version had rad/s.
const RATES: Range = Range::new(0.0, 40.0);
/// Forces and torques.
const THRESHOLD: Range = Range::new(1e-9, 1e6);
/// Weights and memories of the sums.
const EXCITATION: Range = Range::new(1e-12, 1e6);
/// The start, or less of it; or more.
const BELOW: Range = Range::new(1e-3, 1.0);
const ABOVE: Range = Range::new(1.0, 1e3);
/// Masses.
const MASS: Range = Range::new(1e-6, 1e6);

impl ObjectGains {
    /// The gains of the object's loop.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<ObjectGains>; 6] = [
            parameter!(
                "r_slope",
                "1",
                GAIN,
                "Root-strain law: slope of the object's surface, in units of the natural rate of the object between the arms",
                slope
            ),
            parameter!(
                "r_reach",
                "1",
                GAIN,
                "Root-strain law: rate at which the object's surface is reached, in units of its natural rate",
                reach
            ),
            parameter!(
                "r_strain",
                "1",
                POSITIVE,
                "Root-strain law: share of the tip shears in the object's surface, in units of its natural rate",
                strain
            ),
            parameter!("r_feedforward", "1", SHARE, "Root-strain law: share of m_hat that is fed forward", feedforward),
            parameter!(
                "r_brake",
                "1",
                BRAKE,
                "Root-strain law: share of u_limit with which the object is braked on its way to the target; 0 = its surface is straight",
                brake
            ),
            parameter!("r_observer", "rad/s", POLES, "Root-strain law: poles of the object's observer", observer),
        ];
        &ROWS
    };
}

impl HubGains {
    /// The gains of each hub's loop.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<HubGains>; 5] = [
            parameter!(
                "r_slope{}",
                "1",
                GAIN,
                "Root-strain law: slope of hub {}'s surface, in units of the natural rate of the object between the arms",
                slope
            ),
            parameter!(
                "r_reach{}",
                "1",
                GAIN,
                "Root-strain law: rate at which hub {}'s surface is reached, in units of its natural rate",
                reach
            ),
            parameter!(
                "r_strain{}",
                "1",
                POSITIVE,
                "Root-strain law: time by which the root moment over the inertia becomes a rate in hub {}'s surface, times the natural rate of the hub on its arm",
                strain
            ),
            parameter!(
                "r_feedforward{}",
                "1",
                SHARE,
                "Root-strain law: share of hub {}'s inertia that is fed forward",
                feedforward
            ),
            parameter!("r_observer{}", "rad/s", POLES, "Root-strain law: poles of hub {}'s observer", observer),
        ];
        &ROWS
    };
}

impl MassGains {
    /// The settings of the estimator.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<MassGains>; 5] = [
            parameter!("r_mass_min", "kg", MASS, "Root-strain law: smallest m_hat", smallest),
            parameter!("r_mass_max", "kg", MASS, "Root-strain law: largest m_hat", largest),
            parameter!(
                "r_mass_threshold",
                "N",
                THRESHOLD,
                "Root-strain law: force below which the object's motion hardly counts for its estimated mass",
                threshold
            ),
            parameter!(
                "r_mass_prior",
                "N2.s",
                EXCITATION,
                "Root-strain law: excitation that outweighs the mass at the start",
                prior
            ),
            parameter!(
                "r_mass_memory",
                "N2.s",
                EXCITATION,
                "Root-strain law: excitation after which older one is forgotten",
                memory
            ),
        ];
        &ROWS
    };
    /// The initial estimate, fixed once the law runs.
    pub const FIXED: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<MassGains>; 1] =
            [parameter!("r_mass_0", "kg", MASS, "Root-strain law: m_hat at the start", initial)];
        &ROWS
    };
}

impl FilterGains {
    /// The filters of all estimated inertias.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<FilterGains>; 2] = [
            parameter!(
                "r_estimate_filter",
                "rad/s",
                POLES,
                "Root-strain law: bandwidth of the filters of estimated mass and inertias",
                bandwidth
            ),
            parameter!(
                "r_estimate_high_pass",
                "rad/s",
                GAIN,
                "Root-strain law: corner below which forces and torques do not count for estimated mass and inertias",
                high_pass
            ),
        ];
        &ROWS
    };
}

impl InertiaGains {
    /// The settings of the estimators.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<InertiaGains>; 5] = [
            parameter!(
                "r_inertia_min",
                "1",
                BELOW,
                "Root-strain law: smallest J1_hat and J2_hat in units of observer_inertia1 and observer_inertia2",
                smallest
            ),
            parameter!("r_inertia_max", "1", ABOVE, "Root-strain law: largest J1_hat and J2_hat, likewise", largest),
            parameter!(
                "r_inertia_threshold",
                "N.m",
                THRESHOLD,
                "Root-strain law: torque below which a hub's motion hardly counts for its estimated inertia",
                threshold
            ),
            parameter!(
                "r_inertia_prior",
                "N2.m2.s",
                EXCITATION,
                "Root-strain law: excitation that outweighs the inertia at the start",
                prior
            ),
            parameter!(
                "r_inertia_memory",
                "N2.m2.s",
                EXCITATION,
                "Root-strain law: excitation after which older one is forgotten",
                memory
            ),
        ];
        &ROWS
    };
}

impl NetworkGains {
    /// The gains of networks and robust terms.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<NetworkGains>; 2] = [
            parameter!(
                "r_leakage",
                "1/s",
                GAIN,
                "Root-strain law with networks: rate at which they and the robust terms forget",
                leakage
            ),
            parameter!(
                "r_robust",
                "1",
                GAIN,
                "Root-strain law with networks: learning rate of the robust terms relative to theirs",
                robust
            ),
        ];
        &ROWS
    };
}

impl RootStrainGains {
    /// The gains of the law as a whole.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<RootStrainGains>; 2] = [
            parameter!(
                "r_strain_bandwidth",
                "rad/s",
                GAIN,
                "Root-strain law: bandwidth of the low-pass on the root moments in the surfaces; 0 = off",
                strain_bandwidth
            ),
            parameter!(
                "r_strain_rate_bandwidth",
                "1",
                RATES,
                "Root-strain law: bandwidth of the low-pass on the rates of moments and shears, in units of the natural rate of the hubs on their arms; 0 = off, and the measured rates are used",
                strain_rate_bandwidth
            ),
        ];
        &ROWS
    };

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is not a number in its range; a largest mass below the smallest.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        self.check()?;
        let least = Range::new(self.mass.smallest, MASS.max);
        Admissible::Within(least).check("r_mass_max", self.mass.largest)
    }
}

impl GainSet for RootStrainGains {
    fn tables(to: &mut impl Tables<Self>) {
        to.one(Changes::Always, ObjectGains::PARAMETERS, |gains| &mut gains.object);
        to.per_arm(Changes::Always, HubGains::PARAMETERS, |gains| &mut gains.hub);
        to.one(Changes::Always, MassGains::PARAMETERS, |gains| &mut gains.mass);
        to.one(Changes::Always, InertiaGains::PARAMETERS, |gains| &mut gains.inertia);
        to.one(Changes::Always, FilterGains::PARAMETERS, |gains| &mut gains.filter);
        to.one(Changes::Always, Self::PARAMETERS, |gains| gains);
        to.learner();
        to.one(Changes::Always, NetworkGains::PARAMETERS, |gains| &mut gains.networks);
        to.one(Changes::AtStart, MassGains::FIXED, |gains| &mut gains.mass);
    }

    fn preset(name: &str) -> Option<Self> {
        Some(match name {
            "fast" => Self::fast(),
            "certified" => Self::certified(),
            _ => return None,
        })
    }
}

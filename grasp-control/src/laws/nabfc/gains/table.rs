//! The parameters by name, with unit and range: what is declared and what is checked.

use super::{Gains, ObjectGains, PostureGains, RbfLayout};
use crate::blocks::rbf::WIDTHS;
use crate::laws::{Changes, DIVISOR, GAIN, GainSet, Tables};
use parameter_table::{Admissible, InvalidParameter, Parameter, Range, parameter};
use std::ops::RangeInclusive;

/// Admissible widths of the Gaussians.
const WIDTH: Range = Range::new(*WIDTHS.start(), *WIDTHS.end());

impl ObjectGains {
    /// The gains of the object loop.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<ObjectGains>; 12] = [
            parameter!("eta", "N.s/m", GAIN, "Switching gain of the object loop, eq. (36)", eta),
            parameter!("k", "N.s/m", GAIN, "Sliding-variable gain of the object loop, eq. (36)", k),
            parameter!("mu_bar", "1/s", GAIN, "Slope of the object loop's sliding surface, eq. (33)", mu_bar),
            parameter!("c1", "1/s", GAIN, "Virtual control gain of the object loop, eq. (34)", c1),
            parameter!("epsilon1", "m/s", DIVISOR, "Width of tanh in the object loop, eqs. (36), (38)", epsilon1),
            parameter!("a1", "N/m", GAIN, "Adaptation gain of the weights W, eq. (37); 0 = network off", a1),
            parameter!("a2", "m/(N.s)", GAIN, "Leakage of the weights W, eq. (37)", a2),
            parameter!("W_max", "N", GAIN, "Bound of W_norm, the radius of Lemma 3; 0 = no bound", w_max),
            parameter!("gamma1", "N/m", GAIN, "Adaptation gain of epsilon_hat, eq. (38)", gamma1),
            parameter!("gamma2", "m/(N.s)", GAIN, "Leakage of epsilon_hat, eq. (38)", gamma2),
            parameter!("b1", "kg.s2/m2", GAIN, "Adaptation gain of m_hat, eq. (39)", b1),
            parameter!("b2", "m2/(kg.s3)", GAIN, "Leakage of m_hat, eq. (39)", b2),
        ];
        &ROWS
    };
    /// The initial estimate, fixed once the law runs.
    pub const FIXED: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<ObjectGains>; 1] =
            [parameter!("m_hat_0", "kg", GAIN, "Initial estimate of the moving mass", m_hat_0)];
        &ROWS
    };
}

impl PostureGains {
    /// The gains of the posture loop of each arm.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<PostureGains>; 12] = [
            parameter!("xi{}", "N.m.s/rad", GAIN, "Switching gain of posture loop {}, eq. (54)", xi),
            parameter!("k{}", "N.m.s/rad", GAIN, "Sliding-variable gain of posture loop {}, eq. (54)", k),
            parameter!("mu{}", "1/s", GAIN, "Slope of the sliding surface of posture loop {}, eq. (51)", mu),
            parameter!("c3{}", "1/s", GAIN, "Virtual control gain of posture loop {}, eq. (52)", c3),
            parameter!("epsilon2{}", "rad/s", DIVISOR, "Width of tanh in posture loop {}, eqs. (54), (56)", epsilon2),
            parameter!("a3{}", "N.m/rad", GAIN, "Adaptation gain of the weights U{}, eq. (55); 0 = network off", a3),
            parameter!("a4{}", "rad/(N.m.s)", GAIN, "Leakage of the weights U{}, eq. (55)", a4),
            parameter!("U{}_max", "N.m", GAIN, "Bound of U{}_norm, the radius of Lemma 3; 0 = no bound", u_max),
            parameter!("zeta1{}", "N.m/rad", GAIN, "Adaptation gain of pi{}_hat, eq. (56)", zeta1),
            parameter!("zeta2{}", "rad/(N.m.s)", GAIN, "Leakage of pi{}_hat, eq. (56)", zeta2),
            parameter!("g1{}", "kg.m2.s2/rad2", GAIN, "Adaptation gain of J{}_hat, eq. (57)", g1),
            parameter!("g2{}", "rad2/(kg.m2.s3)", GAIN, "Leakage of J{}_hat, eq. (57)", g2),
        ];
        &ROWS
    };
    /// The initial estimate of each arm, fixed once the law runs.
    pub const FIXED: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<PostureGains>; 1] =
            [parameter!("J{}_hat_0", "kg.m2", GAIN, "Initial estimate of the inertia of hub {}", j_hat_0)];
        &ROWS
    };
}

impl RbfLayout {
    /// Admissible [`nodes_posture`](Self::nodes_posture), `rbf_nodes_posture` by name.
    pub const NODES_POSTURE: RangeInclusive<u32> = 1..=9;
    /// Admissible [`rings_object`](Self::rings_object), `rbf_rings_object` by name.
    pub const RINGS_OBJECT: RangeInclusive<u32> = 0..=4;

    /// Widths and scales, fixed once the law runs: the weights belong to them.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<RbfLayout>; 10] = [
            parameter!(
                "rbf_width_posture",
                "1",
                WIDTH,
                "Width of the posture networks' Gaussians, normalised",
                width_posture
            ),
            parameter!(
                "rbf_width_object",
                "1",
                WIDTH,
                "Width of the object network's Gaussians, normalised",
                width_object
            ),
            parameter!(
                "rbf_position_scale",
                "m",
                DIVISOR,
                "Network input scale of the position error p",
                position_scale
            ),
            parameter!(
                "rbf_object_surface_scale",
                "m/s",
                DIVISOR,
                "Network input scale of the sliding variable s",
                object_surface_scale
            ),
            parameter!(
                "rbf_object_alpha_scale",
                "m/s2",
                DIVISOR,
                "Network input scale of the virtual control rate of the object loop",
                object_alpha_scale
            ),
            parameter!("rbf_shear_scale", "1/m2", DIVISOR, "Network input scale of w'''(l)", shear_scale),
            parameter!(
                "rbf_shear_rate_scale",
                "1/(m2.s)",
                DIVISOR,
                "Network input scale of the rate of w'''(l)",
                shear_rate_scale
            ),
            parameter!("rbf_angle_scale", "rad", DIVISOR, "Network input scale of the angle errors e", angle_scale),
            parameter!(
                "rbf_posture_surface_scale",
                "rad/s",
                DIVISOR,
                "Network input scale of the sliding variables s1, s2",
                posture_surface_scale
            ),
            parameter!(
                "rbf_posture_alpha_scale",
                "rad/s2",
                DIVISOR,
                "Network input scale of the virtual control rates of the posture loops",
                posture_alpha_scale
            ),
        ];
        &ROWS
    };

    fn validate_counts(&self) -> Result<(), InvalidParameter> {
        for (name, value, range) in [
            ("rbf_nodes_posture", self.nodes_posture, Self::NODES_POSTURE),
            ("rbf_rings_object", self.rings_object, Self::RINGS_OBJECT),
        ] {
            let range = Range::new((*range.start()).into(), (*range.end()).into());
            Admissible::Within(range).check(name, value.into())?;
        }
        Ok(())
    }
}

impl Gains {
    /// The gains of the law as a whole.
    pub const PARAMETERS: &'static [Parameter<Self>] = {
        static ROWS: [Parameter<Gains>; 2] = [
            parameter!("sat_limit", "1", GAIN, "Limit of sat, which replaces sign in eqs. (36), (54)", sat_limit),
            parameter!(
                "shear_rate_bandwidth",
                "rad/s",
                GAIN,
                "Bandwidth of the low-pass on the shear rates; 0 = off",
                shear_rate_bandwidth
            ),
        ];
        &ROWS
    };

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is not a number in its range.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        self.check()?;
        self.rbf.validate_counts()
    }
}

impl GainSet for Gains {
    fn tables(to: &mut impl Tables<Self>) {
        to.one(Changes::Always, ObjectGains::PARAMETERS, |gains| &mut gains.object);
        to.per_arm(Changes::Always, PostureGains::PARAMETERS, |gains| &mut gains.posture);
        to.one(Changes::Always, Self::PARAMETERS, |gains| gains);
        to.per_arm(Changes::AtStart, PostureGains::FIXED, |gains| &mut gains.posture);
        to.one(Changes::AtStart, ObjectGains::FIXED, |gains| &mut gains.object);
        to.one(Changes::AtStart, RbfLayout::PARAMETERS, |gains| &mut gains.rbf);
    }

    /// The paper's law has no certificate, so *certified* are its start values.
    fn preset(name: &str) -> Option<Self> {
        Some(match name {
            "fast" => Self::fast(),
            "certified" => Self::default(),
            _ => return None,
        })
    }
}

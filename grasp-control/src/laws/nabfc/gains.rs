//! Gains of the NABFC law: names, units, ranges, presets.

use crate::blocks::rbf::{Layout, WIDTHS};
use crate::parameter::{Parameter, ParameterError, Range, check, check_value};
use serde::{Deserialize, Serialize};

/// Gains of the object-position loop, eqs. (33)–(39).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObjectGains {
    /// Switching gain η \[N·s/m\], ≥ 0; acts on sat(s).
    pub eta: f64,
    /// Gain k of the sliding variable \[N·s/m\], ≥ 0.
    pub k: f64,
    /// Slope μ̄ of the sliding surface (33) \[1/s\], ≥ 0.
    pub mu_bar: f64,
    /// Gain c₁ of the virtual control (34) \[1/s\], ≥ 0.
    pub c1: f64,
    /// Width ϵ₁ of the tanh in (36) and (38) \[m/s\], > 0.
    pub epsilon1: f64,
    /// Adaptation gain a₁ of the network weights (37) \[N/m\], ≥ 0; zero switches the network off.
    pub a1: f64,
    /// Leakage a₂ of the network weights (37) \[m/(N·s)\], ≥ 0.
    pub a2: f64,
    /// Adaptation gain γ₁ of the bound ε̂ (38) \[N/m\], ≥ 0.
    pub gamma1: f64,
    /// Leakage γ₂ of the bound ε̂ (38) \[m/(N·s)\], ≥ 0.
    pub gamma2: f64,
    /// Adaptation gain b₁ of the mass m̂ (39) \[kg·s²/m²\], ≥ 0.
    pub b1: f64,
    /// Leakage b₂ of the mass m̂ (39) \[m²/(kg·s³)\], ≥ 0.
    pub b2: f64,
    /// Initial estimate m̂(0) of the moving mass m₁ + m₂ + M \[kg\], ≥ 0.
    ///
    /// m̂ multiplies a shear *rate*: near the true mass the loop gain at high frequency exceeds what any sampled loop
    /// bears, and the force ends in a limit cycle. Keep it well below.
    pub m_hat_0: f64,
}

/// Gains of the posture loop of one arm, eqs. (51)–(57).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PostureGains {
    /// Switching gain ξᵢ \[N·m·s/rad\], ≥ 0; acts on sat(sᵢ).
    pub xi: f64,
    /// Gain kᵢ of the sliding variable \[N·m·s/rad\], ≥ 0.
    pub k: f64,
    /// Slope μᵢ of the sliding surface (51) \[1/s\], ≥ 0.
    pub mu: f64,
    /// Gain c₃ᵢ of the virtual control (52) \[1/s\], ≥ 0.
    pub c3: f64,
    /// Width ϵ₂ᵢ of the tanh in (54) and (56) \[rad/s\], > 0.
    pub epsilon2: f64,
    /// Adaptation gain a₃ᵢ of the network weights (55) \[N·m/rad\], ≥ 0; zero switches the network off.
    pub a3: f64,
    /// Leakage a₄ᵢ of the network weights (55) \[rad/(N·m·s)\], ≥ 0.
    pub a4: f64,
    /// Adaptation gain ζ₁ᵢ of the bound π̂ᵢ (56) \[N·m/rad\], ≥ 0.
    pub zeta1: f64,
    /// Leakage ζ₂ᵢ of the bound π̂ᵢ (56) \[rad/(N·m·s)\], ≥ 0.
    pub zeta2: f64,
    /// Adaptation gain g₁ᵢ of the hub inertia Ĵᵢ (57) \[kg·m²·s²/rad²\], ≥ 0.
    pub g1: f64,
    /// Leakage g₂ᵢ of the hub inertia Ĵᵢ (57) \[rad²/(kg·m²·s³)\], ≥ 0.
    pub g2: f64,
    /// Initial estimate Ĵᵢ(0) of the hub inertia \[kg·m²\], ≥ 0.
    pub j_hat_0: f64,
}

/// Layout and scaling of the networks, see [`rbf`](crate::blocks::rbf).
///
/// A scale is the magnitude of a signal that maps to the edge of the box the centres fill.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RbfLayout {
    /// Nodes per axis of the posture networks, 1 to 9; a network has the cube of it.
    pub nodes_posture: u32,
    /// Nodes of the object network on each side of the origin along each of its seven axes, 0 to 4.
    pub rings_object: u32,
    /// Width b of the posture networks' Gaussians in normalised units, 0.1 to 10.
    pub width_posture: f64,
    /// Width b of the object network's Gaussians in normalised units, 0.1 to 10.
    pub width_object: f64,
    /// Scale of z₁ = p \[m\], > 0.
    pub position_scale: f64,
    /// Scale of s \[m/s\], > 0.
    pub object_surface_scale: f64,
    /// Scale of α̇₁ \[m/s²\], > 0.
    pub object_alpha_scale: f64,
    /// Scale of wᵢ'''(l) \[1/m²\], > 0.
    pub shear_scale: f64,
    /// Scale of ẇᵢ'''(l) \[1/(m²·s)\], > 0.
    pub shear_rate_scale: f64,
    /// Scale of eᵢ \[rad\], > 0.
    pub angle_scale: f64,
    /// Scale of sᵢ \[rad/s\], > 0.
    pub posture_surface_scale: f64,
    /// Scale of α̇₂ᵢ \[rad/s²\], > 0.
    pub posture_alpha_scale: f64,
}

impl Default for RbfLayout {
    /// Five nodes per axis, wide enough to overlap, on boxes that hold the way into the grasp.
    fn default() -> Self {
        Self {
            nodes_posture: 5,
            rings_object: 2,
            width_posture: 1.1,
            width_object: 0.75,
            position_scale: 0.01,
            object_surface_scale: 1.0,
            object_alpha_scale: 50.0,
            shear_scale: 10.0,
            shear_rate_scale: 50.0,
            angle_scale: 0.05,
            posture_surface_scale: 0.7,
            posture_alpha_scale: 5.0,
        }
    }
}

impl RbfLayout {
    /// Admissible `rbf_nodes_posture`.
    pub const NODES_POSTURE: std::ops::RangeInclusive<u32> = 1..=9;
    /// Admissible `rbf_rings_object`.
    pub const RINGS_OBJECT: std::ops::RangeInclusive<u32> = 0..=4;

    /// Layout of a posture network.
    #[must_use]
    pub const fn posture(&self) -> Layout {
        Layout::Grid(self.nodes_posture as usize)
    }

    /// Layout of the object network.
    #[must_use]
    pub const fn object(&self) -> Layout {
        Layout::Star(self.rings_object as usize)
    }
}

/// All parameters of the NABFC law; index 0 of an array is arm 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gains {
    /// Object-position loop.
    pub object: ObjectGains,
    /// Posture loops.
    pub posture: [PostureGains; 2],
    /// Limit of `sat`, which replaces the sign function: sat clips its argument to ± this value. In m/s in (36), in
    /// rad/s in (54). 0 switches these terms off.
    pub sat_limit: f64,
    /// Bandwidth of the low-pass on the measured shear rates \[rad/s\]; 0 = off.
    pub shear_rate_bandwidth: f64,
    /// Networks.
    pub rbf: RbfLayout,
}

/// Admissible widths of the Gaussians.
const WIDTH: Range = Range::from(*WIDTHS.start(), *WIDTHS.end());

/// The parameters of one posture loop.
macro_rules! posture_parameters {
    ($arm:literal, $index:literal) => {
        [
            parameter!(
                concat!("xi", $arm),
                "N.m.s/rad",
                Range::GAIN,
                concat!("switching gain of posture loop ", $arm, ", eq. (54)"),
                posture[$index].xi
            ),
            parameter!(
                concat!("k", $arm),
                "N.m.s/rad",
                Range::GAIN,
                concat!("sliding-variable gain of posture loop ", $arm, ", eq. (54)"),
                posture[$index].k
            ),
            parameter!(
                concat!("mu", $arm),
                "1/s",
                Range::GAIN,
                concat!("slope of the sliding surface of posture loop ", $arm, ", eq. (51)"),
                posture[$index].mu
            ),
            parameter!(
                concat!("c3", $arm),
                "1/s",
                Range::GAIN,
                concat!("virtual control gain of posture loop ", $arm, ", eq. (52)"),
                posture[$index].c3
            ),
            parameter!(
                concat!("epsilon2", $arm),
                "rad/s",
                Range::DIVISOR,
                concat!("width of tanh in posture loop ", $arm, ", eqs. (54), (56)"),
                posture[$index].epsilon2
            ),
            parameter!(
                concat!("a3", $arm),
                "N.m/rad",
                Range::GAIN,
                concat!("adaptation gain of the weights U", $arm, ", eq. (55); 0 = network off"),
                posture[$index].a3
            ),
            parameter!(
                concat!("a4", $arm),
                "rad/(N.m.s)",
                Range::GAIN,
                concat!("leakage of the weights U", $arm, ", eq. (55)"),
                posture[$index].a4
            ),
            parameter!(
                concat!("zeta1", $arm),
                "N.m/rad",
                Range::GAIN,
                concat!("adaptation gain of pi", $arm, "_hat, eq. (56)"),
                posture[$index].zeta1
            ),
            parameter!(
                concat!("zeta2", $arm),
                "rad/(N.m.s)",
                Range::GAIN,
                concat!("leakage of pi", $arm, "_hat, eq. (56)"),
                posture[$index].zeta2
            ),
            parameter!(
                concat!("g1", $arm),
                "kg.m2.s2/rad2",
                Range::GAIN,
                concat!("adaptation gain of J", $arm, "_hat, eq. (57)"),
                posture[$index].g1
            ),
            parameter!(
                concat!("g2", $arm),
                "rad2/(kg.m2.s3)",
                Range::GAIN,
                concat!("leakage of J", $arm, "_hat, eq. (57)"),
                posture[$index].g2
            ),
        ]
    };
}

impl Gains {
    /// Object-loop parameters by their names in the interface.
    pub const OBJECT: [Parameter<Self>; 11] = [
        parameter!("eta", "N.s/m", Range::GAIN, "switching gain of the object loop, eq. (36)", object.eta),
        parameter!("k", "N.s/m", Range::GAIN, "sliding-variable gain of the object loop, eq. (36)", object.k),
        parameter!("mu_bar", "1/s", Range::GAIN, "slope of the object loop's sliding surface, eq. (33)", object.mu_bar),
        parameter!("c1", "1/s", Range::GAIN, "virtual control gain of the object loop, eq. (34)", object.c1),
        parameter!(
            "epsilon1",
            "m/s",
            Range::DIVISOR,
            "width of tanh in the object loop, eqs. (36), (38)",
            object.epsilon1
        ),
        parameter!("a1", "N/m", Range::GAIN, "adaptation gain of the weights W, eq. (37); 0 = network off", object.a1),
        parameter!("a2", "m/(N.s)", Range::GAIN, "leakage of the weights W, eq. (37)", object.a2),
        parameter!("gamma1", "N/m", Range::GAIN, "adaptation gain of epsilon_hat, eq. (38)", object.gamma1),
        parameter!("gamma2", "m/(N.s)", Range::GAIN, "leakage of epsilon_hat, eq. (38)", object.gamma2),
        parameter!("b1", "kg.s2/m2", Range::GAIN, "adaptation gain of m_hat, eq. (39)", object.b1),
        parameter!("b2", "m2/(kg.s3)", Range::GAIN, "leakage of m_hat, eq. (39)", object.b2),
    ];
    /// Parameters of posture loop 1 by their names in the interface.
    pub const POSTURE1: [Parameter<Self>; 11] = posture_parameters!("1", 0);
    /// Parameters of posture loop 2 by their names in the interface.
    pub const POSTURE2: [Parameter<Self>; 11] = posture_parameters!("2", 1);
    /// Parameters of the whole law by their names in the interface.
    pub const COMMON: [Parameter<Self>; 2] = [
        parameter!("sat_limit", "1", Range::GAIN, "limit of sat, which replaces sign in eqs. (36), (54)", sat_limit),
        parameter!(
            "shear_rate_bandwidth",
            "rad/s",
            Range::GAIN,
            "bandwidth of the low-pass on the shear rates; 0 = off",
            shear_rate_bandwidth
        ),
    ];

    /// Parameters that are fixed once the law runs: initial estimates, and the layout that the weights belong to.
    pub const FIXED: [Parameter<Self>; 13] = [
        parameter!("J1_hat_0", "kg.m2", Range::GAIN, "initial estimate of the inertia of hub 1", posture[0].j_hat_0),
        parameter!("J2_hat_0", "kg.m2", Range::GAIN, "initial estimate of the inertia of hub 2", posture[1].j_hat_0),
        parameter!("m_hat_0", "kg", Range::GAIN, "initial estimate of the moving mass", object.m_hat_0),
        parameter!(
            "rbf_width_posture",
            "1",
            WIDTH,
            "width of the posture networks' Gaussians, normalised",
            rbf.width_posture
        ),
        parameter!(
            "rbf_width_object",
            "1",
            WIDTH,
            "width of the object network's Gaussians, normalised",
            rbf.width_object
        ),
        parameter!(
            "rbf_position_scale",
            "m",
            Range::DIVISOR,
            "network input scale of the position error p",
            rbf.position_scale
        ),
        parameter!(
            "rbf_object_surface_scale",
            "m/s",
            Range::DIVISOR,
            "network input scale of the sliding variable s",
            rbf.object_surface_scale
        ),
        parameter!(
            "rbf_object_alpha_scale",
            "m/s2",
            Range::DIVISOR,
            "network input scale of the virtual control rate of the object loop",
            rbf.object_alpha_scale
        ),
        parameter!("rbf_shear_scale", "1/m2", Range::DIVISOR, "network input scale of w'''(l)", rbf.shear_scale),
        parameter!(
            "rbf_shear_rate_scale",
            "1/(m2.s)",
            Range::DIVISOR,
            "network input scale of the rate of w'''(l)",
            rbf.shear_rate_scale
        ),
        parameter!(
            "rbf_angle_scale",
            "rad",
            Range::DIVISOR,
            "network input scale of the angle errors e",
            rbf.angle_scale
        ),
        parameter!(
            "rbf_posture_surface_scale",
            "rad/s",
            Range::DIVISOR,
            "network input scale of the sliding variables s1, s2",
            rbf.posture_surface_scale
        ),
        parameter!(
            "rbf_posture_alpha_scale",
            "rad/s2",
            Range::DIVISOR,
            "network input scale of the virtual control rates of the posture loops",
            rbf.posture_alpha_scale
        ),
    ];

    /// All real parameters; the two integers of the networks' layout are `rbf_nodes_posture` and `rbf_rings_object`.
    pub fn parameters() -> impl Iterator<Item = &'static Parameter<Self>> {
        const { &Self::OBJECT }
            .iter()
            .chain(const { &Self::POSTURE1 })
            .chain(const { &Self::POSTURE2 })
            .chain(const { &Self::COMMON })
            .chain(const { &Self::FIXED })
    }

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter that is not finite or not in its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check(Self::parameters(), self)?;
        let counts = [
            ("rbf_nodes_posture", self.rbf.nodes_posture, RbfLayout::NODES_POSTURE),
            ("rbf_rings_object", self.rbf.rings_object, RbfLayout::RINGS_OBJECT),
        ];
        for (name, value, range) in counts {
            let range = Range::from((*range.start()).into(), (*range.end()).into());
            check_value(name, value.into(), range)?;
        }
        Ok(())
    }

    /// These gains with all networks switched off: a₁ = a₃ᵢ = 0.
    #[must_use]
    pub fn without_networks(mut self) -> Self {
        self.object.a1 = 0.0;
        for posture in &mut self.posture {
            posture.a3 = 0.0;
        }
        self
    }

    /// The fast preset: the object loop of the default with posture loops of twice the slope.
    ///
    /// Both contact forces settle within 2 % in 0.16 s with 0.3 % overshoot, |τ| ≤ 0.9 N·m, |u| ≤ 0.21 N, at steps of
    /// 0.05 to 1 ms. Less forgiving than the default: a larger change of the references overshoots.
    #[must_use]
    pub fn fast() -> Self {
        let default = Self::default();
        let posture = PostureGains { xi: 1.0, k: 0.3, mu: 13.0, c3: 13.0, a3: 15.0, ..default.posture[0] };
        let rbf =
            RbfLayout { width_posture: 0.8, posture_surface_scale: 1.3, posture_alpha_scale: 10.0, ..default.rbf };
        Self { posture: [posture; 2], rbf, ..default }
    }

    /// A plain set without networks and without low-pass, and with a stiff object loop; a baseline for comparisons.
    ///
    /// Both contact forces settle within 2 % in 0.43 s, without overshoot. Away from the nominal case (unequal arms or
    /// hubs, another reference, a heavy object, `EI` known too small) the object force saturates and stays in a limit
    /// cycle.
    #[must_use]
    pub fn baseline() -> Self {
        let posture = PostureGains {
            xi: 1.0,
            k: 0.3,
            mu: 5.0,
            c3: 5.0,
            epsilon2: 0.1,
            a3: 0.0,
            a4: 0.0,
            zeta1: 1.0,
            zeta2: 0.01,
            g1: 0.01,
            g2: 0.01,
            j_hat_0: 0.0,
        };
        let object = ObjectGains {
            eta: 1.0,
            k: 5.0,
            mu_bar: 5.0,
            c1: 5.0,
            epsilon1: 0.1,
            a1: 0.0,
            a2: 0.0,
            gamma1: 1.0,
            gamma2: 0.01,
            b1: 1.0,
            b2: 0.01,
            m_hat_0: 0.0,
        };
        let rbf = RbfLayout::default();
        Self { object, posture: [posture; 2], sat_limit: 0.01, shear_rate_bandwidth: 0.0, rbf }
    }
}

impl Default for Gains {
    /// Tuned for robustness: both contact forces settle within 2 % in 0.31 s with less than 0.1 % overshoot,
    /// |τ| ≤ 0.62 N·m, |u| ≤ 0.17 N, at steps of 0.05 to 1 ms.
    ///
    /// The object loop is soft on purpose. s contains Σ q'''(l), 750 times the position error of a squeezed object, so
    /// η and k act 750-fold; and what they gain in stiffness they lose, one sampling delay later, in damping. m̂ adds
    /// damping at the object's own frequency, and the low-pass keeps it from feeding back the beams'. What stiffness
    /// leaves of a lasting disturbance the networks take over: their learning rates a₁‖Y‖² and a₃‖Y‖² are those of an
    /// integrator about as fast as its loop, and their leakage is small enough that hardly any error stays.
    fn default() -> Self {
        let posture = PostureGains {
            xi: 0.8,
            k: 0.38,
            mu: 6.5,
            c3: 6.5,
            epsilon2: 0.2,
            a3: 10.0,
            a4: 1e-4,
            zeta1: 3.0,
            zeta2: 0.002,
            g1: 0.001,
            g2: 0.01,
            j_hat_0: 0.0,
        };
        let object = ObjectGains {
            eta: 0.3,
            k: 0.25,
            mu_bar: 2.0,
            c1: 2.0,
            epsilon1: 1.0,
            a1: 0.4,
            a2: 0.001,
            gamma1: 0.01,
            gamma2: 1.0,
            b1: 3e-4,
            b2: 1.0,
            m_hat_0: 0.015,
        };
        let rbf = RbfLayout::default();
        Self { object, posture: [posture; 2], sat_limit: 0.01, shear_rate_bandwidth: 300.0, rbf }
    }
}

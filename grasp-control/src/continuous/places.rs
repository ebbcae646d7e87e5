//! Where states and indicators are.

use crate::laws::nabfc::RbfLayout;

/// Places of the states.
pub(crate) mod state {
    use std::ops::Range;

    /// Position, rate and disturbance of hub 1, of hub 2 and of the object, as observed.
    pub const OBSERVERS: Range<usize> = 0..9;
    /// PD and PDS: integrals of hub 1, hub 2 and object.
    pub const INTEGRALS: Range<usize> = 9..12;
    /// NABFC, paper's law: filtered rates of tip shears.
    pub const SHEAR_RATES: Range<usize> = 9..11;
    /// Root-strain law: filtered root moments, from which their rates come.
    pub const SLOW_MOMENTS: Range<usize> = 11..13;
    /// Ĵ₁, Ĵ₂, m̂ of the paper's update laws.
    pub const INERTIAS: Range<usize> = 13..16;
    /// π̂₁, π̂₂, ε̂.
    pub const BOUNDS: Range<usize> = 16..19;
    /// Filters and sums of the estimates of inertias by least squares: hub 1, hub 2, object.
    pub const ESTIMATORS: Range<usize> = 19..52;
    /// Filtered root moments.
    pub const MOMENTS: Range<usize> = 52..54;
    /// Filtered tip shears, from which their rates come.
    pub const SLOW_SHEARS: Range<usize> = 54..56;
    /// Û₁, Û₂, Ŵ.
    pub const WEIGHTS: usize = 56;
}

/// Places of the event indicators: hub 1, hub 2, object.
pub(crate) mod indicator {
    use std::ops::Range;

    /// Commands at the limits where integrals stop.
    pub const ANTI_WINDUP: Range<usize> = 0..3;
    /// Commands at the limits that observers know.
    pub const LIMITS: Range<usize> = 3..6;
    /// Observed disturbances at their limits.
    pub const DISTURBANCES: Range<usize> = 6..9;
    /// Surfaces at the corners of `sat`.
    pub const SATURATIONS: Range<usize> = 9..12;
    /// Weights on their balls.
    pub const WEIGHTS: Range<usize> = 12..15;
    /// Robust terms at their limits.
    pub const BOUNDS: Range<usize> = 15..18;
    /// Learnt forces, networks and robust terms together, at their limits.
    pub const UNKNOWNS: Range<usize> = 18..21;
    /// Estimates of inertias at their smallest and largest values, and where losses become positive.
    pub const ESTIMATORS: Range<usize> = 21..30;
}

/// Number of states of PD and PDS.
pub const PDS_STATES: usize = state::INTEGRALS.end;
/// Number of event indicators of PD and PDS.
pub const PDS_INDICATORS: usize = indicator::DISTURBANCES.end;
/// Number of event indicators of NABFC, whatever the law.
pub const NABFC_INDICATORS: usize = indicator::ESTIMATORS.end;

/// Number of states of NABFC with these networks, whatever the law.
#[must_use]
#[inline]
pub fn nabfc_states(layout: &RbfLayout) -> usize {
    state::WEIGHTS + 2 * layout.posture().nodes(3) + layout.object().nodes(7)
}

//! Where things are in the vectors of a plant that can open.

use crate::dynamics::FORCES;

/// Both sides' signs in (12): gap i is σ_i (`Y_i(l)` − (`y_M` − L/2)), since arm 1 is below the object and arm 2 above.
pub const SIGN: [f64; 2] = [-1.0, 1.0];

/// Coordinates x = (a_1, a_2, b_1, b_2, √J_1 θ̇_1, √J_2 θ̇_2, √m_1 v_1(l), √m_2 v_2(l), √M ẏ_M, √k_1 δ_1, √k_2 δ_2), then what a
/// step adds to them: Θ = ∫(θ̇_1, θ̇_2, ẏ_M), Γ = ∫(rates of both gaps), Ψ = ∫Θ, the forces g and their rates r.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    /// Order k of the discretisation.
    pub order: usize,
}

impl Layout {
    const LARGEST: Self = Self { order: *crate::parameters::ORDER_RANGE.end() };

    /// Coordinates of the largest order.
    pub const MOST_COORDINATES: usize = Self::LARGEST.size();

    /// What a step adds to them, too.
    const MOST: usize = Self::LARGEST.extended();

    /// Panels of the largest vector.
    pub const MOST_PANELS: usize = Self::MOST.div_ceil(crate::kernel::LANES);

    /// First moment coefficient of an arm, the one that holds its tip deflection.
    pub const fn moments(self, arm: usize) -> usize {
        arm * self.order
    }

    /// First velocity coefficient of an arm.
    pub const fn field(self, arm: usize) -> usize {
        2 * self.order + arm * (self.order - 1)
    }

    pub const fn hub(self, arm: usize) -> usize {
        self.field(2) + arm
    }

    pub const fn tip(self, arm: usize) -> usize {
        self.hub(2) + arm
    }

    pub const fn object(self) -> usize {
        self.tip(2)
    }

    /// Deformation of the object's face at an arm.
    pub const fn face(self, arm: usize) -> usize {
        self.object() + 1 + arm
    }

    /// Number of coordinates, 4k + 5.
    pub const fn size(self) -> usize {
        self.face(2)
    }

    pub const fn travel(self) -> usize {
        self.size()
    }

    pub const fn opening(self) -> usize {
        self.travel() + FORCES
    }

    pub const fn travel_integral(self) -> usize {
        self.opening() + 2
    }

    pub const fn force(self) -> usize {
        self.travel_integral() + FORCES
    }

    pub const fn force_rate(self) -> usize {
        self.force() + FORCES
    }

    pub const fn extended(self) -> usize {
        self.force_rate() + FORCES
    }

    /// What a piece starts from: (x, g, r).
    pub const fn drive(self) -> usize {
        self.size() + 2 * FORCES
    }

    /// What a piece adds: increments of x, Θ, Γ, Ψ.
    pub const fn increments(self) -> usize {
        self.force()
    }
}

//! Where the centres of a network are, and where their weights.

use crate::blocks::four::LANES;
use serde::{Deserialize, Serialize};

/// Largest number of nodes along one axis.
pub const MAX_PER_AXIS: usize = 9;

/// Nodes per axis of a posture network by default.
pub(super) const USUAL: usize = 5;

/// Fours in a row of such a grid with three axes.
pub(super) const USUAL_ROW: usize = (USUAL * USUAL).div_ceil(LANES);

/// Room for the axes of a network, in fours, with one lane to spare.
pub(super) const GROUPS: usize = 2;

/// Axes of the networks with seven inputs by their lanes: first those that stay where only shear rates change, then α̇₁ and the
/// shear rates, so that a step, which sees the shear rates at two points, evaluates the first four only once.
const OBJECT_AXES: [usize; 7] = [0, 1, 3, 4, 2, 5, 6];

/// Fours of the axes of a network, with one lane to spare: there is the common factor of a star.
pub(super) const fn groups(dimensions: usize) -> usize {
    (dimensions + 1).div_ceil(LANES)
}

/// The axis that a lane stands for.
pub(super) const fn axis(dimensions: usize, lane: usize) -> usize {
    if dimensions == OBJECT_AXES.len() { OBJECT_AXES[lane] } else { lane }
}

/// The lane that stands for an axis.
pub(super) const fn lane(dimensions: usize, of: usize) -> usize {
    let mut lane = 0;
    while axis(dimensions, lane) != of {
        lane += 1;
    }
    lane
}

/// Where the centres are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Layout {
    /// Tensor grid of at most three axes with this many nodes per axis, 1 ≤ n ≤ 9; n = 1 is a single node at the origin.
    Grid(usize),
    /// A node at the origin and this many on each side of it along every axis, 0 ≤ r ≤ 4.
    Star(usize),
}

impl Layout {
    /// Nodes along one axis.
    pub(super) const fn per_axis(self) -> usize {
        match self {
            Self::Grid(n) => n,
            Self::Star(rings) => 2 * rings + 1,
        }
    }

    /// Whether the numbers of axes and of nodes per axis are in their ranges.
    pub(super) const fn is_possible(self, dimensions: usize) -> bool {
        match self {
            Self::Grid(n) => groups(dimensions) == 1 && 1 <= n && n <= MAX_PER_AXIS,
            Self::Star(rings) => rings <= MAX_PER_AXIS / 2,
        }
    }

    /// Rows of the weights: as many as the first axis of a grid has nodes.
    pub(super) const fn rows(self) -> usize {
        match self {
            Self::Grid(n) => n,
            Self::Star(_) => 1,
        }
    }

    /// Lanes of a row, in fours.
    pub(super) fn row_length(self, dimensions: usize) -> usize {
        match self {
            Self::Grid(_) => (self.nodes(dimensions) / self.rows()).div_ceil(LANES),
            Self::Star(rings) => 1 + 2 * rings * groups(dimensions),
        }
    }

    /// Where the weight of a node is: the row, and the lane in it.
    ///
    /// The row of a star has its origin first, then position by position along the axes those of all axes side by side.
    pub(super) fn place(self, dimensions: usize, node: usize) -> (usize, usize) {
        match self {
            Self::Grid(_) => {
                let row = self.nodes(dimensions) / self.rows();
                (node / row, node % row)
            }
            Self::Star(rings) => (
                0,
                node.checked_sub(1).map_or(0, |index| {
                    let (axis, position) = (index / (2 * rings), index % (2 * rings));
                    LANES * (1 + position * groups(dimensions)) + lane(dimensions, axis)
                }),
            ),
        }
    }

    /// Number of nodes in `dimensions` dimensions.
    #[must_use]
    pub fn nodes(self, dimensions: usize) -> usize {
        match self {
            Self::Grid(n) => std::iter::repeat_n(n, dimensions).product(),
            Self::Star(rings) => 1 + 2 * rings * dimensions,
        }
    }
}

//! Where the centres of a network are, and where their weights.

use crate::blocks::four::LANES;
use serde::{Deserialize, Serialize};

/// Largest number of nodes along one axis.
pub const MAX_PER_AXIS: usize = 9;

/// Nodes per axis of a posture network by default.
pub(super) const USUAL: usize = 5;

/// Fours in a row of such a grid with three axes: 24 of its 25 nodes. Of the one in the middle, of all rows, there is a [`TAIL`].
pub(super) const USUAL_ROW: usize = (USUAL * USUAL - 1) / LANES;

/// Nodes along an axis of the object's star by default, without the origin.
pub(super) const USUAL_ARM: usize = 4;

/// Fours of such a star with seven axes: the origin, four axes that stay, and the others.
pub(super) const USUAL_STAR: usize = 1 + 2 * USUAL_ARM;

/// Fours behind the rows of such a grid: its nodes in the middle of the second and third axis. There these axes have activations of 1
/// beside what is common to all nodes, so those of the first axis stand for them.
pub(super) const TAIL: usize = USUAL.div_ceil(LANES);

/// Room for the axes of a network, in fours, with one lane to spare.
pub(super) const GROUPS: usize = 2;

/// Axes of the networks with seven inputs by their lanes: first those that stay where only shear rates change, then α̇₁ and the
/// shear rates, so that a step, which sees the shear rates at two points, evaluates the first four only once.
const OBJECT_AXES: [usize; 7] = [0, 1, 3, 4, 2, 5, 6];

/// Fours of the axes of a network. There is a lane to spare, the last one: there is what is common to all nodes.
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

    /// Whether it is a usual star with two fours of axes.
    pub(super) const fn is_usual_star(self, dimensions: usize) -> bool {
        groups(dimensions) == 2 && matches!(self, Self::Star(rings) if 2 * rings == USUAL_ARM)
    }

    /// Whether it is the usual grid, whose nodes have an order of their own.
    pub(super) const fn is_usual(self, dimensions: usize) -> bool {
        dimensions == 3 && matches!(self, Self::Grid(USUAL))
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
            Self::Grid(_) if self.is_usual(dimensions) => USUAL_ROW,
            Self::Grid(_) => (self.nodes(dimensions) / self.rows()).div_ceil(LANES),
            Self::Star(rings) => 1 + 2 * rings * groups(dimensions),
        }
    }

    /// Fours behind the rows.
    pub(super) const fn tail(self, dimensions: usize) -> usize {
        if self.is_usual(dimensions) { TAIL } else { 0 }
    }

    /// Fours of a star's row that stay where only the axes of the last four move.
    pub(super) fn still(self, dimensions: usize) -> usize {
        match self {
            Self::Star(rings) => 1 + 2 * rings * (groups(dimensions) - 1),
            Self::Grid(_) => 0,
        }
    }

    /// Where the weight of a node is: the row, and the lane in it. The row after the last is the tail.
    ///
    /// A row of the usual grid has the nodes beside the middle of the second axis, four of the third axis each, then those in the middle of the
    /// second axis, then those in the middle of the third. Along each axis the middle comes last.
    ///
    /// The row of a star has its origin first, then four axes, position by position along them, then the other axes likewise.
    pub(super) fn place(self, dimensions: usize, node: usize) -> (usize, usize) {
        match self {
            Self::Grid(_) if self.is_usual(dimensions) => {
                const MIDDLE: usize = USUAL - 1;
                let order = |index: usize| [0, 1, MIDDLE, 2, 3][index % USUAL];
                let first = order(node / (USUAL * USUAL));
                match (order(node / USUAL), order(node)) {
                    (MIDDLE, MIDDLE) => (USUAL, first),
                    (second, MIDDLE) => (first, LANES * USUAL + second),
                    (second, third) => (first, LANES * second + third),
                }
            }
            Self::Grid(_) => {
                let row = self.nodes(dimensions) / self.rows();
                (node / row, node % row)
            }
            Self::Star(rings) => (
                0,
                node.checked_sub(1).map_or(0, |index| {
                    let (axis, position) = (index / (2 * rings), index % (2 * rings));
                    let lane = lane(dimensions, axis);
                    LANES * (1 + 2 * rings * (lane / LANES) + position) + lane % LANES
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

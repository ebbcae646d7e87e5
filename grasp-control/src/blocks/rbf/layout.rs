//! Where the centres of a network are, and where their weights.

use super::lanes::{LANES, groups};
use serde::{Deserialize, Serialize};

/// Largest number of nodes along one axis.
pub const MAX_PER_AXIS: usize = 9;

/// Where the centres are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Layout {
    /// Tensor grid with this many nodes per axis, 1 ≤ n ≤ 9; n = 1 is a single node at the origin.
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

    /// Whether the number of nodes per axis is in its range.
    pub(super) const fn is_possible(self) -> bool {
        match self {
            Self::Grid(n) => 1 <= n && n <= MAX_PER_AXIS,
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
                    LANES * (1 + position * groups(dimensions)) + axis
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

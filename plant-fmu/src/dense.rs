//! Small dense matrices and the one kernel everything fast is built on.
//!
//! The kernel multiplies in a fixed order with plain multiplications and additions, never fused ones, so that results do
//! not depend on the vector units of the processor at hand.

use std::ops::{Index, IndexMut};

/// A dense matrix, stored by columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    rows: usize,
    columns: usize,
    data: Vec<f64>,
}

impl Matrix {
    /// A matrix of zeros.
    #[must_use]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, data: vec![0.0; rows * columns] }
    }

    /// A matrix with entries f(row, column).
    pub fn from_fn(rows: usize, columns: usize, f: impl Fn(usize, usize) -> f64) -> Self {
        let data = (0..columns).flat_map(|j| (0..rows).map(move |i| (i, j))).map(|(i, j)| f(i, j)).collect();
        Self { rows, columns, data }
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Column j as a slice.
    ///
    /// # Panics
    /// If j is not below [`columns`](Self::columns).
    #[must_use]
    pub fn column(&self, j: usize) -> &[f64] {
        &self.data[j * self.rows..(j + 1) * self.rows]
    }

    /// All entries, column after column.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.data
    }

    /// The matrix product `self` · `right`.
    ///
    /// # Panics
    /// If the shapes do not match.
    #[must_use]
    pub fn multiply(&self, right: &Self) -> Self {
        assert_eq!(self.columns, right.rows, "shapes do not match");
        let panels = Panels::new(self);
        let mut product = vec![[0.0; LANES]; panels.panel_count()];
        let mut result = Self::zeros(self.rows, right.columns);
        for j in 0..right.columns {
            panels.multiply(right.column(j), &mut product);
            result.data[j * self.rows..(j + 1) * self.rows].copy_from_slice(&product.as_flattened()[..self.rows]);
        }
        result
    }

    /// `self` + `factor` · `other`, in place; both of one shape.
    pub(crate) fn add_scaled(&mut self, factor: f64, other: &Self) {
        for (entry, other) in self.data.iter_mut().zip(&other.data) {
            *entry += factor * other;
        }
    }

    pub(crate) fn scale(&mut self, factor: f64) {
        for entry in &mut self.data {
            *entry *= factor;
        }
    }

    pub(crate) fn transpose(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, j| self[(j, i)])
    }

    /// The largest sum of magnitudes in a column.
    pub(crate) fn one_norm(&self) -> f64 {
        (0..self.columns).map(|j| self.column(j).iter().map(|entry| entry.abs()).sum()).fold(0.0, f64::max)
    }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        debug_assert!(i < self.rows);
        &self.data[j * self.rows + i]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        debug_assert!(i < self.rows);
        &mut self.data[j * self.rows + i]
    }
}

/// Rows handled together by the kernel: 12 sums fill six two-lane registers and hide the latency of an addition.
pub(crate) const LANES: usize = 12;

/// A matrix cut into panels of [`LANES`] rows (the last one padded with zeros), each stored by columns.
#[derive(Clone, Debug)]
pub(crate) struct Panels {
    columns: usize,
    data: Vec<[f64; LANES]>,
}

impl Panels {
    pub fn new(matrix: &Matrix) -> Self {
        let data = (0..matrix.rows.div_ceil(LANES))
            .flat_map(|panel| (0..matrix.columns).map(move |j| (panel * LANES, j)))
            .map(|(first, j)| {
                std::array::from_fn(|lane| if first + lane < matrix.rows { matrix[(first + lane, j)] } else { 0.0 })
            })
            .collect();
        Self { columns: matrix.columns, data }
    }

    pub fn panel_count(&self) -> usize {
        self.data.len().checked_div(self.columns).unwrap_or(0)
    }

    /// `y` = first `x.len()` columns times `x`.
    #[inline]
    pub fn multiply(&self, x: &[f64], y: &mut [[f64; LANES]]) {
        debug_assert!(x.len() <= self.columns && y.len() >= self.panel_count());
        for (panel, y) in self.data.chunks_exact(self.columns.max(1)).zip(y) {
            let mut sums = [0.0; LANES];
            for (column, x) in panel.iter().zip(x) {
                for (sum, entry) in sums.iter_mut().zip(column) {
                    *sum += entry * x;
                }
            }
            *y = sums;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_multiplies_matrices_of_any_shape() {
        for (rows, inner, columns) in [(1, 1, 1), (12, 5, 3), (13, 12, 11), (36, 39, 2), (25, 1, 7)] {
            let left = Matrix::from_fn(rows, inner, |i, j| (i * 7 + j * 3) as f64 - 11.0);
            let right = Matrix::from_fn(inner, columns, |i, j| (i + 5 * j) as f64 - 4.0);
            let product = left.multiply(&right);
            for i in 0..rows {
                for j in 0..columns {
                    let expected: f64 = (0..inner).map(|m| left[(i, m)] * right[(m, j)]).sum();
                    // Small integers: sums are exact.
                    assert_eq!(product[(i, j)].to_bits(), expected.to_bits());
                }
            }
        }
    }
}

//! The kernel on which all fast code is built: matrix times vector.
//!
//! The kernel multiplies in a fixed order with plain multiplications and additions, never fused ones. So results do not
//! depend on the vector units of the processor: the widest available ones are used, and the bits are the same. Matrices are
//! nalgebra's. Products of large ones use the kernel too ([`product`]), because the order of operations in nalgebra's own
//! products depends on its Cargo features.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use nalgebra::DMatrix;

/// Rows handled together by the kernel.
pub(crate) use grasp_kernel::LANES;
#[cfg(target_arch = "x86_64")]
pub(crate) use grasp_kernel::has_wide_registers;

/// A matrix cut into panels of [`LANES`] rows (the last one padded with zeros), each stored by columns.
#[derive(Clone, Debug)]
pub(crate) struct Panels {
    columns: usize,
    data: Vec<[f64; LANES]>,
}

impl Panels {
    pub fn new(matrix: &DMatrix<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        let data = (0..rows.div_ceil(LANES))
            .flat_map(|panel| (0..columns).map(move |j| (panel * LANES, j)))
            .map(|(first, j)| {
                std::array::from_fn(|lane| if first + lane < rows { matrix[(first + lane, j)] } else { 0.0 })
            })
            .collect();
        Self { columns, data }
    }

    pub fn panel_count(&self) -> usize {
        self.data.len().checked_div(self.columns).unwrap_or(0)
    }

    /// Every number, padding included.
    #[cfg(test)]
    pub fn entries(&self) -> impl Iterator<Item = &f64> {
        self.data.as_flattened().iter()
    }

    /// `y` = first `x.len()` columns times `x`.
    #[inline]
    pub fn multiply(&self, x: &[f64], y: &mut [[f64; LANES]]) {
        debug_assert!(x.len() <= self.columns && y.len() >= self.panel_count());
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { grasp_kernel::multiply_wide(&self.data, self.columns, x, y) };
        }
        grasp_kernel::multiply(&self.data, self.columns, x, y);
    }
}

/// Columns of `ROWS` entries times `x`, for matrices of few rows.
#[inline(always)]
pub(crate) fn multiply_columns<const ROWS: usize>(columns: &[[f64; ROWS]], x: &[f64]) -> [f64; ROWS] {
    let mut sums = [0.0; ROWS];
    for (column, x) in columns.iter().zip(x) {
        for (sum, entry) in sums.iter_mut().zip(column) {
            *sum += entry * x;
        }
    }
    sums
}

/// The matrix product `left` · `right`, with the kernel's order of operations.
pub(crate) fn product(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    assert_eq!(left.ncols(), right.nrows(), "shapes do not match");
    let panels = Panels::new(left);
    let mut column = vec![[0.0; LANES]; panels.panel_count()];
    let mut product = DMatrix::zeros(left.nrows(), right.ncols());
    for (mut target, source) in product.column_iter_mut().zip(right.column_iter()) {
        panels.multiply(source.as_slice(), &mut column);
        target.copy_from_slice(&column.as_flattened()[..left.nrows()]);
    }
    product
}

/// The inner product, first entry first.
pub(crate) fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(l, r)| l * r).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_multiplies_matrices_of_any_shape() {
        for (rows, inner, columns) in [(1, 1, 1), (12, 5, 3), (13, 12, 11), (36, 39, 2), (25, 1, 7)] {
            let left = DMatrix::from_fn(rows, inner, |i, j| (i * 7 + j * 3) as f64 - 11.0);
            let right = DMatrix::from_fn(inner, columns, |i, j| (i + 5 * j) as f64 - 4.0);
            let product = product(&left, &right);
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

//! What plant and laws compute fast with: matrix times vector, in a fixed order of plain multiplications and additions, never fused ones, so
//! that the bits do not depend on the registers that the compiler or the caller chooses; and [wide registers](Wide).
//!
//! This is a crate of its own because the FMUs' libraries compile `grasp-plant`, most of which runs once for a set of parameters, for
//! size. That makes this loop five times as slow, and steps of a grasp that can open spend most of their time in it.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

mod registers;

pub use registers::{Lanes, narrowly};
#[cfg(target_arch = "x86_64")]
pub use registers::{Wide, has_wide_registers};

/// Rows handled together: 12 sums fill six two-lane registers and hide the latency of an addition.
pub const LANES: usize = 12;

/// `y` = first `x.len()` columns of a matrix times `x`. The matrix is cut into panels of [`LANES`] rows, as many as `y` has, each
/// stored by its `columns` columns.
pub fn multiply(matrix: &[[f64; LANES]], columns: usize, x: &[f64], y: &mut [[f64; LANES]]) {
    multiply_here::<1>(matrix, columns, x, y);
}

/// The same arithmetic in registers of four lanes: the same bits, because nothing is fused or summed in another order.
/// Sixteen such registers hold the sums of three panels.
///
/// # Safety
/// The processor must have AVX.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx")]
pub fn multiply_wide(matrix: &[[f64; LANES]], columns: usize, x: &[f64], y: &mut [[f64; LANES]]) {
    multiply_here::<3>(matrix, columns, x, y);
}

/// The product, as many panels at a time as `ABREAST`.
#[inline(always)]
fn multiply_here<const ABREAST: usize>(matrix: &[[f64; LANES]], columns: usize, x: &[f64], y: &mut [[f64; LANES]]) {
    let columns = columns.max(1);
    let (mut matrix, mut y) = (matrix, y);
    while matrix.len() >= ABREAST * columns {
        let (panels, matrix_rest) = matrix.split_at(ABREAST * columns);
        let (sums, y_rest) = y.split_at_mut(ABREAST);
        let panels: [&[[f64; LANES]]; ABREAST] = std::array::from_fn(|panel| &panels[panel * columns..][..x.len()]);
        sums.copy_from_slice(&sums_of(panels, x));
        (matrix, y) = (matrix_rest, y_rest);
    }
    for (panel, y) in matrix.chunks_exact(columns).zip(y) {
        [*y] = sums_of([&panel[..x.len()]], x);
    }
}

/// Panels times `x`, each column after column.
#[inline(always)]
fn sums_of<const ABREAST: usize>(panels: [&[[f64; LANES]]; ABREAST], x: &[f64]) -> [[f64; LANES]; ABREAST] {
    let mut sums = [[0.0; LANES]; ABREAST];
    for (j, x) in x.iter().enumerate() {
        for (sums, panel) in sums.iter_mut().zip(panels) {
            for (sum, entry) in sums.iter_mut().zip(&panel[j]) {
                *sum += entry * x;
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Several panels abreast change no bit, whatever the number of panels.
    #[test]
    fn every_kernel_gives_the_same_bits() {
        for (panels, columns) in [(1, 5), (2, 9), (3, 39), (4, 3), (5, 48), (9, 103)] {
            let entry = |i: usize| ((i * 31 + i / 7) as f64).sin();
            let matrix: Vec<[f64; LANES]> =
                (0..panels * columns).map(|j| std::array::from_fn(|lane| entry(j * LANES + lane))).collect();
            let x: Vec<f64> = (0..columns).map(|j| (j as f64).cos()).collect();
            for length in [columns, columns - 1] {
                let [mut chosen, mut three] = [(); 2].map(|()| vec![[f64::NAN; LANES]; panels]);
                multiply(&matrix, columns, &x[..length], &mut chosen);
                multiply_here::<3>(&matrix, columns, &x[..length], &mut three);
                assert_eq!(chosen, three, "{panels} x {length}");
                #[cfg(target_arch = "x86_64")]
                if std::arch::is_x86_feature_detected!("avx") {
                    let mut wide = vec![[f64::NAN; LANES]; panels];
                    // SAFETY: the processor has it.
                    unsafe { multiply_wide(&matrix, columns, &x[..length], &mut wide) };
                    assert_eq!(chosen, wide, "{panels} x {length}");
                }
            }
        }
    }
}

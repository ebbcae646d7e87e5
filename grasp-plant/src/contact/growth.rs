//! How fast the powers of a matrix grow.

use crate::exponential::one_norm;
use crate::kernel::product;
use nalgebra::DMatrix;

/// An α with ‖ℬ^m‖ ≤ α^m for all m ≥ 12, ℬ being the matrix in balanced units: max(‖ℬ⁴‖^¼, ‖ℬ⁵‖^⅕), because every such m is
/// a sum of fours and fives (Al-Mohy and Higham 2009, theorem 4.2). ‖ℬ‖ itself can be much larger: a force that depends on the
/// rate of a force is one large row.
pub(super) fn growth(matrix: &DMatrix<f64>) -> f64 {
    let balanced = balanced(matrix);
    let squared = product(&balanced, &balanced);
    let fourth = product(&squared, &squared);
    let fifth = product(&fourth, &balanced);
    one_norm(&fourth).sqrt().sqrt().max(fifth_root(one_norm(&fifth)))
}

/// D⁻¹ 𝒜 D with powers of two on the diagonal of D, for which rows and columns have about equal sums of magnitudes (Parlett and
/// Reinsch 1969). Exact. States without a row or a column keep their unit.
fn balanced(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let mut matrix = matrix.clone();
    let mut changes = true;
    while changes {
        changes = false;
        for i in 0..matrix.nrows() {
            let own = matrix[(i, i)].abs();
            let sum = |entries: &mut dyn Iterator<Item = &f64>| entries.map(|entry| entry.abs()).sum::<f64>() - own;
            let (mut column, mut row) = (sum(&mut matrix.column(i).iter()), sum(&mut matrix.row(i).iter()));
            if !(column > 0.0 && row > 0.0) {
                continue;
            }
            let (before, mut unit) = (column + row, 1.0);
            while 2.0 * column < row {
                (column, row, unit) = (2.0 * column, 0.5 * row, 2.0 * unit);
            }
            while column > 2.0 * row {
                (column, row, unit) = (0.5 * column, 2.0 * row, 0.5 * unit);
            }
            // Less gain is not worth another round, of which there are few.
            if column + row < 0.95 * before {
                matrix.column_mut(i).scale_mut(unit);
                matrix.row_mut(i).scale_mut(1.0 / unit);
                changes = true;
            }
        }
    }
    matrix
}

/// x^⅕, x ≥ 0, to a few digits and never less: by Newton, the same bits everywhere.
fn fifth_root(x: f64) -> f64 {
    if x == 0.0 {
        return 0.0;
    }
    let mut root = x.sqrt().sqrt().max(1.0);
    for _ in 0..1000 {
        // Newton from above stays above.
        let next = 0.2 * (4.0 * root + x / (root * root * root * root));
        if next >= root * (1.0 - 1e-3) {
            break;
        }
        root = next;
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No eigenvalue is larger than the growth, and hardly any matrix of the plant's kind needs more than half as much again: large
    /// entries that only units make do not count.
    #[test]
    fn units_do_not_matter() {
        let oscillator = |unit: f64| DMatrix::from_row_slice(2, 2, &[0.0, 300.0 * unit, -300.0 / unit, 0.0]);
        for unit in [1e-6, 1.0, 1e3, 1e9] {
            let alpha = growth(&oscillator(unit));
            assert!((300.0..=450.0).contains(&alpha), "{unit}: {alpha}");
        }
        // What has no column adds nothing to high powers.
        let driven = DMatrix::from_row_slice(2, 2, &[-2.0, 1e12, 0.0, 0.0]);
        assert!(growth(&driven) < 1e4, "{}", growth(&driven));
        assert_eq!(growth(&DMatrix::zeros(3, 3)), 0.0);
    }

    #[test]
    fn roots_are_never_less() {
        for x in [1e-300, 1e-9, 0.5, 1.0, 32.0, 1e30, 1e280] {
            let root = fifth_root(x);
            assert!(root.powi(5) >= x * (1.0 - 1e-14) && root.powi(5) <= 1.1 * x.max(1e-10), "{x}: {root}");
        }
    }
}

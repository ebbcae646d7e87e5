//! The invariant planes of any plant: estimated from a Schur form in plain precision, refined by Newton's method.
//!
//! With all bases V, the blocks Λ of the motion in them, and R = A V − V Λ in twice the precision, V ← V (I + X) with
//! Λ_i X_ij − X_ij Λ_j = −(V⁻¹R)_ij off the diagonal and Λ_i ← Λ_i + (V⁻¹R)_ii converges quadratically. It needs only that the
//! motions of different planes differ.

use super::plane::{Plane, Planes, Wide};
use super::twofold::{Long, Twofold, two_sum};
use super::vibration::Vibration;
use crate::kernel::product;
use nalgebra::linalg::{Schur, balancing::balance_parlett_reinsch};
use nalgebra::{DMatrix, Matrix2};

/// Corrections of the bases below this need no further step: the next ones would be far below the rounding unit of plain
/// precision.
const FINE: f64 = 1e-11;

const NEWTON_STEPS: usize = 12;

/// The planes of the vibration; `system` is its matrix in plain precision. `None` if no separate planes are found.
pub(super) fn planes(vibration: &Vibration, system: &DMatrix<f64>) -> Option<Planes> {
    let mut basis = guess(system)?;
    orthonormalise(&mut basis);
    let mut motions = motions(system, &basis);
    let mut inverse = basis.clone().try_inverse()?;
    let mut columns: Vec<Long> = basis.column_iter().map(|column| Long::of(column.as_slice())).collect();
    for _ in 0..NEWTON_STEPS {
        let error = product(&inverse, &residual(vibration, &columns, &motions));
        let blocks: Vec<Matrix2<f64>> = motions.iter().map(|m| Matrix2::from_fn(|i, j| m[i][j].hi)).collect();
        let correction = correction(&error, &blocks)?;
        let size = correction.amax();
        if size.is_nan() || size > 1e3 {
            return None;
        }
        for (j, motion) in motions.iter_mut().enumerate() {
            for (row, entries) in motion.iter_mut().enumerate() {
                for (column, entry) in entries.iter_mut().enumerate() {
                    *entry = *entry + Twofold::from(error[(2 * j + row, 2 * j + column)]);
                }
            }
        }
        let plain = DMatrix::from_fn(basis.nrows(), basis.ncols(), |i, j| columns[j].hi[i]);
        let change = product(&plain, &correction);
        for (column, change) in columns.iter_mut().zip(change.column_iter()) {
            for (i, change) in change.iter().enumerate() {
                let (hi, low) = two_sum(column.hi[i], *change);
                let (hi, lo) = two_sum(hi, column.lo[i] + low);
                (column.hi[i], column.lo[i]) = (hi, lo);
            }
        }
        if size < FINE {
            let mut columns = columns.into_iter();
            let planes = motions
                .into_iter()
                .map(|motion| Some(Plane { basis: [columns.next()?, columns.next()?], motion }))
                .collect::<Option<_>>()?;
            return Some(Planes { planes, inverse });
        }
        inverse -= product(&correction, &inverse);
    }
    None
}

/// A V − V Λ.
fn residual(vibration: &Vibration, columns: &[Long], motions: &[Wide]) -> DMatrix<f64> {
    let mut residual = DMatrix::zeros(columns[0].len(), columns.len());
    for (j, column) in columns.iter().enumerate() {
        let mut rest = vibration.derivative(column);
        let motion = &motions[j / 2];
        for (i, row) in motion.iter().enumerate() {
            rest.add_multiple(-row[j % 2], &columns[j / 2 * 2 + i]);
        }
        residual.column_mut(j).copy_from_slice(&rest.hi);
    }
    residual
}

/// X of all pairs of planes.
fn correction(error: &DMatrix<f64>, blocks: &[Matrix2<f64>]) -> Option<DMatrix<f64>> {
    let mut correction = DMatrix::zeros(error.nrows(), error.ncols());
    for (i, first) in blocks.iter().enumerate() {
        for (j, second) in blocks.iter().enumerate() {
            if i != j {
                let right = -error.fixed_view::<2, 2>(2 * i, 2 * j).into_owned();
                let x = sylvester(first, second, &right)?;
                correction.fixed_view_mut::<2, 2>(2 * i, 2 * j).copy_from(&x);
            }
        }
    }
    Some(correction)
}

/// X of L X − X R = C. With R's adjugate, (L² − tr R L + det R) X = L C − C adj R.
fn sylvester(left: &Matrix2<f64>, right: &Matrix2<f64>, c: &Matrix2<f64>) -> Option<Matrix2<f64>> {
    let adjugate = Matrix2::new(right.m22, -right.m12, -right.m21, right.m11);
    let polynomial = left * left - left * right.trace() + Matrix2::identity() * right.determinant();
    Some(polynomial.try_inverse()? * (left * c - c * adjugate))
}

/// Bases of the invariant planes to some digits, side by side.
fn guess(system: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = system.nrows();
    let mut balanced = system.clone();
    let scale = balance_parlett_reinsch(&mut balanced);
    let (q, t) = Schur::try_new(balanced, f64::EPSILON, 60 * n)?.unpack();
    let (separated, parts) = separated(&t);
    let mut basis = product(&q, &separated);
    for (mut row, scale) in basis.row_iter_mut().zip(&scale) {
        row *= *scale;
    }
    for mut column in basis.column_iter_mut() {
        let norm = column.norm();
        column /= norm;
    }
    // The motions that vibrate are planes, the others are paired, the most alike first.
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    let mut singles: Vec<(f64, usize)> = Vec::new();
    for part in &parts {
        if part.size == 2 {
            pairs.push([part.first, part.first + 1]);
        } else {
            singles.push((t[(part.first, part.first)], part.first));
        }
    }
    singles.sort_by(|l, r| l.0.total_cmp(&r.0));
    while singles.len() > 1 {
        let gap = |i: usize| (singles[i + 1].0 - singles[i].0) / singles[i].0.abs().max(singles[i + 1].0.abs());
        let nearest = (0..singles.len() - 1).min_by(|l, r| gap(*l).total_cmp(&gap(*r)))?;
        let (first, second) = (singles.remove(nearest).1, singles.remove(nearest).1);
        pairs.push([first, second]);
    }
    if !singles.is_empty() {
        return None;
    }
    let columns: Vec<usize> = pairs.iter().flatten().copied().collect();
    let basis = basis.select_columns(&columns);
    Some(basis)
}

/// Makes each plane's basis orthonormal.
fn orthonormalise(basis: &mut DMatrix<f64>) {
    for j in 0..basis.ncols() / 2 {
        let (mut u, mut w) = basis.columns_range_pair_mut(2 * j, 2 * j + 1);
        u /= u.norm();
        let along = u.dot(&w);
        w.axpy(-along, &u, 1.0);
        w /= w.norm();
    }
}

/// The motion in each plane of an orthonormal basis.
fn motions(system: &DMatrix<f64>, basis: &DMatrix<f64>) -> Vec<Wide> {
    let images = product(system, basis);
    let entry = |r: usize, c: usize| Twofold::from(basis.column(r).dot(&images.column(c)));
    (0..basis.ncols() / 2).map(|j| [0, 1].map(|r| [0, 1].map(|c| entry(2 * j + r, 2 * j + c)))).collect()
}

/// A diagonal block of a Schur form.
struct Part {
    first: usize,
    size: usize,
}

/// Y, unit upper triangular by blocks, with T Y = Y diag(T).
fn separated(t: &DMatrix<f64>) -> (DMatrix<f64>, Vec<Part>) {
    let n = t.nrows();
    let mut parts = Vec::new();
    let mut first = 0;
    while first < n {
        let coupled = first + 1 < n
            && t[(first + 1, first)].abs() > f64::EPSILON * (t[(first, first)].abs() + t[(first + 1, first + 1)].abs());
        let size = if coupled { 2 } else { 1 };
        parts.push(Part { first, size });
        first += size;
    }
    let smallest = f64::EPSILON * t.amax();
    let mut y = DMatrix::identity(n, n);
    for (j, right) in parts.iter().enumerate() {
        for left in parts[..j].iter().rev() {
            // T_ii Y_ij − Y_ij T_jj = −Σ T_il Y_lj over the parts between.
            let begin = left.first + left.size;
            let width = right.first + right.size - begin;
            let known = product(
                &t.view((left.first, begin), (left.size, width)).into_owned(),
                &y.view((begin, right.first), (width, right.size)).into_owned(),
            );
            let x = small_sylvester(t, left, right, &-known, smallest);
            y.view_mut((left.first, right.first), (left.size, right.size)).copy_from(&x);
        }
    }
    (y, parts)
}

/// X of T_ii X − X T_jj = C for blocks of one or two; a divisor that is (nearly) zero is replaced by `smallest`.
fn small_sylvester(t: &DMatrix<f64>, left: &Part, right: &Part, c: &DMatrix<f64>, smallest: f64) -> DMatrix<f64> {
    let (rows, columns) = (left.size, right.size);
    let unknowns = rows * columns;
    // Unknown (r, s) is number r + rows·s.
    let mut system = DMatrix::zeros(unknowns, unknowns + 1);
    for s in 0..columns {
        for r in 0..rows {
            let equation = r + rows * s;
            for m in 0..rows {
                system[(equation, m + rows * s)] += t[(left.first + r, left.first + m)];
            }
            for m in 0..columns {
                system[(equation, r + rows * m)] -= t[(right.first + m, right.first + s)];
            }
            system[(equation, unknowns)] = c[(r, s)];
        }
    }
    for pivot in 0..unknowns {
        let best = (pivot..unknowns)
            .max_by(|l, r| system[(*l, pivot)].abs().total_cmp(&system[(*r, pivot)].abs()))
            .unwrap_or(pivot);
        system.swap_rows(pivot, best);
        if system[(pivot, pivot)].abs() < smallest {
            system[(pivot, pivot)] = smallest;
        }
        for row in pivot + 1..unknowns {
            let factor = system[(row, pivot)] / system[(pivot, pivot)];
            for column in pivot..=unknowns {
                let amount = factor * system[(pivot, column)];
                system[(row, column)] -= amount;
            }
        }
    }
    let mut x = DMatrix::zeros(rows, columns);
    for unknown in (0..unknowns).rev() {
        let known: f64 = (unknown + 1..unknowns).map(|m| system[(unknown, m)] * x[(m % rows, m / rows)]).sum();
        x[(unknown % rows, unknown / rows)] = (system[(unknown, unknowns)] - known) / system[(unknown, unknown)];
    }
    x
}

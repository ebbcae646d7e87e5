//! Four numbers at a time, in a fixed order of operations.

/// Numbers that are computed with at once: a register where the processor has one of that width.
pub(super) const LANES: usize = 4;

/// Four numbers side by side.
pub(super) type Lanes = [f64; LANES];

/// Room for the axes of a network, in fours, with one lane to spare.
pub(super) const MAX_GROUPS: usize = 2;

/// Fours of the axes of a network, with one lane to spare: there is the common factor of a star.
pub(super) const fn groups(dimensions: usize) -> usize {
    (dimensions + 1).div_ceil(LANES)
}

/// w ← decay·w + weight·y; returns [`products`] of the new w with y.
#[inline(always)]
pub(super) fn adapt_row(w: &mut [Lanes], y: &[Lanes], decay: f64, weight: f64) -> Lanes {
    let mut sums = [0.0; LANES];
    for (w, y) in w.iter_mut().zip(y) {
        // All lanes before the store, or the compiler leaves them one by one; and no closure, which would not be compiled
        // for the wide registers of a caller.
        let mut new = [0.0; LANES];
        for lane in 0..LANES {
            new[lane] = decay * w[lane] + weight * y[lane];
        }
        *w = new;
        for lane in 0..LANES {
            sums[lane] += new[lane] * y[lane];
        }
    }
    sums
}

/// The inner product of two lists, in four sums.
#[inline(always)]
pub(super) fn products(a: &[Lanes], b: &[Lanes]) -> Lanes {
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums
}

/// sums ← sums + `factor` row.
#[inline(always)]
pub(super) fn add_scaled(sums: &mut Lanes, factor: f64, row: Lanes) {
    for lane in 0..LANES {
        sums[lane] += factor * row[lane];
    }
}

/// What the four sums add up to.
pub(super) fn total(sums: Lanes) -> f64 {
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

//! Sums over the lanes of weights and activations, in a fixed order of operations.

use crate::blocks::four::{Four, Lanes, Narrow};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};

/// The inner product of two lists, in four sums.
pub(super) fn products(a: &[Lanes], b: &[Lanes]) -> Lanes {
    #[cfg(target_arch = "x86_64")]
    if has_wide_registers() {
        // SAFETY: the processor has it.
        return unsafe { products_wide(a, b) };
    }
    products_here::<Narrow>(a, b).lanes()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn products_wide(a: &[Lanes], b: &[Lanes]) -> Lanes {
    products_here::<Wide>(a, b).lanes()
}

#[inline(always)]
pub(super) fn products_here<V: Four>(a: &[Lanes], b: &[Lanes]) -> V {
    let mut pairs = a.iter().zip(b);
    // The first product as it is, for each sum waits for the one before.
    let mut sums = pairs.next().map_or_else(|| V::splat(0.0), |(a, b)| V::load(a) * V::load(b));
    for (a, b) in pairs {
        sums = sums + V::load(a) * V::load(b);
    }
    sums
}

/// w ← decay·w + weight·y; returns [`products`] of the new w with y.
#[inline(always)]
pub(super) fn adapt_row<V: Four>(w: &mut [Lanes], y: &[Lanes], decay: V, weight: V) -> V {
    let mut sums = V::splat(0.0);
    for (i, (w, y)) in w.iter_mut().zip(y).enumerate() {
        let y = V::load(y);
        let new = decay * V::load(w) + weight * y;
        *w = new.lanes();
        sums = if i == 0 { new * y } else { sums + new * y };
    }
    sums
}

/// What the four sums add up to.
pub(super) fn total(sums: Lanes) -> f64 {
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

//! How the weights learn over a step: Ŵ ← decay·Ŵ + weight·Y, with the output that they then have.

use super::Network;
use super::activations::Activations;
use super::lanes::adapt_row;
use super::layout::{Layout, USUAL_ARM, USUAL_ROW, USUAL_STAR, groups};
use crate::blocks::four::{Four, Lanes, Narrow};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};

impl<const D: usize> Network<D> {
    /// Ŵ ← decay·Ŵ + weight·Y, with the Y of the last activation.
    pub fn adapt(&mut self, decay: f64, weight: f64) {
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.adapt_wide(decay, weight) };
        }
        self.adapt_narrow(decay, weight);
    }

    /// As [`adapt`](Self::adapt), for a caller that knows the registers.
    #[inline(always)]
    pub(crate) fn adapt_here<V: Four>(&mut self, decay: f64, weight: f64) {
        #[cfg(target_arch = "x86_64")]
        if V::IS_WIDE {
            // SAFETY: a wide register is in use.
            return unsafe { self.adapt_wide(decay, weight) };
        }
        self.adapt_narrow(decay, weight);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn adapt_wide(&mut self, decay: f64, weight: f64) {
        self.adapt_in::<Wide>(decay, weight);
    }

    #[inline(never)]
    fn adapt_narrow(&mut self, decay: f64, weight: f64) {
        self.adapt_in::<Narrow>(decay, weight);
    }

    #[inline(always)]
    pub(super) fn adapt_in<V: Four>(&mut self, decay: f64, weight: f64) {
        let Self { weights, at, layout, .. } = self;
        let at = at.get_or_insert_with(|| Activations::nowhere(*layout, D));
        // What `output` would find, to the bit: the same operations in the same order.
        let decay = V::splat(decay);
        if matches!(layout, Layout::Star(_)) {
            let common = at.outer[0][0];
            let still = layout.still(D).min(weights.len());
            let (w, y) = (weights.split_at_mut(still), at.inner.split_at(still));
            let weight = V::splat(weight * common);
            let of_still = adapt_row(w.0, y.0, decay, weight);
            let of_moving = adapt_row(w.1, y.1, decay, weight);
            at.kept = Some(of_still.lanes());
            at.output = Some((V::splat(common) * (of_still + of_moving)).lanes());
            return;
        }
        // There are no grids with more axes.
        if groups(D) > 1 {
            return;
        }
        let (inner, outer) = (at.inner.as_slice(), at.outer.as_flattened());
        let rows = weights.len() - layout.tail(D);
        let (rows, tail) = weights.split_at_mut(rows);
        let mut sums = adapt_row(tail, &at.outer, decay, V::splat(weight));
        if let (true, Ok(inner)) = (V::IS_WIDE, <&[Lanes; USUAL_ROW]>::try_from(inner)) {
            // The row length by default: the activations stay in registers.
            let mut activations = [V::splat(0.0); USUAL_ROW];
            for i in 0..USUAL_ROW {
                activations[i] = V::load(&inner[i]);
            }
            for (row, factor) in rows.as_chunks_mut::<USUAL_ROW>().0.iter_mut().zip(outer) {
                let by = V::splat(weight * factor);
                let mut of_row = V::splat(0.0);
                for i in 0..USUAL_ROW {
                    let new = decay * V::load(&row[i]) + by * activations[i];
                    row[i] = new.lanes();
                    of_row = if i == 0 { new * activations[i] } else { of_row + new * activations[i] };
                }
                sums = sums + V::splat(*factor) * of_row;
            }
        } else {
            for (row, factor) in rows.chunks_exact_mut(inner.len()).zip(outer) {
                sums = sums + V::splat(*factor) * adapt_row(row, inner, decay, V::splat(weight * factor));
            }
        }
        at.output = Some(sums.lanes());
    }

    /// Ŵ ← decay·Ŵ + first·Y' + second·Y of a plain star, with the Y of the last activation and the Y' of the one before, both of
    /// [`fill_plain_both`](Self::fill_plain_both).
    #[inline(always)]
    pub(crate) fn adapt_twice<V: Four>(&mut self, decay: f64, shares: [f64; 2]) {
        if V::IS_WIDE { self.adapt_twice_in::<V>(decay, shares) } else { self.adapt_twice_narrow(decay, shares) }
    }

    #[inline(never)]
    fn adapt_twice_narrow(&mut self, decay: f64, shares: [f64; 2]) {
        self.adapt_twice_in::<Narrow>(decay, shares);
    }

    #[inline(always)]
    fn adapt_twice_in<V: Four>(&mut self, decay: f64, [first, second]: [f64; 2]) {
        const STILL: usize = USUAL_STAR - USUAL_ARM;
        let Some(at) = &mut self.at else { return };
        let (first, second) = (first * at.before_common, second * at.outer[0][0]);
        let (Some(w), Some(y)) = (self.weights.first_chunk_mut::<USUAL_STAR>(), at.inner.first_chunk::<USUAL_STAR>())
        else {
            return;
        };
        let decay = V::splat(decay);
        // Along the axes that stay, both differ in the common factor only.
        at.kept = Some(adapt_row(&mut w[..STILL], &y[..STILL], decay, V::splat(first + second)).lanes());
        let (first, second) = (V::splat(first), V::splat(second));
        for i in 0..USUAL_ARM {
            let learnt = first * V::load(&at.before[i]) + second * V::load(&y[STILL + i]);
            w[STILL + i] = (decay * V::load(&w[STILL + i]) + learnt).lanes();
        }
        at.output = None;
    }
}

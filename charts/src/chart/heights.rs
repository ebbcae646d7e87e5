//! Heights of points, and how far they go up and down.

use std::ops::Range;

/// Heights, and the extremes of each block of them: who asks for those of thousands need not look at all.
#[derive(Debug)]
pub(super) struct Heights {
    pub(super) values: Vec<f32>,
    blocks: Vec<(f32, f32)>,
}

/// So many are a block.
const BLOCK: usize = 128;

impl Heights {
    pub(super) fn new(values: Vec<f32>) -> Self {
        Self { blocks: values.chunks_exact(BLOCK).filter_map(extremes_of).collect(), values }
    }

    /// The smallest and the largest height of a part; they are no numbers if some height is none, and nothing without heights.
    pub(super) fn extremes(&self, part: Range<usize>) -> Option<(f32, f32)> {
        let (first, after) = (part.start.div_ceil(BLOCK), part.end / BLOCK);
        if first >= after {
            return extremes_of(&self.values[part]);
        }
        let ends = [part.start..first * BLOCK, after * BLOCK..part.end];
        let ends = ends.into_iter().filter_map(|end| extremes_of(&self.values[end]));
        let all = self.blocks[first..after].iter().copied().chain(ends);
        let (low, high, odd) = all
            .fold((f32::INFINITY, f32::NEG_INFINITY, 0.0), |(lowest, highest, odd), (low, high)| {
                (lower(lowest, low), higher(highest, high), odd + low * 0.0)
            });
        Some((low + odd, high + odd))
    }
}

/// The smallest and the largest value; they are no numbers if some value is none, and nothing without values.
fn extremes_of(values: &[f32]) -> Option<(f32, f32)> {
    // Side by side, so that one comparison needs not wait for the one before; in loops of their own, as the compiler needs them.
    const LANES: usize = 4;
    let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    // Zero, but for what is no number or infinite.
    let mut odd = [0.0; LANES];
    let (groups, rest) = values.as_chunks::<LANES>();
    for group in groups {
        for (low, y) in low.iter_mut().zip(group) {
            *low = lower(*low, *y);
        }
        for (high, y) in high.iter_mut().zip(group) {
            *high = higher(*high, *y);
        }
        for (odd, y) in odd.iter_mut().zip(group) {
            *odd += y * 0.0;
        }
    }
    let odd: f32 = odd.into_iter().chain(rest.iter().map(|y| y * 0.0)).sum();
    let low = low.into_iter().chain(rest.iter().copied()).fold(f32::INFINITY, lower);
    let high = high.into_iter().chain(rest.iter().copied()).fold(f32::NEG_INFINITY, higher);
    (!values.is_empty()).then_some((low + odd, high + odd))
}

/// One instruction, which f32's own functions are not: they care for what is no number.
fn lower(one: f32, other: f32) -> f32 {
    if other < one { other } else { one }
}

fn higher(one: f32, other: f32) -> f32 {
    if other > one { other } else { one }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_of_parts_are_those_of_their_heights() {
        let mut values: Vec<f32> = (0..1000_u16).map(|index| f32::from(index * 37 % 1009)).collect();
        for odd in [None, Some(f32::NAN), Some(f32::INFINITY), Some(f32::NEG_INFINITY)] {
            values[500] = odd.unwrap_or(5.0);
            let heights = Heights::new(values.clone());
            for (from, to) in
                [(0, 1000), (0, 0), (3, 5), (1, 127), (0, 128), (127, 129), (100, 400), (100, 999), (256, 512)]
            {
                let part = &values[from..to];
                let bounds =
                    (part.iter().copied().fold(f32::INFINITY, f32::min), part.iter().copied().fold(0.0, f32::max));
                match heights.extremes(from..to) {
                    None => assert!(part.is_empty()),
                    Some(found) if part.iter().all(|value| value.is_finite()) => assert_eq!(found, bounds),
                    Some((low, high)) => assert!(low.is_nan() && high.is_nan(), "{odd:?} {from} {to}"),
                }
            }
        }
    }
}

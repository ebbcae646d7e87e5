//! Four numbers side by side: in one wide register, or one by one if the processor has none.
//!
//! Both ways do the same operations, none fused, so both give the same bits. Loops are written once, for any [`Four`].

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::step::NEGLIGIBLE;
use super::table::Lanes;
use crate::actuator::limited;

/// Dead zones, in lanes: their upper ends, which are not negative, and the slope beyond; their lower ends, not positive, and the slope below.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DeadZones {
    pub upper: (Lanes, Lanes),
    pub lower: (Lanes, Lanes),
}

pub(crate) trait Four: Copy {
    fn splat(value: f64) -> Self;
    fn load(lanes: &Lanes) -> Self;
    fn lanes(self) -> Lanes;
    fn plus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    /// One of the lanes in all of them.
    fn spread<const LANE: usize>(self) -> Self;
    /// The same but for the last lane, which is that of the other.
    fn with_last_of(self, other: Self) -> Self;
    /// The last two lanes of both.
    fn last_twos(self, other: Self) -> Self;
    /// The first and third lanes of both in turns, and the second and last ones.
    fn in_turns(self, other: Self) -> (Self, Self);
    /// Of (a, b, c, d): (a + c, a − c, b, d), where two arms do a alike, and c against each other.
    fn apart(self) -> Self;
    /// Zero where it is [`NEGLIGIBLE`].
    fn kept(self) -> Self;
    /// As [`limited`](crate::actuator::limited).
    fn limited(self, low: Self, high: Self) -> Self;
    /// Behind dead zones: beyond the upper ends per the first slope, below the lower ends per the second.
    fn behind_dead_zones(self, zones: &DeadZones) -> Self;
    /// Whether any is at or beyond its limits.
    fn is_any_limited(self, low: Self, high: Self) -> bool;
    /// Whether in each lane the sum of both sizes is below; NaN is not.
    fn are_sizes_below(self, other: Self, limit: f64) -> bool;
    /// Whether these are all zeros, of either sign.
    fn are_zeros(numbers: &[f64; 6]) -> bool;
    /// Whether the sum of the lanes plus the addend is negative, of any of both.
    fn is_any_sum_negative(both: [Self; 2], addends: [f64; 2]) -> bool;
    /// The bits that both have, by lane.
    fn common(self, other: Self) -> Self;
    /// Whether all lanes have this bit.
    fn have_all(self, bit: u64) -> bool;
    /// The sum of the lanes of each.
    fn sums(of: [Self; 4]) -> Self;
    /// Whether the sums of all rows fit into the registers.
    const HOLDS_ALL_ROWS: bool;
}

impl Four for Lanes {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        [value; 4]
    }

    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        *lanes
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        self
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        [self[0] + other[0], self[1] + other[1], self[2] + other[2], self[3] + other[3]]
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        [self[0] * other[0], self[1] * other[1], self[2] * other[2], self[3] * other[3]]
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        [self[0] - other[0], self[1] - other[1], self[2] - other[2], self[3] - other[3]]
    }

    #[inline(always)]
    fn spread<const LANE: usize>(self) -> Self {
        [self[LANE]; 4]
    }

    #[inline(always)]
    fn with_last_of(self, other: Self) -> Self {
        [self[0], self[1], self[2], other[3]]
    }

    #[inline(always)]
    fn last_twos(self, other: Self) -> Self {
        [self[2], self[3], other[2], other[3]]
    }

    #[inline(always)]
    fn in_turns(self, other: Self) -> (Self, Self) {
        ([self[0], other[0], self[2], other[2]], [self[1], other[1], self[3], other[3]])
    }

    #[inline(always)]
    fn apart(self) -> Self {
        let [a, b, c, d] = self;
        // As in wide registers, signs of zeros included.
        [a + c, a - c, b + c * 0.0, d + c * 0.0]
    }

    #[inline(always)]
    fn limited(self, low: Self, high: Self) -> Self {
        std::array::from_fn(|lane| limited(self[lane], low[lane], high[lane]))
    }

    #[inline(always)]
    fn behind_dead_zones(self, zones: &DeadZones) -> Self {
        let ((right, right_slope), (left, left_slope)) = (&zones.upper, &zones.lower);
        std::array::from_fn(|lane| {
            let x = self[lane];
            if x > right[lane] {
                right_slope[lane] * (x - right[lane])
            } else if x < left[lane] {
                left_slope[lane] * (x - left[lane])
            } else {
                0.0
            }
        })
    }

    #[inline(always)]
    #[allow(clippy::needless_bitwise_bool)] // A branch for each would take longer.
    fn is_any_limited(self, low: Self, high: Self) -> bool {
        (0..4).fold(false, |any, lane| any | (self[lane] <= low[lane]) | (self[lane] >= high[lane]))
    }

    #[inline(always)]
    #[allow(clippy::needless_bitwise_bool)] // As above.
    fn are_sizes_below(self, other: Self, limit: f64) -> bool {
        (0..4).fold(true, |all, lane| all & (self[lane].abs() + other[lane].abs() < limit))
    }

    #[inline(always)]
    fn are_zeros(numbers: &[f64; 6]) -> bool {
        // Without the signs: a negative zero is one.
        numbers.iter().fold(0, |bits, number| bits | number.to_bits()) << 1 == 0
    }

    #[inline(always)]
    fn is_any_sum_negative(both: [Self; 2], addends: [f64; 2]) -> bool {
        let negative = |i: usize| super::step::sum(both[i]) + addends[i] < 0.0;
        negative(0) | negative(1)
    }

    #[inline(always)]
    fn kept(mut self) -> Self {
        for x in &mut self {
            if x.abs() < NEGLIGIBLE {
                *x = 0.0;
            }
        }
        self
    }

    #[inline(always)]
    fn common(self, other: Self) -> Self {
        std::array::from_fn(|lane| f64::from_bits(self[lane].to_bits() & other[lane].to_bits()))
    }

    #[inline(always)]
    fn have_all(self, bit: u64) -> bool {
        self.iter().fold(bit, |bits, number| bits & number.to_bits()) != 0
    }

    #[inline(always)]
    fn sums(of: [Self; 4]) -> Self {
        of.map(|lanes| (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]))
    }

    const HOLDS_ALL_ROWS: bool = false;
}

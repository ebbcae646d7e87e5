//! Four numbers one by one, for any processor.

use super::{Add, Div, Four, LANES, Lanes, Mul, Number, Sub};

/// Four numbers one by one.
#[derive(Clone, Copy)]
pub(crate) struct Portable(Lanes);

/// Operators of [`Portable`], lane by lane.
macro_rules! lane_by_lane {
    ($($operator:ident $name:ident),*) => {$(
        impl $operator for Portable {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let (a, b) = (self.0, other.0);
                Self([a[0].$name(b[0]), a[1].$name(b[1]), a[2].$name(b[2]), a[3].$name(b[3])])
            }
        }
    )*};
}

lane_by_lane!(Add add, Sub sub, Mul mul, Div div);

impl Number for Portable {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn constant(lanes: &Lanes) -> Self {
        Self(*lanes)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane].copysign(other.0[lane])))
    }

    #[inline(always)]
    fn within(self, limit: f64) -> Self {
        Self(self.0.map(|x| x.within(limit)))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane].larger(other.0[lane])))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane].smaller(other.0[lane])))
    }

    #[inline(always)]
    fn where_larger(self, other: Self, then: Self, or: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane].where_larger(other.0[lane], then.0[lane], or.0[lane])))
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self(self.0.map(f64::power_of_two))
    }
}

impl Four for Portable {
    const IS_WIDE: bool = false;

    #[inline(always)]
    fn load(lanes: &Lanes) -> Self {
        Self(*lanes)
    }

    #[inline(always)]
    fn pairs([a, b]: [f64; 2], [c, d]: [f64; 2]) -> Self {
        Self([a, b, c, d])
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        self.0
    }

    #[inline(always)]
    fn above(self, least: f64) -> Self {
        Self(self.0.map(|x| if x > least { x } else { 0.0 }))
    }

    #[inline(always)]
    fn powers_of_two(self) -> [Self; 2] {
        let exponents = self.0.map(|x| x.to_bits() << 52);
        let one = 1.0_f64.to_bits();
        [
            Self(exponents.map(|exponent| f64::from_bits(one.wrapping_add(exponent)))),
            Self(exponents.map(|exponent| f64::from_bits(one.wrapping_sub(exponent)))),
        ]
    }

    #[inline(always)]
    fn last(self) -> f64 {
        self.0[LANES - 1]
    }

    #[inline(always)]
    fn with_last(self, value: f64) -> Self {
        let [a, b, c, _] = self.0;
        Self([a, b, c, value])
    }

    #[inline(always)]
    fn whole(self) -> Self {
        self
    }

    #[inline(always)]
    fn now(self) -> Self {
        self
    }

    #[inline(always)]
    fn columns(rows: [Self; LANES]) -> [Self; LANES] {
        std::array::from_fn(|lane| Self(rows.map(|row| row.0[lane])))
    }
}

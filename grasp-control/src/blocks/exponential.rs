//! e^x and its kin with errors of one to three units in the last place, the same bits on every machine.
//!
//! The system's mathematics library chooses among several implementations by the processor at hand, which differ in the
//! last bit, and evaluates one number at a time. Here are plain multiplications and additions without branches, so that
//! the compiler evaluates several numbers at once.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::four::{Four, LANES, Lanes, Narrow, Number};

/// Beyond ±this, results are those of the limits. e^708 is within the range of normal numbers.
const LIMIT: f64 = 708.0;

/// The numbers that an exponential takes, each in four lanes, so that an instruction takes them from memory as they are. As
/// constants each would be an instruction of its own, once for every exponential: there are more of them than registers.
#[repr(align(32))]
struct Constants {
    log2_e: Lanes,
    /// Adding and subtracting it rounds to an integer, whose bits are then the lowest ones of the sum.
    round: Lanes,
    /// ln 2 in two parts; products of the first with an exponent are exact.
    ln_2: [Lanes; 2],
    /// 1/(j+2)!, j = 0 … 11.
    series: [Lanes; 12],
}

const fn four(value: f64) -> Lanes {
    [value; LANES]
}

static CONSTANTS: Constants = Constants {
    log2_e: four(std::f64::consts::LOG2_E),
    round: four(1.5 * (1_u64 << 52) as f64),
    ln_2: [four(6.931_471_803_691_238e-1), four(1.908_214_929_270_587_7e-10)],
    series: [
        four(1.0 / 2.0),
        four(1.0 / 6.0),
        four(1.0 / 24.0),
        four(1.0 / 120.0),
        four(1.0 / 720.0),
        four(1.0 / 5_040.0),
        four(1.0 / 40_320.0),
        four(1.0 / 362_880.0),
        four(1.0 / 3_628_800.0),
        four(1.0 / 39_916_800.0),
        four(1.0 / 479_001_600.0),
        four(1.0 / 6_227_020_800.0),
    ],
};

/// As [`Constants`], for powers of two.
#[repr(align(32))]
struct Base2 {
    round: Lanes,
    one: Lanes,
    /// (2^r + 2^−r)/2 − 1, divided by r², by powers of r².
    even: [Lanes; 5],
    /// (2^r − 2^−r)/2r by powers of r².
    odd: [Lanes; 6],
}

/// Interpolated at Chebyshev's nodes of 0 ≤ r² ≤ ¼, the first ones as they are: in exact arithmetic the error of 2^r is below 8·10⁻¹⁷ and that of
/// 2^−r, 0 ≤ r ≤ ½, below 6·10⁻¹⁷, a third and a half of a unit in the last place.
static BASE_2: Base2 = Base2 {
    round: CONSTANTS.round,
    one: four(1.0),
    even: [
        four(0.240_226_506_959_100_75),
        four(9.618_129_107_618_665e-3),
        four(1.540_353_042_447_765_3e-4),
        four(1.321_545_163_322_143_4e-6),
        four(7.070_977_866_508_138e-9),
    ],
    odd: [
        four(std::f64::consts::LN_2),
        four(5.550_410_866_482_158e-2),
        four(1.333_355_814_642_321_3e-3),
        four(1.525_273_382_079_580_3e-5),
        four(1.017_806_726_744_942_7e-7),
        four(4.454_103_410_587_04e-10),
    ],
};

/// Numbers from a place that the compiler does not see, each time another one for all it knows: or it would take them from memory
/// once for all exponentials, and then has to put them somewhere.
#[cfg(target_arch = "x86_64")]
// What is pointed to is not touched.
#[allow(clippy::pointers_in_nomem_asm_block)]
#[inline(always)]
fn hidden<T>(numbers: &'static T) -> &'static T {
    let mut place: *const T = numbers;
    // SAFETY: no instruction at all; the pointer stays what it is. Unlike `black_box`, memory stays what it is, too, and the compiler
    // may take numbers from there whenever it needs them.
    unsafe {
        std::arch::asm!("/* {0} */", inout(reg) place, options(nomem, nostack, preserves_flags));
        &*place
    }
}

/// As above.
#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
fn hidden<T>(numbers: &'static T) -> &'static T {
    std::hint::black_box(numbers)
}

/// (2^k, e^r − 1) with x = k ln 2 + r and |r| ≤ ½ ln 2.
#[inline(always)]
fn parts<V: Number>(x: V) -> (V, V) {
    let Constants { log2_e, round, ln_2, series } = hidden(&CONSTANTS);
    let c = |j: usize| V::constant(&series[j]);
    let x = x.within(LIMIT);
    let shifted = x * V::constant(log2_e) + V::constant(round);
    let k = shifted - V::constant(round);
    let r = (x - k * V::constant(&ln_2[0])) - k * V::constant(&ln_2[1]);
    // Σ r^j/(j+2)!, j = 0 … 11: the remainder r¹⁴/14! is below 5·10⁻¹⁸. By Estrin's scheme, whose chains are short.
    let r2 = r * r;
    let r4 = r2 * r2;
    let even = (c(0) + r2 * c(2)) + r4 * ((c(4) + r2 * c(6)) + r4 * (c(8) + r2 * c(10)));
    let odd = (c(1) + r2 * c(3)) + r4 * ((c(5) + r2 * c(7)) + r4 * (c(9) + r2 * c(11)));
    (shifted.power_of_two(), r + r2 * (even + r * odd))
}

/// e^x of one number or of several, for |x| ≤ 708; its value there for larger ones.
#[inline(always)]
pub(crate) fn exp_of<V: Number>(x: V) -> V {
    let (power, rest) = parts(x);
    power + power * rest
}

#[inline(always)]
fn exp_m1_of<V: Number>(x: V) -> V {
    let (power, rest) = parts(x);
    (power - V::splat(1.0)) + power * rest
}

/// The largest exponent of [`powers`]: 2^1020 and 2^−1020 are normal numbers.
pub(crate) const LARGEST: f64 = 1020.0;

/// 2^x and 2^−x for |x| ≤ [`LARGEST`], with errors below two units in the last place: 0.45 of the polynomials, the rest of rounding.
///
/// With x = k + r and |r| ≤ ½, 2^r − 1 is the sum of an even and an odd polynomial, and 2^−r − 1 their difference.
#[inline(always)]
fn powers_of<V: Four>(x: V) -> [V; 2] {
    let Base2 { round, one, even, odd } = hidden(&BASE_2);
    let (e, o) = (|j: usize| V::constant(&even[j]), |j: usize| V::constant(&odd[j]));
    let shifted = x + V::constant(round);
    let r = x - (shifted - V::constant(round));
    let r2 = r * r;
    let r4 = r2 * r2;
    let even = r2 * ((e(0) + r2 * e(1)) + r4 * ((e(2) + r2 * e(3)) + r4 * e(4)));
    let odd = r * ((o(0) + r2 * o(1)) + r4 * ((o(2) + r2 * o(3)) + r4 * (o(4) + r2 * o(5))));
    let [up, down] = shifted.powers_of_two();
    let one = V::constant(one);
    // Else the compiler puts them aside half done, for where they are needed.
    [((one + (even + odd)) * up).now(), ((one + (even - odd)) * down).now()]
}

/// 2^x and 2^−x of several fours, for |x| ≤ [`LARGEST`].
#[inline(always)]
pub(crate) fn powers<V: Four, const N: usize>(x: [V; N]) -> [[V; 2]; N] {
    let mut all = [[V::splat(0.0); 2]; N];
    // Independent of each other, so the processor works on several at a time. No closure: it would not see the wide registers.
    if V::IS_WIDE {
        for (result, x) in all.iter_mut().zip(x) {
            *result = powers_of(x);
        }
        return all;
    }
    let mut lanes = [[[0.0; LANES]; 2]; N];
    for (lanes, x) in lanes.iter_mut().zip(x) {
        lanes[0] = x.lanes();
    }
    powers_of_each(&mut lanes);
    for (result, lanes) in all.iter_mut().zip(&lanes) {
        *result = [V::load(&lanes[0]), V::load(&lanes[1])];
    }
    all
}

/// As [`powers`], code that is there once: two registers for each four leave none for a second four.
#[inline(never)]
fn powers_of_each(all: &mut [[Lanes; 2]]) {
    for lanes in all {
        let [up, down] = powers_of(Narrow::load(&lanes[0]));
        *lanes = [up.lanes(), down.lanes()];
    }
}

/// tanh x of one number or of several, with an error of up to three units in the last place.
#[inline(always)]
pub(crate) fn tanh_of<V: Number>(x: V) -> V {
    // (1 − e^{−2|x|})/(1 + e^{−2|x|}): nothing cancels, and nothing overflows. The result's sign is set, whatever the fraction's.
    let rest = exp_m1_of(V::splat(-2.0) * x.abs());
    (rest / (V::splat(2.0) + rest)).with_sign_of(x)
}

/// e^x for |x| ≤ 708; its value there for larger ones.
#[must_use]
#[inline(never)]
pub fn exp(x: f64) -> f64 {
    exp_of(x)
}

/// e^x − 1.
#[must_use]
#[inline(never)]
pub fn exp_m1(x: f64) -> f64 {
    exp_m1_of(x)
}

/// tanh x, with an error of up to three units in the last place.
#[must_use]
#[inline(never)]
pub fn tanh(x: f64) -> f64 {
    tanh_of(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::four::Portable;
    #[cfg(target_arch = "x86_64")]
    use crate::blocks::four::{Wide, has_wide_registers};
    use proptest::prelude::*;

    /// Distance in units in the last place of the expected value.
    fn ulps(found: f64, expected: f64) -> f64 {
        let ulp = f64::from_bits(expected.abs().to_bits() + 1) - expected.abs();
        ((found - expected) / ulp).abs()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// The reference is the system's library, itself within one unit; so neighbours count as equal.
        #[test]
        fn agrees_with_the_system(x in -700.0..700.0, small in -1.0..1.0, tiny in -1e-6..1e-6) {
            for x in [x, small, tiny] {
                prop_assert!(ulps(exp(x), x.exp()) <= 1.0, "exp {x:e}");
                prop_assert!(ulps(exp_m1(x), x.exp_m1()) <= 2.0, "exp_m1 {x:e}");
                prop_assert!(ulps(tanh(x), x.tanh()) <= 4.0, "tanh {x:e}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// x ln 2 is rounded for the reference, which costs it up to half a unit for each unit of x ln 2.
        #[test]
        fn powers_agree_with_the_system(x in -LARGEST..LARGEST, small in -2.0..2.0, whole in -1020..=1020_i32) {
            let [[up, down]] = powers([Narrow::load(&[x, small, f64::from(whole), LARGEST])]);
            for (lane, exponent) in [x, small].into_iter().enumerate() {
                prop_assert!(ulps(up.lanes()[lane], exponent.exp2()) <= 2.0, "2^{exponent:e}");
                prop_assert!(ulps(down.lanes()[lane], (-exponent).exp2()) <= 2.0, "2^-{exponent:e}");
            }
            prop_assert_eq!((up.lanes()[2], down.lanes()[2]), (2.0_f64.powi(whole), 2.0_f64.powi(-whole)));
            prop_assert_eq!((up.last(), down.last()), (2.0_f64.powi(1020), 2.0_f64.powi(-1020)));
        }
    }

    #[test]
    fn limits_are_exact() {
        assert_eq!((exp(0.0), exp_m1(0.0)), (1.0, 0.0));
        assert_eq!(exp_m1(-700.0), -1.0);
        assert_eq!([tanh(f64::INFINITY), tanh(-50.0)], [1.0, -1.0]);
        assert_eq!(tanh(-0.0).to_bits(), (-0.0_f64).to_bits());
    }

    /// In lanes of any kind and one by one give the same bits.
    #[test]
    fn several_at_once_are_the_same_bits() {
        fn check<V: Four>() {
            for i in 0..1000 {
                let x: Lanes =
                    std::array::from_fn(|lane| (f64::from(4 * i) + lane as f64).sin() * 1.3_f64.powi(i % 40 - 15));
                let found = [exp_of(V::load(&x)), exp_m1_of(V::load(&x)), tanh_of(V::load(&x))].map(V::lanes);
                let expected = [x.map(exp), x.map(exp_m1), x.map(tanh)];
                assert_eq!(found.map(|lanes| lanes.map(f64::to_bits)), expected.map(|lanes| lanes.map(f64::to_bits)));
                let of = |x: Lanes| x.map(|x| x.clamp(-LARGEST, LARGEST));
                let found = powers_of(V::load(&of(x))).map(V::lanes);
                let [expected] = powers([Narrow::load(&of(x))]).map(|both| both.map(Narrow::lanes));
                assert_eq!(found.map(|lanes| lanes.map(f64::to_bits)), expected.map(|lanes| lanes.map(f64::to_bits)));
            }
        }
        check::<Portable>();
        check::<Narrow>();
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            check::<Wide>();
        }
    }
}

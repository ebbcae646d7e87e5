//! Normal deviates by inversion: one uniform number for one deviate.
//!
//! Rejection methods (polar, ziggurat) need an unknown number of uniform numbers, so the k-th deviate depends on all those
//! before it; sums of uniform numbers have no tails. The inverse distribution function needs exactly one number, so the
//! k-th deviate does not depend on others.

use serde::{Deserialize, Serialize};

use crate::philox;

/// A sequence of independent standard normal deviates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stream {
    /// Sequences of different seeds are independent.
    pub seed: u32,
    /// And so are those of one seed under different numbers.
    pub number: u32,
}

impl Stream {
    /// The deviate of that index.
    #[must_use]
    pub fn deviate(self, index: u64) -> f64 {
        #[allow(clippy::cast_possible_truncation)] // the two halves of the index
        let counter = [index as u32, (index >> 32) as u32, self.number, 0];
        let [low, high, ..] = philox::block(counter, [self.seed, 0]);
        let bits = u64::from(high) << 32 | u64::from(low);
        // 52 bits and a half: symmetric, never 0 or 1, and exact as a double.
        quantile(((bits >> 12) as f64 + 0.5) * (1.0 / (1_u64 << 52) as f64))
    }
}

/// Φ⁻¹(p) for 0 < p < 1, to 1 in 10¹⁶: algorithm AS 241 (PPND16) of M. J. Wichura, *The percentage points of the normal
/// distribution*, Applied Statistics 37 (1988) 477–484.
#[must_use]
pub fn quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        return q * ratio(&CENTRE, 0.180_625 - q * q);
    }
    let tail = if q < 0.0 { p } else { 1.0 - p };
    let r = (-libm::log(tail)).sqrt();
    let z = if r <= 5.0 { ratio(&MIDDLE, r - 1.6) } else { ratio(&FAR, r - 5.0) };
    z.copysign(q)
}

/// Quotient of two polynomials, by rising powers.
fn ratio([numerator, denominator]: &[[f64; 8]; 2], x: f64) -> f64 {
    let horner = |coefficients: &[f64; 8]| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    horner(numerator) / horner(denominator)
}

// The coefficients as they were published, with more digits than a double has.
#[allow(clippy::excessive_precision)]
const CENTRE: [[f64; 8]; 2] = [
    [
        3.387_132_872_796_366_608_0,
        1.331_416_678_917_843_774_5e2,
        1.971_590_950_306_551_442_7e3,
        1.373_169_376_550_946_112_5e4,
        4.592_195_393_154_987_145_7e4,
        6.726_577_092_700_870_085_3e4,
        3.343_057_558_358_812_810_5e4,
        2.509_080_928_730_122_672_7e3,
    ],
    [
        1.0,
        4.231_333_070_160_091_125_2e1,
        6.871_870_074_920_579_083_0e2,
        5.394_196_021_424_751_107_7e3,
        2.121_379_430_158_659_586_7e4,
        3.930_789_580_009_271_061_0e4,
        2.872_908_573_572_194_267_4e4,
        5.226_495_278_852_854_561_0e3,
    ],
];
#[allow(clippy::excessive_precision)]
const MIDDLE: [[f64; 8]; 2] = [
    [
        1.423_437_110_749_683_577_34,
        4.630_337_846_156_545_295_90,
        5.769_497_221_460_691_405_50,
        3.647_848_324_763_204_605_04,
        1.270_458_252_452_368_382_58,
        2.417_807_251_774_506_117_70e-1,
        2.272_384_498_926_918_458_33e-2,
        7.745_450_142_783_414_076_40e-4,
    ],
    [
        1.0,
        2.053_191_626_637_758_821_87,
        1.676_384_830_183_803_849_40,
        6.897_673_349_851_000_045_50e-1,
        1.481_039_764_274_800_745_90e-1,
        1.519_866_656_361_645_719_66e-2,
        5.475_938_084_995_344_946_00e-4,
        1.050_750_071_644_416_843_24e-9,
    ],
];
#[allow(clippy::excessive_precision)]
const FAR: [[f64; 8]; 2] = [
    [
        6.657_904_643_501_103_777_20,
        5.463_784_911_164_114_369_90,
        1.784_826_539_917_291_335_80,
        2.965_605_718_285_048_912_30e-1,
        2.653_218_952_657_612_309_30e-2,
        1.242_660_947_388_078_438_60e-3,
        2.711_555_568_743_487_578_15e-5,
        2.010_334_399_292_288_132_65e-7,
    ],
    [
        1.0,
        5.998_322_065_558_879_376_90e-1,
        1.369_298_809_227_358_053_10e-1,
        1.487_536_129_085_061_485_25e-2,
        7.868_691_311_456_132_591_00e-4,
        1.846_318_317_510_054_681_80e-5,
        1.421_511_758_316_445_888_70e-7,
        2.044_263_103_389_939_785_64e-15,
    ],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Quantiles to 16 digits, from tables (Φ⁻¹(0.975), one- to six-sigma tail probabilities as far as doubles hold them).
    #[test]
    fn quantiles_are_those_of_tables() {
        for (p, z) in [
            (0.5, 0.0),
            (0.75, 0.674_489_750_196_081_7),
            (0.9, 1.281_551_565_544_600_4),
            (0.975, 1.959_963_984_540_054),
            (0.995, 2.575_829_303_548_901),
            (1e-3, -3.090_232_306_167_813_5),
            (1e-6, -4.753_424_308_822_899),
            (1e-9, -5.997_807_015_007_686_9),
            (1e-12, -7.034_483_825_301_131),
            (1e-15, -7.941_345_326_170_997),
        ] {
            // AS 241's own accuracy of 1e-16, and a few roundings.
            let found = quantile(p);
            assert!((found - z).abs() <= 8.0 * f64::EPSILON * z.abs(), "p = {p}: {found:?}, not {z:?}");
        }
    }

    #[test]
    fn quantiles_are_odd_and_rise_over_the_seams() {
        let n = 1_u64 << 12;
        let grid = |i: u64| (i as f64 + 0.5) / n as f64;
        for i in 0..n {
            assert_eq!(quantile(grid(i)), -quantile(grid(n - 1 - i)));
            assert!(i == 0 || quantile(grid(i)) > quantile(grid(i - 1)));
        }
        for seam in [0.075, 1.0 - 0.075, (-25.0_f64).exp()] {
            let (below, above) = (quantile(seam * (1.0 - 1e-12)), quantile(seam * (1.0 + 1e-12)));
            assert!(below < above && above - below < 1e-10, "{seam}: {below} {above}");
        }
    }

    /// Bits that any machine and any later version must reproduce. Python's `statistics.NormalDist().inv_cdf`, which is AS 241
    /// too, gives the same bits for the same uniform numbers.
    #[test]
    fn deviates_are_the_same_everywhere() {
        let stream = Stream { seed: 1, number: 0 };
        let found: Vec<u64> = (0..4).map(|k| stream.deviate(k).to_bits()).collect();
        assert_eq!(found, RECORDED, "{found:#x?}");
    }

    const RECORDED: [u64; 4] =
        [0x3ff4_0782_7c9b_8c2d, 0x3ff2_5634_4ddb_c08a, 0x3fc2_3064_f5e9_3ea2, 0xbffc_ad31_1a68_b0b5];
}

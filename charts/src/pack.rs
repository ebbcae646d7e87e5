//! Columns of numbers as a short text.
//!
//! Each column is rounded to a whole number of quanta above its smallest value. The differences of these numbers from row
//! to row, or the differences of those where they are shorter (a smooth curve goes on as it went), are written as zigzag LEB128 (small
//! numbers take few bytes), all columns one after the other, then zlib and base64. A value that is not a finite number is written as −1.
//! A column that is equal to an earlier one is only named. `unpack.js` of the pages is the counterpart.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::deflate::{FARTHEST, Stream, Token, add_match};

/// Quanta between the smallest and the largest value of a column. The error of a value is at most half a quantum: less than
/// a millionth of the column's range.
pub const LEVELS: u32 = 1 << 20;

/// Stands for a value that is no finite number.
const GAP: i32 = -1;
/// The largest number: differences of differences are four times as large.
const MOST: i32 = 1 << 29;

/// Columns in the order they were added.
pub struct Packer {
    stream: Stream,
    /// Where numbers, their differences, bytes and tokens of a column are found.
    numbers: Vec<i32>,
    differences: [Vec<u32>; 2],
    bytes: Vec<u8>,
    tokens: Vec<Token>,
}

/// How a column's whole numbers become values: `low + number · quantum`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Smallest value.
    pub low: f64,
    /// Distance of two neighbouring values.
    pub quantum: f64,
    /// What is written: 1 for the differences of numbers, 2 for the differences of differences.
    pub order: u8,
}

impl Packer {
    /// No columns yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            stream: Stream::new(),
            numbers: Vec::new(),
            differences: [Vec::new(), Vec::new()],
            bytes: Vec::new(),
            tokens: Vec::new(),
        }
    }

    /// Adds a column. If it reaches from one end of all numbers to the other, those at the ends become gaps.
    pub fn add(&mut self, values: &[f64]) -> Scale {
        let (low, high) = range(values);
        if low.is_finite() && high - low == f64::INFINITY {
            // No scale reaches from one end of all numbers to the other: what is at an end becomes a gap.
            let inner = |value: &f64| if value.abs() < f64::MAX / 4.0 { *value } else { f64::NAN };
            return self.add(&values.iter().map(inner).collect::<Vec<_>>());
        }
        self.add_with(low, if high > low { (high - low) / f64::from(LEVELS) } else { 0.0 }, values)
    }

    /// Adds a column with its lowest value and a quantum of the caller, of which every value is at most
    /// 2²⁹ above the lowest one.
    pub fn add_with(&mut self, low: f64, quantum: f64, values: &[f64]) -> Scale {
        self.numbers.clear();
        if quantum > 0.0 {
            self.numbers.extend(values.iter().map(|value| number(*value, low, quantum)));
        } else {
            self.numbers.extend(values.iter().map(|value| if value.is_finite() { 0 } else { GAP }));
        }
        let [first, second] = &mut self.differences;
        differences(&self.numbers, first, second);
        let (order, shorter) = if size(second) < size(first) { (2, second) } else { (1, first) };
        let bytes = leb128(shorter, &mut self.bytes);
        runs(bytes, &mut self.tokens);
        // All matches are from one byte before.
        self.stream.add(bytes, &self.tokens, FARTHEST);
        Scale { low, quantum, order }
    }

    /// All columns as one text.
    #[must_use]
    pub fn finish(self) -> String {
        STANDARD.encode(self.stream.finish())
    }
}

impl Default for Packer {
    fn default() -> Self {
        Self::new()
    }
}

/// The earlier one of these columns that is equal to the one at a place, to the bit.
///
/// # Panics
/// When there is none at this place.
#[must_use]
pub fn same(columns: &[&[f64]], place: usize) -> Option<usize> {
    let (earlier, this) = (&columns[..place], columns[place]);
    let bits = |value: Option<&f64>| value.map(|value| value.to_bits());
    // Most differ in the middle or at the end.
    let is_like = |other: &[f64]| {
        [this.len() / 2, this.len().saturating_sub(1)].iter().all(|row| bits(other.get(*row)) == bits(this.get(*row)))
    };
    let is_same = |other: &&[f64]| {
        is_like(other) && other.len() == this.len() && other.iter().zip(this).all(|(a, b)| a.to_bits() == b.to_bits())
    };
    earlier.iter().position(is_same)
}

/// A value as a number of quanta.
#[inline]
fn number(value: f64, low: f64, quantum: f64) -> i32 {
    // The number whose lowest bits are those of a whole number that is added to it. A conversion would do the same for one value at a
    // time, this is done for several at once.
    const WHOLE: f64 = (3_u64 << 51) as f64;
    // What is no finite number is no number then.
    let number = (value - low) / quantum + 0.5 + 0.0 * value;
    let number = if number > f64::from(GAP) { number } else { f64::from(GAP) };
    let number = if number < f64::from(MOST) { number } else { f64::from(MOST) };
    // Between the gap and zero is zero.
    let number = if number > f64::from(GAP) && number < 0.0 { 0.0 } else { number };
    let nearest = number + WHOLE;
    let is_beyond = nearest - WHOLE > number;
    #[allow(clippy::cast_possible_truncation)] // the lowest bits
    let whole = nearest.to_bits() as i32;
    whole.wrapping_sub(i32::from(is_beyond))
}

/// 0, −1, 1, −2, 2 … as 0, 1, 2, 3, 4 …
fn zigzag(number: i32) -> u32 {
    ((number << 1) ^ (number >> 31)).cast_unsigned()
}

/// Differences from number to number, and of these, the first ones from 0; zigzag.
fn differences(numbers: &[i32], first: &mut Vec<u32>, second: &mut Vec<u32>) {
    first.clear();
    second.clear();
    let [one, two, ..] = numbers else {
        first.extend(numbers.iter().copied().map(zigzag));
        second.extend_from_slice(first);
        return;
    };
    first.extend([zigzag(*one), zigzag(two - one)]);
    second.extend([zigzag(*one), zigzag(two - one - one)]);
    // No number is so large that anything here would overflow; without checks for that, several are found at once.
    let [here, once, twice] = [2, 1, 0].map(|before| &numbers[before..numbers.len() - 2 + before]);
    let all = here.iter().zip(once);
    first.extend(all.clone().map(|(here, once)| zigzag(here.wrapping_sub(*once))));
    let bend = |here: i32, once: i32, twice: i32| here.wrapping_sub(once).wrapping_sub(once.wrapping_sub(twice));
    second.extend(all.zip(twice).map(|((here, once), twice)| zigzag(bend(*here, *once, *twice))));
}

/// About how long numbers are when they are compressed, by a part of them.
fn size(numbers: &[u32]) -> u64 {
    numbers.iter().step_by(4).map(|number| u64::from(u32::BITS - number.leading_zeros())).sum()
}

/// Seven bits per byte, the lowest first; the highest bit marks that more bytes follow.
fn leb128<'a>(numbers: &[u32], bytes: &'a mut Vec<u8>) -> &'a [u8] {
    const LONGEST: usize = 5;
    if bytes.len() < LONGEST * numbers.len() {
        bytes.resize(LONGEST * numbers.len(), 0);
    }
    let mut at = 0;
    for number in numbers {
        let mut number = *number;
        while number >= 0x80 {
            let [low, ..] = number.to_le_bytes();
            bytes[at] = low | 0x80;
            number >>= 7;
            at += 1;
        }
        let [low, ..] = number.to_le_bytes();
        bytes[at] = low;
        at += 1;
    }
    &bytes[..at]
}

/// The bytes as literals and repetitions of the byte before.
fn runs(bytes: &[u8], tokens: &mut Vec<Token>) {
    tokens.clear();
    tokens.reserve(bytes.len());
    let mut rest = bytes;
    while let Some((byte, others)) = rest.split_first() {
        tokens.push(Token::Literal(*byte));
        rest = others;
        // Most often not even the next one.
        if rest.first() == Some(byte) {
            let length = rest.iter().take_while(|other| *other == byte).count();
            let left = add_match(tokens, length, false);
            tokens.extend(std::iter::repeat_n(Token::Literal(*byte), left));
            rest = &rest[length..];
        }
    }
}

/// The smallest and the largest finite value; 0 and less if there is none.
fn range(values: &[f64]) -> (f64, f64) {
    // Side by side, so that one comparison needs not wait for the one before; in loops of their own, as the compiler needs them.
    const LANES: usize = 4;
    let lower = |low: f64, value: f64| if value < low { value } else { low };
    let higher = |high: f64, value: f64| if value > high { value } else { high };
    let (mut lows, mut highs) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    // Zero, but for what is no number or infinite.
    let mut odd = [0.0; LANES];
    let (groups, rest) = values.as_chunks::<LANES>();
    for group in groups {
        for (low, value) in lows.iter_mut().zip(group) {
            *low = lower(*low, *value);
        }
        for (high, value) in highs.iter_mut().zip(group) {
            *high = higher(*high, *value);
        }
        for (odd, value) in odd.iter_mut().zip(group) {
            *odd += value * 0.0;
        }
    }
    let is_finite = odd.into_iter().chain(rest.iter().map(|value| value * 0.0)).sum::<f64>() == 0.0;
    let (low, high) = if is_finite {
        let low = lows.into_iter().chain(rest.iter().copied()).fold(f64::INFINITY, lower);
        (low, highs.into_iter().chain(rest.iter().copied()).fold(f64::NEG_INFINITY, higher))
    } else {
        let finite = || values.iter().copied().filter(|value| value.is_finite());
        (finite().fold(f64::INFINITY, lower), finite().fold(f64::NEG_INFINITY, higher))
    };
    (if low.is_finite() { low } else { 0.0 }, high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    /// The decoder of the page, in Rust.
    fn unpack(text: &str, rows: usize, scales: &[Scale]) -> Vec<Vec<f64>> {
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(&STANDARD.decode(text).unwrap()[..]).read_to_end(&mut bytes).unwrap();
        let mut bytes = bytes.into_iter();
        let mut number = 0_i64;
        let columns = scales.iter().map(|scale| {
            number = 0;
            let mut slope = 0;
            let column = (0..rows).map(|_| {
                let (mut code, mut shift) = (0_i64, 0);
                loop {
                    let byte = bytes.next().unwrap();
                    code |= i64::from(byte & 0x7F) << shift;
                    shift += 7;
                    if byte < 0x80 {
                        break;
                    }
                }
                let code = if code % 2 == 0 { code / 2 } else { -(code + 1) / 2 };
                slope = if scale.order == 2 { slope + code } else { code };
                number += slope;
                if number < 0 {
                    return f64::NAN;
                }
                scale.low + number as f64 * scale.quantum
            });
            column.collect()
        });
        let columns = columns.collect();
        assert_eq!(bytes.next(), None, "no byte is left over");
        columns
    }

    #[test]
    fn columns_return_within_a_millionth_of_their_range() {
        let wave: Vec<f64> = (0..5000).map(|row| 3.0 * (f64::from(row) * 0.4).sin() - 7.0).collect();
        let jump: Vec<f64> = (0..5000).map(|row| if row == 17 { 1e12 } else { -1e12 }).collect();
        let constant = vec![0.1; 5000];
        let mut packer = Packer::new();
        let scales = [&wave, &jump, &constant].map(|column| packer.add(column));
        let text = packer.finish();
        let columns = unpack(&text, 5000, &scales);
        for (column, original) in columns.iter().zip([&wave, &jump, &constant]) {
            let range = original.iter().fold(f64::NEG_INFINITY, |high, v| high.max(*v))
                - original.iter().fold(f64::INFINITY, |low, v| low.min(*v));
            assert!(column.iter().zip(original).all(|(a, b)| (a - b).abs() <= 1e-6 * range));
        }
        assert_eq!(columns[2], constant);
    }

    #[test]
    fn what_is_no_number_does_not_spoil_the_rest() {
        let mut packer = Packer::new();
        let scale = packer.add(&[1.0, f64::NAN, 2.0, f64::INFINITY]);
        let columns = unpack(&packer.finish(), 4, &[scale]);
        assert_eq!((columns[0][0], columns[0][2]), (1.0, 2.0));
        assert!(columns[0][1].is_nan() && columns[0][3].is_nan(), "a gap in the curve");
        let mut packer = Packer::new();
        assert_eq!(packer.add(&[f64::NAN]), Scale { low: 0.0, quantum: 0.0, order: 1 });
    }

    #[test]
    fn the_ends_of_all_numbers_are_gaps_where_no_scale_reaches_both() {
        let values = [f64::MAX, 1e300, f64::MIN, 0.0, -1e308];
        let mut packer = Packer::new();
        let scale = packer.add(&values);
        assert!(scale.quantum.is_finite());
        let column = &unpack(&packer.finish(), values.len(), &[scale])[0];
        assert!([0, 2, 4].iter().all(|end| column[*end].is_nan()), "{column:?}");
        assert_eq!((column[1], column[3]), (1e300, 0.0));
        assert_eq!(Packer::new().add(&[f64::MAX, f64::MAX]).low, f64::MAX, "one end alone is a number");
    }

    #[test]
    fn small_differences_take_one_byte() {
        let mut bytes = Vec::new();
        assert_eq!(leb128(&[0, -1, 1, -64, 63].map(zigzag), &mut bytes), [0, 1, 2, 127, 126]);
        assert_eq!(leb128(&[zigzag(i32::MIN)], &mut bytes), [0xFF, 0xFF, 0xFF, 0xFF, 0x0F]);
    }

    #[test]
    fn smooth_columns_take_a_fraction_of_what_their_differences_would() {
        let size = |columns: &[Vec<f64>]| {
            let mut packer = Packer::new();
            let scales: Vec<Scale> = columns.iter().map(|column| packer.add(column)).collect();
            let text = packer.finish();
            assert_eq!(unpack(&text, 8000, &scales).len(), columns.len());
            (text.len(), scales[0].order)
        };
        let smooth = (0..8000).map(|row| (f64::from(row) * 2e-3).sin()).collect();
        assert!(matches!(size(&[smooth]), (..4000, 2)), "half a byte a row");
        // Differences of chance are worse when they are taken twice.
        let mut state = 1_u32;
        let mut chance = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8)
        };
        assert_eq!(size(&[(0..8000).map(&mut chance).collect()]).1, 1);
        let (one, _) = size(&[vec![0.5; 8000]]);
        assert!(one < 150, "{one}");
    }

    #[test]
    fn the_largest_numbers_are_packed_and_what_is_beyond_is_cut_off() {
        let most = f64::from(MOST);
        let values = [0.0, most, 0.0, f64::NAN, most, most, 0.0, 1.0, 9.0 * most, -5.0 * most];
        let mut packer = Packer::new();
        let scale = packer.add_with(0.0, 1.0, &values);
        let column = &unpack(&packer.finish(), values.len(), &[scale])[0];
        assert_eq!(column[..3], values[..3]);
        assert_eq!(column[4..9], [most, most, 0.0, 1.0, most]);
        assert!(column[3].is_nan() && column[9].is_nan());
        for few in [&values[..0], &values[..1], &values[..2]] {
            let mut packer = Packer::new();
            let scale = packer.add_with(0.0, 1.0, few);
            assert_eq!(unpack(&packer.finish(), few.len(), &[scale])[0], few);
        }
    }

    #[test]
    fn equal_columns_are_found() {
        let (a, b, c) = ([0.0, 1.0, f64::NAN], [0.5, 1.0, f64::NAN], [0.0, 1.0]);
        let columns: [&[f64]; 6] = [&a, &b, &c, &b, &[], &a];
        assert_eq!([0, 1, 2, 3, 4, 5].map(|place| same(&columns, place)), [None, None, None, Some(1), None, Some(0)]);
        assert_eq!(same(&[&[0.0], &[-0.0]], 1), None);
    }
}

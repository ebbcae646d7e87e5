//! Columns of numbers as a short text.
//!
//! Each column is rounded to a whole number of quanta above its smallest value. The differences of these numbers from row
//! to row are written as zigzag LEB128 (small differences take few bytes), all columns one after the other, then zlib and
//! base64. A value that is not a finite number is written as −1. `unpack.js` of the pages is the counterpart.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

/// Quanta between the smallest and the largest value of a column. The error of a value is at most half a quantum: less than
/// a millionth of the column's range.
pub const LEVELS: u32 = 1 << 20;

/// Of nine: columns become a thirtieth smaller beyond it, at nearly twice the work.
const EFFORT: u32 = 2;

/// Stands for a value that is no finite number.
const GAP: i32 = -1;

/// Columns in the order they were added.
pub struct Packer {
    encoder: ZlibEncoder<Vec<u8>>,
}

/// How a column's whole numbers become values: `low + number · quantum`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Smallest value.
    pub low: f64,
    /// Distance of two neighbouring values.
    pub quantum: f64,
}

impl Packer {
    /// No columns yet.
    #[must_use]
    pub fn new() -> Self {
        Self { encoder: ZlibEncoder::new(Vec::new(), Compression::new(EFFORT)) }
    }

    /// Adds a column.
    ///
    /// # Panics
    /// Never: writing to memory cannot fail.
    pub fn add(&mut self, values: &[f64]) -> Scale {
        let (low, high) = range(values);
        let scale = Scale { low, quantum: if high > low { (high - low) / f64::from(LEVELS) } else { 0.0 } };
        self.add_with(scale, values);
        scale
    }

    /// Adds a column with a scale of the caller, with which every value is fewer than 2³⁰ quanta above the lowest one.
    ///
    /// # Panics
    /// Never: writing to memory cannot fail.
    pub fn add_with(&mut self, scale: Scale, values: &[f64]) {
        let Scale { low, quantum } = scale;
        let mut bytes = Vec::with_capacity(2 * values.len());
        let mut before = 0;
        for value in values {
            #[allow(clippy::cast_possible_truncation)] // 0 to 2³⁰
            let number = match value {
                value if !value.is_finite() => GAP,
                value if quantum > 0.0 => ((value - low) / quantum + 0.5) as i32,
                _ => 0,
            };
            leb128(zigzag(number - before), &mut bytes);
            before = number;
        }
        self.encoder.write_all(&bytes).expect("writing to memory cannot fail");
    }

    /// All columns as one text.
    ///
    /// # Panics
    /// Never: writing to memory cannot fail.
    #[must_use]
    pub fn finish(self) -> String {
        STANDARD.encode(self.encoder.finish().expect("writing to memory cannot fail"))
    }
}

impl Default for Packer {
    fn default() -> Self {
        Self::new()
    }
}

/// The smallest and the largest finite value; 0 and less if there is none.
fn range(values: &[f64]) -> (f64, f64) {
    // Side by side, so that one comparison needs not wait for the one before.
    const LANES: usize = 8;
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    let mut take = |lane: usize, value: f64| {
        let (less, more) = if value.is_finite() { (value, value) } else { (f64::INFINITY, f64::NEG_INFINITY) };
        low[lane] = if less < low[lane] { less } else { low[lane] };
        high[lane] = if more > high[lane] { more } else { high[lane] };
    };
    let (groups, rest) = values.as_chunks::<LANES>();
    for group in groups {
        for (lane, value) in group.iter().enumerate() {
            take(lane, *value);
        }
    }
    for value in rest {
        take(0, *value);
    }
    let low = low.into_iter().fold(f64::INFINITY, f64::min);
    let high = high.into_iter().fold(f64::NEG_INFINITY, f64::max);
    (if low.is_finite() { low } else { 0.0 }, high)
}

/// 0, −1, 1, −2, 2 … as 0, 1, 2, 3, 4 …
fn zigzag(number: i32) -> u32 {
    ((number << 1) ^ (number >> 31)).cast_unsigned()
}

/// Seven bits per byte, the lowest first; the highest bit marks that more bytes follow.
fn leb128(mut number: u32, bytes: &mut Vec<u8>) {
    loop {
        let [low, ..] = number.to_le_bytes();
        number >>= 7;
        if number == 0 {
            bytes.push(low);
            return;
        }
        bytes.push(low | 0x80);
    }
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
                number += if code % 2 == 0 { code / 2 } else { -(code + 1) / 2 };
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
        assert_eq!(packer.add(&[f64::NAN]), Scale { low: 0.0, quantum: 0.0 });
    }

    #[test]
    fn small_differences_take_one_byte() {
        let mut bytes = Vec::new();
        for number in [0, -1, 1, -64, 63] {
            leb128(zigzag(number), &mut bytes);
        }
        assert_eq!(bytes, [0, 1, 2, 127, 126]);
        bytes.clear();
        leb128(zigzag(i32::MIN), &mut bytes);
        assert_eq!(bytes, [0xFF, 0xFF, 0xFF, 0xFF, 0x0F]);
    }
}

//! Numbers as text: the digits of the standard library's `{:?}`, found several times faster.

use std::io::Write;

/// Whether a number may lie halfway between two shortest texts: the standard library takes the one farther from zero, others the even
/// one. It has as many digits after the point as bits, one more than these texts, which are not closer together than doubles are.
/// That is so with 25 bits at most: a number v = n/2ᵏ has neighbours closer than 10²⁻ᵏ, so n < 2⁵³ 10²⁻ᵏ 2ᵏ, and n ≥ 1.
#[inline]
fn may_be_halfway(value: f64) -> bool {
    const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
    let bits = value.to_bits();
    let exponent = (bits >> MANTISSA) & 0x7FF;
    let zeros = (bits | 1 << MANTISSA).trailing_zeros();
    // Places after the point, less the bias of the exponent.
    let places = u64::from(MANTISSA - zeros) + 1023;
    (exponent + 1..=exponent + 25).contains(&places)
}

/// No text is longer: a sign, a point, 17 digits and `0.000` or `e-308` are 24 bytes.
pub(super) const LONGEST: usize = 32;

/// Writes the shortest digits that read back exactly, and returns how many bytes these are: fixed point from 10⁻⁴ to 10¹⁶, with an
/// exponent below and above, whole numbers without a point, zero without a sign. What is after them may be overwritten.
#[inline]
pub(super) fn put(value: f64, text: &mut [u8; LONGEST]) -> usize {
    let size = value.abs();
    if !(f64::MIN_POSITIVE..1e16).contains(&size) || may_be_halfway(value) {
        return put_odd(value, text);
    }
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format_finite(value).as_bytes();
    if size >= 1e-4 {
        put_short(without_fraction(digits), text)
    } else if size >= 1e-5 {
        put_small(digits, text)
    } else {
        put_short(digits, text)
    }
}

/// The same of any number.
#[cold]
fn put_odd(value: f64, text: &mut [u8; LONGEST]) -> usize {
    let size = value.abs();
    if size == 0.0 {
        text[0] = b'0';
        return 1;
    }
    let mut rest = &mut text[..];
    // There is room for all of it.
    let _ = if size < 1e-4 || (size >= 1e16 && size.is_finite()) {
        write!(rest, "{value:e}")
    } else {
        write!(rest, "{value}")
    };
    LONGEST - rest.len()
}

/// A whole number as text, without the fraction of zero that it may have.
#[inline]
fn without_fraction(digits: &[u8]) -> &[u8] {
    match digits {
        [whole @ .., b'.', b'0'] => whole,
        _ => digits,
    }
}

/// Copies some bytes, as two pieces that may overlap.
#[inline]
fn put_short(bytes: &[u8], text: &mut [u8; LONGEST]) -> usize {
    let count = bytes.len();
    if !put_pieces::<16>(bytes, text) && !put_pieces::<8>(bytes, text) {
        for (to, from) in text.iter_mut().zip(bytes) {
            *to = *from;
        }
    }
    count
}

/// The first `N` bytes and the last ones, if there are as many.
#[inline]
fn put_pieces<const N: usize>(bytes: &[u8], text: &mut [u8; LONGEST]) -> bool {
    let (Some(first), Some(last)) = (bytes.first_chunk::<N>(), bytes.last_chunk::<N>()) else { return false };
    let mut place = |at: usize, piece: &[u8; N]| {
        if let Some(to) = text[at..].first_chunk_mut() {
            *to = *piece;
        }
    };
    place(0, first);
    place(bytes.len() - N, last);
    true
}

/// A number from 10⁻⁵ to 10⁻⁴, which comes as `0.0000…`, with an exponent instead.
#[inline]
fn put_small(digits: &[u8], text: &mut [u8; LONGEST]) -> usize {
    const ZEROS: &[u8] = b"0.0000";
    let (sign, digits) = digits.split_at(usize::from(digits[0] == b'-'));
    let digits = &digits[ZEROS.len()..];
    text[0] = b'-';
    let begin = sign.len();
    // One place farther on, to make room for the point.
    let (head, tail) = digits.split_at(1);
    text[begin] = head[0];
    let mut end = begin + 1;
    if !tail.is_empty() {
        text[end] = b'.';
        text[end + 1..=end + tail.len()].copy_from_slice(tail);
        end += 1 + tail.len();
    }
    for byte in b"e-5" {
        text[end] = *byte;
        end += 1;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: f64) -> String {
        let mut text = [b'x'; LONGEST];
        let count = put(value, &mut text);
        String::from_utf8(text[..count].to_vec()).unwrap()
    }

    /// What rows said before there was anything faster, and what other languages read.
    fn standard(value: f64) -> String {
        let text = format!("{:?}", value + 0.0);
        text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
    }

    #[test]
    fn numbers_are_those_of_the_standard_library() {
        let powers = (-324..=308).map(|power| format!("1e{power}").parse::<f64>().unwrap());
        for power in powers {
            for value in [power, power.next_down(), power.next_up(), 1.5 * power, 9.876_543_21 * power, -power / 3.0] {
                assert_eq!(text(value), standard(value));
            }
        }
        for value in [
            0.0,
            -0.0,
            1e16 - 2.0,
            -f64::MAX,
            -f64::MIN_POSITIVE,
            -123_456_789_012_345.67,
            12_345_678.0,
            1234.5,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MAX,
            f64::from_bits(1),
        ] {
            assert_eq!(text(value), standard(value));
        }
        // Halfway between two texts, and around: few bits after the point.
        for odd in (1..20_000).step_by(2) {
            for places in 1..30 {
                let part = f64::from(odd) * 0.5_f64.powi(places);
                for value in [part, part + 10_f64.powi(16 - places), part + 4.0 * 10_f64.powi(15 - places)] {
                    assert_eq!(text(value), standard(value));
                }
            }
        }
        // A walk through all exponents and signs.
        let mut bits = 0x9E37_79B9_7F4A_7C15_u64;
        for _ in 0..1_000_000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let value = f64::from_bits(bits ^ (bits >> 29));
            assert_eq!(text(value), standard(value));
        }
    }
}

//! Numbers as text: the digits of the standard library's `{:?}`, found several times faster.

use std::io::Write;

/// Whether a number may lie halfway between two shortest texts: the standard library takes the one farther from zero, others the even
/// one. It has as many digits after the point as bits, one more than these texts, which are not closer together than doubles are.
/// That is so with 25 bits at most: a number v = n/2ᵏ has neighbours closer than 10²⁻ᵏ, so n < 2⁵³ 10²⁻ᵏ 2ᵏ, and n ≥ 1.
fn may_be_halfway(value: f64) -> bool {
    const MANTISSA: u32 = f64::MANTISSA_DIGITS - 1;
    let bits = value.to_bits();
    let exponent = (bits >> MANTISSA) & 0x7FF;
    let zeros = (bits | 1 << MANTISSA).trailing_zeros();
    // Places after the point, less the bias of the exponent.
    let places = u64::from(MANTISSA - zeros) + 1023;
    (exponent + 1..=exponent + 25).contains(&places)
}

/// Appends the shortest digits that read back exactly: fixed point from 10⁻⁴ to 10¹⁶, with an exponent below and above, whole
/// numbers without a point, zero without a sign.
pub(super) fn push(value: f64, text: &mut Vec<u8>) {
    let size = value.abs();
    if size == 0.0 {
        text.push(b'0');
        return;
    }
    if may_be_halfway(value) {
        // Writing to memory cannot fail.
        let _ = if size < 1e-4 { write!(text, "{value:e}") } else { write!(text, "{value}") };
        return;
    }
    let mut buffer = zmij::Buffer::new();
    let digits = buffer.format(value).as_bytes();
    if (1e-4..1e16).contains(&size) || !size.is_finite() {
        text.extend_from_slice(without_fraction(digits));
        return;
    }
    // `e-300` is the longest exponent.
    let tail = digits.len().saturating_sub(5);
    if let Some(at) = digits[tail..].iter().position(|byte| *byte == b'e') {
        let (mantissa, exponent) = digits.split_at(tail + at);
        text.extend_from_slice(without_fraction(mantissa));
        let (sign, number): (&[u8], _) = match &exponent[1..] {
            [b'-', number @ ..] => (b"e-", number),
            [b'+', number @ ..] | number => (b"e", number),
        };
        text.extend_from_slice(sign);
        text.extend_from_slice(&number[number.iter().take_while(|digit| **digit == b'0').count()..]);
    } else {
        push_small(digits, text);
    }
}

/// A whole number as text, without the fraction of zero that it may have.
fn without_fraction(digits: &[u8]) -> &[u8] {
    digits.strip_suffix(b".0").unwrap_or(digits)
}

/// Appends a number that comes as `0.0…`, with an exponent instead.
fn push_small(mut digits: &[u8], text: &mut Vec<u8>) {
    if let Some(size) = digits.strip_prefix(b"-") {
        text.push(b'-');
        digits = size;
    }
    let zeros = digits.iter().take_while(|digit| matches!(digit, b'0' | b'.')).count();
    let (first, others) = digits[zeros..].split_at(1);
    text.extend_from_slice(first);
    if !others.is_empty() {
        text.push(b'.');
        text.extend_from_slice(others);
    }
    // Of the zeros one is before the point; writing to memory cannot fail.
    let _ = write!(text, "e-{}", zeros - 1);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pushed(value: f64) -> String {
        let mut text = Vec::new();
        push(value, &mut text);
        String::from_utf8(text).unwrap()
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
                assert_eq!(pushed(value), standard(value));
            }
        }
        for value in [0.0, -0.0, 1e16 - 2.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::from_bits(1)] {
            assert_eq!(pushed(value), standard(value));
        }
        // Halfway between two texts, and around: few bits after the point.
        for odd in (1..20_000).step_by(2) {
            for places in 1..30 {
                let part = f64::from(odd) * 0.5_f64.powi(places);
                for value in [part, part + 10_f64.powi(16 - places), part + 4.0 * 10_f64.powi(15 - places)] {
                    assert_eq!(pushed(value), standard(value));
                }
            }
        }
        // A walk through all exponents and signs.
        let mut bits = 0x9E37_79B9_7F4A_7C15_u64;
        for _ in 0..1_000_000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let value = f64::from_bits(bits ^ (bits >> 29));
            assert_eq!(pushed(value), standard(value));
        }
    }
}

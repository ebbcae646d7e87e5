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
    let mut buffer = zmij::Buffer::new();
    if size == 0.0 {
        text.push(b'0');
    } else if may_be_halfway(value) {
        // Writing to memory cannot fail.
        let _ = if size < 1e-4 { write!(text, "{value:e}") } else { write!(text, "{value}") };
    } else if (1e-4..1e16).contains(&size) || !size.is_finite() {
        let digits = buffer.format(value);
        text.extend_from_slice(digits.strip_suffix(".0").unwrap_or(digits).as_bytes());
    } else {
        if value < 0.0 {
            text.push(b'-');
        }
        let exponent = scientific(buffer.format(size), text);
        text.extend_from_slice(if exponent < 0 { b"e-" } else { b"e" });
        push_whole(exponent.unsigned_abs(), text);
    }
}

/// Appends the digits of a positive number from its first one that is not zero on, with a point behind the first if there are more, and
/// returns the power of ten of the first. The number comes with an exponent, or as `0.0…`.
fn scientific(digits: &str, text: &mut Vec<u8>) -> i32 {
    if let Some((mantissa, exponent)) = digits.split_once('e') {
        text.extend_from_slice(mantissa.strip_suffix(".0").unwrap_or(mantissa).as_bytes());
        return exponent.parse().unwrap_or_default();
    }
    let fraction = digits.trim_start_matches(['0', '.']).as_bytes();
    text.push(fraction[0]);
    if fraction.len() > 1 {
        text.push(b'.');
        text.extend_from_slice(&fraction[1..]);
    }
    let zeros = digits.len() - fraction.len() - 1;
    -i32::try_from(zeros).unwrap_or_default()
}

/// Appends a number of at most three digits.
fn push_whole(number: u32, text: &mut Vec<u8>) {
    let digits = [number / 100 % 10, number / 10 % 10, number % 10];
    let first = digits.iter().position(|digit| *digit > 0).unwrap_or(2);
    text.extend(digits[first..].iter().map(|digit| b'0' + digit.to_le_bytes()[0]));
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

//! CRC-32 as of zip files, which detects every single- and double-bit error and every burst up to 32 bits.
//!
//! A table of 1 KiB: crates that do it faster bring 16 KiB of tables and 6 kB of code into each library, for bytes that are summed once
//! when a state is saved to them or read from them.

/// The polynomial of ISO 3309, lowest bit first.
const POLYNOMIAL: u32 = 0xedb8_8320;

static REMAINDERS: [u32; 256] = remainders();

/// The remainder of each byte alone.
const fn remainders() -> [u32; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        #[allow(clippy::cast_possible_truncation)] // Below 256.
        let mut remainder = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            remainder = (remainder >> 1) ^ if remainder & 1 == 1 { POLYNOMIAL } else { 0 };
            bit += 1;
        }
        table[byte] = remainder;
        byte += 1;
    }
    table
}

/// The CRC-32 of these bytes.
pub(crate) fn checksum(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, byte| REMAINDERS[usize::from(sum.to_le_bytes()[0] ^ byte)] ^ (sum >> 8))
}

#[cfg(test)]
mod tests {
    use super::checksum;

    #[test]
    fn sums_are_those_of_zip_files() {
        // The check value of the catalogue of CRCs.
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
        assert_eq!(checksum(b""), 0);
        let bytes: Vec<u8> = (0..1000_u32).map(|i| i.wrapping_mul(2_654_435_761).to_le_bytes()[3]).collect();
        assert_eq!(checksum(&bytes), crc32fast::hash(&bytes));
    }
}

//! Bytes as a zlib stream (RFC 1950, 1951), for what knows where its repetitions are: each block of literals and matches, with codes
//! of its own.

use simd_adler32::Adler32;

/// The longest match of the format, and the shortest.
pub(crate) const LONGEST: usize = 258;
pub(crate) const SHORTEST: usize = 3;
/// The farthest place that a match may begin at.
pub(crate) const FARTHEST: usize = 1 << 15;
/// The symbol at the end of a block.
const END: u16 = 256;
/// Literals and lengths of matches.
const SYMBOLS: usize = 286;

/// A byte, or what came before again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Token {
    Literal(u8),
    /// So many bytes, from a distance that is the same in all of a block, or else from one byte before.
    Match(u16, bool),
}

/// Adds a match of any length that is not too short; what is left of it, to be written otherwise, is returned.
pub(crate) fn add_match(tokens: &mut Vec<Token>, mut length: usize, is_far: bool) -> usize {
    while length >= SHORTEST {
        let part = length.min(LONGEST);
        #[allow(clippy::cast_possible_truncation)] // 258 at most
        tokens.push(Token::Match(part as u16, is_far));
        length -= part;
    }
    length
}

/// A stream that grows.
pub(crate) struct Stream {
    bits: Bits,
    sum: Adler32,
}

impl Stream {
    pub(crate) fn new() -> Self {
        Self { bits: Bits { bytes: vec![0x78, 0x5E], ..Bits::default() }, sum: Adler32::new() }
    }

    /// Adds bytes, which these tokens stand for; `far` is the distance of matches that are not from one byte before.
    pub(crate) fn add(&mut self, bytes: &[u8], tokens: &[Token], far: usize) {
        self.sum.write(bytes);
        self.bits.push(0b100, 3);
        block(tokens, far, &mut self.bits);
    }

    /// The whole stream.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        // An empty block with the codes of the format.
        self.bits.push(0b011, 3 + 7);
        let mut bytes = self.bits.finish();
        bytes.extend(self.sum.finish().to_be_bytes());
        bytes
    }
}

/// The rest of a block with codes of its own.
fn block(tokens: &[Token], far: usize, stream: &mut Bits) {
    let mut counts = [0_u32; SYMBOLS];
    counts[usize::from(END)] = 1;
    for token in tokens {
        let symbol = match token {
            Token::Literal(byte) => u16::from(*byte),
            Token::Match(length, _) => of_length(*length).0,
        };
        counts[usize::from(symbol)] += 1;
    }
    let lengths = code_lengths(&counts, 15);
    let row = of_distance(far);
    // One bit says which of the two distances.
    let mut distances = vec![0_u8; row.0 + 1];
    (distances[0], distances[row.0]) = (1, 1);
    header(&lengths, &distances, stream);

    // The bits of each literal, and of each length with the number that follows it.
    let codes = codes(&lengths);
    let matches: Vec<(u32, u32)> = (0..=LONGEST)
        .map(|length| {
            #[allow(clippy::cast_possible_truncation)] // 258 at most
            let (symbol, extra, bits) = of_length(length.max(SHORTEST) as u16);
            let (code, count) = codes[usize::from(symbol)];
            (code | extra << count, count + bits)
        })
        .collect();
    for token in tokens {
        match token {
            Token::Literal(byte) => stream.code(codes[usize::from(*byte)]),
            Token::Match(length, false) => {
                let (bits, count) = matches[usize::from(*length)];
                stream.push(bits, count + 1);
            }
            Token::Match(length, true) => {
                stream.code(matches[usize::from(*length)]);
                stream.push(1 | row.1 << 1, 1 + row.2);
            }
        }
    }
    stream.code(codes[usize::from(END)]);
}

/// The symbol of a length, and the number that follows in so many bits.
fn of_length(length: u16) -> (u16, u32, u32) {
    let more = u32::from(length) - 3;
    #[allow(clippy::cast_possible_truncation)] // 284 at most
    match more {
        255 => (285, 0, 0),
        0..8 => (257 + more as u16, 0, 0),
        _ => {
            let bits = more.ilog2() - 2;
            (257 + (4 * bits + (more >> bits)) as u16, more & ((1 << bits) - 1), bits)
        }
    }
}

/// The same of a distance.
fn of_distance(distance: usize) -> (usize, u32, u32) {
    let more = distance - 1;
    if more < 4 {
        return (more, 0, 0);
    }
    let bits = more.ilog2() - 1;
    let extra = u32::try_from(more & ((1 << bits) - 1)).unwrap_or_default();
    (2 * bits as usize + (more >> bits), extra, bits)
}

/// The lengths of both codes, themselves coded.
#[allow(clippy::cast_possible_truncation)] // some hundreds
fn header(lengths: &[u8], distances: &[u8], stream: &mut Bits) {
    /// The order in which the format has the lengths of this code.
    const ORDER: [usize; 19] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
    let all: Vec<u8> = lengths.iter().chain(distances).copied().collect();
    // Symbols, and numbers in so many bits: 17 and 18 are 3 to 10 and 11 to 138 zeros.
    let mut symbols: Vec<(u8, u32, u32)> = Vec::new();
    let mut rest = &all[..];
    while let Some(length) = rest.first() {
        let zeros = rest.iter().take(138).take_while(|length| **length == 0).count();
        let (symbol, count) = match zeros {
            0..3 => ((*length, 0, 0), 1),
            3..11 => ((17, zeros as u32 - 3, 3), zeros),
            _ => ((18, zeros as u32 - 11, 7), zeros),
        };
        symbols.push(symbol);
        rest = &rest[count..];
    }
    let mut counts = [0; 19];
    for (symbol, ..) in &symbols {
        counts[usize::from(*symbol)] += 1;
    }
    let own = code_lengths(&counts, 7);
    let used = ORDER.iter().rposition(|symbol| own[*symbol] > 0).map_or(4, |last| (last + 1).max(4));
    stream.push(lengths.len() as u32 - 257, 5);
    stream.push(distances.len() as u32 - 1, 5);
    stream.push(used as u32 - 4, 4);
    for symbol in &ORDER[..used] {
        stream.push(u32::from(own[*symbol]), 3);
    }
    let codes = codes(&own);
    for (symbol, extra, bits) in symbols {
        stream.code(codes[usize::from(symbol)]);
        stream.push(extra, bits);
    }
}

/// The lengths of Huffman's code for symbols that come this often, none longer than `limit` bits.
fn code_lengths(counts: &[u32], limit: u8) -> Vec<u8> {
    let mut counts = counts.to_vec();
    loop {
        let lengths = huffman(&counts);
        if lengths.iter().all(|length| *length <= limit) {
            return lengths;
        }
        // What is more alike has codes more alike.
        for count in counts.iter_mut().filter(|count| **count > 0) {
            *count = *count / 2 + 1;
        }
    }
}

/// The lengths of Huffman's code; 0 for what does not come.
fn huffman(counts: &[u32]) -> Vec<u8> {
    let mut lengths = vec![0_u8; counts.len()];
    // Symbols from the rarest to the most frequent, then joined ones, which come out in this order, too; and their parents.
    let mut symbols: Vec<usize> = (0..counts.len()).filter(|symbol| counts[*symbol] > 0).collect();
    symbols.sort_by_key(|symbol| counts[*symbol]);
    let leaves = symbols.len();
    if let [only] = symbols[..] {
        lengths[only] = 1;
    }
    let mut weights: Vec<u64> = symbols.iter().map(|symbol| u64::from(counts[*symbol])).collect();
    let mut parents = vec![0; 2 * leaves];
    let (mut leaf, mut joined) = (0, leaves);
    for parent in leaves..(2 * leaves).saturating_sub(1) {
        // The two rarest become one.
        let mut weight = 0;
        for _ in 0..2 {
            let is_leaf = leaf < leaves && (joined == parent || weights[leaf] <= weights[joined]);
            let next = if is_leaf { &mut leaf } else { &mut joined };
            parents[*next] = parent;
            weight += weights[*next];
            *next += 1;
        }
        weights.push(weight);
    }
    // From the last one down: one bit more than the parent.
    let mut depths = vec![0_u8; 2 * leaves];
    for node in (0..(2 * leaves).saturating_sub(2)).rev() {
        depths[node] = depths[parents[node]].saturating_add(1);
        if node < leaves {
            lengths[symbols[node]] = depths[node];
        }
    }
    lengths
}

/// The codes with these lengths, their first bit lowest, and the lengths.
fn codes(lengths: &[u8]) -> Vec<(u32, u32)> {
    let mut next = 0_u32;
    let mut codes = vec![(0, 0); lengths.len()];
    for length in 1..=15 {
        next <<= 1;
        for (code, _) in codes.iter_mut().zip(lengths).filter(|(_, own)| **own == length) {
            let bits = u32::from(length);
            *code = (next.reverse_bits() >> (u32::BITS - bits), bits);
            next += 1;
        }
    }
    codes
}

/// Writes bits, the lowest first.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    waiting: u64,
    count: u32,
}

impl Bits {
    /// At most 32 bits.
    #[inline]
    fn push(&mut self, bits: u32, count: u32) {
        self.waiting |= u64::from(bits) << self.count;
        self.count += count;
        if self.count >= 32 {
            #[allow(clippy::cast_possible_truncation)] // the lower half
            self.bytes.extend((self.waiting as u32).to_le_bytes());
            self.waiting >>= 32;
            self.count -= 32;
        }
    }

    #[inline]
    fn code(&mut self, (code, length): (u32, u32)) {
        self.push(code, length);
    }

    fn finish(mut self) -> Vec<u8> {
        let rest = self.count.div_ceil(8) as usize;
        self.bytes.extend(&self.waiting.to_le_bytes()[..rest]);
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_never_too_long() {
        // Each as frequent as all before it together: one bit more for each.
        let counts: Vec<u32> = (0..30).map(|power| 1 << power).collect();
        for limit in [15, 7] {
            let lengths = code_lengths(&counts, limit);
            assert!(lengths.iter().all(|length| (1..=limit).contains(length)));
            let full: f64 = lengths.iter().map(|length| 0.5_f64.powi(i32::from(*length))).sum();
            assert_eq!(full, 1.0);
        }
        assert_eq!((code_lengths(&[0, 7, 0], 15), code_lengths(&[0, 0], 15)), (vec![0, 1, 0], vec![0, 0]));
    }
}

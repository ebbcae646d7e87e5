//! Saved states as bytes: versioned, tied to the GUID, checksummed.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `fmi2-exp` |
//! | 4 | format version, little endian |
//! | 38 | GUID of the model's description, with braces |
//! | 8 | length n of the payload, little endian |
//! | n | the state, in `postcard` format |
//! | 4 | CRC-32 of all that precedes, little endian |

use postcard::ser_flavors::Flavor;
use serde::{Serialize, de::DeserializeOwned};

use crate::checksum::checksum;

const MAGIC: &[u8; 8] = b"fmi2-exp";
const VERSION: u32 = 1;
pub(crate) const GUID_LENGTH: usize = 38;
const HEADER: usize = MAGIC.len() + 4 + GUID_LENGTH + 8;
const TRAILER: usize = 4;

/// Why bytes were not accepted as a state.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// It does not begin as a saved state does.
    #[error("this is not a saved FMU state")]
    Foreign,
    /// Written by another version of this format.
    #[error("the state has format version {0}, this FMU reads version {VERSION}")]
    Version(u32),
    /// Written by another model, or another version of the model.
    #[error("the state was saved by the FMU with GUID {found}, this one is {expected}")]
    Guid {
        /// GUID in the state.
        found: String,
        /// GUID of this FMU.
        expected: String,
    },
    /// Too short or too long.
    #[error("the state has {found} bytes, it should have {expected}: it was truncated or extended")]
    Length {
        /// Bytes given.
        found: usize,
        /// Bytes expected.
        expected: u64,
    },
    /// The checksum is wrong.
    #[error("the state's checksum is wrong: it was damaged")]
    Checksum,
    /// There is no memory for the bytes.
    #[error("there is no memory for the {0} bytes of the state")]
    Memory(usize),
    /// The payload does not decode, or decodes to a state the model cannot be in.
    #[error("the state cannot be used: {0}")]
    Content(String),
}

/// Takes the bytes of a payload: counts them, and keeps those for which there is room.
pub(crate) struct Sink<'b> {
    room: &'b mut [u8],
    count: usize,
}

impl<'b> Sink<'b> {
    pub fn new(room: &'b mut [u8]) -> Self {
        Self { room, count: 0 }
    }

    pub fn put(&mut self, value: &impl Serialize) -> postcard::Result<()> {
        postcard::serialize_with_flavor(value, self)
    }
}

impl Flavor for &mut Sink<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        let end = self.count.saturating_add(bytes.len());
        if let Some(room) = self.room.get_mut(self.count..end) {
            room.copy_from_slice(bytes);
        }
        self.count = end;
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

/// Writes a payload.
pub(crate) type Write<'w> = dyn Fn(&mut Sink<'_>) -> postcard::Result<()> + 'w;

/// How many bytes a state becomes.
pub(crate) fn encoded_size(payload: &Write<'_>) -> Result<usize, SnapshotError> {
    let mut sink = Sink::new(&mut []);
    payload(&mut sink).map_err(|e| SnapshotError::Content(e.to_string()))?;
    Ok(HEADER + sink.count + TRAILER)
}

pub(crate) fn encode(guid: &str, payload: &Write<'_>) -> Result<Vec<u8>, SnapshotError> {
    let size = encoded_size(payload)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(size).map_err(|_| SnapshotError::Memory(size))?;
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    let mut padded = [b' '; GUID_LENGTH];
    for (to, from) in padded.iter_mut().zip(guid.bytes()) {
        *to = from;
    }
    bytes.extend_from_slice(&padded);
    bytes.extend_from_slice(&((size - HEADER - TRAILER) as u64).to_le_bytes());
    bytes.resize(size - TRAILER, 0);
    let mut sink = Sink::new(&mut bytes[HEADER..]);
    payload(&mut sink).map_err(|e| SnapshotError::Content(e.to_string()))?;
    if sink.count != sink.room.len() {
        return Err(SnapshotError::Content("it serialises differently each time".into()));
    }
    bytes.extend_from_slice(&checksum(&bytes).to_le_bytes());
    Ok(bytes)
}

/// The payload of what [`encode`] has made.
pub(crate) fn payload<'b>(guid: &str, bytes: &'b [u8]) -> Result<&'b [u8], SnapshotError> {
    let (magic, rest) = bytes.split_first_chunk::<8>().ok_or(SnapshotError::Foreign)?;
    if magic != MAGIC {
        return Err(SnapshotError::Foreign);
    }
    let too_short = SnapshotError::Length { found: bytes.len(), expected: (HEADER + TRAILER) as u64 };
    let (version, rest) = rest.split_first_chunk::<4>().ok_or_else(|| too_short.clone())?;
    let version = u32::from_le_bytes(*version);
    if version != VERSION {
        return Err(SnapshotError::Version(version));
    }
    let (found, rest) = rest.split_first_chunk::<GUID_LENGTH>().ok_or_else(|| too_short.clone())?;
    if found.trim_ascii_end() != guid.as_bytes() {
        let found = String::from_utf8_lossy(found).into_owned();
        return Err(SnapshotError::Guid { found, expected: guid.to_owned() });
    }
    let (length, rest) = rest.split_first_chunk::<8>().ok_or(too_short)?;
    let length = u64::from_le_bytes(*length);
    let expected = length.saturating_add((HEADER + TRAILER) as u64);
    if bytes.len() as u64 != expected {
        return Err(SnapshotError::Length { found: bytes.len(), expected });
    }
    // The length was just checked, so the two parts exist.
    let Some((payload, sum)) = rest.split_last_chunk::<TRAILER>() else {
        return Err(SnapshotError::Length { found: bytes.len(), expected });
    };
    let covered = bytes.len() - TRAILER;
    if checksum(&bytes[..covered]) != u32::from_le_bytes(*sum) {
        return Err(SnapshotError::Checksum);
    }
    Ok(payload)
}

/// A part of a payload, and what comes after it.
pub(crate) fn part<T: DeserializeOwned>(payload: &[u8]) -> Result<(T, &[u8]), SnapshotError> {
    postcard::take_from_bytes(payload).map_err(|e| SnapshotError::Content(e.to_string()))
}

/// Checks that nothing comes after a payload's last part.
pub(crate) fn finish(rest: &[u8]) -> Result<(), SnapshotError> {
    if rest.is_empty() { Ok(()) } else { Err(SnapshotError::Content(format!("{} bytes are left over", rest.len()))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GUID: &str = "{00000000-0000-0000-0000-000000000000}";

    fn encode(guid: &str, state: &impl Serialize) -> Result<Vec<u8>, SnapshotError> {
        super::encode(guid, &|sink| sink.put(state))
    }

    fn decode<S: DeserializeOwned>(guid: &str, bytes: &[u8]) -> Result<S, SnapshotError> {
        let (state, rest) = part(payload(guid, bytes)?)?;
        finish(rest)?;
        Ok(state)
    }

    #[test]
    fn round_trip() {
        let bytes = encode(GUID, &(1_u8, vec![0.5_f64, f64::NAN])).unwrap();
        let (a, b): (u8, Vec<f64>) = decode(GUID, &bytes).unwrap();
        assert_eq!((a, b[0]), (1, 0.5));
        assert!(b[1].is_nan());
    }

    #[test]
    fn every_truncation_is_refused() {
        let bytes = encode(GUID, &vec![0.5_f64; 3]).unwrap();
        for n in 0..bytes.len() {
            decode::<Vec<f64>>(GUID, &bytes[..n]).unwrap_err();
        }
    }

    #[test]
    fn every_flipped_bit_is_refused() {
        let mut bytes = encode(GUID, &vec![0.5_f64; 3]).unwrap();
        for bit in 0..8 * bytes.len() {
            bytes[bit / 8] ^= 1 << (bit % 8);
            decode::<Vec<f64>>(GUID, &bytes).unwrap_err();
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        decode::<Vec<f64>>(GUID, &bytes).unwrap();
    }

    #[test]
    fn another_models_state_is_refused() {
        let bytes = encode(GUID, &0.5_f64).unwrap();
        let other = GUID.replace('0', "1");
        assert!(matches!(decode::<f64>(&other, &bytes), Err(SnapshotError::Guid { .. })));
    }
}

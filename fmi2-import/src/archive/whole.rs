//! Entries that are inflated in one piece, which takes two thirds of the time of a stream: all but the very large ones.

use std::fs::File;
use std::io::{BufReader, Read};

use libdeflater::{Decompressor, crc32};
use zip::{CompressionMethod, ZipArchive};

/// An entry of more bytes, packed or unpacked, is a stream: memory for all of it at once would be a waste.
const LARGEST: u64 = 16 << 20;
/// A byte of a deflated entry stands for this many at most: 258 for two bits.
const MOST_OF_A_BYTE: u64 = 1032;
/// What an entry that cannot be packed may be longer than its content.
const OVERHEAD: u64 = 4096;

/// An entry is not what the directory of the archive says of it.
#[derive(Debug, PartialEq, Eq)]
pub struct Untrue;

/// The content of an entry, if it has at most `most` bytes and is one of those that are inflated in one piece. Whatever else it is, nothing
/// is decided about it here: who reads it as a stream finds out.
///
/// # Errors
/// When the entry is not in every respect what the archive says of it. That was work for nothing, which nobody should do again and again.
pub fn content(zip: &mut ZipArchive<BufReader<File>>, index: usize, most: u64) -> Result<Option<Vec<u8>>, Untrue> {
    let Ok(mut entry) = zip.by_index_raw(index) else { return Ok(None) };
    if entry.compression() != CompressionMethod::Deflated || entry.encrypted() {
        return Ok(None);
    }
    let (size, packed_size, sum) = (entry.size(), entry.compressed_size(), entry.crc32());
    // Thousands of entries that share their bytes may promise much and hold little: what is read and made is bounded by the content.
    if size > most.min(LARGEST) || packed_size > size + OVERHEAD || size / MOST_OF_A_BYTE > packed_size {
        return Ok(None);
    }
    let (Some(mut packed), Some(mut content)) = (room(packed_size), room(size)) else { return Ok(None) };
    entry.read_to_end(&mut packed).map_err(|_| Untrue)?;
    content.resize(usize::try_from(size).map_err(|_| Untrue)?, 0);
    let length = Decompressor::new().deflate_decompress(&packed, &mut content).map_err(|_| Untrue)?;
    if length as u64 == size && crc32(&content) == sum { Ok(Some(content)) } else { Err(Untrue) }
}

/// Memory for so many bytes, if there is any: a stream needs less.
fn room(bytes: u64) -> Option<Vec<u8>> {
    let mut room = Vec::new();
    room.try_reserve_exact(usize::try_from(bytes).ok()?).ok()?;
    Some(room)
}

#[cfg(test)]
mod tests {
    use std::io::{Seek, Write};

    use zip::write::SimpleFileOptions;
    use zip::{CompressionMethod, ZipWriter};

    use super::*;

    const TEXT: &[u8] = b"the same again and again, the same again and again, the same again and again";
    /// What a header of the directory begins with, and where in it the checksum and both sizes are.
    const HEADER: &[u8] = b"PK\x01\x02";
    const SUM: usize = 16;
    const PACKED_SIZE: usize = 20;
    const SIZE: usize = 24;

    /// An archive of one entry, and where the header of its directory begins.
    fn packed(method: CompressionMethod) -> (Vec<u8>, usize) {
        let mut writer = ZipWriter::new(std::io::Cursor::new(Vec::new()));
        writer.start_file("a", SimpleFileOptions::default().compression_method(method)).unwrap();
        writer.write_all(TEXT).unwrap();
        let bytes = writer.finish().unwrap().into_inner();
        let header = bytes.windows(4).position(|window| window == HEADER).unwrap();
        (bytes, header)
    }

    fn opened(bytes: &[u8]) -> ZipArchive<BufReader<File>> {
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(bytes).unwrap();
        file.rewind().unwrap();
        ZipArchive::new(BufReader::new(file)).unwrap()
    }

    /// An archive of one entry, changed by `change` at the header of the directory.
    fn archive(method: CompressionMethod, change: impl FnOnce(&mut [u8])) -> ZipArchive<BufReader<File>> {
        let (mut bytes, header) = packed(method);
        change(&mut bytes[header..]);
        opened(&bytes)
    }

    #[test]
    fn bytes_that_belong_to_no_content_are_not_read() {
        // Bytes behind the end of the content, as many as the directory wants: here, zeros.
        let bytes = |count: u64| {
            let (mut bytes, header) = packed(CompressionMethod::Deflated);
            let mut directory = bytes.split_off(header);
            let packed = u64::from(u32::from_le_bytes(directory[PACKED_SIZE..][..4].try_into().unwrap()));
            directory[PACKED_SIZE..][..4].copy_from_slice(&u32::try_from(packed + count).unwrap().to_le_bytes());
            let end = directory.windows(4).position(|window| window == b"PK\x05\x06").unwrap();
            let place = u32::try_from(header as u64 + count).unwrap();
            directory[end + 16..][..4].copy_from_slice(&place.to_le_bytes());
            bytes.resize(header + usize::try_from(count).unwrap(), 0);
            bytes.extend(directory);
            opened(&bytes)
        };
        let size = TEXT.len() as u64;
        assert_eq!(content(&mut bytes(OVERHEAD / 2), 0, size), Ok(Some(TEXT.to_vec())));
        assert_eq!(content(&mut bytes(OVERHEAD + size), 0, size), Ok(None));
    }

    #[test]
    fn only_what_the_archive_says_the_truth_about_is_content() {
        let deflated = |change: fn(&mut [u8])| archive(CompressionMethod::Deflated, change);
        let size = TEXT.len() as u64;
        assert_eq!(content(&mut deflated(|_| {}), 0, size), Ok(Some(TEXT.to_vec())));
        assert_eq!(content(&mut deflated(|_| {}), 0, size - 1), Ok(None));
        assert_eq!(content(&mut deflated(|header| header[SUM] ^= 1), 0, size), Err(Untrue));
        assert_eq!(content(&mut deflated(|header| header[SIZE] += 1), 0, size + 1), Err(Untrue));
        assert_eq!(content(&mut deflated(|header| header[SIZE] -= 1), 0, size), Err(Untrue));
        assert_eq!(content(&mut archive(CompressionMethod::Stored, |_| {}), 0, size), Ok(None));
        assert_eq!(content(&mut deflated(|_| {}), 1, size), Ok(None));
    }
}

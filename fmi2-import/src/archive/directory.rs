//! The directory at the end of a zip archive, entry by entry. The zip reader keeps only the last of several entries with one name.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// What the header of each entry begins with.
const SIGNATURE: &[u8; 4] = b"PK\x01\x02";
/// Bytes of a header before the name.
const HEADER: usize = 46;
/// Where in it the lengths of name, extra fields and comment are, two bytes each.
const LENGTHS: usize = 28;

/// The name of the first file that the directory, which begins at this byte, names again. `None` if there is none, or if it
/// has no more than the `known` entries of different names. Folders may be there several times.
///
/// # Errors
/// When it cannot be read.
pub fn named_twice(path: &Path, start: u64, known: usize) -> io::Result<Option<Vec<u8>>> {
    let mut file = BufReader::new(File::open(path)?);
    let mut count = 0;
    file.seek(SeekFrom::Start(start))?;
    while let Some((name, rest)) = next(&mut file)? {
        count += 1;
        file.seek_relative(i64::from(name) + rest)?;
    }
    if count <= known {
        return Ok(None);
    }
    let mut names = HashSet::with_capacity(known);
    file.seek(SeekFrom::Start(start))?;
    while let Some((length, rest)) = next(&mut file)? {
        let mut name = vec![0; length.into()];
        file.read_exact(&mut name)?;
        file.seek_relative(rest)?;
        if !matches!(name.last(), Some(b'/' | b'\\')) && names.contains(&name) {
            return Ok(Some(name));
        }
        names.insert(name);
    }
    Ok(None)
}

/// The length of the next entry's name, and of what follows it; `None` behind the last entry.
fn next(file: &mut impl Read) -> io::Result<Option<(u16, i64)>> {
    let mut header = [0; HEADER];
    // What ends a directory may be shorter than an entry of it.
    file.read_exact(&mut header[..SIGNATURE.len()])?;
    if !header.starts_with(SIGNATURE) {
        return Ok(None);
    }
    file.read_exact(&mut header[SIGNATURE.len()..])?;
    let length = |place: usize| u16::from_le_bytes([header[LENGTHS + place], header[LENGTHS + place + 1]]);
    Ok(Some((length(0), i64::from(length(2)) + i64::from(length(4)))))
}

//! The `.npz` of numpy: an archive with one `.npy` of version 1.0 per array (numpy.lib.format).

use std::io::{Cursor, Write};

use grasp_plant::nalgebra::DMatrix;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::cli::Failure;

/// Magic, version, length of the header, header: padded so that data begin at a multiple of 64.
fn npy(kind: &str, shape: &str, fortran: bool, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': {shape}, }}");
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    header.extend(std::iter::repeat_n(' ', length - 1 - header.len()));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(length).unwrap_or(u16::MAX).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

/// The file with these matrices, and these names as arrays of text.
pub fn file(matrices: &[(&str, DMatrix<f64>)], names: &[(&str, Vec<&str>)]) -> Result<Vec<u8>, Failure> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut add = |name: &str, content: &[u8]| {
        zip.start_file(format!("{name}.npy"), options).map_err(Failure::failed)?;
        zip.write_all(content).map_err(Failure::failed)
    };
    for (name, matrix) in matrices {
        let data: Vec<u8> = matrix.iter().flat_map(|value| value.to_le_bytes()).collect();
        add(name, &npy("<f8", &format!("({}, {})", matrix.nrows(), matrix.ncols()), true, &data))?;
    }
    for (name, values) in names {
        // numpy's texts are of one length, in UTF-32, filled up with zeros.
        let width = values.iter().map(|value| value.chars().count()).max().unwrap_or(1).max(1);
        let code = |value: &&str| {
            let mut codes: Vec<u32> = value.chars().map(u32::from).collect();
            codes.resize(width, 0);
            codes.into_iter().flat_map(u32::to_le_bytes).collect::<Vec<u8>>()
        };
        let data: Vec<u8> = values.iter().flat_map(code).collect();
        add(name, &npy(&format!("<U{width}"), &format!("({},)", values.len()), false, &data))?;
    }
    Ok(zip.finish().map_err(Failure::failed)?.into_inner())
}

//! MATLAB's format 5, uncompressed, as documented by its vendor ("MAT-File Format", R2019b): a header of 128 bytes, then
//! one element per variable. Numbers are little-endian, matrices column by column, every element padded to 8 bytes.

use grasp_plant::nalgebra::DMatrix;

// Types of data.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
// Classes of arrays.
const CELL: u32 = 1;
const CHAR: u32 = 4;
const NUMBERS: u32 = 6;

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let size = u32::try_from(data.len()).unwrap_or(u32::MAX);
    let mut bytes = [kind.to_le_bytes(), size.to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// An array: flags, dimensions, name, then its content.
fn array(class: u32, shape: [usize; 2], name: &str, content: &[u8]) -> Vec<u8> {
    let flags = [class.to_le_bytes(), 0u32.to_le_bytes()].concat();
    let shape = shape.map(|size| i32::try_from(size).unwrap_or(i32::MAX).to_le_bytes()).concat();
    let parts = [element(UINT32, &flags), element(INT32, &shape), element(INT8, name.as_bytes()), content.to_vec()];
    element(MATRIX, &parts.concat())
}

fn numbers(name: &str, matrix: &DMatrix<f64>) -> Vec<u8> {
    // nalgebra stores column by column too.
    let data: Vec<u8> = matrix.iter().flat_map(|value| value.to_le_bytes()).collect();
    array(NUMBERS, [matrix.nrows(), matrix.ncols()], name, &element(DOUBLE, &data))
}

fn text(text: &str) -> Vec<u8> {
    let data: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    array(CHAR, [1, data.len() / 2], "", &element(UINT16, &data))
}

/// The file with these matrices, and these names as columns of cells.
pub fn file(matrices: &[(&str, DMatrix<f64>)], names: &[(&str, Vec<&str>)]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, dual-arm grasp as a linear system".to_vec();
    bytes.resize(116, b' ');
    bytes.resize(124, 0);
    bytes.extend(0x0100u16.to_le_bytes());
    bytes.extend(b"IM");
    for (name, matrix) in matrices {
        bytes.extend(numbers(name, matrix));
    }
    for (name, values) in names {
        let cells: Vec<u8> = values.iter().flat_map(|value| text(value)).collect();
        bytes.extend(array(CELL, [values.len(), 1], name, &cells));
    }
    bytes
}

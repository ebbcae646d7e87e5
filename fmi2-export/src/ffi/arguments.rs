//! What the host passes as pointers, checked and turned into slices and strings.

use std::ffi::{CStr, c_char};

use crate::slave::Refusal;

/// A C array to read. An empty one may be null.
///
/// # Safety
/// If not null, `pointer` must be valid for reads of `length` elements for the duration of the call.
pub unsafe fn slice<'a, T>(pointer: *const T, length: usize, what: &str) -> Result<&'a [T], Refusal> {
    if length == 0 {
        return Ok(&[]);
    }
    check(pointer, length, what)?;
    // SAFETY: not null, aligned, not larger than an allocation can be; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// A C array to write. An empty one may be null.
///
/// # Safety
/// If not null, `pointer` must be valid for writes of `length` initialised elements for the duration of the call.
pub unsafe fn slice_mut<'a, T>(pointer: *mut T, length: usize, what: &str) -> Result<&'a mut [T], Refusal> {
    if length == 0 {
        return Ok(&mut []);
    }
    check(pointer, length, what)?;
    // SAFETY: as above.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) })
}

fn check<T>(pointer: *const T, length: usize, what: &str) -> Result<(), Refusal> {
    if pointer.is_null() {
        return Err(Refusal::error(format!("{what} is a null pointer")));
    }
    if !pointer.is_aligned() {
        return Err(Refusal::error(format!("{what} is not aligned")));
    }
    if length > isize::MAX as usize / size_of::<T>() {
        return Err(Refusal::error(format!("{what} cannot have {length} elements")));
    }
    Ok(())
}

/// A place for one result.
///
/// # Safety
/// If not null, `pointer` must be valid for writes.
pub unsafe fn place<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut T, Refusal> {
    // SAFETY: one element; the rest is the caller's promise.
    let place = unsafe { slice_mut(pointer, 1, what) }?;
    Ok(&mut place[0])
}

/// A C string.
///
/// # Safety
/// If not null, `pointer` must point to a string that ends in a zero byte.
pub unsafe fn string<'a>(pointer: *const c_char, what: &str) -> Result<&'a CStr, Refusal> {
    if pointer.is_null() {
        return Err(Refusal::error(format!("{what} is a null pointer")));
    }
    // SAFETY: not null; the rest is the caller's promise.
    Ok(unsafe { CStr::from_ptr(pointer) })
}

/// A C string in UTF-8.
///
/// # Safety
/// As [`string`].
pub unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Result<&'a str, Refusal> {
    // SAFETY: the caller's promise.
    unsafe { string(pointer, what) }?.to_str().map_err(|_| Refusal::error(format!("{what} is not UTF-8")))
}

/// An array of C strings.
///
/// # Safety
/// As [`slice`] for the array and [`string`] for each element.
pub unsafe fn strings<'a>(pointer: *const *const c_char, length: usize, what: &str) -> Result<Vec<&'a CStr>, Refusal> {
    // SAFETY: the caller's promise.
    unsafe { slice(pointer, length, what)?.iter().map(|s| string(*s, what)).collect() }
}

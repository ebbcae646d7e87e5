//! What the host passes as pointers, checked and turned into slices and strings.
#![allow(clippy::inline_always)] // On the way of every step, in a crate that is compiled for size.

use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;

use crate::out::Out;
use crate::status::Refusal;

/// A C array to read. An empty one may be null.
///
/// # Safety
/// If not null, `pointer` must be valid for reads of `length` elements for the duration of the call.
#[inline(always)]
pub unsafe fn slice<'a, T>(pointer: *const T, length: usize, what: &str) -> Result<&'a [T], Refusal> {
    if length == 0 {
        return Ok(&[]);
    }
    check(pointer, length, what)?;
    // SAFETY: not null, aligned, not larger than an allocation can be; the rest is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, length) })
}

/// A C array to write results to, which need not be initialised. An empty one may be null.
///
/// # Safety
/// If not null, `pointer` must be valid for writes of `length` elements for the duration of the call.
#[inline(always)]
pub unsafe fn out<'a, T: Copy>(pointer: *mut T, length: usize, what: &str) -> Result<Out<'a, T>, Refusal> {
    if length == 0 {
        return Ok(Out::new(&mut []));
    }
    check(pointer, length, what)?;
    // SAFETY: not null, aligned, not larger than an allocation can be; `MaybeUninit` needs no values there; the rest is the
    // caller's promise.
    Ok(Out::new(unsafe { std::slice::from_raw_parts_mut(pointer.cast::<MaybeUninit<T>>(), length) }))
}

/// Value references, and values to read: as [`slice`] for both.
///
/// # Safety
/// As [`slice`].
pub unsafe fn values<'a>(vr: *const u32, value: *const f64, length: usize) -> Result<(&'a [u32], &'a [f64]), Refusal> {
    // SAFETY: the caller's promise.
    unsafe { Ok((slice(vr, length, "vr")?, slice(value, length, "value")?)) }
}

/// Value references, and places for values: as [`slice`] and [`out`].
///
/// # Safety
/// As [`slice`] and [`out`].
pub unsafe fn places<'a>(vr: *const u32, value: *mut f64, length: usize) -> Result<(&'a [u32], Out<'a, f64>), Refusal> {
    // SAFETY: the caller's promise.
    unsafe { Ok((slice(vr, length, "vr")?, out(value, length, "value")?)) }
}

/// Whether both pointers pass [`check`]. Those of empty arrays may be null all the same.
#[inline(always)]
pub fn are_right(vr: *const u32, value: *const f64) -> bool {
    // One look at the last bits of both.
    const { assert!(align_of::<f64>() == 2 * align_of::<u32>()) };
    let aligned = (vr.addr() << 1 | value.addr()) & (align_of::<f64>() - 1) == 0;
    aligned && !vr.is_null() && !value.is_null()
}

/// The same as [`values`], of pointers that [are right](are_right), if there can be so many.
///
/// # Safety
/// As [`slice`], and both are right.
#[inline(always)]
pub unsafe fn right_values<'a>(vr: *const u32, value: *const f64, length: usize) -> Option<(&'a [u32], &'a [f64])> {
    // SAFETY: as in `slice`.
    can_be(length)
        .then(|| unsafe { (std::slice::from_raw_parts(vr, length), std::slice::from_raw_parts(value, length)) })
}

/// The same as [`places`], likewise.
///
/// # Safety
/// As [`slice`] and [`out`], and both are right.
#[inline(always)]
pub unsafe fn right_places<'a>(vr: *const u32, value: *mut f64, length: usize) -> Option<(&'a [u32], Out<'a, f64>)> {
    // SAFETY: as in `slice` and `out`.
    can_be(length).then(|| unsafe {
        let places = std::slice::from_raw_parts_mut(value.cast::<MaybeUninit<f64>>(), length);
        (std::slice::from_raw_parts(vr, length), Out::new(places))
    })
}

/// Whether there can be so many numbers.
#[inline(always)]
fn can_be(length: usize) -> bool {
    length <= isize::MAX as usize / size_of::<f64>()
}

#[inline(always)]
fn check<T>(pointer: *const T, length: usize, what: &str) -> Result<(), Refusal> {
    if pointer.is_null() || !pointer.is_aligned() || length > isize::MAX as usize / size_of::<T>() {
        return Err(unusable(pointer.addr(), align_of::<T>(), length, what));
    }
    Ok(())
}

/// What is wrong with a pointer, once for all types. It finds that out anew, so that nothing is prepared for it on the way of a step.
#[cold]
#[inline(never)]
fn unusable(address: usize, alignment: usize, length: usize, what: &str) -> Refusal {
    Refusal::error(if address == 0 {
        format!("{what} is a null pointer")
    } else if address.is_multiple_of(alignment) {
        format!("{what} cannot have {length} elements")
    } else {
        format!("{what} is not aligned")
    })
}

/// A variable of the host, which has a value already.
///
/// # Safety
/// If not null, `pointer` must be valid for reads and writes, and its target initialised.
pub unsafe fn initialized<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut T, Refusal> {
    check(pointer, 1, what)?;
    // SAFETY: not null, aligned; the rest is the caller's promise.
    Ok(unsafe { &mut *pointer })
}

/// A C string.
///
/// # Safety
/// If not null, `pointer` must point to a string that ends in a zero byte.
pub unsafe fn string<'a>(pointer: *const c_char, what: &str) -> Result<&'a CStr, Refusal> {
    if pointer.is_null() {
        return Err(unusable(0, 1, 0, what));
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

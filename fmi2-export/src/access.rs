//! The types that variables can have, and how a value of each is read and written.

use crate::enumeration::Enumeration;
use crate::place::Place;

/// A value as FMI's 32-bit integer, or what is wrong with it: a model can compute what such an integer cannot hold.
pub(crate) type Narrowed = Result<i32, String>;

/// Where a variable's value is, by base type.
pub(crate) enum Access {
    /// Of an `f64`.
    Real(Place),
    /// Of an integer of some type.
    Integer(Place, Whole),
    /// Of a `bool`.
    Boolean(Place),
    /// Of a `String`.
    String(Place),
    /// Of an enumeration.
    Enumeration(Place, Whole, EnumerationKind),
}

/// A type whose values are whole numbers to FMI. The pointers are to a value of that type, as references are.
#[derive(Clone, Copy)]
pub(crate) struct Whole {
    pub get: unsafe fn(*const ()) -> Narrowed,
    /// Whether it can have this value.
    pub set: unsafe fn(*mut (), i32) -> bool,
    pub fits: fn(i32) -> bool,
}

/// What `<TypeDefinitions>` says of an enumeration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnumerationKind {
    /// Name of the type.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Names and descriptions, numbered from 1.
    pub items: &'static [(&'static str, &'static str)],
}

/// Types a variable can have: `f64`, integers, `bool`, `String` and enumerations made by
/// [`enumeration!`](crate::enumeration).
pub trait Scalar: Sized + sealed::Sealed + 'static {
    /// What is at a place where a value of this type is.
    #[doc(hidden)]
    #[allow(private_interfaces)]
    fn access(place: Place) -> Access;
}

/// What a [`Field`](crate::Field) can hold that is declared: one value, or an array of values, which becomes as many variables.
pub trait Shape: sealed::Shaped {
    #[doc(hidden)]
    type Element: Scalar;
    /// How many elements there are; `None` if it is no array.
    #[doc(hidden)]
    const LENGTH: Option<usize>;
}

impl<T: Scalar> Shape for T {
    type Element = T;
    const LENGTH: Option<usize> = None;
}

impl<T: Scalar, const N: usize> Shape for [T; N] {
    type Element = T;
    const LENGTH: Option<usize> = Some(N);
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for bool {}
    impl Sealed for String {}
    impl<E: crate::enumeration::Enumeration> Sealed for E {}

    pub trait Shaped {}
    impl<T: Sealed> Shaped for T {}
    impl<T: Sealed, const N: usize> Shaped for [T; N] {}
}

macro_rules! scalar {
    ($type:ty, $access:ident) => {
        #[allow(private_interfaces)]
        impl Scalar for $type {
            fn access(place: Place) -> Access {
                Access::$access(place)
            }
        }
    };
}

scalar!(f64, Real);
scalar!(bool, Boolean);
scalar!(String, String);

/// Rust's integer types, as far as FMI's 32-bit integers reach into them.
macro_rules! integer {
    ($($type:ty),*) => { $(
        impl sealed::Sealed for $type {}

        #[allow(private_interfaces)]
        impl Scalar for $type {
            fn access(place: Place) -> Access {
                unsafe fn get(value: *const ()) -> Narrowed {
                    // SAFETY: the caller's promise.
                    let value = unsafe { *value.cast::<$type>() };
                    i32::try_from(value).map_err(|_| format!("{value} does not fit into the 32 bits of FMI's integers"))
                }
                unsafe fn set(place: *mut (), value: i32) -> bool {
                    let value = <$type>::try_from(value).ok();
                    if let Some(value) = value {
                        // SAFETY: the caller's promise.
                        unsafe { *place.cast::<$type>() = value };
                    }
                    value.is_some()
                }
                Access::Integer(place, Whole { get, set, fits: |value| <$type>::try_from(value).is_ok() })
            }
        }
    )* };
}

integer!(u8, i16, u16, i32, u32, i64, u64, usize);

#[allow(private_interfaces)]
impl<E: Enumeration> Scalar for E {
    fn access(place: Place) -> Access {
        unsafe fn get<E: Enumeration>(value: *const ()) -> Narrowed {
            // SAFETY: the caller's promise.
            item_number(unsafe { *value.cast::<E>() })
        }
        unsafe fn set<E: Enumeration>(place: *mut (), value: i32) -> bool {
            let item = item::<E>(value);
            if let Some(item) = item {
                // SAFETY: the caller's promise.
                unsafe { *place.cast::<E>() = item };
            }
            item.is_some()
        }
        let whole = Whole { get: get::<E>, set: set::<E>, fits: |value| item::<E>(value).is_some() };
        let kind = EnumerationKind { name: E::NAME, description: E::DESCRIPTION, items: E::ITEMS };
        Access::Enumeration(place, whole, kind)
    }
}

/// The item of this number.
fn item<E: Enumeration>(number: i32) -> Option<E> {
    E::VALUES.get(usize::try_from(number.checked_sub(1)?).ok()?).copied()
}

/// Position of an enumeration's value among its items, from 1 as FMI counts.
fn item_number<E: Enumeration>(value: E) -> Narrowed {
    let position = E::VALUES.iter().position(|item| *item == value);
    position.and_then(|i| i32::try_from(i + 1).ok()).ok_or_else(|| format!("its value is no item of {}", E::NAME))
}

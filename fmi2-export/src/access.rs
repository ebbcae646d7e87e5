//! Typed access to the fields that variables live in.

use std::sync::Arc;

use crate::enumeration::Enumeration;

/// The way from a model to a value in it.
pub(crate) type Lens<M, T> = Arc<dyn Fn(&mut M) -> &mut T + Send + Sync>;

type Getter<M, T> = Box<dyn Fn(&mut M) -> T + Send + Sync>;
/// A value as FMI's 32-bit integer, or what is wrong with it: a model can compute what such an integer cannot hold.
type Narrowed = Result<i32, String>;
type Setter<M, T> = Box<dyn Fn(&mut M, T) -> bool + Send + Sync>;

/// The way to a variable's value, by base type.
pub(crate) enum Access<M> {
    Real(Lens<M, f64>),
    Integer { get: Getter<M, Narrowed>, set: Setter<M, i32>, fits: fn(i32) -> bool },
    Boolean(Lens<M, bool>),
    String(Lens<M, String>),
    Enumeration { get: Getter<M, Narrowed>, set: Setter<M, i32>, kind: EnumerationKind },
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
pub trait Scalar: Sized + sealed::Sealed {
    #[doc(hidden)]
    #[allow(private_interfaces)]
    fn access<M: 'static>(field: impl Fn(&mut M) -> &mut Self + Send + Sync + 'static) -> Access<M>;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for bool {}
    impl Sealed for String {}
    impl<E: crate::enumeration::Enumeration> Sealed for E {}
}

macro_rules! scalar {
    ($type:ty, $access:ident) => {
        #[allow(private_interfaces)]
        impl Scalar for $type {
            fn access<M: 'static>(field: impl Fn(&mut M) -> &mut Self + Send + Sync + 'static) -> Access<M> {
                Access::$access(Arc::new(field))
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
            fn access<M: 'static>(field: impl Fn(&mut M) -> &mut Self + Send + Sync + 'static) -> Access<M> {
                let field = Arc::new(field);
                let shared = Arc::clone(&field);
                Access::Integer {
                    get: Box::new(move |model| {
                        let value = *field(model);
                        i32::try_from(value).map_err(|_| format!("{value} does not fit into the 32 bits of FMI's integers"))
                    }),
                    set: Box::new(move |model, value| match Self::try_from(value) {
                        Ok(value) => {
                            *shared(model) = value;
                            true
                        }
                        Err(_) => false,
                    }),
                    fits: |value| Self::try_from(value).is_ok(),
                }
            }
        }
    )* };
}

integer!(u8, i16, u16, i32, u32, i64, u64, usize);

#[allow(private_interfaces)]
impl<E: Enumeration> Scalar for E {
    fn access<M: 'static>(field: impl Fn(&mut M) -> &mut Self + Send + Sync + 'static) -> Access<M> {
        let field = Arc::new(field);
        let shared = Arc::clone(&field);
        Access::Enumeration {
            get: Box::new(move |model| item_number(*field(model))),
            set: Box::new(move |model, value| {
                match value.checked_sub(1).and_then(|i| E::VALUES.get(usize::try_from(i).ok()?)) {
                    Some(item) => {
                        *shared(model) = *item;
                        true
                    }
                    None => false,
                }
            }),
            kind: EnumerationKind { name: E::NAME, description: E::DESCRIPTION, items: E::ITEMS },
        }
    }
}

/// Position of an enumeration's value among its items, from 1 as FMI counts.
fn item_number<E: Enumeration>(value: E) -> Narrowed {
    let position = E::VALUES.iter().position(|item| *item == value);
    position.and_then(|i| i32::try_from(i + 1).ok()).ok_or_else(|| format!("its value is no item of {}", E::NAME))
}

//! Enumeration types.

/// A Rust enumeration that can be a variable's type. Implemented by [`enumeration!`](crate::enumeration).
///
/// FMI numbers the items from 1, in the order of [`VALUES`](Enumeration::VALUES).
pub trait Enumeration: Copy + PartialEq + Send + Sync + 'static {
    /// Name of the type.
    const NAME: &'static str;
    /// What the type is for.
    const DESCRIPTION: &'static str;
    /// Name and description of each item.
    const ITEMS: &'static [(&'static str, &'static str)];
    /// The values, in the order of the items.
    const VALUES: &'static [Self];
}

/// Defines an enumeration that can be a variable's type.
///
/// ```
/// use fmi2_export::Enumeration;
/// fmi2_export::enumeration! {
///     /// Integration method
///     pub enum Method {
///         #[default]
///         Euler = "euler": "Explicit Euler method",
///         Exact = "exact": "Matrix exponential",
///     }
/// }
/// assert_eq!(Method::ITEMS[1].0, "exact");
/// ```
#[macro_export]
macro_rules! enumeration {
    (
        #[doc = $description:literal]
        $visibility:vis enum $name:ident {
            $( $(#[$attribute:meta])* $variant:ident = $item:literal : $text:literal ),+ $(,)?
        }
    ) => {
        #[doc = $description]
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, $crate::serde::Serialize, $crate::serde::Deserialize)]
        #[serde(crate = "fmi2_export::serde")]
        $visibility enum $name {
            $( #[doc = $text] $(#[$attribute])* $variant ),+
        }

        impl $crate::Enumeration for $name {
            const NAME: &'static str = ::core::stringify!($name);
            const DESCRIPTION: &'static str = $description.trim_ascii();
            const ITEMS: &'static [(&'static str, &'static str)] = &[ $( ($item, $text) ),+ ];
            const VALUES: &'static [Self] = &[ $( Self::$variant ),+ ];
        }
    };
}

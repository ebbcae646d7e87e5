//! The ways in which components exchange signals, and their names.

use std::fmt;

use serde::de::{Deserializer, Error, Visitor};
use serde::{Deserialize, Serialize, Serializer};

/// How components exchange their signals.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Coupling {
    /// All at once: signals arrive one step late.
    Jacobi,
    /// One after the other: each gets the newest signals.
    #[default]
    GaussSeidel,
}

/// Names in scenario files, on the command line and in JSON, in the order of [`Coupling::ALL`].
const NAMES: &[&str] = &["jacobi", "gauss-seidel"];

impl Coupling {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Jacobi, Self::GaussSeidel];

    /// The name in scenario files, on the command line and in JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        NAMES[self as usize]
    }

    /// The one of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|coupling| coupling.name() == name)
    }

    /// The name in a sentence.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Jacobi => "Jacobi",
            Self::GaussSeidel => "Gauss–Seidel",
        }
    }

    /// Its meaning, in one sentence.
    #[must_use]
    pub fn summary(self) -> &'static str {
        match self {
            Self::Jacobi => "All exchange at once: every signal arrives one step late",
            Self::GaussSeidel => "One after the other with the newest signals: a controller answers without delay",
        }
    }
}

impl Serialize for Coupling {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Coupling {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Name;
        impl Visitor<'_> for Name {
            type Value = Coupling;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "one of {}", NAMES.join(", "))
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<Coupling, E> {
                Coupling::from_name(name).ok_or_else(|| E::unknown_variant(name, NAMES))
            }
        }
        deserializer.deserialize_str(Name)
    }
}

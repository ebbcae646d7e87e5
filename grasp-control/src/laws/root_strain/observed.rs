//! Hub 1, hub 2 and the object side by side: what the observers know.

use crate::blocks::four::{LANES, Lanes};
use crate::blocks::observer::Observer;
use serde::{Deserialize, Serialize};

/// The observers of all three coordinates in lanes, number by number; stored as if they were one after the other.
///
/// A step stores each number of all three at once, so what reads two of them right after it need not wait until they are in the processor's
/// cache. The lane to spare stays at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "[Observer; 3]", into = "[Observer; 3]")]
pub(super) struct Observers {
    pub position: Lanes,
    pub rate: Lanes,
    pub disturbance: Lanes,
}

impl From<[Observer; 3]> for Observers {
    #[inline]
    fn from(observers: [Observer; 3]) -> Self {
        let (mut position, mut rate, mut disturbance) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for (i, observer) in observers.into_iter().enumerate() {
            (position[i], rate[i], disturbance[i]) = (observer.position, observer.rate, observer.disturbance);
        }
        Self { position, rate, disturbance }
    }
}

impl From<Observers> for [Observer; 3] {
    #[inline]
    fn from(observers: Observers) -> Self {
        [0, 1, 2].map(|i| observers.of(i))
    }
}

impl Observers {
    /// The observer of a coordinate.
    #[inline]
    pub fn of(&self, i: usize) -> Observer {
        Observer { position: self.position[i], rate: self.rate[i], disturbance: self.disturbance[i] }
    }

    /// The observers one after the other.
    #[inline]
    pub fn all(&self) -> [Observer; 3] {
        (*self).into()
    }
}

//! What a saved state holds of a network.

use super::{Layout, Network, WIDTHS};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What is stored of a network.
#[derive(Serialize, Deserialize)]
pub(super) struct Stored {
    layout: Layout,
    width: f64,
    weights: Vec<f64>,
}

/// A stored network that is none.
#[derive(Debug, Error)]
#[error("stored network has an impossible layout, width or number of weights")]
pub(super) struct StoredNetworkError;

impl<const D: usize> From<Network<D>> for Stored {
    fn from(network: Network<D>) -> Self {
        Self { layout: network.layout, width: network.width, weights: network.weights().collect() }
    }
}

impl<const D: usize> TryFrom<Stored> for Network<D> {
    type Error = StoredNetworkError;

    fn try_from(Stored { layout, width, weights }: Stored) -> Result<Self, StoredNetworkError> {
        if !layout.is_possible(D) || !WIDTHS.contains(&width) || weights.len() != layout.nodes(D) {
            return Err(StoredNetworkError);
        }
        let mut network = Self::new(layout, width);
        for (node, weight) in weights.into_iter().enumerate() {
            network.set_weight(node, weight);
        }
        Ok(network)
    }
}

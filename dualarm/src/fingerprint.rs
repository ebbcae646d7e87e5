//! The fingerprint of a search or a study: an object whose parts must all be equal for it to be continued.

use serde_json::Value;

/// The first part of two fingerprints that differs.
pub(crate) fn difference(one: &Value, other: &Value) -> String {
    let mut keys = other.as_object().into_iter().flatten().map(|(key, _)| key);
    keys.find(|key| one.get(key.as_str()) != other.get(key.as_str())).map_or("content".into(), Clone::clone)
}

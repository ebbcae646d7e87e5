//! The data that plants with equal parameters share: one [`Model`] in the process.
//!
//! The registry keeps nothing alive: a model is freed with the last plant that uses it, and then the registry is empty too,
//! so that a library of plants can be unloaded without a trace.

use super::model::Model;
use crate::parameters::{Parameters, Start};
use std::fmt::Write;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// A model, by a hash of its parameters.
type Entry = (u64, Weak<Model>);

static MODELS: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

/// The model of these parameters, made now if no plant has it. It does not depend on start values.
pub(super) fn model(parameters: &Parameters) -> Arc<Model> {
    let key = Parameters { start: Start::default(), ..parameters.clone() };
    let hash = hash(&key);
    if let Some(model) = find(hash, &key) {
        return model;
    }
    // Not while others wait: two plants that are made at the same time may each have its own.
    let model = Arc::new(Model::new(key));
    lock().push((hash, Arc::downgrade(&model)));
    model
}

fn find(hash: u64, key: &Parameters) -> Option<Arc<Model>> {
    let alike: Vec<Arc<Model>> =
        lock().iter().filter(|(other, _)| *other == hash).filter_map(|(_, model)| model.upgrade()).collect();
    // Compared and dropped without the lock, because dropping the last owner of a model takes the lock.
    alike.into_iter().find(|model| model.parameters == *key)
}

impl Drop for Model {
    fn drop(&mut self) {
        let mut models = lock();
        models.retain(|(_, model)| model.strong_count() > 0);
        if models.is_empty() {
            *models = Vec::new();
        }
    }
}

/// Locks. The data stay consistent if a thread panics.
fn lock() -> MutexGuard<'static, Vec<Entry>> {
    MODELS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A hash of the printed parameters, and so of all their bits (FNV-1a).
fn hash(parameters: &Parameters) -> u64 {
    struct Hash(u64);
    impl Write for Hash {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            for byte in text.bytes() {
                self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
            Ok(())
        }
    }
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    // Writing to a number does not fail.
    let _ = write!(hash, "{parameters:?}");
    hash.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same for equal parameters, whatever the start; another for others, for a zero of another sign too.
    #[test]
    fn equal_parameters_share_and_nothing_is_kept() {
        let parameters = Parameters { object_mass: 0.123_456_789, kelvin_voigt: 0.0, ..Parameters::default() };
        let start = Start { theta: [0.1, 0.2], ..Start::default() };
        let first = model(&parameters);
        assert!(Arc::ptr_eq(&first, &model(&Parameters { start, ..parameters.clone() })));
        for other in [
            Parameters { kelvin_voigt: -0.0, ..parameters.clone() },
            Parameters { object_mass: 0.123_456_789_000_000_01, ..parameters.clone() },
        ] {
            assert!(!Arc::ptr_eq(&first, &model(&other)));
        }
        let hash = hash(&Parameters { start: Start::default(), ..parameters });
        assert_eq!(lock().iter().filter(|(other, _)| *other == hash).count(), 1);
        drop(first);
        assert_eq!(lock().iter().filter(|(other, _)| *other == hash).count(), 0);
    }
}

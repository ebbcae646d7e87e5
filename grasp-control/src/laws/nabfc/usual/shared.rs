//! Equal tables of all laws in the process are one: a host with many instances keeps their constants in the processor's cache once.
//!
//! Nothing is kept alive: a table goes with the last law that uses it, and then the list is empty too, so that a library of laws can be
//! unloaded without a trace.

use super::table::Table;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

static TABLES: Mutex<Vec<Weak<Shared>>> = Mutex::new(Vec::new());

/// A table in the list.
#[derive(Debug)]
#[repr(align(64))] // Registers are then not read from two lines of the cache.
pub(super) struct Shared(Table);

impl Deref for Shared {
    type Target = Table;

    #[inline]
    fn deref(&self) -> &Table {
        &self.0
    }
}

/// The table with the bits of this one.
pub(super) fn shared(table: &Table) -> Arc<Shared> {
    let alike = tables().iter().filter_map(Weak::upgrade).collect::<Vec<_>>();
    // Compared and dropped without the lock, because dropping the last owner of a table takes the lock.
    if let Some(known) = alike.into_iter().find(|known| known.bits() == table.bits()) {
        return known;
    }
    let new = Arc::new(Shared(*table));
    tables().push(Arc::downgrade(&new));
    new
}

impl Drop for Shared {
    fn drop(&mut self) {
        let mut tables = tables();
        tables.retain(|table| table.strong_count() > 0);
        if tables.is_empty() {
            *tables = Vec::new();
        }
    }
}

/// Locks. The list stays consistent if a thread panics.
fn tables() -> MutexGuard<'static, Vec<Weak<Shared>>> {
    TABLES.lock().unwrap_or_else(PoisonError::into_inner)
}

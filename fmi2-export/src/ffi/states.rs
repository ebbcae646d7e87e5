//! C functions that save and restore states.
#![allow(clippy::missing_safety_doc)] // One rule for all of them: see the module `ffi`.

use std::ffi::c_char;
use std::ptr;

use super::arguments::{initialized, out, slice};
use super::instance::{Instance, call, guarded};
use super::types::{Component, FmuState};
use crate::slave::Snapshot;
use crate::status::{Refusal, Status};

/// `fmi2GetFMUstate`.
#[inline(never)]
pub unsafe fn get_fmu_state(component: Component, state: *mut FmuState) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let state = initialized(state, "FMUstate")?;
            let snapshot = save(instance);
            let owner = component.addr();
            if state.is_null() {
                *state = ptr::without_provenance_mut(instance.library.states.keep(owner, snapshot));
            } else {
                let before = instance.library.states.replace(state.addr(), owner, snapshot);
                keep(instance, before.ok_or_else(unknown_state)?);
            }
            Ok(())
        })
    }
}

/// `fmi2SetFMUstate`. The state may have been saved by another instance of the same FMU.
#[inline(never)]
pub unsafe fn set_fmu_state(component: Component, state: FmuState) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let snapshot = instance.library.states.snapshot(state.addr()).ok_or_else(unknown_state)?;
            instance.slave.restore(&snapshot)
        })
    }
}

/// `fmi2FreeFMUstate`.
#[inline(never)]
pub unsafe fn free_fmu_state(component: Component, state: *mut FmuState) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let state = initialized(state, "FMUstate")?;
            // "If a null pointer is provided, the call is ignored."
            if !state.is_null() {
                let forgotten = instance.library.states.forget(state.addr()).ok_or_else(unknown_state)?;
                *state = ptr::null_mut();
                keep(instance, forgotten);
            }
            Ok(())
        })
    }
}

/// Saves the state, in the memory of the one that was freed last if it can be.
fn save(instance: &mut Instance) -> Snapshot {
    if let Some(mut spare) = instance.slave.spare.take() {
        if guarded(|| instance.slave.save_in(&mut spare)) == Ok(true) {
            return spare;
        }
        discard(spare);
    }
    instance.slave.save()
}

/// Keeps a state that nobody needs any more for its memory: hosts that try steps save one before each.
fn keep(instance: &mut Instance, freed: Snapshot) {
    if let Some(before) = instance.slave.spare.replace(freed) {
        discard(before);
    }
}

/// A panic in the destructor of a state that the host knows no more is no reason for a call to fail.
fn discard(snapshot: Snapshot) {
    let _ = guarded(|| drop(snapshot));
}

fn unknown_state() -> Refusal {
    Refusal::error("FMUstate is none that fmi2GetFMUstate or fmi2DeSerializeFMUstate returned, or it was freed")
}

fn encode(instance: &Instance, state: FmuState) -> Result<Vec<u8>, Refusal> {
    let snapshot = instance.library.states.snapshot(state.addr()).ok_or_else(unknown_state)?;
    instance.slave.encode(&snapshot)
}

/// `fmi2SerializedFMUstateSize`.
#[inline(never)]
pub unsafe fn serialized_fmu_state_size(component: Component, state: FmuState, size: *mut usize) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let size = out(size, 1, "size")?;
            let snapshot = instance.library.states.snapshot(state.addr()).ok_or_else(unknown_state)?;
            size.write([instance.slave.encoded_size(&snapshot)?]);
            Ok(())
        })
    }
}

/// `fmi2SerializeFMUstate`.
#[inline(never)]
pub unsafe fn serialize_fmu_state(component: Component, state: FmuState, bytes: *mut c_char, size: usize) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let encoded = encode(instance, state)?;
            let bytes = out(bytes.cast::<u8>(), size, "serializedState")?;
            // A longer one would hold bytes that nobody has written, which fmi2DeSerializeFMUstate would have to trust.
            if bytes.len() != encoded.len() {
                let message = format!(
                    "the state has {} bytes, size is {size}: fmi2SerializedFMUstateSize tells how many it needs",
                    encoded.len()
                );
                return Err(Refusal::error(message));
            }
            bytes.write(encoded);
            Ok(())
        })
    }
}

/// `fmi2DeSerializeFMUstate`.
#[inline(never)]
pub unsafe fn deserialize_fmu_state(
    component: Component,
    bytes: *const c_char,
    size: usize,
    state: *mut FmuState,
) -> Status {
    // SAFETY: the host's promise, see the module `ffi`.
    unsafe {
        call(component, |instance| {
            let bytes = slice(bytes.cast::<u8>(), size, "serializedState")?;
            let state = initialized(state, "FMUstate")?;
            let snapshot = instance.slave.decode(bytes)?;
            let owner = component.addr();
            // As with `fmi2GetFMUstate`, a state that was returned before is replaced.
            if state.is_null() || instance.library.states.replace(state.addr(), owner, snapshot.clone()).is_none() {
                *state = ptr::without_provenance_mut(instance.library.states.keep(owner, snapshot));
            }
            Ok(())
        })
    }
}

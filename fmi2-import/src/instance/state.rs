//! Saved states: `fmi2GetFMUstate` and its kin.

use std::ffi::c_void;
use std::ptr::{self, NonNull};

use super::{Instance, Result};
use crate::error::CallError;
use crate::floating_point::guarded;
use crate::library::Status;

/// A state of an instance, saved inside the slave. Give it back with [`Instance::free_state`].
#[derive(Debug)]
pub struct SavedState {
    state: *mut c_void,
    owner: NonNull<c_void>,
}

impl Instance {
    /// `fmi2GetFMUstate`: saves the state inside the slave.
    ///
    /// # Errors
    /// When the slave cannot.
    pub fn save_state(&mut self) -> Result<SavedState> {
        let function = self.optional("fmi2GetFMUstate", self.functions().get_fmu_state, |interface| {
            interface.can_get_and_set_fmu_state
        })?;
        let mut state = ptr::null_mut();
        // SAFETY: living component; a null state asks for a new one.
        let status = guarded(|| unsafe { function(self.component.as_ptr(), &raw mut state) });
        self.check("fmi2GetFMUstate", status)?;
        Ok(SavedState { state, owner: self.component })
    }

    /// `fmi2SetFMUstate`: restores a saved state.
    ///
    /// # Errors
    /// When the slave cannot, or the state is another instance's.
    pub fn restore_state(&mut self, saved: &SavedState) -> Result<Status> {
        let function = self.optional("fmi2SetFMUstate", self.functions().set_fmu_state, |interface| {
            interface.can_get_and_set_fmu_state
        })?;
        self.own(saved)?;
        // SAFETY: living component, its own state.
        let status = guarded(|| unsafe { function(self.component.as_ptr(), saved.state) });
        self.check("fmi2SetFMUstate", status)
    }

    /// `fmi2FreeFMUstate`: frees a saved state.
    ///
    /// # Errors
    /// When the slave cannot, or the state is another instance's.
    #[allow(clippy::needless_pass_by_value)] // it must not be used again
    pub fn free_state(&mut self, saved: SavedState) -> Result<Status> {
        let function = self.optional("fmi2FreeFMUstate", self.functions().free_fmu_state, |interface| {
            interface.can_get_and_set_fmu_state
        })?;
        self.own(&saved)?;
        let mut state = saved.state;
        // SAFETY: living component, its own state.
        let status = guarded(|| unsafe { function(self.component.as_ptr(), &raw mut state) });
        self.check("fmi2FreeFMUstate", status)
    }

    /// `fmi2SerializeFMUstate`: a saved state as bytes.
    ///
    /// # Errors
    /// When the slave cannot, or the state is another instance's.
    pub fn serialize_state(&mut self, saved: &SavedState) -> Result<Vec<u8>> {
        let size_of =
            self.optional("fmi2SerializedFMUstateSize", self.functions().serialized_fmu_state_size, |interface| {
                interface.can_serialize_fmu_state
            })?;
        let serialize = self.optional("fmi2SerializeFMUstate", self.functions().serialize_fmu_state, |interface| {
            interface.can_serialize_fmu_state
        })?;
        self.own(saved)?;
        let mut size = 0;
        // SAFETY: living component, its own state.
        let status = guarded(|| unsafe { size_of(self.component.as_ptr(), saved.state, &raw mut size) });
        self.check("fmi2SerializedFMUstateSize", status)?;
        let mut bytes = vec![0; size];
        // SAFETY: living component, its own state, an array of the stated length.
        let status = guarded(|| unsafe { serialize(self.component.as_ptr(), saved.state, bytes.as_mut_ptr(), size) });
        self.check("fmi2SerializeFMUstate", status)?;
        Ok(bytes)
    }

    /// `fmi2DeSerializeFMUstate`: a saved state from bytes.
    ///
    /// # Errors
    /// When the slave cannot.
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<SavedState> {
        let function =
            self.optional("fmi2DeSerializeFMUstate", self.functions().deserialize_fmu_state, |interface| {
                interface.can_serialize_fmu_state
            })?;
        let mut state = ptr::null_mut();
        // SAFETY: living component, an array of the stated length.
        let status =
            guarded(|| unsafe { function(self.component.as_ptr(), bytes.as_ptr(), bytes.len(), &raw mut state) });
        self.check("fmi2DeSerializeFMUstate", status)?;
        Ok(SavedState { state, owner: self.component })
    }

    fn own(&self, saved: &SavedState) -> Result<()> {
        if saved.owner == self.component {
            Ok(())
        } else {
            Err(CallError::ForeignState { instance: self.name.clone() })
        }
    }
}

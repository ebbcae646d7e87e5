//! The C interface: each function checks what the host passes, then calls the instance.
//!
//! A call on an instance on which another one is running, be it from its logger or from another thread, is answered with
//! `fmi2Error` and has no effect.
//!
//! A panic never leaves these functions: it is caught, logged as an error, and the instance answers `fmi2Error` from then
//! on to all but reading, `fmi2Reset`, `fmi2SetFMUstate` and `fmi2FreeInstance`.
//!
//! # Memory
//! Where a host decides how much is needed (strings, bytes of a state) a failed allocation is an error. Copies of the model,
//! which `fmi2GetFMUstate`, `fmi2Instantiate` and tuning make, are allocated by the model's `Clone`: without memory for them
//! Rust ends the process, as it does everywhere.
//!
//! # Safety
//! What C cannot check, the host has to guarantee, as the standard demands of it: a component comes from
//! `fmi2Instantiate` and has not been freed, is used by one thread at a time, arrays have the stated lengths, strings
//! end in a zero byte. Its logger returns: one that jumps over these functions (`longjmp`) leaves the instance busy for good, and
//! one that throws a C++ exception ends the process. Null pointers are refused. Handles of saved states are never dereferenced.

mod arguments;
mod barrier;
mod exchange;
mod guard;
mod instance;
mod life;
mod logger;
mod panics;
mod states;
mod step;
pub mod types;
mod values;

/// The functions behind the C symbols that [`export!`](crate::export) defines. Most are not inlined there: here they are compiled for size, in
/// the library's own crate for speed. That also suits the calls of a step, whose lists are short: their loops are not unrolled.
pub mod calls {
    pub use super::exchange::*;
    pub use super::life::*;
    pub use super::states::*;
    pub use super::step::*;
    pub use super::values::*;
}

//! A communication step in which one component comes after the other and all wires carry reals: the calls of the FMUs and little else.
//!
//! What is known of the signals' age is not looked at here: each component's inputs are set in its turn, since an earlier component, or
//! itself in the step before, has given new outputs.

// As in `bus.rs`.
#![allow(clippy::inline_always)]

use super::bus::Port;
use super::components::Slave;
use fmi2_import::{CallError, Environment};

/// A component's index, and why it did not go on. It is a small result, because it is passed on at every step.
pub(super) type Obstacle = (usize, Box<CallError>);

/// Sets the inputs of these components and fetches what is watched of them.
///
/// # Errors
/// When an FMU refuses.
#[inline(always)]
pub(super) fn watch(
    components: &mut [Slave],
    (signals, ports): (&mut [f64], &[Port]),
    host: Environment,
    watched: &[usize],
) -> Result<(), Obstacle> {
    for index in watched {
        let (component, port) = (&mut components[*index], &ports[*index]);
        let turn = component.instance.together_in(host, |slave| {
            let mut calls = || {
                port.write(signals, slave)?;
                port.watch(signals, slave)
            };
            calls().map_err(Box::new)
        });
        turn.map_err(|source| (*index, source))?;
    }
    Ok(())
}

/// One step of all components, from `time` to `time + size`. The first one may have its inputs already.
///
/// It is one call, so that none is left inside: in both of its callers, the compiler would make a call of each component's turn.
///
/// # Errors
/// When an FMU does not complete it.
#[inline(never)]
pub(super) fn step(
    components: &mut [Slave],
    (signals, ports): (&mut [f64], &[Port]),
    host: Environment,
    (time, size): (f64, f64),
    has_first_inputs: bool,
) -> Result<(), Obstacle> {
    let mut has_inputs = has_first_inputs;
    // Two iterators in one would be put together by a call, at every step.
    let mut ports = ports.iter();
    for (index, component) in components.iter_mut().enumerate() {
        let Some(port) = ports.next() else { break };
        let turn = component.instance.together_in(host, |slave| {
            let mut calls = || {
                if !has_inputs {
                    port.write(signals, slave)?;
                }
                slave.do_step(time, size)?;
                port.read(signals, slave)
            };
            calls().map_err(Box::new)
        });
        turn.map_err(|source| (index, source))?;
        has_inputs = false;
    }
    Ok(())
}

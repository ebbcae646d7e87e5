//! Handles of saved states: freed ones, and those of others.

use std::ptr::{null, null_mut, without_provenance_mut};

use crate::common::misbehaving::instantiate;
use crate::common::{Fmu, OK};
use crate::{refused, stepping};

#[test]
fn handles_of_states_that_are_not_there_are_refused() {
    let fmu = Fmu::load("misbehaving");
    let slave = stepping(&fmu);
    let c = slave.component;
    let mut freed = slave.save();
    let copy = freed;
    assert_eq!(fmu.fmi2FreeFMUstate(c, &mut freed), OK);
    assert!(freed.is_null());
    assert_eq!(fmu.fmi2FreeFMUstate(c, &mut freed), OK, "null is ignored");
    let of_the_dead = {
        let other = stepping(&fmu);
        other.save()
    };
    let garbage = without_provenance_mut(0xdead_beef);
    let own = std::ptr::from_ref(&slave).cast_mut().cast();
    let says = "FMUstate is none that";
    for handle in [copy, of_the_dead, garbage, own, c] {
        let mut again = handle;
        refused(&slave, says, || fmu.fmi2FreeFMUstate(c, &mut again));
        assert_eq!(again, handle);
        refused(&slave, says, || fmu.fmi2SetFMUstate(c, handle));
        refused(&slave, says, || fmu.fmi2GetFMUstate(c, &mut again));
        refused(&slave, says, || fmu.fmi2SerializedFMUstateSize(c, handle, &mut 0));
        refused(&slave, says, || fmu.fmi2SerializeFMUstate(c, handle, [0; 9999].as_mut_ptr(), 9999));
    }
    refused(&slave, says, || fmu.fmi2SetFMUstate(c, null_mut()));
    refused(&slave, "FMUstate is a null pointer", || fmu.fmi2GetFMUstate(c, null_mut()));
    refused(&slave, "FMUstate is a null pointer", || fmu.fmi2FreeFMUstate(c, null_mut()));
    let blob = slave.blob();
    refused(&slave, "FMUstate is a null pointer", || {
        fmu.fmi2DeSerializeFMUstate(c, blob.as_ptr(), blob.len(), null_mut())
    });
    refused(&slave, "serializedState is a null pointer", || fmu.fmi2DeSerializeFMUstate(c, null(), 9, &mut null_mut()));
    refused(&slave, "this is not a saved FMU state", || fmu.fmi2DeSerializeFMUstate(c, null(), 0, &mut null_mut()));
    let state = slave.save();
    refused(&slave, "size is a null pointer", || fmu.fmi2SerializedFMUstateSize(c, state, null_mut()));
    refused(&slave, "serializedState is a null pointer", || fmu.fmi2SerializeFMUstate(c, state, null_mut(), 999));
    let mut short = vec![7; blob.len() - 1];
    refused(&slave, "bytes, size is", || fmu.fmi2SerializeFMUstate(c, state, short.as_mut_ptr(), short.len()));
    assert!(short.iter().all(|byte| *byte == 7), "nothing is written");
}

#[test]
fn states_of_another_model_in_the_same_library_are_refused() {
    let fmu = Fmu::load("two_models");
    let guids = fmu.guids();
    let (integrator, counter) = (fmu.instantiate(&guids[0]), fmu.instantiate(&guids[1]));
    let state = counter.save();
    refused(&integrator, "belongs to another model", || fmu.fmi2SetFMUstate(integrator.component, state));
    refused(&integrator, "belongs to another model", || {
        fmu.fmi2SerializedFMUstateSize(integrator.component, state, &mut 0)
    });
    refused(&integrator, "the state was saved by the FMU with GUID", || integrator.load(&counter.blob()));
    // The place of a state can be used again by any instance; it is that instance's then.
    let mut reused = state;
    assert_eq!(fmu.fmi2GetFMUstate(integrator.component, &mut reused), OK);
    assert_eq!(reused, state);
    assert_eq!(fmu.fmi2SetFMUstate(integrator.component, reused), OK);
    refused(&counter, "belongs to another model", || fmu.fmi2SetFMUstate(counter.component, reused));
}

#[test]
fn states_of_another_library_are_refused() {
    let (fmu, other) = (Fmu::load("misbehaving"), Fmu::load("two_models"));
    let (slave, stranger) = (stepping(&fmu), other.instantiate(&other.guids()[0]));
    // The same number of states on both sides: what is counted alike must not be mistaken for one's own.
    let (own, foreign) = (slave.save(), stranger.save());
    let mut again = foreign;
    let says = "FMUstate is none that";
    refused(&slave, says, || fmu.fmi2SetFMUstate(slave.component, foreign));
    refused(&slave, says, || fmu.fmi2FreeFMUstate(slave.component, &mut again));
    refused(&slave, says, || fmu.fmi2GetFMUstate(slave.component, &mut again));
    assert_eq!(fmu.fmi2SetFMUstate(slave.component, own), OK);
    assert_eq!(other.fmi2SetFMUstate(stranger.component, foreign), OK);
}

#[test]
fn a_state_is_shared_by_the_instances_of_a_model_while_its_owner_lives() {
    let fmu = Fmu::load("misbehaving");
    let (a, b) = (stepping(&fmu), instantiate(&fmu));
    let mut state = a.save();
    assert_eq!(fmu.fmi2SetFMUstate(b.component, state), OK);
    assert_eq!(a.blob(), b.blob());
    assert_eq!(fmu.fmi2FreeFMUstate(b.component, &mut state), OK);
}

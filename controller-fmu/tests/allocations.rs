//! What a host calls at every communication step allocates nothing, once a step of that size has been made; and how much
//! memory an instance holds.

use std::ffi::CString;
use std::ptr::{null, null_mut};

use allocation_counter::measure;
use fmi2_export::ffi::calls;
use fmi2_export::ffi::types::{CallbackFunctions, Component, Status};

const NO_CALLBACKS: CallbackFunctions = CallbackFunctions {
    logger: None,
    allocate_memory: None,
    free_memory: None,
    step_finished: None,
    component_environment: null_mut(),
};

/// An instance in stepping mode, with the name and GUID of one of the library's models.
fn instance(guid: &str) -> Component {
    let guid = CString::new(guid).unwrap();
    // SAFETY: as a host does.
    unsafe {
        let c = calls::instantiate(
            controller_fmu::FMUS.served(),
            c"c".as_ptr(),
            1,
            guid.as_ptr(),
            null(),
            &NO_CALLBACKS,
            1,
        );
        assert_eq!(calls::setup_experiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(calls::enter_initialization_mode(c), Status::Ok);
        assert_eq!(calls::exit_initialization_mode(c), Status::Ok);
        c
    }
}

/// Inputs that move, ramps, two step sizes, the outputs and their derivatives.
fn run(c: Component, outputs: &[u32], steps: std::ops::Range<u32>, time: &mut f64) {
    let inputs: [u32; 16] = std::array::from_fn(|i| u32::try_from(i).unwrap());
    let mut values = [0.0; 64];
    let values = &mut values[..outputs.len()];
    // The commands, targets and errors have time derivatives.
    let (derived, orders) = (&outputs[..10], [1; 16]);
    for step in steps {
        let size = if step % 3 == 0 { 5e-5 } else { 1e-4 };
        let signals: [f64; 16] = std::array::from_fn(|i| 0.01 * (f64::from(step) * 0.1 + i as f64).sin());
        // SAFETY: as a host does.
        unsafe {
            assert_eq!(calls::set_real(c, inputs.as_ptr(), 16, signals.as_ptr()), Status::Ok);
            assert_eq!(calls::get_real(c, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), Status::Ok);
            if step % 4 == 0 {
                let (orders, slopes) = (orders.as_ptr(), signals.as_ptr());
                assert_eq!(calls::set_real_input_derivatives(c, inputs.as_ptr(), 16, orders, slopes), Status::Ok);
            }
            assert_eq!(calls::do_step(c, *time, size, 1), Status::Ok);
            assert_eq!(calls::get_real(c, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), Status::Ok);
            let (vr, values) = (derived.as_ptr(), values.as_mut_ptr());
            assert_eq!(calls::get_real_output_derivatives(c, vr, derived.len(), orders.as_ptr(), values), Status::Ok);
        }
        *time += size;
    }
}

/// One test only: the memory that instances share must not come from, or go with, another thread's.
#[test]
fn costs_of_memory() {
    a_step_and_its_inputs_and_outputs_allocate_nothing();
    an_instance_is_small_and_leaves_nothing_behind();
}

fn a_step_and_its_inputs_and_outputs_allocate_nothing() {
    for model in controller_fmu::FMUS.models() {
        let description = model.description().unwrap();
        // 16 inputs come first, then 10 outputs; NABFC has 12 more.
        let outputs: Vec<u32> = (16..if description.name == "NabfcController" { 38 } else { 26 }).collect();
        let c = instance(&description.guid);
        let mut time = 0.0;
        run(c, &outputs, 0..3, &mut time);
        let steps = measure(|| run(c, &outputs, 3..1000, &mut time));
        assert_eq!((steps.count_total, steps.bytes_current), (0, 0), "{}", description.name);
        // SAFETY: as a host does.
        unsafe { calls::free_instance(c) };
    }
}

/// The first instance also holds the layout, which it shares with those after it: for NABFC that of hundreds of continuous states
/// and their derivatives, with what there is to say of each.
fn an_instance_is_small_and_leaves_nothing_behind() {
    for model in controller_fmu::FMUS.models() {
        let description = model.description().unwrap();
        let outputs: Vec<u32> = (16..26).collect();
        let create = || {
            let mut component = null_mut();
            let held = measure(|| {
                component = instance(&description.guid);
                run(component, &outputs, 0..10, &mut 0.0);
            });
            (component, held.bytes_current)
        };
        let all = measure(|| {
            let (first, with_layout) = create();
            let (second, alone) = create();
            println!("{}: first instance {with_layout} bytes, another {alone} bytes", description.name);
            assert!((1..1 << 20).contains(&with_layout) && (1..16 << 10).contains(&alone));
            // SAFETY: as a host does.
            unsafe {
                calls::free_instance(first);
                calls::free_instance(second);
            }
        });
        // What is left is the panic hook, which has no size, and what the standard library keeps once.
        assert!(all.bytes_current < 1 << 10, "{} bytes stay", all.bytes_current);
    }
}

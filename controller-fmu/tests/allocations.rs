//! What a host calls at every communication step allocates nothing, once a step of that size has been made; and how much
//! memory an instance holds.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::CString;
use std::ptr::null_mut;

use fmi2_export::ffi::calls;
use fmi2_export::ffi::types::{CallbackFunctions, Component, Status};

thread_local! {
    /// Allocations so far, and bytes in use.
    static COUNTED: Cell<(usize, isize)> = const { Cell::new((0, 0)) };
}

struct Counting;

// SAFETY: passes everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let (count, bytes) = COUNTED.get();
        COUNTED.set((count + 1, bytes + layout.size().cast_signed()));
        // SAFETY: the caller's promise, here and below.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        let (count, bytes) = COUNTED.get();
        COUNTED.set((count, bytes - layout.size().cast_signed()));
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

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
        let c = calls::instantiate(&controller_fmu::FMUS, c"c".as_ptr(), 1, guid.as_ptr(), &NO_CALLBACKS, 1);
        assert_eq!(calls::setup_experiment(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(calls::enter_initialization_mode(c), Status::Ok);
        assert_eq!(calls::exit_initialization_mode(c), Status::Ok);
        c
    }
}

/// Inputs that move, ramps, two step sizes, the outputs and their derivatives.
fn run(c: Component, outputs: &[u32], steps: std::ops::Range<u32>, time: &mut f64) {
    let inputs: [u32; 14] = std::array::from_fn(|i| u32::try_from(i).unwrap());
    let mut values = [0.0; 64];
    let values = &mut values[..outputs.len()];
    // The commands, targets and errors have time derivatives.
    let (derived, orders) = (&outputs[..10], [1; 14]);
    for step in steps {
        let size = if step % 3 == 0 { 5e-5 } else { 1e-4 };
        let signals: [f64; 14] = std::array::from_fn(|i| 0.01 * (f64::from(step) * 0.1 + i as f64).sin());
        // SAFETY: as a host does.
        unsafe {
            assert_eq!(calls::set_real(c, inputs.as_ptr(), 14, signals.as_ptr()), Status::Ok);
            assert_eq!(calls::get_real(c, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), Status::Ok);
            if step % 4 == 0 {
                let (orders, slopes) = (orders.as_ptr(), signals.as_ptr());
                assert_eq!(calls::set_real_input_derivatives(c, inputs.as_ptr(), 14, orders, slopes), Status::Ok);
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
        // 14 inputs come first, then 10 outputs; NABFC has 12 more.
        let outputs: Vec<u32> = (14..if description.name == "NabfcController" { 36 } else { 24 }).collect();
        let c = instance(&description.guid);
        let mut time = 0.0;
        run(c, &outputs, 0..3, &mut time);
        let before = COUNTED.get();
        run(c, &outputs, 3..1000, &mut time);
        assert_eq!(COUNTED.get(), before, "{}", description.name);
        // SAFETY: as a host does.
        unsafe { calls::free_instance(c) };
    }
}

/// The first instance also holds the layout, which it shares with those after it.
fn an_instance_is_small_and_leaves_nothing_behind() {
    for model in controller_fmu::FMUS.models() {
        let description = model.description().unwrap();
        let outputs: Vec<u32> = (14..24).collect();
        let measure = || {
            let before = COUNTED.get().1;
            let c = instance(&description.guid);
            run(c, &outputs, 0..10, &mut 0.0);
            (c, COUNTED.get().1 - before)
        };
        let start = COUNTED.get().1;
        let (first, with_layout) = measure();
        let (second, alone) = measure();
        println!("{}: first instance {with_layout} bytes, another {alone} bytes", description.name);
        assert!(with_layout < 256 << 10 && alone < 16 << 10);
        // SAFETY: as a host does.
        unsafe {
            calls::free_instance(first);
            calls::free_instance(second);
        }
        // What is left is the panic hook, which has no size, and what the standard library keeps once.
        assert!(COUNTED.get().1 - start < 1 << 10, "{} bytes stay", COUNTED.get().1 - start);
    }
}

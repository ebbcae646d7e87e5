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
    instance_of(guid, &[])
}

/// The same with other values of Integer variables.
fn instance_of(guid: &str, settings: &[(u32, i32)]) -> Component {
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
        for (reference, value) in settings {
            assert_eq!(calls::set_integer(c, reference, 1, value), Status::Ok);
        }
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
    the_papers_law_leaves_room_for_a_plant();
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

/// 12 KiB are what a pair of plant and controller with the paper's law may take beyond what all share, and 4 KiB of them the plant. In
/// either order of calls, and where nothing moves. The system's allocator rounds up, and keeps the size of each block.
fn the_papers_law_leaves_room_for_a_plant() {
    const BESIDE_A_BLOCK: i64 = 16;
    let models = controller_fmu::FMUS.models();
    let description = models.iter().map(|model| model.description().unwrap()).find(|d| d.name == "NabfcController");
    let description = description.unwrap();
    let (_, law) = description.xml.split_once("name=\"law\" valueReference=\"").unwrap();
    let law = law.split('"').next().unwrap().parse().unwrap();
    let inputs: [u32; 16] = std::array::from_fn(|i| u32::try_from(i).unwrap());
    let commands = [16, 17, 18];
    for (moves, before, after) in [(0.0, true, false), (0.01, false, true), (0.01, true, false), (0.01, true, true)] {
        let walk = |c: Component, steps: std::ops::Range<u32>| {
            for step in steps {
                let signals: [f64; 16] = std::array::from_fn(|i| moves * (f64::from(step) * 0.1 + i as f64).sin());
                let mut values = [0.0; 3];
                // SAFETY: as a host does.
                unsafe {
                    assert_eq!(calls::set_real(c, inputs.as_ptr(), 16, signals.as_ptr()), Status::Ok);
                    if before {
                        assert_eq!(calls::get_real(c, commands.as_ptr(), 3, values.as_mut_ptr()), Status::Ok);
                    }
                    assert_eq!(calls::do_step(c, f64::from(step) * 1e-4, 1e-4, 1), Status::Ok);
                    if after {
                        assert_eq!(calls::get_real(c, commands.as_ptr(), 3, values.as_mut_ptr()), Status::Ok);
                    }
                }
            }
        };
        let create = || {
            let c = instance_of(&description.guid, &[(law, 1)]);
            walk(c, 0..20);
            c
        };
        let first = create();
        let mut second = null_mut();
        let held = measure(|| second = create());
        let bytes = held.bytes_current + BESIDE_A_BLOCK * held.count_current;
        println!("the paper's law, moves {moves}, asked before {before}, after {after}: {bytes} bytes");
        // Where there are no wide registers, activations are kept in memory.
        let has_wide_registers = is_wide();
        assert!(bytes > 0 && (!has_wide_registers || bytes <= 8 << 10), "{bytes} bytes");
        let later = measure(|| walk(first, 20..100));
        assert_eq!((later.count_total, later.bytes_current), (0, 0), "moves {moves}, before {before}, after {after}");
        // SAFETY: as a host does.
        unsafe {
            calls::free_instance(first);
            calls::free_instance(second);
        }
    }
}

fn is_wide() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

//! What the C interface costs around a model that computes next to nothing: the integrator of `two_models`.
//!
//! ```text
//! cargo build -p counted-models --profile fmu
//! cargo run --release -p fmi2-export --example call_cost -- time     ns of set, step and get, beside the same model in C
//! call_cost count integrator                                         steps; run under callgrind, as `cargo xtask counts` does
//! ```
//!
//! `time` compiles `benches/integrator.c` by the command `cc`.

use std::error::Error;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::ptr::null;
use std::time::Instant;

use libloading::Library;

#[path = "../tests/common/mod.rs"]
#[allow(missing_docs)]
mod common;

use common::{CO_SIMULATION, Callbacks, Fmu, OK};

/// Steps before counting begins, and steps that are counted.
const STEPS: [u32; 2] = [100, 4000];

/// Communication step (s): a power of two, so that the time is exact.
const SIZE: f64 = 1.0 / 1024.0;

type Component = *mut c_void;
type SetReal = unsafe extern "C" fn(Component, *const u32, usize, *const f64) -> c_int;
type GetReal = unsafe extern "C" fn(Component, *const u32, usize, *mut f64) -> c_int;
type DoStep = unsafe extern "C" fn(Component, f64, f64, c_int) -> c_int;
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> Component;
type SetupExperiment = unsafe extern "C" fn(Component, c_int, f64, f64, c_int, f64) -> c_int;

/// An integrator in a library, and the functions that a host calls at every step.
struct Integrator {
    component: Component,
    set_real: SetReal,
    do_step: DoStep,
    get_real: GetReal,
    time: f64,
    _library: Library,
}

impl Integrator {
    fn new(library: Library, guid: &CStr) -> Result<Self, Box<dyn Error>> {
        let callbacks = common::callbacks(&common::Log::default());
        // SAFETY: the functions have these types in FMI 2.0, and are called in the order that it wants.
        unsafe {
            let instantiate = *library.get::<Instantiate>("fmi2Instantiate")?;
            let setup = *library.get::<SetupExperiment>("fmi2SetupExperiment")?;
            let modes = ["fmi2EnterInitializationMode", "fmi2ExitInitializationMode"];
            let callbacks = Callbacks { logger: None, ..callbacks };
            let component =
                instantiate(c"measured".as_ptr(), CO_SIMULATION, guid.as_ptr(), null(), &raw const callbacks, 0, 0);
            assert!(!component.is_null() && setup(component, 0, 0.0, 0.0, 0, 0.0) == OK);
            for mode in modes {
                let enter = *library.get::<unsafe extern "C" fn(Component) -> c_int>(mode)?;
                assert_eq!(enter(component), OK);
            }
            let set_real = *library.get::<SetReal>("fmi2SetReal")?;
            let do_step = *library.get::<DoStep>("fmi2DoStep")?;
            let get_real = *library.get::<GetReal>("fmi2GetReal")?;
            Ok(Self { component, set_real, do_step, get_real, time: 0.0, _library: library })
        }
    }

    /// `fmi2SetReal`, `fmi2DoStep`, `fmi2GetReal`, of a variable each.
    #[inline]
    fn step(&mut self, input: f64) -> f64 {
        let mut output = 0.0;
        // SAFETY: as a host does.
        let statuses = unsafe {
            [
                (self.set_real)(self.component, &0, 1, &raw const input),
                (self.do_step)(self.component, self.time, SIZE, 1),
                (self.get_real)(self.component, &1, 1, &raw mut output),
            ]
        };
        assert!(statuses == [OK; 3]);
        self.time += SIZE;
        output
    }
}

/// What callgrind counts.
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn step_cost_counted(integrator: &mut Integrator) -> f64 {
    (0..STEPS[1]).map(|i| integrator.step(f64::from(i % 2))).sum()
}

/// Ours, as the profile `fmu` builds it.
fn ours() -> Result<Integrator, Box<dyn Error>> {
    let file = format!("{}two_models{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    // target/release/examples/call_cost
    let path = std::env::current_exe()?.ancestors().nth(3).map(|target| target.join("fmu").join(file));
    let path = path.filter(|path| path.is_file());
    let path = path.ok_or("there is no library: `cargo build -p counted-models --profile fmu` builds it")?;
    let fmu = Fmu::open(&path);
    let guid = CString::new(fmu.guids().swap_remove(0))?;
    Integrator::new(fmu.library, &guid)
}

/// The same model in C.
fn peer() -> Result<Integrator, Box<dyn Error>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/integrator.c");
    let folder = tempfile::tempdir()?;
    let library: PathBuf = folder.path().join("integrator.so");
    let cc = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
    let compiled = Command::new(cc).args(["-O3", "-shared", "-fPIC", "-o"]).arg(&library).arg(source).status();
    if !compiled.map_err(|error| format!("cc does not start: {error}"))?.success() {
        return Err("cc does not compile benches/integrator.c".into());
    }
    // SAFETY: our own library.
    Integrator::new(unsafe { Library::new(&library) }?, c"")
}

/// Nanoseconds of a step of each in the best of many batches, in turns.
fn nanoseconds<const N: usize>(mut integrators: [&mut Integrator; N]) -> [f64; N] {
    const REPETITIONS: u32 = 20_000;
    let mut best = [f64::INFINITY; N];
    for _ in 0..100 {
        for (best, integrator) in best.iter_mut().zip(&mut integrators) {
            let begin = Instant::now();
            for i in 0..REPETITIONS {
                black_box(integrator.step(f64::from(i % 2)));
            }
            *best = best.min(begin.elapsed().as_secs_f64() * 1e9 / f64::from(REPETITIONS));
        }
    }
    best
}

fn run() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut ours = ours()?;
    match arguments.as_slice() {
        ["count", "integrator", ..] => {
            for _ in 0..STEPS[0] {
                ours.step(1.0);
            }
            black_box(step_cost_counted(&mut ours));
            println!("{}", STEPS[1]);
        }
        ["time"] => {
            let mut peer = peer()?;
            assert_eq!(ours.step(0.5), peer.step(0.5), "not the same model");
            let [own, c] = nanoseconds([&mut ours, &mut peer]);
            println!("set, step and get of an integrator: {own:.1} ns; the same in C {c:.1} ns; ratio {:.2}", own / c);
        }
        _ => return Err("usage: call_cost time | count integrator".into()),
    }
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

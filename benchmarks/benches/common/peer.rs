//! The peer: the same algorithms in plain C (`benches/peer/peer.c`), compiled by the C compiler at hand and called in the same run.

use std::ffi::{c_int, c_uint, c_void};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use grasp_control::laws::nabfc::{Gains, ObjectGains, PostureGains};
use grasp_control::{Arms, References};
use libloading::Library;

use super::replay::{Replay, Steps};
use super::{COMMANDS, Case, MEASURED, Result, STEP};

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peer/peer.c");

type Access<T> = unsafe extern "C" fn(*mut c_void, *const c_uint, usize, T) -> c_int;

/// A line of a processor's cache: ours keep their numbers in whole ones, too.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Line(#[allow(dead_code)] [u8; 64]);

/// One model of the peer: its memory, and its functions.
pub struct Peer {
    memory: Vec<Line>,
    set: Access<*const f64>,
    step: unsafe extern "C" fn(*mut c_void, f64, f64) -> c_int,
    get: Access<*mut f64>,
    inputs: Vec<c_uint>,
    outputs: Vec<c_uint>,
    steps: u32,
    /// Its functions' home, which has to outlive them.
    library: Arc<Library>,
}

/// The peer's library.
#[derive(Clone)]
pub struct Peers(Arc<Library>);

impl Peers {
    /// Compiles the peer, for wide registers or for those that every processor has; `order` is the plant's, an even number.
    ///
    /// # Errors
    /// Without a C compiler, or if it does not like the source.
    pub fn compile(wide: bool, order: usize) -> Result<Self> {
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("peer.so");
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
        let mut command = Command::new(&compiler);
        // As in ours: no operation is fused with another.
        command.args(["-std=gnu11", "-O3", "-ffp-contract=off", "-Wno-psabi", "-shared", "-fPIC", "-o"]);
        command.arg(&file).arg(SOURCE).arg("-lm").args(wide.then_some("-mavx2"));
        command.arg(format!("-DGROUPS={}", order / 2));
        let output =
            command.output().map_err(|error| format!("the C compiler \"{compiler}\" cannot be run ({error})"))?;
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
        }
        // SAFETY: the library has been made of our own source and does nothing when it is loaded.
        let library = unsafe { Library::new(&file) }?;
        Ok(Self(Arc::new(library)))
    }

    /// The plant: three commands, twelve measurements.
    pub fn plant(&self) -> Result<Peer> {
        self.peer("plant", COMMANDS.len(), MEASURED.len(), &[])
    }

    /// NABFC with the paper's law: twelve measurements, three commands.
    pub fn paper(&self) -> Result<Peer> {
        self.peer("paper", MEASURED.len(), COMMANDS.len(), &paper_gains())
    }

    /// The plant or the law alone, with the inputs that the FMU is measured with.
    pub fn alone(&self, name: &str, folder: &Path) -> Result<Replay<Peer>> {
        let peer = if name == "plant" { self.plant()? } else { self.paper()? };
        let outputs = peer.outputs.len();
        Ok(Replay::new(peer, recorded(name, folder)?, outputs))
    }

    fn peer(&self, name: &str, inputs: usize, outputs: usize, gains: &[f64]) -> Result<Peer> {
        let named = |what: &str| format!("{name}_{what}");
        // SAFETY: the types are those of the functions in peer.c.
        let (size, new, set, step, get) = unsafe {
            let size = self.0.get::<unsafe extern "C" fn() -> usize>(named("size").as_bytes())?;
            let new = *self
                .0
                .get::<unsafe extern "C" fn(*mut c_void, f64, *const f64) -> *mut c_void>(named("new").as_bytes())?;
            let set = *self.0.get(named("set").as_bytes())?;
            let step = *self.0.get(named("step").as_bytes())?;
            let get = *self.0.get(named("get").as_bytes())?;
            (size(), new, set, step, get)
        };
        let mut memory = vec![Line([0; 64]); size.div_ceil(size_of::<Line>())];
        // SAFETY: the memory has the size that the model asks for, and the gains those that it reads.
        unsafe { new(memory.as_mut_ptr().cast(), STEP, gains.as_ptr()) };
        let references = |count: usize| (0..).take(count).collect();
        let library = self.0.clone();
        Ok(Peer { memory, set, step, get, inputs: references(inputs), outputs: references(outputs), steps: 0, library })
    }
}

impl Steps for Peer {
    /// Sets all inputs, makes a step, gets all outputs, with a host's looks at how each call went, as of an FMU.
    #[inline]
    fn step(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        assert!(inputs.len() == self.inputs.len() && outputs.len() == self.outputs.len());
        let model = self.memory.as_mut_ptr().cast();
        // SAFETY: the model has been made in its memory; the arrays have the lengths that are said.
        unsafe {
            assert_eq!((self.set)(model, self.inputs.as_ptr(), inputs.len(), inputs.as_ptr()), 0, "set");
            assert_eq!((self.step)(model, f64::from(self.steps) * STEP, STEP), 0, "step");
            assert_eq!((self.get)(model, self.outputs.as_ptr(), outputs.len(), outputs.as_mut_ptr()), 0, "get");
        }
        self.steps += 1;
    }
}

/// The inputs of an FMU in a coupled run.
fn recorded(name: &str, folder: &Path) -> Result<Vec<f64>> {
    match Case::new(name, folder)? {
        Case::Alone(replay) => Ok(replay.inputs),
        _ => Err("not recorded".into()),
    }
}

/// Plant and controller of the peer, with the signals of a recorded run of ours: the numbers of its plant are made up.
pub struct Pair {
    plant: Peer,
    controller: Peer,
    measured: Vec<f64>,
    commands: Vec<f64>,
    next: usize,
    outputs: [f64; 12],
    own: [f64; 3],
}

impl Pair {
    /// From the signals of [`RUN`](super::RUN) steps: what the plant gave, and what it was given.
    pub fn new(peers: &Peers, folder: &Path) -> Result<Self> {
        let (measured, commands) = (recorded("nabfc", folder)?, recorded("plant", folder)?);
        let (plant, controller) = (peers.plant()?, peers.paper()?);
        Ok(Self { plant, controller, measured, commands, next: 0, outputs: [0.0; 12], own: [0.0; 3] })
    }

    pub fn step(&mut self) {
        let (measured, commands) = (self.measured.as_chunks::<12>().0, self.commands.as_chunks::<3>().0);
        self.plant.step(&commands[self.next], &mut self.outputs);
        self.controller.step(&measured[self.next], &mut self.own);
        self.next = if self.next + 1 == commands.len() { 0 } else { self.next + 1 };
    }

    /// The largest difference of the controller's commands from ours over the recorded run, in units of the largest command of each
    /// kind: that it is the same algorithm.
    pub fn difference(&mut self) -> f64 {
        let (measured, commands) = (self.measured.as_chunks::<12>().0, self.commands.as_chunks::<3>().0);
        let (mut largest, mut difference) = ([0.0_f64; 3], [0.0_f64; 3]);
        // What the plant was given next is what the controller made of these.
        for (measured, ours) in measured.iter().zip(&commands[1..]) {
            self.controller.step(measured, &mut self.own);
            for i in 0..3 {
                largest[i] = largest[i].max(ours[i].abs());
                difference[i] = difference[i].max((self.own[i] - ours[i]).abs());
            }
        }
        (0..3).map(|i| difference[i] / largest[i]).fold(0.0, f64::max)
    }
}

/// Whether our kernels use wide registers here.
pub fn has_wide_registers() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// What `paper_new` reads: the default gains, the arms, the references.
fn paper_gains() -> Vec<f64> {
    let Gains { object, posture, sat_limit, shear_rate_bandwidth, rbf } = Gains::default();
    let (arms, reference) = (Arms::default(), References::default());
    let ObjectGains { eta, k, mu_bar, c1, epsilon1, a1, a2, gamma1, gamma2, b1, b2, m_hat_0, .. } = object;
    let mut gains = vec![eta, k, mu_bar, c1, epsilon1, a1, a2, gamma1, gamma2, b1, b2, m_hat_0];
    for posture in posture {
        let PostureGains { xi, k, mu, c3, epsilon2, a3, a4, zeta1, zeta2, g1, g2, j_hat_0, .. } = posture;
        gains.extend([xi, k, mu, c3, epsilon2, a3, a4, zeta1, zeta2, g1, g2, j_hat_0]);
    }
    assert_eq!((rbf.nodes_posture, rbf.rings_object), (5, 2), "the layout that peer.c has");
    gains.extend([sat_limit, shear_rate_bandwidth, rbf.width_posture, rbf.width_object]);
    gains.extend([rbf.position_scale, rbf.object_surface_scale, rbf.object_alpha_scale]);
    gains.extend([rbf.shear_scale, rbf.shear_rate_scale]);
    gains.extend([rbf.angle_scale, rbf.posture_surface_scale, rbf.posture_alpha_scale]);
    gains.extend([arms.ei[0], arms.ei[1], arms.length, arms.hub_distance, reference.lambda1_ref, reference.theta1_ref]);
    gains
}

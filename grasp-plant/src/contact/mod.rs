//! A grasp that can open: contacts that push and do not pull.
//!
//! # Gap and force
//! The gap between tip i and the object is g_i = σ_i (Y_i(l) − `y_M` + L/2), σ_1 = −1, σ_2 = +1, which is σ_i φ_i of (12). The
//! contact force f_i = σ_i λ_i > 0 presses. With the boundary velocity v_i(l) = `Ẏ_i(l)` of each tip as an unknown of its own
//!
//! ```text
//! m_i v̇_i(l) = −S_i + λ_i,     M ÿ_M = u + ΔF_ext − λ_1 − λ_2,     S_i = EI_i w_i'''(l) (+ its dissipative parts),
//! ```
//!
//! and a tip that touches nothing has λ_i = 0: EI_i w_i'''(l) + m_i v̇_i(l) = 0. u and the external ΔF act on the object,
//! whatever touches it: alone it is M ÿ_M = u + ΔF; with one tip, m_i + M moves; with both it is (11), m = m_1 + m_2 + M.
//!
//! # The built-in ΔF
//! ΔF = −c_F (EI_1+EI_2) Σ ẇ_i'''(l) is the paper's model of what disturbs the object *in the grasp*. Here it is there while both tips
//! touch, and gives tips and object one acceleration ΔF/m. So the motion of the closed grasp is the paper's, and no contact
//! feels ΔF: f_i has S_i and m_i (ÿ_M − ΔF/m). Nothing else would do. On the object alone it would have to go on when a tip leaves
//! (a push by an arm that does not touch), or else f_i = 0 would not mean g̈_i = 0 there: states, among them the paper's own
//! start, without any motion (closed, the force is tensile; open, the gap closes). At the tips, arm by arm, it would throw them off
//! with the momentum c_F (EI_1+EI_2) w_i'''(l), a thousandfold the energy of the impact.
//!
//! # Unilateral: 0 ≤ g_i ⟂ f_i ≥ 0
//! A side that touches has ġ_i = 0; it opens when f_i would become negative. A gap that closes ends in an impact: impulses
//! p_i ≥ 0 with ġ_i⁺ + e ġ_i⁻ ≥ 0 and p_i (ġ_i⁺ + e ġ_i⁻) = 0 on all sides that are closed (Moreau's law with Newton's e). It
//! keeps momentum, never gains energy, and has exactly one solution, also when both sides are hit at once. Below `plastic_speed`
//! e counts as zero: bounces that accumulate (their speeds fall like eⁿ, their times add up to a finite one) end in contact there.
//!
//! # Compliant: Kelvin–Voigt faces
//! A face is pressed in by δ_i ≥ 0 and resists with f_i = k δ + c δ̇. It has no mass: where the tip does not touch it, f = 0 and it
//! relaxes, δ ∝ e^{−kt/c}. Tip and face touch from when their distance σ_i φ_i + δ_i becomes zero until f_i does.
//!
//! # Exact
//! Which sides touch is a mode, and each mode is linear: [`assembly`] has its matrix, [`mode`] its exact motion and the signals that
//! may end it, [`stiff`] what decays too fast for these, [`series`] their first root, [`complementarity`] who pushes when that is not decided by continuity, [`switch`] what
//! becomes of a contact then; [`step`] puts them together, and [`endless`] says where no switch ends it. So a step has no cuts of its own: it goes from switch to switch. For a
//! solver of one's own, [`continuous`] has the same grasp as differential equations.

// A side's number stands in several arrays at once.
#![allow(clippy::needless_range_loop)]

mod assembly;
mod complementarity;
mod continuous;
mod decay;
mod endless;
mod growth;
mod impact;
mod layout;
mod mode;
mod outputs;
mod piece;
mod rates;
mod series;
mod start;
mod step;
mod stiff;
mod switch;

use crate::dynamics::Signals;
use crate::kernel::{LANES, Panels};
use crate::parameters::{ContactModel, Face, Parameters};
use crate::state::{State, StateError};
use assembly::{Assembly, Touching};
use complementarity::Delassus;
use layout::Layout;
use mode::Mode;
use nalgebra::DMatrix;
use piece::{Cache, Motion};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

pub(crate) use continuous::Relative;
pub(crate) use layout::SIGN;
pub use outputs::Contact;

/// The most coordinates.
pub(crate) const MOST_COORDINATES: usize = Layout::MOST_COORDINATES;

/// What of the contacts moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactState {
    /// Which tips touch the object.
    pub touching: [bool; 2],
    /// Distance of each tip from the object's undeformed face \[m\]: negative by as much as a face is pressed in.
    pub clearance: [f64; 2],
    /// Energy lost in impacts and in the object's faces since the start \[J\].
    pub loss: f64,
    /// How often a tip has come onto the object, by side.
    pub impacts: [u32; 2],
    /// How often a tip has left the object, by side.
    pub openings: [u32; 2],
}

/// What a plant that can open consists of, besides what it shares with one that cannot.
#[derive(Debug)]
struct Modes {
    layout: Layout,
    rigid: bool,
    /// Contacts can switch [without end](endless).
    may_not_end: bool,
    faces: [Face; 2],
    restitution: f64,
    plastic_speed: f64,
    tip_masses: [f64; 2],
    object_mass: f64,
    delassus: Delassus,
    /// By `touching[0] + 2 touching[1]`.
    by_touching: [Mode; 4],
    /// Rows of the plant's signals.
    signals: Panels,
    /// S_i from x: rows.
    shear: DMatrix<f64>,
    /// k_i/c_i \[1/s\], infinite without damping.
    relaxation: [f64; 2],
    /// Gauss rule for squares of signals.
    rule: Vec<(f64, f64)>,
    length: f64,
    tip_compliance: [f64; 2],
}

impl Modes {
    fn new(parameters: &Parameters, tip_compliance: [f64; 2]) -> Self {
        let p = parameters;
        let assembly = Assembly::new(p);
        let without_losses = p.root_uncertainty == 0.0 && p.tip_uncertainty == 0.0 && p.kelvin_voigt == 0.0;
        let rigid = p.contact_model != ContactModel::Compliant;
        let modes = [[false, false], [true, false], [false, true], [true, true]].map(|touching: Touching| {
            let damped = !rigid && (0..2).any(|i| touching[i] && p.faces[i].damping > 0.0);
            let relaxes = !rigid && touching != [true; 2];
            Mode::new(touching, assembly.layout, assembly.mode(touching), without_losses && !damped, relaxes)
        });
        Self {
            layout: assembly.layout,
            rigid,
            may_not_end: endless::may_not_end(p),
            faces: p.faces,
            restitution: p.restitution,
            plastic_speed: p.plastic_speed,
            tip_masses: p.arms.map(|arm| arm.tip_mass),
            object_mass: p.object_mass,
            delassus: Delassus::new(p.arms.map(|arm| arm.tip_mass), p.object_mass),
            by_touching: modes,
            signals: Panels::new(&assembly.signals),
            shear: DMatrix::from_rows(&assembly.shear),
            relaxation: p.faces.map(|face| face.stiffness / face.damping),
            rule: crate::basis::gauss(series::MOST_TERMS),
            length: p.length,
            tip_compliance,
        }
    }

    fn mode(&self, touching: Touching) -> &Mode {
        &self.by_touching[mode_index(touching)]
    }

    fn signals(&self, x: &[f64]) -> Signals {
        let mut rows = [[0.0; LANES]];
        self.signals.multiply(x, &mut rows);
        rows[0]
    }

    /// The rate of gap i while only the masses move, ġ = σ (v(l) − ẏ).
    fn opening_rate(&self, x: &[f64], side: usize) -> f64 {
        let tip = x[self.layout.tip(side)] / self.tip_masses[side].sqrt();
        let object = x[self.layout.object()] / self.object_mass.sqrt();
        layout::SIGN[side] * (tip - object)
    }
}

fn mode_index(touching: Touching) -> usize {
    usize::from(touching[0]) + 2 * usize::from(touching[1])
}

/// The contacts of a plant that can open, with the buffers of its steps.
#[derive(Clone, Debug)]
pub(crate) struct Contacts {
    modes: Arc<Modes>,
    cache: Cache,
    motion: Motion,
    /// (x, g, r).
    drive: Vec<f64>,
    next: State,
}

impl Contacts {
    /// The contacts and the start of a plant of valid parameters, if it can open.
    pub fn new(parameters: &Parameters, tip_compliance: [f64; 2]) -> Option<(Self, State)> {
        if parameters.contact_model == ContactModel::Bilateral {
            return None;
        }
        let modes = Modes::new(parameters, tip_compliance);
        let state = start::state(parameters, &modes);
        let drive = vec![0.0; modes.layout.drive()];
        let contacts = Self {
            modes: Arc::new(modes),
            cache: Cache::default(),
            motion: Motion::none(),
            drive,
            next: state.clone(),
        };
        Some((contacts, state))
    }

    /// The start, again.
    pub fn start(&self, parameters: &Parameters) -> State {
        start::state(parameters, &self.modes)
    }

    /// The plant's signals.
    pub fn signals(&self, coordinates: &[f64]) -> Signals {
        self.modes.signals(coordinates)
    }

    /// The longest step done in one piece \[s\].
    pub fn longest_part(&self) -> f64 {
        self.modes.by_touching.iter().map(Mode::longest_piece).fold(f64::INFINITY, f64::min)
    }

    /// Whether a state is one that this plant can be in.
    pub fn check(state: &State) -> Result<(), StateError> {
        let contact = state.contact.as_deref().ok_or(StateError::Contact)?;
        if !contact.clearance.iter().chain([&contact.loss]).all(|value| value.is_finite()) {
            return Err(StateError::NotFinite);
        }
        Ok(())
    }
}

//! The usual step: inputs that are held, networks that learn, are plain and have no ball, a low-pass. It leaves the commands that follow it
//! behind. Commands that are asked for before it are found in the same way; what the step has in common with them it then [finds](evaluation)
//! and leaves no commands behind, for the next ones are of other inputs.
//!
//! Lanes are the three loops, so whatever all of them do is done once: hub 1, hub 2, and the object in the last one. Inputs of
//! networks come as one row for each component and are turned into one column for each network; the star's last inputs, which the shear rates
//! move, as one row for each component with the points of the step in its lanes. Activations are in registers only. Number by number these are the
//! operations of the [general way](super::kernel) in the same order, so the same bits.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]
// It is for wide registers, which other processors than x86-64 have not: narrow ones are too few for it.
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]

mod evaluation;
mod keep;
mod shared;
mod signals;
mod table;
#[cfg(test)]
mod tests;

pub(super) use keep::{Keep, Known};

use super::Nabfc;
use super::estimator::Learner;
use super::object_loop::ObjectLoop;
use super::posture_loop::PostureLoop;
use crate::blocks::exponential::powers;
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::Wide;
use crate::blocks::four::{Four, LANES};
use crate::blocks::lowpass::LowPass;
use crate::blocks::rbf::{
    GRID, GridActivations, STAR, grid_output, learn_grid, learn_star, star_output, still_activations, still_output,
};
use crate::signals::{Commands, Inputs};
use evaluation::Evaluation;
use signals::Signals;
use std::sync::atomic::{Ordering, compiler_fence};
use table::{Learning, Table};

/// Hubs: the first lanes.
const HUBS: usize = 2;

/// The lane of the object.
const OBJECT: usize = LANES - 1;

/// What a step changes.
struct State<'a> {
    hubs: [Learner<'a, GRID>; HUBS],
    object: Learner<'a, STAR>,
    filters: &'a mut LowPass,
}

/// Ends a part of a step: the compiler takes from memory behind it what is needed behind it. There are more constants than registers, and it
/// would have to put those aside that it takes before.
#[inline(always)]
fn next_part() {
    compiler_fence(Ordering::SeqCst);
}

/// The step, and the commands that follow it.
///
/// First come the exponentials and tanh, which are long chains of operations that wait for each other: only together do they keep a processor
/// busy. The grids come last: there are many operations that wait for few others, and the next step can begin meanwhile.
#[inline(always)]
fn step<V: Four>(table: &Table, state: State<'_>, inputs: &Inputs) -> Commands {
    let State { hubs: [hub1, hub2], object, filters } = state;
    next_part();
    let signals = Signals::<V>::of(table, inputs);
    let Signals { s, exponents: [z1, z2, still], .. } = signals;
    let rests = filters.state() == inputs.measured.tip_shear_dot;
    let learning = &table.learning[usize::from(rests)];
    let ([x1, x2, x3, _], regressors) = signals.moving(table, inputs, follow(table, filters, inputs));
    next_part();
    let of_z = powers([z1, z2]);
    let [still, of_first, of_second] = powers([still, x1, x2]);
    let [of_end] = powers([x3]);
    let tanh = signals.tanh(table).now();
    next_part();

    // (37), and the output of the network afterwards.
    let surfaces = s.lanes();
    let least = table.least[HUBS];
    let [decay, weight1, weight2, _] = learning.star_weights;
    let shares = [weight1 * surfaces[OBJECT], weight2 * surfaces[OBJECT]];
    let [heights, moving] = &table.star_heights;
    let still = still_activations(heights, still);
    let still = learn_star(object.weights, &still, (moving, least), [of_first, of_second], (decay, shares));
    let of_star = star_output(object.weights, moving, least, of_end, still).now();
    let [regressor1, regressor2, regressor3, _] = regressors.lanes();
    let scalars = Scalars {
        bounds: [hub1.bound, hub2.bound, object.bound],
        inertias: [hub1.inertia, hub2.inertia, object.inertia],
    };
    let [bounds, inertias] = scalars.step(learning, &signals, tanh, [regressor1, regressor2]);
    next_part();

    // (55), likewise.
    let mut of_grids = [V::splat(0.0); HUBS];
    for (hub, w) in [hub1.weights, hub2.weights].into_iter().enumerate() {
        let [decay, weight] = table.grid_weights[hub];
        let at = GridActivations::new(&table.grid_heights[hub], table.least[hub], of_z[hub]);
        of_grids[hub] = learn_grid(w, at, (decay, weight * surfaces[hub]));
    }
    next_part();
    let [a, b, c, d] = V::columns([of_grids[0], of_grids[1], V::splat(0.0), of_star]);
    let outputs = (a + b) + (c + d);
    signals.commands(table, inputs, tanh, regressor3, [outputs, bounds, inertias])
}

/// The low-pass: where its filters are at the nodes of the step and at its end, where they stay.
#[inline(always)]
fn follow<V: Four>(table: &Table, filters: &mut LowPass, inputs: &Inputs) -> [V; 2] {
    let follow = V::load(&table.follow);
    let [state1, state2] = filters.state();
    let [rate1, rate2] = inputs.measured.tip_shear_dot;
    let first = V::splat(state1) + V::splat(rate1 - state1) * follow;
    let second = V::splat(state2) + V::splat(rate2 - state2) * follow;
    filters.settle([first.lanes()[2], second.lanes()[2]]);
    [first, second]
}

/// Bounds and inertias of hub 1, of hub 2 and of the object.
struct Scalars<'a> {
    bounds: [&'a mut f64; 3],
    inertias: [&'a mut f64; 3],
}

/// In the lanes of their loops.
#[inline(always)]
fn in_lanes<V: Four>([hub1, hub2, object]: [&f64; 3]) -> V {
    V::load(&[*hub1, *hub2, 0.0, *object])
}

impl Scalars<'_> {
    /// (38), (39), (56) and (57), with the object's regressors at the nodes of the step: bounds and inertias afterwards.
    #[inline(always)]
    fn step<V: Four>(self, learning: &Learning, signals: &Signals<V>, tanh: V, regressors: [f64; 2]) -> [V; 2] {
        let Self { bounds: [bound1, bound2, bound3], inertias: [inertia1, inertia2, inertia3] } = self;
        let drive = signals.s * tanh;
        let bounds = learning.bounds.step(in_lanes([bound1, bound2, bound3]), [drive, drive]);
        let drives = regressors.map(|regressor| signals.s * signals.regressor.with_last(regressor));
        let inertias = learning.inertias.step(in_lanes([inertia1, inertia2, inertia3]), drives);
        [*bound1, *bound2, _, *bound3] = bounds.lanes();
        [*inertia1, *inertia2, _, *inertia3] = inertias.lanes();
        [bounds, inertias]
    }
}

/// The step where its inputs are evaluated. The commands that follow it are not found: whoever asks for them before a step will ask for those
/// of other inputs.
#[inline(always)]
fn learn<V: Four>(table: &Table, state: State<'_>, inputs: &Inputs, at: &Evaluation) {
    let State { hubs: [hub1, hub2], object, filters } = state;
    let signals = at.signals::<V>();
    let learning = &table.learning[usize::from(filters.state() == inputs.measured.tip_shear_dot)];
    let surfaces = signals.s.lanes();
    for (hub, w) in [hub1.weights, hub2.weights].into_iter().enumerate() {
        let [decay, weight] = table.grid_weights[hub];
        learn_grid::<V>(w, at.grid(hub), (decay, weight * surfaces[hub]));
    }
    // Here the exponentials are fewer, and with the grids first a step took less time.
    next_part();
    let ([x1, x2, ..], regressors) = signals.moving(table, inputs, follow(table, filters, inputs));
    let of_nodes = powers([x1, x2]);
    let [decay, weight1, weight2, _] = learning.star_weights;
    let shares = [weight1 * surfaces[OBJECT], weight2 * surfaces[OBJECT]];
    let moving = (&table.star_heights[1], table.least[HUBS]);
    learn_star(object.weights, &at.still, moving, of_nodes, (decay, shares));
    let scalars = Scalars {
        bounds: [hub1.bound, hub2.bound, object.bound],
        inertias: [hub1.inertia, hub2.inertia, object.inertia],
    };
    let [regressor1, regressor2, ..] = regressors.lanes();
    scalars.step(learning, &signals, at.tanh(), [regressor1, regressor2]);
}

/// Commands where the inputs are evaluated.
#[inline(always)]
fn look<V: Four>(table: &Table, state: State<'_>, inputs: &Inputs, at: &Evaluation) -> Commands {
    let State { hubs: [hub1, hub2], object, filters } = state;
    let signals = at.signals::<V>();
    let ([x, ..], regressors) = signals.moving(table, inputs, filters.state().map(V::splat));
    let [of_x] = powers([x]);
    let of_grids: [V; HUBS] = std::array::from_fn(|hub| {
        let w: &[_; GRID] = [&*hub1.weights, &*hub2.weights][hub];
        grid_output(w, at.grid(hub))
    });
    let still = still_output::<V>(object.weights, &at.still);
    let of_star = star_output(object.weights, &table.star_heights[1], table.least[HUBS], of_x, still);
    let [a, b, c, d] = V::columns([of_grids[0], of_grids[1], V::splat(0.0), of_star]);
    let outputs = (a + b) + (c + d);
    let bounds = in_lanes([hub1.bound, hub2.bound, object.bound]);
    let inertias = in_lanes([hub1.inertia, hub2.inertia, object.inertia]);
    let regressor = regressors.lanes()[0];
    signals.commands(table, inputs, at.tanh(), regressor, [outputs, bounds, inertias])
}

impl<'a> State<'a> {
    /// Of a law whose networks are usual ones.
    #[inline(always)]
    fn of(
        object: &'a mut ObjectLoop,
        [arm1, arm2]: &'a mut [PostureLoop; 2],
        filters: &'a mut LowPass,
    ) -> Option<Self> {
        let hubs = [arm1.estimator.learner()?, arm2.estimator.learner()?];
        Some(Self { hubs, object: object.estimator.learner()?, filters })
    }
}

impl Nabfc {
    /// Makes a usual step, if it is one; it is then one without a fault.
    #[inline(always)]
    pub(super) fn usual_step<V: Four>(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> bool {
        let Self { keep, object, posture, shear_rate, .. } = self;
        let Some(table) = keep.table(h) else { return false };
        if !(rates.are_zeros() && inputs.are_surely_usable::<V>()) {
            return false;
        }
        let Some(state) = State::of(object, posture, shear_rate) else { return false };
        if keep.has_seen(inputs) {
            return keep.learn::<V>(state, inputs);
        }
        let commands = step::<V>(table, state, inputs);
        keep.put(inputs, commands);
        true
    }

    /// The commands, if there is a table for usual steps.
    #[inline(always)]
    pub(super) fn usual_commands<V: Four>(&mut self, inputs: &Inputs) -> Option<Commands> {
        let Self { keep, object, posture, shear_rate, .. } = self;
        if !inputs.are_surely_usable::<V>() {
            return None;
        }
        let state = State::of(object, posture, shear_rate)?;
        let are_seen = keep.has_seen(inputs);
        let (table, at) = keep.evaluated::<V>(inputs, are_seen)?;
        let commands = look::<V>(table, state, inputs, at);
        keep.add(commands);
        Some(commands)
    }
}

impl Keep {
    /// Makes a usual step with the inputs that the law has seen last.
    #[inline(always)]
    fn learn<V: Four>(&mut self, state: State<'_>, inputs: &Inputs) -> bool {
        #[cfg(target_arch = "x86_64")]
        if V::IS_WIDE {
            // SAFETY: a wide register is in use.
            return unsafe { self.learn_wide(state, inputs) };
        }
        self.learn_here::<V>(state, inputs)
    }

    // Not inlined, so that other steps do not share registers with it.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    fn learn_wide(&mut self, state: State<'_>, inputs: &Inputs) -> bool {
        self.learn_here::<Wide>(state, inputs)
    }

    #[inline(always)]
    fn learn_here<V: Four>(&mut self, state: State<'_>, inputs: &Inputs) -> bool {
        let Some((table, at)) = self.evaluated::<V>(inputs, true) else { return false };
        learn::<V>(table, state, inputs, at);
        self.known = Known::Nothing;
        true
    }
}

//! The law's general way, in narrow registers on all processors: with wide ones nearly all is for the [usual step](super::usual).
//!
//! Three hyperbolic tangents, two grids and a star ask for some twenty exponentials. With held inputs a step sees the shear rates
//! at two points, because the low-pass moves, and commands see them at a third. Only three of the star's seven inputs differ
//! between these, so the rest is evaluated once. What commands need after a step is evaluated in it if they were not asked for before it: then
//! the processor has it ready by the time. Elsewhere each loop evaluates itself ([`ObjectLoop::at`], [`PostureLoop::at`]): the
//! same operations number by number, so the same bits.
//!
//! [`ObjectLoop::at`]: super::object_loop::ObjectLoop::at
//! [`PostureLoop::at`]: super::posture_loop::PostureLoop::at

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::{Known, Nabfc};
use crate::blocks::exponential::{powers, tanh_of};
use crate::blocks::four::{Four, LANES};
use crate::law::StepError;
use crate::signals::{Commands, Inputs, have_same_bits};

impl Nabfc {
    /// Evaluates surfaces, tangents, regressors and bases for inputs, with other shear rates instead of those in them, as far as they
    /// are not known there.
    #[inline(always)]
    fn evaluate<V: Four>(&mut self, inputs: &Inputs, shear_dot: [f64; 2]) {
        if !self.knows(inputs) {
            self.evaluate_still::<V>(inputs);
        } else if self.object.point.as_ref().is_some_and(|point| have_same_bits(point.inputs.shear_dot, shear_dot)) {
            return;
        }
        self.object.move_to::<V>(shear_dot);
    }

    /// Whether the loops are evaluated for these inputs, whatever the shear rates.
    #[inline(always)]
    fn knows(&self, inputs: &Inputs) -> bool {
        let [arm1, arm2] = &self.posture;
        let (Some(object), Some(point1), Some(point2)) = (&self.object.point, &arm1.point, &arm2.point) else {
            return false;
        };
        let are_of_seen = object.is_of_seen & point1.is_of_seen & point2.is_of_seen;
        are_of_seen && self.keep.knows_loops() && self.keep.seen.has_bits_of(inputs)
    }

    /// Evaluates all that the shear rates do not change. What they do change is to follow.
    #[inline(never)]
    fn evaluate_still<V: Four>(&mut self, inputs: &Inputs) {
        self.keep.see(inputs, Known::Loops);
        self.object.prepare();
        let at = self.loop_inputs(inputs, [0.0; 2]);
        let [arm1, arm2] = &mut self.posture;
        let (mut point1, z1) = arm1.signals(at.posture[0].0, at.posture[0].1);
        let (mut point2, z2) = arm2.signals(at.posture[1].0, at.posture[1].1);
        let (mut object, x) = self.object.signals(&at.object);
        (object.is_of_seen, point1.is_of_seen, point2.is_of_seen) = (true, true, true);
        let network = &mut self.object.estimator.network;
        let [network1, network2] = [&mut arm1.estimator.network, &mut arm2.estimator.network];
        if network.is_plain() & network1.is_plain() & network2.is_plain() {
            let (z1, z2) = (V::load(&z1), V::load(&z2));
            let [of_z1, of_z2, of_x] = powers([
                network1.last_exponents(z1),
                network2.last_exponents(z2),
                network.first_exponents(V::load(&x)),
            ]);
            // The star first: what the compiler computes as late as it can would else be put aside in parts.
            network.fill_plain_first(of_x);
            network1.fill_plain_grid(z1, of_z1);
            network2.fill_plain_grid(z2, of_z2);
        } else {
            network1.go_on(z1);
            network2.go_on(z2);
            network.activate_lanes(&[x, [0.0; LANES]]);
        }
        let width = self.object.epsilon();
        let widths = V::load(&[width, arm1.epsilon(), arm2.epsilon(), width]);
        [object.tanh, point1.tanh, point2.tanh, _] =
            tanh_of(V::load(&[object.s, point1.s, point2.s, object.s]) / widths).lanes();
        (self.object.point, arm1.point, arm2.point) = (Some(object), Some(point1), Some(point2));
    }

    /// Eqs. (36) and (54).
    #[inline(always)]
    pub(super) fn commands_here<V: Four>(&mut self, inputs: &Inputs) -> Commands {
        let used = self.shear_rate.output(inputs.measured.tip_shear_dot);
        self.evaluate::<V>(inputs, used);
        let [arm1, arm2] = &self.posture;
        let (Some(object), Some(point1), Some(point2)) = (&self.object.point, &arm1.point, &arm2.point) else {
            return Commands::default();
        };
        let moment = inputs.measured.root_moment;
        Commands {
            tau: [arm1.command_here::<V>(point1, moment[0]), arm2.command_here::<V>(point2, moment[1])],
            u: self.object.command_here::<V>(object),
        }
    }

    /// Update laws (37)–(39) and (55)–(57), and the low-pass.
    #[inline(always)]
    pub(super) fn step_here<V: Four>(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        if !rates.are_held() {
            StepError::check(h, inputs, rates)?;
            self.keep.forget_commands();
            self.ramped_step(h, inputs, rates);
            return Ok(());
        }
        StepError::check_held(h, inputs)?;
        self.keep.forget_commands();
        self.held_step_here::<V>(h, inputs);
        Ok(())
    }

    /// A step with held inputs.
    #[inline(always)]
    fn held_step_here<V: Four>(&mut self, h: f64, inputs: &Inputs) {
        let shear_dot = inputs.measured.tip_shear_dot;
        let used = self.shear_rate.sampled(h, shear_dot, [0.0; 2]);
        let is_settled = self.shear_rate.is_settled(shear_dot);
        self.shear_rate.step(h, shear_dot, [0.0; 2]);
        if is_settled {
            self.evaluate::<V>(inputs, used[0]);
            self.object.step_here::<V>(h);
        } else {
            let is_new = !self.knows(inputs);
            if is_new {
                self.evaluate_still::<V>(inputs);
            }
            self.object.step_both_here::<V>(h, used);
            if is_new {
                // Nobody has asked for commands before the step, so somebody will after it.
                self.object.move_to::<V>(self.shear_rate.output(shear_dot));
            }
        }
        for posture in &mut self.posture {
            posture.step_here::<V>(h);
        }
    }
}

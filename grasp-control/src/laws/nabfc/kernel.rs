//! The law's hot path: one pass for all exponentials of a step, in the registers that the processor has.
//!
//! Three hyperbolic tangents, two grids and a star ask for some thirty exponentials. With held inputs a step sees the shear rates
//! at two points, because the low-pass moves, and commands see them at a third. Only three of the star's seven inputs differ
//! between these, so the rest is evaluated once. Elsewhere each loop evaluates itself ([`ObjectLoop::at`], [`PostureLoop::at`]): the
//! same operations number by number, so the same bits.
//!
//! [`ObjectLoop::at`]: super::object_loop::ObjectLoop::at
//! [`PostureLoop::at`]: super::posture_loop::PostureLoop::at

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::{LoopInputs, Nabfc};
use crate::blocks::exponential::{exp_of, tanh_of};
use crate::blocks::four::{Four, LANES, Lanes};
use crate::law::StepError;
use crate::signals::{Commands, Inputs, all_equal};

impl Nabfc {
    /// Evaluates surfaces, tangents, regressors and bases at an instant, as far as they are not known there.
    ///
    /// With `SECOND`, `second` are the shear rates of a second instant that is otherwise the same: gives the second half of the
    /// exponentials that the star needs there.
    #[inline(always)]
    fn evaluate<V: Four, const SECOND: bool>(&mut self, at: &LoopInputs, second: [f64; 2]) -> Lanes {
        let [arm1, arm2] = &self.posture;
        let mut moved = [0.0; LANES];
        if let (Some(object), Some(point1), Some(point2)) = (&self.object.point, &arm1.point, &arm2.point)
            && object.inputs.agrees_but_for_rates(&at.object)
            && all_equal(
                &[point1.e, point1.e_dot, point2.e, point2.e_dot],
                &[at.posture[0].0, at.posture[0].1, at.posture[1].0, at.posture[1].1],
            )
        {
            if SECOND {
                moved = self.object.moved_exponentials::<V>(&at.object, second);
            }
            if object.inputs.shear_dot != at.object.shear_dot {
                let moving = self.object.moved_exponentials::<V>(&at.object, at.object.shear_dot);
                self.object.move_to::<V>(&at.object, moving);
            }
            return moved;
        }
        let (mut object, x) = self.object.signals(&at.object);
        let (mut point1, z1) = arm1.signals(at.posture[0].0, at.posture[0].1);
        let (mut point2, z2) = arm2.signals(at.posture[1].0, at.posture[1].1);
        let tangents =
            [self.object.tanh_argument(&object), arm1.tanh_argument(&point1), arm2.tanh_argument(&point2), 0.0];
        let [tanh, tanh1, tanh2, _] = tanh_of(V::load(&tangents)).lanes();
        (object.tanh, point1.tanh, point2.tanh) = (tanh, tanh1, tanh2);
        if SECOND {
            moved = self.object.moved_exponentials::<V>(&at.object, second);
        }
        let exponentials1 = arm1.estimator.exponents::<V>(z1);
        let exponentials2 = arm2.estimator.exponents::<V>(z2);
        let exponentials = self.object.estimator.exponents::<V>(x);
        // Independent of each other, so the processor works on several at a time.
        let exponentials1 = [exp_of(exponentials1[0]).lanes(), exp_of(exponentials1[1]).lanes()];
        let exponentials2 = [exp_of(exponentials2[0]).lanes(), exp_of(exponentials2[1]).lanes()];
        let exponentials = [exp_of(exponentials[0]).lanes(), exp_of(exponentials[1]).lanes()];
        let [arm1, arm2] = &mut self.posture;
        arm1.estimator.fill::<V>(z1, &exponentials1);
        arm2.estimator.fill::<V>(z2, &exponentials2);
        self.object.estimator.fill::<V>(x, &exponentials);
        (self.object.point, arm1.point, arm2.point) = (Some(object), Some(point1), Some(point2));
        moved
    }

    /// Eqs. (36) and (54).
    #[inline(always)]
    pub(super) fn commands_here<V: Four>(&mut self, inputs: &Inputs) -> Commands {
        let at = self.loop_inputs(inputs, self.shear_rate.output(inputs.measured.tip_shear_dot));
        self.evaluate::<V, false>(&at, [0.0; 2]);
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
            self.ramped_step(h, inputs, rates);
            return Ok(());
        }
        StepError::check_held(h, inputs)?;
        self.held_step_here::<V>(h, inputs);
        Ok(())
    }

    /// A step with held inputs.
    #[inline(always)]
    fn held_step_here<V: Four>(&mut self, h: f64, inputs: &Inputs) {
        let shear_dot = inputs.measured.tip_shear_dot;
        let used = self.shear_rate.sampled(h, shear_dot, [0.0; 2]);
        let at = self.loop_inputs(inputs, used[0]);
        if self.shear_rate.is_settled(shear_dot) {
            self.evaluate::<V, false>(&at, [0.0; 2]);
            self.object.step_here::<V>(h);
        } else {
            let moved = self.evaluate::<V, true>(&at, used[1]);
            self.object.step_both_here::<V>(h, &at.object, used[1], moved);
        }
        for posture in &mut self.posture {
            posture.step_here::<V>(h);
        }
        self.shear_rate.step(h, shear_dot, [0.0; 2]);
    }
}

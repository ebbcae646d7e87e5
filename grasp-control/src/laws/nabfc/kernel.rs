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

use super::object_loop::Point;
use super::{LoopInputs, Nabfc};
use crate::blocks::exponential::{exp_of_all, tanh_of};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::Wide;
use crate::blocks::four::{Four, LANES, Lanes, Narrow};
use crate::law::StepError;
use crate::signals::{Commands, Inputs, all_equal};

impl Nabfc {
    /// Evaluates surfaces, tangents, regressors and bases for inputs, with the shear rates `first` instead of those in them, as far as they are
    /// not known there.
    ///
    /// `second` are the shear rates of a second instant that is otherwise the same, if there is one: gives the second half of the
    /// exponentials that the star needs there.
    #[inline(always)]
    fn evaluate<V: Four>(&mut self, inputs: &Inputs, first: [f64; 2], second: Option<[f64; 2]>) -> Lanes {
        let mut moved = [0.0; LANES];
        if let Some(point) = self.known(inputs) {
            if let Some(second) = second {
                moved = self.object.moved_exponentials::<V>(point, second);
            }
            if point.inputs.shear_dot != first {
                let moving = self.object.moved_exponentials::<V>(point, first);
                self.object.move_to::<V>(first, moving);
            }
            return moved;
        }
        self.seen = *inputs;
        let at = self.loop_inputs(inputs, first);
        #[cfg(target_arch = "x86_64")]
        if V::IS_WIDE {
            // SAFETY: a wide register is in use.
            return unsafe { self.evaluate_all_wide(&at, second.unwrap_or(first)) };
        }
        self.evaluate_all_narrow(&at, second.unwrap_or(first))
    }

    /// The object's point, if the loops are evaluated for these inputs, whatever the shear rates.
    #[inline(always)]
    fn known(&self, inputs: &Inputs) -> Option<&Point> {
        let [arm1, arm2] = &self.posture;
        let (Some(object), Some(point1), Some(point2)) = (&self.object.point, &arm1.point, &arm2.point) else {
            return None;
        };
        let are_of_seen = object.is_of_seen & point1.is_of_seen & point2.is_of_seen;
        if are_of_seen && all_equal(&self.seen.to_array(), &inputs.to_array()) { Some(object) } else { None }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    fn evaluate_all_wide(&mut self, at: &LoopInputs, second: [f64; 2]) -> Lanes {
        self.evaluate_all::<Wide>(at, second)
    }

    #[inline(never)]
    fn evaluate_all_narrow(&mut self, at: &LoopInputs, second: [f64; 2]) -> Lanes {
        self.evaluate_all::<Narrow>(at, second)
    }

    /// [`evaluate`](Self::evaluate) where nothing is known. Without a branch for the second instant: at it the compiler would put all
    /// constants of the exponentials aside.
    #[inline(always)]
    fn evaluate_all<V: Four>(&mut self, at: &LoopInputs, second: [f64; 2]) -> Lanes {
        let [arm1, arm2] = &self.posture;
        let mut object = self.object.signals(&at.object);
        let (mut point1, z1) = arm1.signals(at.posture[0].0, at.posture[0].1);
        let (mut point2, z2) = arm2.signals(at.posture[1].0, at.posture[1].1);
        (object.is_of_seen, point1.is_of_seen, point2.is_of_seen) = (true, true, true);
        let tangents =
            [self.object.tanh_argument(&object), arm1.tanh_argument(&point1), arm2.tanh_argument(&point2), 0.0];
        let [tanh, tanh1, tanh2, _] = tanh_of(V::load(&tangents)).lanes();
        (object.tanh, point1.tanh, point2.tanh) = (tanh, tanh1, tanh2);
        let moved = self.object.moved_exponentials::<V>(&object, second);
        let [first1, second1] = arm1.estimator.exponents::<V>(z1);
        let [first2, second2] = arm2.estimator.exponents::<V>(z2);
        let [still, moving] = self.object.estimator.exponents::<V>(object.x);
        let [first1, second1, first2, second2, still, moving] =
            exp_of_all([first1, second1, first2, second2, still, moving]);
        let [arm1, arm2] = &mut self.posture;
        arm1.estimator.fill::<V>(z1, &[first1, second1]);
        arm2.estimator.fill::<V>(z2, &[first2, second2]);
        self.object.estimator.fill::<V>(object.x, &[still, moving]);
        (self.object.point, arm1.point, arm2.point) = (Some(object), Some(point1), Some(point2));
        moved
    }

    /// Eqs. (36) and (54).
    #[inline(always)]
    pub(super) fn commands_here<V: Four>(&mut self, inputs: &Inputs) -> Commands {
        let used = self.shear_rate.output(inputs.measured.tip_shear_dot);
        self.evaluate::<V>(inputs, used, None);
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
        if self.shear_rate.is_settled(shear_dot) {
            self.evaluate::<V>(inputs, used[0], None);
            self.object.step_here::<V>(h);
        } else {
            let moved = self.evaluate::<V>(inputs, used[0], Some(used[1]));
            self.object.step_both_here::<V>(h, used[1], moved);
        }
        for posture in &mut self.posture {
            posture.step_here::<V>(h);
        }
        self.shear_rate.step(h, shear_dot, [0.0; 2]);
    }
}

//! What the usual step computes from its inputs, whatever has been learnt; and the commands.

#![allow(clippy::inline_always)]
#![cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]

use super::table::Table;
use crate::blocks::exponential::{LARGEST, tanh_of};
use crate::blocks::four::Four;
use crate::signals::{Commands, Inputs};

/// Clamped.
#[inline(always)]
fn within<V: Four>(x: V, (least, most): (V, V)) -> V {
    most.smaller(least.larger(x))
}

/// Signals of the loops.
#[derive(Clone, Copy)]
pub(super) struct Signals<V> {
    pub error: V,
    /// Surfaces (33) and (51).
    pub s: V,
    /// Of the hubs.
    pub regressor: V,
    /// Exponents of two of the networks' inputs but for those that the shear rates move: of hub 1, of hub 2, of the star.
    pub exponents: [V; 3],
    /// ‖x‖² of these inputs of the star.
    pub still_norm2: f64,
}

impl<V: Four> Signals<V> {
    #[inline(always)]
    pub fn of(table: &Table, inputs: &Inputs) -> Self {
        let (measured, reference) = (&inputs.measured, &inputs.reference);
        let (shear, lambda1) = (measured.tip_shear, reference.lambda1_ref);

        // (16), (33) and (51).
        let [by_theta1, by_lambda1, rest] = &table.targets;
        let targets = V::load(by_theta1) * V::splat(reference.theta1_ref)
            + V::load(by_lambda1) * V::pairs([-0.0, lambda1], [lambda1; 2]);
        let position = V::pairs(measured.theta, [0.0, measured.y_object]);
        let error = position - (targets + V::load(rest));
        let velocity = V::pairs(measured.theta_dot, [0.0, measured.y_object_dot]);
        let slope = V::load(&table.slope);
        let [c1, c2] = table.compliance;
        let shear_error = (shear[0] - lambda1) * c1 + (shear[1] + lambda1) * c2;
        let s = slope * error + velocity;
        let s = s.with_last(s.last() + shear_error);
        let regressor = velocity * slope;

        // The networks' inputs: clamped, squared, exponents of two, by component.
        let reach = (V::load(&table.reach[0]), V::load(&table.reach[1]));
        let [of_error, of_surface, of_alpha] = &table.scales;
        let x = [
            error * V::load(of_error),
            s * V::load(of_surface),
            ((V::load(&table.alpha) * velocity) * V::load(of_alpha)).with_last(shear[0] * c1 * table.shear[0]),
            V::splat(0.0).with_last(shear[1] * c2 * table.shear[1]),
        ];
        let [a, b, c, d] = [within(x[0], reach), within(x[1], reach), within(x[2], reach), within(x[3], reach)];
        let norm2 = (a * a + b * b) + (c * c + d * d);
        let step = V::load(&table.step);
        let common = (norm2 * V::load(&table.common)).larger(V::splat(-LARGEST));
        let [z1, z2, _, still] = V::columns([a * step, b * step, c * step, d * step + common]);
        Self { error, s, regressor, exponents: [z1, z2, still], still_norm2: norm2.last() }
    }

    /// Of s/ϵ.
    #[inline(always)]
    pub fn tanh(&self, table: &Table) -> V {
        tanh_of(self.s / V::load(&table.width))
    }

    /// What shear rates move, for those of each arm at up to four points: exponents of two of the star's last inputs for each point, and
    /// regressors with points in lanes.
    #[inline(always)]
    pub fn moving(&self, table: &Table, inputs: &Inputs, [first, second]: [V; 2]) -> ([V; 4], V) {
        let [[alpha1, regressor1], [alpha2, regressor2]] = table.by_rate;
        let object_velocity = V::splat(inputs.measured.y_object_dot);
        let alpha =
            object_velocity * V::splat(table.by_velocity[0]) + (first * V::splat(alpha1) + second * V::splat(alpha2));
        let regressors = object_velocity * V::splat(table.by_velocity[1])
            + (first * V::splat(regressor1) + second * V::splat(regressor2));
        let [star_reach, star_step, star_common] = table.star;
        let a = alpha.within(star_reach);
        let b = (first * V::splat(table.by_own_rate[0])).within(star_reach);
        let c = (second * V::splat(table.by_own_rate[1])).within(star_reach);
        let norm2 = V::splat(self.still_norm2) + ((a * a + b * b) + c * c);
        let common = (norm2 * V::splat(star_common)).larger(V::splat(-LARGEST));
        let step = V::splat(star_step);
        (V::columns([a * step, b * step, c * step, common]), regressors)
    }

    /// (36) and (54), with the object's regressor.
    #[inline(always)]
    pub fn commands(
        &self,
        table: &Table,
        inputs: &Inputs,
        tanh: V,
        of_object: f64,
        [outputs, bounds, inertias]: [V; 3],
    ) -> Commands {
        let Self { s, error, regressor, .. } = *self;
        let shear = inputs.measured.tip_shear;
        let of_s = V::load(&table.switching) * s.within(table.limit) - V::load(&table.k) * s - error;
        let of_inertias = inertias * regressor.with_last(of_object);
        let loads = V::pairs(inputs.measured.root_moment, [0.0, shear[1]]);
        let with_loads = of_s - of_inertias.with_last(-shear[0]) + loads;
        let [tau1, tau2, _, u] = (with_loads - outputs - bounds * tanh).lanes();
        Commands { tau: [tau1, tau2], u: u - of_inertias.last() }
    }
}

//! What the usual step needs of gains and step size, ready to be used in lanes.

#![allow(clippy::inline_always)]

use super::super::Nabfc;
use super::super::estimator::Estimator;
use super::{HUBS, OBJECT};
use crate::blocks::adaptation::{LeakyLaw, NODES};
use crate::blocks::four::{Four, LANES, Lanes};
use crate::blocks::rbf::{Heights, PlainAxis};

/// A leaky law for each loop: x ← decay·x + first·φ' + second·φ'', where the hubs' second weight is zero, for their forcings are held.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(super) struct Leaky {
    pub decay: Lanes,
    pub weights: [Lanes; 2],
}

impl Leaky {
    /// The estimates after a step.
    #[inline(always)]
    pub fn step<V: Four>(&self, estimates: V, [first, second]: [V; 2]) -> V {
        let [by_first, by_second] = &self.weights;
        (V::load(&self.decay) * estimates + V::load(by_first) * first) + V::load(by_second) * second
    }
}

/// How all that is learnt follows its forcings.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(super) struct Learning {
    /// Decay and two weights of the star's weights; the last number is none of them.
    pub star_weights: Lanes,
    /// The laws (38), (56).
    pub bounds: Leaky,
    /// The laws (39), (57).
    pub inertias: Leaky,
}

/// Constants of the usual step. In vectors of four, lanes 0 and 1 are the hubs and the last one is the object; in those of a component of the
/// star's last inputs lanes are points.
///
/// Equal tables are one in memory, see [`shared`](super::shared).
#[derive(Debug, Clone, Copy)]
#[repr(C)] // Nothing but numbers, of which `shared` compares the bits.
pub(super) struct Table {
    /// Step size \[s\].
    pub h: f64,
    /// Where exp(−‖x‖²/b²) of the grids and the star is not larger, every activation is negligible.
    pub least: [f64; 3],
    /// Targets (16): θ₁ᵈ, θ₂ᵈ and `y_M`ᵈ per θ₁ᵈ and per λ₁ᵈ, on which θ₁ᵈ does not depend, and the rest. What is not there is −0, which changes
    /// no sum.
    pub targets: [Lanes; 3],
    /// μ + c₃, μ̄ + c₁.
    pub slope: Lanes,
    /// Widths ϵ of tanh.
    pub width: Lanes,
    /// Inverse scales of errors, of surfaces, and of the hubs' α̇₂.
    pub scales: [Lanes; 3],
    /// −c₃.
    pub alpha: Lanes,
    /// 1/EIᵢ.
    pub compliance: [f64; 2],
    /// Inverse scales of wᵢ'''(l).
    pub shear: [f64; 2],
    /// The clamp of the networks' inputs.
    pub reach: [Lanes; 2],
    /// The exponent of two for one step along an axis.
    pub step: Lanes,
    /// −1/b², for powers of two; 0 for the star.
    pub common: Lanes,
    /// Reach, step and −1/b² of the star's axes.
    pub star: [f64; 3],
    /// What ż₁ moves of α̇₁, normalised, and of the regressor.
    pub by_velocity: [f64; 2],
    /// How far the low-pass has come at the two nodes of a step and at its end.
    pub follow: Lanes,
    /// What each shear rate moves of α̇₁, normalised, and of the regressor.
    pub by_rate: [[f64; 2]; 2],
    /// What each shear rate moves of ẇᵢ'''(l), normalised.
    pub by_own_rate: [f64; 2],
    /// Of the grids.
    pub grid_heights: [Heights; HUBS],
    /// Of the star: axes that stay, and those that the shear rates move.
    pub star_heights: [Heights; 2],
    /// Decay and weight of the grids' weights.
    pub grid_weights: [[f64; 2]; HUBS],
    /// Where the low-pass moves, and where it rests: there the object's forcings are held, too, and their second weights are zero.
    pub learning: [Learning; 2],
    /// −ξ, −η.
    pub switching: Lanes,
    /// k.
    pub k: Lanes,
    /// Limit of sat.
    pub limit: f64,
}

impl Table {
    /// The bits of all numbers.
    pub fn bits(&self) -> &[u64] {
        const { assert!(size_of::<Self>().is_multiple_of(size_of::<u64>())) };
        // SAFETY: `repr(C)`, nothing but numbers of eight bytes, so nothing between them either.
        unsafe { std::slice::from_raw_parts((&raw const *self).cast(), size_of::<Self>() / size_of::<u64>()) }
    }

    /// The constants, if the law's steps of this size are usual ones: all three networks learn, are plain, and have no ball; the low-pass is on.
    pub fn new(law: &Nabfc, h: f64) -> Option<Self> {
        let object = &law.object;
        let estimators = law.posture.each_ref().map(|posture| &posture.estimator);
        let star = &object.estimator.network;
        let is_usual = law.shear_rate.is_on()
            && object.estimator.is_plain()
            && estimators.iter().all(|estimator| estimator.is_plain());
        if !is_usual {
            return None;
        }
        let slopes = law.slopes.unwrap_or_else(|| law.arms.slopes());
        let [hub1, hub2] = law.posture.each_ref().map(|posture| &posture.settings);
        let settings = &object.settings;
        let lanes = |of: [f64; HUBS], object: f64| {
            let mut lanes = [0.0; LANES];
            lanes[..HUBS].copy_from_slice(&of);
            lanes[OBJECT] = object;
            lanes
        };
        let hubs = [hub1, hub2];
        let [position, surface, _, shear1, shear2, ..] = settings.inverse_scales;
        let of_scale = |axis: usize| hubs.map(|hub| hub.inverse_scales[axis]);
        let [grid1, grid2] = estimators.map(|estimator| estimator.network.plain_axis());
        let axis = star.plain_axis();
        let of_axes = |of: fn(&PlainAxis) -> f64| lanes([of(&grid1), of(&grid2)], of(&axis));
        let [by_velocity, by_rate1, by_rate2] = settings.moving();
        let of_hubs = estimators.map(Estimator::laws);
        let learning = |rests: bool| {
            let of_object = |law: LeakyLaw| {
                if rests {
                    let step = law.held(h);
                    (step.decay, [step.weight, 0.0])
                } else {
                    let step = law.sampled(h);
                    (step.decay, step.weights)
                }
            };
            let leaky = |hubs: [LeakyLaw; HUBS], object: LeakyLaw| {
                let ([one, two], (decay, [first, second])) = (hubs.map(|law| law.held(h)), of_object(object));
                Leaky {
                    decay: lanes([one.decay, two.decay], decay),
                    weights: [lanes([one.weight, two.weight], first), lanes([0.0; 2], second)],
                }
            };
            let laws = object.estimator.laws();
            let (decay, [first, second]) = of_object(laws.weights);
            Learning {
                star_weights: [decay, first, second, 0.0],
                bounds: leaky(of_hubs.map(|laws| laws.bound), laws.bound),
                inertias: leaky(of_hubs.map(|laws| laws.inertia), laws.inertia),
            }
        };
        let [node1, node2, end] = law.shear_rate.follows([NODES[0] * h, NODES[1] * h, h]);
        Some(Self {
            h,
            least: [grid1.least, grid2.least, axis.least],
            targets: [
                lanes([1.0; 2], law.arms.length),
                lanes([1.0, slopes.theta2], slopes.y),
                lanes([-0.0; 2], 0.5 * law.arms.hub_distance),
            ],
            slope: lanes(hubs.map(|hub| hub.gains.mu + hub.gains.c3), settings.gains.mu_bar + settings.gains.c1),
            width: [hub1.gains.epsilon2, hub2.gains.epsilon2, settings.gains.epsilon1, settings.gains.epsilon1],
            scales: [lanes(of_scale(0), position), lanes(of_scale(1), surface), lanes(of_scale(2), 0.0)],
            alpha: lanes(hubs.map(|hub| -hub.gains.c3), 0.0),
            compliance: settings.compliance,
            shear: [shear1, shear2],
            reach: [of_axes(|axis| -axis.reach), of_axes(|axis| axis.reach)],
            step: of_axes(|axis| axis.step),
            common: lanes([grid1.common, grid2.common], 0.0),
            star: [axis.reach, axis.step, axis.common],
            by_velocity: [by_velocity[0], by_velocity[3]],
            follow: [node1, node2, end, end],
            by_rate: [[by_rate1[0], by_rate1[3]], [by_rate2[0], by_rate2[3]]],
            by_own_rate: [by_rate1[1], by_rate2[2]],
            grid_heights: estimators.map(|estimator| estimator.network.heights(0)),
            star_heights: [star.heights(0), star.heights(1)],
            grid_weights: of_hubs.map(|laws| laws.weights.held(h)).map(|step| [step.decay, step.weight]),
            learning: [false, true].map(learning),
            switching: lanes(hubs.map(|hub| -hub.gains.xi), -settings.gains.eta),
            k: lanes(hubs.map(|hub| hub.gains.k), settings.gains.k),
            limit: settings.sat_limit,
        })
    }
}

//! Hub 1, hub 2 and the object side by side: what learns at every step, estimators and observers, in lanes.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::super::observed::Observers;
use super::{Estimator, FilterGains, Moving, Prior, Shares, Weights};
use crate::blocks::four::{Four, Lanes};
use crate::blocks::observer::{Observed, RateSource};
use serde::{Deserialize, Serialize};

/// The estimators of all three coordinates; stored as if they were one after the other.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "[Estimator; 3]", into = "[Estimator; 3]")]
pub(in super::super) struct Estimators([Lanes; Estimator::<f64>::STATES]);

/// Their priors, and all else that a step needs that changes with gains and step sizes only.
#[derive(Debug, Clone)]
pub(in super::super) struct OfSize {
    pub h: f64,
    pub source: RateSource,
    /// Poles of the observers, what is left of their errors after a step, and the most that they take for a disturbance.
    pub poles: Lanes,
    pub decays: Lanes,
    pub limits: Lanes,
    pub filter: FilterGains,
    pub shares: Shares,
    pub priors: Priors,
}

/// What the priors add to the sums.
#[derive(Debug, Clone)]
pub(in super::super) struct Priors([Lanes; Weights::<f64>::NUMBERS]);

/// What is measured, and the known force.
#[derive(Clone, Copy)]
pub(in super::super) struct Sights<V> {
    pub position: V,
    pub rate: V,
    /// The rates that the estimators take: as measured, or as the observers had them before.
    pub moving: V,
    pub force: V,
    pub load: V,
}

impl From<[Estimator; 3]> for Estimators {
    fn from(estimators: [Estimator; 3]) -> Self {
        Self(in_lanes(estimators.map(Estimator::to_array), [0.0; _]))
    }
}

impl From<Estimators> for [Estimator; 3] {
    fn from(estimators: Estimators) -> Self {
        [0, 1, 2].map(|i| estimators.of(i))
    }
}

impl From<&[Prior; 3]> for Priors {
    fn from(priors: &[Prior; 3]) -> Self {
        let numbers = priors.map(|prior| prior.weights().to_array());
        // The lane to spare must not divide by zero.
        Self(in_lanes(numbers, numbers[2]))
    }
}

/// The numbers of three coordinates, those of each lane in turn; `spare` go into the lane to spare.
fn in_lanes<const N: usize>([hub1, hub2, object]: [[f64; N]; 3], spare: [f64; N]) -> [Lanes; N] {
    std::array::from_fn(|j| [hub1[j], hub2[j], object[j], spare[j]])
}

impl Estimators {
    /// The estimator of a coordinate.
    pub fn of(&self, i: usize) -> Estimator {
        Estimator::from_array(std::array::from_fn(|j| self.0[j][i]))
    }

    /// Advances the estimators by a step in which what is seen is held, and with `inertias` as they are before also the `observers`, if
    /// these learn. Gives the inertias after the step.
    #[inline(always)]
    pub fn step<V: Four>(
        &mut self,
        size: &OfSize,
        sights: &Sights<V>,
        observers: &mut Observers,
        inertias: Option<V>,
    ) -> Lanes {
        let h = V::splat(size.h);
        let moving = Moving { rate: sights.moving, force: sights.force, load: sights.load };
        if let Some(inertias) = inertias {
            let Observers { position, rate, disturbance } = observers;
            let observed = Observed {
                state: [V::load(position), V::load(rate), V::load(disturbance)],
                measured: [sights.position, sights.rate],
                force: moving.force,
            };
            let (decays, poles, limits) = (V::load(&size.decays), V::load(&size.poles), V::load(&size.limits));
            let after = observed.after(size.source, h, decays, poles, inertias, limits);
            (*position, *rate, *disturbance) = (after[0].lanes(), after[1].lanes(), after[2].lanes());
        }
        let mut numbers = [h; Estimator::<f64>::STATES];
        for (number, lanes) in numbers.iter_mut().zip(&self.0) {
            *number = V::load(lanes);
        }
        let mut weights = [h; Weights::<f64>::NUMBERS];
        for (weight, lanes) in weights.iter_mut().zip(&size.priors.0) {
            *weight = V::load(lanes);
        }
        let (mut estimator, weights) = (Estimator::from_array(numbers), Weights::from_array(weights));
        let shares = [V::splat(size.shares.slow), V::splat(size.shares.follow)];
        estimator.step_with(h, V::splat(size.filter.bandwidth), shares, &weights, &moving);
        for (lanes, number) in self.0.iter_mut().zip(estimator.to_array()) {
            *lanes = number.lanes();
        }
        estimator.inertia_with(&weights).lanes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::four::{Narrow, Portable};
    #[cfg(target_arch = "x86_64")]
    use crate::blocks::four::{Wide, has_wide_registers};
    use crate::blocks::observer::{Known, Motion, Observer};

    const FILTER: FilterGains = FilterGains { bandwidth: 150.0, high_pass: 3.0 };
    const SIZE: f64 = 1e-3;
    const INERTIAS: Lanes = [0.008, 0.012, 0.6, 0.6];

    fn priors() -> [Prior; 3] {
        let prior = |initial: f64, memory: f64| Prior {
            initial,
            smallest: 0.5 * initial,
            largest: 20.0 * initial,
            threshold: 0.1,
            weight: 3e-4,
            memory,
            stiffness: 1.7,
        };
        [prior(0.0073, 0.1), prior(0.0073, 0.2), prior(0.5, 0.01)]
    }

    fn size(source: RateSource) -> OfSize {
        let poles = [60.0, 80.0, 40.0, 40.0];
        OfSize {
            h: SIZE,
            source,
            poles,
            decays: poles.map(|pole| Observer::decay(pole, SIZE)),
            limits: [2.0, 2.0, 0.3, 0.3],
            filter: FILTER,
            shares: FILTER.shares(SIZE),
            priors: Priors::from(&priors()),
        }
    }

    /// What is seen in a step, in lanes.
    struct Seen {
        position: Lanes,
        rate: Lanes,
        moving: Lanes,
        force: Lanes,
        load: Lanes,
    }

    impl Seen {
        fn new(step: u32, rates: Lanes, source: RateSource) -> Self {
            let wave = |rate: f64| std::array::from_fn(|i| (rate * f64::from(step) * SIZE + i as f64).sin());
            let rate = wave(30.0);
            let moving = match source {
                RateSource::Measured => rate,
                RateSource::Estimated => rates,
            };
            Self { position: wave(20.0), rate, moving, force: wave(45.0), load: wave(12.0) }
        }

        fn sights<V: Four>(&self) -> Sights<V> {
            Sights {
                position: V::load(&self.position),
                rate: V::load(&self.rate),
                moving: V::load(&self.moving),
                force: V::load(&self.force),
                load: V::load(&self.load),
            }
        }
    }

    /// Estimators, observers and inertias of some hundred steps.
    fn run<V: Four>(source: RateSource) -> (Estimators, [Observer; 3], Vec<[u64; 3]>) {
        let (size, mut observers) = (size(source), Observers::from([Observer::default(); 3]));
        let (mut estimators, mut inertias) = (Estimators::from([Estimator::default(); 3]), Vec::new());
        for step in 0..400 {
            let sights = Seen::new(step, observers.rate, source).sights::<V>();
            let found = estimators.step(&size, &sights, &mut observers, Some(V::load(&INERTIAS)));
            inertias.push([0, 1, 2].map(|i: usize| found[i].to_bits()));
        }
        (estimators, observers.into(), inertias)
    }

    /// In lanes of any kind and one by one give the same bits.
    #[test]
    fn side_by_side_is_the_same_as_one_by_one() {
        for source in [RateSource::Measured, RateSource::Estimated] {
            let (estimators, observers, inertias) = run::<Portable>(source);
            let same = |(of, and, found): &(Estimators, [Observer; 3], Vec<[u64; 3]>)| {
                assert_eq!((&of.0, and, found), (&estimators.0, &observers, &inertias));
            };
            same(&run::<Narrow>(source));
            #[cfg(target_arch = "x86_64")]
            if has_wide_registers() {
                same(&run::<Wide>(source));
            }
            let (size, priors) = (size(source), priors());
            let (mut one_by_one, mut alone) = ([Estimator::default(); 3], [Observer::default(); 3]);
            for step in 0..400 {
                let seen = Seen::new(step, Observers::from(alone).rate, source);
                for i in 0..3 {
                    let moving = Moving { rate: seen.moving[i], force: seen.force[i], load: seen.load[i] };
                    let shares = [size.shares.slow, size.shares.follow];
                    one_by_one[i].step_with(SIZE, FILTER.bandwidth, shares, &priors[i].weights(), &moving);
                    let known = Known { source, bandwidth: size.poles[i], inertia: INERTIAS[i], limit: size.limits[i] };
                    let measured = Motion { position: seen.position[i], rate: seen.rate[i] };
                    alone[i].step(SIZE, &known, measured, seen.force[i]);
                    assert_eq!(one_by_one[i].inertia(&priors[i]).to_bits(), inertias[step as usize][i]);
                }
            }
            assert_eq!((<[Estimator; 3]>::from(estimators), observers), (one_by_one, alone));
        }
    }
}

//! The estimates as differential equations.

use super::{Estimator, FilterGains, Moving, Prior, Signals, Sums};

impl<V: Copy> Signals<V> {
    #[inline(always)]
    fn from_array([a, f, n]: [V; 3]) -> Self {
        Self { a, f, n }
    }
}

impl<V: Copy> Estimator<V> {
    /// Number of states.
    pub const STATES: usize = 11;

    #[inline(always)]
    pub fn to_array(self) -> [V; 11] {
        let Self { smooth, slow, sums: Sums { ff, nn, nf, af, an } } = self;
        [smooth.a, smooth.f, smooth.n, slow.a, slow.f, slow.n, ff, nn, nf, af, an]
    }

    #[inline(always)]
    pub fn from_array(states: [V; 11]) -> Self {
        let [a, f, n, slow_a, slow_f, slow_n, ff, nn, nf, af, an] = states;
        Self {
            smooth: Signals::from_array([a, f, n]),
            slow: Signals::from_array([slow_a, slow_f, slow_n]),
            sums: Sums { ff, nn, nf, af, an },
        }
    }
}

impl Estimator {
    /// Low-passes and high-passes: rates of what they hold.
    #[inline]
    fn filter_rates(&self, filter: &FilterGains, signals: &Signals, moving: Moving) -> (Signals, Signals) {
        let (smooth, w, slow) = (&self.smooth, filter.bandwidth, filter.high_pass);
        let towards = [moving.rate - smooth.a, moving.force - smooth.f, moving.load - smooth.n];
        let away = [signals.a, signals.f, signals.n];
        (Signals::from_array(towards.map(|x| w * x)), Signals::from_array(away.map(|x| slow * x)))
    }

    /// Time derivatives.
    #[inline]
    pub fn derivative(&self, filter: &FilterGains, prior: &Prior, moving: Moving) -> Self {
        let signals = self.signals(filter, moving);
        let (smooth, slow) = self.filter_rates(filter, &signals, moving);
        let square = signals.f * signals.f;
        let weight = prior.counting(square);
        let sums = Sums::of(signals).combine(weight, &self.sums, -weight * square / prior.memory);
        Self { smooth, slow, sums }
    }

    /// Exact change of [`derivative`](Self::derivative) for a change `by` of the state, and of the motion.
    #[inline]
    pub fn derivative_change(
        &self,
        filter: &FilterGains,
        prior: &Prior,
        moving: Moving,
        by: &Self,
        moving_change: Moving,
    ) -> Self {
        let signals = self.signals(filter, moving);
        // Linear.
        let change = by.signals(filter, moving_change);
        let (smooth, slow) = by.filter_rates(filter, &change, moving_change);
        let (square, square_change) = (signals.f * signals.f, 2.0 * signals.f * change.f);
        let threshold = prior.threshold * prior.threshold;
        let weight = prior.counting(square);
        let weight_change = square_change * threshold / (square + threshold).powi(2);
        let Signals { a, f, n } = signals;
        let products = Sums {
            ff: square_change,
            nn: 2.0 * n * change.n,
            nf: change.n * f + n * change.f,
            af: change.a * f + a * change.f,
            an: change.a * n + a * change.n,
        };
        // d(w (X − f² S/S₀)) = dw (X − f² S/S₀) + w (dX − 2 f df S/S₀ − f² dS/S₀)
        let driven = Sums::of(signals).combine(weight_change, &self.sums, -weight_change * square / prior.memory);
        let moved = products.combine(weight, &self.sums, -weight * square_change / prior.memory);
        let forgotten = by.sums.combine(-weight * square / prior.memory, &driven, 1.0);
        Self { smooth, slow, sums: moved.combine(1.0, &forgotten, 1.0) }
    }

    /// Change of Ĵ.
    #[inline]
    pub fn inertia_changes(&self, prior: &Prior, by: &Self) -> f64 {
        // At its one value an estimate that is held may count as inside of its bounds.
        if prior.largest <= prior.smallest { 0.0 } else { self.inertia_change(prior, &by.sums) }
    }

    /// How far β = 1/Ĵ is inside of its bounds, relatively: from that of the largest inertia, from that of the smallest (1 where
    /// they are the same); and γ, which losses make positive, relatively.
    #[inline]
    pub fn distances(&self, prior: &Prior) -> [f64; 3] {
        let Sums { ff, nn, nf, af, an } = self.weighted(prior);
        let loss = (nf * af - ff * an) / (ff * af.abs().max(ff / prior.largest)) * prior.stiffness.recip();
        if prior.largest <= prior.smallest {
            return [1.0, 1.0, loss];
        }
        let (above, below, _) = Self::fraction(prior, &Sums { ff, nn, nf, af, an });
        [above * prior.largest / below - 1.0, 1.0 - above * prior.smallest / below, loss]
    }
}

//! What the law sees of its inputs and its state, and how that changes along directions and in time.

use super::RootStrain;
use super::loops::Point;
use super::natural::Compliance;
use crate::blocks::observer::{Motion, RateSource};
use crate::blocks::slope::Signals;
use crate::laws::nabfc::Surfaces;
use crate::signals::{Commands, INPUTS, Inputs};
use crate::target::Arms;

impl RootStrain {
    /// Q̇ᵢ = −(3EIᵢ/l³)(l θ̇ᵢ − ẏ), Ṁᵢ = −l Q̇ᵢ; also maps accelerations to the rates of these.
    pub(super) fn quasi_static(&self, omega: [f64; 2], v: f64) -> ([f64; 2], [f64; 2]) {
        let shear = quasi_static_shear_rates(&self.arms, omega, v);
        (shear.map(|rate| -self.arms.length * rate), shear)
    }

    /// Rates of root moments and of the tip shears. Estimated ones are those of arms that bend as at rest: right below
    /// the first beam mode.
    pub(super) fn strain_rates(&self, inputs: &Inputs) -> ([f64; 2], [f64; 2]) {
        let [hub1, hub2, object, _] = self.observers.rate;
        match self.source {
            RateSource::Measured => {
                let (moments, shears) = loads(inputs);
                (self.root_moment_rate.output(moments), self.tip_shear_rate.output(shears))
            }
            RateSource::Estimated => self.quasi_static([hub1, hub2], object),
        }
    }

    /// The commands for these inputs. Not inlined, because a step and what comes after it ask for them; what they are made of is.
    #[inline(never)]
    pub(super) fn act(&self, inputs: &Inputs) -> Commands {
        self.loops().at(&self.point_here(inputs)).into()
    }

    /// The signals for these inputs.
    #[inline(never)]
    pub(super) fn point(&self, inputs: &Inputs) -> Point {
        self.point_here(inputs)
    }

    #[inline(always)]
    fn point_here(&self, inputs: &Inputs) -> Point {
        let slopes = self.slopes.unwrap_or_else(|| self.arms.slopes());
        let targets = self.arms.targets_with(&slopes, &inputs.reference);
        let errors = targets.errors(inputs);
        let measured = &inputs.measured;
        let [hub1, hub2, object, _] = self.observers.rate;
        let [unknown1, unknown2, unknown, _] = self.observers.disturbance;
        let (moment_rate, shear_rate) = self.strain_rates(inputs);
        let [inertia1, inertia2, mass] = self.inertias();
        let moment = self.root_moment.output(measured.root_moment);
        Point {
            e: errors.e,
            omega: [hub1, hub2],
            moment: std::array::from_fn(|i| moment[i] + targets.lambda[i] * self.arms.length),
            moment_rate,
            load: measured.root_moment,
            p: errors.p,
            v: object,
            shear: measured.tip_shear[0] + measured.tip_shear[1],
            shear_rate: shear_rate[0] + shear_rate[1],
            mass,
            inertia: [inertia1, inertia2],
            unknown: [unknown1, unknown2, unknown],
        }
    }

    /// Change of the signals along a direction of the inputs, with the law's state as it is.
    pub(super) fn direction(&self, direction: &Inputs) -> Point {
        let jacobian = self.arms.error_jacobian();
        let values = direction.to_array();
        let inner = |row: &[f64; INPUTS]| crate::law::inner(row, &values);
        let lambda = [direction.reference.lambda1_ref, -direction.reference.lambda1_ref];
        let measured = &direction.measured;
        let moment = if self.root_moment.is_on() { [0.0; 2] } else { measured.root_moment };
        let mut change = Point {
            e: jacobian.e.each_ref().map(inner),
            moment: std::array::from_fn(|i| moment[i] + lambda[i] * self.arms.length),
            load: measured.root_moment,
            p: inner(&jacobian.p),
            shear: measured.tip_shear[0] + measured.tip_shear[1],
            ..Point::default()
        };
        if self.source == RateSource::Measured {
            let (moments, shears) = loads(direction);
            change.moment_rate = self.root_moment_rate.output_change(moments, [0.0; 2]);
            let shear = self.tip_shear_rate.output_change(shears, [0.0; 2]);
            change.shear_rate = shear[0] + shear[1];
        }
        change
    }

    /// Change of the signals in time, for inputs that change at `rates`.
    pub(super) fn velocity(&mut self, inputs: &Inputs, rates: &Inputs) -> Point {
        let state = self.state_rates(inputs);
        let mut change = self.direction(rates);
        if self.root_moment.is_on() {
            let rate = self.root_moment.output_rate(inputs.measured.root_moment, rates.measured.root_moment);
            (0..2).for_each(|i| change.moment[i] += rate[i]);
        }
        let [hub1, hub2, object] = &state.observers;
        change.omega = [hub1.rate, hub2.rate];
        change.v = object.rate;
        change.unknown = state.observers.map(|observer| observer.disturbance);
        let [inertia1, inertia2, mass] = state.inertia;
        (change.mass, change.inertia) = (mass, [inertia1, inertia2]);
        match self.source {
            RateSource::Estimated => {
                let shear;
                (change.moment_rate, shear) = self.quasi_static(change.omega, change.v);
                change.shear_rate = shear[0] + shear[1];
            }
            RateSource::Measured if self.root_moment_rate.is_on() => {
                let (moments, shears) = loads(rates);
                let m = &inputs.measured;
                let slow = self.root_moment_rate.filtered_rate(m.root_moment);
                change.moment_rate = self.root_moment_rate.output_change(moments, slow);
                let slow = self.tip_shear_rate.filtered_rate(m.tip_shear);
                let shear = self.tip_shear_rate.output_change(shears, slow);
                change.shear_rate = shear[0] + shear[1];
            }
            RateSource::Measured => {}
        }
        change
    }

    /// The sliding variables for these inputs.
    #[must_use]
    pub fn surfaces(&self, inputs: &Inputs) -> Surfaces {
        self.loops().at(&self.point(inputs)).into()
    }

    /// Change of the sliding variables along a direction of the inputs.
    #[must_use]
    pub fn surface_derivative(&self, inputs: &Inputs, direction: &Inputs) -> Surfaces {
        self.loops().change(&self.point(inputs), &self.direction(direction)).into()
    }

    /// Time derivatives of the sliding variables, for inputs that change at `rates`.
    pub fn surface_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Surfaces {
        let change = self.velocity(inputs, rates);
        self.loops().change(&self.point(inputs), &change).into()
    }
}

/// Hub 1, hub 2, object.
pub(crate) fn motions(inputs: &Inputs) -> [Motion; 3] {
    let m = &inputs.measured;
    [
        Motion { position: m.theta[0], rate: m.theta_dot[0] },
        Motion { position: m.theta[1], rate: m.theta_dot[1] },
        Motion { position: m.y_object, rate: m.y_object_dot },
    ]
}

/// Root moments and tip shears with their rates, or the change of that.
pub(super) fn loads(inputs: &Inputs) -> (Signals, Signals) {
    let m = &inputs.measured;
    (Signals { value: m.root_moment, rate: m.root_moment_dot }, Signals { value: m.tip_shear, rate: m.tip_shear_dot })
}

/// Q̇ᵢ = −(3EIᵢ/l³)(l θ̇ᵢ − ẏ) of arms that bend as at rest.
pub(crate) fn quasi_static_shear_rates(arms: &Arms, omega: [f64; 2], v: f64) -> [f64; 2] {
    let stiffness = Compliance::of(arms).tip_stiffness;
    std::array::from_fn(|i| -stiffness[i] * (arms.length * omega[i] - v))
}

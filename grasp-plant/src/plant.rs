//! The plant: state, exact steps, outputs.

use crate::actuator::Actuator;
use crate::beam::DEFLECTION_POINTS;
use crate::dense::{LANES, Matrix};
use crate::dynamics::{
    Dynamics, FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, Signals, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY, builtin_forces, dot,
};
use crate::initial;
use crate::parameters::{InvalidParameter, Parameters};
use crate::propagator::{Cache, Extended, MAX_PANELS};
use crate::signals::{Direct, Inputs, Measured, Rates, Uncertainty};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Coordinates smaller than this \[√J\] become zero after a step. A decaying motion would otherwise end in subnormal
/// numbers, on which processors are a hundred times slower; the energy given up is below the smallest normal number.
const NEGLIGIBLE: f64 = 1e-150;

/// Into how many parts a step is divided at most, if it is too long for one piece: seconds of computing time.
const MOST_PARTS: u32 = 1 << 22;

/// Everything that changes while the plant moves. Together with [`Parameters`] it determines all that follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Energy coordinates x \[√J\], 4k + 1 of them: ½|x|² is the total energy.
    pub coordinates: Vec<f64>,
    /// θ_1 \[rad\], θ_2 \[rad\], `y_M` \[m\].
    pub position: [f64; 3],
    /// What rounding has kept from being added to the positions so far (compensated summation): at rest, increments are
    /// below half a unit in the last place of the positions, but not of the beams' coordinates, and (12) ties the two.
    pub carry: [f64; 3],
    /// Work done on the plant by actuators and external disturbances since the start \[J\].
    pub supplied_energy: f64,
}

impl State {
    /// Adds to the positions, keeping what rounding takes away for the next time.
    fn travel(&mut self, from: &Self, travel: &[f64; FORCES]) {
        for (i, travel) in travel.iter().enumerate() {
            let increment = from.carry[i] + travel;
            let position = from.position[i] + increment;
            self.carry[i] = increment - (position - from.position[i]);
            self.position[i] = position;
        }
    }
}

/// Why a step was refused. The plant is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The step size is not a positive finite number.
    #[error("step size {h} s is not positive and finite")]
    NotPositive {
        /// The step size \[s\].
        h: f64,
    },
    /// The step is longer than [`Plant::longest_step`].
    #[error("step size {h:e} s is longer than {longest:e} s, the longest for these parameters")]
    TooLong {
        /// The step size \[s\].
        h: f64,
        /// The longest admissible one \[s\].
        longest: f64,
    },
    /// An input or an input's derivative is infinite or not a number.
    #[error("an input or its derivative is not finite")]
    InputNotFinite,
    /// The state would leave the range of floating-point numbers.
    #[error("the state would overflow")]
    Overflow,
}

/// Why a [`State`] was refused. The plant is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// The state is one of another order.
    #[error("a state of {found} coordinates does not fit a plant of {expected}")]
    Length {
        /// Number of coordinates of the refused state.
        found: usize,
        /// Number of coordinates of this plant.
        expected: usize,
    },
    /// A number in the state is infinite or not a number.
    #[error("the state has an entry that is not finite")]
    NotFinite,
}

/// The plant as a linear system, for analysis: ξ̇ = A ξ + B g, measured = C ξ with ξ = (x, θ_1, θ_2, `y_M`) and
/// g the torques on hubs 1 and 2 and the force on the object.
///
/// By (12), w_i(l), θ_i and `y_M` depend on each other: two eigenvalues of A are zero for this reason alone.
#[derive(Clone, Debug)]
pub struct StateSpace {
    /// A, shape (4k+4) × (4k+4).
    pub a: Matrix,
    /// B, shape (4k+4) × 3.
    pub b: Matrix,
    /// C, shape 12 × (4k+4): θ_1, θ_2, θ̇_1, θ̇_2, `y_M`, `ẏ_M`, EI w''(0) (2), EI w'''(l) (2), d/dt EI w'''(l) (2).
    pub c: Matrix,
    /// Rows that give w_1(l) and w_2(l), shape 2 × (4k+4).
    pub tip_deflection: Matrix,
}

/// What follows from the parameters alone.
#[derive(Debug)]
struct Model {
    parameters: Parameters,
    dynamics: Dynamics,
    extended: Extended,
    actuators: [Actuator; FORCES],
}

/// Two flexible arms grasping an object, (2)–(14), behind their actuators (18)–(20).
///
/// Cloning is cheap: clones share all matrices.
///
/// ```
/// use grasp_plant::{Inputs, Parameters, Plant};
/// let mut plant = Plant::new(Parameters::default())?;
/// let inputs = Inputs { torque_command: [0.05, 0.0], ..Inputs::ZERO };
/// for _ in 0..500 {
///     plant.step(1e-4, &inputs, &Inputs::ZERO)?;
/// }
/// // Exact value of θ_1(0.05 s) from the characteristic equation: 0.0059126125…
/// assert!((plant.measured().theta[0] - 0.005_912_612_5).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Plant {
    model: Arc<Model>,
    state: State,
    /// Signals of `state`, kept current.
    signals: Signals,
    cache: Cache,
    work: Workspace,
}

/// Buffers of a step, so that it does not allocate.
#[derive(Clone, Debug)]
struct Workspace {
    /// (x, g, r), or the whole extended vector.
    drive: Vec<f64>,
    /// Increments, padded.
    increment: Vec<[f64; LANES]>,
    next: State,
}

impl Plant {
    /// A plant at its start.
    ///
    /// # Errors
    /// If a parameter is not admissible.
    pub fn new(parameters: Parameters) -> Result<Self, InvalidParameter> {
        parameters.validate()?;
        let dynamics = Dynamics::new(&parameters);
        let extended = Extended::new(&dynamics, parameters.length);
        let channels = [&parameters.torque_channel, &parameters.torque_channel, &parameters.force_channel];
        let actuators = channels.map(|channel| Actuator::new(parameters.actuator_model, channel));
        let state = start(&parameters, &dynamics);
        let size = extended.layout.size();
        let work = Workspace {
            drive: vec![0.0; size],
            increment: vec![[0.0; LANES]; size.div_ceil(LANES)],
            next: state.clone(),
        };
        Ok(Self {
            signals: dynamics.signals(&state.coordinates),
            model: Arc::new(Model { parameters, dynamics, extended, actuators }),
            state,
            cache: Cache::default(),
            work,
        })
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.model.parameters
    }

    /// The state.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Replaces the state by one that a plant of the same parameters had.
    ///
    /// # Errors
    /// If the state belongs to another order or holds a number that is not finite.
    pub fn set_state(&mut self, state: &State) -> Result<(), StateError> {
        let (found, expected) = (state.coordinates.len(), self.state.coordinates.len());
        if found != expected {
            return Err(StateError::Length { found, expected });
        }
        let mut values =
            state.coordinates.iter().chain(&state.position).chain(&state.carry).chain([&state.supplied_energy]);
        if !values.all(|value| value.is_finite()) {
            return Err(StateError::NotFinite);
        }
        self.state.coordinates.copy_from_slice(&state.coordinates);
        self.state.position = state.position;
        self.state.carry = state.carry;
        self.state.supplied_energy = state.supplied_energy;
        self.signals = self.model.dynamics.signals(&self.state.coordinates);
        Ok(())
    }

    /// Returns to the start. What was computed for the step sizes in use is kept.
    pub fn reset(&mut self) {
        self.state = start(&self.model.parameters, &self.model.dynamics);
        self.signals = self.model.dynamics.signals(&self.state.coordinates);
    }

    /// The longest step this plant takes \[s\]: [`LONGEST_STEP`](crate::LONGEST_STEP) at the default parameters of every
    /// order, less for extremely stiff ones, times the four million parts into which a step may be divided.
    #[must_use]
    pub fn longest_step(&self) -> f64 {
        self.longest_part() * f64::from(MOST_PARTS)
    }

    /// The longest step done in one piece \[s\].
    #[must_use]
    pub fn longest_part(&self) -> f64 {
        self.model.extended.longest_step
    }

    /// Advances by h seconds, exactly: commands and disturbances are `inputs` + `rates`·t for 0 ≤ t ≤ h. Zero rates hold
    /// the inputs.
    ///
    /// A ramp that runs over kinks of an actuator is followed exactly too, piece by piece. The first step of a size costs
    /// a matrix exponential; the last eight sizes are remembered.
    ///
    /// # Errors
    /// See [`StepError`]; the plant is then as it was before.
    pub fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        if !(h > 0.0 && h.is_finite()) {
            return Err(StepError::NotPositive { h });
        }
        let longest = self.longest_step();
        if h > longest {
            return Err(StepError::TooLong { h, longest });
        }
        if !(inputs.is_finite() && rates.is_finite()) {
            return Err(StepError::InputNotFinite);
        }
        if h > self.longest_part() {
            return self.long_step(h, inputs, rates);
        }
        if *rates == Inputs::ZERO {
            self.whole_step(h, &self.model.forces(inputs), None);
        } else {
            let mut times = [0.0; MAX_KINK_TIMES];
            let kinks = self.model.kink_times(h, inputs, rates, &mut times);
            if kinks.is_empty() {
                let force_rates = self.model.force_rates(&at(inputs, rates, h / 2.0), rates);
                self.whole_step(h, &self.model.forces(inputs), Some(&force_rates));
            } else {
                self.broken_step(h, inputs, rates, kinks);
            }
        }
        let next = &mut self.work.next;
        flush(&mut next.coordinates);
        let signals = self.model.dynamics.signals(&next.coordinates);
        let finite = all_finite(&next.coordinates) & all_finite(&next.position) & all_finite(&signals);
        if !(finite & next.supplied_energy.is_finite()) {
            return Err(StepError::Overflow);
        }
        self.signals = signals;
        std::mem::swap(&mut self.state, next);
        Ok(())
    }

    /// A step that is too long for one piece, in equal parts.
    #[cold]
    fn long_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        // One more than the quotient, so that rounding cannot make a part too long.
        let parts = (h / self.longest_part()).floor() + 1.0;
        let part = h / parts;
        let before = self.state.clone();
        let mut i = 0.0;
        while i < parts {
            if let Err(error) = self.step(part, &at(inputs, rates, i * part), rates) {
                self.signals = self.model.dynamics.signals(&before.coordinates);
                self.state = before;
                return Err(error);
            }
            i += 1.0;
        }
        Ok(())
    }

    /// One step with forces g + r t, into the workspace's next state.
    fn whole_step(&mut self, h: f64, forces: &[f64; FORCES], rates: Option<&[f64; FORCES]>) {
        let n = self.state.coordinates.len();
        let propagator = self.cache.get(&self.model.extended, h);
        let Workspace { drive, increment, next } = &mut self.work;
        drive[..n].copy_from_slice(&self.state.coordinates);
        drive[n..n + FORCES].copy_from_slice(forces);
        let mut length = n + FORCES;
        if let Some(rates) = rates {
            drive[length..length + FORCES].copy_from_slice(rates);
            length += FORCES;
        }
        propagator.step(&drive[..length], increment);
        let (change, travel) = increment.as_flattened().split_at(n);
        for ((next, x), change) in next.coordinates.iter_mut().zip(&self.state.coordinates).zip(change) {
            *next = x + change;
        }
        let mut work = dot(forces, travel);
        if let Some(rates) = rates {
            // ∫ t Θ̇ dt = h Θ(h) − ∫ Θ dt
            let integral = propagator.travel_integral(&drive[..length]);
            work += (0..FORCES).map(|i| rates[i] * (h * travel[i] - integral[i])).sum::<f64>();
        }
        next.travel(&self.state, &std::array::from_fn(|i| travel[i]));
        next.supplied_energy = self.state.supplied_energy + work;
    }

    /// One step whose forces have kinks at the given times, into the workspace's next state.
    fn broken_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs, kinks: &[f64]) {
        let Model { extended, dynamics, parameters, .. } = &*self.model;
        let layout = extended.layout;
        let n = self.state.coordinates.len();
        let Workspace { drive, increment, next } = &mut self.work;
        let z = &mut drive[..];
        z[..n].copy_from_slice(&self.state.coordinates);
        next.supplied_energy = self.state.supplied_energy;
        let mut total = [0.0; FORCES];
        let mut begin = 0.0;
        for end in kinks.iter().copied().chain([h]) {
            let duration = end - begin;
            let forces = self.model.forces(&at(inputs, rates, begin));
            let force_rates = self.model.force_rates(&at(inputs, rates, f64::midpoint(begin, end)), rates);
            z[layout.travel()..layout.force()].fill(0.0);
            z[layout.force()..layout.force_rate()].copy_from_slice(&forces);
            z[layout.force_rate()..].copy_from_slice(&force_rates);
            let tips = [0, 1].map(|i| z[dynamics.tip_coordinate(i)]);
            extended.advance(duration, z, increment);
            let (travel, integral) = (layout.travel(), layout.travel_integral());
            for i in 0..FORCES {
                let lag = duration * z[travel + i] - z[integral + i];
                next.supplied_energy += forces[i] * z[travel + i] + force_rates[i] * lag;
            }
            // Δθ_i follows from (12) as in a whole step.
            let rise = z[travel + 2];
            for i in 0..2 {
                let bend = dynamics.tip_compliance[i] * (z[dynamics.tip_coordinate(i)] - tips[i]);
                total[i] += (bend + rise) / parameters.length;
            }
            total[2] += rise;
            begin = end;
        }
        next.coordinates.copy_from_slice(&z[..n]);
        next.travel(&self.state, &total);
    }

    /// The measured outputs.
    #[must_use]
    pub fn measured(&self) -> Measured {
        measured(&self.state.position, &self.signals)
    }

    /// The outputs that depend on the inputs directly.
    #[must_use]
    pub fn direct(&self, inputs: &Inputs) -> Direct {
        let commands = inputs.commands();
        let applied = std::array::from_fn(|i| self.model.actuators[i].output(commands[i]));
        self.model.direct(&self.signals, &applied, &inputs.disturbances())
    }

    /// The exact directional derivative ∂direct/∂inputs · `direction` at `inputs`, with the actuators' slopes there.
    /// No other output depends on the inputs directly.
    #[must_use]
    pub fn direct_derivative(&self, inputs: &Inputs, direction: &Inputs) -> Direct {
        let applied = self.model.command_response(inputs, direction);
        self.model.direct(&Signals::default(), &applied, &direction.disturbances())
    }

    /// The built-in uncertainties at this moment.
    #[must_use]
    pub fn uncertainty(&self) -> Uncertainty {
        uncertainty(&self.model.parameters, &self.signals)
    }

    /// Deflections w_i at eleven equally spaced points x = 0 … l \[m\], by arm.
    #[must_use]
    pub fn deflection(&self) -> [[f64; DEFLECTION_POINTS]; 2] {
        [0, 1].map(|arm| self.model.dynamics.deflection(arm, &self.state.coordinates))
    }

    /// Tip deflections w_i(l) \[m\].
    #[must_use]
    pub fn tip_deflection(&self) -> [f64; 2] {
        self.model.tip_deflection(&self.state.coordinates)
    }

    /// The constraints φ_i = l θ_i − w_i(l) − `y_M` + L/2 \[m\], eq. (12). They are invariants of the discrete motion, not
    /// enforced: zero up to rounding.
    #[must_use]
    pub fn constraint(&self) -> [f64; 2] {
        let p = &self.model.parameters;
        let constraint = self.model.constraint(&self.state.coordinates, &self.state.position);
        constraint.map(|value| value + p.object_width / 2.0)
    }

    /// Kinetic and strain energy \[J\].
    #[must_use]
    pub fn energy(&self) -> f64 {
        0.5 * dot(&self.state.coordinates, &self.state.coordinates)
    }

    /// Work done since the start by actuators and external disturbances \[J\], exact for every step. Without built-in
    /// uncertainties and Kelvin–Voigt damping, energy − supplied energy is constant. Kelvin–Voigt damping only ever takes
    /// energy; the built-in uncertainties mostly do, but ΔF answers to the rates of both arms and can do work on one of
    /// them, most so if one is much stiffer than the other.
    #[must_use]
    pub fn supplied_energy(&self) -> f64 {
        self.state.supplied_energy
    }

    /// Time derivatives of all outputs for inputs that change with the given rates: analytic, from ẋ = A x + B g.
    #[must_use]
    pub fn rates(&self, inputs: &Inputs, input_rates: &Inputs) -> Rates {
        let Model { dynamics, parameters, .. } = &*self.model;
        let n = self.state.coordinates.len();
        let x = &self.state.coordinates[..];
        let forces = self.model.forces(inputs);
        let mut buffer = [[0.0; LANES]; MAX_PANELS];
        dynamics.system_panels.multiply(x, &mut buffer);
        let rate = &mut buffer.as_flattened_mut()[..n];
        for (row, rate) in rate.iter_mut().enumerate() {
            *rate += (0..FORCES).map(|force| dynamics.input(row, force) * forces[force]).sum::<f64>();
        }
        let signals = dynamics.signals(rate);
        let velocity = VELOCITY.map(|index| self.signals[index]);
        Rates {
            measured: measured(&velocity, &signals),
            direct: self.model.direct(
                &signals,
                &self.model.command_response(inputs, input_rates),
                &input_rates.disturbances(),
            ),
            uncertainty: uncertainty(parameters, &signals),
            deflection: [0, 1].map(|arm| dynamics.deflection(arm, rate)),
            tip_deflection: self.model.tip_deflection(rate),
            constraint: self.model.constraint(rate, &velocity),
            energy: dot(x, rate),
            supplied_energy: dot(&forces, &velocity),
        }
    }

    /// The plant as a linear system.
    #[must_use]
    pub fn state_space(&self) -> StateSpace {
        let dynamics = &self.model.dynamics;
        let n = dynamics.size();
        let velocity = |force: usize, column: usize| dynamics.signal_rows[(VELOCITY[force], column)];
        let a = Matrix::from_fn(n + 3, n + 3, |i, j| match (i < n, j < n) {
            (true, true) => dynamics.system[(i, j)],
            (false, true) => velocity(i - n, j),
            _ => 0.0,
        });
        let b = Matrix::from_fn(n + 3, FORCES, |i, force| if i < n { dynamics.input(i, force) } else { 0.0 });
        let c = Matrix::from_fn(12, n + 3, |row, j| {
            let signal = |index: usize| if j < n { dynamics.signal_rows[(index, j)] } else { 0.0 };
            let position = |index: usize| f64::from(u8::from(j == n + index));
            match row {
                0 | 1 => position(row),
                2 | 3 => signal(VELOCITY[row - 2]),
                4 => position(2),
                5 => signal(VELOCITY[2]),
                6 | 7 => signal(ROOT_MOMENT[row - 6]),
                8 | 9 => signal(TIP_SHEAR[row - 8]),
                _ => signal(TIP_SHEAR_RATE[row - 10]),
            }
        });
        let tip_deflection = Matrix::from_fn(2, n + 3, |arm, j| {
            if j == dynamics.tip_coordinate(arm) { dynamics.tip_compliance[arm] } else { 0.0 }
        });
        StateSpace { a, b, c, tip_deflection }
    }
}

/// Most kinks that three ramps can meet.
const MAX_KINK_TIMES: usize = FORCES * Actuator::MAX_KINKS;

impl Model {
    /// Forces that actuators and external disturbances exert together.
    fn forces(&self, inputs: &Inputs) -> [f64; FORCES] {
        let (commands, disturbances) = (inputs.commands(), inputs.disturbances());
        std::array::from_fn(|i| self.actuators[i].output(commands[i]) + disturbances[i])
    }

    /// Change of the actuator outputs for a change of the commands.
    fn command_response(&self, inputs: &Inputs, direction: &Inputs) -> [f64; FORCES] {
        let (commands, direction) = (inputs.commands(), direction.commands());
        std::array::from_fn(|i| self.actuators[i].slope(commands[i]) * direction[i])
    }

    /// Change of [`Self::forces`].
    fn force_rates(&self, inputs: &Inputs, rates: &Inputs) -> [f64; FORCES] {
        let (response, disturbances) = (self.command_response(inputs, rates), rates.disturbances());
        std::array::from_fn(|i| response[i] + disturbances[i])
    }

    /// Ascending times strictly inside (0, h) at which a ramped command meets a kink of its actuator.
    fn kink_times<'a>(
        &self,
        h: f64,
        inputs: &Inputs,
        rates: &Inputs,
        times: &'a mut [f64; MAX_KINK_TIMES],
    ) -> &'a [f64] {
        let mut count = 0;
        for (actuator, (command, rate)) in
            self.actuators.iter().zip(inputs.commands().into_iter().zip(rates.commands()))
        {
            for kink in actuator.kinks() {
                // A rate of zero gives an infinity or a NaN, which are not inside.
                let time = (kink - command) / rate;
                if time > 0.0 && time < h {
                    times[count] = time;
                    count += 1;
                }
            }
        }
        let times = &mut times[..count];
        times.sort_unstable_by(f64::total_cmp);
        times
    }

    /// Outputs with direct feedthrough. Linear in all arguments, so it also maps rates to rates.
    ///
    /// λ_i = EI_i w_i'''(l) + m_i ÿ_M with ÿ_M from (11), which is (13) and (14); with Kelvin–Voigt damping the shear is
    /// the transmitted one, EI_i(w_i'''(l) + κ ẇ_i'''(l)).
    fn direct(&self, signals: &Signals, applied: &[f64; FORCES], disturbances: &[f64; FORCES]) -> Direct {
        let p = &self.parameters;
        let shear = [0, 1].map(|i| signals[TIP_SHEAR[i]] + p.kelvin_voigt * signals[TIP_SHEAR_RATE[i]]);
        let force = applied[2] + disturbances[2] + builtin_forces(p, signals)[2];
        let acceleration = (force - shear[0] - shear[1]) / p.moving_mass();
        let lambda = [0, 1].map(|i| shear[i] + p.arms[i].tip_mass * acceleration);
        Direct { torque: [applied[0], applied[1]], force: applied[2], lambda, contact_force: [-lambda[0], lambda[1]] }
    }

    fn tip_deflection(&self, x: &[f64]) -> [f64; 2] {
        [0, 1].map(|arm| self.dynamics.tip_compliance[arm] * x[self.dynamics.tip_coordinate(arm)])
    }

    /// The homogeneous part of (12), l θ_i − w_i(l) − `y_M`.
    fn constraint(&self, x: &[f64], position: &[f64; 3]) -> [f64; 2] {
        let tip = self.tip_deflection(x);
        [0, 1].map(|arm| self.parameters.length * position[arm] - tip[arm] - position[2])
    }
}

/// Makes what is [`NEGLIGIBLE`] zero.
fn flush(coordinates: &mut [f64]) {
    for x in coordinates {
        *x = if x.abs() < NEGLIGIBLE { 0.0 } else { *x };
    }
}

/// Whether all numbers are finite, several at a time: 0·x is zero or NaN, and a NaN stays in a sum.
fn all_finite(numbers: &[f64]) -> bool {
    let (chunks, rest) = numbers.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for chunk in chunks {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum += 0.0 * x;
        }
    }
    sums.iter().chain(rest).fold(0.0, |sum, x| sum + 0.0 * x) == 0.0
}

/// Inputs at time t of a ramp.
fn at(inputs: &Inputs, rates: &Inputs, t: f64) -> Inputs {
    let pair = |value: [f64; 2], rate: [f64; 2]| [value[0] + rate[0] * t, value[1] + rate[1] * t];
    Inputs {
        torque_command: pair(inputs.torque_command, rates.torque_command),
        force_command: inputs.force_command + rates.force_command * t,
        hub_disturbance: pair(inputs.hub_disturbance, rates.hub_disturbance),
        object_disturbance: inputs.object_disturbance + rates.object_disturbance * t,
    }
}

fn start(parameters: &Parameters, dynamics: &Dynamics) -> State {
    let Parameters { start, .. } = parameters;
    State {
        coordinates: initial::coordinates(parameters, dynamics),
        position: [start.theta[0], start.theta[1], start.y_object],
        carry: [0.0; 3],
        supplied_energy: 0.0,
    }
}

fn measured(position: &[f64; 3], signals: &Signals) -> Measured {
    let both = |indices: [usize; 2]| indices.map(|index| signals[index]);
    Measured {
        theta: [position[0], position[1]],
        theta_dot: [signals[VELOCITY[0]], signals[VELOCITY[1]]],
        y_object: position[2],
        y_object_dot: signals[VELOCITY[2]],
        root_moment: both(ROOT_MOMENT),
        tip_shear: both(TIP_SHEAR),
        tip_shear_dot: both(TIP_SHEAR_RATE),
    }
}

fn uncertainty(parameters: &Parameters, signals: &Signals) -> Uncertainty {
    let [delta_f1, delta_f2, delta_force] = builtin_forces(parameters, signals);
    Uncertainty {
        delta_f: [delta_f1, delta_f2],
        delta_force,
        root_moment_dot: ROOT_MOMENT_RATE.map(|index| signals[index]),
    }
}

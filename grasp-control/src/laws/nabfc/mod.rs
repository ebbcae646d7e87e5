//! Neuro-adaptive boundary force control, eqs. (31)–(39) and (49)–(57).

mod continuous;
mod estimator;
mod gains;
mod kernel;
mod object_loop;
mod posture_loop;
mod usual;

pub use gains::{Gains, ObjectGains, PostureGains, RbfLayout};

use crate::blocks::adaptation::NODES;
use crate::blocks::four::Narrow;
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};
use crate::blocks::lowpass::LowPass;
use crate::law::{CommandJacobian, Law, StepError};
use crate::signals::{Commands, INPUTS, Inputs, column};
use crate::target::{Arms, ErrorJacobian, TargetSlopes};
use object_loop::{ObjectInputs, ObjectLoop, ObjectPartials};
use parameter_table::InvalidParameter;
use posture_loop::PostureLoop;
use serde::{Deserialize, Serialize};
use usual::{Keep, Known};

/// The NABFC law: three loops, each with its estimates, and a low-pass on the shear rates.
///
/// With held inputs, and the low-pass off or in equilibrium, a step solves the update laws exactly. With inputs that
/// ramp, or a low-pass in motion, their forcings are sampled at the two Gauss–Legendre points of the step and weighted
/// with exact exponentials ([`LeakyLaw::sampled`](crate::blocks::adaptation::LeakyLaw::sampled)); the low-pass itself is always
/// exact.
///
/// The targets are static in the law, as in the paper: a moving reference acts through the errors, its rate does not
/// enter ż₁ and ėᵢ.
// What is unsafe asks for a feature of the processor, and nothing of the data.
#[allow(clippy::unsafe_derive_deserialize)]
#[derive(Debug, Serialize, Deserialize)]
pub struct Nabfc {
    arms: Arms,
    #[serde(skip)]
    slopes: Option<TargetSlopes>,
    gains: Gains,
    object: ObjectLoop,
    posture: [PostureLoop; 2],
    shear_rate: LowPass,
    #[serde(skip)]
    keep: Keep,
}

impl Clone for Nabfc {
    fn clone(&self) -> Self {
        let Self { arms, slopes, gains, object, posture, shear_rate, keep } = self;
        Self {
            arms: *arms,
            slopes: *slopes,
            gains: *gains,
            object: object.clone(),
            posture: posture.clone(),
            shear_rate: *shear_rate,
            keep: keep.clone(),
        }
    }

    /// The same in the memory that is there.
    #[inline(never)]
    fn clone_from(&mut self, source: &Self) {
        let Self { arms, slopes, gains, object, posture, shear_rate, keep } = source;
        (self.arms, self.slopes, self.gains, self.shear_rate) = (*arms, *slopes, *gains, *shear_rate);
        self.object.clone_from(object);
        self.posture.clone_from(posture);
        self.keep.clone_from(keep);
    }
}

/// The sliding variables (33) and (51).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Surfaces {
    /// s of the object loop \[m/s\].
    pub object: f64,
    /// sᵢ of the posture loops \[rad/s\].
    pub posture: [f64; 2],
}

/// Partial derivatives of [`Surfaces`]; rows are ordered like [`INPUT_NAMES`](crate::signals::INPUT_NAMES).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceJacobian {
    /// ∂s.
    pub object: [f64; INPUTS],
    /// ∂sᵢ.
    pub posture: [[f64; INPUTS]; 2],
}

/// The estimates of the update laws.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Estimates {
    /// m̂ \[kg\] (39).
    pub m_hat: f64,
    /// Ĵᵢ \[kg·m²\] (57).
    pub j_hat: [f64; 2],
    /// ε̂ \[N\] (38).
    pub epsilon_hat: f64,
    /// π̂ᵢ \[N·m\] (56).
    pub pi_hat: [f64; 2],
    /// ‖Ŵ‖ \[N\] (37).
    pub w_norm: f64,
    /// ‖Ûᵢ‖ \[N·m\] (55).
    pub u_norm: [f64; 2],
}

/// Inputs of the three loops at one instant.
#[derive(Clone, Copy)]
struct LoopInputs {
    object: ObjectInputs,
    /// (eᵢ, ėᵢ).
    posture: [(f64, f64); 2],
}

impl Nabfc {
    /// A controller for these arms, in its initial state.
    ///
    /// # Errors
    /// The first parameter that is not in its range.
    pub fn new(arms: Arms, gains: Gains) -> Result<Self, InvalidParameter> {
        arms.validate()?;
        gains.validate()?;
        Ok(Self {
            arms,
            slopes: Some(arms.slopes()),
            gains,
            object: ObjectLoop::new(&gains, arms.ei),
            posture: [PostureLoop::new(&gains, 0), PostureLoop::new(&gains, 1)],
            shear_rate: LowPass::new(gains.shear_rate_bandwidth),
            keep: Keep::default(),
        })
    }

    /// The gains.
    #[must_use]
    pub const fn gains(&self) -> &Gains {
        &self.gains
    }

    /// Changes the gains while the law runs: estimates, weights and filters stay.
    ///
    /// Initial estimates and the layout of the networks ([`RbfLayout`]) are not gains in this sense; they stay what
    /// they were.
    ///
    /// # Errors
    /// The first parameter that is not in its range; the law is then as before.
    pub fn set_gains(&mut self, gains: Gains) -> Result<(), InvalidParameter> {
        let mut gains = Gains { rbf: self.gains.rbf, ..gains };
        gains.object.m_hat_0 = self.gains.object.m_hat_0;
        for (new, old) in gains.posture.iter_mut().zip(&self.gains.posture) {
            new.j_hat_0 = old.j_hat_0;
        }
        gains.validate()?;
        self.object.retune(&gains, self.arms.ei);
        for (arm, posture) in self.posture.iter_mut().enumerate() {
            posture.retune(&gains, arm);
        }
        self.shear_rate.set_bandwidth(gains.shear_rate_bandwidth);
        self.forget();
        self.gains = gains;
        Ok(())
    }

    /// Whether this law has the arms and gains of another one, whatever its estimates.
    #[must_use]
    pub fn has_settings_of(&self, other: &Self) -> bool {
        let [arm1, arm2] = &self.posture;
        self.arms == other.arms
            && self.gains == other.gains
            && self.object.has_settings_of(&other.object)
            && arm1.has_settings_of(&other.posture[0])
            && arm2.has_settings_of(&other.posture[1])
            && self.shear_rate.has_settings_of(&other.shear_rate)
    }

    /// The sliding variables for these inputs.
    #[must_use]
    pub fn surfaces(&self, inputs: &Inputs) -> Surfaces {
        let at = self.loop_inputs(inputs, self.shear_rate.output(inputs.measured.tip_shear_dot));
        Surfaces {
            object: self.object.surface(&at.object),
            posture: std::array::from_fn(|i| self.posture[i].surface(at.posture[i].0, at.posture[i].1)),
        }
    }

    /// Partial derivatives of the sliding variables; they are linear in the inputs.
    #[must_use]
    pub fn surface_jacobian(&self) -> SurfaceJacobian {
        let errors = self.arms.error_jacobian();
        SurfaceJacobian {
            object: self.object_row(&self.object.surface_partials(), &errors),
            posture: std::array::from_fn(|i| posture_row(i, self.posture[i].slope(), 1.0, &errors)),
        }
    }

    /// The present estimates.
    #[must_use]
    pub fn estimates(&self) -> Estimates {
        let object = &self.object.estimator;
        let [arm1, arm2] = self.posture.each_ref().map(|posture| &posture.estimator);
        Estimates {
            m_hat: object.inertia,
            j_hat: [arm1.inertia, arm2.inertia],
            epsilon_hat: object.bound,
            pi_hat: [arm1.bound, arm2.bound],
            w_norm: object.network.norm(),
            u_norm: [arm1.network.norm(), arm2.network.norm()],
        }
    }

    /// Time derivatives of the estimates for these inputs: the update laws (37)–(39) and (55)–(57).
    #[must_use]
    pub fn estimate_rates(&mut self, inputs: &Inputs) -> Estimates {
        let at = self.loop_inputs(inputs, self.shear_rate.output(inputs.measured.tip_shear_dot));
        let object = self.object.estimate_rates(&at.object);
        let [arm1, arm2] = [0, 1].map(|i| {
            let (e, e_dot) = at.posture[i];
            self.posture[i].estimate_rates(e, e_dot)
        });
        Estimates {
            m_hat: object.inertia,
            j_hat: [arm1.inertia, arm2.inertia],
            epsilon_hat: object.bound,
            pi_hat: [arm1.bound, arm2.bound],
            w_norm: object.norm,
            u_norm: [arm1.norm, arm2.norm],
        }
    }

    /// Weights Ŵ of the object network, for the record; their centres are those of the layout.
    pub fn object_weights(&self) -> impl Iterator<Item = f64> {
        self.object.estimator.network.weights()
    }

    /// Weights Ûᵢ of the posture network of `arm` 0 or 1.
    pub fn posture_weights(&self, arm: usize) -> impl Iterator<Item = f64> {
        self.posture[arm].estimator.network.weights()
    }

    /// What the loops see, given the shear rates to use.
    #[inline]
    fn loop_inputs(&self, inputs: &Inputs, shear_dot: [f64; 2]) -> LoopInputs {
        let measured = &inputs.measured;
        let slopes = self.slopes.unwrap_or_else(|| self.arms.slopes());
        let errors = self.arms.targets_with(&slopes, &inputs.reference).errors(inputs);
        LoopInputs {
            object: ObjectInputs {
                z1: errors.p,
                z1_dot: measured.y_object_dot,
                shear: measured.tip_shear,
                shear_dot,
                lambda1: inputs.reference.lambda1_ref,
            },
            posture: std::array::from_fn(|i| (errors.e[i], measured.theta_dot[i])),
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    fn commands_wide(&mut self, inputs: &Inputs) -> Commands {
        match self.usual_commands::<Wide>(inputs) {
            Some(commands) => commands,
            None => self.commands_narrow(inputs),
        }
    }

    #[inline(never)]
    fn commands_narrow(&mut self, inputs: &Inputs) -> Commands {
        self.commands_here::<Narrow>(inputs)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline(never)]
    fn step_wide(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        while !self.usual_step::<Wide>(h, inputs, rates) {
            // Where the size had no table, the step may be a usual one with it.
            if self.keep.has_table(h) || !self.adopt(h) {
                return self.step_narrow(h, inputs, rates);
            }
        }
        Ok(())
    }

    #[inline(never)]
    fn step_narrow(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        self.step_here::<Narrow>(h, inputs, rates)
    }

    /// A step with inputs that change. Not inlined, because few hosts ask for it: everything is sampled at two points.
    #[inline(never)]
    fn ramped_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) {
        let (shear_dot, shear_dot_rate) = (inputs.measured.tip_shear_dot, rates.measured.tip_shear_dot);
        let used = self.shear_rate.sampled(h, shear_dot, shear_dot_rate);
        let [first, second] = [0, 1].map(|node| self.loop_inputs(&inputs.after(NODES[node] * h, rates), used[node]));
        self.object.step_sampled(h, &[first.object, second.object]);
        for (i, posture) in self.posture.iter_mut().enumerate() {
            posture.step_sampled(h, [first.posture[i], second.posture[i]]);
        }
        self.shear_rate.step(h, shear_dot, shear_dot_rate);
    }

    /// Assembles partial derivatives of the object loop into a row. The columns of the shear rates are those of the
    /// *used* rates, which are the measured ones only while the low-pass is off.
    fn object_row(&self, partials: &ObjectPartials, errors: &ErrorJacobian) -> [f64; INPUTS] {
        let mut row = errors.p.map(|by_input| partials.z1 * by_input);
        row[column::Y_OBJECT_DOT] += partials.z1_dot;
        row[column::LAMBDA1_REF] += partials.lambda1;
        for arm in 0..2 {
            row[column::TIP_SHEAR + arm] += partials.shear[arm];
            if !self.shear_rate.is_on() {
                row[column::TIP_SHEAR_DOT + arm] += partials.shear_dot[arm];
            }
        }
        row
    }
}

/// A row of one arm from its derivatives with respect to e and ė.
fn posture_row(arm: usize, by_e: f64, by_e_dot: f64, errors: &ErrorJacobian) -> [f64; INPUTS] {
    let mut row = errors.e[arm].map(|by_input| by_e * by_input);
    row[column::THETA_DOT + arm] += by_e_dot;
    row
}

impl Law for Nabfc {
    fn arms(&self) -> &Arms {
        &self.arms
    }

    fn initialize(&mut self, inputs: &Inputs) {
        self.keep.known = Known::Nothing;
        self.object.reset();
        for posture in &mut self.posture {
            posture.reset();
        }
        self.shear_rate.settle(inputs.measured.tip_shear_dot);
    }

    /// Eqs. (36) and (54).
    fn commands(&mut self, inputs: &Inputs) -> Commands {
        if let Some(commands) = self.keep.commands(inputs) {
            return commands;
        }
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.commands_wide(inputs) };
        }
        self.commands_narrow(inputs)
    }

    /// Update laws (37)–(39) and (55)–(57), and the low-pass.
    fn step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs) -> Result<(), StepError> {
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.step_wide(h, inputs, rates) };
        }
        self.step_narrow(h, inputs, rates)
    }

    fn jacobian(&mut self, inputs: &Inputs) -> CommandJacobian {
        let at = self.loop_inputs(inputs, self.shear_rate.output(inputs.measured.tip_shear_dot));
        let errors = self.arms.error_jacobian();
        let tau = std::array::from_fn(|i| {
            let (e, e_dot) = at.posture[i];
            let partials = self.posture[i].partials(e, e_dot);
            let mut row = posture_row(i, partials.e, partials.e_dot, &errors);
            row[column::ROOT_MOMENT + i] += 1.0;
            row
        });
        let partials = self.object.partials(&at.object);
        CommandJacobian { tau, u: self.object_row(&partials, &errors) }
    }

    fn command_rates(&mut self, inputs: &Inputs, rates: &Inputs) -> Commands {
        let mut commands = self.jacobian(inputs).apply(rates);
        let shear_dot = inputs.measured.tip_shear_dot;
        let at = self.loop_inputs(inputs, self.shear_rate.output(shear_dot));
        for (i, (e, e_dot)) in at.posture.into_iter().enumerate() {
            commands.tau[i] += self.posture[i].drift(e, e_dot);
        }
        commands.u += self.object.drift(&at.object);
        if self.shear_rate.is_on() {
            let partials = self.object.partials(&at.object);
            let used_rate = self.shear_rate.output_rate(shear_dot, rates.measured.tip_shear_dot);
            for (partial, rate) in partials.shear_dot.iter().zip(used_rate) {
                commands.u += partial * rate;
            }
        }
        commands
    }
}

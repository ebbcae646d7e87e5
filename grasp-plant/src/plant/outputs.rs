//! Outputs and their derivatives.

use super::Plant;
use super::model::Model;
use crate::beam::DEFLECTION_POINTS;
use crate::contact::{Contact, ContactState, Contacts};
use crate::dynamics::{
    FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, Signals, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY, builtin_forces,
};
use crate::extended::{MAX_COORDINATES, MAX_PANELS};
use crate::kernel::{LANES, dot};
use crate::parameters::Parameters;
use crate::signals::{Direct, Inputs, Measured, Rates, Uncertainty, read_singly};

impl Plant {
    /// The measured outputs.
    #[must_use]
    #[inline]
    pub fn measured(&self) -> Measured {
        // A step has just written them, in its own way.
        measured(&self.state.position.each_ref().map(read_singly), &self.signals)
    }

    /// The outputs that depend on the inputs directly.
    #[must_use]
    #[inline]
    pub fn direct(&self, inputs: &Inputs) -> Direct {
        let commands = inputs.commands();
        let applied = std::array::from_fn(|i| self.model.actuators[i].output(commands[i]));
        if let Some(contacts) = &self.contacts {
            return opening_direct(&applied, self.opening_force(contacts, inputs));
        }
        self.model.direct(&self.signals, &applied, &inputs.disturbances())
    }

    /// Whether a tip may have pulled at the object instead of pressing when the last step had been made: whether with its inputs a
    /// [contact force](Self::contact_force) was negative, to rounding. True of a grasp that can open.
    #[must_use]
    #[inline]
    pub fn may_have_pulled(&self) -> bool {
        self.pulls
    }

    /// What [`Self::may_have_pulled`] is after a step with these inputs.
    pub(super) fn may_pull(&self, inputs: &Inputs) -> bool {
        self.model.pulls(Model::of_tips(&self.signals), self.model.forces(inputs)[2])
    }

    /// The contact forces alone \[N\], as in [`Self::direct`].
    #[must_use]
    pub fn contact_force(&self, inputs: &Inputs) -> [f64; 2] {
        if let Some(contacts) = &self.contacts {
            return self.opening_force(contacts, inputs);
        }
        let applied = self.model.actuators[2].output(inputs.force_command);
        let [first, second] = self.model.lambda(&self.signals, applied + inputs.object_disturbance);
        [-first, second]
    }

    #[inline(never)]
    fn opening_force(&self, contacts: &Contacts, inputs: &Inputs) -> [f64; 2] {
        contacts.force(&self.state, &self.model.forces(inputs))
    }

    /// The contacts: closed gaps and no losses, unless the grasp can open.
    #[must_use]
    pub fn contact(&self) -> Contact {
        self.contacts.as_ref().map_or_else(Contact::default, |contacts| contacts.contact(&self.state))
    }

    /// Whether the actuators are at their limits with these commands: those of the hubs, that of the object.
    #[must_use]
    #[inline]
    pub fn limited(&self, inputs: &Inputs) -> [bool; FORCES] {
        let commands = inputs.commands();
        std::array::from_fn(|i| self.model.actuators[i].is_limited(commands[i]))
    }

    /// Whether any of them was in the last step.
    #[must_use]
    #[inline]
    pub fn was_any_limited(&self) -> bool {
        self.limited
    }

    /// What [`Self::was_any_limited`] is after a step with these inputs.
    pub(super) fn is_any_limited(&self, inputs: &Inputs) -> bool {
        let [commands, _] = inputs.fresh_lanes();
        self.model.is_any_limited(commands)
    }

    /// The exact directional derivative ∂direct/∂inputs · `direction` at `inputs`, with the actuators' slopes there.
    /// No other output depends on the inputs directly.
    #[must_use]
    pub fn direct_derivative(&self, inputs: &Inputs, direction: &Inputs) -> Direct {
        let applied = self.model.command_response(inputs, direction);
        if let Some(contacts) = &self.contacts {
            let change = self.model.force_rates(inputs, direction);
            let force = contacts.force_derivative(&self.state, &self.model.forces(inputs), &change);
            return opening_direct(&applied, force);
        }
        self.model.direct(&Signals::default(), &applied, &direction.disturbances())
    }

    /// The built-in uncertainties at this moment.
    #[must_use]
    pub fn uncertainty(&self) -> Uncertainty {
        let mut signals = self.signals;
        if let Some(modal) = self.modal_of_state() {
            let [first, second] = modal.root_moment_rates(&self.state.coordinates);
            (signals[ROOT_MOMENT_RATE[0]], signals[ROOT_MOMENT_RATE[1]]) = (first, second);
        }
        held(self.state.contact.as_deref(), uncertainty(&self.model.parameters, &signals))
    }

    /// Deflections w_i at eleven equally spaced points x = 0 … l \[m\], by arm.
    #[must_use]
    #[inline(never)]
    pub fn deflection(&self) -> [[f64; DEFLECTION_POINTS]; 2] {
        let mut buffer = [0.0; MAX_COORDINATES];
        let x = self.energy_coordinates_in(&mut buffer);
        [0, 1].map(|arm| self.model.dynamics.deflection(arm, x))
    }

    /// Tip deflections w_i(l) \[m\].
    #[must_use]
    pub fn tip_deflection(&self) -> [f64; 2] {
        match self.modal_of_state() {
            Some(modal) => modal.tip_deflection(&self.state.coordinates),
            None => self.model.tip_deflection(&self.state.coordinates),
        }
    }

    /// The constraints φ_i = l θ_i − w_i(l) − `y_M` + L/2 \[m\], eq. (12). They are invariants of the discrete motion, not
    /// enforced: zero up to rounding.
    #[must_use]
    pub fn constraint(&self) -> [f64; 2] {
        let p = &self.model.parameters;
        let constraint = self.model.constraint(&self.tip_deflection(), &self.state.position);
        constraint.map(|value| value + p.object_width / 2.0)
    }

    /// Kinetic and strain energy \[J\].
    #[must_use]
    pub fn energy(&self) -> f64 {
        let mut buffer = [0.0; MAX_COORDINATES];
        let x = self.energy_coordinates_in(&mut buffer);
        0.5 * dot(x, x)
    }

    /// Work done since the start by actuators and external disturbances \[J\], exact for every step. Without built-in
    /// uncertainties and Kelvin–Voigt damping, energy − supplied energy is constant. Kelvin–Voigt damping only dissipates
    /// energy. The built-in uncertainties mostly do too, but ΔF depends on the rates of both arms and can do work on one of
    /// them, especially if one is much stiffer than the other.
    #[must_use]
    pub fn supplied_energy(&self) -> f64 {
        self.state.supplied_energy
    }

    /// Time derivatives of all outputs for inputs that change with the given rates: analytic, from ẋ = A x + B g.
    #[must_use]
    #[inline(never)]
    pub fn rates(&self, inputs: &Inputs, input_rates: &Inputs) -> Rates {
        if let Some(contacts) = &self.contacts {
            return self.opening_rates(contacts, inputs, input_rates);
        }
        let Model { dynamics, parameters, .. } = &*self.model;
        let mut coordinates = [0.0; MAX_COORDINATES];
        let x = self.energy_coordinates_in(&mut coordinates);
        let n = x.len();
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
            constraint: self.model.constraint(&self.model.tip_deflection(rate), &velocity),
            energy: dot(x, rate),
            supplied_energy: dot(&forces, &velocity),
            contact: Contact::default(),
        }
    }

    /// [`Self::rates`] where the grasp can open.
    fn opening_rates(&self, contacts: &Contacts, inputs: &Inputs, input_rates: &Inputs) -> Rates {
        let Model { dynamics, parameters, .. } = &*self.model;
        let x = &self.state.coordinates[..];
        let (forces, force_rates) = (self.model.forces(inputs), self.model.force_rates(inputs, input_rates));
        let moment = contacts.moment(&self.state, &forces, &force_rates);
        let rate = &moment.coordinates.as_flattened()[..x.len()];
        let signals = contacts.signals(rate);
        let velocity = VELOCITY.map(|index| self.signals[index]);
        Rates {
            measured: measured(&velocity, &signals),
            direct: opening_direct(&self.model.command_response(inputs, input_rates), moment.force),
            uncertainty: held(self.state.contact.as_deref(), uncertainty(parameters, &signals)),
            deflection: [0, 1].map(|arm| dynamics.deflection(arm, rate)),
            tip_deflection: self.model.tip_deflection(rate),
            constraint: self.model.constraint(&self.model.tip_deflection(rate), &velocity),
            energy: dot(x, rate),
            supplied_energy: dot(&forces, &velocity),
            contact: moment.contact,
        }
    }
}

/// Direct outputs from contact forces.
pub(super) fn opening_direct(applied: &[f64; FORCES], contact_force: [f64; 2]) -> Direct {
    let lambda = Contacts::lambda(contact_force);
    Direct { torque: [applied[0], applied[1]], force: applied[2], lambda, contact_force }
}

/// The built-in ΔF is there while both tips touch.
pub(super) fn held(contact: Option<&ContactState>, uncertainty: Uncertainty) -> Uncertainty {
    match contact {
        Some(contact) if contact.touching != [true; 2] => Uncertainty { delta_force: 0.0, ..uncertainty },
        _ => uncertainty,
    }
}

#[inline]
pub(super) fn measured(position: &[f64; 3], signals: &Signals) -> Measured {
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

pub(super) fn uncertainty(parameters: &Parameters, signals: &Signals) -> Uncertainty {
    let [delta_f1, delta_f2, delta_force] = builtin_forces(parameters, signals);
    Uncertainty {
        delta_f: [delta_f1, delta_f2],
        delta_force,
        root_moment_dot: ROOT_MOMENT_RATE.map(|index| signals[index]),
    }
}

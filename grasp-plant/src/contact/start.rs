//! The start of a grasp that can open.
//!
//! The start values of hubs and object decide: where the straight arm does not reach the object, it starts straight and turns
//! with its hub, and there is a gap. Where it would reach into the object, it starts pressed against it: with a rigid face the
//! static cubic that the bilateral plant has; with a compliant one arm and face share the way, and its rate, as their static
//! stiffnesses 3EI/l³ and k do.

use super::layout::SIGN;
use super::{ContactState, Modes};
use crate::beam::Beam;
use crate::parameters::Parameters;
use crate::state::{Basis, State};
use crate::step_sizes::StepSizes;

pub(super) fn state(parameters: &Parameters, modes: &Modes) -> State {
    let (p, layout, start) = (parameters, modes.layout, &parameters.start);
    let mut x = vec![0.0; layout.size()];
    let mut contact = ContactState::default();
    for arm in 0..2 {
        let beam = Beam::new(&p.arms[arm], p.length, p.order);
        // Tip of the straight arm above the object's face, and its rate.
        let above = p.length * start.theta[arm] - start.y_object + p.object_width / 2.0;
        let above_rate = p.length * start.theta_dot[arm] - start.y_object_dot;
        let (gap, gap_rate) = (SIGN[arm] * above, SIGN[arm] * above_rate);
        let touching = gap < 0.0 || (gap == 0.0 && gap_rate <= 0.0);
        // How much of the way the arm takes.
        let share = match (touching, modes.rigid) {
            (false, _) => 0.0,
            (true, true) => 1.0,
            (true, false) => {
                let arm_stiffness = 1.0 / (beam.tip_compliance * beam.tip_compliance);
                p.faces[arm].stiffness / (p.faces[arm].stiffness + arm_stiffness)
            }
        };
        let (tip, tip_rate) = (share * above, share * above_rate);
        x[layout.moments(arm)] = tip / beam.tip_compliance;
        let fields = beam.rotation.iter().zip(&beam.static_shape);
        for (velocity, (rotation, shape)) in x[layout.field(arm)..].iter_mut().zip(fields) {
            *velocity = start.theta_dot[arm] * rotation - tip_rate * shape;
        }
        x[layout.hub(arm)] = p.arms[arm].hub_inertia.sqrt() * start.theta_dot[arm];
        let tip_velocity =
            if touching && modes.rigid { start.y_object_dot } else { p.length * start.theta_dot[arm] - tip_rate };
        x[layout.tip(arm)] = p.arms[arm].tip_mass.sqrt() * tip_velocity;
        contact.touching[arm] = touching;
        if !(touching && modes.rigid) {
            contact.clearance[arm] = (1.0 - share) * gap;
        }
        if touching && !modes.rigid {
            x[layout.face(arm)] = -p.faces[arm].stiffness.sqrt() * contact.clearance[arm];
        }
    }
    x[layout.object()] = p.object_mass.sqrt() * start.y_object_dot;
    State {
        basis: Basis::Energy,
        coordinates: x.into(),
        position: [start.theta[0], start.theta[1], start.y_object],
        carry: [0.0; 3],
        supplied_energy: 0.0,
        sizes: StepSizes::default(),
        contact: Some(Box::new(contact)),
    }
}

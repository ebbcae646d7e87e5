//! A consistent state for any start values.
//!
//! The deflection w_i(x, 0) is the static cubic of (16), scaled to the tip deflection that the constraint (12) demands,
//! w_i(l, 0) = l θ_i(0) − y_M(0) + L/2. The velocity field is the same cubic with the rate that the differentiated
//! constraint demands, ẇ_i(l, 0) = l θ̇_i(0) − ẏ_M(0). The grasp starts as if loaded quasi-statically, with the least
//! strain energy and the least bending rate that the start values allow. Both satisfy (9).

use crate::dynamics::Dynamics;
use crate::parameters::Parameters;

/// Energy coordinates x at the start.
pub(crate) fn coordinates(parameters: &Parameters, dynamics: &Dynamics) -> Vec<f64> {
    let p = parameters;
    let (k, start) = (p.order, &p.start);
    let mut x = vec![0.0; dynamics.size()];
    let (moments, velocities) = x.split_at_mut(2 * k);
    for i in 0..2 {
        let tip = p.length * start.theta[i] - start.y_object + p.object_width / 2.0;
        let tip_rate = p.length * start.theta_dot[i] - start.y_object_dot;
        moments[dynamics.tip_coordinate(i)] = tip / dynamics.tip_compliance[i];
        let fields = dynamics.rotation[i].iter().zip(&dynamics.static_shape[i]);
        for (velocity, (rotation, shape)) in velocities[i * (k - 1)..].iter_mut().zip(fields) {
            *velocity = start.theta_dot[i] * rotation - tip_rate * shape;
        }
        velocities[2 * (k - 1) + i] = p.arms[i].hub_inertia.sqrt() * start.theta_dot[i];
    }
    velocities[2 * k] = p.moving_mass().sqrt() * start.y_object_dot;
    dynamics.reflect(velocities);
    x
}

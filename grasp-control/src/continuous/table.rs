//! Names, units and magnitudes of the states.

use super::{nabfc_states, state};
use crate::laws::nabfc::RbfLayout;
use parameter_table::StateVariable;

/// Name of a position, of a force, and of what moves; units and magnitudes of position, rate and force.
type Coordinate = (&'static str, &'static str, &'static str, [&'static str; 3], [f64; 3]);

const COORDINATES: [Coordinate; 3] = [
    ("theta1", "tau1", "hub 1", ["rad", "rad/s", "N.m"], [0.05, 0.5, 0.1]),
    ("theta2", "tau2", "hub 2", ["rad", "rad/s", "N.m"], [0.05, 0.5, 0.1]),
    ("y_object", "u", "the object", ["m", "m/s", "N"], [0.05, 0.05, 0.1]),
];

/// A row, its texts in pieces. There are some dozens of them, each of which would be longer with a format of its own.
#[inline(never)]
fn row(name: &[&str], unit: &'static str, nominal: f64, description: &[&str]) -> StateVariable {
    StateVariable { name: name.concat(), unit, nominal, description: description.concat() }
}

#[inline]
fn observers() -> Vec<StateVariable> {
    let mut rows = Vec::new();
    for (name, force, of, units, nominals) in COORDINATES {
        rows.push(row(&["observed_", name], units[0], nominals[0], &["Observed position of ", of]));
        rows.push(row(&["observed_", name, "_dot"], units[1], nominals[1], &["Observed rate of ", of]));
        let disturbance = ["observed_", force, "_disturbance"];
        rows.push(row(&disturbance, units[2], nominals[2], &["Observed disturbance of ", of]));
    }
    rows
}

/// Continuous states of PD and PDS, also of those with estimated rates.
#[must_use]
#[inline]
pub fn pds_state_variables() -> Vec<StateVariable> {
    let mut rows = observers();
    for (_, force, of, units, nominals) in COORDINATES {
        let text = ["Integral of the position error of ", of, " times its gain"];
        rows.push(row(&[force, "_integral"], units[2], nominals[2], &text));
    }
    rows
}

/// Numbers of the arms.
const ARMS: [&str; 2] = ["1", "2"];

/// Continuous states of NABFC with these networks, of both laws.
#[must_use]
#[inline]
pub fn nabfc_state_variables(layout: &RbfLayout) -> Vec<StateVariable> {
    let mut rows = observers();
    for arm in ARMS {
        let text = ["Paper's law: rate of the tip shear of arm ", arm, " behind the low-pass"];
        rows.push(row(&["filtered_tip_shear", arm, "_dot"], "N/s", 10.0, &text));
    }
    for arm in ARMS {
        let text = ["Root-strain law: root moment of arm ", arm, " behind the low-pass for its rate"];
        rows.push(row(&["slow_root_moment", arm], "N.m", 0.1, &text));
    }
    for arm in ARMS {
        let text = ["Paper's law: estimated inertia of hub ", arm, ", eq. (57)"];
        rows.push(row(&["adapted_J", arm], "kg.m2", 1e-3, &text));
    }
    rows.push(row(&["adapted_m"], "kg", 0.1, &["Paper's law: estimated moving mass, eq. (39)"]));
    for arm in ARMS {
        let text = ["Bound of posture network ", arm, "'s error, eq. (56)"];
        rows.push(row(&["adapted_pi", arm], "N.m", 0.1, &text));
    }
    rows.push(row(&["adapted_epsilon"], "N", 0.1, &["Bound of the object network's error, eq. (38)"]));
    let (turning, pushing) = (
        ["rad/s", "N.m", "N.m", "rad/s2", "N.m", "N.m/s", "N2.m2.s", "N2.m2/s", "N2.m2", "N.m.rad/s", "N.m.rad/s2"],
        ["m/s", "N", "N", "m/s2", "N", "N/s", "N2.s", "N2/s", "N2", "N.m/s", "N.m/s2"],
    );
    for (name, of, units, nominals) in [
        ("J1", "hub 1", turning, [0.5, 0.1, 0.1, 1.0, 0.1, 1.0, 1e-3, 1e-1, 1e-2, 1e-1, 1.0]),
        ("J2", "hub 2", turning, [0.5, 0.1, 0.1, 1.0, 0.1, 1.0, 1e-3, 1e-1, 1e-2, 1e-1, 1.0]),
        ("m", "the object", pushing, [0.05, 0.1, 1.0, 0.1, 0.1, 10.0, 1e-3, 1.0, 1e-2, 1e-3, 0.1]),
    ] {
        let texts = [
            ("rate", "low-passed rate"),
            ("force", "low-passed force"),
            ("load", "low-passed load"),
            ("slow_acceleration", "slow part of the acceleration"),
            ("slow_force", "slow part of the force"),
            ("slow_load_rate", "slow part of the load's rate"),
            ("ff", "sum of squared forces"),
            ("nn", "sum of squared load rates"),
            ("nf", "sum of load rates times forces"),
            ("af", "sum of accelerations times forces"),
            ("an", "sum of accelerations times load rates"),
        ];
        for (((signal, text), unit), nominal) in texts.into_iter().zip(units).zip(nominals) {
            let text = ["Root-strain law's estimate of the inertia of ", of, ": ", text];
            rows.push(row(&["estimate_", name, "_", signal], unit, nominal, &text));
        }
    }
    for arm in ARMS {
        let text = ["Root moment of arm ", arm, " behind the low-pass of the surfaces"];
        rows.push(row(&["filtered_root_moment", arm], "N.m", 0.1, &text));
    }
    for arm in ARMS {
        let text = ["Root-strain law: tip shear of arm ", arm, " behind the low-pass for its rate"];
        rows.push(row(&["slow_tip_shear", arm], "N", 1.0, &text));
    }
    for arm in ARMS {
        for node in 1..=layout.posture().nodes(3) {
            let node = node.to_string();
            let text = ["Weight ", &node, " of posture network ", arm, ", eq. (55)"];
            rows.push(row(&["U", arm, "[", &node, "]"], "N.m", 0.01, &text));
        }
    }
    for node in 1..=layout.object().nodes(7) {
        let node = node.to_string();
        let text = ["Weight ", &node, " of the object network, eq. (37)"];
        rows.push(row(&["W[", &node, "]"], "N", 0.01, &text));
    }
    debug_assert!(rows.len() == nabfc_states(layout) && state::WEIGHTS < rows.len());
    rows
}

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

fn observers() -> impl Iterator<Item = StateVariable> {
    COORDINATES.into_iter().flat_map(|(name, force, of, units, nominals)| {
        [
            StateVariable::new(format!("observed_{name}"), units[0], nominals[0], format!("Observed position of {of}")),
            StateVariable::new(format!("observed_{name}_dot"), units[1], nominals[1], format!("Observed rate of {of}")),
            StateVariable::new(
                format!("observed_{force}_disturbance"),
                units[2],
                nominals[2],
                format!("Observed disturbance of {of}"),
            ),
        ]
    })
}

/// Continuous states of PD and PDS, also of those with estimated rates.
#[must_use]
pub fn pds_state_variables() -> Vec<StateVariable> {
    let integrals = COORDINATES.into_iter().map(|(_, force, of, units, nominals)| {
        StateVariable::new(
            format!("{force}_integral"),
            units[2],
            nominals[2],
            format!("Integral of the position error of {of} times its gain"),
        )
    });
    observers().chain(integrals).collect()
}

/// Continuous states of NABFC with these networks, of both laws.
#[must_use]
pub fn nabfc_state_variables(layout: &RbfLayout) -> Vec<StateVariable> {
    let mut rows: Vec<_> = observers().collect();
    let mut row = |name: String, unit, nominal, description: &str| {
        rows.push(StateVariable::new(name, unit, nominal, description));
    };
    for (signal, unit, nominal, called) in
        [("tip_shear", "N/s", 10.0, "tip shear"), ("root_moment", "N.m/s", 1.0, "root moment")]
    {
        for arm in 1..=2 {
            let text = format!("Rate of the {called} of arm {arm} behind the low-pass");
            row(format!("filtered_{signal}{arm}_dot"), unit, nominal, &text);
        }
    }
    for arm in 1..=2 {
        row(
            format!("adapted_J{arm}"),
            "kg.m2",
            1e-3,
            &format!("Paper's law: estimated inertia of hub {arm}, eq. (57)"),
        );
    }
    row("adapted_m".into(), "kg", 0.1, "Paper's law: estimated moving mass, eq. (39)");
    for arm in 1..=2 {
        row(format!("adapted_pi{arm}"), "N.m", 0.1, &format!("Bound of posture network {arm}'s error, eq. (56)"));
    }
    row("adapted_epsilon".into(), "N", 0.1, "Bound of the object network's error, eq. (38)");
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
            let text = format!("Root-strain law's estimate of the inertia of {of}: {text}");
            row(format!("estimate_{name}_{signal}"), unit, nominal, &text);
        }
    }
    for arm in 1..=2 {
        let text = format!("Root moment of arm {arm} behind the low-pass of the surfaces");
        row(format!("filtered_root_moment{arm}"), "N.m", 0.1, &text);
    }
    for arm in 1..=2 {
        for node in 1..=layout.posture().nodes(3) {
            row(format!("U{arm}[{node}]"), "N.m", 0.01, &format!("Weight {node} of posture network {arm}, eq. (55)"));
        }
    }
    for node in 1..=layout.object().nodes(7) {
        row(format!("W[{node}]"), "N", 0.01, &format!("Weight {node} of the object network, eq. (37)"));
    }
    debug_assert!(rows.len() == nabfc_states(layout) && state::WEIGHTS < rows.len());
    rows
}

//! Constraint, energy, momentum.

use nalgebra::{DMatrix, DVector};

use super::oracle;
use super::rig::{Rig, Settings, settings};
use super::{Check, Fmus, Subject, VerifyError};
use crate::grasp;
use fmi2_cosim::settings::Setting;

fn check(what: &str, exact: &str, found: String, error: f64, bound: f64, unit: &'static str) -> Check {
    Check { subject: Subject::Conservation, what: what.into(), exact: exact.into(), found, error, bound, unit }
}

/// All of them.
///
/// # Errors
/// When an FMU fails.
pub fn checks(fmus: &Fmus) -> Result<Vec<Check>, VerifyError> {
    let mut checks = constraint(fmus)?;
    checks.push(conservative_energy(fmus)?);
    for (plant, name) in [("paper", "the paper's plant"), ("unequal", "unequal arms")] {
        checks.push(energy_with_uncertainties(fmus, plant, name)?);
    }
    checks.push(momentum(fmus)?);
    Ok(checks)
}

/// (12) along the paper's three scenarios, the start at rest as well as one that is not.
fn constraint(fmus: &Fmus) -> Result<Vec<Check>, VerifyError> {
    fmus.controllers
        .iter()
        .zip(grasp::PAPER)
        .map(|(controller, paper)| {
            let mut start =
                settings([("theta1_0", 0.02), ("theta2_0", -0.01), ("theta1_dot_0", 0.1), ("y_object_dot_0", -0.02)]);
            start.extend(paper.settings());
            let rows =
                Rig::record(&[&fmus.plant, controller], &start, (2.0, 1e-4, 1e-3), &["constraint1", "constraint2"])?;
            let worst = rows.iter().flat_map(|row| &row[1..]).fold(0.0_f64, |worst, value| worst.max(value.abs()));
            let what = format!("constraint (12) over 2 s, {}", controller.description().model_name);
            // A micrometre would be visible; this is round-off of 20 000 steps of quantities of 0.05 m.
            Ok(check(&what, "0", format!("{worst:.1e} m"), worst, 1e-14, "m"))
        })
        .collect()
}

/// Drives the plant's six inputs with jumps at incommensurable rates.
fn drive(time: f64) -> [f64; 6] {
    #[allow(clippy::cast_possible_truncation)] // less than a hundred
    let sign = |rate: f64| if (time * rate) as i64 % 2 == 0 { 1.0 } else { -1.0 };
    [
        0.06 * (sign(7.3) + 0.5 * sign(31.7)),
        -0.08 * sign(11.9),
        0.4 * sign(5.1), // beyond the limit of 0.3 N
        0.01 * sign(3.7),
        0.0,
        0.05 * sign(13.3),
    ]
}

const INPUTS: [&str; 6] = ["tau1_cmd", "tau2_cmd", "u_cmd", "delta_f1", "delta_f2", "delta_F"];

/// Without uncertainties and damping the energy equals the supplied energy, also with saturated actuators.
fn conservative_energy(fmus: &Fmus) -> Result<Check, VerifyError> {
    const STEP: f64 = 1e-4;
    let start = settings([("root_uncertainty", 0.0), ("tip_uncertainty", 0.0), ("theta1_dot_0", 0.2)]);
    let mut rig = Rig::new(&[&fmus.plant], &start, STEP)?;
    let (input, energy) = (rig.port(0, &INPUTS)?, rig.port(0, &["energy", "supplied_energy"])?);
    let begin = rig.get(&energy)?[0];
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for step in 0..20_000 {
        rig.set(&input, &drive(f64::from(step) * STEP))?;
        rig.advance(1)?;
        let now = rig.get(&energy)?;
        worst = worst.max((now[0] - begin - now[1]).abs());
        largest = largest.max(now[0]);
    }
    let found = format!("{worst:.1e} J, of {largest:.2e} J");
    Ok(check("energy − supplied energy, 2 s, jumping and saturated inputs", "0", found, worst, 1e-14, "J"))
}

/// With the built-in uncertainties: their work ∫(Δf₁ θ̇₁ + Δf₂ θ̇₂ + ΔF ẏ) is computed from the FMU's outputs.
///
/// The integral is the corrected trapezoidal rule, `h/2 (f₀ + f₁) + h²/12 (f₀' − f₁')`, of the outputs and their
/// derivatives. Its difference to the integral with twice the step bounds its error (of fourth order: the error is a
/// fifteenth).
fn energy_with_uncertainties(fmus: &Fmus, plant: &str, name: &str) -> Result<Check, VerifyError> {
    const STEP: f64 = 1e-5;
    const STEPS: u32 = 40_000;
    const FORCES: [&str; 3] = ["hub_uncertainty1", "hub_uncertainty2", "object_uncertainty"];
    const SPEEDS: [&str; 3] = ["theta1_dot", "theta2_dot", "y_object_dot"];
    let mut values: Settings = oracle::plant(plant, true, 8);
    // The inputs are held for the whole run, so the power is smooth. A small order has no modes that the quadrature would
    // miss.
    values.extend(settings([
        ("tau1_cmd", 0.08),
        ("tau2_cmd", -0.03),
        ("u_cmd", 0.05),
        ("delta_f2", 0.02),
        ("delta_F", -0.1),
    ]));
    values.extend(settings([("theta1_0", 0.02), ("theta2_0", -0.01), ("y_object_0", 0.051)]));
    values.push(Setting::new("order", 6));
    let mut rig = Rig::new(&[&fmus.plant], &values, STEP)?;
    let names: Vec<&str> = FORCES.into_iter().chain(SPEEDS).collect();
    let (signals, energy) = (rig.port(0, &names)?, rig.port(0, &["energy", "supplied_energy"])?);
    let begin = rig.get(&energy)?;
    let mut power = Vec::with_capacity(STEPS as usize + 1);
    for step in 0..=STEPS {
        let (value, rate) = (rig.get(&signals)?, rig.rates(&signals)?);
        let sum = |a: &[f64], b: &[f64]| (0..3).map(|i| a[i] * b[3 + i]).sum::<f64>();
        power.push((sum(&value, &value), sum(&rate, &value) + sum(&value, &rate)));
        if step < STEPS {
            rig.advance(1)?;
        }
    }
    let integral = |stride: usize| -> f64 {
        let h = STEP * stride as f64;
        let part = |(a, b): (&(f64, f64), &(f64, f64))| h / 2.0 * (a.0 + b.0) + h * h / 12.0 * (a.1 - b.1);
        power.iter().step_by(stride).zip(power.iter().step_by(stride).skip(1)).map(part).sum()
    };
    let (fine, coarse) = (integral(1), integral(2));
    let end = rig.get(&energy)?;
    let change = end[0] - begin[0] - (end[1] - begin[1]);
    Ok(check(
        &format!("energy − supplied energy = work of Δf₁, Δf₂, ΔF over 0.4 s, {name}"),
        &format!("{fine:.12e} J"),
        format!("{change:.12e} J"),
        (change - fine).abs(),
        (fine - coarse).abs() + 1e-14,
        "J",
    ))
}

/// Σ(J θ + ∫ρ x (xθ − w) dx) + m l (y − L/2) moves with the constant acceleration τ₁ + τ₂ + l u, whatever the motion of the
/// arms.
///
/// w is a polynomial of degree 10 at order 8, so the eleven deflections determine the integral exactly.
fn momentum(fmus: &Fmus) -> Result<Check, VerifyError> {
    const LENGTH: f64 = 0.2;
    const STEP: f64 = 1e-3;
    const MASS: f64 = 0.5;
    let inertia = [0.0073, 0.0061];
    let rho = [0.054, 0.08];
    let speeds = [0.3, -0.2, 0.05];
    let loads = [0.02, -0.05, 0.1];
    let mut values = settings([
        ("root_uncertainty", 0.0),
        ("tip_uncertainty", 0.0),
        ("EI2", 0.2),
        ("J2", inertia[1]),
        ("rho2", rho[1]),
        ("theta1_dot_0", speeds[0]),
        ("theta2_dot_0", speeds[1]),
        ("y_object_dot_0", speeds[2]),
        ("tau1_cmd", loads[0]),
        ("tau2_cmd", loads[1]),
        ("u_cmd", loads[2]),
    ]);
    values.push(Setting::new("actuator_model", "ideal"));
    // ∫ξ p(ξ) dξ over [0, 1] from values at eleven points: exact for the powers 0 to 10.
    let node = |i: usize| i as f64 / 10.0;
    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // 0 to 10
    let powers = DMatrix::from_fn(11, 11, |power, i| node(i).powi(power as i32));
    let moments = DVector::from_fn(11, |power, _| 1.0 / (power + 2) as f64);
    let weights = powers.lu().solve(&moments).unwrap_or_else(|| DVector::repeat(11, f64::NAN));

    let points: Vec<String> = (1..=2).flat_map(|arm| (1..=11).map(move |i| format!("deflection{arm}[{i}]"))).collect();
    let mut names = vec!["theta1", "theta2", "y_object"];
    names.extend(points.iter().map(String::as_str));
    let rows = Rig::record(&[&fmus.plant], &values, (1.0, STEP, 0.0), &names)?;
    let mut start = MASS * LENGTH * speeds[2];
    for arm in 0..2 {
        // ẇ(x, 0) is the static cubic of the tip's speed: ∫x ẇ dx = (3/8 − 1/10) l² ẇ(l).
        let tip = LENGTH * speeds[arm] - speeds[2];
        start +=
            inertia[arm] * speeds[arm] + rho[arm] * (LENGTH.powi(3) / 3.0 * speeds[arm] - 0.275 * LENGTH.powi(2) * tip);
    }
    let (mut worst, mut largest, mut found) = (0.0_f64, 0.0_f64, 0.0);
    for row in &rows {
        let (time, values) = (row[0], &row[1..]);
        let mut moved = MASS * LENGTH * (values[2] - 0.05);
        for arm in 0..2 {
            let bent: f64 = (0..11).map(|i| weights[i] * values[3 + 11 * arm + i]).sum();
            moved +=
                inertia[arm] * values[arm] + rho[arm] * (LENGTH.powi(3) / 3.0 * values[arm] - LENGTH.powi(2) * bent);
        }
        let exact = start * time + 0.5 * (loads[0] + loads[1] + LENGTH * loads[2]) * time * time;
        worst = worst.max((moved - exact).abs());
        largest = largest.max(exact.abs());
        found = moved;
    }
    let exact = start + 0.5 * (loads[0] + loads[1] + LENGTH * loads[2]);
    Ok(check(
        "∫ of the momentum about the hubs, unequal arms, constant loads, 1 s",
        &format!("{exact:.14} kg·m²"),
        format!("{found:.14} kg·m²"),
        worst / largest,
        1e-12,
        "1",
    ))
}

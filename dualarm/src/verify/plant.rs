//! Checks of the plant against the exact solution of the beam equations, and its convergence over the order of the
//! discretisation.

use super::identify;
use super::oracle::{self, EXACT, Pole, elements, entries, number};
use super::rig::{Rig, Settings, settings};
use super::{Check, Fmus, Subject, VerifyError};
use crate::report::figures::NamedFigure;
use charts::chart::{Curve, Figure, Panel, palette};
use grasp_certify::realisation::nearest;
use nalgebra::ComplexField;

const COMMANDS: [&str; 3] = ["tau1_cmd", "tau2_cmd", "u_cmd"];

fn written(pole: Pole) -> String {
    match (pole.re == 0.0, pole.im == 0.0) {
        (true, _) => format!("±{:.9}j 1/s", pole.im),
        (_, true) => format!("{:.9} 1/s", pole.re),
        _ => format!("{:.8} ± {:.8}j 1/s", pole.re, pole.im),
    }
}

/// Checks of identified poles: only the worst one, or each.
pub(super) fn pole_checks(
    subject: Subject,
    title: &str,
    found: &[(Pole, Pole)],
    bounds: impl Fn(usize) -> f64,
    each: bool,
) -> Vec<Check> {
    let check = |index: usize, count: Option<usize>| {
        let (exact, got) = found[index];
        // For conservative systems the relative error is that of the frequency; any decay counts as error too.
        let name = count.map_or(String::new(), |count| format!(", worst of {count}"));
        Check {
            subject,
            what: format!("{title}{name}"),
            exact: written(exact),
            found: written(if exact.re == 0.0 { Pole::new(0.0, got.im) } else { got }),
            error: (got - exact).modulus() / exact.modulus(),
            bound: bounds(index),
            unit: "1",
        }
    };
    let ratio = |index: usize| {
        let (exact, got) = found[index];
        (got - exact).modulus() / exact.modulus() / bounds(index)
    };
    if each {
        return (0..found.len()).map(|index| check(index, None)).collect();
    }
    let worst = (0..found.len()).max_by(|&a, &b| ratio(a).total_cmp(&ratio(b)));
    worst.map(|worst| check(worst, Some(found.len()))).into_iter().collect()
}

/// Identified counterparts of exact poles.
fn identified(fmus: &Fmus, settings: &Settings, exact: &[Pole], step: f64) -> Result<Vec<(Pole, Pole)>, VerifyError> {
    let found = identify::eigenvalues(&[&fmus.plant], settings, COMMANDS, step, 1)?;
    Ok(exact.iter().map(|&pole| (pole, nearest(&found, pole, step))).collect())
}

/// A sampling time below half a period of the fastest wanted mode.
fn sample(exact: &[Pole]) -> f64 {
    exact.iter().fold(1e-3, |step, pole| step.min(0.5 / pole.im))
}

/// Natural frequencies without, poles with uncertainties and Kelvin–Voigt damping.
///
/// # Errors
/// When the FMU fails.
pub fn eigenvalues(fmus: &Fmus) -> Result<Vec<Check>, VerifyError> {
    let mut checks = Vec::new();
    let free = |name: &str| oracle::poles(&format!("{name}_free"))[..5].to_vec();
    let exact = free("paper");
    // Order 8 has two pairs of beam modes right and the third nearly.
    let bounds = |index: usize| if index < 4 { 1e-6 } else { 1e-4 };
    let found = identified(fmus, &oracle::plant("paper", false, 8), &exact, sample(&exact))?;
    checks.extend(pole_checks(Subject::Plant, "natural frequency, order 8", &found, bounds, true));
    for (name, plant) in [
        ("paper", "the paper's plant"),
        ("unequal", "unequal arms"),
        ("light_object", "light object (10 g)"),
        ("heavy_object", "heavy object (5 kg)"),
        ("soft_arms", "soft arms (EI/11.5)"),
        ("stiff_arms", "stiff arms (17 EI)"),
    ] {
        let exact = free(name);
        let found = identified(fmus, &oracle::plant(name, false, 12), &exact, sample(&exact))?;
        let title = format!("natural frequencies, order 12, {plant}");
        checks.extend(pole_checks(Subject::Plant, &title, &found, |_| 1e-9, false));
    }
    for (name, plant) in [
        ("paper", "the paper's plant"),
        ("unequal", "unequal arms"),
        ("kelvin_voigt", "Kelvin–Voigt damping 1 ms"),
        ("unequal_kelvin_voigt", "unequal arms, Kelvin–Voigt damping 1 ms"),
    ] {
        // After a sample of 1 ms too little remains of faster poles to identify them.
        let listed = oracle::poles(&format!("{name}_no_control"));
        let exact: Vec<Pole> = listed.into_iter().filter(|pole| pole.re > -400.0 && pole.im < 1000.0).collect();
        let found = identified(fmus, &oracle::plant(name, true, 12), &exact, 1e-3)?;
        let title = format!("poles with the uncertainties, order 12, {plant}");
        checks.extend(pole_checks(Subject::Plant, &title, &found, |_| 1e-8, name == "paper"));
    }
    Ok(checks)
}

const STEP_OUTPUTS: [(&str, &str); 9] = [
    ("theta1", "rad"),
    ("theta2", "rad"),
    ("y", "m"),
    ("root_moment1", "N·m"),
    ("root_moment2", "N·m"),
    ("tip_shear1", "N"),
    ("tip_shear2", "N"),
    ("lambda1", "N"),
    ("lambda2", "N"),
];

/// Step responses: the output that is closest to its bound, of all outputs and times.
///
/// A polynomial of order k represents about k/4 pairs of beam modes accurately. The bound is the contribution of all later
/// pairs, from the oracle, plus a tenth of the last accurate pair's contribution (its phase is off by up to 0.1 rad after 1
/// s) and the rounding of a thousand steps.
///
/// # Errors
/// When the FMU fails.
pub fn step_responses(fmus: &Fmus) -> Result<Vec<Check>, VerifyError> {
    const ORDER: u32 = 12;
    const STEP: f64 = 1e-3;
    let mut checks = Vec::new();
    for (name, case) in entries(&EXACT["steps"]) {
        let (Some(input), Some(loop_name)) = (case["input"].as_str(), case["loop"].as_str()) else { continue };
        let Some(command) = COMMANDS.into_iter().find(|command| command.strip_suffix("_cmd") == Some(input)) else {
            continue;
        };
        let plant = loop_name.replace("_no_control", "");
        let mut values = oracle::plant(&plant, true, ORDER);
        values.extend(settings([(command, number(&case["amplitude"]))]));
        let names = STEP_OUTPUTS.map(|(name, _)| if name == "y" { "y_object" } else { name });
        let rows = Rig::record(&[&fmus.plant], &values, (1.0, STEP, 0.0), &names)?;
        let mut nearest: Option<(f64, Check)> = None;
        for (column, (output, unit)) in STEP_OUTPUTS.into_iter().enumerate() {
            let at: Vec<_> = elements(&case["at"]).map(|row| (number(&row["t"]), &row["outputs"][output])).collect();
            let size = at.iter().fold(0.0_f64, |size, (_, exact)| size.max(number(&exact["value"]).abs()));
            for (time, exact) in at {
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 10 to 1000
                let row = (time / STEP).round() as usize;
                let found = rows[row][column + 1] - if output == "y" { 0.05 } else { 0.0 };
                let mut bound = number(&exact["error"]) + 2e-11 * size;
                let beyond: Vec<f64> = elements(&exact["beyond"]).map(number).collect();
                if let Some(later) = beyond.get(ORDER as usize / 4) {
                    bound += later + 0.1 * beyond[ORDER as usize / 4 - 1];
                }
                let value = number(&exact["value"]);
                let error = (found - value).abs();
                if nearest.as_ref().is_none_or(|(ratio, _)| error / bound > *ratio) {
                    let check = Check {
                        subject: Subject::Plant,
                        what: format!("step response {name}: {output} at {time} s, worst of 9 outputs × 5 times"),
                        exact: format!("{value:.10} {unit}"),
                        found: format!("{found:.10} {unit}"),
                        error,
                        bound,
                        unit,
                    };
                    nearest = Some((error / bound, check));
                }
            }
        }
        checks.extend(nearest.map(|(_, check)| check));
    }
    Ok(checks)
}

/// Opposite constant hub torques end in the static squeeze of (16): contact forces, angle between the hubs, shape.
///
/// # Errors
/// When the FMU fails.
pub fn static_deflections(fmus: &Fmus) -> Result<Vec<Check>, VerifyError> {
    const LENGTH: f64 = 0.2;
    const TORQUE: f64 = 0.1;
    let mut checks = Vec::new();
    for (name, plant, stop) in [
        ("paper", "the paper's plant", 4.0),
        ("unequal", "unequal arms", 4.0),
        ("soft_arms", "soft arms", 100.0),
        ("stiff_arms", "stiff arms", 4.0),
    ] {
        let mut values = oracle::plant(name, true, 8);
        values.extend(settings([("tau1_cmd", TORQUE), ("tau2_cmd", -TORQUE)]));
        let points: Vec<String> =
            (1..=2).flat_map(|arm| (1..=11).map(move |i| format!("deflection{arm}[{i}]"))).collect();
        let mut names = vec!["contact_force1", "contact_force2", "theta1", "theta2"];
        names.extend(points.iter().map(String::as_str));
        let rows = Rig::record(&[&fmus.plant], &values, (stop, 1e-2, stop), &names)?;
        let last = &rows[rows.len() - 1][1..];
        let force = TORQUE / LENGTH;
        let rigidity = [0, 1].map(|arm| number(&EXACT["plants"][name]["EI"][arm]));
        // The force is positive in compression: λ_1 = −f, λ_2 = +f.
        let angle = force * LENGTH.powi(2) / 3.0 * (1.0 / rigidity[0] + 1.0 / rigidity[1]);
        let tip = force * LENGTH.powi(3) / (3.0 * rigidity[0]);
        let mut shape = 0.0_f64;
        for arm in 0..2 {
            let lambda = if arm == 0 { -force } else { force };
            for point in 0..11 {
                let x = LENGTH * f64::from(point) / 10.0;
                let exact = lambda * x * x / (2.0 * rigidity[arm]) * (x / 3.0 - LENGTH);
                let size = force * LENGTH.powi(3) / (3.0 * rigidity[arm]);
                #[allow(clippy::cast_sign_loss)] // 0 to 10
                let found = last[4 + 11 * arm + point as usize];
                shape = shape.max((found - exact).abs() / size);
            }
        }
        let bound = 1e-11;
        let mut add = |what: String, exact: f64, found: f64, error: f64, unit: &str| {
            let (exact, found) = (format!("{exact:.12} {unit}"), format!("{found:.12} {unit}"));
            checks.push(Check { subject: Subject::Plant, what, exact, found, error, bound, unit: "1" });
        };
        let worse = if (last[0] - force).abs() > (last[1] - force).abs() { last[0] } else { last[1] };
        add(format!("static contact force (13)–(16), {plant}"), force, worse, (worse - force).abs() / force, "N");
        let between = last[2] - last[3];
        add(format!("static θ₁ − θ₂ (16), {plant}"), angle, between, (between - angle).abs() / angle, "rad");
        add(format!("static shape w(x) (16), {plant}: w₁(l), worst of 22 points"), tip, last[14], shape, "m");
    }
    Ok(checks)
}

/// Errors of five natural frequencies of the paper's plant over the order: a figure, and the check of spectral convergence.
///
/// # Errors
/// When the FMU fails.
pub fn convergence(fmus: &Fmus) -> Result<(NamedFigure, Vec<Check>), VerifyError> {
    // Round-off of the identification.
    const FLOOR: f64 = 1e-13;
    // One of each pair, each with a suitable sampling time; otherwise the aliases of the fast ones would hide the slow
    // ones.
    let listed = oracle::poles("paper_free");
    let exact: Vec<Pole> = [0, 2, 4, 6].map(|mode| listed[mode]).to_vec();
    let mut errors: Vec<(u32, Vec<f64>)> = Vec::new();
    for order in 4..=14 {
        let plant = oracle::plant("paper", false, order);
        let mut row = Vec::new();
        for pole in &exact {
            let found = identified(fmus, &plant, &[*pole], sample(&[*pole]))?;
            row.extend(found.iter().map(|(exact, got)| (got - exact).modulus() / exact.modulus()));
        }
        errors.push((order, row));
    }
    let curve = |mode: usize| Curve {
        name: format!("{:.1} rad/s", exact[mode].im),
        color: palette::ALL[mode],
        wide: false,
        points: errors.iter().map(|(order, errors)| (f64::from(*order), errors[mode].max(FLOOR).log10())).collect(),
    };
    let caption = "Spectral convergence: relative errors of natural frequencies over the order".to_owned();
    let note = "One curve per natural frequency: a straight line down would be exponential convergence.".to_owned();
    let figure = Figure {
        title: "Natural frequencies identified from the FMU: error over the order".into(),
        size: (720, 380),
        rows: vec![vec![Panel {
            x_label: Some("order k of the bending moment".into()),
            y_label: "log₁₀ of the relative error".into(),
            x_range: (4.0, 14.0),
            y_include: vec![-13.0, 0.0],
            curves: (0..exact.len()).map(curve).collect(),
            ..Panel::default()
        }]],
    };
    let at = |order: u32| errors.iter().find(|(k, _)| *k == order).map_or(f64::NAN, |(_, errors)| errors[2]);
    let (coarse, fine) = (at(6), at(10));
    let check = Check {
        subject: Subject::Plant,
        what: "spectral convergence: error of mode 5 at order 10 over that at order 6".into(),
        exact: "→ 0 faster than any power of 1/k".into(),
        found: format!("{coarse:.1e} → {fine:.1e}"),
        error: fine / coarse,
        // A method of algebraic order 8 would give (6/10)⁸.
        bound: 0.6_f64.powi(8),
        unit: "1",
    };
    Ok((NamedFigure { name: "convergence".into(), caption, note, figure }, vec![check]))
}

//! Plant and controller co-simulated, against exact poles and against one stiff ODE.

use super::identify;
use super::oracle::{self, MONOLITH, Pole, elements, entries, number};
use super::plant::pole_checks;
use super::rig::{Rig, Settings, settings};
use super::{Check, Fmus, Subject, VerifyError};
use crate::grasp::{self, Controller};
use fmi2_cosim::settings::Setting;
use grasp_certify::realisation::nearest;
use nalgebra::ComplexField;

/// Limit of a quantity as the step goes to zero, from its values at steps that are halved: the diagonal of Richardson's
/// scheme, for an error in whole powers of the step. The second number is the distance of the last two diagonals.
fn extrapolate<T>(mut values: Vec<T>, distance: impl Fn(T, T) -> f64) -> (T, f64)
where
    T: Copy + std::ops::Sub<Output = T> + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let mut before = values[values.len() - 1];
    let mut factor = 2.0;
    while values.len() > 1 {
        before = values[values.len() - 1];
        values = values.windows(2).map(|pair| pair[1] + (pair[1] - pair[0]) * (1.0 / (factor - 1.0))).collect();
        factor *= 2.0;
    }
    (values[0], distance(values[0], before))
}

/// Poles of the linear closed loops, compared with the roots of the characteristic equations. They are identified from
/// responses of the co-simulated FMUs to pulses of the disturbances, at four step sizes, and extrapolated to a step of
/// zero.
///
/// # Errors
/// When an FMU fails.
pub fn poles(fmus: &Fmus) -> Result<Vec<Check>, VerifyError> {
    const STEPS: [f64; 4] = [5e-5, 2.5e-5, 1.25e-5, 6.25e-6];
    const DISTURBANCES: [&str; 3] = ["delta_f1", "delta_f2", "delta_F"];
    let mut checks = Vec::new();
    for (name, plant, controller, title) in [
        ("paper_pds", "paper", "PdsController", "poles with PDS (95)(96)"),
        ("unequal_pds", "unequal", "PdsController", "poles with PDS, unequal arms"),
        ("paper_pd", "paper", "PdController", "poles with PD (97)(98)"),
    ] {
        let controller = fmus.controller(controller)?;
        let mut values: Settings = oracle::plant(plant, true, 12);
        values.extend(settings([("lambda1_ref", 0.0), ("theta1_ref", 0.0)]));
        let mut found: Vec<(Pole, Pole)> = Vec::new();
        // Slow poles need a long record, beam modes a fine one.
        for sample in [0.02, 1e-3] {
            let is_slow = sample > 0.01;
            let exact: Vec<Pole> = oracle::poles(name)
                .into_iter()
                .filter(|pole| pole.re > -110.0 && pole.im < 1000.0 && (pole.modulus() < 20.0) == is_slow)
                .collect();
            let mut found_at = vec![Vec::new(); exact.len()];
            for step in STEPS {
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 20 to 3200
                let steps = (sample / step).round() as u64;
                let all = identify::eigenvalues(&[&fmus.plant, controller], &values, DISTURBANCES, step, steps)?;
                for (list, pole) in found_at.iter_mut().zip(&exact) {
                    list.push(nearest(&all, *pole, sample));
                }
            }
            for (list, pole) in found_at.into_iter().zip(exact) {
                found.push((pole, extrapolate(list, |a: Pole, b| (a - b).modulus()).0));
            }
        }
        checks.extend(pole_checks(Subject::ClosedLoop, title, &found, |_| 1e-7, name != "unequal_pds"));
    }
    Ok(checks)
}

const OUTPUTS: [(&str, &str); 7] = [
    ("theta1", "rad"),
    ("theta2", "rad"),
    ("y_object", "m"),
    ("root_moment1", "N·m"),
    ("tip_shear1", "N"),
    ("contact_force1", "N"),
    ("contact_force2", "N"),
];

/// Compares co-simulations at four step sizes with the monolithic solutions: error at 0.1 ms, order, limit for a step of
/// zero.
///
/// The limit's bound is the distance of the last two extrapolations plus the accuracy of the solution, both at their worst.
///
/// # Errors
/// When an FMU fails.
pub fn against_monolith(fmus: &Fmus) -> Result<Vec<Check>, VerifyError> {
    const STEPS: [f64; 4] = [1e-4, 5e-5, 2.5e-5, 1.25e-5];
    let mut checks = Vec::new();
    for (name, case) in entries(&MONOLITH["cases"]) {
        let title = name.replace("_saturated", ", saturated").to_uppercase().replace("SATURATED", "saturated");
        let controller = fmus.controller(case["controller"].as_str().unwrap_or_default())?;
        let mut values: Settings = settings(entries(&case["settings"]).map(|(name, value)| (name, number(value))));
        values.extend(settings(["lambda1_ref", "theta1_ref"].map(|name| (name, number(&case[name])))));
        values.push(Setting::new("order", number(&case["order"])));
        let is_this =
            |paper: &&Controller| Some(controller.description().model_name.as_str()) == paper.fmu.strip_suffix(".fmu");
        values.extend(grasp::PAPER.iter().find(is_this).into_iter().flat_map(Controller::settings));
        let names = OUTPUTS.map(|(name, _)| name);
        let exact: Vec<Vec<f64>> =
            elements(&case["at"]).map(|row| names.iter().map(|name| number(&row[*name])).collect()).collect();
        let times: Vec<f64> = elements(&case["at"]).map(|row| number(&row["t"])).collect();
        let interval = times[0];
        let runs = STEPS
            .iter()
            .map(|&step| {
                Rig::record(&[&fmus.plant, controller], &values, (times[times.len() - 1], step, interval), &names)
            })
            .collect::<Result<Vec<_>, _>>()?;
        // Each output counts by its largest value; y_object from where it starts.
        let from = |output: usize| if names[output] == "y_object" { 0.05 } else { 0.0 };
        let size = |output: usize| exact.iter().fold(0.0_f64, |size, row| size.max((row[output] - from(output)).abs()));
        let sizes: Vec<f64> = (0..names.len()).map(size).collect();
        let error = |run: &[Vec<f64>]| -> f64 {
            exact.iter().zip(&run[1..]).fold(0.0_f64, |worst, (exact, row)| {
                (0..names.len()).fold(worst, |worst, i| worst.max((row[i + 1] - exact[i]).abs() / sizes[i]))
            })
        };
        let errors: Vec<f64> = runs.iter().map(|run| error(run)).collect();
        let order = (errors[2] / errors[3]).log2();
        let check = |what: String, exact: String, found: String, error: f64, bound: f64| Check {
            subject: Subject::ClosedLoop,
            what,
            exact,
            found,
            error,
            bound,
            unit: "1",
        };
        let list: Vec<String> = errors.iter().map(|error| format!("{error:.1e}")).collect();
        checks.push(check(
            format!("{title}: co-simulation error at 0.1, 0.05, 0.025, 0.0125 ms"),
            "one stiff ODE".into(),
            list.join(", "),
            errors[0],
            // A quarter of the band in which a force counts as settled.
            5e-3,
        ));
        checks.push(check(
            format!("{title}: observed order in the step"),
            "1".into(),
            format!("{order:.3}"),
            (order - 1.0).abs(),
            0.2,
        ));
        // Clipped commands (and NABFC's sat) have kinks: only the first power of the step has a smooth coefficient.
        let is_smooth = case["saturates"] == false && !controller.description().model_name.starts_with("Nabfc");
        let mut worst = (0.0, String::new(), String::new(), String::new());
        let mut bound = 1e-9_f64;
        for (row, (exact_row, time)) in exact.iter().zip(&times).enumerate() {
            for (i, (output, unit)) in OUTPUTS.into_iter().enumerate() {
                let values: Vec<f64> = runs.iter().map(|run| run[row + 1][i + 1]).collect();
                let (limit, apart) = if is_smooth {
                    extrapolate(values, |a, b| (a - b).abs())
                } else {
                    let [_, b, c, d] = [values[0], values[1], values[2], values[3]];
                    (2.0 * d - c, ((2.0 * d - c) - (2.0 * c - b)).abs())
                };
                bound = bound.max((apart + number(&case["error"][output])) / sizes[i]);
                let off = (limit - exact_row[i]).abs() / sizes[i];
                if off >= worst.0 {
                    let what = format!("{title}: limit for a step of zero; {output} at {time:.1} s, worst of 35");
                    worst = (off, what, format!("{:.10} {unit}", exact_row[i]), format!("{limit:.10} {unit}"));
                }
            }
        }
        let (error, what, exact, found) = worst;
        checks.push(check(what, exact, found, error, bound));
    }
    Ok(checks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extrapolation_removes_the_powers_of_the_step() {
        let value = |h: f64| 3.0 + 2.0 * h - 5.0 * h * h + 7.0 * h * h * h;
        let (limit, apart) = extrapolate([0.4, 0.2, 0.1, 0.05].map(value).to_vec(), |a: f64, b| (a - b).abs());
        assert!((limit - 3.0).abs() < 1e-13 && apart > 1e-4);
    }
}

//! The sampled laws tend to the laws as differential equations; and those to solutions by other means.

mod continuous;

use continuous::{Loop, cases, share};
use grasp_plant::Parameters;

const NO_LOAD: grasp_plant::Inputs = grasp_plant::Inputs::ZERO;

/// The largest difference of two states in units of their magnitudes.
fn distance(a: &[f64], b: &[f64], scales: &[f64]) -> f64 {
    a.iter().zip(b).zip(scales).fold(0.0, |most, ((a, b), scale)| most.max((a - b).abs() / scale.max(b.abs())))
}

/// Every law, on a way so short that no limit matters: as the step of the sampled loop is halved, its distance from the
/// solution of the differential equations is halved (inputs are held), and extrapolated to zero it is none.
#[test]
fn the_sampled_loop_tends_to_the_equations() {
    let (end, coarsest, levels) = (0.02, 400, 6);
    for index in 0..cases().len() {
        let start = || {
            let parameters = Parameters { order: 4, ..Parameters::default() };
            Loop::new(cases().swap_remove(index), parameters, share(0.01), NO_LOAD)
        };
        let mut system = start();
        let scales = integrator_scales(&system);
        let (exact, _) = system.run(end, 1e-12);
        let runs: Vec<_> = (0..levels).map(|level| start().sample(end, coarsest << level)).collect();
        let [.., coarse, fine] = &runs[..] else { unreachable!() };
        let ratio = distance(coarse, &exact, &scales) / distance(fine, &exact, &scales);
        // Neville: a series in h.
        let mut rows = runs.clone();
        for column in 1..rows.len() {
            let factor = f64::from(1 << column) - 1.0;
            rows = rows
                .windows(2)
                .map(|pair| pair[1].iter().zip(&pair[0]).map(|(f, c)| f + (f - c) / factor).collect())
                .collect();
        }
        let limit = distance(&rows[0], &exact, &scales);
        println!("{}: ratio {ratio:.4}, limit {limit:.2e}", system.case.name);
        assert!((ratio - 2.0).abs() < 0.05, "{}: {ratio}", system.case.name);
        assert!(limit < 1e-9, "{}: {limit:e}", system.case.name);
    }
}

fn integrator_scales(system: &Loop) -> Vec<f64> {
    continuous::integrator::System::scales(system)
}

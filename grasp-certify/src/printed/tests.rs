use super::*;
use grasp_plant::Parameters;

fn paper() -> Grasp {
    Grasp::from(&Parameters::default())
}

const LARGE: f64 = 1e6;

/// At B_min(g) the best ϑ_1, ϑ_2, ϑ_3 leave nothing; B_min → 6 + 8√2 where B g = 1/√2.
#[test]
fn the_objects_conditions_end_at_the_smallest_b() {
    for g in [0.001, 0.02, 0.05, 0.1, 0.124] {
        let b = smallest_b(g);
        let best = |b: f64| {
            let rest: f64 = 1.0 + 0.5 * b - 2.0 * b * g;
            b * g * ((0.5 * rest).sqrt() - (b * g).sqrt()).powi(2)
        };
        assert!((best(b.lo()) - 1.0).abs() < 1e-9, "{g}");
        assert!(b.hi() >= smallest_b_of_all() && b.hi() - b.lo() < 1e-10 * b.hi());
    }
    // min over g of B_min lies where B g = 1/√2.
    let g = 1.0 / (2f64.sqrt() * smallest_b_of_all());
    assert!((smallest_b(g).hi() - smallest_b_of_all()).abs() < 1e-9);
}

/// The limit of the paper's arms: 0.2107 1/s (control notes: 0.211) with all other gains at their best.
#[test]
fn the_posture_rate_has_a_limit() {
    let grasp = paper();
    let g = 1.0 / (2f64.sqrt() * smallest_b_of_all());
    let limit = 0.2 / (4.0 * smallest_b_of_all() / 0.23 * 0.04 * (0.054f64 * 0.115).sqrt());
    assert!((limit - 0.2107).abs() < 1e-4, "{limit}");
    let gains = |g3: f64| Gains { g, k: LARGE, g3: [g3; 2], k_hub: [LARGE; 2] };
    assert!(matches!(decide(&grasp, &gains(0.999 * limit)), Verdict::Feasible(_)));
    match decide(&grasp, &gains(1.001 * limit)) {
        Verdict::Infeasible(conflicts) => {
            assert_eq!(conflicts.len(), 2);
            assert!((conflicts[0].limit - limit).abs() < 1e-6 * limit);
        }
        other => panic!("{other:?}"),
    }
}

/// Random constants that satisfy everything are never called impossible, and the verdict's own constants hold.
#[test]
fn no_feasible_gains_are_refused() {
    let grasp = paper();
    let mut feasible = 0;
    for step in 0..400 {
        let x = |k: usize| (f64::from(step) * [0.618_034, 0.414_214, 0.732_051, 0.236_068][k]).fract();
        let gains = Gains {
            g: 0.01 + 0.13 * x(0),
            k: 4.0 + 60.0 * x(1),
            g3: [0.02 + 0.25 * x(2); 2],
            k_hub: [100.0 * 10f64.powf(2.0 * x(3)); 2],
        };
        match decide(&grasp, &gains) {
            Verdict::Feasible(constants) => {
                feasible += 1;
                assert!(violated(&grasp, &gains, &constants).is_empty());
                // More gain does not hurt.
                let more = Gains { k: 2.0 * gains.k, k_hub: gains.k_hub.map(|k| 2.0 * k), ..gains };
                assert!(matches!(decide(&grasp, &more), Verdict::Feasible(_)));
            }
            Verdict::Infeasible(conflicts) => assert!(!conflicts.is_empty()),
            Verdict::Undecided => panic!("{gains:?}"),
        }
    }
    assert!(feasible > 5, "{feasible}");
}

/// The gains of the FMU settle in a third of a second and are far from the conditions.
#[test]
fn the_shipped_gains_are_refused_with_reasons() {
    let gains = Gains { g: 4.0, k: 0.25, g3: [13.0; 2], k_hub: [0.38; 2] };
    let Verdict::Infeasible(conflicts) = decide(&paper(), &gains) else { panic!() };
    assert_eq!(conflicts.len(), 4);
    assert!(conflicts.iter().all(|conflict| conflict.value != conflict.limit));
}

/// (92) is never below 4√m, with whatever learning rates.
#[test]
fn the_bounds_say_nothing() {
    let grasp = paper();
    let gains = Gains { g: 0.03, k: LARGE, g3: [0.085; 2], k_hub: [LARGE; 2] };
    let Verdict::Feasible(start) = decide(&grasp, &gains) else { panic!() };
    for leak in [1e-6, 1e-2, 10.0] {
        let pair = [1.0, leak];
        let learning = Learning {
            weights: pair,
            bias: pair,
            mass: pair,
            hub_weights: [pair; 2],
            hub_bias: [pair; 2],
            inertia: [pair; 2],
        };
        let bounds = bounds(&grasp, &gains, &learning, &start);
        assert!(bounds.phi > 0.0 && bounds.phi < 0.04, "{bounds:?}");
        assert!(bounds.position >= bounds.least_position && bounds.angle[0] >= bounds.least_angle[0]);
        assert!((bounds.least_position - 8f64.sqrt()).abs() < 1e-12);
    }
}

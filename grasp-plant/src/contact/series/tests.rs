use super::*;
use crate::basis::gauss;

fn found(series: &Series) -> Option<f64> {
    series.first_negative(1e-15).unwrap()
}

/// (ξ−a)(ξ−b)… with known roots: the first one where the sign goes down, to rounding.
#[test]
fn the_first_crossing_is_found_among_many_roots() {
    let product = |roots: &[f64], sign: f64| {
        let mut c = vec![sign];
        for root in roots {
            let mut next = vec![0.0; c.len() + 1];
            for (m, c) in c.iter().enumerate() {
                next[m + 1] += c;
                next[m] -= root * c;
            }
            c = next;
        }
        Series::new(Basis::Powers, &c)
    };
    for (roots, sign, expected) in [
        (vec![0.3], -1.0, Some(0.3)),
        (vec![0.3, 0.7], 1.0, Some(0.3)),
        (vec![0.3, 0.3, 0.8], -1.0, Some(0.8)),
        (vec![0.25, 0.5, 0.75, 1e-3], 1.0, Some(1e-3)),
        (vec![0.5, 0.500_001], 1.0, Some(0.5)),
        (vec![1.5, 2.0], 1.0, None),
    ] {
        let found = found(&product(&roots, sign));
        match (found, expected) {
            (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-9, "{roots:?} {found}"),
            pair => assert_eq!(pair.0, pair.1, "{roots:?}"),
        }
    }
}

/// A parabola that touches zero, or stays above it by as little as numbers can say, is no crossing; one that dips below
/// by a part in a billion is.
#[test]
fn grazes_are_no_crossings() {
    let parabola = |depth: f64| Series::new(Basis::Powers, &[0.25 - depth, -1.0, 1.0]);
    for depth in [0.0, -1e-16, -1e-12, -1e-6] {
        assert_eq!(found(&parabola(depth)), None, "{depth}");
    }
    for depth in [1e-9, 1e-6, 1e-3] {
        let expected = 0.5 - f64::sqrt(depth);
        assert!((found(&parabola(depth)).unwrap() - expected).abs() < 1e-6 * f64::sqrt(depth), "{depth}");
    }
    // What leaves zero like t³ is not negative, whatever rounding makes of its first coefficients.
    assert_eq!(found(&Series::new(Basis::Powers, &[0.0, -1e-20, 1e-19, 1.0])), None);
}

/// e^{−Kξ} − ½ crosses zero at ln 2/K, for slow faces and for those that are back at once.
#[test]
fn a_relaxing_face_is_part_of_the_signal() {
    for rate in [1.0, 30.0, 1e4, 1e9] {
        let series = Series { amplitude: 1.0, rate, ..Series::new(Basis::Powers, &[-0.5]) };
        let expected = std::f64::consts::LN_2 / rate;
        assert!((found(&series).unwrap() - expected).abs() < 1e-14 * expected.max(1e-2), "{rate}");
    }
}

/// 1 − 3 e^{−Kξ} begins below zero, and ¼ − ξ + ¾ e^{−Kξ} ends there; 2 − e^{−Kξ} never is.
#[test]
fn what_decays_has_either_sign() {
    for rate in [0.5, 30.0, 1e4, 1e9] {
        let series = |terms: &[f64], amplitude| Series { amplitude, rate, ..Series::new(Basis::Powers, terms) };
        assert_eq!(found(&series(&[1.0], -3.0)), Some(0.0), "{rate}");
        assert_eq!(found(&series(&[2.0], -1.0)), None, "{rate}");
        let crossing = found(&series(&[0.25, -1.0], 0.75)).unwrap();
        let value = 0.25 - crossing + 0.75 * decay(rate * crossing);
        assert!(value.abs() < 1e-14, "{rate}: {crossing} {value:e}");
    }
}

/// Integral and square of 1 + ξ − 2 e^{−Kξ}.
#[test]
fn what_decays_is_integrated_and_squared() {
    let rule = gauss(MOST_TERMS);
    for basis in [Basis::Powers, Basis::Legendre] {
        for rate in [0.5, 20.0, 700.0, 1e5] {
            let terms: &[f64] = if basis == Basis::Powers { &[1.0, 1.0] } else { &[1.5, 0.5] };
            let series = Series { amplitude: -2.0, rate, ..Series::new(basis, terms) };
            for xi in [0.1, 1.0] {
                let gone = 1.0 - decay(rate * xi);
                let integral = xi + 0.5 * xi * xi - 2.0 * gone / rate;
                let found = series.integrated(0.25, 3.0).value_and_slope(xi).0;
                assert!((found - (0.25 + 3.0 * integral)).abs() < 1e-14 * (1.0 + 6.0 / rate), "{basis:?} {rate} {xi}");
                // ∫(1+s)² − 4 ∫(1+s) e^{−Ks} + 4 ∫e^{−2Ks}
                let mixed = gone / rate + (gone / rate - xi * decay(rate * xi)) / rate;
                let square =
                    ((1.0 + xi).powi(3) - 1.0) / 3.0 - 4.0 * mixed + 2.0 * (1.0 - decay(2.0 * rate * xi)) / rate;
                let found = series.square(xi, &rule);
                assert!((found - square).abs() < 1e-13, "{basis:?} {rate} {xi}: {found} {square}");
            }
        }
    }
}

#[test]
fn both_bases_integrate_and_square_alike() {
    // p = 1 + 2ξ + 3ξ² = 3 + 2.5 P_1 + 0.5 P_2.
    let powers = Series::new(Basis::Powers, &[1.0, 2.0, 3.0]);
    let legendre = Series::new(Basis::Legendre, &[3.0, 2.5, 0.5]);
    let rule = gauss(6);
    for xi in [0.0, 0.3, 1.0] {
        for series in [powers, legendre] {
            assert!((series.value_and_slope(xi).0 - (1.0 + 2.0 * xi + 3.0 * xi * xi)).abs() < 1e-14);
            assert!((series.value_and_slope(xi).1 - (2.0 + 6.0 * xi)).abs() < 1e-13);
            let integral = series.integrated(0.5, 2.0).value_and_slope(xi).0;
            assert!((integral - (0.5 + 2.0 * (xi + xi * xi + xi.powi(3)))).abs() < 1e-14);
            // ∫(1+2s+3s²)² ds
            let square = xi + 2.0 * xi.powi(2) + 10.0 / 3.0 * xi.powi(3) + 3.0 * xi.powi(4) + 1.8 * xi.powi(5);
            assert!((series.square(xi, &rule) - square).abs() < 1e-13, "{xi}");
        }
    }
}

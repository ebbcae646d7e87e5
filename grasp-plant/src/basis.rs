//! Polynomials on one element: Jacobi and Legendre, their derivatives, Gauss quadrature.

use std::f64::consts::{FRAC_PI_2, PI};

/// Jacobi polynomial P_n^{(α,β)}(t) on [−1, 1] by its three-term recurrence (DLMF 18.9.2).
pub(crate) fn jacobi(n: usize, alpha: f64, beta: f64, t: f64) -> f64 {
    let mut previous = 1.0;
    if n == 0 {
        return previous;
    }
    let mut current = (alpha + 1.0) + (alpha + beta + 2.0) * (t - 1.0) / 2.0;
    for m in 1..n {
        let m = m as f64;
        let c = 2.0 * m + alpha + beta;
        let next = ((c + 1.0) * (c * (c + 2.0) * t + alpha * alpha - beta * beta) * current
            - 2.0 * (m + alpha) * (m + beta) * (c + 2.0) * previous)
            / (2.0 * (m + 1.0) * (m + alpha + beta + 1.0) * c);
        (previous, current) = (current, next);
    }
    current
}

/// Derivative of P_n^{(α,β)} of the given order at t (DLMF 18.9.15).
pub(crate) fn jacobi_derivative(order: usize, n: usize, alpha: f64, beta: f64, t: f64) -> f64 {
    if order > n {
        return 0.0;
    }
    let factor: f64 = (1..=order).map(|m| (n as f64 + alpha + beta + m as f64) / 2.0).product();
    factor * jacobi(n - order, alpha + order as f64, beta + order as f64, t)
}

/// Legendre polynomial `P_n(t)`.
pub(crate) fn legendre(n: usize, t: f64) -> f64 {
    jacobi(n, 0.0, 0.0, t)
}

/// Nodes and weights of the n-point Gauss–Legendre rule on [0, 1], exact for degree 2n − 1.
///
/// Only basic arithmetic, without functions of the system's mathematics library: the same bits on every machine.
pub(crate) fn gauss(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            // The usual first guess, −cos φ, by Bhāskara's formula. Its error is at most 0.0017 in the middle, where the
            // nodes are far apart, and smaller towards the ends.
            let phi = (i as f64 + 0.75) / (n as f64 + 0.5) * PI;
            let cosine = |phi: f64| (PI * PI - 4.0 * phi * phi) / (PI * PI + phi * phi);
            let mut t = if phi < FRAC_PI_2 { -cosine(phi) } else { cosine(PI - phi) };
            // Newton from this guess converges quadratically; six steps reach rounding for every n used here.
            for _ in 0..6 {
                t -= legendre(n, t) / jacobi_derivative(1, n, 0.0, 0.0, t);
            }
            let slope = jacobi_derivative(1, n, 0.0, 0.0, t);
            (f64::midpoint(t, 1.0), 1.0 / ((1.0 - t * t) * slope * slope))
        })
        .collect()
}

/// The moment shape (1−ξ) P_j^{(2,0)}(2ξ−1), orthogonal on [0, 1] with squared norm 1/(2j+3), and vanishing at the tip.
pub(crate) fn moment_shape(j: usize, xi: f64) -> f64 {
    (1.0 - xi) * jacobi(j, 2.0, 0.0, 2.0 * xi - 1.0)
}

/// Second derivative by ξ of [`moment_shape`].
pub(crate) fn moment_shape_curvature(j: usize, xi: f64) -> f64 {
    let t = 2.0 * xi - 1.0;
    4.0 * ((1.0 - xi) * jacobi_derivative(2, j, 2.0, 0.0, t) - jacobi_derivative(1, j, 2.0, 0.0, t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_integrates_monomials_exactly() {
        for n in 1..=26 {
            let rule = gauss(n);
            for degree in 0..2 * n {
                let integral: f64 =
                    rule.iter().map(|(xi, weight)| weight * xi.powi(i32::try_from(degree).unwrap())).sum();
                assert!((integral * (degree as f64 + 1.0) - 1.0).abs() < 2e-13, "n {n} degree {degree}: {integral}");
            }
        }
    }

    #[test]
    fn moment_shapes_are_orthogonal() {
        let rule = gauss(26);
        for i in 0..24 {
            for j in 0..24 {
                let product: f64 = rule.iter().map(|(x, w)| w * moment_shape(i, *x) * moment_shape(j, *x)).sum();
                let expected = if i == j { 1.0 / (2.0 * j as f64 + 3.0) } else { 0.0 };
                assert!((product - expected).abs() < 1e-13, "{i} {j}: {product}");
            }
        }
    }

    /// ∫₀¹ (1−ξ) f'' = f(1) − f(0) − f'(0), and f(0) = (−1)^j, f(1) = 0, f'(1) = −(j+1)(j+2)/2 in closed form.
    #[test]
    fn curvatures_integrate_to_the_boundary_values() {
        let rule = gauss(26);
        for j in 0..24 {
            let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
            let slope = -(((j + 1) * (j + 2)) as f64) / 2.0;
            let integral: f64 = rule.iter().map(|(x, w)| w * x * moment_shape_curvature(j, *x)).sum();
            // ∫ξ f'' = f'(1) − f(1) + f(0)
            assert!((integral - (slope + sign)).abs() < 1e-12 * slope.abs(), "{j}: {integral}");
            assert!((moment_shape(j, 0.0) - sign).abs() < 1e-13);
        }
    }
}

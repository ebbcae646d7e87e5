//! The normal distribution.

/// Φ(z), the normal distribution function.
pub(super) fn distribution(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// Φ⁻¹(p) by bisection, as exactly as Φ is: a run takes a thousand times longer.
pub(super) fn quantile(p: f64) -> f64 {
    let (mut below, mut above) = (-9.0, 9.0);
    loop {
        let middle = 0.5 * (below + above);
        if middle <= below || middle >= above {
            return middle;
        }
        if distribution(middle) < p { below = middle } else { above = middle }
    }
}

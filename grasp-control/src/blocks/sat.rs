//! The saturation that replaces the sign function (Section IV).

/// sat(ι): ι clipped to ±`limit`.
///
/// The paper prints its middle inequality reversed; this is what is meant. Note that the result is at most `limit`, not
/// one: η sat(s) is a linear gain η inside the limit and never larger than η·limit.
pub(crate) fn sat(value: f64, limit: f64) -> f64 {
    // Not `clamp`, which looks at its limits each time.
    if value > limit {
        limit
    } else if value < -limit {
        -limit
    } else {
        value
    }
}

/// Derivative of [`sat`]; at the corners that of the inner branch.
pub(crate) fn sat_slope(value: f64, limit: f64) -> f64 {
    if value.abs() <= limit { 1.0 } else { 0.0 }
}

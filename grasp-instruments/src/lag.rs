//! The first-order lag ẏ = ω (x − y), exact for inputs that are held or ramp.

/// The output of the lag after `time` \[s\], from `y`, for an input that starts at `x` and changes at `rate`; ω > 0 in
/// rad/s.
pub(crate) fn lag(omega: f64, y: f64, x: f64, rate: f64, time: f64) -> f64 {
    let followed = -libm::expm1(-omega * time);
    y + (x - y) * followed + rate * (time - followed / omega)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_has_settled_stays() {
        assert_eq!(lag(37.0, 0.1, 0.1, 0.0, 1e-3), 0.1);
    }

    proptest! {
        /// y = x − r/ω + r t + c e^{−ωt}, the textbook solution. Its own cancellation determines the tolerance.
        #[test]
        fn step_and_ramp_responses_are_exact(
            omega in 1.0..5e3_f64, time in 1e-5..1e-1_f64, y in -5.0..5.0_f64, x in -5.0..5.0_f64, rate in -50.0..50.0_f64,
        ) {
            let behind = rate / omega;
            let exact = x - behind + rate * time + (y - x + behind) * (-omega * time).exp();
            prop_assert!((lag(omega, y, x, rate, time) - exact).abs() < 1e-13);
        }

        #[test]
        fn two_half_steps_are_one(omega in 1.0..5e3_f64, time in 1e-5..1e-1_f64, y in -5.0..5.0_f64, x in -5.0..5.0_f64, rate in -50.0..50.0_f64) {
            let half = 0.5 * time;
            let twice = lag(omega, lag(omega, y, x, rate, half), x + rate * half, rate, half);
            prop_assert!((twice - lag(omega, y, x, rate, time)).abs() < 1e-13);
        }
    }
}

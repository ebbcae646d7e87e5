//! Sensors part by part: each is exact, and nothing depends on how time is divided into steps.

use grasp_instruments::{InstrumentSettings, Instruments, LONGEST_LINE, Sensor, SensorSettings, StepError, Stream};
use proptest::prelude::*;

const STREAM: Stream = Stream { seed: 7, number: 3 };

/// A signal that is different at every step of 0.1 ms.
fn signal(step: u32) -> f64 {
    (0.37 * f64::from(step)).sin()
}

/// What a sensor shows at the end of each of `steps` steps of 0.1 ms.
fn run(settings: SensorSettings, steps: u32) -> Vec<f64> {
    let mut sensor = Sensor::new(settings, STREAM, 0.0, signal(0));
    let mut shown = vec![sensor.output(signal(0))];
    for i in 1..=steps {
        sensor.step(f64::from(i - 1) * 1e-4, 1e-4, signal(i), 0.0);
        shown.push(sensor.output(signal(i)));
    }
    shown
}

#[test]
fn off_is_transparent_to_the_bit() {
    let mut sensor = Sensor::new(SensorSettings::OFF, STREAM, 0.0, 0.0);
    for value in [0.0, -0.0, 1.0 / 3.0, -f64::MIN_POSITIVE, 5e-324, f64::MAX] {
        sensor.step(0.0, 1e-4, value, 0.0);
        assert_eq!(sensor.output(value).to_bits(), value.to_bits());
        assert_eq!((sensor.output_rate(value, -2.5), sensor.feedthrough()), (-2.5, 1.0));
    }
}

#[test]
fn a_sampler_holds_what_it_took() {
    let shown = run(SensorSettings { sample_time: 1e-3, ..SensorSettings::OFF }, 100);
    for (i, value) in (0..).zip(&shown) {
        assert_eq!(*value, signal(i - i % 10));
    }
}

/// The delay is exact, in samples and in fractions of them: the newest sample that is old enough is shown.
#[test]
fn a_delay_shows_the_samples_that_are_old_enough() {
    for tenths in [0, 1, 9, 10, 11, 20, 25, 1_000] {
        let settings = SensorSettings { sample_time: 1e-3, delay: f64::from(tenths) * 1e-4, ..SensorSettings::OFF };
        let shown = run(settings, 2_500);
        for (i, value) in (0..).zip(&shown) {
            let old_enough: u32 = i - tenths.min(i);
            assert_eq!(*value, signal(old_enough - old_enough % 10), "delay of {tenths} tenths, step {i}");
        }
    }
}

#[test]
fn quantised_values_are_the_nearest_multiples() {
    let lsb = std::f64::consts::TAU / 65_536.0;
    let sensor = Sensor::new(SensorSettings { lsb, ..SensorSettings::OFF }, STREAM, 0.0, 0.0);
    for i in 0..10_000_u32 {
        let value = 3.0 * signal(i);
        let shown = sensor.output(value);
        assert_eq!(shown, lsb * (shown / lsb).round());
        assert!((shown - value).abs() <= 0.5 * lsb * (1.0 + 1e-12));
    }
    // Where a double is coarser than the steps, it stays.
    assert_eq!(sensor.output(1e300), 1e300);
    assert_eq!((sensor.output_rate(0.1, 5.0), sensor.feedthrough()), (0.0, 0.0));
}

/// The error of a quantiser is uniform, so its variance is lsb²/12: of 10⁴ independent phases within 4 standard errors.
#[test]
fn quantisation_has_the_variance_of_a_uniform_error() {
    let sensor = Sensor::new(SensorSettings { lsb: 1e-3, ..SensorSettings::OFF }, STREAM, 0.0, 0.0);
    let n = 10_000;
    let error = |k| {
        let value = Stream { seed: 1, number: 1 }.deviate(k);
        sensor.output(value) - value
    };
    let variance = (0..n).map(|k| error(k).powi(2)).sum::<f64>() / n as f64;
    // Var of the square of a uniform error: lsb⁴ (1/80 − 1/144).
    let bound = 4.0 * ((1.0 / 80.0 - 1.0 / 144.0) / n as f64).sqrt() * 1e-6;
    assert!((variance - 1e-6 / 12.0).abs() < bound, "{variance}");
}

/// A constant 1 from t = 0 on, seen by a sensor that was at 0.
#[test]
fn the_low_pass_follows_by_the_exponential() {
    for sample_time in [0.0, 1e-3] {
        let settings = SensorSettings { bandwidth: 200.0, sample_time, ..SensorSettings::OFF };
        let mut sensor = Sensor::new(settings, STREAM, 0.0, 0.0);
        for i in 0..10 {
            sensor.step(f64::from(i) * 1e-3, 1e-3, 1.0, 0.0);
            let exact = 1.0 - (-0.2 * f64::from(i + 1)).exp();
            assert!((sensor.output(1.0) - exact).abs() < 1e-15);
        }
    }
}

#[test]
fn bias_and_noise_are_added_before_the_quantiser() {
    let settings = SensorSettings { sample_time: 1e-3, bias: 0.4, noise: 0.5, ..SensorSettings::OFF };
    let shown = run(settings, 50);
    for (i, value) in (0..).zip(&shown) {
        let taken = i - i % 10;
        assert_eq!(*value, signal(taken) + 0.4 + 0.5 * STREAM.deviate(u64::from(taken / 10)));
    }
    let coarse = run(SensorSettings { lsb: 0.25, ..settings }, 50);
    assert!(coarse.iter().zip(&shown).all(|(coarse, shown)| *coarse == 0.25 * (shown / 0.25).round()));
}

#[test]
fn an_absent_sensor_shows_nothing() {
    let settings = SensorSettings { absent: true, sample_time: 1e-3, noise: 1.0, ..SensorSettings::OFF };
    assert!(run(settings, 20).iter().all(|value| *value == 0.0));
}

proptest! {
    /// Noise, samples and delays to the bit, low-passes to rounding, for one step and any division of it, held or ramping.
    #[test]
    fn steps_can_be_divided(
        parts in prop::collection::vec(1_u32..40, 1..30), input in -1.0..1.0_f64, rate in prop_oneof![Just(0.0), -3.0..3.0_f64],
        delay in 0.0..5e-3_f64, bandwidth in prop_oneof![Just(0.0), 1.0..2e3_f64], start in -5.0..5.0_f64,
    ) {
        let settings = SensorSettings { noise: 0.1, sample_time: 1e-3, delay, bandwidth, ..SensorSettings::OFF };
        let mut once = Sensor::new(settings, STREAM, start, 0.5);
        let mut divided = once.clone();
        let unit = 1e-4;
        let mut done = 0;
        for part in &parts {
            let (from, size) = (f64::from(done) * unit, f64::from(*part) * unit);
            divided.step(start + from, size, input + rate * from, rate);
            done += part;
        }
        once.step(start, f64::from(done) * unit, input, rate);
        let difference = (once.output(0.0) - divided.output(0.0)).abs();
        prop_assert!(difference <= if bandwidth > 0.0 || rate != 0.0 { 1e-12 } else { 0.0 }, "{difference}");
    }

    /// However long a step, it takes no longer than its delay line has samples.
    #[test]
    fn long_steps_are_short_work(size in 1e3..1e9_f64) {
        let settings = SensorSettings { noise: 0.1, sample_time: 1e-6, delay: 1e-3, ..SensorSettings::OFF };
        let mut sensor = Sensor::new(settings, STREAM, 0.0, 0.0);
        sensor.step(0.0, size, 1.0, 0.0);
        prop_assert!((sensor.output(0.0) - 1.0).abs() < 1.0);
    }
}

fn refused(change: impl FnOnce(&mut InstrumentSettings)) -> String {
    let mut settings = InstrumentSettings::default();
    change(&mut settings);
    Instruments::new(&settings, 0.0, &[0.0; 14]).unwrap_err().to_string()
}

#[test]
fn settings_that_cannot_be_used_are_refused_with_name_and_remedy() {
    for (message, parts) in [
        (refused(|s| s.sensors[0].noise = 1e-4), ["theta1_noise", "set sample_time or theta1_sample_time"]),
        (refused(|s| s.sensors[4].delay = 1e-3), ["y_object_delay", "set sample_time"]),
        (refused(|s| s.sensors[1].sample_time = 1e-9), ["theta2_sample_time", "at least 1e-6 s"]),
        (refused(|s| s.sample_time = 1e-9), ["sample_time", "at least 1e-6 s"]),
        (refused(|s| s.sample_time = f64::NAN), ["sample_time = NaN", "between"]),
        (refused(|s| s.noise_scale = -1.0), ["noise_scale = -1", "between"]),
        (refused(|s| s.sensors[3].lsb = f64::INFINITY), ["theta2_dot_lsb", "between"]),
        (refused(|s| s.sensors[8].bandwidth = -1.0), ["tip_shear1_bandwidth = -1", "between"]),
        (refused(|s| s.sensors[13].bias = 1e10), ["root_moment2_dot_bias", "between"]),
        (
            refused(|s| (s.sample_time, s.sensors[6].delay) = (1e-3, 1e-3 * (LONGEST_LINE as f64 + 1.0))),
            ["root_moment1_delay", "at most 1000 sample times"],
        ),
    ] {
        for part in parts {
            assert!(message.contains(part), "{message:?} should contain {part:?}");
        }
    }
}

#[test]
fn steps_without_a_finite_end_are_refused() {
    let settings = InstrumentSettings { sample_time: 1e-6, ..InstrumentSettings::default() };
    let mut instruments = Instruments::new(&settings, 0.0, &[0.0; 14]).unwrap();
    assert_eq!(instruments.step(0.0, 1e12, &[0.0; 14], &[0.0; 14]), Err(StepError::Count));
    let mut settings = InstrumentSettings::default();
    settings.sensors[0].bandwidth = 1e3;
    let mut instruments = Instruments::new(&settings, 0.0, &[-f64::MAX; 14]).unwrap();
    assert_eq!(instruments.step(0.0, 1.0, &[f64::MAX; 14], &[0.0; 14]), Err(StepError::NotFinite));
}

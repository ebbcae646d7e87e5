//! Commands: inverse dead zone, delay, rate limit and lag, each exact, and nothing depends on how time is divided.

use grasp_instruments::actuation::Actuation;
use grasp_instruments::dead_zone::DeadZone;
use grasp_instruments::{ActuationSettings, CommandPath, CommandSettings, MOST_SAMPLES, StepError};
use proptest::prelude::*;

const OFF: CommandSettings =
    CommandSettings { sample_time: 0.0, delay: 0.0, rate_limit: 0.0, bandwidth: 0.0, inverse: None };

fn command(step: u32) -> f64 {
    (0.37 * f64::from(step)).sin()
}

fn run(settings: CommandSettings, steps: u32) -> Vec<f64> {
    let mut path = CommandPath::new(&settings, 0.0, command(0));
    let mut sent = vec![path.output(command(0))];
    for i in 1..=steps {
        path.step(f64::from(i - 1) * 1e-4, 1e-4, command(i), 0.0).unwrap();
        sent.push(path.output(command(i)));
    }
    sent
}

#[test]
fn off_is_transparent_to_the_bit() {
    let mut path = CommandPath::new(&OFF, 0.0, 0.0);
    for value in [0.0, -0.0, 1.0 / 3.0, -f64::MIN_POSITIVE, f64::MAX] {
        path.step(0.0, 1e-4, value, 0.0).unwrap();
        assert_eq!(path.output(value).to_bits(), value.to_bits());
        assert_eq!((path.output_rate(value, 3.0), path.feedthrough(value)), (3.0, 1.0));
    }
}

#[test]
fn delays_are_exact() {
    for tenths in [0, 1, 9, 10, 20, 25, 333] {
        let settings = CommandSettings { sample_time: 1e-3, delay: f64::from(tenths) * 1e-4, ..OFF };
        for (i, value) in (0..).zip(run(settings, 1_000)) {
            let old_enough: u32 = i - tenths.min(i);
            assert_eq!(value, command(old_enough - old_enough % 10), "delay of {tenths} tenths, step {i}");
        }
    }
}

/// Behind a delay that ends within the steps, limiter and lag see a command change in their middle.
#[test]
fn a_delayed_command_meets_the_drive_when_it_arrives() {
    let settings =
        CommandSettings { sample_time: 1e-2, delay: 3.5e-3, rate_limit: 10.0, bandwidth: 0.0, inverse: None };
    let mut path = CommandPath::new(&settings, 0.0, 0.0);
    // Sampled at 10 ms, it arrives at 13.5 ms and is half way after 50 ms more.
    path.step(0.0, 1e-2, 1.0, 0.0).unwrap();
    assert_eq!(path.output(1.0), 0.0);
    path.step(1e-2, 53.5e-3, 1.0, 0.0).unwrap();
    assert!((path.output(1.0) - 0.5).abs() < 1e-14);
    path.step(63.5e-3, 1.0, 1.0, 0.0).unwrap();
    assert_eq!(path.output(1.0), 1.0);
}

#[test]
fn the_inverse_takes_part_in_everything() {
    let zone = DeadZone { m_r: 0.1, m_l: -0.2, k_r: 2.0, k_l: 0.5 };
    let path = CommandPath::new(&CommandSettings { inverse: Some(zone), ..OFF }, 0.0, 0.0);
    assert_eq!([1.0, 0.0, -1.0].map(|wanted| path.output(wanted)), [0.6, 0.0, -2.2]);
    assert_eq!([1.0, 0.0, -1.0].map(|wanted| path.feedthrough(wanted)), [0.5, 0.0, 2.0]);
    assert_eq!(path.output_rate(-1.0, 3.0), 6.0);
    // A ramp over zero jumps there: the limiter, fast enough for the ramp, needs the jump's height over its speed.
    let settings = CommandSettings { inverse: Some(zone), rate_limit: 100.0, ..OFF };
    let mut path = CommandPath::new(&settings, 0.0, -0.1);
    assert_eq!(path.output(-0.1), -0.4);
    // Zero is crossed after 0.1 s at −0.2; the gap of 0.3 closes at 100 − 0.5 per second.
    path.step(0.0, 0.1 + 2e-3, -0.1, 1.0).unwrap();
    assert!((path.output(0.0) - (-0.2 + 0.2)).abs() < 1e-12);
    path.step(0.102, 0.098, 0.002, 1.0).unwrap();
    assert!((path.output(0.1) - zone.inverse(0.1)).abs() < 1e-12);
}

fn zones() -> impl Strategy<Value = DeadZone> {
    (0.0..1.0_f64, 0.0..1.0_f64, 0.1..5.0_f64, 0.1..5.0_f64).prop_map(|(m_r, m_l, k_r, k_l)| DeadZone {
        m_r,
        m_l: -m_l,
        k_r,
        k_l,
    })
}

/// The plant's bare actuator: saturation, then the dead zone.
fn raw(zone: &DeadZone, k_min: f64, k_max: f64, command: f64) -> f64 {
    let limited = command.clamp(k_min, k_max);
    if limited > zone.m_r {
        zone.k_r * (limited - zone.m_r)
    } else if limited < zone.m_l {
        zone.k_l * (limited - zone.m_l)
    } else {
        0.0
    }
}

proptest! {
    /// Lemma 5: D(sat(D⁺(ς))) is the clip (18).
    #[test]
    fn the_raw_actuator_behind_the_inverse_is_a_clip(
        zone in zones(), up in 0.01..3.0_f64, down in 0.01..3.0_f64, wanted in -20.0..20.0_f64,
    ) {
        let (k_min, k_max) = (zone.m_l - down, zone.m_r + up);
        let path = CommandPath::new(&CommandSettings { inverse: Some(zone), ..OFF }, 0.0, 0.0);
        let output = raw(&zone, k_min, k_max, path.output(wanted));
        let clip = wanted.clamp(zone.k_l * (k_min - zone.m_l), zone.k_r * (k_max - zone.m_r));
        prop_assert!((output - clip).abs() < 1e-13);
    }

    /// One step or many, with everything switched on, held or ramping.
    #[test]
    fn steps_can_be_divided(
        zone in prop_oneof![Just(None), zones().prop_map(Some)], sample_time in prop_oneof![Just(0.0), Just(1e-3)],
        delay in 0.0..5e-3_f64, rate_limit in prop_oneof![Just(0.0), 1.0..500.0_f64],
        bandwidth in prop_oneof![Just(0.0), 10.0..2e3_f64], from in -1.0..1.0_f64, rate in prop_oneof![Just(0.0), -50.0..50.0_f64],
        parts in prop::collection::vec(1_u32..40, 1..20),
    ) {
        let delay = if sample_time > 0.0 { delay } else { 0.0 };
        let settings = CommandSettings { sample_time, delay, rate_limit, bandwidth, inverse: zone };
        let mut once = CommandPath::new(&settings, 0.0, 0.3);
        let mut divided = once.clone();
        let mut done = 0;
        for part in &parts {
            let (time, size) = (f64::from(done) * 1e-4, f64::from(*part) * 1e-4);
            divided.step(time, size, from + rate * time, rate).unwrap();
            done += part;
        }
        let end = f64::from(done) * 1e-4;
        once.step(0.0, end, from, rate).unwrap();
        let last = from + rate * end;
        // The inverse jumps at zero, where rounding decides on the side.
        prop_assume!(zone.is_none() || (0..=done).all(|i| (from + rate * f64::from(i) * 1e-4).abs() > 1e-9));
        prop_assert!((once.output(last) - divided.output(last)).abs() < 1e-9);
    }
}

#[test]
fn settings_that_cannot_be_used_are_refused_with_name_and_remedy() {
    let refused = |change: &dyn Fn(&mut ActuationSettings)| {
        let mut settings = ActuationSettings::default();
        change(&mut settings);
        Actuation::new(&settings, 0.0, &[0.0; 3]).unwrap_err().to_string()
    };
    for (message, parts) in [
        (refused(&|s| s.commands[0].delay = 1e-3), ["tau1_cmd_delay", "set sample_time"]),
        (refused(&|s| s.sample_time = 1e-9), ["sample_time", "at least 1e-6 s"]),
        (
            refused(&|s| (s.sample_time, s.commands[2].delay) = (1e-3, 2.0)),
            ["u_cmd_delay", "at most 1000 sample times"],
        ),
        (refused(&|s| s.commands[1].rate_limit = -1.0), ["tau2_cmd_rate_limit = -1", "between"]),
        (refused(&|s| s.commands[1].bandwidth = f64::NAN), ["tau2_cmd_bandwidth = NaN", "between"]),
        (refused(&|s| s.dead_zones[1].k_l = 0.0), ["k_l2 = 0", "between"]),
        (refused(&|s| s.dead_zones[0].m_l = 0.1), ["m_l1 = 0.1", "between"]),
    ] {
        for part in parts {
            assert!(message.contains(part), "{message:?} should contain {part:?}");
        }
    }
}

#[test]
fn steps_that_would_take_too_long_or_leave_the_numbers_are_refused() {
    let mut path = CommandPath::new(&CommandSettings { sample_time: 1e-6, ..OFF }, 0.0, 0.0);
    assert_eq!(path.step(0.0, 1e12, 0.0, 0.0), Err(StepError::Count));
    assert!(matches!(path.step(0.0, 2.0, 0.0, 0.0), Err(StepError::Samples(n)) if n > MOST_SAMPLES));
    let zone = DeadZone { k_r: 1e-6, ..DeadZone::TORQUE };
    let mut path = CommandPath::new(&CommandSettings { bandwidth: 1.0, inverse: Some(zone), ..OFF }, 0.0, 0.0);
    assert_eq!(path.step(0.0, 1.0, f64::MAX, 0.0), Err(StepError::NotFinite));
}

//! Hosts keep time in many ways; none of them is refused for rounding, and no mistake of half a step passes for it.

mod common;

use common::{ERROR, Fmu, OK, Slave};

/// A slave that steps from 0, with this stop time.
fn until(fmu: &Fmu, stop: f64) -> Slave<'_> {
    let slave = fmu.instantiate(&fmu.guids()[0]);
    assert_eq!(fmu.fmi2SetupExperiment(slave.component, 0, 0.0, 0.0, 1, stop), OK);
    assert_eq!(fmu.fmi2EnterInitializationMode(slave.component), OK);
    assert_eq!(fmu.fmi2ExitInitializationMode(slave.component), OK);
    slave
}

fn run(fmu: &Fmu, stop: f64, steps: u32, size: f64, clock: impl Fn(f64, u32) -> f64) {
    let slave = until(fmu, stop);
    let mut time = 0.0;
    for i in 0..steps {
        assert_eq!(slave.step(time, size), OK, "step {i} of {size} s, stop {stop} s: {}", slave.message());
        time = clock(time, i + 1);
    }
}

/// The standard's own example master: `time += h`. A million additions of 0.1 ms end at 100.00000000219612.
#[test]
fn adding_up_reaches_the_stop_time() {
    let fmu = Fmu::load("first_order_lag");
    for (size, steps) in
        [(1e-4, 1_000_000), (5e-5, 2_000_000), (2e-4, 500_000), (1e-6, 1_000_000), (0.01, 100_000), (0.1, 100_000)]
    {
        run(&fmu, (size * f64::from(steps) * 1e9).round() / 1e9, steps, size, |time, _| time + size);
    }
}

#[test]
fn clocks_of_microseconds_and_of_single_precision_will_do() {
    let fmu = Fmu::load("first_order_lag");
    for size in [1e-4, 1.0 / 3000.0, 0.01] {
        let steps = 20_000;
        let stop = size * f64::from(steps);
        let exact = |i: u32| f64::from(i) * size;
        run(&fmu, stop, steps, size, |_, i| exact(i));
        run(&fmu, stop, steps, size, |_, i| (exact(i) * 1e6).round() / 1e6);
        #[allow(clippy::cast_possible_truncation)]
        run(&fmu, stop, steps, size, |_, i| f64::from(exact(i) as f32));
        #[allow(clippy::cast_possible_truncation)]
        run(&fmu, stop + 0.5, steps, size, |time, _| f64::from(time as f32 + size as f32));
    }
}

#[test]
fn half_a_step_out_is_a_mistake() {
    let fmu = Fmu::load("first_order_lag");
    for size in [1e-6, 1e-4, 0.1] {
        let slave = until(&fmu, 1e4 * size);
        assert_eq!(slave.step(0.0, size), OK);
        for wrong in [0.0, 0.5, 1.5, 2.0, -1.0] {
            assert_eq!(slave.step(wrong * size, size), ERROR);
            assert!(slave.message().contains("but the last step ended at"), "{}", slave.message());
        }
        assert_eq!(slave.step(size, 1.1e4 * size), ERROR);
        assert!(slave.message().contains("past the stop time"));
        assert_eq!(slave.step(size, 9998.5 * size), OK);
        assert_eq!(slave.step(9999.5 * size, size), ERROR, "half a step past the stop time");
        assert_eq!(slave.step(9999.5 * size, 0.5 * size), OK);
    }
}

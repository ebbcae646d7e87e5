//! `cargo bench -p grasp-plant`: time of a step, of a new step size, of one that is new in every step, of a new plant, and of one with its first step, printed per order.

#![allow(clippy::doc_markdown)]

use grasp_plant::{Inputs, Parameters, Plant};
use std::hint::black_box;
use std::time::Instant;

fn nanoseconds(repetitions: u32, mut task: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    // The best of many short batches: what the machine does when it is not doing something else.
    for _ in 0..100 {
        let begin = Instant::now();
        for _ in 0..repetitions {
            task();
        }
        best = best.min(begin.elapsed().as_secs_f64() / f64::from(repetitions) * 1e9);
    }
    best
}

fn main() {
    println!(
        "order   hold+measured   ramp+measured   direct   fields   kinked ramp   new size   always new   new plant   with a step"
    );
    for order in [4, 8, 12, 16, 24] {
        let parameters = Parameters { order, ..Parameters::default() };
        let mut plant = Plant::new(parameters).expect("valid");
        let mut phase = 0.0f64;
        let mut inputs = move || {
            phase += 1e-3;
            Inputs { torque_command: [0.1 * phase.sin(), -0.1 * phase.sin()], force_command: 0.1, ..Inputs::ZERO }
        };
        let ramp = Inputs { force_command: 1e-3, ..Inputs::ZERO };
        let kinked = Inputs { force_command: 1e4, ..Inputs::ZERO };
        let hold = nanoseconds(1_000, || {
            plant.step(1e-4, black_box(&inputs()), &Inputs::ZERO).expect("valid");
            black_box(plant.measured());
        });
        let ramped = nanoseconds(1_000, || {
            plant.step(1e-4, black_box(&inputs()), &ramp).expect("valid");
            black_box(plant.measured());
        });
        let direct = nanoseconds(1_000, || {
            black_box(plant.direct(black_box(&Inputs::ZERO)));
        });
        let fields = nanoseconds(1_000, || {
            black_box((plant.deflection(), plant.energy(), plant.constraint(), plant.tip_deflection()));
        });
        let broken = nanoseconds(20, || plant.step(1e-4, black_box(&inputs()), &kinked).expect("valid"));
        let mut h = 1e-4;
        let new = nanoseconds(1, || {
            h *= 1.0 + 1e-9;
            // Its second step is one of a size that repeats.
            plant.step(h, &Inputs::ZERO, &Inputs::ZERO).expect("valid");
            plant.step(h, &Inputs::ZERO, &Inputs::ZERO).expect("valid");
        });
        let always = nanoseconds(20, || {
            h *= 1.0 + 1e-9;
            plant.step(h, &Inputs::ZERO, &Inputs::ZERO).expect("valid");
        });
        // Each a little other than the last: equal ones would share.
        let mut parameters = Parameters { order, ..Parameters::default() };
        let plants = nanoseconds(1, || {
            parameters.object_mass *= 1.0 + 1e-9;
            black_box(Plant::new(parameters.clone()).expect("valid"));
        });
        let started = nanoseconds(1, || {
            parameters.object_mass *= 1.0 + 1e-9;
            let mut plant = Plant::new(parameters.clone()).expect("valid");
            plant.step(1e-4, &Inputs::ZERO, &Inputs::ZERO).expect("valid");
            black_box(plant);
        });
        println!(
            "{order:5} {hold:12.0} ns {ramped:12.0} ns {direct:5.0} ns {fields:5.0} ns {broken:10.0} ns {:8.1} µs {:9.1} µs {:9.0} µs {:11.0} µs",
            new / 1e3,
            always / 1e3,
            plants / 1e3,
            started / 1e3
        );
    }
}

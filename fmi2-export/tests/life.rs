//! Resetting, repeating, going back, running side by side: always the same numbers, to the bit.

mod common;

use std::path::Path;

use common::real::{all_libraries, count, reals, set_reals, trajectory};
use common::{ERROR, Fmu, OK, sizes_of_all_magnitudes};

/// Runs a check with every model of every library there is.
fn with_every_model(check: impl Fn(&Fmu, &str, &Path)) {
    for path in all_libraries() {
        let fmu = Fmu::open(&path);
        for guid in fmu.guids() {
            check(&fmu, &guid, &path);
        }
    }
}

#[test]
fn reset_leads_back_to_the_instantiated_state_exactly() {
    with_every_model(|fmu, guid, path| {
        let counts = count(fmu, guid);
        let slave = fmu.instantiate(guid);
        let fresh = slave.blob();
        set_reals(&slave, counts, |vr| 0.5 + f64::from(vr % 2));
        let reset = || {
            assert_eq!(fmu.fmi2Reset(slave.component), OK);
            assert!(slave.blob() == fresh, "{}", path.display());
        };
        reset();
        let first = trajectory(&slave, counts, 20, 0);
        reset();
        assert_eq!(trajectory(&slave, counts, 20, 0), first, "{}", path.display());
        assert_eq!(slave.step(-1.0, 1e-3), ERROR);
        reset();
        slave.initialize();
        assert_eq!(fmu.fmi2Terminate(slave.component), OK);
        reset();
        // In initialization mode, with values that it has been set.
        assert_eq!(fmu.fmi2SetupExperiment(slave.component, 1, 1e-3, 1.0, 1, 2.0), OK);
        assert_eq!(fmu.fmi2EnterInitializationMode(slave.component), OK);
        set_reals(&slave, counts, |_| 0.25);
        reset();
        let other = fmu.instantiate(guid);
        assert_eq!(trajectory(&other, counts, 20, 0), first, "another instance");
    });
}

#[test]
fn going_back_and_repeating_gives_the_same_bits_with_either_announcement() {
    with_every_model(|fmu, guid, path| {
        let counts = count(fmu, guid);
        for no_set_state_before in [0, 1] {
            let slave = fmu.instantiate(guid);
            slave.initialize();
            let step = |i: u32| {
                set_reals(&slave, counts, |vr| 1e-3 * f64::from((vr + i) % 5));
                let status = fmu.fmi2DoStep(slave.component, f64::from(i) / 1024.0, 1.0 / 1024.0, no_set_state_before);
                assert!(status == OK, "{:?}", slave.log);
                reals(&slave, counts).iter().map(|value| value.to_bits()).collect::<Vec<u64>>()
            };
            (0..5).for_each(|i| _ = step(i));
            let (state, blob) = (slave.save(), slave.blob());
            let first: Vec<_> = (5..10).map(step).collect();
            assert_eq!(fmu.fmi2SetFMUstate(slave.component, state), OK);
            assert_eq!((5..10).map(step).collect::<Vec<_>>(), first, "{}", path.display());
            assert_eq!(slave.load(&blob), OK);
            assert_eq!((5..10).map(step).collect::<Vec<_>>(), first, "{} from bytes", path.display());
            assert!(slave.blob().len() < 1_000_000);
        }
    });
}

#[test]
fn a_state_does_not_depend_on_what_has_been_read() {
    with_every_model(|fmu, guid, path| {
        let counts = count(fmu, guid);
        let run = |read: bool| {
            let slave = fmu.instantiate(guid);
            slave.initialize();
            for i in 0..10 {
                set_reals(&slave, counts, |vr| 1e-3 * f64::from((vr + i) % 5));
                if read {
                    reals(&slave, counts);
                }
                assert!(slave.step(f64::from(i) / 1024.0, 1.0 / 1024.0) == OK);
                if read {
                    reals(&slave, counts);
                }
            }
            reals(&slave, counts)
        };
        assert_eq!(run(false), run(true), "{}", path.display());
    });
}

#[test]
fn steps_of_any_size_add_up() {
    with_every_model(|fmu, guid, path| {
        let slave = fmu.instantiate(guid);
        slave.initialize();
        let mut time = 0.0;
        for size in sizes_of_all_magnitudes() {
            let status = slave.step(time, size);
            assert!(status == OK, "{}: {size:?} {:?}", path.display(), slave.log);
            time += size;
            let mut last = f64::NAN;
            assert_eq!(fmu.fmi2GetRealStatus(slave.component, 2, &mut last), OK);
            assert_eq!(last.to_bits(), time.to_bits());
        }
        assert!(reals(&slave, count(fmu, guid)).iter().all(|value| value.is_finite()), "{}", path.display());
    });
}

#[test]
fn instances_in_threads_give_the_bits_of_a_single_one() {
    with_every_model(|fmu, guid, path| {
        let counts = count(fmu, guid);
        let expected: Vec<_> = (0..4).map(|seed| trajectory(&fmu.instantiate(guid), counts, 50, seed)).collect();
        std::thread::scope(|scope| {
            for thread in 0..8 {
                let expected = &expected;
                scope.spawn(move || {
                    for seed in 0..4 {
                        let slave = fmu.instantiate(guid);
                        let bits = trajectory(&slave, counts, 50, (thread + seed) % 4);
                        assert_eq!(bits, expected[((thread + seed) % 4) as usize], "{}", path.display());
                        slave.blob();
                    }
                });
            }
        });
    });
}

#[test]
fn an_instance_that_moves_between_threads_gives_the_same_bits() {
    with_every_model(|fmu, guid, path| {
        let counts = count(fmu, guid);
        let run = |moving: bool| {
            let slave = fmu.instantiate(guid);
            slave.initialize();
            let component = slave.component.expose_provenance();
            let mut bits = Vec::new();
            for i in 0..20 {
                let step = move || {
                    let c = std::ptr::with_exposed_provenance_mut(component);
                    fmu.fmi2DoStep(c, f64::from(i) / 1024.0, 1.0 / 1024.0, 1)
                };
                let status =
                    if moving { std::thread::scope(|scope| scope.spawn(step).join().unwrap()) } else { step() };
                assert!(status == OK);
                bits.extend(reals(&slave, counts).iter().map(|value| value.to_bits()));
            }
            bits
        };
        assert_eq!(run(true), run(false), "{}", path.display());
    });
}

#[test]
fn many_instances_at_once_do_not_disturb_each_other() {
    with_every_model(|fmu, guid, path| {
        let counts = count(fmu, guid);
        let alone = trajectory(&fmu.instantiate(guid), counts, 5, 0);
        let slaves: Vec<_> = (0..100).map(|_| fmu.instantiate(guid)).collect();
        for slave in &slaves {
            slave.initialize();
        }
        let mut bits = vec![Vec::new(); slaves.len()];
        let mut time = 0.0;
        for i in 0..5 {
            for (slave, bits) in slaves.iter().zip(&mut bits) {
                set_reals(slave, counts, |vr| 1e-3 * f64::from((vr * 7 + i * 3) % 11));
                assert!(slave.step(time, 1e-3) == OK);
                bits.extend(reals(slave, counts).iter().map(|value| value.to_bits()));
            }
            time += 1e-3;
        }
        assert!(bits.iter().all(|bits| *bits == alone), "{}", path.display());
    });
}

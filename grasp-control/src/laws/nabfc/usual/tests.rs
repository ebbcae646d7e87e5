//! The usual step gives what the general way gives, to the bit.

use super::evaluation::Evaluation;
use super::table::Table;
use super::{State, learn, look, step};
use crate::blocks::four::{Four, Narrow, Portable};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};
use crate::laws::nabfc::{Gains, Nabfc};
use crate::{Arms, Commands, Inputs, Law};

const H: f64 = 1e-4;

/// Inputs in motion, as a grasp has them.
fn inputs(step: u32) -> Inputs {
    let at = |i: usize| (0.05 * f64::from(step) + 1.7 * i as f64).sin();
    let scales = [0.1, 0.1, 0.3, 0.3, 0.05, 0.02, 0.1, 0.1, 0.5, 0.5, 5.0, 5.0, 1.0, 1.0, 0.5, 0.05];
    Inputs::from_array(std::array::from_fn(|i| scales[i] * at(i)))
}

/// The text format keeps every bit.
fn text(law: &Nabfc) -> String {
    serde_json::to_string(law).unwrap()
}

fn bits(commands: &Commands) -> [u64; 3] {
    commands.to_array().map(f64::to_bits)
}

fn arms() -> Arms {
    Arms { ei: [0.1, 0.13], length: 0.21, hub_distance: 0.11 }
}

/// Different arms, so that nothing can stand in the other one's place.
fn gains(gains: &Gains) -> Gains {
    let mut gains = *gains;
    let other = &mut gains.posture[1];
    (other.xi, other.k, other.mu, other.c3, other.epsilon2) =
        (other.xi * 1.1, other.k * 1.2, other.mu * 1.3, other.c3 * 1.4, other.epsilon2 * 1.5);
    (other.a3, other.a4, other.zeta1, other.zeta2, other.g1, other.g2) =
        (other.a3 * 1.6, other.a4 * 0.7, 0.3, 0.8, 0.01, 0.9);
    gains
}

fn state(law: &mut Nabfc) -> State<'_> {
    State::of(&mut law.object, &mut law.posture, &mut law.shear_rate).unwrap()
}

#[test]
fn in_any_registers_it_gives_the_bits_of_the_general_way() {
    fn check<V: Four>(gains: &Gains) {
        let mut law = Nabfc::new(arms(), *gains).unwrap();
        law.initialize(&inputs(0));
        let mut general = law.clone();
        let table = Table::new(&law, H).expect("a usual step");
        let mut at = Evaluation::default();
        for i in 1..200 {
            let mut inputs = inputs(i);
            if i % 5 == 0 {
                // The low-pass is in equilibrium.
                inputs.measured.tip_shear_dot = law.shear_rate.state();
            }
            let is_evaluated = i % 3 == 0;
            if is_evaluated {
                at.fill::<V>(&table, &inputs);
                let commands = look::<V>(&table, state(&mut law), &inputs, &at);
                assert_eq!(bits(&commands), bits(&general.commands_here::<Narrow>(&inputs)), "before step {i}");
            }
            let commands = if is_evaluated {
                learn::<V>(&table, state(&mut law), &inputs, &at);
                look::<V>(&table, state(&mut law), &inputs, &at)
            } else {
                step::<V>(&table, state(&mut law), &inputs)
            };
            general.step_here::<Narrow>(H, &inputs, &Inputs::HELD).unwrap();
            let expected = bits(&general.commands_here::<Narrow>(&inputs));
            assert_eq!(bits(&commands), expected, "step {i}");
            assert_eq!(bits(&law.commands(&inputs)), expected, "asked again in step {i}");
        }
        assert_eq!(text(&law), text(&general));
    }
    for gains in [Gains::default(), Gains::fast()].map(|other| gains(&other)) {
        check::<Portable>(&gains);
        check::<Narrow>(&gains);
        #[cfg(target_arch = "x86_64")]
        if has_wide_registers() {
            check::<Wide>(&gains);
        }
    }
}

/// Commands before a step, after it, for other inputs in between, other step sizes, gains that change, ramps: every order of calls gives
/// the bits of a law that is restored before every call, and so keeps nothing.
#[test]
fn what_is_kept_changes_nothing() {
    let mut law = Nabfc::new(arms(), gains(&Gains::default())).unwrap();
    law.initialize(&inputs(0));
    let fresh = |law: &Nabfc| serde_json::from_str::<Nabfc>(&text(law)).unwrap();
    let mut random = 1_u64;
    for i in 1..600 {
        let mut choose = |n: u64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) % n
        };
        let seen = inputs(if choose(4) == 0 { i - 1 } else { i });
        let mut other = fresh(&law);
        match choose(12) {
            0..3 => assert_eq!(bits(&law.commands(&seen)), bits(&other.commands(&seen)), "commands at {i}"),
            3 => assert_eq!(law.jacobian(&seen), other.jacobian(&seen), "jacobian at {i}"),
            4 => assert_eq!(law.estimate_rates(&seen), other.estimate_rates(&seen), "rates at {i}"),
            5 => {
                let mut gains = *law.gains();
                gains.object.k *= 1.01;
                law.set_gains(gains).unwrap();
                other.set_gains(gains).unwrap();
            }
            way => {
                let h = if way == 6 { 1e-5 * (2 + choose(7)) as f64 } else { H };
                let rates = if way == 7 { inputs(i + 50) } else { Inputs::HELD };
                law.step(h, &seen, &rates).unwrap();
                other.step(h, &seen, &rates).unwrap();
                if choose(2) == 0 {
                    assert_eq!(bits(&law.commands(&seen)), bits(&other.commands(&seen)), "commands after step {i}");
                }
            }
        }
        assert_eq!(text(&law), text(&other), "{i}");
    }
}

/// Zeros of both signs are different inputs where a command is a zero: its sign is that of a law that keeps nothing, whichever the law has seen
/// before.
#[test]
fn what_is_kept_for_zeros_has_their_signs() {
    let arms = arms();
    let zeros = |choice: usize| {
        let mut values: [f64; 16] = std::array::from_fn(|i| if choice >> i & 1 == 0 { 0.0 } else { -0.0 });
        // Where the object is at its target.
        values[4] = 0.5 * arms.hub_distance;
        Inputs::from_array(values)
    };
    let mut law = Nabfc::new(arms, gains(&Gains::default())).unwrap();
    law.initialize(&zeros(0));
    let mut random = 1_u64;
    for i in 0..2000 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let (seen, way) = (zeros((random >> 40) as usize), (random >> 33) % 4);
        let mut fresh = serde_json::from_str::<Nabfc>(&text(&law)).unwrap();
        match way {
            0 => {
                law.step(H, &seen, &Inputs::HELD).unwrap();
                fresh.step(H, &seen, &Inputs::HELD).unwrap();
            }
            1 => assert_eq!(format!("{:?}", law.jacobian(&seen)), format!("{:?}", fresh.jacobian(&seen)), "{i}"),
            _ => assert_eq!(bits(&law.commands(&seen)), bits(&fresh.commands(&seen)), "{i}"),
        }
        assert_eq!(text(&law), text(&fresh), "{i}");
    }
}

#[test]
fn equal_laws_share_a_table_and_nothing_is_kept() {
    let table = |factor: f64| {
        let mut gains = gains(&Gains::default());
        gains.object.k *= factor;
        super::shared::shared(&Table::new(&Nabfc::new(arms(), gains).unwrap(), H).unwrap())
    };
    let first = table(1.25);
    assert!(std::sync::Arc::ptr_eq(&first, &table(1.25)));
    assert!(!std::sync::Arc::ptr_eq(&first, &table(1.5)));
    let weak = std::sync::Arc::downgrade(&first);
    drop(first);
    assert!(weak.upgrade().is_none());
}

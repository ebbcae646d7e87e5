//! The networks against their definition.

use super::basis::in_lanes;
use super::layout::GROUPS;
use super::{Layout, Network};
use crate::blocks::exponential::powers;
use crate::blocks::four::{Four, Lanes, Narrow, Portable};
#[cfg(target_arch = "x86_64")]
use crate::blocks::four::{Wide, has_wide_registers};
use proptest::prelude::*;

/// The definition, node by node.
fn gaussian<const D: usize>(x: [f64; D], centre: [f64; D], width: f64) -> f64 {
    let distance2: f64 = x.iter().zip(centre).map(|(x, c)| (x - c).powi(2)).sum();
    (-distance2 / width.powi(2)).exp()
}

fn assert_definition<const D: usize>(layout: Layout, width: f64, x: [f64; D]) {
    let mut network = Network::<D>::new(layout, width);
    network.activate(x);
    for (node, activation) in network.activations().enumerate() {
        let expected = gaussian(x, network.centre(node), width);
        // Exponents of up to 340 cost as many ulp; negligible factors are flushed to zero.
        assert!((activation - expected).abs() < 1e-12 * expected + 1e-29, "{layout:?} {width} {x:?} {node}");
    }
}

fn weighted<const D: usize>(layout: Layout, width: f64) -> Network<D> {
    let mut network = Network::<D>::new(layout, width);
    for node in 0..layout.nodes(D) {
        network.set_weight(node, (1.7 * node as f64).sin());
    }
    network
}

#[test]
fn layouts_have_the_documented_sizes_and_centres() {
    assert_eq!(Layout::Grid(5).nodes(3), 125);
    assert_eq!(Layout::Star(2).nodes(7), 29);
    let grid = Network::<3>::new(Layout::Grid(3), 1.0);
    assert_eq!(grid.centre(0), [-1.0, -1.0, -1.0]);
    assert_eq!(grid.centre(13), [0.0; 3]);
    assert_eq!(grid.centre(14), [0.0, 0.0, 1.0]);
    let star = Network::<2>::new(Layout::Star(2), 1.0);
    let centres: Vec<_> = (0..9).map(|node| star.centre(node)).collect();
    assert_eq!(
        centres,
        [
            [0.0, 0.0],
            [-1.0, 0.0],
            [-0.5, 0.0],
            [0.5, 0.0],
            [1.0, 0.0],
            [0.0, -1.0],
            [0.0, -0.5],
            [0.0, 0.5],
            [0.0, 1.0],
        ]
    );
}

#[test]
fn extreme_inputs_activate_nothing_and_give_no_nan() {
    for x in [1e3, -1e9, 1e300, f64::MAX, f64::MIN] {
        let mut grid = weighted::<3>(Layout::Grid(9), 0.1);
        grid.activate([x, 0.0, 0.3]);
        assert_eq!(grid.output(), 0.0);
        assert_eq!(grid.gradient(), [0.0; 3]);
        let mut star = weighted::<7>(Layout::Star(4), 10.0);
        star.activate([x; 7]);
        assert_eq!(star.output(), 0.0);
        assert_eq!(star.gradient(), [0.0; 7]);
    }
}

/// Also where the factors of narrow Gaussians are so tiny and so huge that their squares are not numbers.
#[test]
fn the_learning_gain_is_the_sum_of_squared_activations() {
    for width in [0.1, 0.15, 0.24, 0.25, 1.1] {
        for layout in [Layout::Grid(2), Layout::Grid(5), Layout::Grid(9), Layout::Star(2)] {
            let mut network = Network::<3>::new(layout, width);
            for i in 0..1000_u32 {
                let x = std::array::from_fn(|axis| 2.7 * (f64::from(i) * (1.0 + 0.37 * axis as f64)).sin());
                network.activate(x);
                let expected: f64 = network.activations().map(|activation| activation * activation).sum();
                let gain = network.learning_gain();
                assert!((gain - expected).abs() <= 1e-13 * expected, "{layout:?} {width} {x:?}: {gain} {expected}");
            }
        }
    }
}

#[test]
fn activations_survive_serialisation_by_recomputation() {
    let mut network = weighted::<3>(Layout::Grid(4), 0.6);
    network.activate([0.1, -0.2, 0.3]);
    let text = serde_json::to_string(&network).unwrap();
    let mut copy: Network<3> = serde_json::from_str(&text).unwrap();
    copy.activate([0.1, -0.2, 0.3]);
    assert_eq!(copy.output(), network.output());
}

/// The output that adaptation leaves behind is the one that a copy without it computes, to the bit; and the registers
/// change nothing.
#[test]
fn every_way_to_the_output_gives_the_same_bits() {
    fn check<const D: usize>(layout: Layout) {
        let mut network = weighted::<D>(layout, 0.7);
        let (mut plain, mut portable) = (network.clone(), network.clone());
        for step in 0..20 {
            let x = std::array::from_fn(|axis| (0.3 * f64::from(step) + axis as f64).sin());
            network.activate(x);
            plain.activate_here::<Narrow>(&in_lanes(x));
            network.adapt(0.99, 0.1);
            plain.adapt_here::<Narrow>(0.99, 0.1);
            portable.activate_here::<Portable>(&in_lanes(x));
            portable.adapt_in::<Portable>(0.99, 0.1);
            for plain in [&mut plain, &mut portable] {
                assert_eq!(network.weights, plain.weights);
                plain.forget_outputs();
                assert_eq!(network.output().to_bits(), plain.output().to_bits(), "{layout:?}");
            }
        }
    }
    for n in 1..=9 {
        check::<3>(Layout::Grid(n));
    }
    for rings in 0..=4 {
        check::<7>(Layout::Star(rings));
    }
}

/// Learning at two points at once is learning at one after the other, up to rounding; and the same bits in all registers.
#[test]
fn learning_at_two_points_at_once_is_learning_at_one_after_the_other() {
    fn learn<V: Four>(points: [[Lanes; GROUPS]; 2]) -> (Network<7>, f64) {
        let mut network = weighted::<7>(Layout::Star(2), 0.7);
        assert!(network.is_plain());
        network.activate_here::<V>(&points[0]);
        let last = points.map(|x| V::load(&x[1]));
        let of_both = powers(last.map(|x| network.last_exponents(x)));
        network.fill_plain_both(last[1], of_both);
        network.adapt_twice::<V>(0.99, [0.1, 0.2]);
        let output = network.output();
        (network, output)
    }
    let points = [0.3, -0.2].map(|last| in_lanes([0.1, -0.2, last, 0.4, 0.0, -last, 0.5 * last]));
    let (network, output) = learn::<Narrow>(points);
    let mut plain = weighted::<7>(Layout::Star(2), 0.7);
    for (x, decay, weight) in [(points[0], 0.99, 0.1), (points[1], 1.0, 0.2)] {
        plain.activate_lanes(&x);
        plain.adapt(decay, weight);
    }
    for (found, expected) in network.weights().zip(plain.weights()) {
        assert!((found - expected).abs() < 1e-15, "{found} {expected}");
    }
    let mut again = network.clone();
    again.activate_lanes(&points[1]);
    assert_eq!(output.to_bits(), again.output().to_bits());
    let check = |(other, of_other): (Network<7>, f64)| {
        assert_eq!((&other.weights, of_other.to_bits()), (&network.weights, output.to_bits()));
    };
    check(learn::<Portable>(points));
    #[cfg(target_arch = "x86_64")]
    if has_wide_registers() {
        check(learn::<Wide>(points));
    }
}

/// The ways for plain networks give the same bits as the general ones.
#[test]
fn plain_networks_are_evaluated_the_same() {
    let (z, x) = (in_lanes([0.3, -1.2, 0.7]), in_lanes([0.1, -0.2, 0.9, 0.4, 0.0, -2.0, 0.5]));
    let (mut grid, mut star) = (weighted::<3>(Layout::Grid(5), 0.7), weighted::<7>(Layout::Star(2), 0.7));
    let mut plain = (grid.clone(), star.clone());
    grid.activate_lanes(&z);
    star.activate_lanes(&x);
    let last = Narrow::load(&z[0]);
    let [of_last] = powers([plain.0.last_exponents(last)]);
    plain.0.fill_plain_grid(last, of_last);
    let first = plain.1.first_exponents(Narrow::load(&x[0]));
    let last = Narrow::load(&x[1]);
    let [of_first, of_last] = powers([first, plain.1.last_exponents(last)]);
    plain.1.fill_plain_first(of_first);
    plain.1.fill_plain_last(last, of_last);
    for (at, plain) in [(grid.at, plain.0.at), (star.at, plain.1.at)] {
        let (at, plain) = (at.unwrap(), plain.unwrap());
        assert_eq!((at.inner, at.outer, at.point), (plain.inner, plain.outer, plain.point));
    }
}

/// Points and widths where factors of an activation are as large and as small as they get.
#[test]
fn narrow_gaussians_far_out_are_the_gaussians() {
    for n in 1..=9 {
        for x in [[1.84, 1.84, 0.0], [1.24, 1.24, 1.24], [1.8, -1.8, 1.8], [2.5, 0.0, -0.3], [2.6, 2.6, 2.6]] {
            for width in [0.1, 0.12, 0.2, 0.249, 0.25, 0.3] {
                assert_definition::<3>(Layout::Grid(n), width, x);
            }
        }
    }
}

#[test]
fn impossible_stored_networks_are_refused() {
    let good = Network::<3>::new(Layout::Grid(2), 0.5);
    let text = serde_json::to_string(&good).unwrap();
    assert!(serde_json::from_str::<Network<3>>(&text).is_ok());
    assert!(serde_json::from_str::<Network<7>>(&text).is_err());
    for (part, instead) in [("2", "200"), ("0.5", "0.0"), ("[0.0,", "[")] {
        assert!(text.contains(part));
        assert!(serde_json::from_str::<Network<3>>(&text.replacen(part, instead, 1)).is_err(), "{instead}");
    }
}

proptest! {
    #[test]
    fn grid_activations_are_the_gaussians(
        n in 1_usize..=9, width in 0.1..3.0, x in prop::array::uniform3(-2.5..2.5),
    ) {
        assert_definition::<3>(Layout::Grid(n), width, x);
    }

    #[test]
    fn star_activations_are_the_gaussians(
        rings in 0_usize..=4, width in 0.1..3.0, x in prop::array::uniform7(-2.5..2.5),
    ) {
        assert_definition::<7>(Layout::Star(rings), width, x);
    }

    /// Central differences of step 1e-5: truncation ~1e-10 times the third derivative (≤ ~1e3 at these widths).
    #[test]
    fn gradients_agree_with_differences(
        width in 0.4..2.0, x in prop::array::uniform3(-1.5..1.5), rings in 1_usize..=4, n in 2_usize..=5,
    ) {
        fn check<const D: usize>(mut network: Network<D>, x: [f64; D]) {
            network.activate(x);
            let gradient = network.gradient();
            for (axis, slope) in gradient.into_iter().enumerate() {
                let mut at = |step: f64| {
                    let mut moved = x;
                    moved[axis] += step;
                    network.activate(moved);
                    network.output()
                };
                let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                assert!((slope - difference).abs() < 1e-6, "{slope} {difference}");
            }
        }
        check(weighted::<3>(Layout::Grid(n), width), x);
        check(weighted::<3>(Layout::Star(rings), width), x);
    }
}

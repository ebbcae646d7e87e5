#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // coordinates from 0 to 1 become numbers of boxes

use super::*;

fn sampler(method: &str, vary: &str) -> Sampler {
    let text = format!("title = \"x\"\nsystem = \"nabfc\"\nseed = 7\n{method}\n[vary]\n{vary}");
    Sampler::new(&Study::parse("x.toml", &text).unwrap(), None).unwrap()
}

/// The draws of parameters a and b with ranges from 0 to 1.
fn unit(method: &str, draws: u64) -> Vec<[f64; 2]> {
    let range = "{ low = 0, high = 1 }";
    let sampler = sampler(&format!("method = \"{method}\"\ndraws = {draws}"), &format!("a = {range}\nb = {range}"));
    let real = |value: &Value| if let Value::Real(value) = value { *value } else { panic!("{value}") };
    (0..draws).map(|draw| sampler.values(draw)).map(|values| [real(&values[0]), real(&values[1])]).collect()
}

/// Star discrepancy in L², by Warnock's formula.
fn discrepancy(points: &[[f64; 2]]) -> f64 {
    let count = points.len() as f64;
    let single: f64 = points.iter().map(|[x, y]| (1.0 - x * x) * (1.0 - y * y)).sum();
    let pairs = points.iter().flat_map(|[x, y]| points.iter().map(move |[u, v]| (1.0 - x.max(*u)) * (1.0 - y.max(*v))));
    (1.0 / 9.0 - single / (2.0 * count) + pairs.sum::<f64>() / (count * count)).sqrt()
}

#[test]
fn a_latin_hypercube_hits_every_stratum_once() {
    for dimension in 0..2 {
        let mut strata: Vec<_> =
            unit("latin-hypercube", 1000).iter().map(|point| (point[dimension] * 1000.0).floor() as usize).collect();
        assert!(strata.windows(2).any(|pair| pair[0] + 1 != pair[1]), "in random order");
        strata.sort_unstable();
        assert_eq!(strata, (0..1000).collect::<Vec<_>>());
    }
}

#[test]
fn a_sobol_sequence_is_a_net_and_more_even_than_chance() {
    let points = unit("sobol", 256);
    // A (0, 8, 2)-net in base 2: each of the 2⁸ boxes of every shape 2⁻ᵏ × 2⁻⁽⁸⁻ᵏ⁾ has one point.
    for k in 0..=8 {
        let (columns, rows) = (f64::from(1 << k), f64::from(1 << (8 - k)));
        let mut boxes: Vec<_> =
            points.iter().map(|[x, y]| ((x * columns).floor() as usize, (y * rows).floor() as usize)).collect();
        boxes.sort_unstable();
        boxes.dedup();
        assert_eq!(boxes.len(), 256, "k = {k}");
    }
    // Chance has a mean square of (1/4 − 1/9)/N.
    let chance = ((0.25 - 1.0 / 9.0) / 256.0_f64).sqrt();
    assert!(discrepancy(&points) < 0.25 * chance, "{} against {chance}", discrepancy(&points));
    let random = discrepancy(&unit("random", 256));
    assert!(random > 0.25 * chance && random < 3.0 * chance, "{random} against {chance}");
}

#[test]
fn draws_depend_on_seed_and_index_only() {
    for method in ["sobol", "random"] {
        assert_eq!(unit(method, 64)[..16], unit(method, 16), "{method}: more draws go on");
    }
    assert_ne!(unit("random", 16), unit("sobol", 16));
}

#[test]
fn distributions_have_their_moments() {
    let vary = "n = { mean = 2, sd = 0.5 }\nt = { mean = 2, sd = 0.5, low = 2 }\ng = { low = 0.01, high = 100, scale = \"log\" }";
    let sampler = sampler("method = \"latin-hypercube\"\ndraws = 20000", vary);
    let mut columns = [Vec::new(), Vec::new(), Vec::new()];
    for draw in 0..20_000 {
        for (column, value) in columns.iter_mut().zip(sampler.values(draw)) {
            let Value::Real(value) = value else { panic!() };
            column.push(value);
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let [g, n, t] = &columns;
    // Stratified, so errors are of the order of 1/N of the ranges; 1e-3 is far above.
    assert!((mean(n) - 2.0).abs() < 1e-3);
    let spread = mean(&n.iter().map(|x| (x - 2.0).powi(2)).collect::<Vec<_>>()).sqrt();
    assert!((spread - 0.5).abs() < 1e-3, "{spread}");
    // Half a normal distribution has its mean at σ√(2/π).
    assert!((mean(t) - (2.0 + 0.5 * (2.0 / std::f64::consts::PI).sqrt())).abs() < 1e-3);
    assert!(t.iter().all(|value| *value >= 2.0));
    assert!(mean(&g.iter().map(|x| x.ln()).collect::<Vec<_>>()).abs() < 1e-3);
    assert!((normal::quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-14);
}

#[test]
fn a_grid_has_every_combination_and_seeds_differ() {
    let vary = "a = { low = 1, high = 3, count = 3 }\nb = [\"x\", \"y\"]\nc = { seed = true, count = 2 }";
    let sampler = sampler("method = \"grid\"", vary);
    assert_eq!(sampler.draws(), 12);
    let rows: Vec<_> = (0..12).map(|draw| sampler.values(draw)).collect();
    let shown: Vec<_> = rows.iter().map(|row| format!("{}{}", row[0], row[1])).collect();
    assert_eq!(shown, ["1x", "1x", "1y", "1y", "2x", "2x", "2y", "2y", "3x", "3x", "3y", "3y"]);
    let mut seeds: Vec<_> = rows.iter().map(|row| row[2].to_string()).collect();
    seeds.sort();
    seeds.dedup();
    assert_eq!(seeds.len(), 12);
}

#[test]
fn a_table_gives_values_or_coordinates() {
    let text = "title = \"x\"\nsystem = \"nabfc\"\nmethod = \"table\"\npoints = \"p.csv\"\n";
    let points = Points::parse_csv("p.csv", "M,note\n0,a\n0.5,b\n1,c\n").unwrap();
    let sampler =
        |more: &str| Sampler::new(&Study::parse("x.toml", &(text.to_owned() + more)).unwrap(), Some(points.clone()));
    let as_is = sampler("").unwrap();
    assert_eq!((as_is.draws(), as_is.values(1)), (3, vec![Value::Real(0.5), Value::from("b")]));
    let unit = sampler("coordinates = \"unit\"\n[vary]\nM = { low = 1, high = 3 }").unwrap();
    assert_eq!(unit.values(1), [Value::Real(2.0)]);
    let message = sampler("[vary]\nJ = {}").unwrap_err().to_string();
    assert!(message.contains("x.toml:6: p.csv has no column \"J\"; it has M, note"), "{message}");
    let message = sampler("coordinates = \"unit\"\n[vary]\nnote = { low = 1, high = 3 }").unwrap_err().to_string();
    assert!(message.contains("row 1, column \"note\": a number from 0 to 1 is needed, not a"), "{message}");
}

#[test]
fn too_many_are_refused() {
    let study = |text: &str| {
        Study::parse(
            "x.toml",
            &format!(
                "title = \"x\"\nsystem = \"nabfc\"\n{text}\n[vary]\nM = {{ low = 1, high = 2, count = 100000000 }}"
            ),
        )
        .unwrap()
    };
    assert!(matches!(Sampler::new(&study("method = \"grid\""), None), Err(SampleError::TooManyRuns { .. })));
    assert_eq!(Sampler::new(&study("method = \"sobol\"\ndraws = 65537"), None).unwrap_err(), SampleError::SobolEnds);
}

fn probes(sampler: &Sampler) -> Vec<Vec<Value>> {
    (0..sampler.vary().len()).map(|parameter| sampler.probes(parameter).collect()).collect()
}

fn number(value: &Value) -> f64 {
    if let Value::Real(number) = value { *number } else { f64::NAN }
}

/// Ends and lists as the study has them, the middle of what has no ends, and all that a grid or a table has.
#[test]
fn probes_stand_for_all_draws() {
    let text = "title = \"x\"\nsystem = \"pd\"\nmethod = \"random\"\ndraws = 2000\n[vary]\na = { low = 1, high = 2 }\n\
                b = { mean = 3, sd = 2 }\nc = [\"x\", \"y\"]\nd = { seed = true }\n";
    let sampler = Sampler::new(&Study::parse("x.toml", text).unwrap(), None).unwrap();
    let probed = probes(&sampler);
    assert_eq!(probed[0][..2], [Value::Real(1.0), Value::Real(2.0)]);
    assert!(number(&probed[0][2]).fract() > 0.0);
    assert_eq!(probed[2], [Value::from("x"), Value::from("y")]);
    // Φ⁻¹(0.95) = 1.644853627: a table of the normal distribution.
    for (probe, exact) in probed[1].iter().zip([3.0 - 2.0 * 1.644_853_627, 3.0 + 2.0 * 1.644_853_627]) {
        assert!((number(probe) - exact).abs() < 1e-8, "{probe}");
    }
    let seeds = probed[3].iter().map(|seed| if let Value::Integer(seed) = seed { *seed } else { 0 });
    assert!(seeds.eq([i32::MAX / 20, i32::MAX / 20 * 19 + 6]), "{:?}", probed[3]);
    // Draws come close to both ends, and do not reach them.
    let [low, high] = sampler.drawn_ends(0).unwrap().map(|end| number(&end));
    assert!(1.0 < low && low < 1.01 && 1.99 < high && high < 2.0, "{low} {high}");
    assert_eq!([1, 2, 3].map(|parameter| sampler.drawn_ends(parameter)), [None, None, None]);
    let grid = "title = \"x\"\nsystem = \"pd\"\nmethod = \"grid\"\n[vary]\na = { low = 4, high = 12, count = 5 }\nb = [1, 2]\n";
    let sampler = Sampler::new(&Study::parse("x.toml", grid).unwrap(), None).unwrap();
    assert_eq!(probes(&sampler)[0], [4.0, 6.0, 8.0, 10.0, 12.0].map(Value::Real));
    assert_eq!(sampler.drawn_ends(0), None);
    let table = "title = \"x\"\nsystem = \"pd\"\nmethod = \"table\"\npoints = \"p.csv\"\n";
    let points = Points::parse_csv("p.csv", "M,note\n3,a\n1,b\n2,a\n").unwrap();
    let sampler = Sampler::new(&Study::parse("x.toml", table).unwrap(), Some(points)).unwrap();
    let expected = [[3.0, 1.0, 2.0].map(Value::Real), ["a", "b", "a"].map(Value::from)];
    assert_eq!(probes(&sampler), expected);
}

use super::super::{Method, Range, Study};

const GOOD: &str = r#"title = "Two"
system = "nabfc"
controllers = ["nabfc-r", { name = "pds", step = 2e-4 }]
method = "sobol"
draws = 64
outputs = ["u"]

[experiment]
stop = 2

[parameters]
actuator_model = "raw"

[vary]
M = { low = 0.1, high = 10, scale = "log" }
EI = { mean = 0.1, sd = 0.01, names = ["EI1", "EI2"] }
"DualArmPlant.order" = [6, 8]
zone = { low = 0, high = 0.1, names = ["m_r1", "-m_l1"] }
seed = { seed = true }

[success]
settling = 2
overshoot = { min = 0, max = 5 }
"#;

#[test]
fn every_part_is_read() {
    let study = Study::parse("x.toml", GOOD).unwrap();
    assert_eq!((study.method, study.draws, study.seed, study.runs_per_draw()), (Method::Sobol, Some(64), 1, 2));
    assert_eq!(study.entrants[1].step, Some(2e-4));
    let names: Vec<_> = study.vary.iter().map(|varied| varied.name.as_str()).collect();
    assert_eq!(names, ["DualArmPlant.order", "EI", "M", "seed", "zone"]);
    assert_eq!(study.vary[4].targets, [("m_r1".to_owned(), 1.0), ("m_l1".to_owned(), -1.0)]);
    assert_eq!(study.vary[2].range, Range::Logarithmic { low: 0.1, high: 10.0 });
    assert_eq!(study.vary[2].place.to_string(), "x.toml:15");
    assert!(study.success[0].holds(Some(5.0)) && !study.success[0].holds(Some(5.1)) && !study.success[0].holds(None));
}

#[test]
fn mistakes_are_named_with_their_place() {
    for (from, to, expected) in [
        ("draws = 64", "drws = 64", "x.toml:5:1: unknown field `drws`"),
        ("draws = 64", "drws = 64", "did you mean draws?"),
        ("\"sobol\"", "\"sobl\"", "x.toml:4:10: unknown variant `sobl`"),
        ("\"sobol\"", "\"sobl\"", "did you mean sobol?"),
        ("draws = 64\n", "", "x.toml:4:10: draws is missing"),
        ("draws = 64", "draws = 0", "x.toml:5:9: draws must be at least 1"),
        ("\"sobol\"", "\"grid\"", "x.toml:5:9: the values say how many draws there are"),
        ("\"sobol\"\ndraws = 64", "\"grid\"", "x.toml:15:6: EI needs count"),
        ("\"sobol\"\ndraws = 64", "\"table\"", "points is missing"),
        ("low = 0.1, high = 10,", "low = 10, high = 0.1,", "x.toml:15:5: low must be below high"),
        ("low = 0.1, high = 10,", "low = 0, high = 10,", "x.toml:15:5: a range by ratios needs a positive low"),
        ("low = 0.1, high = 10,", "low = 0.1,", "x.toml:15:5: a range needs low and high"),
        ("low = 0.1, high = 10,", "low = 0.1, hgh = 10,", "x.toml:15:18: unknown field `hgh`"),
        ("scale = \"log\"", "scale = \"lineer\"", "did you mean linear?"),
        ("sd = 0.01", "sd = -1", "sd must be a positive number"),
        ("[6, 8]", "[]", "values is empty"),
        ("[6, 8]", "[[6]]", "expected a number, true or false, or a text"),
        ("{ seed = true }", "{ seed = true, low = 1, high = 2 }", "x.toml:19:8: seed = true draws a number by itself"),
        ("names = [\"EI1\", \"EI2\"]", "names = []", "names is empty"),
        ("M = {", "status = {", "x.toml:15:10: status is the name of a column of its own; give it another name"),
        ("\"DualArmPlant.order\" =", "DualArmPlant.order =", "with its quotation marks"),
        ("overshoot = { min = 0, max = 5 }", "overshoot = {}", "overshoot needs a number for min or max"),
        ("system = \"nabfc\"", "system = [\"a.fmu\"]", "write a scenario"),
    ] {
        assert!(GOOD.contains(from), "{from}");
        let message = Study::parse("x.toml", &GOOD.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(message.contains(expected), "{message:?} should contain {expected:?}");
    }
}

//! Whatever a model declares: either a well-formed description that says what was declared, or a list of what is wrong.

use std::cell::RefCell;

use fmi2_export::{Declare, Experiment, Failure, Info, Model, Step, Unit, Variables, describe};
use proptest::prelude::*;
use quick_xml::Reader;
use quick_xml::events::Event;
use serde::{Deserialize, Serialize};

/// What one real parameter is declared as.
#[derive(Clone, Debug)]
struct Declaration {
    name: String,
    description: String,
    unit: Option<(String, f64, f64)>,
    display_unit: Option<(String, f64)>,
    range: Option<(f64, f64)>,
    nominal: Option<f64>,
    start: f64,
    text: String,
}

thread_local! {
    /// `Declare::variables` takes no arguments: the declarations of the model come from here.
    static DECLARED: RefCell<Vec<Declaration>> = const { RefCell::new(Vec::new()) };
}

/// Each declaration becomes a Real and a String.
#[derive(Clone, Serialize, Deserialize)]
struct Declared {
    numbers: Vec<f64>,
    texts: Vec<String>,
}

impl Default for Declared {
    fn default() -> Self {
        DECLARED.with_borrow(|list| Self {
            numbers: list.iter().map(|d| d.start).collect(),
            texts: list.iter().map(|d| d.text.clone()).collect(),
        })
    }
}

impl Declare for Declared {
    const INFO: Info = Info {
        name: "Declared",
        description: "<&\"'> \u{a0}\u{fffd}\u{10ffff}\ttab\nline",
        author: "Dr. \"R\" & <Co>",
        ..Info::new()
    };

    fn variables(variables: &mut Variables<Self>) {
        for (i, declaration) in DECLARED.with_borrow(Clone::clone).iter().enumerate() {
            let Declaration { name, description, unit, display_unit, range, nominal, .. } = declaration;
            let mut builder = variables.parameter(name, move |m| &mut m.numbers[i]).description(description);
            if let Some((name, factor, offset)) = unit {
                builder = builder.other_unit(&Unit::new(name).m(1).factor(*factor).offset(*offset));
            }
            if let Some((name, factor)) = display_unit {
                builder = builder.display_unit(name, *factor);
            }
            if let Some((min, max)) = range {
                builder = builder.range(*min, *max);
            }
            if let Some(nominal) = nominal {
                builder.nominal(*nominal);
            }
            variables.parameter(format!("texts[{i}]"), move |m| &mut m.texts[i]).description(description);
        }
    }
}

impl Model for Declared {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

fn is_text(text: &str) -> bool {
    text.chars().all(|c| (c >= ' ' || "\t\n\r".contains(c)) && c != '\u{fffe}' && c != '\u{ffff}')
}

impl Declaration {
    /// What is legal, in other words than the crate's.
    fn is_legal(&self) -> bool {
        let Self { name, description, unit, display_unit, range, nominal, start, text } = self;
        let factor = |factor: f64| factor.is_normal() || factor.is_subnormal();
        let unit_is_good =
            unit.as_ref().is_none_or(|(name, f, offset)| is_text(name) && factor(*f) && offset.is_finite());
        let display_is_good =
            display_unit.as_ref().is_none_or(|(name, f)| unit.is_some() && is_text(name) && factor(*f));
        let range_is_good = range.is_none_or(|(min, max)| {
            min <= max && min < f64::INFINITY && max > f64::NEG_INFINITY && min <= *start && *start <= max
        });
        let texts = [name, description, text];
        !name.is_empty()
            && !name.contains(|c: char| c.is_control())
            && !description.is_empty()
            && texts.iter().all(|text| is_text(text))
            && unit_is_good
            && display_is_good
            && range_is_good
            && nominal.is_none_or(factor)
            && start.is_finite()
    }
}

/// Mostly what XML has to escape, or can only just hold; seldom what it cannot.
fn text() -> impl Strategy<Value = String> {
    let character = prop_oneof![
        20 => prop::sample::select("aZ9_.[](),;<>&\"'#%{}\\/ \u{a0}é€😀\u{fffd}".chars().collect::<Vec<_>>()),
        1 => prop::sample::select("]]>--?\u{2028}\u{7f}\u{e000}\u{10ffff}".chars().collect::<Vec<_>>()),
        1 => any::<char>(),
    ];
    prop::collection::vec(character, 0..8).prop_map(String::from_iter)
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -2.0..2.0,
        1 => prop::sample::select(vec![0.0, -0.0, f64::MAX, 5e-324, 1e-7, 1e16, 1e22]),
        1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY]),
    ]
}

fn declaration() -> impl Strategy<Value = Declaration> {
    let bounds = (
        prop_oneof![-9.0..-2.0, Just(f64::NEG_INFINITY), number()],
        prop_oneof![2.0..9.0, Just(f64::INFINITY), number()],
    );
    (
        ("[a-z]", text(), text()),
        prop::option::weighted(0.7, (text(), number(), number())),
        prop::option::of((text(), number())),
        prop::option::of(bounds),
        prop::option::of(number()),
        number(),
        text(),
    )
        .prop_map(|((first, name, description), unit, display_unit, range, nominal, start, text)| Declaration {
            name: first + &name,
            description: format!("{description}."),
            unit,
            display_unit,
            range,
            nominal,
            start,
            text,
        })
}

/// Elements of a document: name and attributes, unescaped.
fn elements(xml: &str) -> Vec<(String, Vec<(String, String)>)> {
    let mut reader = Reader::from_str(xml);
    reader.config_mut().check_comments = true;
    let mut elements = Vec::new();
    loop {
        match reader.read_event().expect("well-formed") {
            Event::Eof => return elements,
            Event::Start(element) | Event::Empty(element) => {
                let attributes = element.attributes().map(|attribute| {
                    let attribute = attribute.expect("well-formed, and no attribute twice");
                    let key = attribute.key.as_ref().to_owned();
                    (
                        key,
                        attribute
                            .normalized_value(quick_xml::XmlVersion::Implicit1_0)
                            .expect("well-formed")
                            .into_owned(),
                    )
                });
                elements.push((element.name().as_ref().to_owned(), attributes.collect()));
            }
            _ => {}
        }
    }
}

fn attribute<'e>(element: &'e (String, Vec<(String, String)>), key: &str) -> Option<&'e str> {
    element.1.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_description_is_well_formed_and_says_what_was_declared(list in prop::collection::vec(declaration(), 0..3)) {
        DECLARED.set(list.clone());
        let described = describe::<Declared>();
        // What is defined twice is another matter.
        let twice = |a: &Declaration| list.iter().filter(|b| a.name == b.name).count() > 1;
        let unique = !list.iter().any(twice);
        let unit_names: Vec<&String> = list.iter().filter_map(|d| Some(&d.unit.as_ref()?.0)).collect();
        let one_unit = unit_names.iter().all(|a| unit_names.iter().filter(|b| a == *b).count() == 1);
        prop_assume!(unique && one_unit);
        if list.is_empty() || !list.iter().all(Declaration::is_legal) {
            prop_assert!(described.is_err());
            prop_assert!(!described.unwrap_err().problems.is_empty());
            return Ok(());
        }
        let description = described?;
        let elements = elements(&description.xml);
        let root = &elements[0];
        prop_assert_eq!(attribute(root, "description"), Some(Declared::INFO.description));
        prop_assert_eq!(attribute(root, "author"), Some(Declared::INFO.author));
        prop_assert_eq!(attribute(root, "guid"), Some(description.guid.as_str()));
        let variables: Vec<_> = elements.iter().filter(|e| e.0 == "ScalarVariable").collect();
        let types: Vec<_> = elements.iter().filter(|e| e.0 == "Real" || e.0 == "String").collect();
        prop_assert_eq!((variables.len(), types.len()), (2 * list.len(), 2 * list.len()));
        for (i, d) in list.iter().enumerate() {
            prop_assert_eq!(attribute(variables[2 * i], "name"), Some(d.name.as_str()));
            prop_assert_eq!(attribute(variables[2 * i], "description"), Some(d.description.as_str()));
            let number = |key: &str| attribute(types[2 * i], key).map(|text| text.parse::<f64>().unwrap().to_bits());
            let finite = |value: Option<f64>| value.filter(|v| v.is_finite()).map(f64::to_bits);
            prop_assert_eq!(number("start"), Some(d.start.to_bits()));
            prop_assert_eq!(number("min"), finite(d.range.map(|range| range.0)));
            prop_assert_eq!(number("max"), finite(d.range.map(|range| range.1)));
            prop_assert_eq!(number("nominal"), finite(d.nominal));
            prop_assert_eq!(attribute(types[2 * i], "unit"), d.unit.as_ref().map(|unit| unit.0.as_str()));
            prop_assert_eq!(attribute(types[2 * i], "displayUnit"), d.display_unit.as_ref().map(|unit| unit.0.as_str()));
            prop_assert_eq!(attribute(types[2 * i + 1], "start"), Some(d.text.as_str()));
        }
        for element in &elements {
            for (key, value) in &element.1 {
                let not_a_number = ["inf", "-inf", "NaN"].contains(&value.as_str());
                let texts = ["name", "description", "unit", "displayUnit", "start"];
                prop_assert!(!not_a_number || texts.contains(&key.as_str()), "{key}={value}");
            }
        }
    }

    #[test]
    fn any_text_is_a_unit_or_is_not(expression in "[a-zA-Z0-9./() -]{0,12}|.{0,6}|[mNskg]([0-9-]{0,3})([./][mNskgrad]{1,3}){0,3}") {
        if let Ok(unit) = expression.parse::<Unit>() {
            prop_assert_eq!(unit.name(), expression.as_str());
        }
    }
}

#[test]
fn names_that_are_not_structured_make_the_description_flat() {
    for (name, convention) in [("der(arm[1].'tip mass',2)", "structured"), ("two words", "flat")] {
        DECLARED.set(vec![Declaration {
            name: name.into(),
            description: "x".into(),
            unit: None,
            display_unit: None,
            range: None,
            nominal: None,
            start: 0.0,
            text: String::new(),
        }]);
        let xml = describe::<Declared>().unwrap().xml;
        assert!(xml.contains(&format!("variableNamingConvention=\"{convention}\"")), "{name}");
    }
}

/// An integrator that starts in equilibrium with one of its inputs.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Settled {
    inputs: [f64; 2],
    gain: f64,
    y: f64,
}

impl Declare for Settled {
    const INFO: Info = Info { name: "Settled", description: "Starts in equilibrium", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|_| ());
        variables.output("y", outputs, |m| &mut m.y).depends_on(["b"]).starts_from(["a", "b"]).description("Output");
        variables.input("b", |m| &mut m.inputs[1]).description("Direct feedthrough");
        variables.input("a", |m| &mut m.inputs[0]).description("Only the start depends on it");
        variables.parameter("k", |m| &mut m.gain).description("Gain");
    }
}

impl Model for Settled {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

#[test]
fn initial_unknowns_also_depend_on_what_the_initial_state_follows_from() {
    let xml = describe::<Settled>().unwrap().xml;
    let dependencies: Vec<String> = elements(&xml)
        .iter()
        .filter(|element| element.0 == "Unknown")
        .map(|element| attribute(element, "dependencies").unwrap_or("all").to_owned())
        .collect();
    // At communication points, then in initialization mode: both inputs and the parameter, which are all there are.
    assert_eq!(dependencies, ["2", "all"]);
}

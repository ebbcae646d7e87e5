//! Attributes that are read, and attributes that are refused.

use super::*;

fn read(text: &str) -> Result<Model> {
    model(&syn::parse_str(text).unwrap())
}

#[test]
fn comments_become_descriptions() {
    let model = read(
        "/// A lag of first order:\n/// T der(y) + y = u.\n///\n/// Exact.\n#[model(stop_time = 2)]\nstruct Lag {
            /// Time constant.\n #[parameter(name = \"T\", unit = \"s\", min = 1e-9, start = 0.5)] time_constant: f64,
            /// A text. And another.\n #[input] r#in: [f64; 2],
            x: f64,
        }",
    );
    let model = model.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(model.description, "A lag of first order: T der(y) + y = u");
    let said: Vec<_> = model.fields.iter().map(|f| (f.role, f.name.as_str(), f.description.as_str())).collect();
    assert_eq!(
        said,
        [
            (Role::Parameter, "T", "Time constant"),
            (Role::Input, "in[{}]", "A text. And another."),
            (Role::State, "x", "")
        ]
    );
}

#[test]
fn mistakes_are_named() {
    let field = |text: &str| format!("/// A model\nstruct A {{ /// An input\n #[input] u: f64, {text} }}");
    for (text, message) in [
        ("/// A\nenum A { B }".to_owned(), "a model is a struct: its fields are the variables"),
        ("/// A\nstruct A(f64);".to_owned(), "the fields need names, which the variables take"),
        (
            "/// A\nstruct A<T> { t: T }".to_owned(),
            "a generic model has no one description: implement `Declare` by hand",
        ),
        ("struct A { x: f64 }".to_owned(), "say in a comment (`///`) what the model is"),
        (
            "/// A\n#[model(step = 1)] struct A { x: f64 }".to_owned(),
            "a model takes name, description, copyright, start_time, stop_time, step_size, tolerance, \
             directional_derivatives",
        ),
        (field("#[output] y: f64"), "say in a comment (`///`) what `y` is"),
        (field("/// Y\n#[output] #[input] y: f64"), "`y` is one thing only, and has another attribute already"),
        (
            field("/// K\n#[parameter(units = \"s\")] k: f64"),
            "`#[parameter]` takes start, name, unit, display_degrees, min, max, nominal",
        ),
        (field("#[state(unit = \"s\")] k: f64"), "`#[state]` takes start"),
        (field("/// Y\n#[output(depends_on(v))] y: f64"), "there is no field `v`"),
        (field("/// Y\n#[output(depends_on(u, x))] y: f64, x: f64"), "`x` is no input"),
        (field("/// V\n#[input(ramp = slope)] v: f64"), "there is no field `slope`"),
    ] {
        let error = read(&text).err().unwrap_or_else(|| panic!("{text}"));
        assert_eq!(error.to_string(), message);
    }
    let two = read("/// A\nstruct A { #[input] u: f64, #[output] y: f64 }").err().unwrap();
    assert_eq!(two.into_iter().count(), 2, "all fields' mistakes are told at once");
}

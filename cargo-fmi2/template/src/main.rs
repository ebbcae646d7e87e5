//! Packages the FMU: `cargo fmi2 package`.

use fmi2_package::{Document, Panel, Response};

fn main() -> std::process::ExitCode {
    // The figure in the FMU's documentation: the packaging program runs the model and draws it.
    let heating = Response {
        caption: "The heater is switched on at 100 s and off at 600 s.",
        start: &[],
        inputs: &[("heating_power", |time| if (100.0..600.0).contains(&time) { 100.0 } else { 0.0 })],
        stop_time: 1500.0,
        step_size: 5.0,
        panels: &[
            Panel { title: "Temperature", variables: &["temperature"] },
            Panel { title: "Heat flows", variables: &["heating_power", "heat_loss"] },
        ],
        beside: &[],
    };
    let document = Document {
        model: "MyModel",
        text: include_str!("../documentation/MyModel.md"),
        response: Some(heating),
        // icon: include_bytes!("../documentation/MyModel.png"), license: include_str!("../LICENSE"),
        ..Document::new()
    };
    fmi2_package::main(&my_model::FMUS, &[document])
}

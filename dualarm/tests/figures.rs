//! Every figure of a comparison, from synthetic results: sizes, no text outside the canvas, PNG and SVG alike.
//!
//! To look at them: `DUALARM_FIGURES=<folder> cargo test --release -p dualarm --test figures`

use std::sync::Arc;

use charts::chart::Signals;
use charts::raster;
use charts::text::{missing, width};
use dualarm::grasp;
use dualarm::report::figures::{self, PaperRun};
use dualarm::report::parameters::{ModelParameters, ReportedParameter};
use fmi2_cosim::record::{Column, Sink, Table};
use fmi2_import::Value;
use grasp_merit::metrics::{Limits, Metrics};
use roxmltree::{Document, Node};

/// Second-order responses with the settling times known from the paper, a fast ripple on the force, clipped commands.
fn outcome(scenario: grasp::Controller, pole: f64) -> PaperRun {
    let columns = figures::SIGNALS.iter().map(|name| Column { name: (*name).into(), ..Column::default() }).collect();
    let mut table = Table::new(columns);
    for index in 0..=80_000_u32 {
        let t = f64::from(index) * 1e-4;
        let rise = 1.0 - (1.0 + pole * t) * (-pole * t).exp();
        let ripple = 0.02 * (562.0 * t).sin() * (-9.0 * t).exp();
        let command = 3.0 * (-20.0 * pole * t).exp() + 0.1 * rise;
        let row: Vec<f64> = figures::SIGNALS
            .iter()
            .map(|name| match *name {
                "contact_force1" => 0.5 * rise + ripple,
                "contact_force2" => 0.5 * rise - ripple,
                "theta1" => 3_f64.to_radians() * rise,
                "theta2" => -0.063_581_45 * rise,
                "theta1_d" => 3_f64.to_radians(),
                "theta2_d" => -0.063_581_45,
                "lambda2_d" => 0.5,
                "tau1_cmd" => command,
                "tau2_cmd" => -command,
                "u_cmd" => 0.4 * (-pole * t).exp() + ripple,
                "tau1" => command.min(2.0),
                "tau2" => (-command).max(-2.0),
                "u" => (0.4 * (-pole * t).exp() + ripple).clamp(-0.3, 0.3),
                "W_norm" => 0.0,
                _ => 0.02 * rise,
            })
            .collect();
        table.row(t, &row).unwrap();
    }
    let limit = |high: f64| Some(Limits { low: -high, high });
    let metrics = Metrics::of(&table, [limit(2.0), limit(2.0), limit(0.3)]).unwrap();
    let times = Arc::new(table.times().to_vec());
    #[allow(clippy::cast_possible_truncation)] // pictures are no more precise
    let signal = |name: &&str| {
        let values = table.column(name).unwrap();
        ((*name).to_owned(), values.iter().map(|value| *value as f32).collect(), values.last().copied())
    };
    let signals = Signals::new(times, figures::SIGNALS.iter().map(signal));
    PaperRun { scenario, signals, metrics, models: vec![plant()] }
}

/// The true values that Fig. 6 states.
fn plant() -> ModelParameters {
    let parameter = |(name, value): (&str, f64)| ReportedParameter {
        name: name.into(),
        value: Value::Real(value),
        default: None,
        unit: None,
        description: String::new(),
    };
    let values = [("m1", 0.1), ("m2", 0.1), ("M", 0.3), ("J1", 0.0073), ("J2", 0.0073)];
    ModelParameters { parameters: values.map(parameter).into(), ..ModelParameters::default() }
}

#[test]
fn fig_6_states_the_true_values() {
    let outcomes = [outcome(grasp::NABFC, 15.4)];
    let figures = figures::all(&outcomes);
    let svg = figures.iter().map(|sketch| sketch()).find(|figure| figure.name == "fig06").unwrap().draw().svg;
    assert!(svg.contains("(true: 0.5 kg)") && svg.contains("(true: 0.0073 kg·m²)"));
}

#[test]
fn all_figures_are_whole() {
    let outcomes = [outcome(grasp::NABFC, 15.4), outcome(grasp::PDS, 4.9), outcome(grasp::PD, 1.5)];
    let figures: Vec<_> = figures::all(&outcomes).iter().map(|sketch| sketch()).collect();
    assert_eq!(figures.len(), 21, "Figs. 2 to 18, three overlays and the README's picture");
    for number in 2..=18 {
        assert!(figures.iter().any(|figure| figure.name == format!("fig{number:02}")), "Fig. {number}");
    }
    let folder = std::env::var_os("DUALARM_FIGURES").map(std::path::PathBuf::from);
    for figure in &figures {
        let svg = figure.figure.to_svg();
        assert!(svg.len() < 200_000, "{} has {} bytes", figure.name, svg.len());
        let document = Document::parse(&svg).unwrap();
        for text in document.descendants().filter(|node| node.has_tag_name("text")) {
            assert_inside(&figure.name, text, figure.figure.size);
        }
        if let Some(folder) = &folder {
            fmi2_cosim::files::write(folder.join(format!("{}.svg", figure.name)), &svg).unwrap();
            fmi2_cosim::files::write(folder.join(format!("{}.png", figure.name)), raster::to_png(&svg).unwrap())
                .unwrap();
        }
    }
    assert!(raster::to_png(&figures[0].figure.to_svg()).unwrap().starts_with(b"\x89PNG"));
}

/// A text lies within the canvas, and the font has all its letters.
fn assert_inside(figure: &str, node: Node, (right, bottom): (u32, u32)) {
    const UNITS: f64 = 10.0;
    let text: String = node.descendants().filter(Node::is_text).filter_map(|part| part.text()).collect();
    let text = text.trim();
    let value =
        |name: &str| node.attribute(name).and_then(|value| value.parse::<f64>().ok()).unwrap_or_default() / UNITS;
    let (x, y) = (value("x"), value("y"));
    let length = width(text, value("font-size"), node.attribute("font-weight") == Some("bold"));
    let before = match node.attribute("text-anchor") {
        Some("middle") => length / 2.0,
        Some("end") => length,
        _ => 0.0,
    };
    let inside = if node.attribute("transform").is_some() {
        y - before >= 0.0 && y - before + length <= f64::from(bottom) && x >= 0.0
    } else {
        x - before >= 0.0
            && x - before + length <= f64::from(right)
            && y + value("font-size") <= f64::from(bottom) + 1.0
    };
    assert!(inside, "{figure}: \"{text}\" at ({x}, {y}), {length} px wide, leaves the canvas");
    assert_eq!(missing(text), Vec::<char>::new(), "{figure}: \"{text}\"");
}

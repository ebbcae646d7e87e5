//! The page as a text: hostile names stay names, every part is there. Browsers look at it in `tests/test_report.py`.

use charts::chart::Figure;
use dualarm::report::figures::NamedFigure;
use dualarm::report::html::{Packed, Page, Run};
use dualarm::report::parameters::{ModelParameters, ReportedParameter};
use fmi2_cosim::record::{Column, Sink, Table};
use fmi2_import::Value;
use grasp_merit::metrics::Metrics;

const HOSTILE: &str = "</script><script>alert(1)</script>{{data}}<!--<img src=x onerror='alert(\"2\")'>";

fn html(title: &str, text: &str) -> String {
    let names = ["contact_force1", "contact_force2", "lambda2_d", "tau1", "tau2", "u", "deflection1[1]", text];
    let columns =
        names.iter().map(|name| Column { name: (*name).into(), unit: Some(text.into()), ..Column::default() });
    let mut rows = Table::new(columns.collect());
    for step in 0..=10_u32 {
        rows.row(f64::from(step) * 0.1, &[0.5; 8]).unwrap();
    }
    let parameter = |name: &str, value| ReportedParameter {
        name: name.into(),
        value,
        default: Some(Value::Text(text.into())),
        unit: Some(text.into()),
        description: text.into(),
    };
    let parameters = vec![parameter("l", Value::Real(0.2)), parameter(text, Value::Text(text.into()))];
    let model = ModelParameters { model: text.into(), description: text.into(), parameters };
    let run = Run {
        key: text.into(),
        title: title.into(),
        paper: title.into(),
        metrics: Some(Metrics::of(&rows, [None; 3]).unwrap()),
        rows: Packed::of(&rows, &[]),
        notes: vec![text.into()],
        models: vec![model],
    };
    let runs = [run];
    let figure = Figure { title: text.into(), size: (300, 200), rows: Vec::new() };
    let figures = [NamedFigure { name: "fig02".into(), caption: text.into(), note: text.into(), figure }.draw()];
    let files = vec![(text.into(), text.into())];
    let texts = [(); 4].map(|()| text.to_owned());
    let [title, lead, setup, rows] = texts;
    Page { title, lead, runs: &runs, setup, rows, figures: &figures, files, ..Page::default() }.to_html()
}

#[test]
fn hostile_names_are_only_names() {
    let (tame, hostile) = (html("PD", "x"), html(HOSTILE, HOSTILE));
    // `packed` counts how often the data are in it: a name of the template inside a value is not filled in.
    for markup in ["<script", "</script", "<!--", "<img", "\"packed\""] {
        assert_eq!(hostile.matches(markup).count(), tame.matches(markup).count(), "{markup}");
    }
    assert!(hostile.contains("&lt;img src=x onerror=&#39;alert(&quot;2&quot;)&#39;&gt;"));
}

#[test]
fn nothing_of_the_template_is_left_and_nothing_points_elsewhere() {
    let html = html("PD", "x");
    assert!(html.starts_with("<!doctype html>") && html.trim_end().ends_with("</html>"));
    for name in ["{{style}}", "{{data}}", "{{scripts}}"] {
        assert!(!html.contains(name), "{name}");
    }
    let fetched = ["src=\"", "<link rel=\"stylesheet", "@import", "url(http"];
    for markup in fetched {
        assert!(!html.contains(markup), "{markup}");
    }
    assert!(html.contains("Permission is hereby granted"), "the library's licence comes with it");
}

#[test]
fn numbers_stay_with_their_units() {
    assert!(html("almost 2 s", "x").contains("<td>almost 2\u{a0}s</td>"));
}

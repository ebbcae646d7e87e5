//! The page as a text: hostile names stay names, every part is there. Browsers look at it in `tests/test_report.py`.

use dualarm::grasp::metrics::Metrics;
use dualarm::grasp::{self, Controller};
use dualarm::report::figures::Outcome;
use dualarm::report::html::{self, Page};
use dualarm::report::parameters::{ModelParameters, Parameter};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::record::{Column, Sink, Table};
use fmi2_import::Value;

const HOSTILE: &str = "</script><script>alert(1)</script>{{data}}<!--<img src=x onerror='alert(\"2\")'>";

fn html(title: &'static str, text: &str) -> String {
    let names = ["contact_force1", "contact_force2", "lambda2_d", "tau1", "tau2", "u", "deflection1[1]"];
    assert!(names.iter().all(|name| html::wants(name)));
    let columns = names.iter().map(|name| Column { name: (*name).into(), ..Column::default() }).collect();
    let mut table = Table::new(columns);
    let grid = TimeGrid::new(0.0, 1.0, 0.1).unwrap();
    for step in 0..=grid.steps() {
        table.row(grid.time(step), &[0.5; 7]).unwrap();
    }
    let parameter =
        |name: &str, value| Parameter { name: name.into(), value, unit: Some(text.into()), description: text.into() };
    let parameters = vec![parameter("l", Value::Real(0.2)), parameter(text, Value::Text(text.into()))];
    let model = ModelParameters { model: text.into(), description: text.into(), parameters };
    let mut scenario: Controller = grasp::PD;
    (scenario.title, scenario.paper) = (title, title);
    let outcome = Outcome {
        scenario,
        metrics: Metrics::of(&table, [None; 3]).unwrap(),
        table: table.clone(),
        models: vec![model],
    };
    Page { outcomes: &[outcome], rows: &[table], grid: &grid, setup: text, matrix: None }.to_html()
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

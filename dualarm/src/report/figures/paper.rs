//! The paper's Figs. 2 to 18: for each scenario forces, angles, (estimates,) and control signals.

use super::{NamedFigure, PaperRun, Sketch};
use charts::chart::{Chatter, Curve, Figure, Panel, Signals, Target, chatter, palette};

/// Size of a figure in px.
const SIZE: (u32, u32) = (720, 400);
const TALL: (u32, u32) = (720, 520);

/// A figure of the paper: its number and its content.
struct Entry {
    number: u32,
    scenario: &'static str,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    Force(usize),
    Angle(usize),
    Estimates,
    Torques,
    TipForce,
}

const fn entry(number: u32, scenario: &'static str, kind: Kind) -> Entry {
    Entry { number, scenario, kind }
}

/// The content of each figure of the paper. The paper has no angles for PD.
const ENTRIES: [Entry; 17] = [
    entry(2, "nabfc", Kind::Force(1)),
    entry(3, "nabfc", Kind::Force(2)),
    entry(4, "nabfc", Kind::Angle(1)),
    entry(5, "nabfc", Kind::Angle(2)),
    entry(6, "nabfc", Kind::Estimates),
    entry(7, "nabfc", Kind::Torques),
    entry(8, "nabfc", Kind::TipForce),
    entry(9, "pds", Kind::Force(1)),
    entry(10, "pds", Kind::Force(2)),
    entry(11, "pds", Kind::Angle(1)),
    entry(12, "pds", Kind::Angle(2)),
    entry(13, "pds", Kind::Torques),
    entry(14, "pds", Kind::TipForce),
    entry(15, "pd", Kind::Force(1)),
    entry(16, "pd", Kind::Force(2)),
    entry(17, "pd", Kind::Torques),
    entry(18, "pd", Kind::TipForce),
];

/// Figs. 2 to 18, as far as their scenarios are there.
#[must_use]
pub fn figures(runs: &[PaperRun]) -> Vec<Sketch<'_>> {
    let find = |key| runs.iter().find(|run| run.scenario.key == key);
    let sketch = |entry: &'static Entry| {
        let run = find(entry.scenario)?;
        Some(Box::new(move || entry.figure(run)) as Sketch)
    };
    ENTRIES.iter().filter_map(sketch).collect()
}

impl Entry {
    fn figure(&self, run: &PaperRun) -> NamedFigure {
        let signals = &run.signals;
        let range = window(run);
        let (subject, size, rows) = match self.kind {
            Kind::Force(arm) => (format!("Contact force, arm {arm}"), SIZE, single(force(signals, arm, range))),
            Kind::Angle(arm) => (format!("Hub angle, arm {arm}"), SIZE, single(angle(signals, arm, range))),
            Kind::Estimates => ("Norms of the estimated parameters".into(), TALL, estimates(run, range)),
            Kind::Torques => {
                let rows = vec![control(signals, "tau1", range), control(signals, "tau2", range)];
                ("Torques at the roots".into(), TALL, below_each_other(rows))
            }
            Kind::TipForce => {
                let rows = vec![control(signals, "u", range)];
                ("Force at the end-effectors".into(), SIZE, below_each_other(rows))
            }
        };
        let number = self.number;
        let title = run.scenario.title;
        NamedFigure {
            name: format!("fig{number:02}"),
            caption: format!("Fig. {number} — {subject} ({title})"),
            note: self.kind.note().into(),
            figure: Figure { title: format!("Fig. {number} — {subject} ({title})"), size, rows },
        }
    }
}

impl Kind {
    fn note(self) -> &'static str {
        match self {
            Self::Force(_) => FORCE_NOTE,
            Self::Angle(_) => ANGLE_NOTE,
            Self::Estimates => {
                "The mass and the inertias are adaptive gains of the law, the disturbances bounds that it learns. They stop \
                 where the errors vanish and need not reach the true values, which the panels state; m̂ must stay well below \
                 (docs/controllers.md says why)."
            }
            Self::Torques | Self::TipForce => {
                "Thin: what the actuator puts out; wide: what the controller commands. Where the start kicks, its first \
                 20 ms have a panel of their own, and the other panel cuts them off. Where a signal swings faster than can be \
                 drawn, a band shows how far, and a panel of its own a few swings."
            }
        }
    }
}

pub(super) const FORCE_NOTE: &str = "Horizontal line: the target, shaded: ±2 % of it.";
pub(super) const ANGLE_NOTE: &str = "Horizontal line: the target.";

/// A round time span that shows the settling and some calm after it.
fn window(run: &PaperRun) -> (f64, f64) {
    const ROUND: [f64; 10] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];
    let times = run.signals.times();
    let (start, stop) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(1.0));
    let wanted = run.metrics.settling_2().map_or(f64::INFINITY, |settling| 2.2 * settling);
    let span = ROUND.into_iter().find(|span| *span >= wanted).unwrap_or(f64::INFINITY);
    (start, stop.min(start + span))
}

fn single(panel: Panel) -> Vec<Vec<Panel>> {
    below_each_other(vec![vec![panel]])
}

/// Rows of panels with a labelled time axis only under the last one, unless they differ in their axes.
pub(super) fn below_each_other(mut rows: Vec<Vec<Panel>>) -> Vec<Vec<Panel>> {
    let axes = |row: &[Panel]| row.iter().map(|panel| panel.x_range).collect::<Vec<_>>();
    for index in 0..rows.len() {
        let is_last = rows.get(index + 1).is_none_or(|next| axes(next) != axes(&rows[index]));
        for panel in &mut rows[index] {
            panel.x_label = is_last.then(|| "Time (s)".into());
        }
    }
    rows
}

pub(super) fn force_target(signals: &Signals) -> Vec<Target> {
    let target = signals.last("lambda2_d").map(|value| Target {
        value,
        band: 0.02 * value.abs(),
        labels: vec![format!("target {} N", charts::text::number(value, 1)), "±2 %".into()],
    });
    target.into_iter().collect()
}

pub(super) fn angle_target(signals: &Signals, arm: usize) -> Vec<Target> {
    let target = signals.last(&format!("theta{arm}_d")).map(|radians| Target {
        value: radians.to_degrees(),
        band: 0.0,
        labels: vec![format!("target {}°", charts::text::number(radians.to_degrees(), 2))],
    });
    target.into_iter().collect()
}

pub(super) const SUBSCRIPTS: [&str; 3] = ["", "₁", "₂"];

fn force(signals: &Signals, arm: usize, x_range: (f64, f64)) -> Panel {
    let points = signals.curve(&format!("contact_force{arm}"), 1.0, x_range);
    Panel {
        y_label: format!("Contact force f{} (N)", SUBSCRIPTS[arm]),
        x_range,
        y_include: vec![0.0],
        curves: vec![Curve { name: String::new(), color: palette::BLUE, wide: false, points }],
        targets: force_target(signals),
        ..Panel::default()
    }
}

fn angle(signals: &Signals, arm: usize, x_range: (f64, f64)) -> Panel {
    let points = signals.curve(&format!("theta{arm}"), 1_f64.to_degrees(), x_range);
    Panel {
        y_label: format!("Hub angle θ{} (°)", SUBSCRIPTS[arm]),
        x_range,
        y_include: vec![0.0],
        curves: vec![Curve { name: String::new(), color: palette::BLUE, wide: false, points }],
        targets: angle_target(signals, arm),
        ..Panel::default()
    }
}

/// A control signal: the actuator's output as a thin line, above the controller's command.
fn control(signals: &Signals, signal: &str, x_range: (f64, f64)) -> Vec<Panel> {
    let curve = |name: &str, signal: &str, color, wide| Curve {
        name: name.into(),
        color,
        wide,
        points: signals.curve(signal, 1.0, x_range),
    };
    with_close_up(Panel {
        y_label: control_label(signal),
        x_range,
        y_include: vec![0.0],
        curves: vec![
            curve("actuator output", signal, palette::BLUE, false),
            curve("commanded", &format!("{signal}_cmd"), palette::VERMILION, true),
        ],
        ..Panel::default()
    })
}

/// How long the kick lasts that PD and PDS begin with, in s.
const START: f64 = 0.02;

/// A peak at the start would compress the rest of a control signal. So the start gets a separate panel, and the other panel
/// cuts the peak off.
pub(super) fn with_close_up(panel: Panel) -> Vec<Panel> {
    let start = panel.x_range.0;
    let swings = swings(&panel);
    let mut panels = if panel.span(start) < 5.0 * panel.span(start + START) {
        vec![panel]
    } else {
        let close_up = Panel { x_range: (start, start + START), weight: 0.4, ..panel.clone() };
        // After the peak output and command are equal, and a vibrating upper curve would cover the lower one.
        vec![close_up, Panel { y_label: String::new(), y_from: Some(start + START), first_on_top: true, ..panel }]
    };
    panels.extend(swings);
    panels
}

/// Where a curve chatters its picture is a band; a few of its swings get a panel of their own.
fn swings(panel: &Panel) -> Option<Panel> {
    const SWINGS: f64 = 4.0;
    /// Width of a figure's panel, about.
    const WIDTH: f64 = 400.0;
    let curves = panel.curves.iter().filter(|curve| !curve.wide);
    let chatters = curves.filter_map(|curve| chatter(&curve.points, panel.x_range, WIDTH));
    let Chatter { at, period, .. } = chatters.max_by(|a, b| a.span.total_cmp(&b.span))?;
    let x_range = (at, (at + SWINGS * period).min(panel.x_range.1));
    let zero = Vec::new(); // the axis follows the swings
    Some(Panel { x_range, y_label: String::new(), y_include: zero, weight: 0.4, ..panel.clone() })
}

pub(super) fn control_label(signal: &str) -> String {
    match signal {
        "tau1" => "Torque τ₁ (N·m)".into(),
        "tau2" => "Torque τ₂ (N·m)".into(),
        _ => "Force u (N)".into(),
    }
}

/// Each estimate has its own unit, so each has its own panel; the two arms share a panel, and the object has another
/// colour.
fn estimates(run: &PaperRun, x_range: (f64, f64)) -> Vec<Vec<Panel>> {
    let plant = run.models.first();
    let true_value = |names: &[&str]| names.iter().map(|name| plant?.real(name)).sum::<Option<f64>>();
    let mass = with_truth("mass", true_value(&["m1", "m2", "M"]), "kg");
    let inertias = [true_value(&["J1"]), true_value(&["J2"])];
    // One number for both hubs, where they are alike.
    let inertias = with_truth("hub inertias", inertias[0].filter(|_| inertias[0] == inertias[1]), "kg·m²");
    let panel = |label: &str, signals: &[&str], heading: &str, last: bool| {
        let is_object = signals.len() == 1;
        let colors = if is_object { [palette::PURPLE; 2] } else { [palette::BLUE, palette::VERMILION] };
        let curves = signals.iter().zip(colors).enumerate().map(|(arm, (signal, color))| Curve {
            name: if is_object { "object".into() } else { format!("arm {}", arm + 1) },
            color,
            wide: !is_object && arm == 0, // the second arm's may lie on it
            points: run.signals.curve(signal, 1.0, x_range).magnitudes(),
        });
        Panel {
            heading: Some(heading.into()),
            x_label: last.then(|| "Time (s)".into()),
            y_label: label.into(),
            x_range,
            y_include: vec![0.0],
            curves: curves.collect(),
            ..Panel::default()
        }
    };
    vec![
        vec![
            panel("|m̂| (kg)", &["m_hat"], &mass, false),
            panel("|Ĵ| (kg·m²)", &["J1_hat", "J2_hat"], &inertias, false),
        ],
        vec![
            panel("|ε̂| (N)", &["epsilon_hat"], "disturbance, object", false),
            panel("|π̂| (N·m)", &["pi1_hat", "pi2_hat"], "disturbance, hubs", false),
        ],
        vec![
            panel("‖Ŵ‖", &["W_norm"], "network, object", true),
            panel("‖Û‖", &["U1_norm", "U2_norm"], "networks, hubs", true),
        ],
    ]
}

/// A heading that states the true value, which is often far outside the curve's axis.
fn with_truth(heading: &str, value: Option<f64>, unit: &str) -> String {
    // Sums such as 0.1 + 0.1 + 0.3 have digits that only rounding puts there.
    value.map_or(heading.into(), |value| format!("{heading} (true: {} {unit})", (value * 1e9).round() / 1e9))
}

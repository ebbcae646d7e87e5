//! The three controllers in one picture: forces, angles, control signals, and the picture of the README.

use super::paper::{
    ANGLE_NOTE, FORCE_NOTE, SUBSCRIPTS, angle_target, below_each_other, control_label, force_target, with_close_up,
};
use super::{NamedFigure, PaperRun, Sketch};
use charts::chart::{Curve, Figure, Mark, Panel, RGBColor, Target, palette};
use charts::text::number;

/// File name of the README's picture.
pub const HERO: &str = "grasp";

/// The overlays; empty without runs.
#[must_use]
pub fn figures(runs: &[PaperRun]) -> Vec<Sketch<'_>> {
    if runs.is_empty() {
        return Vec::new();
    }
    [hero, forces, angles, controls].map(|make| Box::new(move || make(runs)) as Sketch).into()
}

fn color(index: usize) -> RGBColor {
    palette::ALL[index % palette::ALL.len()]
}

/// One curve per controller.
fn curves(runs: &[PaperRun], signal: &str, scale: f64) -> Vec<Curve> {
    runs.iter()
        .enumerate()
        .map(|(index, run)| Curve {
            name: run.scenario.title.into(),
            color: color(index),
            wide: false,
            points: run.signals.curve(signal, scale, x_range(runs)),
        })
        .collect()
}

/// The time span that all runs cover, but at most half of it after everything is settled.
fn x_range(runs: &[PaperRun]) -> (f64, f64) {
    let bound = |time: Option<&f64>| time.copied().unwrap_or(0.0);
    let start = runs.iter().map(|run| bound(run.signals.times().first())).fold(f64::INFINITY, f64::min);
    let stop = runs.iter().map(|run| bound(run.signals.times().last())).fold(0.0, f64::max);
    let settled = runs.iter().map(|run| run.metrics.settling_2().unwrap_or(f64::INFINITY)).fold(0.0, f64::max);
    (start, stop.min(start + (1.25 * settled).ceil()))
}

/// The contact forces of both arms side by side, with the moment each controller has settled.
fn hero(runs: &[PaperRun]) -> NamedFigure {
    let panel = |arm: usize| {
        let signals = &runs[0].signals;
        let target = force_target(signals).into_iter().map(|target| {
            // Only the right panel has room for labels.
            let labels = if arm == 2 { target.labels } else { Vec::new() };
            Target { labels, ..target }
        });
        let marks = runs.iter().enumerate().filter_map(|(index, run)| {
            let force = &run.metrics.forces[arm - 1];
            let settling = force.settling_2?;
            let start = run.signals.times()[0];
            let values = run.signals.curve(&format!("contact_force{arm}"), 1.0, (start + settling, f64::INFINITY));
            Some(Mark {
                point: values.first()?,
                color: color(index),
                name: run.scenario.title.into(),
                text: format!("{} s", number(settling, 2)),
            })
        });
        Panel {
            heading: Some(format!("Arm {arm}")),
            x_label: Some("Time (s)".into()),
            y_label: format!("Contact force f{} (N)", SUBSCRIPTS[arm]),
            x_range: x_range(runs),
            y_include: vec![0.0, 1.3 * runs[0].metrics.forces[arm - 1].target],
            first_on_top: true,
            curves: curves(runs, &format!("contact_force{arm}"), 1.0),
            targets: target.collect(),
            marks: marks.collect(),
            ..Panel::default()
        }
    };
    let caption = "Contact forces of both arms and the time each controller needs to stay within ±2 % of the target";
    NamedFigure {
        name: HERO.into(),
        caption: caption.into(),
        note: FORCE_NOTE.into(),
        figure: Figure {
            title: "Contact force without a force sensor: time until it stays within ±2 % of the target".into(),
            size: (1200, 440),
            rows: vec![vec![panel(1), panel(2)]],
        },
    }
}

fn forces(runs: &[PaperRun]) -> NamedFigure {
    let panel = |arm: usize| Panel {
        y_label: format!("Contact force f{} (N)", SUBSCRIPTS[arm]),
        x_range: x_range(runs),
        y_include: vec![0.0],
        first_on_top: true,
        curves: curves(runs, &format!("contact_force{arm}"), 1.0),
        targets: force_target(&runs[0].signals),
        ..Panel::default()
    };
    stacked("overlay-forces", "Contact forces", vec![vec![panel(1)], vec![panel(2)]], 560, FORCE_NOTE)
}

fn angles(runs: &[PaperRun]) -> NamedFigure {
    let panel = |arm: usize| Panel {
        y_label: format!("Hub angle θ{} (°)", SUBSCRIPTS[arm]),
        x_range: x_range(runs),
        y_include: vec![0.0],
        first_on_top: true,
        curves: curves(runs, &format!("theta{arm}"), 1_f64.to_degrees()),
        targets: angle_target(&runs[0].signals, arm),
        ..Panel::default()
    };
    stacked("overlay-angles", "Hub angles", vec![vec![panel(1)], vec![panel(2)]], 560, ANGLE_NOTE)
}

fn controls(runs: &[PaperRun]) -> NamedFigure {
    let row = |signal: &str| {
        with_close_up(Panel {
            y_label: control_label(signal),
            x_range: x_range(runs),
            y_include: vec![0.0],
            first_on_top: true,
            curves: curves(runs, signal, 1.0),
            ..Panel::default()
        })
    };
    let rows = ["tau1", "tau2", "u"].map(row).into();
    let note = "Where the start kicks, its first 20 ms have a panel of their own, and the other panel cuts them off. Where a \
                signal swings faster than can be drawn, a band shows how far, and a panel of its own a few swings.";
    stacked("overlay-controls", "Control signals, actuator outputs", rows, 700, note)
}

fn stacked(name: &str, subject: &str, rows: Vec<Vec<Panel>>, height: u32, note: &str) -> NamedFigure {
    NamedFigure {
        name: name.into(),
        caption: format!("{subject} of the three controllers"),
        note: note.into(),
        figure: Figure {
            title: format!("{subject} — three controllers"),
            size: (720, height),
            rows: below_each_other(rows),
        },
    }
}

//! The maps' figures as SVG: coloured cells over step and gain, and points of the s-plane.

use std::fmt::Write;

use crate::report::html::escape;
use charts::chart::palette;
use charts::text::{FAMILIES, number, with_shifts};

const INK: &str = "#22262E";
const SOFT: &str = "#5B6370";
const UNSTABLE: &str = "#D55E00";

/// One panel of cells.
pub struct Cells {
    pub heading: String,
    /// Rate at which amplitudes grow by column, then by row from below \[1/s\]; infinite where they do.
    pub values: Vec<Vec<f64>>,
}

/// Points of the s-plane with their name.
pub struct Plane {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

fn begin(width: f64, height: f64, title: &str) -> String {
    let title = escape(title);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"{FAMILIES}\" fill=\"{INK}\" role=\"img\">\n<title>{title}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"18\" y=\"27\" font-size=\"15\" font-weight=\"bold\">{title}</text>\n"
    )
}

fn label(svg: &mut String, (x, y): (f64, f64), anchor: &str, fill: &str, text: &str) {
    let text = escape(text);
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"11.5\" text-anchor=\"{anchor}\" fill=\"{fill}\">{text}</text>"
    );
}

/// From hardly damped to well damped.
fn shade(rate: f64) -> String {
    if rate.is_infinite() {
        return UNSTABLE.to_owned();
    }
    // A hundredth of 1/s is white, 10 1/s is blue.
    let depth = (8.0 * ((-rate).max(1e-3).log10() + 2.0) / 3.0).round() / 8.0;
    let mix = |white: f64, blue: f64| white + depth.clamp(0.0, 1.0) * (blue - white);
    format!("rgb({:.0},{:.0},{:.0})", mix(240.0, 0.0), mix(246.0, 114.0), mix(250.0, 178.0))
}

/// Panels side by side, `columns` in a row, over the same steps \[s\] and gain factors, both spaced by ratios.
pub fn cells(panels: &[Cells], columns: usize, steps: &[f64], factors: &[f64]) -> String {
    const PLOT: (f64, f64) = (250.0, 150.0);
    const GAP: (f64, f64) = (52.0, 56.0);
    let rows = panels.len().div_ceil(columns);
    let width = 30.0 + columns as f64 * (PLOT.0 + GAP.0);
    let height = 66.0 + rows as f64 * (PLOT.1 + GAP.1) + 20.0;
    let mut svg = begin(width, height, "Which sampled loops are stable: step, delay and gains");
    let (nx, ny) = (steps.len() as f64, factors.len() as f64);
    let place = |value: f64, range: &[f64]| (value / range[0]).ln() / (range[range.len() - 1] / range[0]).ln();
    for (index, panel) in panels.iter().enumerate() {
        let left = 56.0 + (index % columns) as f64 * (PLOT.0 + GAP.0);
        let top = 66.0 + (index / columns) as f64 * (PLOT.1 + GAP.1);
        let _ = writeln!(
            svg,
            "<text x=\"{left}\" y=\"{}\" font-size=\"12.5\" font-weight=\"bold\">{}</text>",
            top - 7.0,
            escape(&panel.heading)
        );
        for (i, column) in panel.values.iter().enumerate() {
            let mut from = 0;
            // Neighbours of one colour are one rectangle.
            for run in column.chunk_by(|a, b| shade(*a) == shade(*b)) {
                let to = from + run.len();
                let (x, y) = (left + PLOT.0 * i as f64 / nx, top + PLOT.1 * (1.0 - to as f64 / ny));
                let _ = writeln!(
                    svg,
                    "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>",
                    PLOT.0 / nx + 0.3,
                    PLOT.1 * run.len() as f64 / ny + 0.3,
                    shade(run[0])
                );
                from = to;
            }
        }
        for step in [5e-5, 2e-4, 1e-3, 5e-3] {
            let x = left + PLOT.0 * ((nx - 1.0) * place(step, steps) + 0.5) / nx;
            label(&mut svg, (x, top + PLOT.1 + 15.0), "middle", SOFT, &format!("{}", 1e3 * step));
        }
        for factor in [0.1, 1.0, 10.0] {
            let y = top + PLOT.1 * (1.0 - ((ny - 1.0) * place(factor, factors) + 0.5) / ny);
            label(&mut svg, (left - 6.0, y + 4.0), "end", SOFT, &format!("{factor}"));
        }
        label(&mut svg, (left + 0.5 * PLOT.0, top + PLOT.1 + 30.0), "middle", INK, "Step (ms)");
        let (x, y) = (left - 36.0, top + 0.5 * PLOT.1);
        let _ = writeln!(
            svg,
            "<text font-size=\"11.5\" text-anchor=\"middle\" transform=\"translate({x:.1} {y:.1}) rotate(-90)\">Gains ×</text>"
        );
    }
    let note = "Orange: unstable. Blue: amplitudes fall, the darker the faster (0.01 to 10 1/s and above).";
    label(&mut svg, (18.0, height - 10.0), "start", SOFT, note);
    with_shifts(&(svg + "</svg>\n"))
}

/// Eigenvalues of several loops in a region (left, right, bottom, top) \[1/s\].
pub fn plane(sets: &[Plane], [left, right, bottom, top]: [f64; 4]) -> String {
    let (width, height) = (760.0, 520.0);
    let (x0, x1, y0, y1) = (64.0, width - 20.0, height - 48.0, 84.0);
    let mut svg = begin(width, height, "Exact eigenvalues, counted by the argument principle");
    let at = |re: f64, im: f64| {
        (x0 + (re - left) / (right - left) * (x1 - x0), y0 - (im - bottom) / (top - bottom) * (y0 - y1))
    };
    for re in [-120.0, -90.0, -60.0, -30.0, 0.0] {
        let (x, _) = at(re, 0.0);
        let color = if re == 0.0 { SOFT } else { "#E6E9EE" };
        let _ = writeln!(svg, "<path d=\"M{x:.1} {y0:.1}V{y1:.1}\" stroke=\"{color}\"/>");
        label(&mut svg, (x, y0 + 17.0), "middle", SOFT, &number(re, 0));
    }
    for im in [0.0, 500.0, 1000.0, 1500.0, 2000.0] {
        let (_, y) = at(0.0, im);
        let _ = writeln!(svg, "<path d=\"M{x0:.1} {y:.1}H{x1:.1}\" stroke=\"#E6E9EE\"/>");
        label(&mut svg, (x0 - 7.0, y + 4.0), "end", SOFT, &number(im, 0));
    }
    label(&mut svg, (0.5 * (x0 + x1), height - 12.0), "middle", INK, "Real part (1/s)");
    let _ = writeln!(
        svg,
        "<text font-size=\"11.5\" text-anchor=\"middle\" transform=\"translate(16 {}) rotate(-90)\">Imaginary part (1/s)</text>",
        0.5 * (y0 + y1)
    );
    let mut x = 18.0;
    for (set, color) in sets.iter().zip(palette::ALL) {
        let fill = format!("rgb({},{},{})", color.0, color.1, color.2);
        let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"54\" r=\"5\" fill=\"{fill}\"/>");
        label(&mut svg, (x + 11.0, 58.0), "start", INK, &set.name);
        x += 34.0 + 6.2 * set.name.chars().count() as f64;
        for (re, im) in &set.points {
            let (x, y) = at(*re, *im);
            let _ =
                writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{fill}\" fill-opacity=\"0.75\"/>");
        }
    }
    with_shifts(&(svg + "</svg>\n"))
}

//! Tables, figures and data in the folder of the results.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::{ComparisonError, Progress, Runs, parallel};
use crate::grasp::matrix::{Matrices, Matrix};
use crate::report;
use crate::report::figures::{Drawn, Sketch};
use charts::{pdf, raster};
use fmi2_cosim::files::FileSet;

/// The results of the paper's runs as text.
pub(super) fn write(
    out: &Path,
    Runs { runs, figures, .. }: &Runs,
    setup: &str,
    matrix: Option<&Matrices>,
    results: &FileSet,
) -> Result<(), ComparisonError> {
    let metrics = runs.iter().map(|run| (run.scenario.title, &run.metrics));
    results.write(out.join("metrics.csv"), report::metrics_csv(metrics))?;
    results.write(out.join("metrics.md"), report::metrics_markdown(runs))?;
    results.write(out.join("report.md"), report::report(runs, figures, setup, matrix))?;
    Ok(())
}

/// The matrices as tables, data and figures.
///
/// # Errors
/// When a figure cannot be drawn or a file cannot be written.
pub fn write_matrices(matrices: &Matrices, out: &Path, results: &FileSet) -> Result<(), ComparisonError> {
    write_matrix("matrix", &matrices.closed, out, results)?;
    matrices.contact.as_ref().map_or(Ok(()), |matrix| write_matrix("contact", matrix, out, results))
}

fn write_matrix(name: &str, matrix: &Matrix, out: &Path, results: &FileSet) -> Result<(), ComparisonError> {
    let failure = |reason: String| ComparisonError::Draw { name: name.into(), reason };
    let svg = report::matrix::figure::svg(matrix, true);
    let png = raster::to_png(&svg).map_err(failure)?;
    let json = serde_json::to_string_pretty(&report::matrix::documents(matrix)).map_err(|e| failure(e.to_string()))?;
    results.write(out.join(format!("{name}.csv")), report::matrix::csv(matrix))?;
    results.write(out.join(format!("{name}.md")), report::matrix::markdown(matrix))?;
    results.write(out.join(format!("{name}.json")), json + "\n")?;
    results.write(out.join(format!("{name}.svg")), svg)?;
    results.write(out.join(format!("{name}.png")), png)?;
    Ok(())
}

/// Draws all figures as SVG and PNG, on all processors; `untitled` ones as SVG and PDF.
pub(super) fn draw_all(
    folder: &Path,
    sketches: &[Sketch],
    untitled: bool,
    results: &FileSet,
    progress: &impl Progress,
) -> Result<Vec<Drawn>, ComparisonError> {
    let done = progress.begins("figures", sketches.len() as u64);
    let count = AtomicUsize::new(0);
    parallel::each(sketches.len(), |index| {
        let drawn = draw(folder, &sketches[index], untitled, results)?;
        done(count.fetch_add(1, Ordering::Relaxed) as u64 + 1);
        Ok(drawn)
    })
}

fn draw(folder: &Path, sketch: &Sketch, untitled: bool, results: &FileSet) -> Result<Drawn, ComparisonError> {
    let figure = sketch();
    let failure = |reason| ComparisonError::Draw { name: figure.name.clone(), reason };
    if untitled {
        let svg = figure.figure.to_untitled_svg();
        let pdf = pdf::to_pdf(&svg).map_err(failure)?;
        let folder = folder.join("untitled");
        results.write(folder.join(format!("{}.svg", figure.name)), svg)?;
        results.write(folder.join(format!("{}.pdf", figure.name)), pdf)?;
    }
    let drawn = figure.draw();
    let failure = |reason| ComparisonError::Draw { name: drawn.name.clone(), reason };
    let png = raster::to_png(&drawn.svg).map_err(failure)?;
    results.write(folder.join(format!("{}.svg", drawn.name)), &drawn.svg)?;
    results.write(folder.join(format!("{}.png", drawn.name)), png)?;
    Ok(drawn)
}

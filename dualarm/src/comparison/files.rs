//! Tables, figures and data in the folder of the results.

use std::num::NonZero;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::{ComparisonError, Progress, Runs};
use crate::grasp::matrix::{Matrices, Matrix};
use crate::report;
use crate::report::figures::{NamedFigure, pdf, raster};
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
    figures: &[NamedFigure],
    untitled: bool,
    results: &FileSet,
    progress: &impl Progress,
) -> Result<(), ComparisonError> {
    let done = progress.begins("figures", figures.len() as u64);
    let next = AtomicUsize::new(0);
    let drawn = AtomicUsize::new(0);
    let failure = Mutex::new(None);
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, NonZero::get) {
            scope.spawn(|| {
                while let Some(figure) = figures.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let Err(error) = draw(folder, figure, untitled, results) {
                        failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error);
                        return;
                    }
                    done(drawn.fetch_add(1, Ordering::Relaxed) as u64 + 1);
                }
            });
        }
    });
    failure.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).map_or(Ok(()), Err)
}

fn draw(folder: &Path, figure: &NamedFigure, untitled: bool, results: &FileSet) -> Result<(), ComparisonError> {
    let failure = |reason| ComparisonError::Draw { name: figure.name.clone(), reason };
    let svg = figure.figure.to_svg();
    let png = raster::to_png(&svg).map_err(failure)?;
    results.write(folder.join(format!("{}.svg", figure.name)), svg)?;
    results.write(folder.join(format!("{}.png", figure.name)), png)?;
    if untitled {
        let svg = figure.figure.to_untitled_svg();
        let pdf = pdf::to_pdf(&svg).map_err(failure)?;
        let folder = folder.join("untitled");
        results.write(folder.join(format!("{}.svg", figure.name)), svg)?;
        results.write(folder.join(format!("{}.pdf", figure.name)), pdf)?;
    }
    Ok(())
}

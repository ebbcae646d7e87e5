//! The FMUs' icons: where their drawings are, and how a drawing becomes a PNG.

use std::error::Error;
use std::path::{Path, PathBuf};

use charts::raster::to_png;

/// The drawings of all model crates below the repository's root, one for each FMU.
pub fn sources(root: &Path) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut sources = Vec::new();
    for model in dualarm::build::MODELS {
        for entry in std::fs::read_dir(root.join(model).join("documentation"))? {
            sources.push(entry?.path());
        }
    }
    sources.retain(|path| path.extension().is_some_and(|extension| extension == "svg"));
    sources.sort();
    Ok(sources)
}

/// A drawing as PNG.
pub fn draw(svg: &Path) -> Result<Vec<u8>, Box<dyn Error>> {
    Ok(to_png(&std::fs::read_to_string(svg)?)?)
}

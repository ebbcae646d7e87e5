//! Draws the FMUs' icons, `model.png`, from the SVG files beside them:
//!
//! ```sh
//! cargo run --release -p dualarm --example icons
//! ```
//!
//! The packaging programs take the PNG files as they are, so that packaging needs no renderer; a test holds them to the SVG.

use std::error::Error;
use std::path::Path;

#[path = "../tests/support/icons.rs"]
mod icons;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for svg in icons::sources(&root)? {
        let png = svg.with_extension("png");
        std::fs::write(&png, icons::draw(&svg)?)?;
        println!("{}", png.display());
    }
    Ok(())
}

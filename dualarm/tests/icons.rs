//! The icons in the FMUs are those that the drawings give.

use std::path::Path;

#[path = "support/icons.rs"]
mod icons;

#[test]
fn icons_are_drawn_from_their_sources() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let sources = icons::sources(&root).unwrap();
    assert_eq!(sources.len(), 6, "an icon for each FMU");
    for svg in sources {
        let png = std::fs::read(svg.with_extension("png")).unwrap_or_default();
        let drawn = icons::draw(&svg).unwrap();
        assert!(png == drawn, "{}: run `cargo run --release -p dualarm --example icons`", svg.display());
        // The header: width and height in px. Tools show icons at 100 to 300 px.
        let size = [16, 20].map(|at| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()));
        assert_eq!(size, [300, 300]);
        assert!(png.len() < 30_000, "{} bytes", png.len());
    }
}

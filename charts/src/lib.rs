//! Curves for the eye: [`chart`] draws them as SVG, [`raster`] makes pixels of that and [`pdf`] a page, with the letters of
//! [`text`]; [`pack`] hands whole columns to a page's scripts.
//!
//! Nothing here knows what the curves are of. It is a crate of its own because it looks at every point of them: the tool
//! around it, which does so little that it is compiled without optimisation, would take a second longer for a comparison.

#![forbid(unsafe_code)]

mod cells;
pub mod chart;
mod deflate;
mod direct;
mod flat;
mod indexed;
mod letters;
pub mod pack;
pub mod pdf;
mod picture;
pub mod raster;
mod stroke;
pub mod text;

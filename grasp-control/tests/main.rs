//! All tests but the requirements in one program: compiled apart, each of them would contain what it needs of plant and linear
//! algebra again.

mod closed_loop;
mod common;
mod continuous;
mod continuous_jacobians;
mod continuous_loop;
mod derivatives;
mod equations;
mod presets;
mod robustness;
mod sampling;
mod stateful_laws;

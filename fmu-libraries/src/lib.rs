//! No code: the shared libraries of the FMUs are this package's examples, one for each crate of models. `dualarm package`
//! builds them.

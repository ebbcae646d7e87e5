//! What a step of the FMUs costs: `cargo bench -p benchmarks` times it, `examples/step_cost.rs` counts its instructions and times it
//! beside the same algorithms in C (`benches/peer/peer.c`). The library itself is empty.

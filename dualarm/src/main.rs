//! The `dualarm` command; see `dualarm --help`.

/// A run is so short that it would spend a tenth of its time on fetching memory.
#[cfg(target_os = "linux")]
#[global_allocator]
static HEAP: large_blocks::LargeBlocks = large_blocks::LargeBlocks::new();

fn main() -> std::process::ExitCode {
    dualarm::cli::main()
}

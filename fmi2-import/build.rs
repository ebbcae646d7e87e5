//! Compiles the C half of the logger callback.

fn main() {
    println!("cargo::rerun-if-changed=csrc/callbacks.c");
    cc::Build::new().file("csrc/callbacks.c").warnings(true).compile("fmi2_import_callbacks");
}

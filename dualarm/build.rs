//! On Linux the program is linked to fixed addresses.
//!
//! A program that may be loaded anywhere has 75 000 addresses of its own code and data to fill in before it begins, more than a
//! millisecond, and as many pages of memory of its own, which the second process would copy. What is random about the addresses of
//! libraries, heap and stack stays so. Other platforms demand programs that can be moved.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let of_target = |what: &str| std::env::var(format!("CARGO_CFG_TARGET_{what}")).unwrap_or_default();
    if of_target("OS") == "linux" && of_target("ENV") == "gnu" {
        println!("cargo::rustc-link-arg-bins=-no-pie");
    }
}

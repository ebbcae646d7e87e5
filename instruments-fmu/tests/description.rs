//! The checked-in descriptions are those of the code.

use std::path::Path;

#[test]
fn checked_in_descriptions_are_current() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../modelDescription");
    let outdated = instruments_fmu::FMUS.outdated(&folder).unwrap();
    assert!(outdated.is_empty(), "{outdated:?} changed: run `cargo xtask describe` and look at the difference");
}

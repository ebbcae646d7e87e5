//! Names of a new crate and its model. Names that would only fail later, with an error of the compiler or of cargo about
//! something else, are refused here.

/// Keywords of Rust 2024, those reserved for the future among them.
const KEYWORDS: [&str; 52] = [
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do", "dyn", "else",
    "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop", "macro", "match", "mod",
    "move", "mut", "override", "priv", "pub", "ref", "return", "self", "static", "struct", "super", "trait", "true",
    "try", "type", "typeof", "unsafe", "unsized", "use", "virtual", "where", "while", "yield", "_",
];
/// Crates that come with Rust.
const SYSROOT: [&str; 6] = ["alloc", "core", "proc-macro", "std", "test", "rustc-std-workspace-core"];
const PRIMITIVES: [&str; 20] = [
    "bool", "char", "f128", "f16", "f32", "f64", "i128", "i16", "i32", "i64", "i8", "isize", "never", "str", "u128",
    "u16", "u32", "u64", "u8", "usize",
];
/// Folders of the build directory: cargo refuses programs of these names.
const BUILD_FOLDERS: [&str; 4] = ["build", "deps", "examples", "incremental"];
/// Names of devices on Windows, where no file can have them.
const DEVICES: [&str; 22] = [
    "aux", "com1", "com2", "com3", "com4", "com5", "com6", "com7", "com8", "com9", "con", "lpt1", "lpt2", "lpt3",
    "lpt4", "lpt5", "lpt6", "lpt7", "lpt8", "lpt9", "nul", "prn",
];
/// Types, traits and variants that every Rust file sees without a `use`.
const PRELUDE: [&str; 41] = [
    "AsMut",
    "AsRef",
    "AsyncFn",
    "AsyncFnMut",
    "AsyncFnOnce",
    "Box",
    "Clone",
    "Copy",
    "Debug",
    "Default",
    "DoubleEndedIterator",
    "Drop",
    "Eq",
    "Err",
    "ExactSizeIterator",
    "Extend",
    "Fn",
    "FnMut",
    "FnOnce",
    "From",
    "FromIterator",
    "Future",
    "Hash",
    "Into",
    "IntoFuture",
    "IntoIterator",
    "Iterator",
    "None",
    "Ok",
    "Option",
    "Ord",
    "PartialEq",
    "PartialOrd",
    "Result",
    "Send",
    "Sized",
    "Some",
    "String",
    "Sync",
    "ToOwned",
    "ToString",
];
const MORE_PRELUDE: [&str; 4] = ["TryFrom", "TryInto", "Unpin", "Vec"];

/// The longest name that registries take.
const LONGEST: usize = 64;

/// Whether a crate can be called so; if not, why. `dependencies` are the crates that it needs itself.
pub fn check_package(name: &str, dependencies: &[&str]) -> Result<(), String> {
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) || !name.chars().all(is_word) || name.ends_with('-') {
        return Err(format!(
            "the new folder's name becomes the crate's: small letters, digits and -, as in dc-motor, not {name:?}"
        ));
    }
    let taken = |what: &str| Err(format!("a crate cannot be called {name}: {what}; say e.g. {name}-model"));
    if name.len() > LONGEST {
        return Err(format!(
            "the new folder's name becomes the crate's: at most {LONGEST} letters, not {}",
            name.len()
        ));
    }
    if KEYWORDS.contains(&name.replace('-', "_").as_str()) {
        return taken("that is a keyword of Rust");
    }
    if SYSROOT.contains(&name) {
        return taken("that is a crate which comes with Rust");
    }
    if PRIMITIVES.contains(&name) {
        return taken("that is a type of Rust");
    }
    if dependencies.iter().any(|dependency| dependency.replace('_', "-") == name) {
        return taken("that is a crate which the model needs");
    }
    if BUILD_FOLDERS.contains(&name) {
        return taken("cargo has a folder of that name where it puts programs");
    }
    if DEVICES.contains(&name) {
        return taken("that is a device on Windows, where no file can be called so");
    }
    Ok(())
}

/// The model's name for a crate's: `dc-motor` becomes `DcMotor`. Refused if the name has another meaning in `source`, the
/// Rust file of the model.
pub fn model(package: &str, source: &str) -> Result<String, String> {
    let capitalised = |word: &str| word[..1].to_ascii_uppercase() + &word[1..];
    let model: String = package.split('-').filter(|word| !word.is_empty()).map(capitalised).collect();
    let used = PRELUDE.contains(&model.as_str()) || MORE_PRELUDE.contains(&model.as_str());
    if used || types(source).any(|name| name == model) {
        return Err(format!(
            "a crate called {package} has a model {model}, which is another thing in Rust or in the new crate; say e.g. \
             {package}-model"
        ));
    }
    Ok(model)
}

/// Names in a Rust file that begin with a capital letter, besides those in comments and strings.
fn types(source: &str) -> impl Iterator<Item = &str> {
    let code = source.lines().filter_map(|line| line.split("//").next());
    let outside_strings = code.flat_map(|line| line.split('"').step_by(2));
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words = outside_strings.flat_map(move |code| code.split(move |c| !is_part(c)));
    words.filter(|word| word.starts_with(|c: char| c.is_ascii_uppercase()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEPENDENCIES: [&str; 2] = ["serde", "fmi2-export"];

    #[test]
    fn names_that_work() {
        for (package, name) in [
            ("dc-motor", "DcMotor"),
            ("dc--motor-2", "DcMotor2"),
            ("looping", "Looping"),
            ("x", "X"),
            ("union", "Union"),
        ] {
            check_package(package, &DEPENDENCIES).unwrap();
            assert_eq!(model(package, "struct Other;").unwrap(), name);
        }
    }

    #[test]
    fn names_that_cannot_work_are_refused_with_the_reason() {
        for (wrong, reason) in [
            ("DcMotor", "small letters"),
            ("2nd", "small letters"),
            ("dc_motor", "small letters"),
            ("dc motor", "small letters"),
            ("größe", "small letters"),
            ("dc-", "small letters"),
            ("", "small letters"),
            ("loop", "keyword"),
            ("fn", "keyword"),
            ("gen", "keyword"),
            ("std", "comes with Rust"),
            ("proc-macro", "comes with Rust"),
            ("test", "comes with Rust"),
            ("f64", "type of Rust"),
            ("serde", "the model needs"),
            ("fmi2-export", "the model needs"),
            ("deps", "cargo has a folder"),
            ("com1", "Windows"),
            (&"a".repeat(65), "at most 64"),
        ] {
            let message = check_package(wrong, &DEPENDENCIES).unwrap_err();
            assert!(message.contains(reason), "{message}");
        }
    }

    #[test]
    fn a_models_name_means_nothing_else() {
        let source = "use x::{Step, Info}; // a Comment\nconst TEXT: &str = \"a String\";";
        for taken in ["step", "info", "default", "option", "vec", "to-string"] {
            assert!(model(taken, source).unwrap_err().contains(&format!("{taken}-model")), "{taken}");
        }
        assert_eq!(model("comment", source).unwrap(), "Comment");
    }

    #[test]
    fn lists_are_in_order() {
        for list in [&KEYWORDS[..51], &PRIMITIVES, &BUILD_FOLDERS, &DEVICES, &PRELUDE] {
            assert!(list.is_sorted(), "{list:?}");
        }
    }
}

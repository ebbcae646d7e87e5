//! Which description a library belongs to: its GUID.
//!
//! The GUID is a fingerprint of the description. A library could compute it, and does where it was built by itself. But a default
//! value that the host's rounding mode or another mathematical library changes by one bit would give another fingerprint, and
//! the library would refuse its own description. So the packaging computes it once and has it compiled in, by the environment
//! variable [`VARIABLE`].

use crate::snapshot::GUID_LENGTH;

/// The environment variable that tells the compiler the GUIDs of a crate's models: `NAME={GUID};NAME={GUID}`. The macro
/// [`export!`](crate::export) spells it out, since it must be a literal there.
pub const VARIABLE: &str = "FMI2_EXPORT_GUIDS";

/// The GUID that [`VARIABLE`] has for a model.
#[must_use]
pub const fn fixed(table: Option<&'static str>, model: &str) -> Option<&'static str> {
    let Some(table) = table else { return None };
    let mut rest = table.as_bytes();
    loop {
        let mut equals = 0;
        while equals < rest.len() && rest[equals] != b'=' {
            equals += 1;
        }
        if rest.len() < equals + 1 + GUID_LENGTH {
            return None;
        }
        let (name, after) = rest.split_at(equals);
        let (guid, after) = after.split_at(1).1.split_at(GUID_LENGTH);
        if same(name, model.as_bytes()) {
            return match std::str::from_utf8(guid) {
                Ok(guid) => Some(guid),
                Err(_) => None,
            };
        }
        rest = match after {
            [b';', rest @ ..] => rest,
            _ => return None,
        };
    }
}

const fn same(a: &[u8], b: &[u8]) -> bool {
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: &str = "{00000000-0000-0000-0000-00000000000a}";

    #[test]
    fn guids_are_found_by_the_models_name() {
        const TABLE: Option<&str> = Some(
            "Lag={00000000-0000-0000-0000-00000000000a};Lag2={00000000-0000-0000-0000-00000000000b};X={too short}",
        );
        const LAG: Option<&str> = fixed(TABLE, "Lag");
        assert_eq!(LAG, Some(A));
        assert!(fixed(TABLE, "Lag2").is_some_and(|guid| guid.ends_with("b}")));
        for absent in ["La", "Lag3", "X", ""] {
            assert_eq!(fixed(TABLE, absent), None, "{absent}");
        }
        assert_eq!((fixed(None, "Lag"), fixed(Some(""), "Lag")), (None, None));
    }
}

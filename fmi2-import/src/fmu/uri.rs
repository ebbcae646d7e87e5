//! Folders as hosts name them to FMUs.

use std::path::Path;

/// The folder as an RFC 3986 `file` URI.
pub(super) fn file_uri(folder: &Path) -> String {
    use std::fmt::Write;
    let text = folder.to_string_lossy().replace('\\', "/");
    let mut uri = String::from(if text.starts_with('/') { "file://" } else { "file:///" });
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b':' | b'-' | b'_' | b'.' | b'~' => {
                uri.push(char::from(byte));
            }
            _ => write!(uri, "%{byte:02X}").expect("writing to a string cannot fail"),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resource_uris_are_percent_encoded() {
        assert_eq!(file_uri(Path::new("/tmp/a b/ü#")), "file:///tmp/a%20b/%C3%BC%23");
    }
}

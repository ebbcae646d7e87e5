//! Where the files are that an archive carries below `resources/` (FMI 2.0.4, section 2.1.5, `fmuResourceLocation`).

use std::path::{Path, PathBuf};

use crate::model::Failure;

/// The files that an FMU carries below `resources/`: tables, images, whatever a model reads.
///
/// The packaging puts them there, and the importing tool says where it has unpacked them. A model gets this in
/// [`Model::resources`](crate::Model::resources).
///
/// ```
/// # use fmi2_export::{Failure, Resources};
/// fn table(resources: &Resources) -> Result<String, Failure> {
///     // resources/friction.csv in the archive
///     String::from_utf8(resources.read("friction.csv")?).map_err(Failure::error)
/// }
/// # let folder = tempfile::tempdir().unwrap();
/// # std::fs::write(folder.path().join("friction.csv"), "1,2").unwrap();
/// // In a test, there is no archive, but the folder that goes into it.
/// # let there = folder.path();
/// assert_eq!(table(&Resources::at(there)).unwrap(), "1,2");
/// assert!(table(&Resources::default()).unwrap_err().to_string().contains("friction.csv"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Resources {
    /// As the host said it.
    location: String,
    folder: Option<PathBuf>,
}

impl Resources {
    /// Those in a folder, for tests.
    #[must_use]
    pub fn at(folder: impl Into<PathBuf>) -> Self {
        let folder = folder.into();
        Self { location: folder.display().to_string(), folder: Some(folder) }
    }

    /// Those that `fmuResourceLocation` names, which is a URI.
    pub(crate) fn located(location: &[u8]) -> Self {
        let folder = local_path(location, cfg!(windows)).and_then(native);
        Self { location: String::from_utf8_lossy(location).into_owned(), folder }
    }

    /// The folder, if the host named one that a program can open.
    #[must_use]
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// Where the file `resources/NAME` is.
    ///
    /// # Errors
    /// If the host named no folder; the message quotes what it said.
    pub fn path(&self, name: &str) -> Result<PathBuf, Failure> {
        match &self.folder {
            Some(folder) => Ok(folder.join(name)),
            None if self.location.is_empty() => Err(Failure::error(format_args!(
                "the model needs its file resources/{name}, but the importing tool does not say where that is \
                 (fmuResourceLocation is empty)"
            ))),
            None => Err(Failure::error(format_args!(
                "the model needs its file resources/{name}, but the importing tool says it is at {:?}, which names no \
                 folder of this computer",
                self.location
            ))),
        }
    }

    /// The content of the file `resources/NAME`.
    ///
    /// # Errors
    /// If the host named no folder, or the file cannot be read.
    pub fn read(&self, name: &str) -> Result<Vec<u8>, Failure> {
        let path = self.path(name)?;
        std::fs::read(&path).map_err(|error| {
            Failure::error(format_args!("cannot read resources/{name} at {}: {error}", path.display()))
        })
    }
}

/// The path, in bytes, that a `file:` URI stands for (RFC 8089), or that is given as a path although the standard wants a URI.
/// `None` for what is on another computer or in no file system. Hosts write such URIs in many ways: with no, one or three
/// slashes, with a drive in the place of the computer, with characters that should have been encoded.
fn local_path(location: &[u8], windows: bool) -> Option<Vec<u8>> {
    const SCHEME: &[u8] = b"file:";
    if location.contains(&0) {
        return None;
    }
    let is_slash = |byte: &u8| *byte == b'/' || (windows && *byte == b'\\');
    let path = match location.split_at_checked(SCHEME.len()) {
        Some((scheme, rest)) if scheme.eq_ignore_ascii_case(SCHEME) => {
            let (computer, path) = match rest {
                [a, b, rest @ ..] if is_slash(a) && is_slash(b) => {
                    rest.split_at(rest.iter().position(is_slash).unwrap_or(rest.len()))
                }
                _ => (&b""[..], rest),
            };
            let path = percent_decoded(path);
            if computer.is_empty() || computer.eq_ignore_ascii_case(b"localhost") {
                path
            } else if !windows {
                return None;
            } else if drive(computer).is_some() {
                [computer, &path].concat()
            } else {
                [b"\\\\", computer, &path].concat()
            }
        }
        _ => location.to_vec(),
    };
    if path.contains(&0) {
        return None;
    }
    if !windows {
        return path.starts_with(b"/").then_some(path);
    }
    // The drive may stand behind a slash, and its colon may be a bar.
    let from_drive = path.strip_prefix(b"/").filter(|rest| drive(rest).is_some()).unwrap_or(&path);
    let mut path = from_drive.to_vec();
    if drive(&path).is_some() {
        path[1] = b':';
    } else if !path.first().is_some_and(is_slash) {
        return None;
    }
    path.iter_mut().filter(|byte| **byte == b'/').for_each(|byte| *byte = b'\\');
    Some(path)
}

/// The letter of a drive that a path starts with.
fn drive(path: &[u8]) -> Option<u8> {
    match path {
        [letter, b':' | b'|'] | [letter, b':' | b'|', b'/' | b'\\', ..] if letter.is_ascii_alphabetic() => {
            Some(*letter)
        }
        _ => None,
    }
}

/// `%41` becomes `A`. A percent sign that no two hexadecimal digits follow stays: it should have been encoded itself.
fn percent_decoded(text: &[u8]) -> Vec<u8> {
    let digit = |byte: u8| char::from(byte).to_digit(16).and_then(|digit| u8::try_from(digit).ok());
    let mut decoded = Vec::with_capacity(text.len());
    let mut rest = text;
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        let pair = match after {
            [high, low, ..] if byte == b'%' => digit(*high).zip(digit(*low)),
            _ => None,
        };
        if let Some((high, low)) = pair {
            decoded.push(16 * high + low);
            rest = &after[2..];
        } else {
            decoded.push(byte);
        }
    }
    decoded
}

#[cfg(unix)]
#[allow(clippy::unnecessary_wraps)] // Elsewhere not every byte can be in a path.
fn native(path: Vec<u8>) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    Some(std::ffi::OsString::from_vec(path).into())
}

#[cfg(not(unix))]
fn native(path: Vec<u8>) -> Option<PathBuf> {
    String::from_utf8(path).ok().map(PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(location: &str, windows: bool) -> Option<String> {
        local_path(location.as_bytes(), windows).map(|path| String::from_utf8(path).unwrap())
    }

    #[test]
    fn locations_as_hosts_write_them() {
        for (location, expected) in [
            ("file:///tmp/fmu/resources", Some("/tmp/fmu/resources")),
            ("file:/tmp/fmu/resources", Some("/tmp/fmu/resources")),
            ("FILE://localhost/tmp/x", Some("/tmp/x")),
            ("file:///tmp/a%20b%c3%BC/%23", Some("/tmp/a bü/#")),
            ("file:///tmp/a b#?ü", Some("/tmp/a b#?ü")),
            ("file:///100%/50%zz", Some("/100%/50%zz")),
            ("/tmp/a%20b", Some("/tmp/a%20b")),
            ("file:////tmp/x/", Some("//tmp/x/")),
            ("file://server/share/x", None),
            ("file:resources", None),
            ("file:", None),
            ("file://", None),
            ("resources", None),
            ("http://host/x", None),
            ("jar:file:/x.jar!/y", None),
            ("file:///tmp/%00", None),
            ("", None),
        ] {
            assert_eq!(path(location, false).as_deref(), expected, "{location}");
        }
    }

    #[test]
    fn locations_on_windows() {
        for (location, expected) in [
            ("file:///C:/Temp/a%20b/resources", Some(r"C:\Temp\a b\resources")),
            ("file:/C:/Temp", Some(r"C:\Temp")),
            ("file:C:/Temp", Some(r"C:\Temp")),
            ("file:///c|/Temp", Some(r"c:\Temp")),
            ("file:///C%3A/Temp", Some(r"C:\Temp")),
            ("file://C:/Temp", Some(r"C:\Temp")),
            (r"file:///C:\Temp\x", Some(r"C:\Temp\x")),
            (r"file://C:\Temp\x", Some(r"C:\Temp\x")),
            ("file://server/share/x", Some(r"\\server\share\x")),
            ("file:////server/share/x", Some(r"\\server\share\x")),
            (r"C:\Temp\a%20b", Some(r"C:\Temp\a%20b")),
            (r"\\server\share", Some(r"\\server\share")),
            ("http://host/x", None),
            ("Temp", None),
            ("C:Temp", None),
            ("", None),
        ] {
            assert_eq!(path(location, true).as_deref(), expected, "{location}");
        }
    }

    #[test]
    fn what_is_missing_is_said() {
        let message = |resources: &Resources| resources.read("a.csv").unwrap_err().to_string();
        assert!(message(&Resources::default()).contains("fmuResourceLocation is empty"));
        assert!(message(&Resources::located(b"http://x")).contains("\"http://x\", which names no folder"));
        assert!(message(&Resources::at("/nowhere")).contains("cannot read resources/a.csv at /nowhere"));
    }
}

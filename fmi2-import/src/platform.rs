//! The names of platforms in FMI 2.0: folders below `binaries/`.

/// Folders from which this process can load libraries, the preferred one first.
///
/// Since version 2.0.4 the standard names platforms other than x86 by processor and system, as FMI 3.0 does. Older FMUs
/// have such libraries under the old names. These folders are searched too, if the library in them is for this processor.
pub(crate) const FOLDERS: &[&str] = folders();

const fn folders() -> &'static [&'static str] {
    if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        &["linux64", "x86_64-linux"]
    } else if cfg!(all(target_os = "linux", target_arch = "x86")) {
        &["linux32", "x86-linux"]
    } else if cfg!(all(target_os = "linux", target_arch = "aarch64")) {
        &["aarch64-linux", "linux64"]
    } else if cfg!(all(target_os = "linux", target_arch = "arm")) {
        &["aarch32-linux", "linux32"]
    } else if cfg!(all(target_os = "linux", target_arch = "riscv64")) {
        &["riscv64-linux", "linux64"]
    } else if cfg!(all(target_os = "macos", target_arch = "aarch64")) {
        &["aarch64-darwin", "darwin64"]
    } else if cfg!(target_os = "macos") {
        &["darwin64", "x86_64-darwin"]
    } else if cfg!(all(windows, target_arch = "x86_64")) {
        &["win64", "x86_64-windows"]
    } else if cfg!(all(windows, target_arch = "aarch64")) {
        &["aarch64-windows"]
    } else if cfg!(windows) {
        &["win32", "x86-windows"]
    } else {
        &["unknown"]
    }
}

/// The folder below `binaries/` that FMI 2.0 has for this platform.
#[must_use]
pub fn platform() -> &'static str {
    FOLDERS[0]
}

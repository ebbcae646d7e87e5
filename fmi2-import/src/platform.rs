//! The names that FMI 2.0 has for platforms: folders below `binaries/`.

/// Folders this process can load libraries from, the usual one first.
///
/// Since version 2.0.4 the standard names other platforms than those of the x86 family as FMI 3.0 does, by processor and
/// system; older FMUs have libraries for them under the old names, so those are looked at too, if the library in them is
/// for this processor.
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

//! Emulators that run programs of another platform here.

use std::fs;
use std::process::Command;

use super::{cross, first, on_path};
use crate::tree::Tree;

/// How programs of a platform are made and run.
pub struct Emulator {
    /// A C compiler for the platform, and its first arguments.
    pub c_compiler: Vec<String>,
    /// The command that starts a program, and its first arguments.
    pub run: Vec<String>,
    /// Variables for both.
    pub environment: Vec<(&'static str, String)>,
}

/// The release of Debian whose C library represents an old Linux: glibc 2.31, from 2020.
const OLD_DEBIAN: &str = "bullseye";

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Windows.
pub fn wine(tree: &Tree) -> Result<Emulator, String> {
    let Some(wine) = on_path("wine64").or_else(|| first(&["/usr/lib/wine/wine64"])) else {
        return Err("no wine64 (Debian: wine64)".into());
    };
    Ok(Emulator {
        c_compiler: words(&["x86_64-w64-mingw32-gcc"]),
        run: vec![wine.display().to_string()],
        environment: vec![
            ("WINEPREFIX", tree.target.join("wine").display().to_string()),
            ("WINEDEBUG", "-all".into()),
            // Names of files are UTF-8.
            ("LC_ALL", "C.UTF-8".into()),
        ],
    })
}

/// Linux on 64-bit ARM.
pub fn qemu(tree: &Tree) -> Result<Emulator, String> {
    let Some(qemu) = on_path("qemu-aarch64").or_else(|| on_path("qemu-aarch64-static")) else {
        return Err("no qemu-aarch64 (Debian: qemu-user)".into());
    };
    let libraries = old_libraries(tree, "arm64")?;
    Ok(Emulator {
        c_compiler: zig_cc(tree, "aarch64-linux-gnu.2.17")?,
        run: vec![qemu.display().to_string(), "-L".into(), libraries],
        environment: Vec::new(),
    })
}

/// An old Linux on this processor.
pub fn old_linux(tree: &Tree) -> Result<Emulator, String> {
    let root = old_libraries(tree, "amd64")?;
    let libraries = format!("{root}/lib/x86_64-linux-gnu");
    Ok(Emulator {
        c_compiler: zig_cc(tree, "x86_64-linux-gnu.2.17")?,
        // Its own loader and C library; only the kernel is ours.
        run: vec![format!("{libraries}/ld-2.31.so"), "--library-path".into(), libraries],
        environment: Vec::new(),
    })
}

fn zig_cc(tree: &Tree, target: &str) -> Result<Vec<String>, String> {
    let zig = cross::zig(tree)?.display().to_string();
    Ok(vec![zig, "cc".into(), "-target".into(), target.into()])
}

/// The root of an old Debian with its C library; fetched once.
fn old_libraries(tree: &Tree, architecture: &str) -> Result<String, String> {
    let folder = tree.target.join(format!("debian-{OLD_DEBIAN}-{architecture}"));
    if !folder.join("complete").is_file() {
        if on_path("debootstrap").is_none() {
            return Err("no debootstrap to fetch an old C library with".into());
        }
        let _ = fs::remove_dir_all(&folder);
        let mut fetch = Command::new("debootstrap");
        fetch.args(["--foreign", "--variant=minbase", &format!("--arch={architecture}"), OLD_DEBIAN]).arg(&folder);
        let fetched = fetch.output().is_ok_and(|output| output.status.success());
        if !fetched {
            return Err(format!("debootstrap could not fetch Debian {OLD_DEBIAN} (it needs root and the network)"));
        }
        fs::write(folder.join("complete"), "").map_err(|error| error.to_string())?;
    }
    Ok(folder.display().to_string())
}

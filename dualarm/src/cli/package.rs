//! `dualarm package`

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::fmus::folder;
use super::{Failure, numbers, print, print_error};
use crate::build::crosscheck::release;
use crate::build::{PackageError, Platforms, package, repository};
use crate::grasp::systems;
use fmi2_cosim::files::FileSet;
use fmi2_package::platform::Platform;

const AFTER_HELP: &str = "\
Leaves the FMUs, and each controller with the plant as one system: DualArmGrasp-NABFC.ssp, -PDS.ssp and -PD.ssp (SSP \
1.0), which `dualarm simulate`, Ecos, FMPy, OMSimulator and others run.

An FMU has a library for this machine's platform, and for each other one whose toolchain is installed:
  win64                     rustup target add x86_64-pc-windows-gnu, and
                            mingw-w64
  linux64, for old systems  pip install cargo-zigbuild ziglang: glibc 2.17
                            instead of this machine's
  aarch64-linux             rustup target add aarch64-unknown-linux-gnu, and zig
                            as above or gcc-aarch64-linux-gnu
  darwin64, aarch64-darwin  a Mac, with its rustup targets

What a library needs is in documentation/externalDependencies.txt of the archive.

Examples:
  dualarm package                     dist/*.fmu and dist/*.ssp
  dualarm package --out ~/fmus        elsewhere
  dualarm package --require linux64,win64
                                      fails unless they run on both
  dualarm package --merge windows/    with the libraries of the FMUs that were
                                      packaged in that folder on another machine
  dualarm package --plant-order 12 --out fine/
                                      a plant with the states of order 12 for
                                      model exchange, where `order` is fixed
  dualarm package --cross-check       and dist/release: each FMU with inputs,
                                      reference solution, options and README, as
                                      the FMI cross-check rules want them";

/// Arguments of `dualarm package`.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Folder for the .fmu and .ssp files
    #[arg(long, short, default_value = "dist", value_name = "FOLDER", value_parser = folder())]
    out: PathBuf,
    /// Build for these platforms, e.g. linux64,win64 [default: this machine's, and all others whose toolchains are installed]
    #[arg(long, value_name = "NAMES", value_parser = Platform::list, conflicts_with = "describe")]
    platform: Option<Names>,
    /// Fail if one of these platforms is missing in the end
    #[arg(long, value_name = "NAMES", value_parser = Platform::list, conflicts_with = "describe")]
    require: Option<Names>,
    /// Add the libraries of this .fmu, or of all in this folder, built elsewhere from the same sources; can be repeated
    #[arg(long, value_name = "PATH", conflicts_with = "describe")]
    merge: Vec<PathBuf>,
    /// Order of the plant whose states it has in model exchange, where FMI fixes their number; also the default of `order`
    #[arg(long, value_name = "ORDER", value_parser = numbers::order, conflicts_with = "describe")]
    plant_order: Option<u8>,
    /// Also write the release layout of the FMI cross-check rules to FOLDER/release
    // The option was once called `--release`, which is less clear and looks like an option of cargo.
    #[arg(long, alias = "release", conflicts_with = "describe")]
    cross_check: bool,
    /// Only renew the systems' descriptions (.ssd, .ssv) below this folder, from the FMUs' descriptions (.xml) in it
    #[arg(long, value_name = "FOLDER", conflicts_with = "out")]
    describe: Option<PathBuf>,
}

/// An alias, since clap takes an option of type `Vec` for one that can be repeated.
type Names = Vec<&'static Platform>;

pub fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    if let Some(folder) = &arguments.describe {
        return describe(folder, quiet);
    }
    let platforms = Platforms {
        wanted: arguments.platform.clone().unwrap_or_default(),
        required: arguments.require.clone().unwrap_or_default(),
        merged: arguments.merge.clone(),
    };
    for path in package_all(&arguments.out, &platforms, arguments.plant_order, quiet)? {
        if !quiet {
            let size = std::fs::metadata(&path).map_or(0, |file| file.len());
            print(&format!("{}  {:.2} MB\n", path.display(), size as f64 / 1e6));
        }
    }
    if arguments.cross_check {
        let out = arguments.out.join("release");
        for folder in release(&arguments.out, &out, &mut |doing| say(quiet, doing))? {
            if !quiet {
                print(&format!("{}\n", folder.display()));
            }
        }
    }
    Ok(())
}

/// Builds the FMUs, composes the systems, and writes both to a folder. They belong together, so they appear there at the
/// same time.
pub fn package_all(
    out: &Path,
    platforms: &Platforms,
    plant_order: Option<u8>,
    quiet: bool,
) -> Result<Vec<PathBuf>, Failure> {
    let apart = tempfile::tempdir()?;
    let root = repository().ok_or(PackageError::NoSources)?;
    let packaged = package(&root, apart.path(), platforms, plant_order, quiet, &mut |doing| say(quiet, doing))?;
    if let Some(line) = packaged.left_out.filter(|_| !quiet) {
        print_error(&format!("{line}\n"));
    }
    let mut made = packaged.fmus;
    say(quiet, "composing the systems");
    made.extend(systems::write_packages(apart.path())?);
    let together = FileSet::new();
    let mut written = Vec::new();
    for file in made {
        let target = out.join(file.file_name().unwrap_or_default());
        together.write(&target, fs::read(&file)?)?;
        written.push(target);
    }
    together.appear()?;
    Ok(written)
}

fn describe(folder: &Path, quiet: bool) -> Result<(), Failure> {
    let written = FileSet::new();
    let mut paths = Vec::new();
    for (path, text) in systems::describe_packages(folder)? {
        let path = folder.join(path);
        written.write(&path, text)?;
        paths.push(path);
    }
    written.appear()?;
    if !quiet {
        for path in &paths {
            print(&format!("{}\n", path.display()));
        }
    }
    Ok(())
}

/// Prints one line about the present activity to standard error. Cargo draws its own bar below it.
pub fn say(quiet: bool, doing: &str) {
    if !quiet {
        print_error(&format!("{doing} …\n"));
    }
}

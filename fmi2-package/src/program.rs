//! The work of the packaging program: combines descriptions, libraries and documents into archives.

use std::io::Write;
use std::path::{Path, PathBuf};

use fmi2_export::{Description, Library};

use crate::archive::{self, Archive};
use crate::arguments::{Command, HELP, Options, parse};
use crate::build::Crate;
use crate::document::{self, Origin};
use crate::platform::{PLATFORMS, Platform};
use crate::{Document, PackageError, requirements, toolchain};

/// A library and its platform.
type Binary = (&'static Platform, Vec<u8>);

pub fn run(library: &'static Library, documents: &[Document<'_>]) -> Result<(), PackageError> {
    let command = parse()?;
    if matches!(command, Command::Help) {
        return print(HELP);
    }
    let descriptions: Vec<Description> =
        library.models().iter().map(|model| model.description()).collect::<Result<_, _>>()?;
    check_names(documents, &descriptions)?;
    match command {
        Command::Help => Ok(()),
        Command::Guids => print(&format!("{}\n", guids(&descriptions))),
        Command::Describe { out } => {
            create(&out)?;
            for description in &descriptions {
                let path = out.join(format!("{}.xml", description.name));
                std::fs::write(&path, &description.xml).map_err(PackageError::file("write", &path))?;
                print(&format!("{}\n", path.display()))?;
            }
            Ok(())
        }
        Command::Package(options) => package(library, documents, &descriptions, &options),
    }
}

/// The GUIDs of a crate's models, in the format of [`VARIABLE`](fmi2_export::packaging::VARIABLE).
fn guids(descriptions: &[Description]) -> String {
    let entries: Vec<String> = descriptions.iter().map(|one| format!("{}={}", one.name, one.guid)).collect();
    entries.join(";")
}

fn package(
    library: &'static Library,
    documents: &[Document<'_>],
    descriptions: &[Description],
    options: &Options,
) -> Result<(), PackageError> {
    let mut binaries = given(&options.libraries, descriptions)?;
    let merged = options.merged.iter().map(|path| merge(path, descriptions)).collect::<Result<Vec<_>, _>>()?;
    let is_merged = |platform: &&'static Platform| {
        let has = |name| merged.iter().any(|(of, files)| *of == name && files.iter().any(|(p, _)| p == platform));
        descriptions.iter().all(|description| has(description.name))
    };
    let required: Vec<_> = options.required.iter().copied().filter(|platform| !is_merged(platform)).collect();
    let to_build = if binaries.is_empty() {
        let (to_build, mut left_out) =
            toolchain::select(&options.platforms, &required).map_err(PackageError::Platform)?;
        left_out.retain(|(platform, _)| !is_merged(platform));
        if let Some(line) = toolchain::left_out(&left_out) {
            eprintln!("{line}");
        }
        to_build
    } else {
        let has = |platform: &&&'static Platform| binaries.iter().any(|(of, _)| of == *platform);
        if let Some(absent) = required.iter().find(|platform| !has(platform)) {
            return Err(PackageError::Platform(format!(
                "{} is required, but none of the libraries is for it",
                absent.folder
            )));
        }
        Vec::new()
    };

    // Documents are checked first, because building takes longer.
    let none = Document::new();
    let document = |name| documents.iter().find(|document| document.model == name).unwrap_or(&none);
    let further = |name: &str| {
        let of_model = merged.iter().filter(|(of, _)| *of == name).flat_map(|(_, files)| files.iter().map(|(p, _)| *p));
        of_model.collect::<Vec<_>>()
    };
    let mut extras = Vec::new();
    for (model, description) in library.models().iter().zip(descriptions) {
        let mut platforms: Vec<_> =
            binaries.iter().map(|(platform, _)| *platform).chain(to_build.iter().copied()).collect();
        platforms.extend(further(description.name));
        let origin = Origin::new(library.package(), platforms);
        extras.push(document::files(*model, description, document(description.name), &origin)?);
    }
    create(&options.out)?;
    for description in descriptions {
        archive::check_target(&options.out, description.name, library.package())?;
    }

    if !to_build.is_empty() {
        let package = Crate::find()?;
        for platform in to_build {
            let path = package.library(platform, &guids(descriptions))?;
            binaries.extend(given(&[path], descriptions)?);
        }
    }
    let licenses = match Crate::find().and_then(|package| package.licenses()) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("warning: the licences of linked crates are not in the archive: {error}");
            String::new()
        }
    };
    let mut finished = Vec::new();
    for (description, files) in descriptions.iter().zip(&extras) {
        let mut archive = Archive::new();
        archive.add("modelDescription.xml", description.xml.as_bytes());
        let own = binaries.iter();
        let others = merged.iter().filter(|(of, _)| *of == description.name).flat_map(|(_, files)| files);
        let mut libraries: Vec<(&'static Platform, &[u8])> = Vec::new();
        for (platform, content) in own.chain(others) {
            if !libraries.iter().any(|(taken, _)| taken == platform) {
                libraries.push((platform, content));
            }
        }
        libraries.sort_by_key(|(platform, _)| PLATFORMS.iter().position(|known| known == *platform));
        for (platform, content) in &libraries {
            archive.add(library_path(platform, description.name), content);
        }
        archive.add(requirements::PATH, requirements::text(&libraries).as_bytes());
        for (path, content) in files {
            archive.add(path, content);
        }
        if !licenses.is_empty() {
            archive.add(document::LINKED_LICENSES, licenses.as_bytes());
        }
        finished.push(archive.beside(options.out.join(format!("{}.fmu", description.name)))?);
    }
    // The models of a library belong together: an interruption before this point keeps the former ones.
    let written = finished.into_iter().map(archive::Finished::appear).collect::<Result<Vec<_>, _>>()?;
    written.iter().try_for_each(|path| print(&format!("{}\n", path.display())))
}

/// Prints to standard output, which may be closed or full.
fn print(text: &str) -> Result<(), PackageError> {
    let mut out = std::io::stdout();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(PackageError::StandardOutput)
}

/// Where an archive has the library for a platform.
pub fn library_path(platform: &Platform, model: &str) -> String {
    format!("binaries/{}/{model}.{}", platform.folder, platform.extension())
}

/// Built libraries, each for another platform, all with the models' GUIDs in them.
fn given(paths: &[PathBuf], descriptions: &[Description]) -> Result<Vec<Binary>, PackageError> {
    let mut binaries: Vec<Binary> = Vec::new();
    for path in paths {
        let content = archive::plain_file(path).map_err(PackageError::file("read", path))?;
        let wrong = |problem| PackageError::Library { path: path.clone(), problem };
        let platform = Platform::of(&content).map_err(wrong)?;
        if binaries.iter().any(|(other, _)| *other == platform) {
            return Err(wrong(format!("it is the second one for {}", platform.folder)));
        }
        if let Some(other) = descriptions.iter().find(|description| !contains(&content, description.guid.as_bytes())) {
            return Err(wrong(format!(
                "it was not built for this description: the GUID of {} is not in it. `cargo fmi2 package` builds the right one; \
                 otherwise build it with {}='{}'",
                other.name,
                fmi2_export::packaging::VARIABLE,
                guids(descriptions)
            )));
        }
        binaries.push((platform, content));
    }
    Ok(binaries)
}

fn contains(content: &[u8], part: &[u8]) -> bool {
    content.windows(part.len()).any(|window| window == part)
}

/// The libraries of an archive that was made elsewhere from the description of one of the models, and the name of this
/// model.
fn merge<'d>(path: &Path, descriptions: &'d [Description]) -> Result<(&'d str, Vec<Binary>), PackageError> {
    let wrong = |problem: String| PackageError::Merge { path: path.to_owned(), problem };
    let files = archive::read(path)?;
    let xml =
        files.iter().find(|(name, _)| name == "modelDescription.xml").ok_or_else(|| wrong("it is no FMU".into()))?;
    let Some(description) = descriptions.iter().find(|description| description.xml.as_bytes() == xml.1) else {
        let ours: Vec<String> = descriptions.iter().map(|one| format!("{} {}", one.name, one.guid)).collect();
        return Err(wrong(format!(
            "its description is none of this crate's models' ({}): it was made from another version of the sources",
            ours.join(", ")
        )));
    };
    let mut binaries = Vec::new();
    for platform in &PLATFORMS {
        let Some((name, content)) = files.iter().find(|(name, _)| *name == library_path(platform, description.name))
        else {
            continue;
        };
        match Platform::of(content) {
            Ok(found) if found == platform => binaries.push((platform, content.clone())),
            Ok(found) => return Err(wrong(format!("{name} is a library for {}", found.folder))),
            Err(problem) => return Err(wrong(format!("{name}: {problem}"))),
        }
    }
    Ok((description.name, binaries))
}

/// Checks that each document is for a model, and that each model has a unique file name, also where upper and lower case
/// are the same.
fn check_names(documents: &[Document<'_>], descriptions: &[Description]) -> Result<(), PackageError> {
    let known: Vec<&'static str> = descriptions.iter().map(|description| description.name).collect();
    for (i, name) in known.iter().enumerate() {
        if let Some(other) = known[..i].iter().find(|other| other.eq_ignore_ascii_case(name)) {
            return Err(PackageError::SameName { one: other, other: name });
        }
    }
    match documents.iter().find(|document| !known.contains(&document.model)) {
        Some(stray) => Err(PackageError::NoSuchModel { model: stray.model.to_owned(), known }),
        None => Ok(()),
    }
}

fn create(folder: &Path) -> Result<(), PackageError> {
    std::fs::create_dir_all(folder).map_err(PackageError::file("create", folder))
}

//! An `.fmu` file: a zip archive with a description and, per platform, a library.

mod contents;
mod several;
mod uri;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use object::ReadCache;

use crate::binary;
use crate::description::ModelDescription;
use crate::error::{CallError, FmuError};
use crate::instance::Instance;
use crate::library::Functions;
use contents::{archive, candidates, description, of_archive, share, unpacked};
use uri::file_uri;

/// An unpacked FMU. Cheap to clone; the unpacked files are removed with the last clone. [`Fmu::load`] or the first instance
/// loads its library; none of its code runs before. To run several FMUs, unpack all of them before loading one, because
/// loaded code may change the meaning of relative paths.
#[derive(Clone)]
pub struct Fmu {
    unpacked: Arc<Unpacked>,
}

/// Fields drop in this order: the library leaves before its file does.
struct Unpacked {
    loaded: OnceLock<Arc<Loaded>>,
    description: Arc<ModelDescription>,
    path: PathBuf,
    /// Its name in the archive.
    library: String,
    files: Files,
}

/// A loaded library, with everything its instances need. The order of the fields is the order in which they are dropped, as
/// above.
pub(crate) struct Loaded {
    pub functions: Functions,
    pub description: Arc<ModelDescription>,
    pub resources: String,
    _files: Files,
}

/// The unpacked files of an FMU. They are there as long as this is.
#[derive(Debug, Clone)]
pub struct Files(Arc<contents::Unpacked>);

/// The contents of an FMU's archive.
#[derive(Debug, Clone)]
pub struct Contents {
    /// The description.
    pub description: ModelDescription,
    /// The paths of all files in it.
    pub files: Vec<String>,
}

impl Contents {
    /// The folders below `binaries`: one per platform there is a library for.
    #[must_use]
    pub fn platforms(&self) -> Vec<&str> {
        let mut platforms: Vec<&str> = self
            .files
            .iter()
            .filter_map(|file| file.strip_prefix("binaries/")?.split_once('/').map(|(folder, _)| folder))
            .collect();
        platforms.dedup(); // the files are sorted
        platforms
    }

    /// Whether there is a file below this folder.
    #[must_use]
    pub fn has(&self, folder: &str) -> bool {
        self.files.iter().any(|file| file.starts_with(folder))
    }
}

impl Fmu {
    /// Reads only the description of an FMU: works for any platform and for model exchange.
    ///
    /// # Errors
    /// When the file is unreadable, not an FMU, or not FMI 2.0.
    pub fn read_description(path: impl AsRef<Path>) -> Result<ModelDescription, FmuError> {
        let path = path.as_ref();
        description(path, &mut archive(path)?)
    }

    /// Reads the description and the names of all files of an FMU: works for any platform and for model exchange.
    ///
    /// # Errors
    /// When the file is unreadable, not an FMU, or not FMI 2.0.
    pub fn inspect(path: impl AsRef<Path>) -> Result<Contents, FmuError> {
        let path = path.as_ref();
        let mut archive = archive(path)?;
        let description = description(path, &mut archive)?;
        let files = archive.files().into_iter().map(str::to_owned).collect();
        Ok(Contents { description, files })
    }

    /// Checks the library of an FMU, without loading or unpacking it.
    ///
    /// # Errors
    /// When the file is unreadable or not an FMI 2.0 co-simulation FMU, or has no library for this platform, or when this
    /// library is invalid or lacks a function that every co-simulation FMU must have.
    pub fn check_library(path: impl AsRef<Path>) -> Result<(), FmuError> {
        let path = path.as_ref();
        let mut archive = archive(path)?;
        let description = description(path, &mut archive)?;
        let candidates = candidates(path, &archive, &description)?;
        let mut refused = None;
        for (platform, library) in candidates {
            let folder = format!("binaries/{platform}/");
            let is_alone = archive.files().iter().filter(|file| file.starts_with(&folder)).count() <= 1;
            let data = archive.read_large(&library).map_err(|error| of_archive(path, error))?;
            if let Err(source) = binary::check_loadable(&*data) {
                _ = refused.get_or_insert(FmuError::Library { path: path.to_owned(), library, source });
                continue;
            }
            return binary::check_usable(&data, is_alone).map_err(|source| FmuError::Library {
                path: path.to_owned(),
                library,
                source,
            });
        }
        Err(refused.unwrap_or_else(|| FmuError::NotCoSimulation { path: path.to_owned() }))
    }

    /// Unpacks an FMU to a temporary folder.
    ///
    /// # Errors
    /// When the file is unreadable or not an FMI 2.0 co-simulation FMU, has no library for this platform, or when this
    /// library is for another processor or truncated.
    pub fn unpack(path: impl AsRef<Path>) -> Result<Self, FmuError> {
        let path = path.as_ref();
        let mut archive = archive(path)?;
        let description = description(path, &mut archive)?;
        let candidates = candidates(path, &archive, &description)?;
        let files = unpacked(path, &mut archive)?;
        let unpack = |source| FmuError::Unpack { path: path.to_owned(), source };

        // Folders with older names may have libraries for other processors.
        let mut refused = None;
        for (_, library) in candidates {
            // Of a large file this reads little.
            let file = ReadCache::new(File::open(files.place(&library)).map_err(unpack)?);
            match binary::check_loadable(&file) {
                Ok(()) => {
                    let unpacked = Unpacked {
                        loaded: OnceLock::new(),
                        description: Arc::new(description),
                        path: path.to_owned(),
                        library,
                        files: Files(Arc::new(files)),
                    };
                    return Ok(Self { unpacked: Arc::new(unpacked) });
                }
                Err(source) => _ = refused.get_or_insert(FmuError::Library { path: path.to_owned(), library, source }),
            }
        }
        Err(refused.unwrap_or_else(|| FmuError::NotCoSimulation { path: path.to_owned() }))
    }

    /// From now on, FMUs that are nothing but a library, as most are on one platform, are unpacked to this folder of the caller's, and not
    /// each to a temporary one: folders take some systems long to make and to remove. No other user should be able to write to it. Each
    /// library is removed with its last user. An empty folder `resources`, which all of them are told to be theirs, stays. The first call
    /// counts.
    pub fn share_folder(folder: impl Into<PathBuf>) {
        share(folder.into());
    }

    /// Unpacks an FMU to a temporary folder and loads its library.
    ///
    /// # Errors
    /// As [`Fmu::unpack`] and [`Fmu::load`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FmuError> {
        let fmu = Self::unpack(path)?;
        fmu.load()?;
        Ok(fmu)
    }

    /// Loads the library, unless it is already loaded. The FMU's code runs from now on.
    ///
    /// # Errors
    /// When the library cannot be used.
    pub fn load(&self) -> Result<(), FmuError> {
        self.loaded().map(drop)
    }

    fn loaded(&self) -> Result<&Arc<Loaded>, FmuError> {
        let Unpacked { loaded, description, path, library, files } = &*self.unpacked;
        if let Some(loaded) = loaded.get() {
            return Ok(loaded);
        }
        let functions = Functions::load(&files.0.place(library)).map_err(|source| FmuError::Library {
            path: path.clone(),
            library: library.clone(),
            source,
        })?;
        Ok(loaded.get_or_init(|| {
            Arc::new(Loaded {
                functions,
                description: Arc::clone(description),
                resources: file_uri(&files.0.resources()),
                _files: files.clone(),
            })
        }))
    }

    /// The description of the FMU.
    #[must_use]
    pub fn description(&self) -> &ModelDescription {
        &self.unpacked.description
    }

    /// The same, for callers that keep it longer than the FMU.
    #[must_use]
    pub fn shared_description(&self) -> Arc<ModelDescription> {
        Arc::clone(&self.unpacked.description)
    }

    /// The file it was opened from.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.unpacked.path
    }

    /// The unpacked files, for callers that decide when they are removed.
    #[must_use]
    pub fn files(&self) -> Files {
        self.unpacked.files.clone()
    }

    /// Creates an instance; loads the library first if necessary.
    ///
    /// # Errors
    /// When the library cannot be used, or the FMU refuses; the error contains its log messages.
    pub fn instantiate(&self, name: &str) -> Result<Instance, CallError> {
        let loaded = self.loaded().map_err(|source| CallError::Load(Box::new(source)))?;
        Instance::new(Arc::clone(loaded), name)
    }
}

impl std::fmt::Debug for Fmu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fmu").field("path", &self.unpacked.path).finish_non_exhaustive()
    }
}

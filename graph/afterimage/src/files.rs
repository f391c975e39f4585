//! The files of a pipeline: what has been read, and whether it has changed since.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use afterimage_graph::check::Loader;
use afterimage_pipelines::BuiltIn;

use crate::error::Error;
use crate::kinds::KindFiles;

/// The most bytes of a file that a pipeline names. The largest table has about 450 MiB as text.
const MAX_BYTES: u64 = 1 << 30;

/// The state of a file or of a folder by its time of change and its length; `None` where there is none.
type Stamp = Option<(SystemTime, u64)>;

/// Files and folders, with their states.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stamps(BTreeMap<PathBuf, Stamp>);

impl Stamps {
    /// The same files and folders as they are now; `None` if nothing has changed.
    pub(crate) fn changed(&self) -> Option<Self> {
        if self.0.iter().all(|(path, stamp)| stamp_of(path) == *stamp) {
            return None;
        }
        Some(Self(self.0.keys().map(|path| (path.clone(), stamp_of(path))).collect()))
    }

    pub(crate) fn extend(&mut self, others: Self) {
        self.0.extend(others.0);
    }
}

fn stamp_of(path: &Path) -> Stamp {
    let meta = path.metadata().ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

/// What has been read of the files that a pipeline may name. Each is read once, so that all tiers are of one state.
pub(crate) struct Files {
    /// The folders whose files may be read, without links.
    folders: Vec<PathBuf>,
    /// Whether the pipeline lies in no folder: then it may name built-in files.
    is_built_in: bool,
    read: Mutex<Read>,
}

#[derive(Default)]
struct Read {
    stamps: Stamps,
    bytes: BTreeMap<PathBuf, Result<Arc<[u8]>, String>>,
}

impl Files {
    /// The files in the folder of a pipeline, if it lies in one, in other folders, and below.
    pub(crate) fn new(own: Option<&Path>, allowed: &[PathBuf]) -> Self {
        let folders = own.into_iter().chain(allowed.iter().map(PathBuf::as_path));
        let folders = folders.filter_map(|folder| std::fs::canonicalize(or_current(folder)).ok()).collect();
        Self { folders, is_built_in: own.is_none(), read: Mutex::default() }
    }

    /// What has been read, and when it was changed.
    pub(crate) fn stamps(&self) -> Stamps {
        self.lock().stamps.clone()
    }

    /// All that has been read.
    pub(crate) fn all(&self) -> Vec<(PathBuf, Arc<[u8]>)> {
        let read = self.lock();
        read.bytes.iter().filter_map(|(path, bytes)| Some((path.clone(), bytes.clone().ok()?))).collect()
    }

    fn bytes(&self, path: &Path) -> Result<Arc<[u8]>, String> {
        let mut read = self.lock();
        if let Some(known) = read.bytes.get(path) {
            return known.clone();
        }
        // Before the file is read: a change in between is seen as one.
        read.stamps.0.insert(path.to_owned(), stamp_of(path));
        let bytes = read_regular(path);
        read.bytes.insert(path.to_owned(), bytes.clone());
        bytes
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Read> {
        self.read.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl KindFiles for Files {
    type Error = Error;

    fn list(&self, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        let folder = or_current(folder);
        self.lock().stamps.0.insert(folder.to_owned(), stamp_of(folder));
        let unreadable =
            |error: std::io::Error| Error::Unreadable(format!("`{}` cannot be listed: {error}", folder.display()));
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(unreadable)? {
            paths.push(entry.map_err(unreadable)?.path());
        }
        paths.sort();
        Ok(paths)
    }

    fn text(&self, path: &Path, _: &str) -> Result<String, Error> {
        let unreadable =
            |why: &dyn std::fmt::Display| Error::Unreadable(format!("`{}` cannot be read: {why}", path.display()));
        let bytes = self.bytes(path).map_err(|why| unreadable(&why))?;
        String::from_utf8(bytes.to_vec()).map_err(|error| unreadable(&error))
    }

    fn permits(&self, _: &Path) -> bool {
        true
    }

    fn no_kind(&self, message: String, hint: &str) -> Error {
        Error::Unreadable(format!("{message}\n  hint: {hint}"))
    }
}

impl Loader for Files {
    fn load(&self, path: &str) -> Result<Arc<[u8]>, String> {
        if self.is_built_in
            && let Ok(bytes) = BuiltIn.load(path)
        {
            self.lock().bytes.insert(path.into(), Ok(bytes.clone()));
            return Ok(bytes);
        }
        let path = Path::new(path);
        // A file that does not exist is watched, too: that it appears is a change.
        if let Ok(real) = std::fs::canonicalize(path)
            && !self.folders.iter().any(|folder| real.starts_with(folder))
        {
            return Err("only files in the folder of the pipeline and below are read, and in those of `allow`".into());
        }
        self.bytes(path)
    }

    /// Not kept: the user may correct the file, and name it again.
    fn load_override(&self, path: &str) -> Result<Arc<[u8]>, String> {
        read_regular(Path::new(path))
    }
}

/// An empty path means the current folder.
pub(crate) fn or_current(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// The bytes of a regular file. A pipe or a device, which a stranger's file may name, is not opened.
fn read_regular(path: &Path) -> Result<Arc<[u8]>, String> {
    let meta = path.metadata().map_err(|error| error.to_string())?;
    if !meta.is_file() {
        return Err("it is no file".into());
    }
    if meta.len() > MAX_BYTES {
        return Err(format!("it has {} bytes, and at most {MAX_BYTES} are read", meta.len()));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| error.to_string())?;
    file.take(meta.len()).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into())
}

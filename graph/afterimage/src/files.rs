//! The files of a pipeline: what has been read, and whether it has changed since.

use std::collections::BTreeMap;
use std::fs::{File, Metadata};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use afterimage_graph::check::Loader;
use afterimage_graph::diagnostic::shown_path;
use afterimage_pipelines::BuiltIn;

use crate::error::Error;
use crate::kinds::{KindFiles, LIBRARY, or_current};

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

/// The files that a pipeline may name, as far as they were read: each once, so that all tiers are of one state.
pub(crate) struct Files {
    /// The folders whose files the pipeline may name, without links.
    folders: Vec<PathBuf>,
    /// Those with node kinds, and with what these share.
    kind_folders: Vec<PathBuf>,
    /// Set for a pipeline that lies in no folder: it may name built-in files.
    is_built_in: bool,
    read: Mutex<Read>,
}

#[derive(Default)]
struct Read {
    stamps: Stamps,
    bytes: BTreeMap<PathBuf, Result<Arc<[u8]>, String>>,
}

impl Files {
    /// The files in the folder of a pipeline, if it lies in one, in other folders, and below; and those of kinds.
    pub(crate) fn new(own: Option<&Path>, allowed: &[PathBuf], kinds: &[PathBuf]) -> Self {
        let folders = own.into_iter().chain(allowed.iter().map(PathBuf::as_path)).filter_map(real_folder).collect();
        let mut kind_folders = Vec::new();
        for folder in kinds.iter().map(PathBuf::as_path).chain(own).filter_map(real_folder) {
            kind_folders.extend(folder.parent().map(|parent| parent.join(LIBRARY)));
            kind_folders.push(folder);
        }
        Self { folders, kind_folders, is_built_in: own.is_none(), read: Mutex::default() }
    }

    /// The text of the pipeline, which the host names: a link may lead to it.
    pub(crate) fn pipeline(&self, path: &Path) -> Result<String, Error> {
        self.text_if(path, &|_| true)
    }

    /// `true` if a file may be a part of a kind.
    fn permits_kind(&self, real: &Path) -> bool {
        self.folders.iter().chain(&self.kind_folders).any(|folder| real.starts_with(folder))
    }

    fn text_if(&self, path: &Path, permits: Permits<'_>) -> Result<String, Error> {
        let unreadable =
            |why: &dyn std::fmt::Display| Error::Unreadable(format!("`{}` cannot be read: {why}", shown_path(path)));
        let bytes = self.bytes(path, permits).map_err(|why| unreadable(&why))?;
        String::from_utf8(bytes.to_vec()).map_err(|error| unreadable(&error))
    }

    /// The files that have been read, and the times of their changes.
    pub(crate) fn stamps(&self) -> Stamps {
        self.lock().stamps.clone()
    }

    /// All that has been read.
    pub(crate) fn all(&self) -> Vec<(PathBuf, Arc<[u8]>)> {
        let read = self.lock();
        read.bytes.iter().filter_map(|(path, bytes)| Some((path.clone(), bytes.clone().ok()?))).collect()
    }

    fn bytes(&self, path: &Path, permits: Permits<'_>) -> Result<Arc<[u8]>, String> {
        let mut read = self.lock();
        if let Some(known) = read.bytes.get(path) {
            return known.clone();
        }
        // Before the file is read: a change in between is seen as one.
        read.stamps.0.insert(path.to_owned(), stamp_of(path));
        let bytes = read_regular(path, permits);
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
            |error: std::io::Error| Error::Unreadable(format!("`{}` cannot be listed: {error}", shown_path(folder)));
        let mut paths = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(unreadable)? {
            paths.push(entry.map_err(unreadable)?.path());
        }
        paths.sort();
        Ok(paths)
    }

    fn text(&self, path: &Path, _: &str) -> Result<String, Error> {
        self.text_if(path, &|real| self.permits_kind(real))
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
        self.bytes(Path::new(path), &|real| self.folders.iter().any(|folder| real.starts_with(folder)))
    }

    /// Not kept: the user may correct the file, and name it again.
    fn load_override(&self, path: &str) -> Result<Arc<[u8]>, String> {
        read_regular(Path::new(path), &|_| true)
    }
}

/// A folder without links, if there is one.
fn real_folder(folder: &Path) -> Option<PathBuf> {
    std::fs::canonicalize(or_current(folder)).ok()
}

/// Decides by the path of a file without links if it may be read.
type Permits<'a> = &'a dyn Fn(&Path) -> bool;

/// The bytes of a regular file that is permitted: of the file that is open, and not of one that had the name before. A
/// pipe or a device, which a stranger's file may name, is not opened.
fn read_regular(path: &Path, permits: Permits<'_>) -> Result<Arc<[u8]>, String> {
    let real = std::fs::canonicalize(path).map_err(|error| error.to_string())?;
    let refused = "only files in the folder of the pipeline and below are read, and in those of `allow`";
    if !permits(&real) {
        return Err(refused.into());
    }
    check_regular(&real.metadata().map_err(|error| error.to_string())?)?;
    let file = File::open(&real).map_err(|error| error.to_string())?;
    let meta = file.metadata().map_err(|error| error.to_string())?;
    check_regular(&meta)?;
    // A link may have taken its place, or that of a folder above it.
    if !path_of(&file, &meta, &real).is_ok_and(|opened| permits(&opened)) {
        return Err(refused.into());
    }
    let mut bytes = Vec::new();
    file.take(meta.len()).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into())
}

fn check_regular(meta: &Metadata) -> Result<(), String> {
    if !meta.is_file() {
        return Err("it is no file".into());
    }
    if meta.len() > MAX_BYTES {
        return Err(format!("it has {} bytes, and at most {MAX_BYTES} are read", meta.len()));
    }
    Ok(())
}

/// The path of an open file without links; it was opened as `real`.
fn path_of(file: &File, meta: &Metadata, real: &Path) -> std::io::Result<PathBuf> {
    #[cfg(target_os = "linux")]
    {
        use std::os::fd::AsRawFd;
        if let Ok(path) = std::fs::read_link(format!("/proc/self/fd/{}", file.as_raw_fd())) {
            return Ok(path);
        }
    }
    let path = std::fs::canonicalize(real)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let now = std::fs::symlink_metadata(&path)?;
        if (now.dev(), now.ino()) != (meta.dev(), meta.ino()) {
            return Err(std::io::Error::other("it was replaced while it was read"));
        }
    }
    let _ = (file, meta);
    Ok(path)
}

#[cfg(all(test, unix))]
mod tests {
    use std::fs;
    use std::os::unix::fs::symlink;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    #[test]
    fn a_link_that_changes_while_it_is_read_leads_to_no_file_outside() {
        let folder = std::env::temp_dir().join(format!("afterimage-swapped-{}", std::process::id()));
        fs::create_dir_all(folder.join("inside")).expect("a temporary folder");
        fs::write(folder.join("inside/file"), "inside").expect("a temporary file");
        fs::write(folder.join("outside"), "outside").expect("a temporary file");
        let (link, next) = (folder.join("inside/link"), folder.join("inside/next"));
        symlink("file", &link).expect("a link");
        let is_over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for target in ["../outside", "file"].iter().cycle().take(4000) {
                    symlink(target, &next).expect("a link");
                    fs::rename(&next, &link).expect("it is replaced");
                }
                is_over.store(true, Ordering::Relaxed);
            });
            while !is_over.load(Ordering::Relaxed) {
                let files = Files::new(Some(&folder.join("inside")), &[], &[]);
                if let Ok(bytes) = files.load(&link.to_string_lossy()) {
                    assert_eq!(&*bytes, b"inside");
                }
            }
        });
        // A link that stays is refused, too, as a part of a kind.
        fs::remove_file(&link).expect("a link");
        symlink("../outside", &link).expect("a link");
        let files = Files::new(Some(&folder.join("inside")), &[], &[]);
        assert!(files.text(&link, "shader").is_err() && files.load(&link.to_string_lossy()).is_err());
        fs::remove_dir_all(folder).expect("it was made");
    }
}

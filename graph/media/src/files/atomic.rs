//! Output files are written whole or not at all: next to the destination first, then renamed.

use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io::{self, BufReader, Seek, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::codec::{ErrorKind, check};
use crate::files::FileError;
use crate::files::leftovers::{ENDING, remove_leftovers};
use crate::files::rights::{keep_rights, private};

/// Writes `bytes` to `path`. Whatever fails, the file that was there before stays as it was and
/// nothing half written is left. Through a symbolic link the file behind it is replaced or made; devices
/// and pipes are written to directly, as they cannot be replaced.
///
/// A replaced file keeps its mode and, as far as the system permits it, its owner and its group. What killed runs have
/// left in the folder is removed.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_with_io_errors(path, bytes).map_err(|error| FileError::writing(path, &error))
}

fn write_with_io_errors(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = AtomicFile::open(path)?;
    file.file.write_all(bytes)?;
    file.replace()
}

/// Writes an image as [`write_atomic`] writes a file, after its headers are read back.
pub(super) fn write_image(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let mut file = AtomicFile::create(path)?;
    file.file.write_all(bytes).map_err(|error| FileError::writing(path, &error))?;
    file.finish_image()
}

/// A file that is written in parts, as [`write_atomic`] writes one at once. It is at its place when it is
/// [finished](Self::finish); dropped before, it leaves nothing.
pub struct AtomicFile {
    file: File,
    /// `None` for what cannot be replaced.
    temporary: Option<Temporary>,
    to: PathBuf,
    old: Option<Metadata>,
}

impl AtomicFile {
    /// Begins a file.
    ///
    /// # Errors
    /// As [`write_atomic`].
    pub fn create(path: &Path) -> Result<Self, FileError> {
        Self::open(path).map_err(|error| FileError::writing(path, &error))
    }

    fn open(path: &Path) -> io::Result<Self> {
        let (to, old) = match fs::metadata(path) {
            Ok(meta) if meta.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(meta) if !meta.is_file() => {
                let file = File::options().write(true).open(path)?;
                return Ok(Self { file, temporary: None, to: path.to_owned(), old: None });
            }
            Ok(meta) => (fs::canonicalize(path)?, Some(meta)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => (behind_links(path)?, None),
            Err(error) => return Err(error),
        };
        remove_leftovers(&to);
        let (temporary, file) = Temporary::beside(&to, old.as_ref())?;
        Ok(Self { file, temporary: Some(temporary), to, old })
    }

    /// The file, to be written.
    ///
    /// # Errors
    /// The system has no handle for it.
    pub fn handle(&self) -> Result<File, FileError> {
        self.file.try_clone().map_err(|error| FileError::writing(&self.to, &error))
    }

    /// Puts the file at its place.
    ///
    /// # Errors
    /// As [`write_atomic`].
    pub fn finish(self) -> Result<(), FileError> {
        let to = self.to.clone();
        self.replace().map_err(|error| FileError::writing(&to, &error))
    }

    /// Puts an image at its place if its headers can be read.
    ///
    /// # Errors
    /// As [`write_atomic`], and an image that could not be read: the file that was there stays.
    pub(super) fn finish_image(mut self) -> Result<(), FileError> {
        if self.temporary.is_some() {
            self.file.rewind().map_err(|error| FileError::writing(&self.to, &error))?;
            check(BufReader::new(&self.file)).map_err(|error| {
                let what = format!("the image was written, but cannot be read again: {}", error.message);
                FileError::new(&self.to, ErrorKind::Machine, what)
            })?;
        }
        self.finish()
    }

    fn replace(self) -> io::Result<()> {
        let Some(temporary) = self.temporary else { return Ok(()) };
        if let Some(old) = &self.old {
            keep_rights(&self.file, old);
        }
        // Network file systems report a full disk only now.
        self.file.sync_data()?;
        temporary.rename(&self.to)
        // The lock of the file ends here, when nobody can take it for a leftover any more.
    }
}

/// The path from the root, without links, of the file that [`write_atomic`] replaces or makes. The file need not exist,
/// also not behind a link.
///
/// # Errors
/// Its folder does not exist or may not be searched, or its links lead in a circle.
pub fn real_output_path(path: &Path) -> Result<PathBuf, FileError> {
    behind_links(path).map_err(|error| FileError::writing(path, &error))
}

fn behind_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    loop {
        match fs::canonicalize(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            // A circle of links ends here.
            found => return found,
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = fs::canonicalize(folder)?;
        match fs::read_link(&path) {
            Ok(target) => path = folder.join(target),
            Err(_) => return Ok(folder.join(path.file_name().ok_or(io::ErrorKind::IsADirectory)?)),
        }
    }
}

/// A file that is removed when dropped, unless it was renamed.
struct Temporary(Option<PathBuf>);

impl Temporary {
    /// A new file, locked, which another run takes for a leftover otherwise.
    fn beside(path: &Path, old: Option<&Metadata>) -> io::Result<(Self, File)> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        if old.is_some() {
            private(&mut options);
        }
        loop {
            let own = unused_name(path)?;
            let file = match options.open(&own) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            // Another run may lock and remove it before this one has locked it. Some file systems have no locks.
            if !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) && own.exists() {
                return Ok((Self(Some(own)), file));
            }
        }
    }

    fn rename(mut self, to: &Path) -> io::Result<()> {
        match &self.0 {
            Some(from) => fs::rename(from, to)?,
            None => return Ok(()),
        }
        self.0 = None;
        Ok(())
    }
}

fn unused_name(path: &Path) -> io::Result<PathBuf> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let name = path.file_name().ok_or(io::ErrorKind::IsADirectory)?.to_string_lossy();
    // The name itself may already be as long as the file system allows.
    let short: String = name.chars().take(40).collect();
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    Ok(path.with_file_name(format!(".{short}.{}-{count}{ENDING}", process::id())))
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            // An error is already on its way to the user; this one would hide it.
            let _ = fs::remove_file(path);
        }
    }
}

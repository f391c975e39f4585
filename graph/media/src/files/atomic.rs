//! Output files are written whole or not at all: next to the destination first, then renamed. Nothing else in the
//! program writes a file.

use std::fs::{self, File, Metadata, OpenOptions, TryLockError};
use std::io::{self, BufReader, Seek, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::codec::{self, ErrorKind};
use crate::files::leftovers::{ENDING, remove_leftovers};
use crate::files::paths::{real_output_path, replaced};
use crate::files::regular::read_bytes;
use crate::files::rights::{keep_rights, private};
use crate::files::{FileError, run_files};

/// Writes `bytes` to `path`, atomically: after an error the old file is unchanged, and no partial file is left.
/// Symbolic links are followed. Devices and pipes are written to directly, because they cannot be replaced.
///
/// A replaced file keeps its mode and, as far as the system permits it, its owner and its group. Temporary files of
/// killed runs are removed from the folder.
///
/// # Errors
/// The file is an input of the [run](super::run_files), it is read-only or this user may not write it, or writing
/// fails.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    AtomicFile::create(path)?.write_all(bytes)
}

/// As [`write_atomic`], for a file that this run may have read: a corrected text, a cache.
///
/// # Errors
/// As [`write_atomic`], but for inputs.
pub fn rewrite(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    AtomicFile::open(path, true)?.write_all(bytes)
}

/// Writes an image as [`write_atomic`] writes a file, after its headers are read back.
pub(super) fn write_encoded(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let mut file = AtomicFile::create(path)?;
    file.file.write_all(bytes).map_err(|error| file.refused(&error))?;
    file.finish_image()
}

/// A file that is written in parts, as [`write_atomic`] writes one at once. It is at its place when it is
/// [finished](Self::finish); dropped before, it leaves nothing.
pub struct AtomicFile {
    file: File,
    /// `None` for a device or a pipe, which cannot be replaced.
    temporary: Option<Temporary>,
    /// The name that the user gave.
    name: PathBuf,
    /// The file that is replaced or made.
    to: PathBuf,
    old: Option<Metadata>,
    /// True if it may be a file that the run has read.
    is_own: bool,
}

impl AtomicFile {
    /// Begins a file.
    ///
    /// # Errors
    /// As [`write_atomic`].
    pub fn create(path: &Path) -> Result<Self, FileError> {
        Self::open(path, false)
    }

    fn open(path: &Path, is_own: bool) -> Result<Self, FileError> {
        if !is_own {
            run_files::check_output(path)?;
        }
        let name = path.to_owned();
        let old = replaced(path)?;
        if old.as_ref().is_some_and(|meta| !meta.is_file()) {
            let file = File::options().write(true).open(path).map_err(|error| FileError::writing(path, &error))?;
            return Ok(Self { file, temporary: None, to: name.clone(), name, old: None, is_own });
        }
        let to = real_output_path(path)?;
        remove_leftovers(&to);
        let (temporary, file) = Temporary::beside(&to, old.as_ref()).map_err(|error| match error.kind() {
            // The folder is there: those that the kernel makes take no files.
            io::ErrorKind::NotFound => {
                FileError::new(path, ErrorKind::Naming, "no file can be made in this folder").hint("choose another one")
            }
            _ => FileError::writing(path, &error),
        })?;
        Ok(Self { file, temporary: Some(temporary), name, to, old, is_own })
    }

    /// The file, to be written.
    ///
    /// # Errors
    /// The system has no handle for it.
    pub fn handle(&self) -> Result<File, FileError> {
        self.file.try_clone().map_err(|error| FileError::writing(&self.name, &error))
    }

    /// Begins a file that another program writes to the path that is returned.
    ///
    /// # Errors
    /// As [`write_atomic`]; and a device or a pipe.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn for_program(path: &Path) -> Result<(Self, PathBuf), FileError> {
        let file = Self::open(path, false)?;
        let temporary = file.temporary.as_ref().and_then(|temporary| temporary.0.clone());
        let place = temporary.ok_or_else(|| {
            FileError::new(path, ErrorKind::Naming, "another program writes this file, and no device or pipe")
        })?;
        Ok((file, place))
    }

    fn write_all(mut self, bytes: &[u8]) -> Result<(), FileError> {
        self.file.write_all(bytes).map_err(|error| self.refused(&error))?;
        self.finish()
    }

    fn refused(&self, error: &io::Error) -> FileError {
        match self.temporary {
            Some(_) => FileError::writing(&self.name, error),
            None => {
                FileError::new(&self.name, ErrorKind::Machine, format!("this device or pipe takes no more: {error}"))
            }
        }
    }

    /// Syncs the file and renames it to its destination.
    ///
    /// # Errors
    /// As [`write_atomic`].
    pub fn finish(self) -> Result<(), FileError> {
        // It may have become an input since it was begun.
        if !self.is_own && self.temporary.is_some() {
            run_files::check_output(&self.name)?;
        }
        let name = self.name.clone();
        self.replace().map_err(|error| FileError::writing(&name, &error))
    }

    /// Finishes an image if its headers can be read back.
    ///
    /// # Errors
    /// As [`write_atomic`], and an image that could not be read: the file that was there stays.
    pub(super) fn finish_image(mut self) -> Result<(), FileError> {
        if self.temporary.is_some() {
            self.file.rewind().map_err(|error| FileError::writing(&self.name, &error))?;
            codec::check(BufReader::new(&self.file)).map_err(|error| {
                let what = format!("the image was written, but cannot be read again: {}", error.message);
                FileError::new(&self.name, ErrorKind::Machine, what)
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

/// Writes files that do not exist yet into a folder, all of them or none, with the folders that they need. A file
/// that already has the same content is left. Returns whether each is new.
///
/// # Errors
/// There is another file of that name, or a link on the way to it; writing fails.
pub fn write_new(folder: &Path, files: &[(PathBuf, Vec<u8>)]) -> Result<Vec<bool>, FileError> {
    let mut are_new = Vec::new();
    for (name, bytes) in files {
        are_new.push(is_new(folder, name, bytes)?);
    }
    let mut made = Made::default();
    for ((name, bytes), is_new) in files.iter().zip(&are_new) {
        if *is_new {
            made.file(folder, name, bytes)?;
        }
    }
    made.is_whole = true;
    Ok(are_new)
}

/// True if a file is not there yet. Refuses links below the folder, which may lead anywhere, and other files.
fn is_new(folder: &Path, name: &Path, bytes: &[u8]) -> Result<bool, FileError> {
    let path = folder.join(name);
    for part in name.ancestors().skip(1).filter(|part| !part.as_os_str().is_empty()) {
        let part = folder.join(part);
        if part.is_symlink() {
            return Err(FileError::new(&path, ErrorKind::Naming, format!("`{}` is a link", part.display()))
                .hint("choose another folder: new files are not written through links"));
        }
    }
    match fs::symlink_metadata(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(true),
        Err(error) => Err(FileError::writing(&path, &error)),
        Ok(meta) if meta.is_file() && meta.len() == bytes.len() as u64 && read_bytes(&path, meta.len())? == bytes => {
            Ok(false)
        }
        Ok(_) => Err(FileError::new(&path, ErrorKind::Naming, "this file exists, and is not replaced by a new one")
            .hint("choose another name or another folder")),
    }
}

/// New files and folders, which are removed when dropped unless all are made.
#[derive(Default)]
struct Made {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
    is_whole: bool,
}

impl Made {
    fn file(&mut self, folder: &Path, name: &Path, bytes: &[u8]) -> Result<(), FileError> {
        let path = folder.join(name);
        let parts: Vec<&Path> = name.ancestors().skip(1).filter(|part| !part.as_os_str().is_empty()).collect();
        for part in parts.into_iter().rev().map(|part| folder.join(part)) {
            match fs::create_dir(&part) {
                Ok(()) => self.folders.push(part),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(FileError::writing(&part, &error)),
            }
        }
        place_new(&path, bytes).map_err(|error| FileError::writing(&path, &error))?;
        self.files.push(path);
        Ok(())
    }
}

fn place_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (temporary, mut file) = Temporary::beside(path, None)?;
    file.write_all(bytes)?;
    file.sync_data()?;
    temporary.place_new(path)
}

impl Drop for Made {
    fn drop(&mut self) {
        if !self.is_whole {
            // An error is already on its way to the user.
            self.files.iter().for_each(|file| drop(fs::remove_file(file)));
            self.folders.iter().rev().for_each(|folder| drop(fs::remove_dir(folder)));
        }
    }
}

/// A file that is removed when dropped, unless it was renamed.
struct Temporary(Option<PathBuf>);

impl Temporary {
    /// Creates and locks a file. The lock keeps other runs from taking it for a leftover.
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

    /// Renames the file to a name that does not exist yet.
    fn place_new(&self, to: &Path) -> io::Result<()> {
        let Some(from) = &self.0 else { return Ok(()) };
        match fs::hard_link(from, to) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
            // Some file systems have no links.
            Err(_) if to.symlink_metadata().is_err() => fs::rename(from, to),
            placed => placed,
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

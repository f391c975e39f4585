//! Output files are written whole or not at all: beside the destination first, then renamed.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::files::FileError;

/// Writes `bytes` to `path`. Whatever fails, the file that was there before stays as it was and
/// nothing half written is left. Through a symbolic link the file behind it is replaced; devices
/// and pipes are written to directly, as they cannot be replaced.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_with_io_errors(path, bytes).map_err(|error| FileError::writing(path, &error))
}

fn write_with_io_errors(path: &Path, bytes: &[u8]) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(meta) if !meta.is_file() => File::options().write(true).open(path)?.write_all(bytes),
        Ok(_) => replace(&fs::canonicalize(path)?, bytes),
        Err(_) => replace(path, bytes),
    }
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (temporary, mut file) = Temporary::beside(path)?;
    file.write_all(bytes)?;
    // Network file systems report a full disk only now.
    file.sync_data()?;
    drop(file);
    temporary.rename(path)
}

/// A file that is removed when dropped, unless it was renamed.
struct Temporary(Option<PathBuf>);

impl Temporary {
    fn beside(path: &Path) -> io::Result<(Self, File)> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = path.file_name().ok_or(io::ErrorKind::IsADirectory)?.to_string_lossy();
        // The name itself may already be as long as the file system allows.
        let short: String = name.chars().take(40).collect();
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let own = path.with_file_name(format!(".{short}.{}-{count}.part", process::id()));
        let file = OpenOptions::new().write(true).create_new(true).open(&own)?;
        Ok((Self(Some(own)), file))
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

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            // An error is already on its way to the user; this one would hide it.
            let _ = fs::remove_file(path);
        }
    }
}

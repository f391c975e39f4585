//! Image files that are written from the top to the bottom, atomically.

use std::path::{Path, PathBuf};

use super::{AtomicFile, FileError};
use crate::codec::{Encoding, Metadata, RowWriter, Samples, row_writer};

/// An image file that takes rows from the top to the bottom, so that no more than some rows are in memory. Its bytes
/// are those of [`encode`](crate::encode).
pub struct ImageFile {
    file: AtomicFile,
    path: PathBuf,
    rows: Box<dyn RowWriter>,
    notes: Vec<String>,
}

impl ImageFile {
    /// Begins a file of `size` (width, height).
    ///
    /// # Errors
    /// See [`write_atomic`](crate::write_atomic) and [`encode`](crate::encode).
    ///
    /// # Panics
    /// If the encoding [needs all rows](Encoding::needs_all_rows).
    pub fn begin(
        path: &Path,
        size: (u32, u32),
        encoding: &Encoding,
        meta: Option<&Metadata>,
    ) -> Result<Self, FileError> {
        let file = AtomicFile::create(path)?;
        let writer = row_writer(Box::new(file.handle()?), size, encoding, meta);
        let (rows, notes) = writer.map_err(|error| FileError::at(path, error))?;
        Ok(Self { file, path: path.to_owned(), rows, notes })
    }

    /// Sentences about what is left out.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Writes the next rows.
    ///
    /// # Errors
    /// Writing fails, or there is no memory for codes.
    ///
    /// # Panics
    /// If rows of an EXR have another type than those before.
    pub fn write(&mut self, rows: Samples<'_>) -> Result<(), FileError> {
        self.rows.write(rows).map_err(|error| FileError::at(&self.path, error))
    }

    /// Puts the file at its place.
    ///
    /// # Errors
    /// Writing fails; see [`write_atomic`](crate::write_atomic).
    ///
    /// # Panics
    /// If an EXR file lacks rows.
    pub fn finish(self) -> Result<(), FileError> {
        self.rows.finish().map_err(|error| FileError::at(&self.path, error))?;
        self.file.finish_image()
    }
}

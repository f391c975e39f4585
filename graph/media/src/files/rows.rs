//! Files that are written from the top to the bottom, atomically.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::{AtomicFile, FileError};
use crate::codec::{
    CodecError, EncodedPixels, ExrOptions, ExrRows, JpegOptions, JpegRows, Metadata, Pixels, PngOptions, PngRows,
};

/// How an image is written row by row.
pub enum RowsOptions {
    /// A PNG.
    Png(PngOptions),
    /// A JPEG.
    Jpeg(JpegOptions),
    /// An EXR that states what the metadata does.
    Exr(ExrOptions, Box<Metadata>),
}

impl RowsOptions {
    /// Rows that are packed together.
    pub fn block_rows(&self) -> u32 {
        match self {
            Self::Png(_) | Self::Jpeg(_) => 1,
            Self::Exr(options, _) => options.compression.block_rows(),
        }
    }
}

/// A file that rows are written to, from the top to the bottom.
pub struct RowsFile {
    file: AtomicFile,
    path: PathBuf,
    rows: Rows,
}

enum Rows {
    Png(Box<PngRows<File>>),
    Jpeg(Box<JpegRows>),
    Exr(Box<ExrRows<File>>),
}

impl RowsFile {
    /// Begins a file of `size` (width, height).
    ///
    /// # Errors
    /// See [`write_atomic`](crate::write_atomic), [`PngRows::new`], [`JpegRows::new`] and [`ExrRows::new`].
    ///
    /// # Panics
    /// As [`PngRows::new`].
    pub fn begin(path: &Path, size: (u32, u32), options: &RowsOptions) -> Result<Self, FileError> {
        let file = AtomicFile::create(path)?;
        let to = file.handle()?;
        let rows = match options {
            RowsOptions::Png(options) => PngRows::new(to, size, options).map(|rows| Rows::Png(Box::new(rows))),
            RowsOptions::Jpeg(options) => JpegRows::new(to, size, options).map(|rows| Rows::Jpeg(Box::new(rows))),
            RowsOptions::Exr(options, meta) => {
                ExrRows::new(to, size, meta, options).map(|rows| Rows::Exr(Box::new(rows)))
            }
        };
        let rows = rows.map_err(|error| FileError::at(path, error))?;
        Ok(Self { file, path: path.to_owned(), rows })
    }

    /// Whether it holds encoded pictures, and not light.
    pub fn is_encoded(&self) -> bool {
        !matches!(self.rows, Rows::Exr(_))
    }

    /// Sentences about attributes that are left out.
    pub fn notes(&self) -> &[String] {
        if let Rows::Exr(rows) = &self.rows { rows.notes() } else { &[] }
    }

    /// Writes the next rows of an encoded picture.
    ///
    /// # Errors
    /// See [`PngRows::write`] and [`JpegRows::write`].
    ///
    /// # Panics
    /// If the file holds light.
    pub fn write_encoded(&mut self, pixels: EncodedPixels<'_>) -> Result<(), FileError> {
        let written = match &mut self.rows {
            Rows::Png(rows) => rows.write(pixels),
            Rows::Jpeg(rows) => rows.write(pixels),
            Rows::Exr(_) => panic!("an EXR file holds light"),
        };
        self.located(written)
    }

    /// Writes the next rows of light.
    ///
    /// # Errors
    /// See [`ExrRows::write`].
    ///
    /// # Panics
    /// If the file holds an encoded picture, and as [`ExrRows::write`].
    pub fn write_light(&mut self, pixels: Pixels) -> Result<(), FileError> {
        let written = match &mut self.rows {
            Rows::Exr(rows) => rows.write(pixels),
            _ => panic!("only an EXR file holds light"),
        };
        self.located(written)
    }

    /// Puts the file at its place.
    ///
    /// # Errors
    /// What writing reports; see [`write_atomic`](crate::write_atomic).
    ///
    /// # Panics
    /// If an EXR file lacks rows.
    pub fn finish(self) -> Result<(), FileError> {
        let finished = match self.rows {
            Rows::Png(rows) => rows.finish(),
            Rows::Jpeg(rows) => rows.finish(),
            Rows::Exr(rows) => rows.finish(),
        };
        finished.map_err(|error| FileError::at(&self.path, error))?;
        self.file.finish_image()
    }

    fn located(&self, written: Result<(), CodecError>) -> Result<(), FileError> {
        written.map_err(|error| FileError::at(&self.path, error))
    }
}

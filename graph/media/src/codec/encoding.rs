//! The interface between images and the writers of formats.

use std::io::{Cursor, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use afterimage_base::color::{Chromaticities, Colorimetry};

use crate::codec::{CodecError, ExrCompression, ImageFormat, Metadata, Picture, Samples};

/// Properties of a file to be written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoding {
    /// The format of the file.
    pub format: ImageFormat,
    /// Bits of a channel: one of [`ImageFormat::depths`].
    pub bits: u32,
    /// Seed of the dither to 8-bit codes; `None` rounds to the nearest code. Alpha and codes of 16 bits are rounded.
    pub dither: Option<u32>,
    /// The condition for writing alpha. A JPEG has none. In a PNG it is straight.
    pub alpha: Alpha,
    /// True if colors are multiplied by their alpha, as in a pipeline. For a PNG with alpha they are divided by it, and
    /// then clipped to white; they are black where alpha is 0.
    pub premultiplied: bool,
    /// The meaning of the numbers, which the file states; `None` for data.
    pub color: Option<Colorimetry>,
    /// Quality of a JPEG, 1 to 100: of the quantization tables of libjpeg.
    pub quality: u8,
    /// Compression of an EXR.
    pub compression: ExrCompression,
    /// Primaries of an EXR, to which pixels are converted; those of `color` if `None`.
    pub primaries: Option<Chromaticities>,
    /// True if the color of an EXR is scene-linear: then `colorInteropID` names the primaries, if they have a name.
    pub scene: bool,
}

/// The condition for writing the alpha of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Alpha {
    /// Always.
    Keep,
    /// If it is not 1 in all pixels. For EXR: always.
    #[default]
    WhereNeeded,
    /// Never.
    Drop,
}

impl Encoding {
    /// 8-bit sRGB without alpha, dithered with seed 0.
    pub const PNG: Self = Self {
        format: ImageFormat::Png,
        bits: 8,
        dither: Some(0),
        alpha: Alpha::Drop,
        premultiplied: true,
        color: Some(Colorimetry::SRGB),
        quality: 92,
        compression: ExrCompression::Zip,
        primaries: None,
        scene: false,
    };

    /// sRGB of quality 92 and full color resolution, dithered with seed 0.
    pub const JPEG: Self = Self { format: ImageFormat::Jpeg, ..Self::PNG };

    /// Half floats with alpha, ZIP, linear Rec.709.
    pub const EXR: Self = Self {
        format: ImageFormat::Exr,
        bits: 16,
        alpha: Alpha::Keep,
        color: Some(Colorimetry::linear(Chromaticities::REC709)),
        ..Self::PNG
    };

    /// Returns whether the file holds codes of a transfer function; otherwise it holds linear color or data in floats.
    pub fn has_codes(&self) -> bool {
        self.format.is_encoded() && !(self.format == ImageFormat::Tiff && self.bits == 32)
    }

    /// Returns whether the first bytes of the file depend on all pixels: an HDR PNG states its content light level, and
    /// [`Alpha::WhereNeeded`] is decided by all of them.
    pub fn needs_all_rows(&self) -> bool {
        let is_hdr = self.color.is_some_and(|color| color.is_hdr());
        match self.format {
            ImageFormat::Png => self.alpha == Alpha::WhereNeeded || is_hdr,
            ImageFormat::Tiff => self.alpha == Alpha::WhereNeeded,
            _ => false,
        }
    }

    /// Rows that are compressed together.
    pub fn block_rows(&self) -> u32 {
        if self.format == ImageFormat::Exr { self.compression.block_rows() } else { 1 }
    }
}

/// An image to be written.
#[derive(Debug, Clone, Copy)]
pub struct Image<'a> {
    /// Width and height.
    pub size: (u32, u32),
    /// `width` × `height` × 4 samples.
    pub samples: Samples<'a>,
    /// Attributes for an EXR file.
    pub meta: Option<&'a Metadata>,
    /// For a JPEG of an SDR image: the HDR image of the same size to which its gain map leads, encoded as PQ.
    pub hdr: Option<(Samples<'a>, Colorimetry)>,
}

impl<'a> From<((u32, u32), Samples<'a>)> for Image<'a> {
    fn from((size, samples): ((u32, u32), Samples<'a>)) -> Self {
        Self { size, samples, meta: None, hdr: None }
    }
}

impl<'a> From<&'a Picture> for Image<'a> {
    fn from(picture: &'a Picture) -> Self {
        let size = (picture.width, picture.height);
        Self { size, samples: Samples::from(&picture.pixels), meta: Some(&picture.meta), hdr: None }
    }
}

/// Writes the rows of an image file from the top to the bottom, with some rows in memory.
pub trait RowWriter: Send {
    /// Writes the next rows.
    ///
    /// # Errors
    /// Writing fails, or there is no memory for codes.
    fn write(&mut self, rows: Samples<'_>) -> Result<(), CodecError>;

    /// Writes what follows the last row.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    ///
    /// # Panics
    /// If rows are missing.
    fn finish(self: Box<Self>) -> Result<(), CodecError>;
}

/// The place that a [`RowWriter`] writes to.
pub trait Sink: Write + Seek + Send {}

impl<T: Write + Seek + Send> Sink for T {}

#[derive(Clone, Default)]
pub(crate) struct Buffer(Arc<Mutex<Cursor<Vec<u8>>>>);

impl Buffer {
    fn lock(&self) -> MutexGuard<'_, Cursor<Vec<u8>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        std::mem::take(&mut *self.lock()).into_inner()
    }
}

impl Write for Buffer {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.lock().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Buffer {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.lock().seek(to)
    }
}

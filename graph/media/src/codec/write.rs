//! Pixels to the bytes of an image file: the [`RowWriter`] of each format, and [`encode`], which passes it all rows.

use crate::codec::encoding::{Buffer, Encoding, Image, RowWriter, Sink};
use crate::codec::exr::ExrRows;
use crate::codec::jpeg::{JpegRows, gain_map};
use crate::codec::limits::check_size;
use crate::codec::png::{self, PngRows};
use crate::codec::tiff::{self, TiffRows};
use crate::codec::{CodecError, ErrorKind, ImageFormat, Metadata};

/// Writes the beginning of a file. Returns the writer of its rows, and sentences about what is left out.
///
/// # Errors
/// The format cannot hold such an image, or writing fails.
///
/// # Panics
/// If the encoding [needs all rows](Encoding::needs_all_rows).
pub fn row_writer(
    to: Box<dyn Sink>,
    size: (u32, u32),
    encoding: &Encoding,
    meta: Option<&Metadata>,
) -> Result<(Box<dyn RowWriter>, Vec<String>), CodecError> {
    assert!(!encoding.needs_all_rows(), "the first bytes depend on all pixels");
    check_depth(encoding)?;
    let other_aspect = || meta.and_then(Metadata::other_aspect).into_iter().collect();
    match encoding.format {
        ImageFormat::Exr => {
            let (rows, notes) = ExrRows::new(to, size, meta, encoding)?;
            Ok((Box::new(rows), notes))
        }
        ImageFormat::Png => Ok((Box::new(PngRows::new(to, size, encoding, None)?), other_aspect())),
        ImageFormat::Jpeg => Ok((Box::new(JpegRows::new(to, size, encoding)?), other_aspect())),
        ImageFormat::Tiff => Ok((Box::new(TiffRows::new(to, size, encoding)?), other_aspect())),
        _ => unreachable!("the format has no depth"),
    }
}

/// Refuses a depth that the format lacks, and a format that is read only.
fn check_depth(encoding: &Encoding) -> Result<(), CodecError> {
    let Encoding { format, bits, .. } = encoding;
    if format.depths().contains(bits) {
        return Ok(());
    }
    let what = format!("{} files with {bits} bits in a channel are not written", format.name());
    Err(CodecError::new(ErrorKind::Unsupported, what))
}

/// Encodes an image.
///
/// A PNG states `color` by `cICP` where both code points exist, and by `sRGB`, `gAMA` and `cHRM`, or an ICC profile,
/// where these state the same. HDR files also have `mDCV`, from the primaries and the peak, and `cLLI`, from the
/// pixels.
///
/// # Errors
/// An image that is too large; for PNG, `Pq` and `Hlg` with primaries that no chunk states; for JPEG, `Pq`, `Hlg`, and
/// more than 65535 pixels in a row or column.
pub fn encode<'a>(image: impl Into<Image<'a>>, encoding: &Encoding) -> Result<Vec<u8>, CodecError> {
    encode_with_notes(image.into(), encoding).map(|(file, _)| file)
}

/// The file, and sentences about what is left out.
pub(crate) fn encode_with_notes(image: Image<'_>, encoding: &Encoding) -> Result<(Vec<u8>, Vec<String>), CodecError> {
    let Image { size, samples, meta, hdr } = image;
    check_depth(encoding)?;
    if let Some(hdr) = hdr {
        return match encoding.format {
            ImageFormat::Jpeg => {
                let (file, notes) = gain_map::encode(image, hdr, encoding)?;
                Ok((file, meta.and_then(Metadata::other_aspect).into_iter().chain(notes).collect()))
            }
            _ => Err(CodecError::new(ErrorKind::Unsupported, "gain maps are written to JPEG files only")),
        };
    }
    check_size((size.0.into(), size.1.into()), u64::from(encoding.bits / 8))?;
    let file = Buffer::default();
    let to = Box::new(file.clone());
    let (mut writer, notes) = match encoding.format {
        ImageFormat::Png => png::writer_of_image(to, image, encoding)?,
        ImageFormat::Tiff => tiff::writer_of_image(to, image, encoding)?,
        _ => row_writer(to, size, encoding, meta)?,
    };
    writer.write(samples)?;
    writer.finish()?;
    Ok((file.into_bytes(), notes))
}

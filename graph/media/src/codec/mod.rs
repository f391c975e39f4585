//! Images as bytes: [`decode`] turns the bytes of an EXR, Radiance, PNG, JPEG, TIFF or DPX file into a
//! [`Picture`],
//! [`encode`] turns an [`Image`] into bytes. Nothing here uses the file system.

#[cfg(feature = "avif")]
mod avif;
mod chromaticities;
pub(crate) mod cicp;
mod codes;
mod description;
mod dpx;
pub(crate) mod encoding;
mod error;
mod exr;
mod exr_compression;
mod foreign;
mod format;
mod hdr;
pub(crate) mod icc;
mod jpeg;
#[cfg(feature = "jxl")]
mod jxl;
mod light_level;
pub mod limits;
mod metered;
mod orientation;
mod picture;
mod png;
mod quantize;
mod reading;
mod resample;
#[cfg(any(feature = "avif", not(target_family = "wasm")))]
pub(crate) mod signals;
mod space;
mod statistics;
mod tiff;
pub(crate) mod write;

#[cfg(test)]
pub(crate) use chromaticities::{convert, to_rec709};
#[cfg(not(target_family = "wasm"))]
pub(crate) use codes::Colors;

use std::io::{BufRead, Seek, SeekFrom};

pub use afterimage_base::panics::catch_panic;
pub use description::{ChannelDescription, Description, PartDescription, PictureChannels, Window};
pub use encoding::{Alpha, Encoding, Image, RowWriter, Sink};
pub(crate) use error::guarded;
pub use error::{CodecError, ErrorKind};
pub use exr::CameraMatrices;
#[cfg(test)]
pub(crate) use exr::of_attributes;
pub use exr_compression::ExrCompression;
pub use foreign::ForeignFormat;
pub use format::ImageFormat;
pub use limits::Budget;
pub use picture::{Metadata, Picture, Pixels};
pub use png::png_codes;
pub use quantize::Samples;
pub use reading::ReadOptions;
pub use space::ColorSpace;
pub use statistics::ChannelStatistics;
pub(crate) use write::encode_with_notes;
pub use write::{encode, row_writer};

/// Decodes an EXR, Radiance, PNG, JPEG, TIFF or DPX file; the first bytes decide the format. `layer` names a layer, a
/// part or a channel of an EXR file. `options` may be a [`Budget`] alone.
///
/// # Errors
/// Errors of the decoders, a layer of a format without layers, and an encoded `space` for a file of linear color. A
/// panic of a decoder is an error, too.
pub fn decode(
    mut reader: impl BufRead + Seek,
    layer: Option<&str>,
    options: impl Into<ReadOptions>,
) -> Result<Picture, CodecError> {
    let options = &options.into();
    let format = ImageFormat::of_content(&mut reader)?;
    if let Some(space) = options.space.filter(|space| !space.is_linear() && !format.is_encoded()) {
        return Err(not_linear(&space));
    }
    guarded(|| match (format, layer) {
        (ImageFormat::Exr, layer) => exr::decode(reader, layer, options),
        (ImageFormat::Hdr, None) => hdr::decode(reader, options),
        (ImageFormat::Png, None) => png::decode(reader, options),
        (ImageFormat::Jpeg, None) => jpeg::decode(reader, options),
        (ImageFormat::Tiff, None) => tiff::decode(reader, options),
        (ImageFormat::Dpx, None) => dpx::decode(reader, options),
        #[cfg(feature = "jxl")]
        (ImageFormat::Jxl, None) => jxl::decode(reader, options),
        #[cfg(not(feature = "jxl"))]
        (ImageFormat::Jxl, None) => unreachable!("the format is not readable"),
        #[cfg(feature = "avif")]
        (ImageFormat::Avif, None) => avif::decode(reader, options),
        #[cfg(not(feature = "avif"))]
        (ImageFormat::Avif, None) => unreachable!("the format is not readable"),
        (_, Some(layer)) => Err(no_layers(layer)),
    })
}

/// Encodes an EXR file whose picture replaces the one that [`decode`] reads from `original`: all other channels and
/// parts are preserved bit for bit, with the attributes of their parts. Returns the file, and sentences about what is
/// left out.
///
/// Channels keep their names, so the picture takes those of the old one. Where color layers are preserved and
/// `encoding` names no primaries, the file has those of the original. Nothing is preserved of a file that is no EXR, or
/// whose data window is not the display window in the size of the picture.
///
/// # Errors
/// As [`decode`] and [`encode`].
pub fn encode_beside<'a>(
    image: impl Into<Image<'a>>,
    encoding: &Encoding,
    mut original: impl BufRead + Seek,
    layer: Option<&str>,
    reading: &ReadOptions,
) -> Result<(Vec<u8>, Vec<String>), CodecError> {
    if ImageFormat::of_content(&mut original)? != ImageFormat::Exr {
        return encode_with_notes(image.into(), encoding);
    }
    guarded(|| exr::encode_beside(image.into(), encoding, original, layer, reading))
}

/// Sentences about what an EXR file has besides the picture that [`decode`] reads, with the reason why it is left out;
/// none for other formats. Only headers are read.
///
/// # Errors
/// As [`decode`], for what it finds in headers.
pub fn exr_left_out(
    mut original: impl BufRead + Seek,
    layer: Option<&str>,
    why: &str,
) -> Result<Vec<String>, CodecError> {
    if ImageFormat::of_content(&mut original)? != ImageFormat::Exr {
        return Ok(Vec::new());
    }
    guarded(|| exr::left_out(original, layer, why))
}

/// The camera that an EXR file states for a layer: `worldToCamera`, `worldToNDC` and, where they are there, `near` and
/// `far`. Only headers are read.
///
/// # Errors
/// Another format, what the decoder reports, and a file that states no camera.
pub fn decode_camera(mut reader: impl BufRead + Seek, layer: Option<&str>) -> Result<CameraMatrices, CodecError> {
    if ImageFormat::of_content(&mut reader)? != ImageFormat::Exr {
        return Err(CodecError::new(ErrorKind::Unsupported, "only EXR files state a camera")
            .hint("write the camera into a JSON file: `--input camera=FILE.json`"));
    }
    guarded(|| exr::camera(reader, layer))
}

/// Describes an image file by its headers. `layer` as in [`decode`].
///
/// # Errors
/// As [`decode`], for what it finds in headers.
pub fn describe(mut reader: impl BufRead + Seek, layer: Option<&str>) -> Result<Description, CodecError> {
    let format = ImageFormat::of_content(&mut reader)?;
    guarded(|| match (format, layer) {
        (ImageFormat::Exr, layer) => exr::describe(reader, layer),
        (ImageFormat::Hdr, None) => hdr::describe(reader),
        (ImageFormat::Png, None) => png::describe(reader),
        (ImageFormat::Jpeg, None) => jpeg::describe(reader),
        (ImageFormat::Tiff, None) => tiff::describe(reader),
        (ImageFormat::Dpx, None) => dpx::describe(reader),
        #[cfg(feature = "jxl")]
        (ImageFormat::Jxl, None) => jxl::describe(reader),
        #[cfg(not(feature = "jxl"))]
        (ImageFormat::Jxl, None) => unreachable!("the format is not readable"),
        #[cfg(feature = "avif")]
        (ImageFormat::Avif, None) => avif::describe(reader),
        #[cfg(not(feature = "avif"))]
        (ImageFormat::Avif, None) => unreachable!("the format is not readable"),
        (_, Some(layer)) => Err(no_layers(layer)),
    })
}

/// Reads the headers of an image that was written, and returns what another reader would refuse, too. A file of another
/// format than [`decode`] reads passes.
pub(crate) fn check(mut reader: impl BufRead + Seek) -> Result<(), CodecError> {
    match ImageFormat::of_content(&mut reader) {
        Ok(ImageFormat::Exr) => guarded(|| exr::check(reader)),
        Ok(_) => describe(reader, None).map(drop),
        Err(error) if error.kind == ErrorKind::Unsupported => Ok(()),
        Err(error) => Err(error),
    }
}

/// Checks that a PNG and a JPEG end as their formats say; decoders forgive that.
pub(crate) fn check_end(mut reader: impl BufRead + Seek, description: &Description) -> Result<(), CodecError> {
    let end: &[u8] = match description.format {
        "PNG" => b"\0\0\0\0IEND\xaeB`\x82",
        "JPEG" => b"\xff\xd9",
        _ => return Ok(()),
    };
    let mut found = Vec::new();
    let read = reader.seek(SeekFrom::End(-(end.len() as i64))).and_then(|_| reader.read_to_end(&mut found));
    read.map_err(|error| CodecError::reading(&error))?;
    if found == end { Ok(()) } else { Err(CodecError::cut_short()) }
}

fn not_linear(space: &ColorSpace) -> CodecError {
    let linear: Vec<&str> = ColorSpace::ALL.iter().filter(|space| space.is_linear()).map(|space| space.name).collect();
    CodecError::new(ErrorKind::Naming, format!("this file holds linear light, and not {}", space.name))
        .hint(format!("name a linear space: {}", linear.join(", ")))
}

/// The statistics of all channels, part by part, in the order of [`describe`]; of files without layers in linear
/// Rec.709.
///
/// # Errors
/// As [`decode`].
pub fn measure(
    mut reader: impl BufRead + Seek,
    description: &Description,
    budget: Budget,
) -> Result<Vec<Vec<ChannelStatistics>>, CodecError> {
    if ImageFormat::of_content(&mut reader)? == ImageFormat::Exr {
        return guarded(|| exr::measure(reader, budget));
    }
    let options = ReadOptions { premultiplied: false, ..budget.into() };
    let picture = decode(reader, None, options)?;
    let names = |part: &PartDescription| part.channels.iter().map(|channel| channel.name.clone()).collect::<Vec<_>>();
    Ok(description.parts.iter().map(|part| statistics::of_picture(&picture, &names(part))).collect())
}

pub(crate) fn no_layers(layer: &str) -> CodecError {
    CodecError::new(ErrorKind::Naming, format!("only EXR files have layers, so `#{layer}` means nothing here"))
        .hint("leave out what follows the file's name")
}

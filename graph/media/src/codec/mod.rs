//! Images as bytes: [`decode`] turns the bytes of an EXR, Radiance, PNG or JPEG file into a [`Picture`],
//! [`encode_exr`], [`encode_png`] and [`encode_jpeg`] turn pixels into bytes.
//! Nothing here uses the file system.

mod chromaticities;
pub(crate) mod cicp;
mod codes;
mod description;
mod error;
mod exr;
mod fit;
mod hdr;
pub(crate) mod icc;
mod jpeg;
mod light_level;
pub mod limits;
mod metered;
mod orientation;
mod picture;
mod png;
mod quantize;
mod reading;
mod space;
mod statistics;

#[cfg(test)]
pub(crate) use chromaticities::{convert, to_rec709};

use std::io::{BufRead, Read as _, Seek, SeekFrom};

pub use afterimage_base::panics::catch_panic;
pub use description::{ChannelDescription, Description, PartDescription, PictureChannels, Window};
pub use error::{CodecError, ErrorKind};
#[cfg(test)]
pub(crate) use exr::of_attributes;
pub use exr::{ExrCompression, ExrOptions, ExrRows, StatedCamera, encode_exr};
pub use jpeg::{JpegOptions, JpegRows, encode_jpeg};
pub use limits::Budget;
pub use picture::{Metadata, Picture, Pixels};
pub use png::{Alpha, PngDepth, PngOptions, PngRows, encode_png, png_codes, png_left_out};
pub use quantize::EncodedPixels;
pub use reading::ReadOptions;
pub use space::ColorSpace;
pub use statistics::ChannelStatistics;

/// Decodes an EXR, Radiance, PNG or JPEG file; the first bytes decide the format. `layer` names a layer, a part or a
/// channel of an EXR file. `options` may be a [`Budget`] alone.
///
/// # Errors
/// What the decoders report, a layer of a format without layers, and an encoded `space` for a file of linear light. A
/// panic of a decoder is an error, too.
pub fn decode(
    mut reader: impl BufRead + Seek,
    layer: Option<&str>,
    options: impl Into<ReadOptions>,
) -> Result<Picture, CodecError> {
    let options = &options.into();
    let format = Format::of(&mut reader)?;
    if let Some(space) = options.space.filter(|space| !space.is_linear() && matches!(format, Format::Exr | Format::Hdr))
    {
        return Err(not_linear(&space));
    }
    let decoded = catch_panic(|| match (format, layer) {
        (Format::Exr, layer) => exr::decode(reader, layer, options),
        (Format::Hdr, None) => hdr::decode(reader, options),
        (Format::Png, None) => png::decode(reader, options),
        (Format::Jpeg, None) => jpeg::decode(reader, options),
        (_, Some(layer)) => Err(no_layers(layer)),
    });
    decoded.unwrap_or_else(|panic| Err(CodecError::broken(panic)))
}

/// Encodes an EXR file whose picture replaces the one that [`decode`] reads from `original`: all other channels and
/// parts are kept bit for bit, with the attributes of their parts. Returns the file, and sentences about what is left
/// out.
///
/// Channels keep their names, so the picture takes those of the old one. Where layers of light are kept and `options`
/// name no primaries, the file has those of the original. Nothing is kept of a file that is no EXR, or whose data
/// window is not the display window in the size of the picture.
///
/// # Errors
/// As [`decode`] and [`encode_exr`].
pub fn encode_exr_beside(
    picture: &Picture,
    options: &ExrOptions,
    mut original: impl BufRead + Seek,
    layer: Option<&str>,
    reading: &ReadOptions,
) -> Result<(Vec<u8>, Vec<String>), CodecError> {
    if !matches!(Format::of(&mut original)?, Format::Exr) {
        return exr::encode(picture, options);
    }
    let encoded = catch_panic(|| exr::encode_beside(picture, options, original, layer, reading));
    encoded.unwrap_or_else(|panic| Err(CodecError::broken(panic)))
}

/// What an EXR file has besides the picture that [`decode`] reads, in sentences with the reason why it is left out;
/// none for other formats. Only headers are read.
///
/// # Errors
/// As [`decode`], for what it finds in headers.
pub fn exr_left_out(
    mut original: impl BufRead + Seek,
    layer: Option<&str>,
    why: &str,
) -> Result<Vec<String>, CodecError> {
    if !matches!(Format::of(&mut original)?, Format::Exr) {
        return Ok(Vec::new());
    }
    catch_panic(|| exr::left_out(original, layer, why)).unwrap_or_else(|panic| Err(CodecError::broken(panic)))
}

/// The camera that an EXR file states for a layer: `worldToCamera`, `worldToNDC` and, where they are there, `near` and
/// `far`. Only headers are read.
///
/// # Errors
/// Another format, what the decoder reports, and a file that states no camera.
pub fn decode_camera(mut reader: impl BufRead + Seek, layer: Option<&str>) -> Result<StatedCamera, CodecError> {
    if !matches!(Format::of(&mut reader)?, Format::Exr) {
        return Err(CodecError::new(ErrorKind::Unsupported, "only EXR files state a camera")
            .hint("write the camera into a JSON file: `--input camera=FILE.json`"));
    }
    let decoded = catch_panic(|| exr::camera(reader, layer));
    decoded.unwrap_or_else(|panic| Err(CodecError::broken(panic)))
}

/// What the headers of an EXR, Radiance, PNG or JPEG file state. `layer` as in [`decode`].
///
/// # Errors
/// As [`decode`], for what it finds in headers.
pub fn describe(mut reader: impl BufRead + Seek, layer: Option<&str>) -> Result<Description, CodecError> {
    let format = Format::of(&mut reader)?;
    let described = catch_panic(|| match (format, layer) {
        (Format::Exr, layer) => exr::describe(reader, layer),
        (Format::Hdr, None) => hdr::describe(reader),
        (Format::Png, None) => png::describe(reader),
        (Format::Jpeg, None) => jpeg::describe(reader),
        (_, Some(layer)) => Err(no_layers(layer)),
    });
    described.unwrap_or_else(|panic| Err(CodecError::broken(panic)))
}

/// Reads the headers of an image that was written, and returns what another reader would refuse, too. A file of another
/// format than [`decode`] reads passes.
pub(crate) fn check(mut reader: impl BufRead + Seek) -> Result<(), CodecError> {
    match Format::of(&mut reader) {
        Ok(Format::Exr) => catch_panic(|| exr::check(reader)).unwrap_or_else(|panic| Err(CodecError::broken(panic))),
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

pub(crate) use exr::encode as encode_exr_with_notes;

fn not_linear(space: &ColorSpace) -> CodecError {
    let linear: Vec<&str> = ColorSpace::ALL.iter().filter(|space| space.is_linear()).map(|space| space.name).collect();
    CodecError::new(ErrorKind::Naming, format!("this file holds linear light, and not {}", space.name))
        .hint(format!("name a linear space: {}", linear.join(", ")))
}

/// The numbers of all channels, part by part, in the order of [`describe`]; for other files as linear light of
/// Rec.709.
///
/// # Errors
/// As [`decode`].
pub fn measure(
    mut reader: impl BufRead + Seek,
    description: &Description,
    budget: Budget,
) -> Result<Vec<Vec<ChannelStatistics>>, CodecError> {
    if let Format::Exr = Format::of(&mut reader)? {
        let measured = catch_panic(|| exr::measure(reader, budget));
        return measured.unwrap_or_else(|panic| Err(CodecError::broken(panic)));
    }
    let options = ReadOptions { premultiplied: false, ..budget.into() };
    let picture = decode(reader, None, options)?;
    let names = |part: &PartDescription| part.channels.iter().map(|channel| channel.name.clone()).collect::<Vec<_>>();
    Ok(description.parts.iter().map(|part| statistics::of_picture(&picture, &names(part))).collect())
}

fn no_layers(layer: &str) -> CodecError {
    CodecError::new(ErrorKind::Naming, format!("only EXR files have layers, so `#{layer}` means nothing here"))
        .hint("leave out what follows the file's name")
}

enum Format {
    Exr,
    Hdr,
    Png,
    Jpeg,
}

impl Format {
    /// The format by its signature; the reader is at its start again afterwards.
    fn of(reader: &mut (impl BufRead + Seek)) -> Result<Self, CodecError> {
        let start = first_bytes(reader).map_err(|error| CodecError::reading(&error))?;
        if start.starts_with(&exr::MAGIC) {
            Ok(Self::Exr)
        } else if start.starts_with(&png::MAGIC) {
            Ok(Self::Png)
        } else if start.starts_with(&jpeg::MAGIC) {
            Ok(Self::Jpeg)
        } else if hdr::MAGICS.iter().any(|magic| start.starts_with(magic)) {
            Ok(Self::Hdr)
        } else if start.is_empty() {
            Err(CodecError::new(ErrorKind::Broken, "the file is empty").hint("copy or render it again"))
        } else {
            Err(unknown_format(&start))
        }
    }
}

fn first_bytes(reader: &mut (impl BufRead + Seek)) -> std::io::Result<Vec<u8>> {
    let mut start = Vec::new();
    reader.by_ref().take(16).read_to_end(&mut start)?;
    reader.rewind()?;
    Ok(start)
}

fn unknown_format(start: &[u8]) -> CodecError {
    const KNOWN: [(&[u8], &str); 5] =
        [(b"II*\0", "a TIFF"), (b"MM\0*", "a TIFF"), (b"GIF8", "a GIF"), (b"SDPX", "a DPX"), (b"XPDS", "a DPX")];
    let found = KNOWN.iter().find(|(magic, _)| start.starts_with(magic));
    let what = found.map_or("not an image that this program knows", |(_, name)| name);
    CodecError::new(ErrorKind::Unsupported, format!("this is {what}"))
        .hint("EXR, Radiance HDR, PNG and JPEG files are read; convert it to one of them")
}

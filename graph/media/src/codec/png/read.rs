//! PNG to linear Rec.709.

use std::io::{BufRead, Seek};

use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};

use super::chunks;
use super::colors::colors;
use crate::codec::codes::{Alpha, Codes};
use crate::codec::limits::{MAX_PNG_EXTRAS, too_large, zeroed};
use crate::codec::orientation::Orientation;
use crate::codec::{CodecError, Description, Picture, ReadOptions};

/// Decodes a PNG to linear color. The first of `cICP`, `iCCP`, `sRGB`, and `gAMA` with `cHRM` that is understood is
/// applied; those before it are noted. The straight alpha of the file
/// is multiplied into the color, unless `options` keep it apart. The orientation of
/// an `eXIf` chunk before the pixels is applied.
pub(crate) fn decode(reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let (chunks, rest) = chunks::read(reader)?;
    let mut decoder = Decoder::new_with_limits(rest, Limits { bytes: MAX_PNG_EXTRAS });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    let header = decoder.read_header_info().map_err(|error| explain(&error))?;
    let (width, height) = (header.width, header.height);
    options.budget.check((width.into(), height.into()), 2, 0)?;
    let mut reader = decoder.read_info().map_err(|error| explain(&error))?;
    let (color_type, depth) = reader.output_color_type();
    let has_alpha = matches!(color_type, ColorType::GrayscaleAlpha | ColorType::Rgba);
    let channels = color_type.samples();
    let colors = colors(&chunks, channels - usize::from(has_alpha), options.space);
    let size = reader.output_buffer_size().ok_or_else(|| CodecError::broken("no size"))?;
    let bits = if depth == BitDepth::Sixteen { 16 } else { 8 };
    let orientation = chunks.exif.as_deref().and_then(Orientation::of_exif);
    let turned = if orientation.is_some() { 8 * u64::from(width) * u64::from(height) } else { 0 };
    options.budget.check((width.into(), height.into()), colors.bytes_of_sample(bits), size as u64 + turned)?;
    let mut bytes = zeroed(size)?;
    reader.next_frame(&mut bytes).map_err(|error| explain(&error))?;
    let alpha = if !has_alpha {
        Alpha::None
    } else if options.premultiplied {
        Alpha::Premultiply
    } else {
        Alpha::Apart
    };
    let codes = Codes { bytes, bits, channels, alpha, pixels: width as usize * height as usize };
    codes.into_picture([width, height], colors, orientation)
}

/// Describes a file by the chunks before the pixels.
pub(crate) fn describe(reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let (chunks, rest) = chunks::read(reader)?;
    let decoder = Decoder::new_with_limits(rest, Limits { bytes: MAX_PNG_EXTRAS });
    let reader = decoder.read_info().map_err(|error| explain(&error))?;
    let info = reader.info();
    let is_gray = matches!(info.color_type, ColorType::Grayscale | ColorType::GrayscaleAlpha);
    let mut colors = colors(&chunks, if is_gray { 1 } else { 3 }, None);
    let orientation = chunks.exif.as_deref().and_then(Orientation::of_exif);
    colors.notes.extend(orientation.map(Orientation::note));
    let names: &[&str] = match info.color_type {
        ColorType::Grayscale => &["Y"],
        ColorType::GrayscaleAlpha => &["Y", "A"],
        ColorType::Rgb => &["R", "G", "B"],
        ColorType::Rgba => &["R", "G", "B", "A"],
        ColorType::Indexed if info.trns.is_some() => &["R", "G", "B", "A"],
        ColorType::Indexed => &["R", "G", "B"],
    };
    let samples = if info.bit_depth == BitDepth::Sixteen { "16 bits" } else { "8 bits" };
    let size = orientation.unwrap_or(Orientation::UPRIGHT).size(info.width, info.height);
    Ok(colors.describe(Description::of_picture("PNG", size, names, samples, "deflate")))
}

fn explain(error: &DecodingError) -> CodecError {
    match error {
        DecodingError::IoError(error) => CodecError::reading(error),
        DecodingError::LimitsExceeded => too_large("decoding it needs too much memory"),
        other => CodecError::broken(other),
    }
}

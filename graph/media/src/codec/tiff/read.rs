//! TIFF to linear Rec.709.

use std::io::{BufRead, Seek};

use half::f16;
use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use crate::codec::codes::{Alpha, Codes, Colors};
use crate::codec::limits::{MAX_PNG_EXTRAS, too_large};
use crate::codec::orientation::Orientation;
use crate::codec::{CodecError, ColorSpace, Description, ErrorKind, Picture, Pixels, ReadOptions, icc};

/// The values of `ExtraSamples`.
const STRAIGHT_ALPHA: u16 = 2;

/// Decodes the first picture of a TIFF to linear color. Integers are codes of the ICC profile, or of sRGB; floats are
/// linear color, or signals of a profile of primaries and a curve. Straight alpha is multiplied into the color, unless
/// `options` keep it apart.
pub(crate) fn decode(reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let (mut decoder, header) = open(reader, options.budget.0)?;
    let Header { width, height, channels, has_alpha, is_straight, is_float, orientation, .. } = header;
    let colors = colors(&mut decoder, &header, options.space)?;
    let pixels = width as usize * height as usize;
    let extra = (pixels * channels) as u64 * u64::from(header.bits.div_ceil(8)) * 2;
    let turned = if orientation.is_some() { 16 * pixels as u64 } else { 0 };
    options.budget.check((width.into(), height.into()), 4, extra + turned)?;
    let mut read = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut read).map_err(|error| explain(&error))?;
    if read.as_buffer(0).as_bytes().len() < layout.complete_len {
        return Err(too_large("decoding it needs too much memory"));
    }
    // One plane after another, or all samples of a pixel together.
    let planes = layout.planes.max(1);
    if is_float {
        let values = floats(read)?;
        return light(&values, planes, &header, colors, options);
    }
    let bytes = match read {
        DecodingResult::U8(codes) => codes,
        DecodingResult::U16(codes) => codes.iter().flat_map(|code| code.to_be_bytes()).collect(),
        _ => return Err(other_samples(header.bits)),
    };
    let bytes = if planes > 1 { interleaved(&bytes, channels, header.bits as usize / 8) } else { bytes };
    let alpha = match (has_alpha, is_straight && options.premultiplied) {
        (false, _) => Alpha::None,
        (true, true) => Alpha::Premultiply,
        (true, false) => Alpha::Apart,
    };
    Codes { bytes, bits: header.bits, channels, alpha, pixels }.into_picture([width, height], colors, orientation)
}

/// Describes the first picture by its directory.
pub(crate) fn describe(reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let (mut decoder, header) = open(reader, u64::MAX)?;
    let mut colors = colors(&mut decoder, &header, None)?;
    let Header { width, height, orientation, .. } = header;
    let size = orientation.unwrap_or(Orientation::UPRIGHT).size(width, height);
    colors.notes.extend(orientation.map(Orientation::note));
    let names: &[&str] = match (header.channels, header.has_alpha) {
        (1, _) => &["Y"],
        (2, _) => &["Y", "A"],
        (3, _) => &["R", "G", "B"],
        (_, true) => &["R", "G", "B", "A"],
        (_, false) => &["C", "M", "Y", "K"],
    };
    let samples = match (header.is_float, header.bits) {
        (true, 16) => "half",
        (true, _) => "float",
        (false, 9..) => "16 bits",
        (false, _) => "8 bits",
    };
    let compression: Option<u16> = decoder.find_tag_unsigned(Tag::Compression).map_err(|error| explain(&error))?;
    let compression = match compression {
        None | Some(1) => "none",
        Some(5) => "LZW",
        Some(8 | 32946) => "deflate",
        Some(32773) => "PackBits",
        Some(_) => "another one",
    };
    let mut description = colors.describe(Description::of_picture("TIFF", size, names, samples, compression));
    let (across, down) = decoder.chunk_dimensions();
    let is_tiled = decoder.get_chunk_type() == ChunkType::Tile;
    description.parts[0].tiles = is_tiled.then_some([across.into(), down.into()]);
    if header.is_float && description.stated_by.is_none() {
        description.color = None;
    }
    Ok(description)
}

/// The layout of the pixels, from the directory.
struct Header {
    width: u32,
    height: u32,
    /// Samples of a pixel.
    channels: usize,
    has_alpha: bool,
    is_straight: bool,
    is_float: bool,
    bits: u32,
    is_printed: bool,
    orientation: Option<Orientation>,
    notes: Vec<String>,
}

fn open<R: BufRead + Seek>(reader: R, budget: u64) -> Result<(Decoder<R>, Header), CodecError> {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = usize::try_from(budget).unwrap_or(usize::MAX);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    limits.ifd_value_size = MAX_PNG_EXTRAS;
    let mut decoder = Decoder::new(reader).map_err(|error| explain(&error))?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(|error| explain(&error))?;
    let color = decoder.colortype().map_err(|error| explain(&error))?;
    let (channels, has_alpha, is_printed) = match color {
        ColorType::Gray(_) => (1, false, false),
        ColorType::GrayA(_) => (2, true, false),
        ColorType::RGB(_) => (3, false, false),
        ColorType::RGBA(_) => (4, true, false),
        ColorType::CMYK(_) => (4, false, true),
        other => return Err(unsupported(&format!("{other:?}"))),
    };
    let mut numbers = |tag| decoder.find_tag_unsigned_vec::<u16>(tag).map_err(|error| explain(&error));
    let is_float = numbers(Tag::SampleFormat)?.is_some_and(|formats| formats.first() == Some(&3));
    let is_straight = numbers(Tag::ExtraSamples)?.is_some_and(|extra| extra.first() == Some(&STRAIGHT_ALPHA));
    let orientation = numbers(Tag::Orientation)?.and_then(|stated| Orientation::of_code(*stated.first()?));
    let bits = u32::from(color.bit_depth());
    if !matches!((is_float, bits), (true, 16 | 32) | (false, 8 | 16)) {
        return Err(other_samples(bits));
    }
    let smaller: Option<u32> = decoder.find_tag_unsigned(Tag::NewSubfileType).map_err(|error| explain(&error))?;
    if smaller == Some(1) {
        return Err(unsupported("its first picture is a small copy of another one"));
    }
    let planes: Option<u16> = decoder.find_tag_unsigned(Tag::PlanarConfiguration).map_err(|error| explain(&error))?;
    if planes == Some(2) && decoder.get_chunk_type() == ChunkType::Tile {
        return Err(unsupported("each channel has tiles of its own"));
    }
    let mut notes = Vec::new();
    if decoder.more_images() {
        notes.push("it has several pictures; only its first one is read".to_owned());
    }
    Ok((
        decoder,
        Header { width, height, channels, has_alpha, is_straight, is_float, bits, is_printed, orientation, notes },
    ))
}

fn colors(
    decoder: &mut Decoder<impl BufRead + Seek>,
    header: &Header,
    space: Option<ColorSpace>,
) -> Result<Colors, CodecError> {
    let mut notes = header.notes.clone();
    let inks = header.channels - usize::from(header.has_alpha);
    let profile = match space {
        Some(_) if !header.is_printed => None,
        _ => decoder.find_tag(Tag::IccProfile).map_err(|error| explain(&error))?,
    };
    let read = profile.and_then(|profile| profile.into_u8_vec().ok()).map(|bytes| icc::read(&bytes, inks));
    let profile =
        read.and_then(|read| read.map_err(|why| notes.push(format!("its ICC profile is not applied: {why}"))).ok());
    let mut colors = match (profile, space) {
        (Some(profile), _) if !header.is_float => Colors::of_profile(profile).stated_by("ICC profile"),
        (Some(icc::Profile::Space(primaries, transfer)), _) => {
            Colors::new(Some((primaries, transfer)), None).stated_by("ICC profile")
        }
        (Some(_), _) => {
            notes.push("its ICC profile is not applied to floats: it is no space of primaries and a curve".to_owned());
            linear(ColorSpace::ALL[0])
        }
        (None, Some(space)) => Colors::new(Some((space.primaries, space.transfer)), None),
        (None, None) if header.is_float => linear(ColorSpace::ALL[0]),
        (None, None) if header.is_printed => {
            let what = "this TIFF is for a printer (CMYK), without a profile that states its colors";
            return Err(CodecError::new(ErrorKind::Unsupported, what).hint("save it again in RGB"));
        }
        (None, None) => Colors::new(None, None),
    };
    colors.notes = notes;
    Ok(colors)
}

fn linear(space: ColorSpace) -> Colors {
    let mut colors = Colors::new(Some((space.primaries, space.transfer)), None);
    colors.stated = None;
    colors
}

fn floats(read: DecodingResult) -> Result<Vec<f32>, CodecError> {
    match read {
        DecodingResult::F32(values) => Ok(values),
        DecodingResult::F16(values) => Ok(values.into_iter().map(f16::to_f32).collect()),
        _ => Err(other_samples(64)),
    }
}

/// The picture of floats.
fn light(
    values: &[f32],
    planes: usize,
    header: &Header,
    colors: Colors,
    options: &ReadOptions,
) -> Result<Picture, CodecError> {
    let Header { width, height, channels, has_alpha, .. } = *header;
    let count = width as usize * height as usize;
    let inks = channels - usize::from(has_alpha);
    let value = |pixel: usize, channel: usize| match planes {
        1 => values[pixel * channels + channel],
        _ => values[channel * count + pixel],
    };
    let mut pixels = crate::codec::limits::filled(4 * count, 1.0_f32)?;
    for (pixel, out) in pixels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        for (channel, out) in out[..3].iter_mut().enumerate() {
            *out = value(pixel, channel.min(inks - 1));
        }
        if has_alpha {
            out[3] = value(pixel, inks);
        }
    }
    colors.decode(&mut pixels);
    if has_alpha && header.is_straight && options.premultiplied {
        for [r, g, b, alpha] in pixels.as_chunks_mut::<4>().0 {
            [r, g, b].into_iter().for_each(|channel| *channel *= *alpha);
        }
    }
    let mut picture = Picture::new(width, height, Pixels::Float(pixels));
    (picture.stated, picture.notes) = (colors.stated, colors.notes);
    if let Some(orientation) = header.orientation {
        picture = orientation.upright(picture);
        picture.notes.push(orientation.note());
    }
    Ok(picture)
}

/// Samples of a pixel together, from one plane after another.
fn interleaved(planes: &[u8], channels: usize, bytes: usize) -> Vec<u8> {
    let plane = planes.len() / channels;
    let samples =
        (0..plane / bytes).flat_map(|pixel| (0..channels).map(move |channel| channel * plane + pixel * bytes));
    samples.flat_map(|at| planes[at..at + bytes].iter().copied()).collect()
}

fn other_samples(bits: u32) -> CodecError {
    unsupported(&format!("{bits} bits in a sample"))
}

fn unsupported(what: &str) -> CodecError {
    CodecError::new(ErrorKind::Unsupported, format!("this TIFF cannot be read: {what}")).hint(
        "save it again in gray, RGB or CMYK of 8 or 16 bits or in floats, such as `oiiotool IN.tif -o OUT.exr`; a raw \
         file of a camera is developed first, by `darktable-cli`",
    )
}

fn explain(error: &TiffError) -> CodecError {
    match error {
        TiffError::IoError(error) => CodecError::reading(error),
        TiffError::LimitsExceeded => too_large("decoding it needs too much memory"),
        TiffError::UnsupportedError(what) => unsupported(&what.to_string()),
        other => CodecError::broken(other),
    }
}

//! PNG to linear Rec.709: halves for 8 bits, which hold every code apart, floats for 16 and for HDR.

use std::io::{BufRead, Seek};

use afterimage_base::color::Colorimetry;
use half::f16;
use png::{BitDepth, ColorType, Decoder, DecodingError, Info, Limits, Transformations};

use super::light::Colors;
use crate::codec::limits::{MAX_PNG_EXTRAS, filled, too_large, zeroed};
use crate::codec::{
    ChannelDescription, CodecError, Description, PartDescription, Picture, PictureChannels, Pixels, ReadOptions, Window,
};

/// The first eight bytes of every PNG.
pub(crate) const MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Decodes a PNG to linear light. `cICP`, `iCCP`, `sRGB`, and `gAMA` with `cHRM` are applied, in this order of
/// priority. A profile that is no matrix with a known curve is ignored, with a note. Alpha is not multiplied in.
pub(crate) fn decode(reader: impl BufRead + Seek, options: &ReadOptions) -> Result<Picture, CodecError> {
    let mut decoder = Decoder::new_with_limits(reader, Limits { bytes: MAX_PNG_EXTRAS });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    let header = decoder.read_header_info().map_err(|error| explain(&error))?;
    let (width, height) = (header.width, header.height);
    options.budget.check((width.into(), height.into()), 2, 0)?;
    let mut reader = decoder.read_info().map_err(|error| explain(&error))?;
    let colors = Colors::of(reader.info(), options.space)?;
    let (color_type, depth) = reader.output_color_type();
    let size = reader.output_buffer_size().ok_or_else(|| CodecError::broken("no size"))?;
    let is_half = depth == BitDepth::Eight && !colors.is_hdr();
    options.budget.check((width.into(), height.into()), if is_half { 2 } else { 4 }, size as u64)?;
    let mut bytes = zeroed(size)?;
    reader.next_frame(&mut bytes).map_err(|error| explain(&error))?;
    let codes = Codes { bytes, depth, channels: color_type.samples(), pixels: width as usize * height as usize };
    let mut picture = Picture::new(width, height, codes.to_light(&colors)?);
    picture.notes = colors.notes;
    picture.stated = colors.stated;
    Ok(picture)
}

/// What the chunks before the pixels state.
pub(crate) fn describe(reader: impl BufRead + Seek) -> Result<Description, CodecError> {
    let mut decoder = Decoder::new_with_limits(reader, Limits { bytes: MAX_PNG_EXTRAS });
    decoder.set_ignore_text_chunk(true);
    let reader = decoder.read_info().map_err(|error| explain(&error))?;
    let info = reader.info();
    let colors = Colors::of(info, None)?;
    let names: &[&str] = match info.color_type {
        ColorType::Grayscale => &["Y"],
        ColorType::GrayscaleAlpha => &["Y", "A"],
        ColorType::Rgb => &["R", "G", "B"],
        ColorType::Rgba => &["R", "G", "B", "A"],
        ColorType::Indexed if info.trns.is_some() => &["R", "G", "B", "A"],
        ColorType::Indexed => &["R", "G", "B"],
    };
    let samples = if info.bit_depth == BitDepth::Sixteen { "16 bits" } else { "8 bits" };
    let window = Window::of_size(info.width, info.height);
    let part = PartDescription {
        name: None,
        display: window,
        data: window,
        channels: names.iter().map(|name| ChannelDescription { name: (*name).to_owned(), samples }).collect(),
        compression: "deflate".to_owned(),
        tiles: None,
    };
    Ok(Description {
        format: "PNG",
        parts: vec![part],
        picture: Some(PictureChannels { part: 0, channels: names.iter().map(|name| (*name).to_owned()).collect() }),
        color: Some(colors.stated.unwrap_or(Colorimetry::SRGB)),
        stated_by: colors.stated.and_then(|_| stating_chunk(info)),
        notes: colors.notes,
    })
}

/// The chunk that states the colors.
fn stating_chunk(info: &Info<'_>) -> Option<&'static str> {
    let chunks = [
        ("cICP", info.coding_independent_code_points.is_some()),
        ("iCCP", info.icc_profile.is_some()),
        ("sRGB", info.srgb.is_some()),
        ("gAMA", info.gama_chunk.is_some()),
        ("cHRM", info.chrm_chunk.is_some()),
    ];
    chunks.into_iter().find(|(_, is_there)| *is_there).map(|(name, _)| name)
}

/// What a PNG stores.
struct Codes {
    bytes: Vec<u8>,
    depth: BitDepth,
    /// Gray, gray and alpha, RGB or RGBA.
    channels: usize,
    pixels: usize,
}

impl Codes {
    fn to_light(&self, colors: &Colors) -> Result<Pixels, CodecError> {
        if self.depth == BitDepth::Eight && !colors.is_hdr() {
            let mut values = filled(self.pixels * 4, f16::ONE)?;
            self.linearize(colors, f16::from_f32, &mut values);
            colors.convert_halves(&mut values);
            return Ok(Pixels::Half(values));
        }
        let mut values = filled(self.pixels * 4, 1.0_f32)?;
        self.linearize(colors, |value| value, &mut values);
        colors.convert(&mut values);
        Ok(Pixels::Float(values))
    }

    fn linearize<T: Copy>(&self, colors: &Colors, to_sample: impl Fn(f32) -> T, out: &mut [T]) {
        if self.depth == BitDepth::Sixteen {
            let (codes, _) = self.bytes.as_chunks::<2>();
            let codes = codes.iter().map(|code| usize::from(u16::from_be_bytes(*code)));
            spread(codes, self.channels, &colors.table(65535), to_sample, out);
        } else {
            let codes = self.bytes.iter().map(|code| usize::from(*code));
            spread(codes, self.channels, &colors.table(255), to_sample, out);
        }
    }
}

/// Spreads gray, gray and alpha, RGB or RGBA codes over RGBA.
fn spread<T: Copy>(
    mut codes: impl Iterator<Item = usize>,
    channels: usize,
    table: &[f32],
    to_sample: impl Fn(f32) -> T,
    out: &mut [T],
) {
    let alpha_scale = 1.0 / (table.len() - 1) as f32;
    let light: Vec<T> = table.iter().map(|value| to_sample(*value)).collect();
    let has_alpha = channels.is_multiple_of(2);
    for pixel in out.as_chunks_mut::<4>().0 {
        let mut next = || codes.next().unwrap_or(0);
        if channels < 3 {
            let gray = light[next()];
            pixel[..3].fill(gray);
        } else {
            pixel[..3].fill_with(|| light[next()]);
        }
        if has_alpha {
            pixel[3] = to_sample(next() as f32 * alpha_scale);
        }
    }
}

fn explain(error: &DecodingError) -> CodecError {
    match error {
        DecodingError::IoError(error) => CodecError::reading(error),
        DecodingError::LimitsExceeded => too_large("decoding it needs too much memory"),
        other => CodecError::broken(other),
    }
}

//! PNG to linear Rec.709: halves for 8 bits, which hold every code apart, floats for 16.

use std::io::{BufRead, Seek};

use afterimage_base::color::Chromaticities;
use glam::DMat3;
use half::f16;
use png::{BitDepth, Decoder, DecodingError, Info, Limits, Transformations};

use crate::codec::chromaticities::{convert, to_rec709};
use crate::codec::limits::{MAX_BYTES, check_size, filled, too_large};
use crate::codec::{CodecError, ErrorKind, Picture, Pixels};

/// The first eight bytes of every PNG.
pub(crate) const MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Decodes a PNG to linear light. `cICP`, `sRGB`, `gAMA` and `cHRM` are applied, in this order of
/// priority. An ICC profile is ignored, with a note. Alpha is not multiplied in.
pub(crate) fn decode(reader: impl BufRead + Seek) -> Result<Picture, CodecError> {
    let limits = Limits { bytes: MAX_BYTES as usize };
    let mut decoder = Decoder::new_with_limits(reader, limits);
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(|error| explain(&error))?;
    let (width, height) = (header.width, header.height);
    check_size((width.into(), height.into()), 4)?;
    let mut reader = decoder.read_info().map_err(|error| explain(&error))?;
    let colours = Colours::of(reader.info())?;
    let (colour_type, depth) = reader.output_color_type();
    let size = reader.output_buffer_size().ok_or_else(|| CodecError::broken("no size"))?;
    let mut bytes = filled(size, 0_u8)?;
    reader.next_frame(&mut bytes).map_err(|error| explain(&error))?;
    let count = width as usize * height as usize;
    let channels = colour_type.samples();
    let pixels = if depth == BitDepth::Sixteen {
        let (codes, _) = bytes.as_chunks::<2>();
        let codes = codes.iter().map(|code| usize::from(u16::from_be_bytes(*code)));
        let mut values = filled(count * 4, 1.0_f32)?;
        linearise(codes, channels, &colours.table(65535), |v| v, &mut values);
        colours.convert(&mut values);
        Pixels::Float(values)
    } else {
        let codes = bytes.iter().map(|code| usize::from(*code));
        let mut values = filled(count * 4, f16::ONE)?;
        linearise(codes, channels, &colours.table(255), f16::from_f32, &mut values);
        colours.convert_halves(&mut values);
        Pixels::Half(values)
    };
    let mut picture = Picture::new(width, height, pixels);
    picture.notes = colours.notes;
    Ok(picture)
}

/// Spreads grey, grey and alpha, RGB or RGBA codes over RGBA.
fn linearise<T: Copy>(
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
            let grey = light[next()];
            pixel[..3].fill(grey);
        } else {
            pixel[..3].fill_with(|| light[next()]);
        }
        if has_alpha {
            pixel[3] = to_sample(next() as f32 * alpha_scale);
        }
    }
}

enum Transfer {
    Srgb,
    /// Light is the code to this power.
    Power(f32),
}

/// What the chunks of the file say about its colours.
struct Colours {
    transfer: Transfer,
    matrix: Option<DMat3>,
    notes: Vec<String>,
}

impl Colours {
    fn of(info: &Info<'_>) -> Result<Self, CodecError> {
        let (transfer, primaries) = match info.coding_independent_code_points {
            Some(cicp) => from_cicp(cicp.color_primaries, cicp.transfer_function)?,
            None if info.srgb.is_some() || info.icc_profile.is_some() => (Transfer::Srgb, Chromaticities::REC709),
            None => (from_gamma(info), stated_primaries(info)?),
        };
        let matrix = to_rec709(&primaries);
        let mut notes = Vec::new();
        if info.icc_profile.is_some() && info.coding_independent_code_points.is_none() {
            notes.push("its ICC profile is not applied; the colours are taken as sRGB".to_owned());
        }
        Ok(Self { transfer, matrix, notes })
    }

    /// Linear light for each code.
    fn table(&self, max: u32) -> Vec<f32> {
        let light = |code: u32| {
            let v = f64::from(code) / f64::from(max);
            match self.transfer {
                Transfer::Srgb if v <= 0.04045 => v / 12.92,
                Transfer::Srgb => ((v + 0.055) / 1.055).powf(2.4),
                Transfer::Power(power) => v.powf(power.into()),
            }
        };
        (0..=max).map(|code| light(code) as f32).collect()
    }

    fn convert(&self, values: &mut [f32]) {
        let Some(matrix) = self.matrix.map(|matrix| matrix.as_mat3()) else { return };
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            [*r, *g, *b] = convert(&matrix, [*r, *g, *b]);
        }
    }

    fn convert_halves(&self, values: &mut [f16]) {
        let Some(matrix) = self.matrix.map(|matrix| matrix.as_mat3()) else { return };
        for [r, g, b, _] in values.as_chunks_mut::<4>().0 {
            let rgb = [r.to_f32(), g.to_f32(), b.to_f32()];
            [*r, *g, *b] = convert(&matrix, rgb).map(f16::from_f32);
        }
    }
}

/// Numbers of ITU-T H.273.
fn from_cicp(primaries: u8, transfer: u8) -> Result<(Transfer, Chromaticities), CodecError> {
    let primaries = match primaries {
        1 => Some(Chromaticities::REC709),
        9 => Some(Chromaticities::REC2020),
        12 => Some(Chromaticities::DISPLAY_P3),
        _ => None,
    };
    let transfer = match transfer {
        8 => Some(Transfer::Power(1.0)),
        13 => Some(Transfer::Srgb),
        _ => None,
    };
    transfer.zip(primaries).ok_or_else(|| {
        let what = "the `cICP` chunk of this PNG names a colour coding that is not read";
        CodecError::new(ErrorKind::Unsupported, what).hint("save it again as sRGB, or as linear EXR")
    })
}

fn from_gamma(info: &Info<'_>) -> Transfer {
    const SRGB_LIKE: f32 = 0.45455;
    let gamma = info.gama_chunk.map(|gamma| gamma.into_value());
    match gamma.filter(|g| (0.01..=10.0).contains(g) && (g - SRGB_LIKE).abs() > 0.001) {
        Some(gamma) => Transfer::Power(1.0 / gamma),
        None => Transfer::Srgb,
    }
}

fn stated_primaries(info: &Info<'_>) -> Result<Chromaticities, CodecError> {
    let Some(stated) = info.chrm_chunk else { return Ok(Chromaticities::REC709) };
    let points = [stated.red, stated.green, stated.blue, stated.white];
    let numbers = points.map(|(x, y)| [x, y].map(|number| f64::from(number.into_scaled()) / 1e5));
    let space =
        Chromaticities::from_numbers(numbers.as_flattened().try_into().expect("four points have eight numbers"));
    space.ok_or_else(|| CodecError::broken("its `cHRM` chunk describes no colour space"))
}

fn explain(error: &DecodingError) -> CodecError {
    match error {
        DecodingError::IoError(error) => CodecError::reading(error),
        DecodingError::LimitsExceeded => too_large("decoding it needs too much memory"),
        other => CodecError::broken(other),
    }
}

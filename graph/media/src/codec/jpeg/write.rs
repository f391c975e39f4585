//! Encoded pixels to JPEG: eight bits, no alpha, SDR.

use afterimage_base::color::Colorimetry;
use jpeg_encoder::{ColorType, Encoder, EncodingError, SamplingFactor};

use crate::codec::limits::check_size;
use crate::codec::quantize::Quantizer;
use crate::codec::{CodecError, EncodedPixels, ErrorKind, icc};

/// How a JPEG is written. The color channels have full resolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JpegOptions {
    /// 1 to 100: of the quantization tables of libjpeg.
    pub quality: u8,
    /// Seed of the dither to eight bits, or `None` to round.
    pub dither: Option<u32>,
    /// What the numbers mean, stated by an ICC profile; not stated if `None`.
    pub color: Option<Colorimetry>,
}

impl Default for JpegOptions {
    /// Quality 92, sRGB, dithered with seed 0.
    fn default() -> Self {
        Self { quality: 92, dither: Some(0), color: Some(Colorimetry::SRGB) }
    }
}

/// Encodes a JPEG of `size` (width, height). Alpha is not written.
///
/// # Errors
/// More than 65535 pixels in a row or column, `Pq` and `Hlg`.
pub fn encode_jpeg(size: (u32, u32), pixels: EncodedPixels<'_>, options: &JpegOptions) -> Result<Vec<u8>, CodecError> {
    let (Ok(width), Ok(height)) = (u16::try_from(size.0), u16::try_from(size.1)) else {
        return Err(CodecError::new(ErrorKind::TooLarge, "a JPEG has at most 65535 pixels in a row or column"));
    };
    check_size((size.0.into(), size.1.into()), 1)?;
    let profile = options.color.map(profile).transpose()?;
    let codes = Quantizer { bits: 8, dither: options.dither, channels: 3, first_row: 0 }.codes(size, pixels)?;
    let bytes: Vec<u8> = codes.iter().map(|code| *code as u8).collect();
    pack((width, height), &bytes, profile.as_deref(), options.quality)
        .map_err(|error| CodecError::new(ErrorKind::Machine, format!("packing the JPEG failed: {error}")))
}

fn profile(color: Colorimetry) -> Result<Vec<u8>, CodecError> {
    icc::write(&color).ok_or_else(|| {
        CodecError::new(ErrorKind::Unsupported, "a JPEG has eight bits, too few for PQ and HLG")
            .hint("write a PNG or an AVIF, or encode for an SDR display")
    })
}

fn pack(size: (u16, u16), bytes: &[u8], profile: Option<&[u8]>, quality: u8) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, quality.clamp(1, 100));
    encoder.set_sampling_factor(SamplingFactor::F_1_1);
    if let Some(profile) = profile {
        encoder.add_icc_profile(profile)?;
    }
    encoder.encode(bytes, size.0, size.1, ColorType::Rgb)?;
    Ok(file)
}

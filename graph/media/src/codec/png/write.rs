//! Encoded pixels to PNG. Rows are converted on all cores; the packing is the fast kind.

use half::f16;
use half::slice::HalfFloatSliceExt;
use png::chunk::ChunkType;
use png::{
    BitDepth, ColorType, Compression, Encoder, EncodingError, ScaledFloat, SourceChromaticities, SrgbRenderingIntent,
};
use rayon::prelude::*;

use super::dither::{Noise, dithered, quantise};
use crate::codec::limits::{check_size, zeroed};
use crate::codec::{CodecError, ErrorKind};

/// Interleaved RGBA after the transfer function: numbers in [0, 1], or codes of eight bits.
#[derive(Debug, Clone, Copy)]
pub enum EncodedPixels<'a> {
    /// 16-bit floats.
    Half(&'a [f16]),
    /// 32-bit floats.
    Float(&'a [f32]),
    /// Codes 0 to 255, already dithered.
    Byte(&'a [u8]),
}

/// How a PNG is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PngOptions {
    /// Bits for each channel.
    pub depth: PngDepth,
    /// Whether alpha is written. PNG takes it as coverage that is not multiplied into the colour.
    pub alpha: bool,
    /// Seed of the 8-bit dither, or `None` to round. Alpha, 16 bits and codes are never dithered.
    pub dither: Option<u32>,
    /// What the file says about its colours.
    pub colour: PngColour,
}

impl Default for PngOptions {
    /// 8-bit sRGB without alpha, dithered with seed 0.
    fn default() -> Self {
        Self { depth: PngDepth::Eight, alpha: false, dither: Some(0), colour: PngColour::Srgb }
    }
}

/// Bits for each channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PngDepth {
    /// Codes 0 to 255.
    Eight,
    /// Codes 0 to 65535.
    Sixteen,
}

/// What a PNG says about its colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PngColour {
    /// IEC 61966-2-1, with the `gAMA` and `cHRM` chunks that older readers want.
    Srgb,
    /// Rec.709 primaries with `code = light^gamma`; 0.45455 is the usual display gamma of 2.2.
    Gamma(f32),
    /// Code points of ITU-T H.273, for example 9 and 16 for Rec.2100 PQ.
    Cicp {
        /// `ColourPrimaries`: 1 Rec.709, 9 Rec.2020, 12 P3 with D65.
        primaries: u8,
        /// `TransferCharacteristics`: 13 sRGB, 16 PQ, 18 HLG.
        transfer: u8,
    },
    /// Nothing.
    Unstated,
}

/// Encodes a PNG of `size` (width, height).
pub fn encode_png(size: (u32, u32), pixels: EncodedPixels<'_>, options: &PngOptions) -> Result<Vec<u8>, CodecError> {
    check_size((size.0.into(), size.1.into()), 2)?;
    let bytes = codes(size, pixels, options)?;
    pack(size, &bytes, options)
        .map_err(|error| CodecError::new(ErrorKind::Machine, format!("packing the PNG failed: {error}")))
}

fn codes((width, height): (u32, u32), pixels: EncodedPixels<'_>, options: &PngOptions) -> Result<Vec<u8>, CodecError> {
    let row_length = width as usize * 4;
    assert_eq!(pixels.len(), row_length * height as usize, "four numbers for a pixel");
    let mut bytes = zeroed::<u8>(width as usize * height as usize * options.pixel_bytes())?;
    let rows = bytes.par_chunks_exact_mut(width as usize * options.pixel_bytes()).enumerate();
    rows.for_each_init(
        || vec![0.0; row_length],
        |scratch, (y, out)| {
            let from = y * row_length..(y + 1) * row_length;
            match pixels {
                EncodedPixels::Byte(codes) => byte_row(&codes[from], out, options),
                EncodedPixels::Float(values) => float_row(&values[from], y as u32, out, options),
                EncodedPixels::Half(values) => {
                    values[from].convert_to_f32_slice(scratch);
                    float_row(scratch, y as u32, out, options);
                }
            }
        },
    );
    Ok(bytes)
}

fn byte_row(row: &[u8], out: &mut [u8], options: &PngOptions) {
    let channels = options.channels();
    let (pixels, _) = row.as_chunks::<4>();
    for (pixel, out) in pixels.iter().zip(out.chunks_exact_mut(options.pixel_bytes())) {
        match options.depth {
            PngDepth::Eight => out.copy_from_slice(&pixel[..channels]),
            // 257 = 65535 / 255: both bytes of the code are alike.
            PngDepth::Sixteen => {
                out.as_chunks_mut().0.iter_mut().zip(pixel).for_each(|(o, c)| *o = [*c, *c]);
            }
        }
    }
}

fn float_row(row: &[f32], y: u32, out: &mut [u8], options: &PngOptions) {
    let (pixels, _) = row.as_chunks::<4>();
    let outs = out.chunks_exact_mut(options.pixel_bytes());
    match (options.depth, options.dither) {
        (PngDepth::Eight, Some(seed)) => {
            let noise = Noise::of_row(seed, y);
            for ((x, pixel), out) in (0..).zip(pixels).zip(outs) {
                dithered_pixel(pixel, noise.at(x), out);
            }
        }
        (PngDepth::Eight, None) => {
            for (pixel, out) in pixels.iter().zip(outs) {
                out.iter_mut().zip(pixel).for_each(|(o, v)| *o = quantise(*v, 255.0) as u8);
            }
        }
        (PngDepth::Sixteen, _) => {
            for (pixel, out) in pixels.iter().zip(outs) {
                let words = out.as_chunks_mut().0.iter_mut();
                words.zip(pixel).for_each(|(o, v)| {
                    *o = (quantise(*v, 65535.0) as u16).to_be_bytes();
                });
            }
        }
    }
}

fn dithered_pixel(pixel: &[f32; 4], noise: [(f32, f32); 3], out: &mut [u8]) {
    for ((o, v), (u1, u2)) in out.iter_mut().zip(pixel).zip(noise) {
        *o = dithered(*v, u1, u2);
    }
    if let Some(alpha) = out.get_mut(3) {
        *alpha = quantise(pixel[3], 255.0) as u8;
    }
}

impl EncodedPixels<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Half(values) => values.len(),
            Self::Float(values) => values.len(),
            Self::Byte(values) => values.len(),
        }
    }
}

impl PngOptions {
    fn channels(&self) -> usize {
        if self.alpha { 4 } else { 3 }
    }

    fn pixel_bytes(&self) -> usize {
        match self.depth {
            PngDepth::Eight => self.channels(),
            PngDepth::Sixteen => self.channels() * 2,
        }
    }
}

fn pack((width, height): (u32, u32), bytes: &[u8], options: &PngOptions) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(if options.alpha { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(match options.depth {
        PngDepth::Eight => BitDepth::Eight,
        PngDepth::Sixteen => BitDepth::Sixteen,
    });
    encoder.set_compression(Compression::Fast);
    match options.colour {
        PngColour::Srgb => state_srgb(&mut encoder),
        PngColour::Gamma(gamma) => encoder.set_source_gamma(ScaledFloat::new(gamma)),
        PngColour::Cicp { .. } | PngColour::Unstated => {}
    }
    let mut writer = encoder.write_header()?;
    if let PngColour::Cicp { primaries, transfer } = options.colour {
        // Matrix 0 is RGB and range 1 is full, the only ones PNG knows. The encoder has no setter.
        writer.write_chunk(ChunkType(*b"cICP"), &[primaries, transfer, 0, 1])?;
    }
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(file)
}

/// Beside `sRGB`, the values that the PNG specification (11.3.2.5) wants for older readers.
fn state_srgb(encoder: &mut Encoder<'_, &mut Vec<u8>>) {
    encoder.set_source_gamma(ScaledFloat::from_scaled(45455));
    encoder.set_source_chromaticities(SourceChromaticities::new(
        (0.3127, 0.3290),
        (0.64, 0.33),
        (0.30, 0.60),
        (0.15, 0.06),
    ));
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
}

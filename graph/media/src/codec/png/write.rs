//! Encoded pixels to PNG. Rows are converted and packed on all cores; the packing is the fast kind.

use afterimage_base::color::Colorimetry;
use std::io::Write;

use png::chunk::ChunkType;
use png::{BitDepth, ColorType, Encoder, EncodingError, Info, Writer};

use super::label::Label;
use super::strips::{PngDepth, Strips};
use crate::codec::light_level::LightLevel;
use crate::codec::limits::{check_sides, check_size};
use crate::codec::quantize::{Premultiplied, Quantizer};
use crate::codec::{CodecError, EncodedPixels, ErrorKind};

/// How a PNG is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PngOptions {
    /// Bits for each channel.
    pub depth: PngDepth,
    /// Whether alpha is written. In the file it is coverage that is not multiplied into the color.
    pub alpha: Alpha,
    /// Whether the light of the pixels is multiplied by their alpha, as in a pipeline. Where alpha is written it is
    /// divided by it: light above white is cut then, and there is none where alpha is 0.
    pub premultiplied: bool,
    /// Seed of the 8-bit dither, or `None` to round. Alpha, 16 bits and codes are never dithered.
    pub dither: Option<u32>,
    /// What the numbers mean, which the file states; `None` states nothing.
    pub color: Option<Colorimetry>,
}

impl Default for PngOptions {
    /// 8-bit sRGB without alpha, dithered with seed 0.
    fn default() -> Self {
        let color = Some(Colorimetry::SRGB);
        Self { depth: PngDepth::Eight, alpha: Alpha::Drop, premultiplied: true, dither: Some(0), color }
    }
}

/// Whether the alpha of an image is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Alpha {
    /// Always.
    Keep,
    /// Where it is not 1 in all pixels.
    #[default]
    WhereNeeded,
    /// Never.
    Drop,
}

/// Encodes a PNG of `size` (width, height).
///
/// The file states `options.color` by `cICP` where both code points exist, and by `sRGB`, `gAMA` and `cHRM`, or an ICC
/// profile, where these state the same. HDR files also have `mDCV`, from the primaries and the peak, and `cLLI`, from
/// the pixels.
///
/// # Errors
/// An image that is too large, and `Pq` or `Hlg` with primaries that no chunk states.
pub fn encode_png(size: (u32, u32), pixels: EncodedPixels<'_>, options: &PngOptions) -> Result<Vec<u8>, CodecError> {
    check_size((size.0.into(), size.1.into()), 2)?;
    let bits = options.depth.bits();
    let (codes, channels) = png_codes(size, pixels, options)?;
    let level = options.color.and_then(|color| LightLevel::of(&codes, channels, bits, &color));
    let label = options.color.map(|color| Label::new(&color, level)).transpose()?;
    pack(size, channels, options.depth, codes, label).map_err(|error| failed(&error))
}

/// The codes that a PNG with these options holds, rows without gaps, and the number of channels: 3 or 4.
///
/// # Errors
/// The machine has no memory for them.
pub fn png_codes(
    size: (u32, u32),
    pixels: EncodedPixels<'_>,
    options: &PngOptions,
) -> Result<(Vec<u16>, usize), CodecError> {
    let bits = options.depth.bits();
    let keeps_alpha = match options.alpha {
        Alpha::Keep => true,
        Alpha::WhereNeeded => pixels.has_alpha(bits),
        Alpha::Drop => false,
    };
    let quantizer = options.quantizer(if keeps_alpha { 4 } else { 3 });
    Ok((quantizer.codes(size, pixels)?, quantizer.channels))
}

/// What a PNG with these options leaves out, in a sentence.
pub fn png_left_out(pixels: EncodedPixels<'_>, options: &PngOptions) -> Option<String> {
    let bits = options.depth.bits();
    let color = Premultiplied::new(options.color);
    let is_straight = options.premultiplied && options.alpha != Alpha::Drop;
    (is_straight && pixels.any(|pixel| color.is_cut(pixel, bits))).then(|| {
        "light that is brighter than its alpha holds is cut, as a PNG has straight color; an EXR keeps it".to_owned()
    })
}

impl PngOptions {
    fn quantizer(&self, channels: usize) -> Quantizer {
        Quantizer {
            bits: self.depth.bits(),
            dither: self.dither.filter(|_| self.depth == PngDepth::Eight),
            channels,
            first_row: 0,
            premultiplied: self.premultiplied.then(|| Premultiplied::new(self.color)),
        }
    }
}

fn info((width, height): (u32, u32), channels: usize, depth: PngDepth) -> Info<'static> {
    let mut info = Info::with_size(width, height);
    info.color_type = if channels == 4 { ColorType::Rgba } else { ColorType::Rgb };
    info.bit_depth = match depth {
        PngDepth::Eight => BitDepth::Eight,
        PngDepth::Sixteen => BitDepth::Sixteen,
    };
    info
}

fn pack(
    size: (u32, u32),
    channels: usize,
    depth: PngDepth,
    codes: Vec<u16>,
    label: Option<Label>,
) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    let mut writer = begin(&mut file, info(size, channels, depth), label)?;
    let mut strips = Strips::new(size.0, channels, depth);
    strips.write(&mut writer, codes)?;
    strips.finish(&mut writer)?;
    writer.finish()?;
    Ok(file)
}

/// Writes all chunks before the pixels.
fn begin<W: Write>(to: W, mut info: Info<'_>, label: Option<Label>) -> Result<Writer<W>, EncodingError> {
    if let Some(label) = &label {
        label.state(&mut info);
    }
    let mut writer = Encoder::with_info(to, info)?.write_header()?;
    for (name, data) in label.iter().flat_map(|label| &label.newer) {
        writer.write_chunk(ChunkType(*name), data)?;
    }
    Ok(writer)
}

/// A PNG that is written from the top to the bottom, so that no more than some rows are in memory: the bytes of
/// [`encode_png`].
pub struct PngRows<W: Write> {
    writer: Writer<W>,
    strips: Strips,
    width: u32,
    quantizer: Quantizer,
}

impl<W: Write> PngRows<W> {
    /// Whether these options need no pixel before the first row is written: an HDR file states the light of all of them
    /// at its beginning, and [`Alpha::WhereNeeded`] depends on all.
    pub fn can_write(options: &PngOptions) -> bool {
        options.alpha != Alpha::WhereNeeded && !options.color.is_some_and(|color| color.is_hdr())
    }

    /// Writes what comes before the rows of a PNG of `size`.
    ///
    /// # Errors
    /// A side that is too long, and what writing to `to` reports.
    ///
    /// # Panics
    /// If the options are not [those](Self::can_write) of rows.
    pub fn new(to: W, size: (u32, u32), options: &PngOptions) -> Result<Self, CodecError> {
        assert!(Self::can_write(options), "the first bytes depend on all pixels");
        check_sides((size.0.into(), size.1.into()))?;
        let channels = if options.alpha == Alpha::Keep { 4 } else { 3 };
        let label = options.color.map(|color| Label::new(&color, None)).transpose()?;
        let writer = begin(to, info(size, channels, options.depth), label).map_err(|error| failed(&error))?;
        let strips = Strips::new(size.0, channels, options.depth);
        let quantizer = options.quantizer(channels);
        Ok(Self { writer, strips, width: size.0, quantizer })
    }

    /// Writes the next rows.
    ///
    /// # Errors
    /// What writing reports, and no memory for the codes.
    pub fn write(&mut self, pixels: EncodedPixels<'_>) -> Result<(), CodecError> {
        let rows = (pixels.len() / 4 / self.width as usize) as u32;
        let codes = self.quantizer.codes((self.width, rows), pixels)?;
        self.quantizer.first_row += rows;
        self.strips.write(&mut self.writer, codes).map_err(|error| failed(&error))
    }

    /// Writes what comes after the last row.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn finish(mut self) -> Result<(), CodecError> {
        let finished = self.strips.finish(&mut self.writer).and_then(|()| self.writer.finish());
        finished.map_err(|error| failed(&error))
    }
}

fn failed(error: &EncodingError) -> CodecError {
    match error {
        EncodingError::IoError(error) => CodecError::writing(error),
        error => CodecError::new(ErrorKind::Machine, format!("packing the PNG failed: {error}")),
    }
}

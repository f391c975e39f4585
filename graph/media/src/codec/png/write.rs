//! Encoded pixels to PNG. Rows are converted and packed on all cores; the packing is the fast kind.

use png::chunk::ChunkType;
use png::{BitDepth, ColorType, Encoder, EncodingError, Info, Writer};

use super::label::Label;
use super::strips::Strips;
use crate::codec::encoding::{Image, RowWriter, Sink};
use crate::codec::light_level::LightLevel;
use crate::codec::limits::check_sides;
use crate::codec::quantize::{Premultiplied, Quantizer};
use crate::codec::{Alpha, CodecError, Encoding, ErrorKind, Metadata, Samples};

/// The writer of a PNG.
pub(crate) struct PngRows {
    writer: Writer<Box<dyn Sink>>,
    strips: Strips,
    width: u32,
    quantizer: Quantizer,
}

impl PngRows {
    /// Writes all chunks before the pixels. `level` is the light level that an HDR file states.
    pub(crate) fn new(
        to: Box<dyn Sink>,
        size: (u32, u32),
        encoding: &Encoding,
        level: Option<LightLevel>,
    ) -> Result<Self, CodecError> {
        check_sides((size.0.into(), size.1.into()))?;
        let quantizer = quantizer(encoding, encoding.alpha == Alpha::Keep);
        let label = encoding.color.map(|color| Label::new(&color, level)).transpose()?;
        let mut info = Info::with_size(size.0, size.1);
        info.color_type = if quantizer.channels == 4 { ColorType::Rgba } else { ColorType::Rgb };
        info.bit_depth = if encoding.bits == 16 { BitDepth::Sixteen } else { BitDepth::Eight };
        let writer = begin(to, info, label).map_err(|error| failed(&error))?;
        let strips = Strips::new(size.0, quantizer.channels, encoding.bits);
        Ok(Self { writer, strips, width: size.0, quantizer })
    }
}

fn begin(to: Box<dyn Sink>, mut info: Info<'_>, label: Option<Label>) -> Result<Writer<Box<dyn Sink>>, EncodingError> {
    if let Some(label) = &label {
        label.state(&mut info);
    }
    let mut writer = Encoder::with_info(to, info)?.write_header()?;
    for (name, data) in label.iter().flat_map(|label| &label.newer) {
        writer.write_chunk(ChunkType(*name), data)?;
    }
    Ok(writer)
}

impl RowWriter for PngRows {
    fn write(&mut self, samples: Samples<'_>) -> Result<(), CodecError> {
        let codes = self.quantizer.next_codes(self.width, samples)?;
        self.strips.write(&mut self.writer, codes).map_err(|error| failed(&error))
    }

    fn finish(self: Box<Self>) -> Result<(), CodecError> {
        let Self { mut writer, strips, .. } = *self;
        let finished = strips.finish(&mut writer).and_then(|()| writer.finish());
        finished.map_err(|error| failed(&error))
    }
}

/// The writer of an image in memory, whose pixels determine alpha and the content light level, and notes about what is
/// left out.
pub(crate) fn writer_of_image(
    to: Box<dyn Sink>,
    image: Image<'_>,
    encoding: &Encoding,
) -> Result<(Box<dyn RowWriter>, Vec<String>), CodecError> {
    let Image { size, samples, meta, .. } = image;
    let notes = cut_light(samples, encoding).into_iter().chain(meta.and_then(Metadata::other_aspect)).collect();
    let alpha = if keeps_alpha(samples, encoding) { Alpha::Keep } else { Alpha::Drop };
    let encoding = Encoding { alpha, ..*encoding };
    let level = match encoding.color.filter(|color| color.is_hdr()) {
        Some(color) => {
            let (codes, channels) = png_codes(size, samples, &encoding)?;
            LightLevel::of(&codes, channels, encoding.bits, &color)
        }
        None => None,
    };
    Ok((Box::new(PngRows::new(to, size, &encoding, level)?), notes))
}

/// The codes of a PNG, rows without gaps, and the number of channels: 3 or 4.
///
/// # Errors
/// The machine has no memory for them.
pub fn png_codes(size: (u32, u32), samples: Samples<'_>, encoding: &Encoding) -> Result<(Vec<u16>, usize), CodecError> {
    let quantizer = quantizer(encoding, keeps_alpha(samples, encoding));
    Ok((quantizer.codes(size, samples)?, quantizer.channels))
}

fn keeps_alpha(samples: Samples<'_>, encoding: &Encoding) -> bool {
    match encoding.alpha {
        Alpha::Keep => true,
        Alpha::WhereNeeded => samples.has_alpha(encoding.bits),
        Alpha::Drop => false,
    }
}

/// A note about premultiplied color that straight color cannot hold.
fn cut_light(samples: Samples<'_>, encoding: &Encoding) -> Option<String> {
    let color = Premultiplied::new(encoding.color);
    let is_straight = encoding.premultiplied && encoding.alpha != Alpha::Drop;
    (is_straight && samples.any(|pixel| color.is_cut(pixel, encoding.bits))).then(|| {
        "light that is brighter than its alpha holds is cut, as a PNG has straight color; an EXR keeps it".to_owned()
    })
}

fn quantizer(encoding: &Encoding, keeps_alpha: bool) -> Quantizer {
    Quantizer {
        bits: encoding.bits,
        dither: encoding.dither.filter(|_| encoding.bits == 8),
        channels: if keeps_alpha { 4 } else { 3 },
        first_row: 0,
        premultiplied: encoding.premultiplied.then(|| Premultiplied::new(encoding.color)),
    }
}

fn failed(error: &EncodingError) -> CodecError {
    match error {
        EncodingError::IoError(error) => CodecError::writing(error),
        error => CodecError::new(ErrorKind::Machine, format!("packing the PNG failed: {error}")),
    }
}

//! Pixels of rendered images in the memory of the processor.

use afterimage_gpu::Texels;
use afterimage_graph::color::Colorimetry;
use afterimage_graph::image::{ColorState, Format, ImageDesc};
use afterimage_media::{Alpha, png_codes};
use afterimage_plan::PlanOutput;

use super::quantize::with_samples;
use crate::error::Error;

/// The components of outputs for a display. Linear color and data are not encoded: they have the type that the
/// pipeline stores.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// Codes of 8 bits for SDR, of 16 for PQ and HLG: those of the program's PNG files.
    #[default]
    Codes,
    /// Codes of 8 bits.
    Codes8,
    /// Codes of 16 bits.
    Codes16,
    /// Numbers from 0 to 1, which are not rounded to codes, as 16-bit floats.
    Half,
    /// The same as 32-bit floats.
    Float,
}

impl Encoding {
    /// The bits that the pipeline must keep.
    pub(super) fn bits(self, is_hdr: bool) -> u32 {
        match self {
            Self::Codes if is_hdr => 16,
            Self::Codes | Self::Codes8 | Self::Half => 8,
            Self::Codes16 | Self::Float => 16,
        }
    }

    fn is_rounded(self) -> bool {
        !matches!(self, Self::Half | Self::Float)
    }
}

/// The type of the components of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComponentType {
    /// Codes of 8 bits.
    U8,
    /// Codes of 16 bits.
    U16,
    /// 16-bit floats.
    F16,
    /// 32-bit floats.
    F32,
}

/// The format of an image with components of this type; `None` if no texture for an input has it.
pub fn format_of(ty: ComponentType, channels: u32) -> Option<Format> {
    match (ty, channels) {
        (ComponentType::F16, 1) => Some(Format::R16Float),
        (ComponentType::F16, 2) => Some(Format::Rg16Float),
        (ComponentType::F16, 4) => Some(Format::Rgba16Float),
        (ComponentType::F32, 1) => Some(Format::R32Float),
        (ComponentType::F32, 4) => Some(Format::Rgba32Float),
        _ => None,
    }
}

/// The components of an image: row by row without gaps, the channels of a pixel side by side.
pub enum PixelData {
    /// The bytes of components of a type.
    Bytes(Vec<u8>, ComponentType),
    /// Codes of 16 bits.
    Codes(Vec<u16>),
    /// 32-bit floats.
    Floats(Vec<f32>),
}

impl PixelData {
    /// The type of the components.
    pub fn ty(&self) -> ComponentType {
        match self {
            Self::Bytes(_, ty) => *ty,
            Self::Codes(_) => ComponentType::U16,
            Self::Floats(_) => ComponentType::F32,
        }
    }

    /// The bytes of the components, as the processor stores them.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Bytes(bytes, _) => bytes,
            Self::Codes(codes) => bytemuck::cast_slice(codes),
            Self::Floats(floats) => bytemuck::cast_slice(floats),
        }
    }
}

/// An output of a frame in the memory of the processor.
pub struct RenderedImage {
    /// The name of the output.
    pub name: String,
    /// Its pixels.
    pub data: PixelData,
    /// Components of a pixel, 1 to 4.
    pub channels: usize,
    /// Its size, and the format in which the pipeline stored it.
    pub desc: ImageDesc,
    /// The meaning of the components.
    pub state: ColorState,
    /// Primaries, transfer function and white.
    pub colorimetry: Colorimetry,
}

/// The rounding of an output for a display.
pub(super) struct Rounding {
    pub(super) bits: u32,
    /// The seed of the noise; `None` rounds to the nearest code.
    pub(super) dither: Option<u32>,
    pub(super) keeps_alpha: bool,
}

impl RenderedImage {
    /// The image of these texels; encoded ones are rounded unless `encoding` wants them as they are.
    pub(super) fn of(
        output: &PlanOutput,
        texels: Texels,
        encoding: Encoding,
        rounding: Option<&Rounding>,
    ) -> Result<Self, Error> {
        let desc = texels.desc;
        let (data, channels) = match rounding.filter(|_| encoding.is_rounded()) {
            Some(rounding) => rounded(&texels, rounding, output.colorimetry)?,
            None => plain(texels),
        };
        let (state, colorimetry) = (output.state, output.colorimetry);
        Ok(Self { name: output.name.clone(), data, channels, desc, state, colorimetry })
    }
}

/// The components of linear color, of data, or of an encoded image that is not rounded.
fn plain(texels: Texels) -> (PixelData, usize) {
    match texels.desc.format {
        Format::Rgba16Float => (PixelData::Bytes(texels.bytes, ComponentType::F16), 4),
        Format::Rg16Float => (PixelData::Bytes(texels.bytes, ComponentType::F16), 2),
        Format::R16Float => (PixelData::Bytes(texels.bytes, ComponentType::F16), 1),
        Format::Rgba32Float => (PixelData::Bytes(texels.bytes, ComponentType::F32), 4),
        Format::R32Float | Format::Depth32Float => (PixelData::Bytes(texels.bytes, ComponentType::F32), 1),
        Format::Rgba8Unorm | Format::Rg11b10Ufloat | Format::Rgb10a2Unorm | Format::Depth16Unorm => {
            (PixelData::Floats(texels.to_floats().into_flattened()), 4)
        }
    }
}

/// The codes of the program's PNG.
fn rounded(texels: &Texels, rounding: &Rounding, color: Colorimetry) -> Result<(PixelData, usize), Error> {
    let size = (texels.desc.size.width, texels.desc.size.height);
    let encoding = afterimage_media::Encoding {
        bits: rounding.bits,
        alpha: if rounding.keeps_alpha { Alpha::Keep } else { Alpha::Drop },
        dither: rounding.dither,
        color: Some(color),
        ..afterimage_media::Encoding::PNG
    };
    let codes = with_samples(texels, |pixels| png_codes(size, pixels, &encoding));
    let (codes, channels) = codes.map_err(|error| Error::Image(error.message))?;
    let data = match rounding.bits {
        16 => PixelData::Codes(codes),
        _ => PixelData::Bytes(codes.into_iter().map(|code| code as u8).collect(), ComponentType::U8),
    };
    Ok((data, channels))
}

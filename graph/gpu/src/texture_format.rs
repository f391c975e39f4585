//! Formats of wgpu for those of images, and the other way around.

use afterimage_graph::image::Format;
use wgpu::TextureFormat;

/// The image format that a plan takes an input of a wgpu format for: it has the channels, and at least the bits, of
/// what shaders read. Depth is one channel of 32 bits.
pub fn image_format(format: TextureFormat) -> Option<Format> {
    let same = Format::ALL.into_iter().find(|known| texture_format(*known) == format);
    same.or(match format {
        TextureFormat::Rgba8UnormSrgb | TextureFormat::Bgra8Unorm | TextureFormat::Bgra8UnormSrgb => {
            Some(Format::Rgba8Unorm)
        }
        TextureFormat::R8Unorm => Some(Format::R16Float),
        TextureFormat::Rg8Unorm => Some(Format::Rg16Float),
        format if format.has_depth_aspect() => Some(Format::R32Float),
        _ => None,
    })
}

/// The wgpu format of an image format.
pub fn texture_format(format: Format) -> TextureFormat {
    match format {
        Format::Rgba8Unorm => TextureFormat::Rgba8Unorm,
        Format::R16Float => TextureFormat::R16Float,
        Format::Rg16Float => TextureFormat::Rg16Float,
        Format::Rgba16Float => TextureFormat::Rgba16Float,
        Format::Rg11b10Ufloat => TextureFormat::Rg11b10Ufloat,
        Format::Rgb10a2Unorm => TextureFormat::Rgb10a2Unorm,
        Format::R32Float => TextureFormat::R32Float,
        Format::Rgba32Float => TextureFormat::Rgba32Float,
        Format::Depth16Unorm => TextureFormat::Depth16Unorm,
        Format::Depth32Float => TextureFormat::Depth32Float,
    }
}

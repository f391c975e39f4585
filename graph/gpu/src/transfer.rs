//! Transfers of single images between the host and textures.

use afterimage_graph::image::{Format, ImageDesc, Size};
use half::f16;

use crate::platform::watched;
use crate::{GpuError, samples, store};

/// Texels on the host, tightly packed.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    /// Size and format.
    pub desc: ImageDesc,
    /// The bytes, row by row.
    pub bytes: Vec<u8>,
}

impl Texels {
    /// Four 32-bit floats per texel, unchanged.
    pub fn from_floats(width: u32, height: u32, rgba: &[[f32; 4]]) -> Self {
        let desc = ImageDesc::new(Size::new(width, height)).format(Format::Rgba32Float);
        Self { desc, bytes: bytemuck::cast_slice(rgba).to_vec() }
    }

    /// Four half floats per texel, rounded; numbers beyond half range become infinite.
    pub fn from_floats_as_half(width: u32, height: u32, rgba: &[[f32; 4]]) -> Self {
        let halves: Vec<f16> = rgba.as_flattened().iter().map(|x| f16::from_f32(*x)).collect();
        Self { desc: ImageDesc::new(Size::new(width, height)), bytes: bytemuck::cast_slice(&halves).to_vec() }
    }

    /// Four floats per texel; missing color channels are 0, missing alpha is 1.
    pub fn to_floats(&self) -> Vec<[f32; 4]> {
        let texel = self.desc.format.bytes() as usize;
        self.bytes.chunks_exact(texel).map(|bytes| decode(self.desc.format, bytes)).collect()
    }
}

fn decode(format: Format, bytes: &[u8]) -> [f32; 4] {
    let half = |i: usize| f16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]).to_f32();
    let float = |i: usize| f32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]);
    let unorm = |i: usize| f32::from(bytes[i]) / 255.0;
    let word = || u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    match format {
        Format::Rgba8Unorm => std::array::from_fn(unorm),
        Format::R16Float => [half(0), 0.0, 0.0, 1.0],
        Format::Rg16Float => [half(0), half(1), 0.0, 1.0],
        Format::Rgba16Float => std::array::from_fn(half),
        Format::R32Float | Format::Depth32Float => [float(0), 0.0, 0.0, 1.0],
        Format::Depth16Unorm => [f32::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65535.0, 0.0, 0.0, 1.0],
        Format::Rgba32Float => std::array::from_fn(float),
        Format::Rg11b10Ufloat => {
            let word = word();
            [small_float(word, 6), small_float(word >> 11, 6), small_float(word >> 22, 5), 1.0]
        }
        Format::Rgb10a2Unorm => {
            let code = |shift: u32, most: u32| (word() >> shift & most) as f32 / most as f32;
            [code(0, 1023), code(10, 1023), code(20, 1023), code(30, 3)]
        }
    }
}

/// An unsigned float with 5 exponent bits and `mantissa` mantissa bits: a half float without its sign and its lowest
/// bits.
fn small_float(word: u32, mantissa: u32) -> f32 {
    let bits = word & ((1 << (5 + mantissa)) - 1);
    f16::from_bits((bits << (10 - mantissa)) as u16).to_f32()
}

/// Creates a texture with these texels, as an input of a pipeline.
///
/// # Errors
/// The device is lost or has no memory for it.
pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, texels: &Texels) -> Result<wgpu::Texture, GpuError> {
    upload_bytes(device, queue, texels.desc, &texels.bytes)
}

/// Creates a texture from borrowed, tightly packed texels. Those of a multisampled image are as many images: all first
/// samples, then all second ones.
///
/// # Errors
/// As [`upload`].
pub fn upload_bytes(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    desc: ImageDesc,
    bytes: &[u8],
) -> Result<wgpu::Texture, GpuError> {
    watched(device, "an input image", || {
        if desc.samples > 1 {
            return samples::upload(device, queue, desc, bytes);
        }
        let stored = store::create(device, desc, "input");
        store::upload(queue, &stored.texture, desc, bytes)?;
        Ok(stored.texture)
    })
}

#[cfg(test)]
mod tests {
    use afterimage_graph::image::{Format, ImageDesc, Size};

    use super::Texels;

    #[test]
    fn floats_of_11_and_10_bits_are_read() {
        // Exponents are offset by 15; red and green have mantissas of 6 bits, blue has one of 5.
        let [red, green, blue] = [15 << 6 | 0b10_0000, 13 << 6, 17 << 5 | 0b1_0000_u32];
        let word = red | green << 11 | blue << 22;
        let desc = ImageDesc::new(Size::new(1, 1)).format(Format::Rg11b10Ufloat);
        let texels = Texels { desc, bytes: word.to_le_bytes().to_vec() };
        assert_eq!(texels.to_floats(), [[1.5, 0.25, 6.0, 1.0]]);
    }

    #[test]
    fn codes_of_10_and_2_bits_are_read() {
        let word = 1023_u32 | 341 << 10 | 2 << 30;
        let desc = ImageDesc::new(Size::new(1, 1)).format(Format::Rgb10a2Unorm);
        let texels = Texels { desc, bytes: word.to_le_bytes().to_vec() };
        assert_eq!(texels.to_floats(), [[1.0, 1.0 / 3.0, 0.0, 2.0 / 3.0]]);
    }
}

//! The numbers of single texels of many images.

use afterimage_gpu::{Texels, texture_format, wgpu};
use afterimage_graph::image::{Format, ImageDesc, Size};

use super::readback::Readback;

pub struct TexelRequest<'t> {
    /// The name of the value.
    pub name: String,
    pub texture: &'t wgpu::Texture,
    desc: ImageDesc,
    /// In parts of the width and the height.
    place: [f32; 2],
}

impl<'t> TexelRequest<'t> {
    /// The texel of an image at a place, in parts of the width and the height; of a volume that of the middle slice,
    /// because only a node knows which one belongs to a pixel. `None` for a format that no pipeline stores.
    pub fn new(name: &str, texture: &'t wgpu::Texture, place: [f32; 2]) -> Option<Self> {
        let format = Format::ALL.into_iter().find(|format| texture_format(*format) == texture.format())?;
        let size = texture.size();
        let desc = match texture.dimension() == wgpu::TextureDimension::D3 {
            true => ImageDesc::volume(Size::volume(size.width, size.height, size.depth_or_array_layers)),
            false => ImageDesc::new(Size::new(size.width, size.height)),
        };
        Some(Self { name: name.to_owned(), texture, desc: desc.format(format), place })
    }
}

/// A texel that has arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct TexelValue {
    pub name: String,
    /// The four numbers; missing color channels are 0, missing alpha is 1.
    pub value: [f32; 4],
}

/// Bytes of the widest texel, and the distance between two texels in the buffer.
const STRIDE: u64 = 16;

/// Reads texels, a few frames late.
#[derive(Default)]
pub struct TexelReader {
    pending: Option<(Readback, Vec<(String, ImageDesc)>)>,
}

impl TexelReader {
    /// Copies the texels, unless others are still on their way. `Rgba32Float` and the like are read as they are stored.
    pub fn record(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, texels: &[TexelRequest<'_>]) {
        if self.pending.is_some() || texels.is_empty() {
            return;
        }
        let readback = Readback::new(device, texels.len() as u64 * STRIDE);
        for (index, texel) in texels.iter().enumerate() {
            copy_texel(encoder, texel, &readback.buffer, index as u64 * STRIDE);
        }
        let names = texels.iter().map(|texel| (texel.name.clone(), texel.desc)).collect();
        self.pending = Some((readback, names));
    }

    /// Requests the texels that were copied; call it after the commands are submitted.
    pub fn request(&mut self) {
        if let Some((readback, _)) = &mut self.pending {
            readback.request();
        }
    }

    /// The texels, once they have arrived.
    pub fn take(&mut self) -> Option<Vec<TexelValue>> {
        let bytes = self.pending.as_ref()?.0.bytes()?;
        let (_, names) = self.pending.take()?;
        let stride = STRIDE as usize;
        let decoded = names.into_iter().zip(bytes.chunks_exact(stride)).map(|((name, desc), bytes)| {
            let desc = desc.sized(Size::new(1, 1));
            let texels = Texels { desc, bytes: bytes[..desc.format.bytes() as usize].to_vec() };
            TexelValue { name, value: texels.to_floats()[0] }
        });
        Some(decoded.collect())
    }
}

fn copy_texel(encoder: &mut wgpu::CommandEncoder, texel: &TexelRequest<'_>, buffer: &wgpu::Buffer, offset: u64) {
    let size = [texel.texture.width(), texel.texture.height()];
    let [x, y] = [0, 1].map(|axis| ((texel.place[axis] * size[axis] as f32) as u32).min(size[axis] - 1));
    let slice = if texel.desc.volume { texel.desc.size.depth / 2 } else { 0 };
    let origin = wgpu::Origin3d { x, y, z: slice };
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo { origin, ..texel.texture.as_image_copy() },
        wgpu::TexelCopyBufferInfo {
            buffer,
            layout: wgpu::TexelCopyBufferLayout { offset, bytes_per_row: None, rows_per_image: None },
        },
        wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
    );
}

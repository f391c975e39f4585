//! A copy of an image for the processor, read once it has arrived.

use afterimage_gpu::{Texels, texture_format, wgpu};
use afterimage_graph::image::{Format, ImageDesc, Size};

use super::readback::Readback;

/// A copy of an image on its way from the device.
pub struct ImageCopy {
    readback: Readback,
    desc: ImageDesc,
}

impl ImageCopy {
    /// Records the copy of an image, or of one slice of a volume; `None` for formats that no pipeline stores.
    pub fn record(
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
        slice: u32,
    ) -> Option<Self> {
        let format = Format::ALL.into_iter().find(|format| texture_format(*format) == texture.format())?;
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() };
        let desc = ImageDesc::new(Size::new(size.width, size.height)).format(format);
        let readback = Readback::new(device, u64::from(pitch(&desc)) * u64::from(size.height));
        let (bytes_per_row, rows_per_image) = (Some(pitch(&desc)), Some(size.height));
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image };
        let origin = wgpu::Origin3d { z: slice, ..wgpu::Origin3d::ZERO };
        let from = wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
        encoder.copy_texture_to_buffer(from, wgpu::TexelCopyBufferInfo { buffer: &readback.buffer, layout }, size);
        Some(Self { readback, desc })
    }

    /// Requests the bytes; call it after the commands are submitted.
    pub fn request(&mut self) {
        self.readback.request();
    }

    /// The texels, once they have arrived.
    pub fn texels(&self) -> Option<Texels> {
        let padded = self.readback.bytes()?;
        let row = self.desc.size.width as usize * self.desc.format.bytes() as usize;
        let bytes = padded.chunks_exact(pitch(&self.desc) as usize).flat_map(|line| &line[..row]).copied().collect();
        Some(Texels { desc: self.desc, bytes })
    }
}

/// The distance between rows in a buffer that a texture is copied to.
fn pitch(desc: &ImageDesc) -> u32 {
    (desc.size.width * desc.format.bytes() as u32).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

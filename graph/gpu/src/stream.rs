//! Transfers of image sequences between the host and textures. Staging buffers are created once: allocating tens of
//! megabytes of pinned memory for each frame costs more than copying them.

use afterimage_graph::image::{Format, ImageDesc, Size};

use crate::buffer::buffer;
use crate::device::texture_format;
use crate::{GpuError, Texels, store};

/// A texture that receives one image after another, as an input of a pipeline. The texture stays the same, so bind
/// groups stay valid.
pub struct Feed {
    device: wgpu::Device,
    queue: wgpu::Queue,
    stored: store::Stored,
    /// Created with the second image: for a single one it does not pay.
    staging: Option<wgpu::Buffer>,
    is_filled: bool,
}

impl Feed {
    /// A texture for images of that description.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, desc: ImageDesc) -> Self {
        let stored = store::create(device, desc, "input");
        Self { device: device.clone(), queue: queue.clone(), stored, staging: None, is_filled: false }
    }

    /// The description of the images.
    pub fn desc(&self) -> ImageDesc {
        self.stored.desc
    }

    /// The texture's view.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.stored.view
    }

    /// Uploads the next image: rows tightly packed. Frames that were submitted earlier still see the previous image.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`] if the device was lost.
    pub fn fill(&mut self, bytes: &[u8]) -> Result<(), GpuError> {
        if !self.is_filled {
            store::upload(&self.queue, &self.stored.texture, self.stored.desc, bytes);
            self.is_filled = true;
            return Ok(());
        }
        let size = self.stored.desc.size;
        let (row, pitch) = row_and_pitch(size, self.stored.desc.format);
        let usage = wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC;
        let new = || buffer(&self.device, "upload", (pitch * rows(size)) as u64, usage);
        let staging = self.staging.take().unwrap_or_else(new);
        map(&self.device, &staging, wgpu::MapMode::Write)?;
        let mut mapped = staging.slice(..).get_mapped_range_mut().map_err(|error| GpuError::lost(&error))?;
        if row == pitch {
            mapped.slice(..).copy_from_slice(bytes);
        } else {
            let lines = bytes.chunks_exact(row).enumerate();
            lines.for_each(|(y, line)| mapped.slice(y * pitch..y * pitch + row).copy_from_slice(line));
        }
        drop(mapped);
        staging.unmap();
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let from = wgpu::TexelCopyBufferInfo { buffer: &staging, layout: layout(size, pitch) };
        encoder.copy_buffer_to_texture(from, self.stored.texture.as_image_copy(), self.stored.texture.size());
        self.queue.submit([encoder.finish()]);
        self.staging = Some(staging);
        Ok(())
    }
}

/// Bytes of a value: one `vec4f`.
const VALUE_BYTES: u64 = 16;

const READABLE: wgpu::BufferUsages = wgpu::BufferUsages::MAP_READ.union(wgpu::BufferUsages::COPY_DST);

/// Reads textures and values back, one after another.
pub struct Readback {
    device: wgpu::Device,
    queue: wgpu::Queue,
    buffer: Option<wgpu::Buffer>,
}

impl Readback {
    /// For textures of this device.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self { device: device.clone(), queue: queue.clone(), buffer: None }
    }

    /// The texels of a texture. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Format`] for a texture in none of the formats of images, [`GpuError::DeviceLost`] if the device was
    /// lost.
    pub fn download(&mut self, texture: &wgpu::Texture) -> Result<Texels, GpuError> {
        let format = Format::ALL.into_iter().find(|format| texture_format(*format) == texture.format());
        let format = format.ok_or_else(|| GpuError::Format { what: format!("reading {:?} back", texture.format()) })?;
        let size = Size::volume(texture.width(), texture.height(), texture.depth_or_array_layers());
        let (row, pitch) = row_and_pitch(size, format);
        let buffer = self.buffer_of((pitch * rows(size)) as u64);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout: layout(size, pitch) };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        self.queue.submit([encoder.finish()]);
        map(&self.device, &buffer, wgpu::MapMode::Read)?;
        let bytes = {
            let mapped = buffer.slice(..).get_mapped_range().map_err(|error| GpuError::lost(&error))?;
            without_padding(&mapped, row, pitch)
        };
        buffer.unmap();
        self.buffer = Some(buffer);
        let volume = texture.dimension() == wgpu::TextureDimension::D3;
        Ok(Texels { desc: ImageDesc { size, format, volume }, bytes })
    }

    /// The first four numbers of a storage buffer. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`] if the device was lost.
    pub fn value(&self, source: &wgpu::Buffer) -> Result<[f32; 4], GpuError> {
        let copy = buffer(&self.device, "value", VALUE_BYTES, READABLE);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(source, 0, &copy, 0, VALUE_BYTES);
        self.queue.submit([encoder.finish()]);
        map(&self.device, &copy, wgpu::MapMode::Read)?;
        let mapped = copy.slice(..).get_mapped_range().map_err(|error| GpuError::lost(&error))?;
        Ok(bytemuck::pod_read_unaligned(&mapped))
    }

    /// The previous buffer if it has this size, otherwise a new one.
    fn buffer_of(&mut self, bytes: u64) -> wgpu::Buffer {
        let known = self.buffer.take().filter(|buffer| buffer.size() == bytes);
        known.unwrap_or_else(|| buffer(&self.device, "readback", bytes, READABLE))
    }
}

/// Reads many textures of known descriptions back through one buffer.
pub(crate) struct ReadbackBatch {
    device: wgpu::Device,
    buffer: wgpu::Buffer,
    descs: Vec<ImageDesc>,
    /// The number of textures that are copied so far, and their bytes.
    copied: (usize, u64),
}

impl ReadbackBatch {
    /// A batch of textures of these descriptions, in this order.
    pub(crate) fn new(device: &wgpu::Device, descs: Vec<ImageDesc>) -> Self {
        let size: u64 = descs.iter().map(padded_bytes).sum();
        let buffer = buffer(device, "readback", size.max(4), READABLE);
        Self { device: device.clone(), buffer, descs, copied: (0, 0) }
    }

    /// Records the copy of the next texture.
    pub(crate) fn copy(&mut self, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture) {
        let (number, offset) = self.copied;
        let desc = self.descs[number];
        debug_assert_eq!(texture.format(), texture_format(desc.format));
        let (_, pitch) = row_and_pitch(desc.size, desc.format);
        let layout = wgpu::TexelCopyBufferLayout { offset, ..layout(desc.size, pitch) };
        let to = wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        self.copied = (number + 1, offset + padded_bytes(&desc));
    }

    /// The texels of all textures, once the copies are submitted. Waits for the GPU.
    pub(crate) fn read(self) -> Result<Vec<Texels>, GpuError> {
        map(&self.device, &self.buffer, wgpu::MapMode::Read)?;
        let mapped = self.buffer.slice(..).get_mapped_range().map_err(|error| GpuError::lost(&error))?;
        let mut rest: &[u8] = &mapped;
        let texels = self.descs.iter().map(|desc| {
            let (padded, after) = rest.split_at(padded_bytes(desc) as usize);
            rest = after;
            let (row, pitch) = row_and_pitch(desc.size, desc.format);
            Texels { desc: *desc, bytes: without_padding(padded, row, pitch) }
        });
        Ok(texels.collect())
    }
}

/// Bytes of an image whose rows are padded for copies.
fn padded_bytes(desc: &ImageDesc) -> u64 {
    (row_and_pitch(desc.size, desc.format).1 * rows(desc.size)) as u64
}

/// Reads the texels of a texture. Waits for the GPU; use [`Readback`] for many textures.
pub fn download(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<Texels, GpuError> {
    Readback::new(device, queue).download(texture)
}

/// Maps a buffer. Waits for the GPU. Buffers of a lost device are invalid, which is a validation error in wgpu.
pub(crate) fn map(device: &wgpu::Device, buffer: &wgpu::Buffer, mode: wgpu::MapMode) -> Result<(), GpuError> {
    let validation = device.push_error_scope(wgpu::ErrorFilter::Validation);
    buffer.slice(..).map_async(mode, |_| {});
    if let Some(error) = pollster::block_on(validation.pop()) {
        return Err(GpuError::lost(&error));
    }
    device.poll(wgpu::PollType::wait_indefinitely()).map(drop).map_err(|error| GpuError::lost(&error))
}

/// Bytes of a row of texels, and the aligned distance between rows in a buffer.
fn row_and_pitch(size: Size, format: Format) -> (usize, usize) {
    let row = size.width as usize * format.bytes() as usize;
    (row, row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize))
}

fn rows(size: Size) -> usize {
    size.height as usize * size.depth as usize
}

fn layout(size: Size, pitch: usize) -> wgpu::TexelCopyBufferLayout {
    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch as u32), rows_per_image: Some(size.height) }
}

/// The rows without padding.
fn without_padding(padded: &[u8], row: usize, pitch: usize) -> Vec<u8> {
    if row == pitch {
        return padded.to_vec();
    }
    let mut bytes = Vec::with_capacity(padded.len() / pitch * row);
    padded.chunks_exact(pitch).for_each(|line| bytes.extend_from_slice(&line[..row]));
    bytes
}

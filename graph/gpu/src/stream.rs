//! Transfers of image sequences between the host and textures. Staging buffers are created once: allocating tens of
//! megabytes of pinned memory for each frame costs more than copying them.

use afterimage_base::color::Transfer;
use afterimage_graph::image::{Format, ImageDesc, Size};

use crate::buffer::buffer;
use crate::platform::{scoped, submit, wait, watched};
use crate::texture_format::texture_format;
use crate::{Gpu, GpuError, Texels, store};

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
    /// A texture for images of that description, which are not multisampled.
    ///
    /// # Errors
    /// The device is lost or has no memory for it.
    ///
    /// # Panics
    /// If the images are multisampled: [`upload_bytes`](crate::upload_bytes) makes these.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, desc: ImageDesc) -> Result<Self, GpuError> {
        assert!(desc.samples == 1, "a feed has one sample in each pixel");
        let stored = watched(device, "an input image", || Ok(store::create(device, desc, "input")))?;
        Ok(Self { device: device.clone(), queue: queue.clone(), stored, staging: None, is_filled: false })
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
    /// [`GpuError::DeviceLost`] if the device was lost, [`GpuError::OutOfMemory`] if it cannot hold the bytes on their
    /// way. The texture keeps the image before.
    pub fn fill(&mut self, bytes: &[u8]) -> Result<(), GpuError> {
        let size = self.stored.desc.size;
        let (_, pitch) = row_and_pitch(size, self.stored.desc.format);
        // No staging buffer can hold a very large one; wgpu copies it by its own.
        if !self.is_filled || (pitch * rows(size)) as u64 > self.device.limits().max_buffer_size {
            let upload = || store::upload(&self.queue, &self.stored.texture, self.stored.desc, bytes);
            scoped(&self.device, WHAT_FED, upload)?;
            self.is_filled = true;
            return Ok(());
        }
        let staging = self.stage(bytes)?;
        submit(&self.device, &self.queue, WHAT_FED, |encoder| {
            let from = wgpu::TexelCopyBufferInfo { buffer: &staging, layout: layout(size, pitch) };
            encoder.copy_buffer_to_texture(from, self.stored.texture.as_image_copy(), self.stored.texture.size());
            Ok::<(), GpuError>(())
        })?;
        self.staging = Some(staging);
        Ok(())
    }

    /// The staging buffer with these bytes, rows padded.
    fn stage(&mut self, bytes: &[u8]) -> Result<wgpu::Buffer, GpuError> {
        let size = self.stored.desc.size;
        let (row, pitch) = row_and_pitch(size, self.stored.desc.format);
        let staging = match self.staging.take() {
            Some(staging) => staging,
            None => {
                let usage = wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC;
                let new = || Ok(buffer(&self.device, "upload", (pitch * rows(size)) as u64, usage));
                watched(&self.device, WHAT_FED, new)?
            }
        };
        put(&self.device, &staging, bytes, row, pitch)?;
        Ok(staging)
    }
}

/// Puts rows into a buffer, and pads them. Waits for the GPU.
fn put(device: &wgpu::Device, staging: &wgpu::Buffer, bytes: &[u8], row: usize, pitch: usize) -> Result<(), GpuError> {
    map(device, staging, wgpu::MapMode::Write)?;
    let mut mapped = staging.slice(..).get_mapped_range_mut().map_err(|error| GpuError::lost(&error))?;
    if row == pitch {
        mapped.slice(..bytes.len()).copy_from_slice(bytes);
    } else {
        let lines = bytes.chunks_exact(row).enumerate();
        lines.for_each(|(y, line)| mapped.slice(y * pitch..y * pitch + row).copy_from_slice(line));
    }
    drop(mapped);
    staging.unmap();
    Ok(())
}

/// Uploads rows of textures through one buffer.
pub(crate) struct RowUpload {
    device: wgpu::Device,
    queue: wgpu::Queue,
    staging: wgpu::Buffer,
}

impl RowUpload {
    /// Through a buffer of that size, or of that of the longest row of these images.
    pub(crate) fn new(gpu: &Gpu, bytes: u64, images: impl Iterator<Item = ImageDesc>) -> Self {
        let all = images.map(|desc| (row_and_pitch(desc.size, desc.format).1 as u64, u64::from(desc.size.height)));
        let needed = all.map(|(pitch, rows)| pitch * rows.min(bytes / pitch).max(1));
        let usage = wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC;
        let staging = buffer(&gpu.device, "upload", needed.max().unwrap_or(4), usage);
        Self { device: gpu.device.clone(), queue: gpu.queue.clone(), staging }
    }

    /// Uploads rows without gaps, to those of a texture that begin with `first`. The slices of a volume are one below
    /// the other; these rows are within one.
    pub(crate) fn rows(&self, to: &store::Stored, first: u32, texels: &[u8]) -> Result<(), GpuError> {
        let (row, pitch) = row_and_pitch(to.desc.size, to.desc.format);
        let most = (self.staging.size() as usize / pitch).max(1);
        for (index, piece) in texels.chunks(most * row).enumerate() {
            put(&self.device, &self.staging, piece, row, pitch)?;
            let size = Size { height: (piece.len() / row) as u32, ..to.desc.size };
            let at = first + (index * most) as u32;
            let origin = wgpu::Origin3d { x: 0, y: at % to.desc.size.height, z: at / to.desc.size.height };
            submit(&self.device, &self.queue, "rows of an image", |encoder| {
                let from = wgpu::TexelCopyBufferInfo { buffer: &self.staging, layout: layout(size, pitch) };
                let to = wgpu::TexelCopyTextureInfo { origin, ..to.texture.as_image_copy() };
                let extent = wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: 1 };
                encoder.copy_buffer_to_texture(from, to, extent);
                Ok::<(), GpuError>(())
            })?;
        }
        Ok(())
    }
}

const WHAT_FED: &str = "the next input image";

/// Bytes of a value: one `vec4f`.
const VALUE_BYTES: u64 = 16;

const READABLE: wgpu::BufferUsages = wgpu::BufferUsages::MAP_READ.union(wgpu::BufferUsages::COPY_DST);

/// A buffer that copies end in.
fn readable(device: &wgpu::Device, label: &str, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
    watched(device, "the buffer to read back", || Ok(buffer(device, label, bytes, READABLE)))
}

/// Reads textures and values back, one after another.
pub struct Readback {
    device: wgpu::Device,
    queue: wgpu::Queue,
    buffer: Option<wgpu::Buffer>,
    /// Bytes that are read at a time.
    piece: u64,
}

/// A copy of this size is as fast as a larger one.
const PIECE: u64 = 256 << 20;

impl Readback {
    /// For textures of this device.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let piece = device.limits().max_buffer_size.min(PIECE);
        Self { device: device.clone(), queue: queue.clone(), buffer: None, piece }
    }

    /// Reads at most that many bytes at a time, and at least a row.
    #[must_use]
    pub fn in_pieces_of(self, bytes: u64) -> Self {
        Self { piece: bytes.min(self.piece), ..self }
    }

    /// Bytes of the buffer that the texels of such an image come through.
    pub(crate) fn bytes_of(&self, desc: &ImageDesc) -> u64 {
        let pitch = row_and_pitch(desc.size, desc.format).1 as u64;
        padded_bytes(desc).min(self.piece.max(pitch))
    }

    /// The texels of a texture, 32-bit depth as `R32Float`, without a stencil. Formats of 8 bits that no image of a
    /// plan has, such as those of windows, become `Rgba32Float`, with the numbers that shaders read: sRGB is decoded.
    /// Waits for the GPU. A texture that is larger than a buffer may be is read in pieces.
    ///
    /// # Errors
    /// [`GpuError::Format`] for a texture in another format, [`GpuError::DeviceLost`], [`GpuError::OutOfMemory`],
    /// [`GpuError::TimedOut`].
    pub fn download(&mut self, texture: &wgpu::Texture) -> Result<Texels, GpuError> {
        // Depth is copied as the floats that it is.
        let stored = match texture.format() {
            wgpu::TextureFormat::Depth32Float | wgpu::TextureFormat::Depth32FloatStencil8 => {
                wgpu::TextureFormat::R32Float
            }
            format => format,
        };
        let aspect = match texture.format().has_stencil_aspect() {
            true => wgpu::TextureAspect::DepthOnly,
            false => wgpu::TextureAspect::All,
        };
        let channels = channels_of_8_bits(stored);
        let (format, texel) = match channels {
            Some(channels) => (Format::Rgba32Float, channels.len()),
            None => format_to_read(stored).map(|format| (format, format.bytes() as usize))?,
        };
        let size = Size::volume(texture.width(), texture.height(), texture.depth_or_array_layers());
        let row = size.width as usize * texel;
        let pitch = pitch_of(row);
        let mut bytes = Vec::with_capacity(row * rows(size));
        for (origin, extent) in pieces(size, (self.piece / pitch as u64).max(1)) {
            let part = wgpu::TexelCopyTextureInfo { origin, aspect, ..texture.as_image_copy() };
            self.read(part, extent, row, pitch, &mut bytes)?;
        }
        if let Some(channels) = channels {
            bytes = floats_of_codes(&bytes, channels, stored.is_srgb());
        }
        let volume = texture.dimension() == wgpu::TextureDimension::D3;
        Ok(Texels { desc: ImageDesc { volume, ..ImageDesc::new(size).format(format) }, bytes })
    }

    /// Puts the texels of some rows of a texture into `bytes`, as [`download`](Self::download) gives them.
    pub(crate) fn rows(
        &mut self,
        texture: &wgpu::Texture,
        rows: std::ops::Range<u32>,
        bytes: &mut Vec<u8>,
    ) -> Result<(), GpuError> {
        let format = format_to_read(texture.format())?;
        let size = Size::new(texture.width(), rows.end - rows.start);
        let (row, pitch) = row_and_pitch(size, format);
        bytes.clear();
        bytes.reserve_exact(row * size.height as usize);
        for (mut origin, extent) in pieces(size, (self.piece / pitch as u64).max(1)) {
            origin.y += rows.start;
            let part = wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
            self.read(part, extent, row, pitch, bytes)?;
        }
        Ok(())
    }

    /// Appends the texels of a part of a texture.
    fn read(
        &mut self,
        part: wgpu::TexelCopyTextureInfo<'_>,
        extent: wgpu::Extent3d,
        row: usize,
        pitch: usize,
        bytes: &mut Vec<u8>,
    ) -> Result<(), GpuError> {
        let size = Size::volume(extent.width, extent.height, extent.depth_or_array_layers);
        let length = pitch * rows(size);
        let buffer = self.buffer_of(length as u64)?;
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout: layout(size, pitch) };
        submit(&self.device, &self.queue, "the copy of a texture", |encoder| {
            encoder.copy_texture_to_buffer(part, to, extent);
            Ok::<(), GpuError>(())
        })?;
        read_mapped(&self.device, &buffer, |mapped| append_without_padding(bytes, &mapped[..length], row, pitch))?;
        self.buffer = Some(buffer);
        Ok(())
    }

    /// The first four numbers of a storage buffer. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`], [`GpuError::OutOfMemory`], [`GpuError::TimedOut`].
    pub fn value(&self, source: &wgpu::Buffer) -> Result<[f32; 4], GpuError> {
        Ok(bytemuck::pod_read_unaligned(&self.bytes(source, VALUE_BYTES)?))
    }

    /// The first bytes of a storage buffer, a multiple of four. Waits for the GPU.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn bytes(&self, source: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, GpuError> {
        let copy = readable(&self.device, "value", bytes)?;
        submit(&self.device, &self.queue, "the copy of a value", |encoder| {
            encoder.copy_buffer_to_buffer(source, 0, &copy, 0, bytes);
            Ok::<(), GpuError>(())
        })?;
        read_mapped(&self.device, &copy, <[u8]>::to_vec)
    }

    /// The previous buffer if it has this size at least, otherwise a new one.
    fn buffer_of(&mut self, bytes: u64) -> Result<wgpu::Buffer, GpuError> {
        let known = self.buffer.take().filter(|buffer| buffer.size() >= bytes);
        known.map_or_else(|| readable(&self.device, "readback", bytes), Ok)
    }
}

/// Reads many textures of known descriptions back through one buffer.
pub struct ReadbackBatch {
    device: wgpu::Device,
    buffer: wgpu::Buffer,
    descs: Vec<ImageDesc>,
    /// The number of textures that are copied so far, and their bytes.
    copied: (usize, u64),
}

impl ReadbackBatch {
    /// A batch of textures of these descriptions, in this order.
    pub fn new(device: &wgpu::Device, descs: Vec<ImageDesc>) -> Result<Self, GpuError> {
        let size: u64 = descs.iter().map(padded_bytes).sum();
        let buffer = readable(device, "readback", size.max(4))?;
        Ok(Self { device: device.clone(), buffer, descs, copied: (0, 0) })
    }

    /// True if a buffer of the device can hold them all.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn fits(device: &wgpu::Device, descs: &[ImageDesc]) -> bool {
        descs.iter().map(padded_bytes).sum::<u64>() <= device.limits().max_buffer_size
    }

    /// Records the copy of the next texture.
    pub fn copy(&mut self, encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture) {
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
    pub fn read(self) -> Result<Vec<Texels>, GpuError> {
        read_mapped(&self.device, &self.buffer, |mut rest| {
            let mut texels = Vec::with_capacity(self.descs.len());
            for desc in &self.descs {
                let (padded, after) = rest.split_at(padded_bytes(desc) as usize);
                rest = after;
                let (row, pitch) = row_and_pitch(desc.size, desc.format);
                let mut bytes = Vec::with_capacity(row * rows(desc.size));
                append_without_padding(&mut bytes, padded, row, pitch);
                texels.push(Texels { desc: *desc, bytes });
            }
            texels
        })
    }
}

fn format_to_read(format: wgpu::TextureFormat) -> Result<Format, GpuError> {
    let same = Format::ALL.into_iter().find(|known| texture_format(*known) == format);
    same.ok_or_else(|| GpuError::Format { what: format!("reading {format:?} back") })
}

/// The places of red, green, blue and alpha in texels of 8 bits that no image of a plan has.
fn channels_of_8_bits(format: wgpu::TextureFormat) -> Option<&'static [usize]> {
    match format {
        wgpu::TextureFormat::R8Unorm => Some(&[0]),
        wgpu::TextureFormat::Rg8Unorm => Some(&[0, 1]),
        wgpu::TextureFormat::Rgba8UnormSrgb => Some(&[0, 1, 2, 3]),
        wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Bgra8UnormSrgb => Some(&[2, 1, 0, 3]),
        _ => None,
    }
}

/// Texels of `Rgba32Float` for such codes.
fn floats_of_codes(codes: &[u8], channels: &[usize], is_srgb: bool) -> Vec<u8> {
    let transfer = if is_srgb { Transfer::Srgb } else { Transfer::Linear };
    let color = |code: u8| transfer.to_light(f64::from(code) / 255.0) as f32;
    let mut floats: Vec<f32> = Vec::with_capacity(codes.len() / channels.len() * 4);
    for texel in codes.chunks_exact(channels.len()) {
        let code = |at: usize| channels.get(at).map(|place| texel[*place]);
        floats.extend([0, 1, 2].map(|at| code(at).map_or(0.0, color)));
        floats.push(code(3).map_or(1.0, |alpha| f32::from(alpha) / 255.0));
    }
    bytemuck::cast_slice(&floats).to_vec()
}

/// Bytes of an image whose rows are padded for copies.
fn padded_bytes(desc: &ImageDesc) -> u64 {
    (row_and_pitch(desc.size, desc.format).1 * rows(desc.size)) as u64
}

/// Reads the texels of a texture as shaders read them: those of sRGB formats are decoded to light. Waits for the GPU;
/// use [`Readback`] for many textures.
pub fn download(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<Texels, GpuError> {
    Readback::new(device, queue).download(texture)
}

/// Maps a buffer. Waits for the GPU. Buffers of a lost device are invalid, which is a validation error in wgpu.
fn map(device: &wgpu::Device, buffer: &wgpu::Buffer, mode: wgpu::MapMode) -> Result<(), GpuError> {
    scoped(device, "a buffer for the host", || {
        buffer.slice(..).map_async(mode, |_| {});
        wait(device, None)
    })
}

/// Gives the bytes of a buffer to `read`. Waits for the GPU.
pub(crate) fn read_mapped<T>(
    device: &wgpu::Device,
    buffer: &wgpu::Buffer,
    read: impl FnOnce(&[u8]) -> T,
) -> Result<T, GpuError> {
    map(device, buffer, wgpu::MapMode::Read)?;
    let mapped = buffer.slice(..).get_mapped_range().map_err(|error| GpuError::lost(&error))?;
    let result = read(&mapped);
    drop(mapped);
    buffer.unmap();
    Ok(result)
}

/// Bytes of a row of texels, and the aligned distance between rows in a buffer.
fn row_and_pitch(size: Size, format: Format) -> (usize, usize) {
    let row = size.width as usize * format.bytes() as usize;
    (row, pitch_of(row))
}

fn pitch_of(row: usize) -> usize {
    row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize)
}

fn rows(size: Size) -> usize {
    size.height as usize * size.depth as usize
}

fn layout(size: Size, pitch: usize) -> wgpu::TexelCopyBufferLayout {
    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch as u32), rows_per_image: Some(size.height) }
}

/// Appends the rows without padding.
fn append_without_padding(bytes: &mut Vec<u8>, padded: &[u8], row: usize, pitch: usize) {
    if row == pitch {
        return bytes.extend_from_slice(padded);
    }
    padded.chunks_exact(pitch).for_each(|line| bytes.extend_from_slice(&line[..row]));
}

/// The parts of a texture in the order of its texels, of at most `most` rows each: whole slices, or rows of one.
fn pieces(size: Size, most: u64) -> Vec<(wgpu::Origin3d, wgpu::Extent3d)> {
    let slices = (most / u64::from(size.height)).clamp(1, size.depth.into()) as u32;
    let lines = most.min(size.height.into()) as u32;
    let mut parts = Vec::new();
    for z in (0..size.depth).step_by(slices as usize) {
        for y in (0..size.height).step_by(lines as usize) {
            let (height, depth) = (lines.min(size.height - y), slices.min(size.depth - z));
            let extent = wgpu::Extent3d { width: size.width, height, depth_or_array_layers: depth };
            parts.push((wgpu::Origin3d { x: 0, y, z }, extent));
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slices and the rows of each piece.
    fn ranges(size: Size, most: u64) -> Vec<(std::ops::Range<u32>, std::ops::Range<u32>)> {
        let range = |from: u32, length: u32| from..from + length;
        let parts = pieces(size, most).into_iter();
        parts.map(|(at, part)| (range(at.z, part.depth_or_array_layers), range(at.y, part.height))).collect()
    }

    #[test]
    fn pieces_cover_each_row_once_in_order() {
        assert_eq!(ranges(Size::new(9, 7), 100), [(0..1, 0..7)]);
        assert_eq!(ranges(Size::new(9, 7), 3), [(0..1, 0..3), (0..1, 3..6), (0..1, 6..7)]);
        assert_eq!(ranges(Size::volume(9, 2, 5), 4), [(0..2, 0..2), (2..4, 0..2), (4..5, 0..2)]);
        assert_eq!(ranges(Size::volume(9, 2, 2), 1), [(0..1, 0..1), (0..1, 1..2), (1..2, 0..1), (1..2, 1..2)]);
        for (height, depth, most) in [(1, 1, 1), (13, 1, 5), (4, 6, 9), (4, 6, 3)] {
            let rows: Vec<_> = ranges(Size::volume(3, height, depth), most)
                .into_iter()
                .flat_map(|(slices, rows)| slices.flat_map(move |z| rows.clone().map(move |y| (z, y))))
                .collect();
            let all: Vec<_> = (0..depth).flat_map(|z| (0..height).map(move |y| (z, y))).collect();
            assert_eq!(rows, all, "{height} rows, {depth} slices, {most} at most");
        }
    }
}

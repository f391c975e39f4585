//! Textures of images.

use afterimage_graph::image::ImageDesc;
use wgpu::{TextureUsages, TextureViewDimension};

use crate::buffer::buffer;
use crate::error::GpuError;
use crate::platform::caught;
use crate::texture_format::texture_format;

/// A texture and the view that all bind groups use.
#[derive(Clone)]
pub(crate) struct Stored {
    pub(crate) texture: wgpu::Texture,
    pub(crate) view: wgpu::TextureView,
    pub(crate) desc: ImageDesc,
}

/// The usages that any image of that description may need.
pub(crate) fn usages(device: &wgpu::Device, desc: ImageDesc) -> TextureUsages {
    let format = texture_format(desc.format);
    let mut usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
    let features = device.features();
    let guaranteed = format.guaranteed_format_features(features).allowed_usages;
    let specific = features.contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
    for wanted in [TextureUsages::STORAGE_BINDING, TextureUsages::RENDER_ATTACHMENT] {
        if guaranteed.contains(wanted) || specific && wanted == TextureUsages::STORAGE_BINDING {
            usage |= wanted;
        }
    }
    if desc.samples > 1 || desc.format.is_depth() {
        return TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    }
    // Volumes are never drawn to.
    if desc.volume { usage - TextureUsages::RENDER_ATTACHMENT } else { usage }
}

/// The wgpu descriptor of an image, with every usage that a pass may need.
pub(crate) fn descriptor<'l>(device: &wgpu::Device, desc: ImageDesc, label: &'l str) -> wgpu::TextureDescriptor<'l> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size: extent(desc),
        mip_level_count: desc.levels,
        sample_count: desc.samples,
        dimension: if desc.volume { wgpu::TextureDimension::D3 } else { wgpu::TextureDimension::D2 },
        format: texture_format(desc.format),
        usage: usages(device, desc),
        view_formats: &[],
    }
}

pub(crate) fn create(device: &wgpu::Device, desc: ImageDesc, label: &str) -> Stored {
    let texture = device.create_texture(&descriptor(device, desc, label));
    let view = view(&texture, desc);
    Stored { texture, view, desc }
}

/// A view of the whole texture, or of all levels of the first layer of an array.
pub(crate) fn view(texture: &wgpu::Texture, desc: ImageDesc) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(if desc.volume { TextureViewDimension::D3 } else { TextureViewDimension::D2 }),
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// A view of one mip level of one layer.
pub fn part_view(texture: &wgpu::Texture, level: u32, layer: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2),
        base_mip_level: level,
        mip_level_count: Some(1),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
}

/// The view of one mip level of one layer of an image. A view of the host may be of any level of its texture.
pub(crate) fn level_view(view: &wgpu::TextureView, desc: ImageDesc, level: u32, layer: u32) -> wgpu::TextureView {
    let is_whole = desc.levels == 1 && desc.layers == 1;
    if is_whole { view.clone() } else { part_view(view.texture(), level, layer) }
}

pub(crate) fn extent(desc: ImageDesc) -> wgpu::Extent3d {
    let depth_or_array_layers = if desc.volume { desc.size.depth } else { desc.layers };
    wgpu::Extent3d { width: desc.size.width, height: desc.size.height, depth_or_array_layers }
}

/// Fills a texture from tightly packed texels.
pub(crate) fn upload(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    desc: ImageDesc,
    bytes: &[u8],
) -> Result<(), GpuError> {
    upload_part(queue, texture.as_image_copy(), desc, bytes)
}

/// Fills a part of a texture, which has that description, from tightly packed texels.
pub(crate) fn upload_part(
    queue: &wgpu::Queue,
    to: wgpu::TexelCopyTextureInfo<'_>,
    desc: ImageDesc,
    bytes: &[u8],
) -> Result<(), GpuError> {
    let write = || {
        queue.write_texture(
            to,
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(desc.size.width * desc.format.bytes() as u32),
                rows_per_image: Some(desc.size.height),
            },
            extent(desc),
        )
    };
    caught("the texels of a texture", write)
}

/// Clears a texture to zero: a depth by a pass, others by a copy where the device has no clear command.
pub(crate) fn clear(device: &wgpu::Device, stored: &Stored, encoder: &mut wgpu::CommandEncoder) {
    if stored.desc.format.is_depth() {
        return clear_depth(stored, encoder);
    }
    if device.features().contains(wgpu::Features::CLEAR_TEXTURE) {
        encoder.clear_texture(&stored.texture, &wgpu::ImageSubresourceRange::default());
        return;
    }
    let size = stored.desc.size;
    let row = size.width * stored.desc.format.bytes() as u32;
    let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let bytes = u64::from(pitch) * u64::from(size.height) * u64::from(size.depth);
    let zeros = buffer(device, "zeros", bytes, wgpu::BufferUsages::COPY_SRC);
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: Some(size.height) };
    let zeros = wgpu::TexelCopyBufferInfo { buffer: &zeros, layout };
    encoder.copy_buffer_to_texture(zeros, stored.texture.as_image_copy(), extent(stored.desc));
}

/// Copies all levels and layers of a texture to another one of the same description, which is no depth and has one
/// sample in each pixel.
pub(crate) fn copy(from: &Stored, to: &Stored, encoder: &mut wgpu::CommandEncoder) {
    let part = |texture, mip_level| wgpu::TexelCopyTextureInfo {
        texture,
        mip_level,
        origin: wgpu::Origin3d::ZERO,
        aspect: wgpu::TextureAspect::All,
    };
    for level in 0..from.desc.levels {
        let size = extent(from.desc).mip_level_size(level, from.texture.dimension());
        encoder.copy_texture_to_texture(part(&from.texture, level), part(&to.texture, level), size);
    }
}

/// Nothing is copied to a depth.
fn clear_depth(stored: &Stored, encoder: &mut wgpu::CommandEncoder) {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store };
    drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("afterimage"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &stored.view,
            depth_ops: Some(ops),
            stencil_ops: None,
        }),
        ..Default::default()
    }));
}

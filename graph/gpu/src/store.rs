//! The textures of an executor, and which of them the next plan reuses.

use afterimage_graph::image::ImageDesc;
use rustc_hash::FxHashMap;
use slotmap::SlotMap;
use wgpu::{TextureUsages, TextureViewDimension};

use crate::GpuError;
use crate::buffer::buffer;
use crate::device::texture_format;
use crate::platform::caught;

slotmap::new_key_type! {
    /// A texture in the store. The key of a removed texture finds nothing, so no stale texture is ever bound.
    pub(crate) struct TextureKey;
}

/// A texture and the view that all bind groups use.
#[derive(Clone)]
pub(crate) struct Stored {
    pub(crate) texture: wgpu::Texture,
    pub(crate) view: wgpu::TextureView,
    pub(crate) desc: ImageDesc,
}

/// All textures of an executor.
#[derive(Default)]
pub(crate) struct Store {
    textures: SlotMap<TextureKey, Stored>,
    /// Textures of the previous plan that the plan being loaded may take.
    spare: Vec<TextureKey>,
    /// Textures created for the plan being loaded.
    new: Vec<TextureKey>,
    constants: FxHashMap<(ImageDesc, Vec<u8>), TextureKey>,
    /// The constants of the plan being loaded.
    wanted: Vec<TextureKey>,
}

impl Store {
    pub(crate) fn get(&self, key: TextureKey) -> &Stored {
        &self.textures[key]
    }

    pub(crate) fn insert(&mut self, stored: Stored) -> TextureKey {
        let key = self.textures.insert(stored);
        self.new.push(key);
        key
    }

    /// A texture that holds zeros.
    pub(crate) fn black(&mut self, device: &wgpu::Device, desc: ImageDesc, label: &str) -> TextureKey {
        self.insert(create(device, desc, label))
    }

    pub(crate) fn remove(&mut self, key: TextureKey) {
        self.textures.remove(key);
    }

    /// Offers textures of the old plan to the next plan, each once: several images of a plan may share a texture.
    pub(crate) fn retire(&mut self, keys: impl IntoIterator<Item = TextureKey>) {
        for key in keys {
            if !self.spare.contains(&key) {
                self.spare.push(key);
            }
        }
    }

    /// A texture of that description, from the old plan or new. Its contents are undefined.
    pub(crate) fn take(&mut self, device: &wgpu::Device, desc: ImageDesc, label: &str) -> TextureKey {
        let fits = |key: &TextureKey| self.textures.get(*key).is_some_and(|stored| stored.desc == desc);
        match self.spare.iter().position(fits) {
            Some(at) => self.spare.swap_remove(at),
            None => self.insert(create(device, desc, label)),
        }
    }

    /// The texture with these constant texels; created and filled on first use.
    pub(crate) fn constant(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        desc: ImageDesc,
        bytes: &[u8],
    ) -> Result<TextureKey, GpuError> {
        let content = (desc, bytes.to_vec());
        if let Some(key) = self.constants.get(&content) {
            self.wanted.push(*key);
            return Ok(*key);
        }
        let stored = create(device, desc, "constant");
        upload(queue, &stored.texture, desc, bytes)?;
        let key = self.insert(stored);
        self.constants.insert(content, key);
        self.wanted.push(key);
        Ok(key)
    }

    /// Frees what the loaded plan did not take.
    pub(crate) fn sweep(&mut self) {
        self.new.clear();
        let wanted = std::mem::take(&mut self.wanted);
        let unwanted = self.constants.extract_if(|_, key| !wanted.contains(key)).map(|(_, key)| key);
        for key in std::mem::take(&mut self.spare).into_iter().chain(unwanted) {
            self.textures.remove(key);
        }
    }

    /// Frees what was created for a plan that failed to load. The old plan keeps its textures.
    pub(crate) fn abandon(&mut self) {
        self.spare.clear();
        self.wanted.clear();
        for key in std::mem::take(&mut self.new) {
            self.textures.remove(key);
        }
        self.constants.retain(|_, key| self.textures.contains_key(*key));
    }
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

/// A new texture.
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
pub(crate) fn part_view(texture: &wgpu::Texture, level: u32, layer: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2),
        base_mip_level: level,
        mip_level_count: Some(1),
        base_array_layer: layer,
        array_layer_count: Some(1),
        ..Default::default()
    })
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
    let write = || {
        queue.write_texture(
            texture.as_image_copy(),
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
pub(crate) fn blacken(device: &wgpu::Device, stored: &Stored, encoder: &mut wgpu::CommandEncoder) {
    if stored.desc.format.is_depth() {
        return blacken_depth(stored, encoder);
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

/// Nothing is copied to a depth.
fn blacken_depth(stored: &Stored, encoder: &mut wgpu::CommandEncoder) {
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

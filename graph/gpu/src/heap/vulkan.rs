//! Memory from Vulkan: the images are created through it, bound to one allocation and imported into wgpu, which tracks
//! them and destroys them when the GPU has finished, like any other texture.
#![allow(
    unsafe_code,
    reason = "memory cannot be placed through wgpu's safe interface; every block has its proof beside it"
)]

use std::sync::Arc;

use afterimage_graph::image::{Format, ImageDesc};
use ash::vk;
use wgpu::hal::api::Vulkan;

use super::requirements::MemoryRequirements;
use crate::store::{self, Stored, usages, view};

/// Memory for the transient images of a plan, and of the plan after it where they fit.
pub(crate) struct Heap {
    // Declared before the device, because fields are dropped in this order and the memory must not outlive the device.
    block: Arc<Block>,
    device: wgpu::Device,
    pub(super) bytes: u64,
    pub(super) memory_type: u32,
}

/// An allocation, shared by the heap and by every image in it. The last owner frees it.
struct Block {
    raw: ash::Device,
    memory: vk::DeviceMemory,
}

impl Drop for Block {
    fn drop(&mut self) {
        // SAFETY: the heap keeps the device alive. wgpu destroys a texture while its device exists and only after the
        // GPU has finished with it, so nothing uses the memory any more.
        unsafe { self.raw.free_memory(self.memory, None) };
    }
}

impl Heap {
    /// Allocates device-local memory of one of the given types; `None` where the backend is not Vulkan or has no such
    /// memory.
    pub(super) fn new(device: &wgpu::Device, bytes: u64, types: u32) -> Option<Self> {
        // SAFETY: the guard is dropped before this function returns, and the device is not destroyed through it.
        let hal = unsafe { device.as_hal::<Vulkan>() }?;
        let instance = hal.shared_instance().raw_instance();
        // SAFETY: the physical device belongs to this instance.
        let properties = unsafe { instance.get_physical_device_memory_properties(hal.raw_physical_device()) };
        let suits = |index: &u32| {
            let local = vk::MemoryPropertyFlags::DEVICE_LOCAL;
            types & (1 << index) != 0 && properties.memory_types[*index as usize].property_flags.contains(local)
        };
        let memory_type = (0..properties.memory_type_count).find(suits)?;
        let info = vk::MemoryAllocateInfo::default().allocation_size(bytes).memory_type_index(memory_type);
        // SAFETY: the type index is one of the device's; the allocation is freed by `Block`.
        let memory = unsafe { hal.raw_device().allocate_memory(&info, None) }.ok()?;
        let block = Arc::new(Block { raw: hal.raw_device().clone(), memory });
        drop(hal);
        Some(Self { block, device: device.clone(), bytes, memory_type })
    }

    /// Creates an image at an offset of the allocation.
    pub(super) fn place(&self, desc: ImageDesc, offset: u64, label: &str) -> Option<Stored> {
        // SAFETY: as in `new`.
        let hal = unsafe { self.device.as_hal::<Vulkan>() }?;
        let image = create_image(hal.raw_device(), &self.device, &desc)?;
        // SAFETY: the image is new and unbound. The plan's offset has the alignment and leaves the bytes that the
        // driver requires.
        let bound = unsafe { hal.raw_device().bind_image_memory(image, self.block.memory, offset) };
        if bound.is_err() {
            // SAFETY: this function created the image, and nothing uses it.
            unsafe { hal.raw_device().destroy_image(image, None) };
            return None;
        }
        let descriptor = store::descriptor(&self.device, desc, label);
        let hal_desc = hal_descriptor(&descriptor);
        let memory = wgpu::hal::vulkan::TextureMemory::External;
        let block = self.block.clone();
        let destroy = move || {
            // SAFETY: wgpu calls this once, after the GPU has finished with the image and before the device is
            // destroyed.
            unsafe { block.raw.destroy_image(image, None) };
            drop(block);
        };
        // SAFETY: the image was created with the properties in `hal_desc`. `destroy` destroys it and keeps its memory
        // alive until then.
        let hal_texture = unsafe { hal.texture_from_raw(image, &hal_desc, Some(Box::new(destroy)), memory) };
        drop(hal);
        // SAFETY: the texture comes from this device and matches the descriptor. Its contents are undefined: the plan
        // never reads an image before a pass has written all of it.
        let texture = unsafe {
            self.device.create_texture_from_hal::<Vulkan>(hal_texture, &descriptor, wgpu::TextureUses::UNINITIALIZED)
        };
        let view = view(&texture, desc);
        Some(Stored { texture, view, desc })
    }
}

/// The memory requirements of an image by the driver; `None` where the backend is not Vulkan.
pub(super) fn requirements(device: &wgpu::Device, desc: &ImageDesc) -> Option<MemoryRequirements> {
    // SAFETY: as in `Heap::new`.
    let hal = unsafe { device.as_hal::<Vulkan>() }?;
    let image = create_image(hal.raw_device(), device, desc)?;
    // SAFETY: the image was created above, and nothing else refers to it.
    unsafe {
        let requirements = hal.raw_device().get_image_memory_requirements(image);
        hal.raw_device().destroy_image(image, None);
        let vk::MemoryRequirements { size, alignment, memory_type_bits, .. } = requirements;
        Some(MemoryRequirements { bytes: size, alignment, memory_types: memory_type_bits })
    }
}

fn create_image(raw: &ash::Device, device: &wgpu::Device, desc: &ImageDesc) -> Option<vk::Image> {
    let info = vk::ImageCreateInfo::default()
        .flags(vk::ImageCreateFlags::ALIAS)
        .image_type(if desc.volume { vk::ImageType::TYPE_3D } else { vk::ImageType::TYPE_2D })
        .format(vulkan_format(desc.format))
        .extent(vk::Extent3D { width: desc.size.width, height: desc.size.height, depth: desc.size.depth })
        .mip_levels(desc.levels)
        .array_layers(desc.layers)
        .samples(vk::SampleCountFlags::from_raw(desc.samples))
        .tiling(vk::ImageTiling::OPTIMAL)
        .usage(vulkan_usage(usages(device, *desc), desc.format))
        .sharing_mode(vk::SharingMode::EXCLUSIVE)
        .initial_layout(vk::ImageLayout::UNDEFINED);
    // SAFETY: the description is complete and within the device's limits, which the planner checks.
    unsafe { raw.create_image(&info, None) }.ok()
}

fn vulkan_format(format: Format) -> vk::Format {
    match format {
        Format::Rgba8Unorm => vk::Format::R8G8B8A8_UNORM,
        Format::R16Float => vk::Format::R16_SFLOAT,
        Format::Rg16Float => vk::Format::R16G16_SFLOAT,
        Format::Rgba16Float => vk::Format::R16G16B16A16_SFLOAT,
        Format::Rg11b10Ufloat => vk::Format::B10G11R11_UFLOAT_PACK32,
        Format::Rgb10a2Unorm => vk::Format::A2B10G10R10_UNORM_PACK32,
        Format::R32Float => vk::Format::R32_SFLOAT,
        Format::Rgba32Float => vk::Format::R32G32B32A32_SFLOAT,
        Format::Depth16Unorm => vk::Format::D16_UNORM,
        Format::Depth32Float => vk::Format::D32_SFLOAT,
    }
}

fn hal_descriptor<'l>(descriptor: &wgpu::TextureDescriptor<'l>) -> wgpu::hal::TextureDescriptor<'l> {
    wgpu::hal::TextureDescriptor {
        label: descriptor.label,
        size: descriptor.size,
        mip_level_count: descriptor.mip_level_count,
        sample_count: descriptor.sample_count,
        dimension: descriptor.dimension,
        format: descriptor.format,
        usage: hal_usage(descriptor.usage),
        memory_flags: wgpu::hal::MemoryFlags::empty(),
        view_formats: Vec::new(),
    }
}

const USAGES: [(wgpu::TextureUsages, wgpu::TextureUses, vk::ImageUsageFlags); 5] = [
    (wgpu::TextureUsages::COPY_SRC, wgpu::TextureUses::COPY_SRC, vk::ImageUsageFlags::TRANSFER_SRC),
    (wgpu::TextureUsages::COPY_DST, wgpu::TextureUses::COPY_DST, vk::ImageUsageFlags::TRANSFER_DST),
    (wgpu::TextureUsages::TEXTURE_BINDING, wgpu::TextureUses::RESOURCE, vk::ImageUsageFlags::SAMPLED),
    (wgpu::TextureUsages::STORAGE_BINDING, wgpu::TextureUses::STORAGE_WRITE_ONLY, vk::ImageUsageFlags::STORAGE),
    (wgpu::TextureUsages::RENDER_ATTACHMENT, wgpu::TextureUses::COLOR_TARGET, vk::ImageUsageFlags::COLOR_ATTACHMENT),
];

fn hal_usage(usage: wgpu::TextureUsages) -> wgpu::TextureUses {
    USAGES.iter().filter(|(known, ..)| usage.contains(*known)).map(|(_, hal, _)| *hal).collect()
}

fn vulkan_usage(usage: wgpu::TextureUsages, format: Format) -> vk::ImageUsageFlags {
    let of_format = |vk: vk::ImageUsageFlags| match vk {
        vk::ImageUsageFlags::COLOR_ATTACHMENT if format.is_depth() => vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        vk => vk,
    };
    USAGES
        .iter()
        .filter(|(known, ..)| usage.contains(*known))
        .fold(vk::ImageUsageFlags::empty(), |all, (.., vk)| all | of_format(*vk))
}

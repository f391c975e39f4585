//! Images of a renderer with a Vulkan device of its own, shared with ours without a copy: by memory that both devices
//! know by a file descriptor. The processor waits between the two: lavapipe shares no semaphores, and wgpu has none of
//! their extensions without a device that is opened by a callback.
#![allow(unsafe_code, reason = "Vulkan has no other interface")]

use afterimage::Post;
use afterimage_gpu::{Frame, Gpu, download, upload, wanted_features, wgpu};
use afterimage_graph::image::Size;
use ash::{khr, vk};
use wgpu::hal::api::Vulkan;

use super::{assert_same, scene_texels};
use crate::support::gpu::{Shared, another_device, changed, gpu};

const SIZE: Size = Size { width: 96, height: 54, depth: 1 };
const HANDLE: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_FD;
const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// An image that two devices know.
#[derive(Clone, Copy)]
struct Kind {
    format: wgpu::TextureFormat,
    raw: vk::Format,
    texel: u64,
    usage: vk::ImageUsageFlags,
}

const LIGHT: Kind = Kind {
    format: wgpu::TextureFormat::Rgba16Float,
    raw: vk::Format::R16G16B16A16_SFLOAT,
    texel: 8,
    usage: both(vk::ImageUsageFlags::TRANSFER_DST, vk::ImageUsageFlags::SAMPLED),
};
const CODES: Kind = Kind {
    format: wgpu::TextureFormat::Rgba8Unorm,
    raw: vk::Format::R8G8B8A8_UNORM,
    texel: 4,
    usage: both(vk::ImageUsageFlags::TRANSFER_SRC, vk::ImageUsageFlags::COLOR_ATTACHMENT),
};

const fn both(one: vk::ImageUsageFlags, other: vk::ImageUsageFlags) -> vk::ImageUsageFlags {
    vk::ImageUsageFlags::from_raw(one.as_raw() | other.as_raw())
}

fn image(device: &ash::Device, kind: Kind) -> vk::Image {
    let mut shared = vk::ExternalMemoryImageCreateInfo::default().handle_types(HANDLE);
    let info = vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(kind.raw)
        .extent(vk::Extent3D { width: SIZE.width, height: SIZE.height, depth: 1 })
        .mip_levels(1)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .usage(kind.usage)
        .push_next(&mut shared);
    // SAFETY: the description is complete.
    unsafe { device.create_image(&info, None) }.expect("an image")
}

/// A transition of an image from or to the other device.
fn hand_over(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    image: vk::Image,
    layouts: [vk::ImageLayout; 2],
    families: [u32; 2],
) {
    let barrier = vk::ImageMemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
        .old_layout(layouts[0])
        .new_layout(layouts[1])
        .src_queue_family_index(families[0])
        .dst_queue_family_index(families[1])
        .image(image)
        .subresource_range(COLOR);
    let all = vk::PipelineStageFlags::ALL_COMMANDS;
    // SAFETY: the commands are being recorded, and the image is of this device.
    unsafe { device.cmd_pipeline_barrier(commands, all, all, vk::DependencyFlags::empty(), &[], &[], &[barrier]) };
}

/// The renderer: another instance and another device on the same hardware.
struct Renderer {
    _entry: ash::Entry,
    instance: ash::Instance,
    physical: vk::PhysicalDevice,
    device: ash::Device,
    queue: vk::Queue,
    commands: vk::CommandBuffer,
    memory_fd: khr::external_memory_fd::Device,
}

impl Renderer {
    fn new(uuid: [u8; vk::UUID_SIZE]) -> Self {
        // SAFETY: what is made lives until the process ends, and each description is complete.
        unsafe {
            let entry = ash::Entry::load().expect("Vulkan");
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_1);
            let instance = entry
                .create_instance(&vk::InstanceCreateInfo::default().application_info(&application), None)
                .expect("an instance");
            let devices = instance.enumerate_physical_devices().expect("devices");
            let physical = devices.into_iter().find(|device| uuid_of(&instance, *device) == uuid).expect("the same");
            let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
            let extensions = [khr::external_memory_fd::NAME.as_ptr()];
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&extensions);
            let device = instance.create_device(physical, &info, None).expect("a device");
            let info = vk::CommandPoolCreateInfo::default().flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&info, None).expect("a pool");
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info).expect("commands")[0];
            let memory_fd = khr::external_memory_fd::Device::new(&instance, &device);
            let queue = device.get_device_queue(0, 0);
            Self { _entry: entry, instance, physical, device, queue, commands, memory_fd }
        }
    }

    fn memory(&self, requirements: vk::MemoryRequirements, wanted: vk::MemoryPropertyFlags) -> u32 {
        // SAFETY: the physical device is of this instance.
        let known = unsafe { self.instance.get_physical_device_memory_properties(self.physical) };
        let suits = |index: &u32| {
            requirements.memory_type_bits & (1 << index) != 0
                && known.memory_types[*index as usize].property_flags.contains(wanted)
        };
        (0..known.memory_type_count).find(suits).expect("a type of memory")
    }

    /// An image whose memory the other device can have, its bytes and the type of its memory.
    fn shared_image(&self, kind: Kind) -> (vk::Image, i32, u64, u32) {
        let image = image(&self.device, kind);
        // SAFETY: the image is new, and the memory is for it alone.
        unsafe {
            let requirements = self.device.get_image_memory_requirements(image);
            let index = self.memory(requirements, vk::MemoryPropertyFlags::DEVICE_LOCAL);
            let mut export = vk::ExportMemoryAllocateInfo::default().handle_types(HANDLE);
            let mut alone = vk::MemoryDedicatedAllocateInfo::default().image(image);
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(requirements.size)
                .memory_type_index(index)
                .push_next(&mut export)
                .push_next(&mut alone);
            let memory = self.device.allocate_memory(&info, None).expect("memory");
            self.device.bind_image_memory(image, memory, 0).expect("it is bound");
            let info = vk::MemoryGetFdInfoKHR::default().memory(memory).handle_type(HANDLE);
            let fd = self.memory_fd.get_memory_fd(&info).expect("a file descriptor");
            (image, fd, requirements.size, index)
        }
    }

    /// Memory for the texels of an image that the processor can use.
    fn texels(&self, kind: Kind) -> (vk::Buffer, *mut u8, usize) {
        let bytes = SIZE.texels() * kind.texel;
        // SAFETY: the buffer is new, and the memory is for it alone.
        unsafe {
            let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
            let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
            let buffer = self.device.create_buffer(&info, None).expect("a buffer");
            let requirements = self.device.get_buffer_memory_requirements(buffer);
            let wanted = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
            let info = vk::MemoryAllocateInfo::default()
                .allocation_size(requirements.size)
                .memory_type_index(self.memory(requirements, wanted));
            let memory = self.device.allocate_memory(&info, None).expect("memory");
            self.device.bind_buffer_memory(buffer, memory, 0).expect("it is bound");
            let mapped = self.device.map_memory(memory, 0, bytes, vk::MemoryMapFlags::empty()).expect("it is mapped");
            (buffer, mapped.cast(), bytes as usize)
        }
    }

    /// Runs commands, and waits for them.
    fn run(&self, record: impl FnOnce(vk::CommandBuffer)) {
        // SAFETY: the commands of the run before are done, and this thread alone uses the queue.
        unsafe {
            let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            self.device.begin_command_buffer(self.commands, &info).expect("it begins");
            record(self.commands);
            self.device.end_command_buffer(self.commands).expect("it ends");
            let commands = [self.commands];
            let info = vk::SubmitInfo::default().command_buffers(&commands);
            self.device.queue_submit(self.queue, &[info], vk::Fence::null()).expect("it is submitted");
            self.device.queue_wait_idle(self.queue).expect("it is done");
        }
    }

    fn copy(&self) -> vk::BufferImageCopy {
        let layers = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
        let extent = vk::Extent3D { width: SIZE.width, height: SIZE.height, depth: 1 };
        vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent)
    }
}

fn uuid_of(instance: &ash::Instance, device: vk::PhysicalDevice) -> [u8; vk::UUID_SIZE] {
    let mut ids = vk::PhysicalDeviceIDProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut ids);
    // SAFETY: the physical device is of this instance.
    unsafe { instance.get_physical_device_properties2(device, &mut properties) };
    ids.device_uuid
}

/// The texture of an image of the renderer. wgpu owns it.
fn import(gpu: &Gpu, kind: Kind, fd: i32, bytes: u64, memory_type: u32, state: wgpu::TextureUses) -> wgpu::Texture {
    let of_input = kind.usage.contains(vk::ImageUsageFlags::SAMPLED);
    let usage = match of_input {
        true => wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        false => wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
    };
    let uses = match of_input {
        true => wgpu::TextureUses::RESOURCE | wgpu::TextureUses::COPY_DST,
        false => wgpu::TextureUses::COLOR_TARGET | wgpu::TextureUses::COPY_SRC,
    };
    let size = wgpu::Extent3d { width: SIZE.width, height: SIZE.height, depth_or_array_layers: 1 };
    let (mip_level_count, sample_count, dimension, format) = (1, 1, wgpu::TextureDimension::D2, kind.format);
    let label = Some("an image of the renderer");
    // SAFETY: the image is described like that of the renderer, whose memory it has, and is in this state when a frame
    // reads it.
    unsafe {
        let hal = gpu.device.as_hal::<Vulkan>().expect("Vulkan");
        let raw = hal.raw_device();
        let image = image(raw, kind);
        let mut import = vk::ImportMemoryFdInfoKHR::default().handle_type(HANDLE).fd(fd);
        let mut alone = vk::MemoryDedicatedAllocateInfo::default().image(image);
        let info = vk::MemoryAllocateInfo::default()
            .allocation_size(bytes)
            .memory_type_index(memory_type)
            .push_next(&mut import)
            .push_next(&mut alone);
        let memory = raw.allocate_memory(&info, None).expect("the memory of the renderer");
        raw.bind_image_memory(image, memory, 0).expect("it is bound");
        let descriptor = wgpu::hal::TextureDescriptor {
            label,
            size,
            mip_level_count,
            sample_count,
            dimension,
            format,
            usage: uses,
            memory_flags: wgpu::hal::MemoryFlags::empty(),
            view_formats: Vec::new(),
        };
        let memory = wgpu::hal::vulkan::TextureMemory::Dedicated(memory);
        let texture = hal.texture_from_raw(image, &descriptor, None, memory);
        drop(hal);
        let view_formats = &[];
        let descriptor = wgpu::TextureDescriptor {
            label,
            size,
            mip_level_count,
            sample_count,
            dimension,
            format,
            usage,
            view_formats,
        };
        gpu.device.create_texture_from_hal::<Vulkan>(texture, &descriptor, state)
    }
}

/// An encoder with a transition of its own: wgpu does not know other owners of an image, and an encoder has either its
/// commands or those of others.
fn transition(gpu: &Gpu, texture: &wgpu::Texture, layout: vk::ImageLayout, families: [u32; 2]) -> wgpu::CommandBuffer {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    // SAFETY: the encoder has this barrier and no command of wgpu.
    unsafe {
        let image = texture.as_hal::<Vulkan>().expect("Vulkan").raw_handle();
        let raw = gpu.device.as_hal::<Vulkan>().expect("Vulkan").raw_device().clone();
        encoder.as_hal_mut::<Vulkan, _, _>(|encoder| {
            let commands = encoder.expect("Vulkan").raw_handle();
            hand_over(&raw, commands, image, [layout; 2], families);
        });
    }
    encoder.finish()
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn images_of_another_vulkan_device_come_in_and_go_out_without_a_copy() {
    let wanted = {
        let gpu = gpu();
        let mut post = Post::new(&gpu, changed("caracal.ron", None, &[]));
        let scene = upload(&gpu.device, &gpu.queue, &scene_texels(SIZE)).expect("a scene");
        let view = scene.create_view(&Default::default());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        post.encode(&mut encoder, &Frame { inputs: &[("scene", &view)], ..Frame::default() }).expect("a frame");
        gpu.queue.submit([encoder.finish()]);
        download(&gpu.device, &gpu.queue, post.output("display").unwrap()).expect("a picture").bytes
    };

    let gpu = gpu();
    let features = wanted_features(&gpu.adapter) | wgpu::Features::VULKAN_EXTERNAL_MEMORY_FD;
    let gpu = Shared::of(another_device(&gpu, features, gpu.adapter.limits()));
    // SAFETY: the physical device is of this instance.
    let uuid = unsafe {
        let hal = gpu.adapter.as_hal::<Vulkan>().expect("Vulkan");
        uuid_of(hal.shared_instance().raw_instance(), hal.raw_physical_device())
    };
    let renderer = Renderer::new(uuid);
    let (device, ours) = (&renderer.device, 0);
    let others = vk::QUEUE_FAMILY_EXTERNAL;

    let (light, light_fd, light_bytes, light_type) = renderer.shared_image(LIGHT);
    let (codes, codes_fd, codes_bytes, codes_type) = renderer.shared_image(CODES);
    let read = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

    // The renderer draws.
    let (buffer, mapped, length) = renderer.texels(LIGHT);
    let texels = scene_texels(SIZE);
    assert_eq!(texels.bytes.len(), length);
    // SAFETY: the memory is mapped and has as many bytes.
    unsafe { std::ptr::copy_nonoverlapping(texels.bytes.as_ptr(), mapped, length) };
    let draw = |commands| {
        let (none, to) = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::TRANSFER_DST_OPTIMAL);
        hand_over(device, commands, light, [none, to], [vk::QUEUE_FAMILY_IGNORED; 2]);
        // SAFETY: the commands are being recorded.
        unsafe { device.cmd_copy_buffer_to_image(commands, buffer, light, to, &[renderer.copy()]) };
        hand_over(device, commands, light, [to, read], [ours, others]);
    };
    renderer.run(draw);

    // A frame.
    let scene = import(&gpu, LIGHT, light_fd, light_bytes, light_type, wgpu::TextureUses::RESOURCE);
    let screen = import(&gpu, CODES, codes_fd, codes_bytes, codes_type, wgpu::TextureUses::UNINITIALIZED);
    let mut post = Post::new(&gpu, changed("caracal.ron", None, &[]));
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let views = [&scene, &screen].map(|texture| texture.create_view(&Default::default()));
    let (inputs, outputs) = (&[("scene", &views[0])], &[("display", &views[1])]);
    post.encode(&mut encoder, &Frame { inputs, outputs, ..Frame::default() }).expect("a frame");
    let given = wgpu::TextureTransition { texture: &screen, selector: None, state: wgpu::TextureUses::COPY_SRC };
    encoder.transition_resources(std::iter::empty(), std::iter::once(given));
    let from = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
    let taken = transition(&gpu, &scene, read, [others, ours]);
    let given = transition(&gpu, &screen, from, [ours, others]);
    gpu.queue.submit([taken, encoder.finish(), given]);
    gpu.wait().expect("it is done");

    // The renderer shows it.
    let (buffer, mapped, length) = renderer.texels(CODES);
    let show = |commands| {
        hand_over(device, commands, codes, [from; 2], [others, ours]);
        // SAFETY: the commands are being recorded.
        unsafe { device.cmd_copy_image_to_buffer(commands, codes, from, buffer, &[renderer.copy()]) };
    };
    renderer.run(show);
    // SAFETY: the memory is mapped and has as many bytes, and the device is done with it.
    let shown = unsafe { std::slice::from_raw_parts(mapped, length) };
    assert_same(shown, &wanted);
}

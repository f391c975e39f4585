//! The adapter, the device and their capabilities.

use std::sync::{Arc, Mutex};

use afterimage_graph::image::{Format, ImageDesc};
use afterimage_plan::{BandLimits, Caps, HostLimits, Options};
use wgpu::{Features, TextureFormatFeatureFlags, TextureFormatFeatures, TextureUsages};

use crate::error::GpuError;
use crate::pipelines::Pipelines;
#[cfg(not(target_family = "wasm"))]
use crate::platform;
use crate::platform::{caught, local_memory, used_memory, watched};
use crate::texture_format::texture_format;

/// A device: that of a host, or one that Afterimage opens, for programs without a renderer. Clones are handles to the
/// same device.
#[derive(Clone)]
pub struct Gpu {
    /// The adapter.
    pub adapter: wgpu::Adapter,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The capabilities that plans may use.
    pub caps: Caps,
    /// The compiled pipelines of all [executors](Self::executor).
    pub(crate) pipelines: Arc<Pipelines>,
}

/// Options for opening a device.
#[derive(Clone, Debug, Default)]
pub struct Opening {
    /// Part of the adapter's name, and `#2` after it for the second adapter with that part; `None` for the adapter with
    /// the highest performance.
    pub adapter: Option<String>,
    /// True if the Khronos validation layer is enabled.
    pub validation: bool,
    /// Bytes that the images of a frame may take, and all else that is on the device for them; by default three
    /// quarters of a card's memory, or half of the system's.
    pub max_memory: Option<u64>,
}

/// The hint for a machine without an adapter.
const ADVICE: &str = "no Vulkan, Metal or Direct3D 12 driver was found; on Debian or Ubuntu `apt-get install \
                      mesa-vulkan-drivers` installs one that runs on the processor";

/// Bytes of the blocks that wgpu shares between images and buffers that are smaller: the fewest that it can have.
pub(crate) const BLOCK: u64 = 4 << 20;

/// Bytes that a driver may take of a card when pipelines are compiled and commands recorded. That of NVIDIA took 10 to
/// 29 MiB.
const FOR_DRIVER: u64 = 32 << 20;

/// Optional features that make plans faster; each is requested where the adapter has it.
const WELCOME: Features = Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES
    .union(Features::FLOAT32_FILTERABLE)
    .union(Features::FLOAT32_BLENDABLE)
    .union(Features::RG11B10UFLOAT_RENDERABLE)
    .union(Features::INDIRECT_FIRST_INSTANCE)
    .union(Features::TIMESTAMP_QUERY)
    .union(Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)
    .union(Features::TIMESTAMP_QUERY_INSIDE_PASSES)
    .union(Features::PIPELINE_CACHE)
    .union(Features::IMMEDIATES)
    .union(Features::CLEAR_TEXTURE);

impl Gpu {
    /// The device of a host. The capabilities are those that it was opened with.
    pub fn new(adapter: &wgpu::Adapter, device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self::with_caps(adapter, device, queue, caps(adapter, device))
    }

    /// The same with capabilities that the host states.
    pub fn with_caps(adapter: &wgpu::Adapter, device: &wgpu::Device, queue: &wgpu::Queue, caps: Caps) -> Self {
        let (adapter, device, queue) = (adapter.clone(), device.clone(), queue.clone());
        Self { adapter, device, queue, caps, pipelines: Arc::default() }
    }

    /// Opens a device without a window.
    #[cfg(not(target_family = "wasm"))]
    pub fn open(opening: &Opening) -> Result<Self, GpuError> {
        pollster::block_on(Self::open_async(opening))
    }

    /// Opens a device without a window. Without `adapter`, this works on the web, too.
    pub async fn open_async(opening: &Opening) -> Result<Self, GpuError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        // Without DEBUG, wgpu does not receive the layer's messages. With it, a layer that is older than the driver
        // reports every shader's source language.
        let validated = wgpu::InstanceFlags::VALIDATION | wgpu::InstanceFlags::DEBUG;
        let flags = if opening.validation { validated } else { wgpu::InstanceFlags::empty() };
        // Ranges of draws that kernels write are not trusted: those beyond the buffers draw nothing.
        descriptor.flags = flags | wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL;
        let hints = match opening.max_memory {
            Some(_) => wgpu::MemoryHints::Manual { suballocated_device_memory_block_size: BLOCK..BLOCK },
            None => wgpu::MemoryHints::Performance,
        };
        let mut gpu = Self::open_with(&wgpu::Instance::new(descriptor), opening.adapter.as_deref(), hints).await?;
        gpu.caps.max_memory = opening.max_memory.unwrap_or(gpu.caps.max_memory);
        Ok(gpu)
    }

    /// Opens a device of an instance that the program has made, on the adapter that `wanted` names as
    /// [`Opening::adapter`] does; without it, on the one with the highest performance.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] and [`GpuError::NoDevice`].
    pub async fn open_on(instance: &wgpu::Instance, wanted: Option<&str>) -> Result<Self, GpuError> {
        Self::open_with(instance, wanted, wgpu::MemoryHints::Performance).await
    }

    async fn open_with(
        instance: &wgpu::Instance,
        wanted: Option<&str>,
        memory_hints: wgpu::MemoryHints,
    ) -> Result<Self, GpuError> {
        let adapter = adapter(instance, wanted).await?;
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("afterimage"),
            required_features: wanted_features(&adapter),
            required_limits: adapter.limits(),
            memory_hints,
            ..Default::default()
        };
        let opened = caught("the device", || adapter.request_device(&descriptor))?.await;
        let (device, queue) =
            opened.map_err(|error| GpuError::NoDevice { adapter: info.name, why: error.to_string() })?;
        Ok(Self::new(&adapter, &device, &queue))
    }

    /// The adapter's name.
    pub fn name(&self) -> String {
        self.adapter.get_info().name
    }

    /// The limits of pictures in bands: all that is on the device may take [`max_memory`](Caps::max_memory).
    pub fn band_limits(&self) -> BandLimits {
        let report = self.device.generate_allocator_report();
        BandLimits {
            bytes: self.caps.max_memory,
            taken: report.map_or(0, |report| report.total_allocated_bytes) + self.memory_used_by_others(),
            block: BLOCK,
            side: self.caps.max_side,
            filters: self.is_processor(),
            least: 1,
            parts: None,
            rows: None,
            host: HostLimits::NONE,
        }
    }

    /// Bytes of a card that its driver has for this program besides images and buffers, and may take later; 0 if it
    /// does not state them.
    #[doc(hidden)] // For the crate `afterimage`.
    pub fn memory_used_by_others(&self) -> u64 {
        let is_card = self.adapter.get_info().device_type == wgpu::DeviceType::DiscreteGpu;
        let used = used_memory(&self.device).filter(|_| is_card);
        let report = self.device.generate_allocator_report();
        used.zip(report).map_or(0, |(used, report)| used.saturating_sub(report.total_reserved_bytes) + FOR_DRIVER)
    }

    /// True if the adapter is the processor itself.
    pub fn is_processor(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Options with which a host may repeat frames in part: a processor renders for so long that this is worth the
    /// memory of images of their own, a card does not.
    pub fn options_to_repeat(&self, options: Options) -> Options {
        Options { repeatable: options.repeatable || self.is_processor(), ..options }
    }

    /// Checks that the device can hold an image.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn check_fits(&self, desc: ImageDesc) -> Result<(), GpuError> {
        let (width, height) = (desc.size.width, desc.size.height);
        let limit = if desc.volume { self.caps.max_volume_side } else { self.caps.max_side };
        match width.max(height).max(desc.size.depth) <= limit {
            true => Ok(()),
            false => Err(GpuError::TooLarge { width, height, adapter: self.name(), limit }),
        }
    }

    /// Looks whether the device is still there.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`].
    pub fn check_device(&self) -> Result<(), GpuError> {
        watched(&self.device, "a check of the device", || Ok(()))
    }

    /// A new command encoder. Errors of its commands go to the device's error handler.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&Default::default())
    }

    /// Submits what `record` records.
    ///
    /// # Errors
    /// Those of `record`; the device has no memory for the commands, or refuses them.
    #[cfg(not(target_family = "wasm"))]
    pub fn submit<E: From<GpuError>>(
        &self,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<(), E>,
    ) -> Result<(), E> {
        platform::submit(&self.device, &self.queue, "the commands", record)
    }

    /// Waits until all submitted work is done.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`], [`GpuError::TimedOut`].
    #[cfg(not(target_family = "wasm"))]
    pub fn wait(&self) -> Result<(), GpuError> {
        self.wait_for(None)
    }

    /// Waits for the end of a submission; of the last one if `submission_index` is `None`.
    ///
    /// # Errors
    /// [`GpuError::DeviceLost`], [`GpuError::TimedOut`].
    #[cfg(not(target_family = "wasm"))]
    pub fn wait_for(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), GpuError> {
        platform::wait(&self.device, submission_index)
    }

    /// Collects the errors of the device from now on, which would stop the program otherwise.
    pub fn log_errors(&self) -> ErrorLog {
        let log = ErrorLog::default();
        let errors = log.0.clone();
        self.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            errors.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(error.to_string());
        }));
        log
    }
}

/// Errors that a device has reported.
#[derive(Clone, Debug, Default)]
pub struct ErrorLog(Arc<Mutex<Vec<String>>>);

impl ErrorLog {
    /// The first error since the last call, if there is one.
    pub fn take_first(&self) -> Option<String> {
        let mut errors = self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        std::mem::take(&mut *errors).into_iter().next()
    }
}

async fn adapter(instance: &wgpu::Instance, wanted: Option<&str>) -> Result<wgpu::Adapter, GpuError> {
    let Some(wanted) = wanted else {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = caught("the list of adapters", || instance.request_adapter(&options))?.await;
        return adapter.map_err(|_| GpuError::NoAdapter { wanted: None, advice: ADVICE.into() });
    };
    let adapters = caught("the list of adapters", || instance.enumerate_adapters(wgpu::Backends::all()))?.await;
    let known: Vec<(String, wgpu::Backend)> =
        adapters.iter().map(|adapter| adapter.get_info()).map(|info| (info.name, info.backend)).collect();
    let names: Vec<String> = known.iter().map(|(name, _)| format!("`{name}`")).collect();
    let found = named(&known, wanted).and_then(|index| adapters.into_iter().nth(index));
    found.ok_or_else(|| GpuError::NoAdapter {
        wanted: Some(wanted.to_owned()),
        advice: if names.is_empty() { ADVICE.into() } else { format!("there are {}", names.join(", ")) },
    })
}

/// The index of the adapter that is named by a part of its name, and by `#2` after it if it is the second one. The same
/// card is listed once for each backend, so all are those of the first one's.
fn named(known: &[(String, wgpu::Backend)], wanted: &str) -> Option<usize> {
    let numbered = wanted.rsplit_once('#').and_then(|(part, number)| Some((part, number.parse::<usize>().ok()?)));
    let (part, number) = numbered.unwrap_or((wanted, 1));
    let has_name = |(name, _): &(String, wgpu::Backend)| name.to_lowercase().contains(&part.to_lowercase());
    let (_, backend) = known.iter().find(|adapter| has_name(adapter))?;
    let same = known.iter().enumerate().filter(|(_, adapter)| has_name(adapter) && adapter.1 == *backend);
    same.map(|(index, _)| index).nth(number.checked_sub(1)?)
}

/// The features of an adapter that make plans faster. A host that opens the device itself adds them to its own.
pub fn wanted_features(adapter: &wgpu::Adapter) -> Features {
    adapter.features() & WELCOME
}

/// The capabilities of a device of this adapter.
pub fn caps(adapter: &wgpu::Adapter, device: &wgpu::Device) -> Caps {
    let features = device.features();
    let limits = device.limits();
    let specific = features.contains(Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
    let offered = |format: Format| {
        let format = texture_format(format);
        if specific { adapter.get_texture_format_features(format) } else { format.guaranteed_format_features(features) }
    };
    let formats = |usage: TextureUsages, flags: TextureFormatFeatureFlags| {
        let usage = usage | TextureUsages::TEXTURE_BINDING;
        let allows =
            |offered: TextureFormatFeatures| offered.allowed_usages.contains(usage) && offered.flags.contains(flags);
        Format::ALL.into_iter().filter(|format| allows(offered(*format))).collect()
    };
    let any = TextureFormatFeatureFlags::empty();
    Caps {
        storage: formats(TextureUsages::STORAGE_BINDING, any),
        renderable: formats(TextureUsages::RENDER_ATTACHMENT, any),
        blendable: formats(TextureUsages::RENDER_ATTACHMENT, TextureFormatFeatureFlags::BLENDABLE),
        filter_32_bit: features.contains(Features::FLOAT32_FILTERABLE),
        max_side: limits.max_texture_dimension_2d,
        max_volume_side: limits.max_texture_dimension_3d,
        workgroup_invocations: limits.max_compute_invocations_per_workgroup,
        max_buffer: limits.max_storage_buffer_binding_size,
        max_memory: max_memory(adapter, device),
        max_storage_images: limits.max_storage_textures_per_shader_stage,
        max_uniform_buffers: limits.max_uniform_buffers_per_shader_stage.saturating_sub(1),
        max_fused_uniform_buffers: max_fused_uniform_buffers(&adapter.get_info(), &limits),
        indirect_first_instance: features.contains(Features::INDIRECT_FIRST_INSTANCE),
        fast_workgroup_memory: adapter.get_info().device_type != wgpu::DeviceType::Cpu,
        prefer_fragment: false,
    }
}

/// Three quarters of the memory of a card, half of memory that is also the system's; the rest is for other programs.
fn max_memory(adapter: &wgpu::Adapter, device: &wgpu::Device) -> u64 {
    let is_card = adapter.get_info().device_type == wgpu::DeviceType::DiscreteGpu;
    match local_memory(device) {
        Some(bytes) if is_card => bytes / 4 * 3,
        Some(bytes) => bytes / 2,
        None => u64::MAX,
    }
}

/// Uniform buffers of a fused pass. Mesa 22's llvmpipe ends the process in some shaders that branch by the fourth one.
fn max_fused_uniform_buffers(adapter: &wgpu::AdapterInfo, limits: &wgpu::Limits) -> u32 {
    let most = limits.max_uniform_buffers_per_shader_stage.saturating_sub(1);
    let crashes = adapter.driver == "llvmpipe" && adapter.driver_info.starts_with("Mesa 22.");
    if crashes { most.min(3) } else { most }
}

#[cfg(test)]
mod tests {
    use wgpu::Backend;

    use super::named;

    #[test]
    fn the_second_of_equal_cards_is_chosen_by_its_number() {
        let known = [
            ("H200", Backend::Vulkan),
            ("H200", Backend::Vulkan),
            ("llvmpipe", Backend::Vulkan),
            ("H200", Backend::Gl),
        ];
        let known = known.map(|(name, backend)| (name.to_owned(), backend));
        let index = |wanted| named(&known, wanted);
        assert_eq!(
            [index("h200"), index("h200#1"), index("h200#2"), index("h200#3")],
            [Some(0), Some(0), Some(1), None]
        );
        assert_eq!([index("pipe"), index("pipe#2"), index("#3"), index("h200#0")], [Some(2), None, Some(2), None]);
        assert_eq!([index("voodoo"), index("h#200")], [None, None]);
    }
}

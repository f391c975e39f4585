//! The memory of a device, which wgpu does not report.
#![allow(unsafe_code, reason = "only Vulkan below wgpu knows it; the block has its proof beside it")]

/// Bytes of the device's largest memory of its own; `None` where the backend is not Vulkan.
#[cfg(not(any(target_vendor = "apple", target_family = "wasm")))]
pub(crate) fn local_memory(device: &wgpu::Device) -> Option<u64> {
    use ash::vk::MemoryHeapFlags;

    // SAFETY: the guard is dropped before this function returns, and the device is not destroyed through it.
    let hal = unsafe { device.as_hal::<wgpu::hal::api::Vulkan>() }?;
    let instance = hal.shared_instance().raw_instance();
    // SAFETY: the physical device belongs to this instance.
    let properties = unsafe { instance.get_physical_device_memory_properties(hal.raw_physical_device()) };
    let heaps = properties.memory_heaps_as_slice().iter();
    heaps.filter(|heap| heap.flags.contains(MemoryHeapFlags::DEVICE_LOCAL)).map(|heap| heap.size).max()
}

/// Targets without Vulkan.
#[cfg(any(target_vendor = "apple", target_family = "wasm"))]
pub(crate) fn local_memory(_device: &wgpu::Device) -> Option<u64> {
    None
}

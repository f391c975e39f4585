//! The memory of a device, which wgpu does not report.
#![allow(unsafe_code, reason = "only Vulkan below wgpu knows it; each block has its proof beside it")]

#[cfg(not(any(target_vendor = "apple", target_family = "wasm")))]
use ash::vk;

/// Bytes of the device's largest memory of its own; `None` where the backend is not Vulkan.
#[cfg(not(any(target_vendor = "apple", target_family = "wasm")))]
pub(crate) fn local_memory(device: &wgpu::Device) -> Option<u64> {
    // SAFETY: the guard is dropped before this function returns, and the device is not destroyed through it.
    let hal = unsafe { device.as_hal::<wgpu::hal::api::Vulkan>() }?;
    let instance = hal.shared_instance().raw_instance();
    // SAFETY: the physical device belongs to this instance.
    let properties = unsafe { instance.get_physical_device_memory_properties(hal.raw_physical_device()) };
    largest(&properties).map(|(_, bytes)| bytes)
}

/// Bytes of that memory which this program has, what the driver keeps for it included; `None` where it does not say.
#[cfg(not(any(target_vendor = "apple", target_family = "wasm")))]
pub(crate) fn used_memory(device: &wgpu::Device) -> Option<u64> {
    // SAFETY: as in `local_memory`.
    let hal = unsafe { device.as_hal::<wgpu::hal::api::Vulkan>() }?;
    let is_known = hal.enabled_device_extensions().contains(&ash::ext::memory_budget::NAME);
    if !is_known || hal.shared_instance().instance_api_version() < vk::API_VERSION_1_1 {
        return None;
    }
    let mut budget = vk::PhysicalDeviceMemoryBudgetPropertiesEXT::default();
    let mut properties = vk::PhysicalDeviceMemoryProperties2::default().push_next(&mut budget);
    let instance = hal.shared_instance().raw_instance();
    // SAFETY: the physical device belongs to this instance, which has the function, and has the extension that fills
    // `budget`.
    unsafe { instance.get_physical_device_memory_properties2(hal.raw_physical_device(), &mut properties) };
    let properties = properties.memory_properties;
    largest(&properties).map(|(heap, _)| budget.heap_usage[heap])
}

/// The place of the largest memory of the device itself, and its bytes.
#[cfg(not(any(target_vendor = "apple", target_family = "wasm")))]
fn largest(properties: &vk::PhysicalDeviceMemoryProperties) -> Option<(usize, u64)> {
    let heaps = properties.memory_heaps_as_slice().iter().enumerate();
    let local = heaps.filter(|(_, heap)| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
    local.map(|(index, heap)| (index, heap.size)).max_by_key(|(_, bytes)| *bytes)
}

/// Targets without Vulkan.
#[cfg(any(target_vendor = "apple", target_family = "wasm"))]
pub(crate) fn local_memory(_device: &wgpu::Device) -> Option<u64> {
    None
}

/// Targets without Vulkan.
#[cfg(any(target_vendor = "apple", target_family = "wasm"))]
pub(crate) fn used_memory(_device: &wgpu::Device) -> Option<u64> {
    None
}

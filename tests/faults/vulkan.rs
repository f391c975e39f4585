//! The machine's Vulkan driver, with calls that fail on request.
//!
//! Every function that wgpu and the framework look up goes through [`hooked`]. A hook returns the error in place of the
//! call, as a driver does, or calls the driver. So wgpu and the framework run as they are, with their own code for
//! errors.
#![allow(unsafe_code, reason = "the functions of Vulkan are called and replaced by their addresses")]

use std::ffi::{CStr, c_char, c_void};
use std::mem::transmute;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicPtr, AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};

use ash::vk;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The device has no memory for this call.
    DeviceMemory,
    /// The driver has no memory on the host for this call.
    HostMemory,
    /// The device is lost from this call on.
    Lost,
    /// The device does not finish during this call.
    TimeOut,
    /// An error that is none of the others.
    Unknown,
}

impl Kind {
    pub const ALL: [Self; 5] = [Self::DeviceMemory, Self::HostMemory, Self::Lost, Self::TimeOut, Self::Unknown];

    fn result(self) -> vk::Result {
        match self {
            Self::DeviceMemory => vk::Result::ERROR_OUT_OF_DEVICE_MEMORY,
            Self::HostMemory => vk::Result::ERROR_OUT_OF_HOST_MEMORY,
            Self::Lost => vk::Result::ERROR_DEVICE_LOST,
            Self::TimeOut => vk::Result::TIMEOUT,
            Self::Unknown => vk::Result::ERROR_UNKNOWN,
        }
    }

    /// True if the specification lets a call of this group return it.
    fn is_possible(self, group: Group) -> bool {
        match self {
            Self::DeviceMemory | Self::HostMemory | Self::Unknown => true,
            Self::Lost => group != Group::Memory,
            Self::TimeOut => group == Group::Wait,
        }
    }
}

/// The errors that a call can return.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Group {
    Memory,
    Queue,
    Wait,
}

/// Calls so far that can return the error, the number of the call that returns it, and the error.
static CALLS: AtomicU64 = AtomicU64::new(0);
static FAILING: AtomicU64 = AtomicU64::new(0);
static KIND: AtomicU64 = AtomicU64::new(0);
static IS_LOST: AtomicBool = AtomicBool::new(false);
/// True if the device has just not finished: the counter of its work then reads as it did before.
static IS_BEHIND: AtomicBool = AtomicBool::new(false);
static COUNTER: AtomicU64 = AtomicU64::new(0);
static FAILED: Mutex<Option<&'static str>> = Mutex::new(None);
/// The device that was opened last, and how to wait for it.
static DEVICE: AtomicU64 = AtomicU64::new(0);
static IDLE: AtomicPtr<c_void> = AtomicPtr::new(std::ptr::null_mut());

/// From now on the call of this number that can return the error does so, counted from 1; none for 0.
pub fn arm(kind: Kind, failing: u64) {
    KIND.store(Kind::ALL.iter().position(|known| *known == kind).expect("it is one of all") as u64, Ordering::SeqCst);
    CALLS.store(0, Ordering::SeqCst);
    IS_LOST.store(false, Ordering::SeqCst);
    IS_BEHIND.store(false, Ordering::SeqCst);
    *FAILED.lock().expect("no thread panics with it") = None;
    FAILING.store(failing, Ordering::SeqCst);
}

/// From now on all calls succeed. The number of calls until now that could return the error.
pub fn disarm() -> u64 {
    FAILING.store(0, Ordering::SeqCst);
    IS_LOST.store(false, Ordering::SeqCst);
    CALLS.load(Ordering::SeqCst)
}

/// The name of the call that failed.
pub fn failed() -> Option<&'static str> {
    *FAILED.lock().expect("no thread panics with it")
}

/// The error that this call returns in place of doing anything.
fn fault(name: &'static str, group: Group) -> Option<vk::Result> {
    let kind = Kind::ALL[KIND.load(Ordering::SeqCst) as usize];
    if !kind.is_possible(group) {
        return None;
    }
    let call = CALLS.fetch_add(1, Ordering::SeqCst) + 1;
    let fails = call == FAILING.load(Ordering::SeqCst);
    if fails {
        *FAILED.lock().expect("no thread panics with it") = Some(name);
        // What runs now may use what the program frees after the error, and only a simulated device goes on running.
        finish_all();
        IS_BEHIND.store(kind == Kind::TimeOut, Ordering::SeqCst);
        IS_LOST.store(kind == Kind::Lost, Ordering::SeqCst);
    }
    (fails || IS_LOST.load(Ordering::SeqCst)).then(|| kind.result())
}

fn finish_all() {
    let device = <vk::Device as vk::Handle>::from_raw(DEVICE.load(Ordering::SeqCst));
    let wait = IDLE.load(Ordering::SeqCst);
    if !wait.is_null() && device != vk::Device::null() {
        // SAFETY: the address is that of this function, and the device is not destroyed while calls for it arrive.
        unsafe { transmute::<*mut c_void, vk::PFN_vkDeviceWaitIdle>(wait)(device) }.result().expect("it can wait");
    }
}

macro_rules! hooks {
    ($($name:ident $group:ident ($($argument:ident: $type:ty),*);)*) => {
        #[allow(non_upper_case_globals, reason = "a static for each function")]
        mod driver {
            $(pub(super) static $name: super::AtomicPtr<super::c_void> =
                super::AtomicPtr::new(std::ptr::null_mut());)*
        }

        #[allow(non_snake_case, reason = "the names of Vulkan")]
        mod hook {
            use super::*;

            $(pub(super) unsafe extern "system" fn $name($($argument: $type),*) -> vk::Result {
                if let Some(error) = fault(stringify!($name), Group::$group) {
                    return error;
                }
                type Function = unsafe extern "system" fn($($type),*) -> vk::Result;
                let address = driver::$name.load(Ordering::SeqCst);
                // SAFETY: it is the driver's address of this function, which was stored when the hook was given out.
                let result = unsafe { transmute::<*mut c_void, Function>(address)($($argument),*) };
                if result == vk::Result::SUCCESS {
                    count(stringify!($name), 1);
                }
                result
            })*
        }

        /// The address of the hook of a function, which calls the one at `address`; without one, `address` itself.
        fn hooked(name: &CStr, address: *mut c_void) -> *mut c_void {
            match name.to_str().unwrap_or_default() {
                $(stringify!($name) if !address.is_null() => {
                    driver::$name.store(address, Ordering::SeqCst);
                    hook::$name as *mut c_void
                })*
                _ => ending(name, address),
            }
        }
    };
}

hooks! {
    vkEnumeratePhysicalDevices Memory (i: vk::Instance, n: *mut u32, out: *mut vk::PhysicalDevice);
    vkEnumerateDeviceExtensionProperties Memory (d: vk::PhysicalDevice, l: *const c_char, n: *mut u32, out: *mut c_void);
    vkAllocateMemory Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::DeviceMemory);
    vkMapMemory Memory (d: vk::Device, m: vk::DeviceMemory, o: u64, s: u64, f: u32, out: *mut *mut c_void);
    vkFlushMappedMemoryRanges Memory (d: vk::Device, n: u32, r: *const c_void);
    vkInvalidateMappedMemoryRanges Memory (d: vk::Device, n: u32, r: *const c_void);
    vkBindBufferMemory Memory (d: vk::Device, b: vk::Buffer, m: vk::DeviceMemory, o: u64);
    vkBindImageMemory Memory (d: vk::Device, i: vk::Image, m: vk::DeviceMemory, o: u64);
    vkCreateBuffer Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::Buffer);
    vkCreateImage Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::Image);
    vkCreateImageView Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::ImageView);
    vkCreateSampler Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::Sampler);
    vkCreateShaderModule Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::ShaderModule);
    vkCreatePipelineLayout Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::PipelineLayout);
    vkCreatePipelineCache Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::PipelineCache);
    vkGetPipelineCacheData Memory (d: vk::Device, c: vk::PipelineCache, n: *mut usize, out: *mut c_void);
    vkCreateComputePipelines Memory
        (d: vk::Device, c: vk::PipelineCache, n: u32, i: *const c_void, a: *const c_void, out: *mut vk::Pipeline);
    vkCreateGraphicsPipelines Memory
        (d: vk::Device, c: vk::PipelineCache, n: u32, i: *const c_void, a: *const c_void, out: *mut vk::Pipeline);
    vkCreateDescriptorSetLayout Memory
        (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::DescriptorSetLayout);
    vkCreateDescriptorPool Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::DescriptorPool);
    vkAllocateDescriptorSets Memory (d: vk::Device, i: *const c_void, out: *mut vk::DescriptorSet);
    vkCreateRenderPass Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::RenderPass);
    vkCreateFramebuffer Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::Framebuffer);
    vkCreateCommandPool Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::CommandPool);
    vkAllocateCommandBuffers Memory (d: vk::Device, i: *const c_void, out: *mut vk::CommandBuffer);
    vkBeginCommandBuffer Memory (c: vk::CommandBuffer, i: *const c_void);
    vkEndCommandBuffer Memory (c: vk::CommandBuffer);
    vkResetCommandPool Memory (d: vk::Device, p: vk::CommandPool, f: u32);
    vkCreateFence Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::Fence);
    vkResetFences Memory (d: vk::Device, n: u32, f: *const vk::Fence);
    vkCreateSemaphore Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::Semaphore);
    vkCreateQueryPool Memory (d: vk::Device, i: *const c_void, a: *const c_void, out: *mut vk::QueryPool);
    vkQueueSubmit Queue (q: vk::Queue, n: u32, i: *const c_void, f: vk::Fence);
    vkQueueWaitIdle Queue (q: vk::Queue);
    vkGetFenceStatus Queue (d: vk::Device, f: vk::Fence);
    vkWaitForFences Wait (d: vk::Device, n: u32, f: *const vk::Fence, all: u32, t: u64);
    vkWaitSemaphores Wait (d: vk::Device, i: *const c_void, t: u64);
    vkWaitSemaphoresKHR Wait (d: vk::Device, i: *const c_void, t: u64);
}

macro_rules! ends {
    ($($name:ident $made:ident;)*) => {
        /// The numbers of objects that were made and not yet destroyed, by the function that makes them.
        static ALIVE: [(&str, AtomicI64); [$(stringify!($made)),*].len()] =
            [$((stringify!($made), AtomicI64::new(0))),*];

        #[allow(non_upper_case_globals, reason = "a static for each function")]
        mod driver_of_ends {
            $(pub(super) static $name: super::AtomicPtr<super::c_void> =
                super::AtomicPtr::new(std::ptr::null_mut());)*
        }

        #[allow(non_snake_case, reason = "the names of Vulkan")]
        mod end {
            use super::*;

            $(pub(super) unsafe extern "system" fn $name(device: vk::Device, object: u64, allocator: *const c_void) {
                if object != 0 {
                    count(stringify!($made), -1);
                }
                type Function = unsafe extern "system" fn(vk::Device, u64, *const c_void);
                let address = driver_of_ends::$name.load(Ordering::SeqCst);
                // SAFETY: it is the driver's address of this function; objects that are no handles of it are 64 bits.
                unsafe { transmute::<*mut c_void, Function>(address)(device, object, allocator) }
            })*
        }

        /// The address of the hook of a function that destroys objects, or `address` itself.
        fn ending(name: &CStr, address: *mut c_void) -> *mut c_void {
            match name.to_str().unwrap_or_default() {
                $(stringify!($name) if !address.is_null() => {
                    driver_of_ends::$name.store(address, Ordering::SeqCst);
                    end::$name as *mut c_void
                })*
                _ => address,
            }
        }
    };
}

ends! {
    vkFreeMemory vkAllocateMemory;
    vkDestroyBuffer vkCreateBuffer;
    vkDestroyImage vkCreateImage;
    vkDestroyImageView vkCreateImageView;
    vkDestroySampler vkCreateSampler;
    vkDestroyShaderModule vkCreateShaderModule;
    vkDestroyPipelineLayout vkCreatePipelineLayout;
    vkDestroyPipelineCache vkCreatePipelineCache;
    vkDestroyDescriptorSetLayout vkCreateDescriptorSetLayout;
    vkDestroyDescriptorPool vkCreateDescriptorPool;
    vkDestroyRenderPass vkCreateRenderPass;
    vkDestroyFramebuffer vkCreateFramebuffer;
    vkDestroyCommandPool vkCreateCommandPool;
    vkDestroyFence vkCreateFence;
    vkDestroySemaphore vkCreateSemaphore;
    vkDestroyQueryPool vkCreateQueryPool;
}

fn count(made: &str, more: i64) {
    let alive = ALIVE.iter().find(|(name, _)| *name == made);
    alive.into_iter().for_each(|(_, alive)| _ = alive.fetch_add(more, Ordering::SeqCst));
}

/// The numbers of objects that were made and not yet destroyed, by the function that makes them.
pub fn alive() -> Vec<(&'static str, i64)> {
    ALIVE.iter().map(|(name, alive)| (*name, alive.load(Ordering::SeqCst))).collect()
}

static INSTANCE_LOOK_UP: OnceLock<vk::PFN_vkGetInstanceProcAddr> = OnceLock::new();
static DEVICE_LOOK_UP: AtomicPtr<c_void> = AtomicPtr::new(std::ptr::null_mut());
static READ_COUNTER: AtomicPtr<c_void> = AtomicPtr::new(std::ptr::null_mut());
static CREATE_DEVICE: AtomicPtr<c_void> = AtomicPtr::new(std::ptr::null_mut());

unsafe extern "system" fn look_up_in_instance(instance: vk::Instance, name: *const c_char) -> vk::PFN_vkVoidFunction {
    let look_up = INSTANCE_LOOK_UP.get().expect("it is stored before an instance is made");
    // SAFETY: the caller gives an instance and a name that ends with zero.
    let (name, address) = unsafe { (CStr::from_ptr(name), look_up(instance, name)) };
    let address = address.map_or(std::ptr::null_mut(), |address| address as *mut c_void);
    let own = match name.to_bytes() {
        b"vkGetDeviceProcAddr" => {
            DEVICE_LOOK_UP.store(address, Ordering::SeqCst);
            look_up_in_device as *mut c_void
        }
        b"vkCreateDevice" => {
            CREATE_DEVICE.store(address, Ordering::SeqCst);
            create_device as *mut c_void
        }
        _ => hooked(name, address),
    };
    // SAFETY: a null pointer is no function, and any other one is the address of one.
    unsafe { transmute::<*mut c_void, vk::PFN_vkVoidFunction>(own) }
}

unsafe extern "system" fn look_up_in_device(device: vk::Device, name: *const c_char) -> vk::PFN_vkVoidFunction {
    // SAFETY: the address is that of this function, and the caller gives a device and a name that ends with zero.
    unsafe {
        let look_up = transmute::<*mut c_void, vk::PFN_vkGetDeviceProcAddr>(DEVICE_LOOK_UP.load(Ordering::SeqCst));
        let address = look_up(device, name).map_or(std::ptr::null_mut(), |address| address as *mut c_void);
        let own = match CStr::from_ptr(name).to_bytes() {
            b"vkDeviceWaitIdle" => {
                IDLE.store(address, Ordering::SeqCst);
                address
            }
            b"vkGetSemaphoreCounterValue" | b"vkGetSemaphoreCounterValueKHR" if !address.is_null() => {
                READ_COUNTER.store(address, Ordering::SeqCst);
                counter_value as *mut c_void
            }
            _ => hooked(CStr::from_ptr(name), address),
        };
        transmute::<*mut c_void, vk::PFN_vkVoidFunction>(own)
    }
}

/// The counter of finished work, or its value before.
unsafe extern "system" fn counter_value(device: vk::Device, semaphore: vk::Semaphore, out: *mut u64) -> vk::Result {
    if let Some(error) = fault("vkGetSemaphoreCounterValue", Group::Queue) {
        return error;
    }
    // SAFETY: the address is that of this function, and the arguments are the caller's.
    unsafe {
        let read = transmute::<*mut c_void, vk::PFN_vkGetSemaphoreCounterValue>(READ_COUNTER.load(Ordering::SeqCst));
        let result = read(device, semaphore, out);
        if IS_BEHIND.swap(false, Ordering::SeqCst) {
            *out = COUNTER.load(Ordering::SeqCst);
        }
        COUNTER.store(*out, Ordering::SeqCst);
        result
    }
}

/// Remembers the device, so that a fault can wait for it.
unsafe extern "system" fn create_device(
    adapter: vk::PhysicalDevice,
    info: *const vk::DeviceCreateInfo<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    out: *mut vk::Device,
) -> vk::Result {
    DEVICE.store(0, Ordering::SeqCst);
    COUNTER.store(0, Ordering::SeqCst);
    if let Some(error) = fault("vkCreateDevice", Group::Queue) {
        return error;
    }
    // SAFETY: the address is that of this function, and the arguments are the caller's.
    unsafe {
        let create = transmute::<*mut c_void, vk::PFN_vkCreateDevice>(CREATE_DEVICE.load(Ordering::SeqCst));
        let result = create(adapter, info, allocator, out);
        if result == vk::Result::SUCCESS {
            DEVICE.store(vk::Handle::as_raw(*out), Ordering::SeqCst);
        }
        result
    }
}

/// An instance of wgpu whose calls go through the hooks.
pub fn instance() -> wgpu::Instance {
    type Hal = wgpu::hal::api::Vulkan;
    static LIBRARY: OnceLock<ash::Entry> = OnceLock::new();
    // SAFETY: the library is the machine's Vulkan loader, and it stays loaded.
    let library = LIBRARY.get_or_init(|| unsafe { ash::Entry::load() }.expect("the machine has Vulkan"));
    INSTANCE_LOOK_UP.get_or_init(|| library.static_fn().get_instance_proc_addr);
    let look_up = ash::StaticFn { get_instance_proc_addr: look_up_in_instance };
    let flags = wgpu::InstanceFlags::empty();
    let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
    // SAFETY: the look-up gives addresses of Vulkan's functions or of hooks with their signatures; the instance is
    // made with the extensions that wgpu asks for, and wgpu becomes its owner.
    unsafe {
        let entry = ash::Entry::from_static_fn(look_up);
        let extensions = wgpu::hal::vulkan::Instance::desired_extensions(&entry, vk::API_VERSION_1_3, flags);
        let extensions = extensions.expect("the extensions can be listed");
        let names: Vec<*const c_char> = extensions.iter().map(|name| name.as_ptr()).collect();
        let info = vk::InstanceCreateInfo::default().application_info(&application).enabled_extension_names(&names);
        let raw = entry.create_instance(&info, None).expect("the machine has a driver");
        let version = vk::API_VERSION_1_3;
        let thresholds = wgpu::MemoryBudgetThresholds::default();
        let hal = wgpu::hal::vulkan::Instance::from_raw(
            entry, raw, version, 0, None, extensions, flags, thresholds, false, None,
        );
        wgpu::Instance::from_hal::<Hal>(hal.expect("it is a valid instance"))
    }
}

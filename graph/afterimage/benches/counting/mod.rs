//! An allocator that tells the framework's allocations from those of wgpu.
//!
//! It reads the call stack of every allocation of its thread while it counts. The first function outwards from the
//! allocator that belongs to one of our crates or to a graphics crate is the origin of the allocation. So allocations
//! within calls to wgpu count as wgpu's, also where we have called it. A function of wgpu that the compiler has inlined
//! into one of ours counts as ours where there is no debug information, so our share is never too small. What libraries
//! allocate for us, as the standard library does, counts as ours.
#![allow(unsafe_code, reason = "an allocator is unsafe by nature; this one only counts and forwards")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::backtrace::Backtrace;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

/// To be the global allocator of a program.
pub(crate) struct Counting;

/// Bytes and calls by origin.
pub(crate) type MemoryRequirements = BTreeMap<&'static str, (usize, usize)>;

/// The crates of this framework.
pub(crate) const OURS: &str = "the framework";
/// wgpu and what is below it.
pub(crate) const THEIRS: &str = "wgpu";
/// All else.
pub(crate) const HOST: &str = "this program";

const GRAPHICS: [&str; 7] = ["wgpu", "wgpu_core", "wgpu_hal", "wgpu_types", "naga", "ash", "gpu_allocator"];

thread_local! {
    static COUNTS: Cell<bool> = const { Cell::new(false) };
    static ASKED: RefCell<MemoryRequirements> = const { RefCell::new(BTreeMap::new()) };
}

// SAFETY: every call is forwarded to the system's allocator; counting is off while it works, so it never calls itself.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size());
        // SAFETY: the caller keeps the contract of `GlobalAlloc`, which is also that of the system's allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above; the pointer came from the system's allocator.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

fn count(bytes: usize) {
    if !COUNTS.try_with(|counts| counts.replace(false)).unwrap_or(false) {
        return;
    }
    let who = asker(&Backtrace::force_capture().to_string());
    ASKED.with_borrow_mut(|asked| {
        let (all, calls) = asked.entry(who).or_default();
        *all += bytes;
        *calls += 1;
    });
    COUNTS.set(true);
}

/// The origin of an allocation with this call stack.
pub(crate) fn asker(stack: &str) -> &'static str {
    // `   7: <afterimage_gpu::store::Store as core::ops::Drop>::drop`
    let functions = stack.lines().filter_map(|line| line.split_once(": ")).map(|(_, function)| function);
    functions.filter_map(origin).next().unwrap_or(HOST)
}

fn origin(function: &str) -> Option<&'static str> {
    // `<f32 as afterimage_base::value::ParamType>::into_value`
    let mut crates = function.split([' ', '<', '&', '[', '(', ',']).filter_map(|path| Some(path.split_once("::")?.0));
    crates.find_map(|name| match name {
        _ if name == "afterimage" || name.starts_with("afterimage_") => Some(OURS),
        _ if GRAPHICS.contains(&name) => Some(THEIRS),
        _ => None,
    })
}

/// Bytes and calls by origin, while `work` runs the given number of times on this thread.
pub(crate) fn counted<E>(times: u32, mut work: impl FnMut() -> Result<(), E>) -> Result<MemoryRequirements, E> {
    for _ in 0..times {
        COUNTS.set(true);
        let done = work();
        COUNTS.set(false);
        done?;
    }
    Ok(ASKED.take())
}

//! Kinds from folders are freed with their last handle, so that a program may reload them for days.
//!
//! This is a binary of its own, because it counts the bytes of the whole process.
#![allow(missing_docs, reason = "a test binary has no outside")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicIsize, Ordering};

mod posterize;

use posterize::posterize;

/// Counts the bytes that the process holds: shaders are parsed on threads of their own.
struct Counting;

static LIVE: AtomicIsize = AtomicIsize::new(0);

fn count(bytes: isize) {
    LIVE.fetch_add(bytes, Ordering::Relaxed);
}

#[allow(unsafe_code, reason = "an allocator is unsafe by its trait; this one only counts")]
// SAFETY: all calls go to the allocator of the system with the same arguments.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller keeps the contract of `dealloc`, and the memory comes from the same allocator.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_thousand_reloads_hold_no_memory() {
    // The first loads fill what is made once per program.
    (0..3).for_each(|_| drop(posterize()));
    let before = LIVE.load(Ordering::Relaxed);
    (0..1000).for_each(|_| drop(posterize()));
    let held = LIVE.load(Ordering::Relaxed) - before;
    // The test's own thread is not the only one of the process.
    assert!(held.abs() < 1000, "{held} bytes are held after 1000 loads");
}

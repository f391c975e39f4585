//! Kinds from folders are freed with their last handle, so that a program may reload them for days.
//!
//! This is a binary of its own, because it counts the bytes of the whole process.
#![allow(missing_docs, reason = "a test binary has no outside")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicIsize, Ordering};

use afterimage_graph::node::{NodeKind, folder_kind};

const DECLARATION: &str = r#"Kind(
    name: "Posterize",
    doc: "Leaves only a few levels of each color.",
    inputs: { "source": Image(doc: "The picture.", accepts: [DisplayLinear]) },
    outputs: { "result": Image(doc: "The picture in levels.", state: Same("source")) },
    parameters: { "levels": Float(doc: "Levels.", default: 4.0, within: (2.0, 256.0), unit: "levels") },
)"#;

const SHADER: &str = "struct Posterize { levels: f32 }

fn posterize(source: vec4f, params: Posterize) -> vec4f {
    return vec4f(round(source.rgb * params.levels) / params.levels, source.a);
}
";

fn load() -> NodeKind {
    let kind = folder_kind(("posterize/node.ron", DECLARATION), ("posterize/posterize.wgsl", SHADER));
    kind.unwrap_or_else(|errors| panic!("{errors}"))
}

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
    (0..3).for_each(|_| drop(load()));
    let before = LIVE.load(Ordering::Relaxed);
    (0..1000).for_each(|_| drop(load()));
    let held = LIVE.load(Ordering::Relaxed) - before;
    // The test's own thread is not the only one of the process.
    assert!(held.abs() < 1000, "{held} bytes are held after 1000 loads");
}

//! Kinds from folders are freed with their last handle, so that a program may reload them for days.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use afterimage_graph::node::{NodeKind, Registry, folder_kind};

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

/// Counts the bytes that each thread holds.
struct Counting;

thread_local! {
    static LIVE: Cell<isize> = const { Cell::new(0) };
}

fn count(bytes: isize) {
    // A thread that ends frees memory after its counter.
    let _ = LIVE.try_with(|live| live.set(live.get() + bytes));
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
    let before = LIVE.get();
    (0..1000).for_each(|_| drop(load()));
    assert_eq!(LIVE.get() - before, 0, "bytes are held");
}

#[test]
fn a_kind_is_dropped_with_its_registry() {
    let kind = load();
    let held = Arc::downgrade(kind.counted().expect("a kind from a folder is counted"));
    let registry = Registry::new(&[&[kind]]).expect("one kind has one name");
    assert!(held.upgrade().is_some() && registry.get("Posterize").is_some());
    drop(registry);
    assert!(held.upgrade().is_none(), "something holds the kind");
}

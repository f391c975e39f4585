//! A frame in which nothing changes allocates nothing of ours, in either world.
//!
//! A counting allocator keeps the call stack of every allocation while systems of the plug-in run, which is on one thread
//! here. The first function outwards from the allocator that belongs to one of our crates, to Bevy or to wgpu is the
//! origin. A function that the compiler has inlined into one of ours counts as ours, so our share is never too small.
#![allow(unsafe_code, reason = "an allocator is unsafe by nature; this one only counts and forwards")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::backtrace::Backtrace;
use std::cell::{Cell, RefCell};

use bevy::camera::Viewport;
use bevy::core_pipeline::prepass::DepthPrepass;
use bevy::core_pipeline::schedule::Core3d;
use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::render_resource::TextureFormat;
use bevy_afterimage::{Afterimage, AfterimageStatus, AfterimageSystems};

use shown::{Folder, Shown};

#[path = "all/shown.rs"]
#[allow(dead_code, reason = "the other tests use all of it")]
mod shown;

/// How many frames are counted. To name the functions of each call stack takes long.
const FRAMES: usize = 2;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

struct Counting;

thread_local! {
    /// Whether systems of the plug-in run on this thread.
    static IS_OURS: Cell<bool> = const { Cell::new(false) };
    static STACKS: RefCell<Vec<Backtrace>> = const { RefCell::new(Vec::new()) };
}

// SAFETY: every call is forwarded to the system's allocator; counting is off while it works, so it never calls itself.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `GlobalAlloc`, which is also that of the system's allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above; the pointer came from the system's allocator.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

fn count() {
    if IS_OURS.try_with(|is_ours| is_ours.replace(false)).unwrap_or(false) {
        let stack = Backtrace::force_capture();
        STACKS.with_borrow_mut(|stacks| stacks.push(stack));
        IS_OURS.set(true);
    }
}

/// Whether an allocation is ours: the first known function on a call stack, from the allocator outwards, is.
fn is_ours(stack: &str) -> bool {
    for line in stack.lines() {
        // `   7: <afterimage_gpu::store::Store as core::ops::Drop>::drop`
        let Some((_, function)) = line.split_once(": ") else { continue };
        let krate = function.trim_start_matches(['<', '&', '[']).split("::").next().unwrap_or_default();
        match krate {
            _ if krate.starts_with("afterimage") || krate == "bevy_afterimage" => return true,
            _ if krate.starts_with("bevy_") || krate.starts_with("wgpu") || krate == "naga" || krate == "ash" => {
                return false;
            }
            _ => {}
        }
    }
    false
}

/// Counts from now on while the plug-in's systems run.
fn count_ours(app: &mut App) {
    let (begin, end) = (|| IS_OURS.set(true), || IS_OURS.set(false));
    let mark = |schedule: &mut Schedule, set: AfterimageSystems| {
        schedule.set_executor(SingleThreadedExecutor::new());
        schedule.add_systems((begin.before(set), end.after(set)));
    };
    app.edit_schedule(PostUpdate, |schedule| mark(schedule, AfterimageSystems::Follow));
    app.sub_app_mut(RenderApp).edit_schedule(Core3d, |schedule| mark(schedule, AfterimageSystems::Record));
}

/// The call stacks of our allocations in some frames, and the number of all allocations.
fn counted(app: &mut App, frames: usize) -> (Vec<String>, usize) {
    STACKS.take();
    (0..frames).for_each(|_| app.update());
    let stacks = STACKS.take();
    let all = stacks.len();
    let ours = stacks.iter().map(Backtrace::to_string).filter(|stack| is_ours(stack));
    (ours.collect(), all)
}

const DISTANCE: &str = r#"Pipeline(inputs: { "scene": Color, "depth": Depth, "camera": Camera },
    nodes: { "far": LinearDepth(depth: "depth", camera: "camera") }, outputs: { "far": "far" })"#;

#[test]
fn a_steady_frame_allocates_nothing_of_ours() {
    // A debug build of wgpu captures call stacks of its own, and an allocation in one must not capture another.
    // SAFETY: no other thread reads the environment: this is the program's only test, and it has started nothing yet.
    unsafe { std::env::set_var("RUST_LIB_BACKTRACE", "0") };
    let own = Folder::new("steady");
    let lynx = std::fs::read_to_string(shown::pipelines().join("lynx.ron")).expect("it is in the repository");
    own.write("lynx.ron", &lynx);
    own.write("depth.ron", DISTANCE);
    let mut shown = Shown::new(&own.0, TextureFormat::Rgba8UnormSrgb);
    // One camera with a parameter of its own, and one with a viewport, a prepass and a block.
    let look = shown.look("lynx.ron").set("lit.strength", 0.3);
    shown.spawn(Vec3::new(0.0, 1.0, 7.0), look);
    let look = shown.look("depth.ron");
    let viewport = Viewport { physical_position: UVec2::new(90, 10), physical_size: UVec2::new(60, 40), ..default() };
    let camera = Camera { viewport: Some(viewport), order: 1, ..default() };
    let second = shown.spawn(Vec3::new(2.0, 1.0, 7.0), (camera, look, DepthPrepass));
    let is_steady = |shown: &mut Shown| {
        shown.run(1);
        let world = shown.app.world_mut();
        let mut statuses = world.query::<&AfterimageStatus>();
        statuses.iter(world).all(|status| status.is_running && !status.is_changing)
    };
    shown.wait("a steady frame", |shown| is_steady(shown).then_some(()));
    assert!((0..100).all(|_| is_steady(&mut shown)));
    count_ours(&mut shown.app);
    shown.run(5);
    let (ours, all) = counted(&mut shown.app, FRAMES);
    assert!(all > 10 * FRAMES, "wgpu allocates in each command of ours: {all}");
    let first = ours.first().map_or("", String::as_str);
    assert!(ours.is_empty(), "{} of {all} allocations in {FRAMES} frames:\n{first}", ours.len());
    println!("0 of {all} allocations in {FRAMES} frames are ours");
    // A counter that misses this misses everything.
    let mut look = shown.app.world_mut().get_mut::<Afterimage>(second).expect("it has a pipeline");
    look.facts.insert("new".into(), true.into());
    assert!(!counted(&mut shown.app, 1).0.is_empty());
}

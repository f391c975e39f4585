//! A frame allocates nothing of ours on the host's thread while nothing changes, and nothing where a parameter is set.
//!
//! This is a binary of its own, because it has its own allocator.
#![allow(missing_docs, clippy::print_stdout, reason = "a test binary has no outside")]

#[path = "../graph/afterimage/benches/counting/mod.rs"]
mod counting;

use std::error::Error;
use std::process::Command;

use afterimage::Post;
use afterimage::host::Parameter;
use afterimage_gpu::{Frame, Gpu, Opening, Texels, upload, wgpu};
use afterimage_graph::check::{CheckOptions, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::node::Registry;
use afterimage_plan::Options;
use counting::{Counting, HOST, OURS, THEIRS, asker, counted};

#[global_allocator]
static COUNTING: Counting = Counting;

/// Comes before `RUST_BACKTRACE`.
const ALONE: &str = "RUST_LIB_BACKTRACE";
const SIZE: [u32; 2] = [64, 36];
/// The call stack of each allocation is read, which takes long.
const FRAMES: u32 = 3;

type Outcome = Result<(), Box<dyn Error>>;

struct Host {
    gpu: Gpu,
    post: Post,
    textures: [wgpu::Texture; 2],
    /// Of the scene and of the screen.
    views: [wgpu::TextureView; 2],
}

impl Host {
    fn new() -> Result<Self, Box<dyn Error>> {
        Self::of("lynx.ron")
    }

    /// A host of a built-in pipeline.
    fn of(name: &str) -> Result<Self, Box<dyn Error>> {
        let gpu = Gpu::open(&Opening::default())?;
        let path = format!("{}/../pipelines/{name}", env!("CARGO_MANIFEST_DIR"));
        let options = CheckOptions { loader: &NoFiles, ..CheckOptions::default() };
        let document = parse(&path, &std::fs::read_to_string(&path)?)?;
        let (graph, _) = check(&document, &Registry::new(&[afterimage_nodes::ALL])?, &options)?;
        let [width, height] = SIZE;
        let pixels: Vec<_> = (0..width * height).map(|at| [at as f32 * 1e-4, 0.5, 2.0, 1.0]).collect();
        let input = upload(&gpu.device, &gpu.queue, &Texels::from_floats_as_half(width, height, &pixels))?;
        let output = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("screen"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Bgra8Unorm,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let textures = [input, output];
        let views = textures.each_ref().map(|texture| texture.create_view(&Default::default()));
        let post = Post::new(&gpu, graph);
        Ok(Self { gpu, post, textures, views })
    }

    /// Makes another view of the scene or of the screen, as hosts do in every frame.
    fn renew_view(&mut self, index: usize) {
        self.views[index] = self.textures[index].create_view(&Default::default());
    }

    fn frame(&mut self, set: Option<(Parameter<f32>, f32)>) -> Outcome {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        if let Some((parameter, value)) = set {
            self.post.set(parameter, value)?;
        }
        let (inputs, outputs) = (&[("scene", &self.views[0])], &[("display", &self.views[1])]);
        self.post.encode(&mut encoder, &Frame { inputs, outputs, dt: 1.0 / 60.0, ..Frame::default() })?;
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }
}

/// Runs a test of this binary in a process in which only the counter takes call stacks. wgpu takes some in debug builds
/// where `RUST_BACKTRACE` asks for them, and allocates meanwhile: the counter would wait for a lock that its own thread
/// holds.
fn run_without_backtraces(test: &str) -> Outcome {
    let run = Command::new(std::env::current_exe()?).args([test, "--exact", "--nocapture"]).env(ALONE, "0").output()?;
    let text = [run.stdout, run.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    assert!(run.status.success() && text.contains("1 passed"), "{text}");
    Ok(())
}

#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_allocates_nothing_of_ours_also_with_a_new_value() -> Outcome {
    if std::env::var_os(ALONE).is_none_or(|value| value != "0") {
        return run_without_backtraces("a_frame_allocates_nothing_of_ours_also_with_a_new_value");
    }
    let mut host = Host::new()?;
    let strength = host.post.parameter::<f32>("lit.strength")?;
    // The first frame makes bind groups: a counter that misses this misses everything.
    let first = counted(1, || host.frame(None))?;
    assert!(first.contains_key(OURS) && first.contains_key(THEIRS), "{first:?}");
    for frame in 0..6 {
        host.frame(Some((strength, 0.1 + 0.1 * frame as f32)))?;
    }
    let steady = counted(FRAMES, || host.frame(None))?;
    let mut value = 0.2;
    let moved = counted(FRAMES, || {
        value += 0.01;
        host.frame(Some((strength, value)))
    })?;
    println!("bytes and calls in {FRAMES} frames: steady {steady:?}, with a new value {moved:?}");
    for asked in [&steady, &moved] {
        assert!(asked.contains_key(THEIRS) && !asked.contains_key(OURS), "{asked:?}");
    }
    // The value arrives at the device: wgpu allocates for it.
    assert!(moved[THEIRS].1 > steady[THEIRS].1, "{steady:?}, {moved:?}");
    Ok(())
}

/// MiB of memory of the process.
#[cfg(target_os = "linux")]
fn resident() -> Result<f64, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).ok_or("it states the memory")?;
    Ok(line.trim().trim_end_matches(" kB").parse::<f64>()? / 1024.0)
}

/// Mesa's driver for processors compiles a pass whose branches depend on a uniform buffer again in each frame, and keeps
/// all of them: 0.4 MiB a frame.
#[test]
#[cfg(target_os = "linux")]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn frames_of_a_pass_that_branches_on_parameters_keep_no_memory() -> Outcome {
    if std::env::var_os(ALONE).is_none_or(|value| value != "0") {
        return run_without_backtraces("frames_of_a_pass_that_branches_on_parameters_keep_no_memory");
    }
    let mut host = Host::of("exposure.ron")?;
    host.post.set_options(Options { fuse: false, exact: true, ..Options::default() });
    (0..40).try_for_each(|_| host.frame(None))?;
    let before = resident()?;
    (0..120).try_for_each(|_| host.frame(None))?;
    let grown = resident()? - before;
    assert!(grown < 12.0, "{grown:.1} MiB in 120 frames");
    Ok(())
}

/// The view of a swap chain is new in every frame, and that of a scene may be.
#[test]
#[cfg_attr(no_gpu, ignore = "AFTERIMAGE_NO_GPU is set")]
fn a_frame_with_a_new_view_allocates_nothing_of_ours() -> Outcome {
    if std::env::var_os(ALONE).is_none_or(|value| value != "0") {
        return run_without_backtraces("a_frame_with_a_new_view_allocates_nothing_of_ours");
    }
    let mut host = Host::new()?;
    for (index, name) in ["scene", "screen"].into_iter().enumerate() {
        // The cache of bind groups is filled first.
        for _ in 0..40 {
            host.renew_view(index);
            host.frame(None)?;
        }
        let asked = counted(FRAMES, || {
            host.renew_view(index);
            host.frame(None)
        })?;
        println!("bytes and calls in {FRAMES} frames with a new view of the {name}: {asked:?}");
        assert!(asked.contains_key(THEIRS) && !asked.contains_key(OURS), "{name}: {asked:?}");
    }
    Ok(())
}

#[test]
fn the_nearest_known_crate_of_a_call_stack_is_the_origin() {
    let stack = |functions: &[&str]| functions.join("\n   7: ");
    let origin = |functions: &[&str]| asker(&format!("   6: {}", stack(functions)));
    let ours = "afterimage_gpu::post::Post::encode";
    assert_eq!(origin(&["alloc::vec::Vec<T>::push", ours, "wgpu::Queue::submit"]), OURS);
    assert_eq!(origin(&["<wgpu::Queue as wgpu::dispatch::QueueInterface>::write_buffer", ours]), THEIRS);
    assert_eq!(origin(&["<f32 as afterimage_base::value::ParamType>::into_value", "wgpu::x"]), OURS);
    assert_eq!(origin(&["<&[afterimage_plan::Part] as core::fmt::Debug>::fmt"]), OURS);
    assert_eq!(origin(&["alloc::vec::Vec<T>::push", "allocations::main"]), HOST);
}

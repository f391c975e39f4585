//! The host cost of a steady frame: its allocations by crate, and the time to record, finish and submit it.
//!
//! An allocator tells the framework's allocations from those of wgpu: see `counting`.
//!
//! Ends with an error if the framework allocates anything. Run it with `cargo bench -p afterimage --bench steady`.
#![allow(clippy::print_stdout, reason = "a benchmark's figures are its output")]

mod counting;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use afterimage_gpu::{Executor, Frame, Gpu, Opening, Texels, upload, wgpu};
use afterimage_graph::check::{CheckOptions, NoFiles, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_plan::{HostImageDesc, HostInputs, PlanRequest, plan};
use counting::{Counting, HOST, OURS, THEIRS, counted};

const WARM_UP: u32 = 8;
const FRAMES: u32 = 20;
/// Number of frames in each median.
const TIMED: usize = 300;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() -> ExitCode {
    // `cargo test` runs benchmarks with this flag, to check that they start.
    let frames = if std::env::args().any(|argument| argument == "--test") { 1 } else { FRAMES };
    match measure(frames) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            println!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Prints the allocations of a frame. Returns whether the framework made none.
fn measure(frames: u32) -> Result<bool, Box<dyn std::error::Error>> {
    let gpu = Gpu::open(&Opening::default())?;
    let size = Size::new(256, 144);
    for pipeline in ["lynx", "exposure", "tsushima"] {
        time(&gpu, pipeline, size, if frames == 1 { 1 } else { TIMED })?;
    }
    let (executor, input) = load(&gpu, "lynx", size)?;
    let view = input.create_view(&Default::default());
    let inputs = [("scene", &view)];
    let mut executor = executor;
    // The first frame makes bind groups, which allocates: a counter that misses this misses everything.
    let first = counted(1, || frame(&gpu, &mut executor, &inputs))?;
    if !first.contains_key(OURS) {
        return Err("the counter does not see the framework's allocations".into());
    }
    for _ in 0..WARM_UP {
        frame(&gpu, &mut executor, &inputs)?;
    }
    let asked = counted(frames, || frame(&gpu, &mut executor, &inputs))?;
    println!("bytes and allocations of one steady frame of lynx.ron, {frames} frames, on {}:", gpu.name());
    for who in [OURS, THEIRS, HOST] {
        let (bytes, calls) = asked.get(who).copied().unwrap_or_default();
        let mean = |all: usize| all as f64 / f64::from(frames);
        println!("  {who:14} {:10.1} bytes in {:6.1} allocations", mean(bytes), mean(calls));
    }
    Ok(!asked.contains_key(OURS))
}

/// Prints the median microseconds to record, finish and submit a frame. The previous frame has always ended.
fn time(gpu: &Gpu, pipeline: &str, size: Size, frames: usize) -> Result<(), Box<dyn std::error::Error>> {
    let (mut executor, input) = load(gpu, pipeline, size)?;
    let view = input.create_view(&Default::default());
    let inputs = [("scene", &view)];
    let mut times: [Vec<f64>; 3] = Default::default();
    for _ in 0..WARM_UP {
        frame(gpu, &mut executor, &inputs)?;
    }
    for number in 0..frames {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let time = number as f64 / 60.0;
        executor.encode(&mut encoder, &Frame { inputs: &inputs, time, dt: 1.0 / 60.0, ..Frame::default() })?;
        let recorded = Instant::now();
        let commands = encoder.finish();
        let finished = Instant::now();
        gpu.queue.submit([commands]);
        let spans = [recorded - start, finished - recorded, finished.elapsed()];
        times.iter_mut().zip(spans).for_each(|(times, span)| times.push(span.as_secs_f64() * 1e6));
        gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
    }
    let [record, finish, submit] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    let passes = executor.plan().map_or(0, |plan| plan.passes.len());
    println!("{pipeline}.ron, {passes} passes: {record:.1} us to record, {finish:.1} to finish, {submit:.1} to submit");
    Ok(())
}

fn load(gpu: &Gpu, pipeline: &str, size: Size) -> Result<(Executor, wgpu::Texture), Box<dyn std::error::Error>> {
    let path = format!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/{}.ron"), pipeline);
    let registry = Registry::new(&[afterimage_nodes::ALL])?;
    let refuse = |errors: afterimage_graph::diagnostic::Diagnostics| format!("{errors:?}");
    let document = parse(&path, &std::fs::read_to_string(&path)?).map_err(refuse)?;
    let options = CheckOptions { tier: None, sets: Vec::new(), loader: &NoFiles };
    let (graph, _) = check(&document, &registry, &options).map_err(refuse)?;
    let mut executor = Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone());
    let requirement = |desc: &ImageDesc| executor.requirement(desc);
    let setting = PlanRequest {
        given: HostInputs {
            inputs: [("scene".to_owned(), HostImageDesc { desc: ImageDesc::new(size), finite: false })].into(),
            ..HostInputs::none(size)
        },
        facts: Default::default(),
        caps: gpu.caps.clone(),
        options: Default::default(),
        dynamic: Default::default(),
        requirement: &requirement,
    };
    let plan = plan(&graph, &setting)?;
    executor.load(Arc::new(plan))?;
    let pixels = (0..size.width * size.height).map(|at| [at as f32 * 1e-4, 0.5, 2.0, 1.0]).collect::<Vec<_>>();
    let texels = Texels::from_floats_as_half(size.width, size.height, &pixels);
    Ok((executor, upload(&gpu.device, &gpu.queue, &texels)?))
}

fn frame(
    gpu: &Gpu,
    executor: &mut Executor,
    inputs: &[(&str, &wgpu::TextureView)],
) -> Result<(), Box<dyn std::error::Error>> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    executor.encode(&mut encoder, &Frame { inputs, dt: 1.0 / 60.0, ..Frame::default() })?;
    gpu.queue.submit([encoder.finish()]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(())
}

//! `afterimage bench`: what a pipeline costs here, pass by pass, beside what the device could do.

mod calibrate;
mod clock;
mod copy;
mod grow;
mod inputs;
mod peer;
mod plain;
mod plot;
mod report;
mod runner;

use std::collections::VecDeque;
use std::path::Path;
use std::time::Instant;

use afterimage_gpu::{Executor, Gpu};
use afterimage_graph::check::Graph;
use afterimage_graph::image::Size;
use afterimage_graph::node::{NodeKind, Registry};
use afterimage_plan::{Options, Plan, Stage};

use self::clock::Stopwatch;
use self::inputs::Inputs;
use self::peer::{Chain, PeerReport};
use self::report::{FirstFrame, HostReport, PassReport, Report};
use self::runner::Runner;
use crate::args::BenchArgs;
use crate::failure::Failure;
use crate::pipeline::{check_text, facts, load_graph, plan_options, read_text, registry};
use crate::session::{open, options_on};
use crate::terminal::say;
use afterimage_media::write_atomic;

pub(crate) fn run(args: &BenchArgs, tables: &[&[NodeKind]]) -> Result<(), Failure> {
    let registry = registry(tables, &args.options.nodes)?;
    let gpu = open(&args.device)?;
    if args.calibrate {
        say(&calibrate::run(&gpu, &registry, args.frames)?);
    }
    if let Some(folder) = &args.grow {
        say(&grow::run(&gpu, &registry, args.frames, folder)?);
    }
    let Some(pipeline) = &args.pipeline else { return Ok(()) };
    let report = measure(args, pipeline, &registry, &gpu)?;
    say(&report.to_string());
    if let Some(file) = &args.json {
        let json = serde_json::to_vec_pretty(&report).expect("names and finite numbers are JSON");
        write_atomic(file, &json)?;
    }
    Ok(())
}

fn measure(args: &BenchArgs, pipeline: &Path, registry: &Registry, gpu: &Gpu) -> Result<Report, Failure> {
    // Also says the warnings, which need not be said again for each start below.
    let graph = load_graph(pipeline, registry, &args.options)?;
    let size = Size::new(args.size.0, args.size.1);
    let inputs = Inputs::new(gpu, registry, &graph, size)?;
    let options = options_on(gpu, plan_options(&args.plan), &args.device.arithmetic);
    let (first_frame, mut runner) = starts(args, pipeline, (registry, options), gpu, &inputs)?;
    let stopwatch = Stopwatch::new(gpu);
    let (gpu_ms, peer) = frame_times(args, &graph, gpu, &stopwatch, &inputs, &mut runner)?;
    let host = host_times(gpu, &mut runner, args.frames)?;
    let copy_gbps = copy::bandwidth(gpu, &stopwatch)?;
    let times = runner.pass_times(&stopwatch, args.frames)?;
    let plan = runner.plan();
    let info = gpu.adapter.get_info();
    Ok(Report {
        pipeline: pipeline.display().to_string(),
        adapter: info.name,
        driver: format!("{} {}", info.driver, info.driver_info),
        size: [size.width, size.height],
        frames: args.frames,
        clock: if stopwatch.is_gpu() { "gpu" } else { "host" },
        gpu_ms,
        host_us: host.encode_us + host.submit_us,
        host,
        copy_gbps,
        bytes: plan.bytes_moved(),
        share: share(plan.bytes_moved(), gpu_ms, copy_gbps),
        memory: plan.memory.placed + plan.memory.kept,
        first_frame_ms: first_frame,
        peer,
        passes: passes(plan, &times, copy_gbps),
    })
}

/// Gigabytes a second of so many bytes in so many milliseconds, as a share of what the device can copy; a time of zero has none.
fn share(bytes: u64, milliseconds: f64, copy_gbps: f64) -> f64 {
    if milliseconds > 0.0 { bytes as f64 * 1e-6 / milliseconds / copy_gbps } else { 0.0 }
}

fn passes(plan: &Plan, times: &[f64], copy_gbps: f64) -> Vec<PassReport> {
    let report = |(index, ms): (usize, &f64)| {
        let bytes = plan.bytes_moved_by(index);
        let pass = &plan.recording.passes[index];
        PassReport {
            name: pass.label.clone(),
            nodes: pass.nodes.clone(),
            stage: if plan.stages[index] == Stage::Compute { "compute" } else { "fragment" },
            ms: *ms,
            bytes,
            share: share(bytes, *ms, copy_gbps),
        }
    };
    times.iter().enumerate().map(report).collect()
}

/// From the text to the first picture, without the driver's pipelines and with them; the second one's runner goes on.
fn starts<'a>(
    args: &BenchArgs,
    pipeline: &Path,
    (registry, options): (&Registry, Options),
    gpu: &'a Gpu,
    inputs: &'a Inputs,
) -> Result<(FirstFrame, Runner<'a>), Failure> {
    let start = |known: &[u8]| -> Result<(f64, Runner<'a>), Failure> {
        let executor = Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone()).with_pipeline_cache(known);
        let begun = Instant::now();
        let text = read_text(pipeline, "pipeline")?;
        let (graph, _) = check_text(&pipeline.to_string_lossy(), &text, registry, &args.options)?;
        let mut runner = Runner::new(gpu, inputs, &graph, facts(&args.options)?, options, executor)?;
        runner.frame()?;
        Ok((begun.elapsed().as_secs_f64() * 1e3, runner))
    };
    let (cold, first) = start(&[])?;
    let (warm, runner) = start(&first.pipelines())?;
    Ok((FirstFrame { cold, warm }, runner))
}

/// Frames that a renderer has under way while it records another.
const UNDER_WAY: usize = 2;

/// What the processor does for a frame, without timestamps, in a program that does not wait for every frame. Where the adapter is the processor
/// itself, earlier frames would take the cores away: there each one ends before the next begins.
fn host_times(gpu: &Gpu, runner: &mut Runner<'_>, frames: u32) -> Result<HostReport, Failure> {
    let under_way = if gpu.is_processor() { 0 } else { UNDER_WAY };
    let (mut encode, mut submit) = (Vec::new(), Vec::new());
    let mut submitted = VecDeque::new();
    for _ in 0..frames {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        runner.encode(&mut encoder)?;
        let commands = encoder.finish();
        let encoded = Instant::now();
        submitted.push_back(gpu.queue.submit([commands]));
        submit.push(encoded.elapsed().as_secs_f64() * 1e6);
        encode.push((encoded - start).as_secs_f64() * 1e6);
        if submitted.len() > under_way {
            clock::wait_for(gpu, submitted.pop_front())?;
        }
    }
    clock::wait(gpu)?;
    Ok(HostReport { encode_us: clock::median(encode), submit_us: clock::median(submit) })
}

/// Milliseconds of a frame, and of the hand-written chains if the pipeline is the one that they were written for.
fn frame_times(
    args: &BenchArgs,
    graph: &Graph,
    gpu: &Gpu,
    stopwatch: &Stopwatch<'_>,
    inputs: &Inputs,
    runner: &mut Runner<'_>,
) -> Result<(f64, Option<PeerReport>), Failure> {
    let (Some(chain), Some(scene)) = (Chain::of(graph), inputs.first()) else {
        return Ok((stopwatch.median(args.frames, |encoder| runner.encode(encoder))?, None));
    };
    let (ours, peer) = peer::measure(stopwatch, gpu, &chain, scene, args.frames, runner)?;
    Ok((ours, Some(peer)))
}

//! How time and memory grow with pixels and with nodes: a table and a plot.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use afterimage_gpu::{Executor, Gpu};
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_plan::Requirement;

use super::clock::{Stopwatch, median, wait};
use super::inputs::Inputs;
use super::plot::{Chart, Line, page};
use super::runner::Runner;
use crate::args::PipelineOptions;
use crate::failure::Failure;
use crate::pipeline::check_text;
use afterimage_media::write_atomic;

/// 720p to 16K, all 16:9.
const HEIGHTS: [u32; 7] = [720, 1080, 1440, 2160, 4320, 5760, 8640];
/// Nodes of a chain.
const LENGTHS: [usize; 8] = [2, 5, 10, 20, 50, 100, 200, 500];
/// The height of the frame that chains work on.
const CHAIN_HEIGHT: u32 = 720;
/// The largest heights that a processor is asked for: it would take minutes for more.
const PATIENCE: (u32, u32) = (1440, 90);
/// How often each graph is planned.
const PLANS: usize = 7;

/// One measured graph.
struct Growth {
    /// Which row of measurements it belongs to.
    series: &'static str,
    nodes: usize,
    size: Size,
    passes: usize,
    /// From the text to the plan.
    plan_ms: f64,
    gpu_ms: f64,
    record_us: f64,
    /// Bytes of the transient images, as they are placed and as they would be one by one.
    placed: u64,
    unshared: u64,
}

/// Measures, writes `growth.csv` and `growth.svg` to the folder, and gives the table.
pub(super) fn run(gpu: &Gpu, registry: &Registry, frames: u32, folder: &Path) -> Result<String, Failure> {
    let stopwatch = Stopwatch::new(gpu);
    let mut all = Vec::new();
    let (highest, chain_height) = if gpu.is_processor() { PATIENCE } else { (u32::MAX, CHAIN_HEIGHT) };
    for size in HEIGHTS.into_iter().filter(|height| *height <= highest).map(wide) {
        if size.width <= gpu.caps.max_side {
            all.push(measure(gpu, registry, &stopwatch, "pixels", &pyramid(), size, frames)?);
        }
    }
    for length in LENGTHS {
        for (series, text) in [("point nodes", points(length)), ("gather nodes", gathers(length))] {
            all.push(measure(gpu, registry, &stopwatch, series, &text, wide(chain_height), frames)?);
        }
    }
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::machine(format!("cannot make the folder `{}`: {error}", folder.display())))?;
    let csv = csv(&all);
    write_atomic(&folder.join("growth.csv"), csv.as_bytes())?;
    write_atomic(&folder.join("growth.svg"), plot(&all, &gpu.name(), stopwatch.is_gpu()).as_bytes())?;
    Ok(csv)
}

/// 16:9.
fn wide(height: u32) -> Size {
    Size::new(height / 9 * 16, height)
}

/// Bloom, a curve and the way to the display: seven nodes, most of whose passes are small.
fn pyramid() -> String {
    r#"Pipeline(
    inputs: { "scene": Color },
    nodes: {
        "exposed": Exposure(source: "scene", stops: 0.5),
        "bright": Extract(source: "exposed"),
        "mips": Downsample(source: "bright", levels: 5),
        "bloom": Upsample(source: "mips"),
        "lit": Composite(base: "exposed", bloom: "bloom"),
        "mapped": ToneMap(source: "lit"),
        "display": Encode(source: "mapped"),
    },
    outputs: { "display": "display" },
)"#
    .to_owned()
}

/// A chain of kernels that only look at their own pixel: all become one pass.
fn points(length: usize) -> String {
    chain(length, "Saturation(amount: 0.99")
}

/// A chain of blurs, none of which can be joined with the next.
fn gathers(length: usize) -> String {
    chain(length, "Gaussian(sigma: 1.0")
}

fn chain(length: usize, node: &str) -> String {
    let mut text = "Pipeline(inputs: { \"scene\": Color }, nodes: {\n".to_owned();
    for at in 0..length {
        let source = if at == 0 { "scene".to_owned() } else { format!("n{}", at - 1) };
        let _ = writeln!(text, "    \"n{at}\": {node}, source: \"{source}\"),");
    }
    let _ = write!(text, "}}, outputs: {{ \"out\": \"n{}\" }})", length - 1);
    text
}

fn measure(
    gpu: &Gpu,
    registry: &Registry,
    stopwatch: &Stopwatch<'_>,
    series: &'static str,
    text: &str,
    size: Size,
    frames: u32,
) -> Result<Growth, Failure> {
    let (graph, _) = check_text("growth.ron", text, registry, &no_options())?;
    let inputs = Inputs::new(gpu, registry, &graph, size)?;
    let plan_ms = plan_time(gpu, registry, &inputs, text)?;
    let executor = Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone());
    let mut runner = Runner::new(gpu, &inputs, &graph, Default::default(), Default::default(), executor)?;
    let gpu_ms = stopwatch.median(frames, |encoder| runner.encode(encoder))?;
    let record_us = record_times(gpu, &mut runner, frames)?;
    let plan = runner.plan();
    Ok(Growth {
        series,
        nodes: graph.nodes.len(),
        size,
        passes: plan.recording.passes.len(),
        plan_ms,
        gpu_ms,
        record_us,
        placed: plan.memory.placed,
        unshared: plan.memory.unshared,
    })
}

/// From the text to the plan.
fn plan_time(gpu: &Gpu, registry: &Registry, inputs: &Inputs, text: &str) -> Result<f64, Failure> {
    let mut times = Vec::new();
    for _ in 0..PLANS {
        let begun = Instant::now();
        let (graph, _) = check_text("growth.ron", text, registry, &no_options())?;
        Runner::plan_of(gpu, inputs, &graph, Default::default(), Default::default(), Requirement::typical)?;
        times.push(begun.elapsed().as_secs_f64() * 1e3);
    }
    Ok(median(times))
}

fn no_options() -> PipelineOptions {
    PipelineOptions { sets: Vec::new(), facts: Vec::new(), tier: None, nodes: Vec::new() }
}

fn record_times(gpu: &Gpu, runner: &mut Runner<'_>, frames: u32) -> Result<f64, Failure> {
    let mut times = Vec::new();
    for _ in 0..frames {
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        runner.encode(&mut encoder)?;
        let commands = encoder.finish();
        times.push(start.elapsed().as_secs_f64() * 1e6);
        gpu.queue.submit([commands]);
        wait(gpu)?;
    }
    Ok(median(times))
}

fn csv(all: &[Growth]) -> String {
    let mut text = "series,nodes,width,height,passes,plan ms,frame ms,record us,placed MiB,one by one MiB\n".to_owned();
    for row in all {
        let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        let Growth { series, nodes, size, passes, plan_ms, gpu_ms, record_us, placed, unshared } = row;
        let (placed, unshared) = (mebibytes(*placed), mebibytes(*unshared));
        let _ = writeln!(
            text,
            "{series},{nodes},{},{},{passes},{plan_ms:.2},{gpu_ms:.4},{record_us:.1},{placed:.2},{unshared:.2}",
            size.width, size.height
        );
    }
    text
}

fn plot(all: &[Growth], adapter: &str, gpu_clock: bool) -> String {
    let of = |series: &str, x: fn(&Growth) -> f64, y: fn(&Growth) -> f64| {
        all.iter().filter(|row| row.series == series).map(|row| (x(row), y(row))).collect::<Vec<_>>()
    };
    let pixels = |row: &Growth| f64::from(row.size.width) * f64::from(row.size.height) * 1e-6;
    let nodes = |row: &Growth| row.nodes as f64;
    let mebibytes = |row: &Growth| row.placed as f64 / f64::from(1 << 20);
    let unshared = |row: &Growth| row.unshared as f64 / f64::from(1 << 20);
    let clock = if gpu_clock { "GPU milliseconds" } else { "milliseconds (wall clock)" };
    let line = |name: &'static str, points| Line { name, points };
    let both = |y: fn(&Growth) -> f64| {
        vec![line("point nodes", of("point nodes", nodes, y)), line("gather nodes", of("gather nodes", nodes, y))]
    };
    let charts = [
        Chart {
            title: clock,
            x: "megapixels, bloom and a curve",
            lines: vec![line("a frame", of("pixels", pixels, |r| r.gpu_ms))],
        },
        Chart {
            title: "MiB of images inside",
            x: "megapixels, bloom and a curve",
            lines: vec![
                line("placed", of("pixels", pixels, mebibytes)),
                line("one by one", of("pixels", pixels, unshared)),
            ],
        },
        Chart { title: clock, x: "nodes in a chain", lines: both(|r| r.gpu_ms) },
        Chart { title: "microseconds to record", x: "nodes in a chain", lines: both(|r| r.record_us) },
        Chart { title: "milliseconds from text to plan", x: "nodes in a chain", lines: both(|r| r.plan_ms) },
        Chart { title: "MiB of images inside", x: "nodes in a chain", lines: both(mebibytes) },
    ];
    page(adapter, &charts)
}

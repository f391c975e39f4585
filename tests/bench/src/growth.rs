//! The growth of time and memory with pixels and with nodes.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Instant;

use afterimage::offline::{Session, timing};
use afterimage_gpu::{Clock, FrameStep, Gpu, InputImage, median};
use afterimage_graph::check::Facts;
use afterimage_graph::image::Size;
use afterimage_graph::node::Registry;
use afterimage_lab::{LabError, scene};
use afterimage_plan::{HostImageDesc, HostInputs, Options, PlanRequest, Requirement, plan};

/// 720p to 16K, all 16:9.
const HEIGHTS: [u32; 7] = [720, 1080, 1440, 2160, 4320, 5760, 8640];
/// Nodes of a chain.
const LENGTHS: [usize; 8] = [2, 5, 10, 20, 50, 100, 200, 500];
/// The height of the frame of chains.
const CHAIN_HEIGHT: u32 = 720;
/// The largest heights on a processor, where more would take minutes: of frames, and of the frame of chains.
const PROCESSOR_HEIGHTS: (u32, u32) = (1440, 90);
/// The number of times that each graph is planned.
const PLANS: usize = 7;

/// One measured graph.
struct Growth {
    /// The series that it belongs to.
    series: &'static str,
    nodes: usize,
    size: Size,
    passes: usize,
    /// From the text to the plan.
    plan_ms: f64,
    gpu_ms: f64,
    record_us: f64,
    /// Bytes of the transient images: as they are placed, and with memory of its own for each.
    placed: u64,
    unshared: u64,
}

/// The figures, as comma-separated values.
pub(crate) fn growth(gpu: &Gpu, registry: &Registry, samples: u32) -> Result<String, LabError> {
    let conditions = Conditions { gpu, registry, clock: Clock::new(gpu)?, samples };
    let mut all = Vec::new();
    let (highest, chain_height) = if gpu.is_processor() { PROCESSOR_HEIGHTS } else { (u32::MAX, CHAIN_HEIGHT) };
    for size in HEIGHTS.into_iter().filter(|height| *height <= highest).map(wide) {
        if size.width <= gpu.caps.max_side {
            all.push(conditions.measure("pixels", &pyramid(), size)?);
        }
    }
    for length in LENGTHS {
        for (series, text) in [("point nodes", points(length)), ("gather nodes", gathers(length))] {
            all.push(conditions.measure(series, &text, wide(chain_height))?);
        }
    }
    Ok(csv(&all))
}

/// 16:9.
fn wide(height: u32) -> Size {
    Size::new(height / 9 * 16, height)
}

/// Bloom, a tone curve and the encoding: seven nodes with mostly small passes.
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

/// A chain of point kernels, which fuse to one pass.
fn points(length: usize) -> String {
    chain(length, "Saturation(amount: 0.99")
}

/// A chain of blurs, which cannot fuse.
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

/// The device and the conditions of all measurements.
struct Conditions<'a> {
    gpu: &'a Gpu,
    registry: &'a Registry,
    clock: Clock,
    samples: u32,
}

impl Conditions<'_> {
    fn measure(&self, series: &'static str, text: &str, size: Size) -> Result<Growth, LabError> {
        let graph = scene::graph(self.registry, "growth.ron", text)?;
        let images = scene::still(self.gpu, self.registry, &graph, size)?;
        let plan_ms = self.plan_time(&images, text, size)?;
        let mut session = Session::new(self.gpu, graph.clone(), Facts::default(), Options::default());
        session.load(size, &images)?;
        let (frame, _) = timing::frame_time(&mut session, &self.clock, self.samples, &images, Vec::new())?;
        let record_us = self.record_time(&mut session, &images)?;
        let plan = session.plan();
        Ok(Growth {
            series,
            nodes: graph.nodes.len(),
            size,
            passes: plan.passes.len(),
            plan_ms,
            gpu_ms: frame.ms(),
            record_us,
            placed: plan.memory.placed,
            unshared: plan.memory.unshared,
        })
    }

    /// Milliseconds from the text to the plan.
    fn plan_time(&self, images: &[InputImage], text: &str, size: Size) -> Result<f64, LabError> {
        let given = |image: &InputImage| (image.input.clone(), HostImageDesc { desc: image.desc, finite: false });
        let inputs: BTreeMap<_, _> = images.iter().map(given).collect();
        let mut times = Vec::new();
        for _ in 0..PLANS {
            let start = Instant::now();
            let graph = scene::graph(self.registry, "growth.ron", text)?;
            let request = PlanRequest {
                given: HostInputs { inputs: inputs.clone(), ..HostInputs::none(size) },
                facts: Facts::default(),
                caps: self.gpu.caps.clone(),
                options: Options::default(),
                dynamic: Default::default(),
                requirement: &Requirement::typical,
            };
            plan(&graph, &request)?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        Ok(median(times))
    }

    /// Microseconds to record a frame.
    fn record_time(&self, session: &mut Session, images: &[InputImage]) -> Result<f64, LabError> {
        let mut times = Vec::new();
        for _ in 0..self.samples {
            let start = Instant::now();
            let mut encoder = self.gpu.encoder();
            session.encode(&mut encoder, images, FrameStep::default())?;
            let commands = encoder.finish();
            times.push(start.elapsed().as_secs_f64() * 1e6);
            self.gpu.queue.submit([commands]);
            self.gpu.wait()?;
        }
        Ok(median(times))
    }
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

//! The hand-written rival of `lynx.ron`: a chain of plain wgpu passes, drawn or dispatched, with all that its author knows about the pipeline.

use afterimage_gpu::{Gpu, download};
use afterimage_graph::check::{Graph, GraphNode};
use afterimage_graph::image::{Format, Size};
use afterimage_graph::value::Value;
use serde::Serialize;
use wgpu::util::DeviceExt as _;
use wgpu::{BindGroupEntry, BindingResource, TextureFormat, TextureUsages, TextureView};

use super::clock::{Record, Stopwatch, wait};
use super::plain::{compute_pipeline, draw, draw_pipeline, group, groups, module, target};
use super::runner::Runner;
use crate::failure::Failure;

/// What the rivals took, in milliseconds, and how far their pictures are from ours.
#[derive(Debug, Serialize)]
pub(super) struct PeerReport {
    /// As one writes it by hand: from half the pixels, with four loads each, and without dither.
    #[serde(flatten)]
    pub(super) light: Times,
    /// With all the work of the pipeline: filters, weights, guards and dither.
    pub(super) same: Times,
}

/// One chain in its ways.
#[derive(Debug, Serialize)]
pub(super) struct Times {
    /// Draws, half-float levels.
    pub(super) fragment_ms: f64,
    /// Dispatches in one compute pass, half-float levels.
    pub(super) compute_ms: f64,
    /// The same with levels of 11, 11 and 10 bits; `None` where the device cannot store them.
    pub(super) compute_rg11b10_ms: Option<f64>,
    /// The largest difference of a channel, of 1.
    pub(super) max_difference: f32,
    /// The mean difference of a channel.
    pub(super) mean_difference: f32,
}

/// The numbers of the pipeline that the rival takes over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chain {
    levels: usize,
    threshold: f32,
    knee: f32,
    radius: f32,
    strength: f32,
    /// Whether the glow is laid over the picture through a tent, not bilinearly.
    tent: bool,
    gain: f32,
}

impl Chain {
    /// The rival's settings if the graph is the chain that it was written for.
    pub(super) fn of(graph: &Graph) -> Option<Self> {
        let wanted = ["Exposure", "Extract", "Downsample", "Upsample", "Composite", "ToneMap", "Encode"];
        // The last bits of its picture may be dithered; the rival does without.
        let nodes = match graph.nodes.as_slice() {
            [nodes @ .., last] if last.kind.name() == "Dither" => nodes,
            nodes => nodes,
        };
        let kinds: Vec<&str> = nodes.iter().map(|node| node.kind.name()).collect();
        if kinds != wanted || graph.nodes.iter().any(|node| node.off || node.when.is_some()) {
            return None;
        }
        let [exposure, extract, downsample, upsample, composite, tone_map, encode] = nodes else {
            return None;
        };
        let choices = [
            (extract, "method", "Gate"),
            (downsample, "filter", "Tap13"),
            (upsample, "blend", "Add"),
            (upsample, "filter", "Tent"),
            (composite, "blend", "Add"),
            (tone_map, "curve", "Aces"),
            (encode, "transfer", "Srgb"),
        ];
        if choices.iter().any(|(node, name, choice)| value(node, name) != Some(&Value::Choice(choice))) {
            return None;
        }
        Some(Self {
            levels: number(downsample, "levels")?.max(2.0) as usize,
            threshold: number(extract, "threshold")?,
            knee: number(extract, "knee")?,
            radius: number(upsample, "radius")?,
            strength: number(composite, "strength")?,
            tent: value(composite, "filter") == Some(&Value::Choice("Tent")),
            gain: number(exposure, "stops")?.exp2(),
        })
    }

    /// The uniform of the passes, where so many levels are coarser than the result.
    fn uniform(&self, coarser: usize) -> [f32; 8] {
        let all = (coarser + 1) as f32;
        let (low, high) = (self.threshold - self.knee, self.threshold + self.knee.max(1e-4));
        [low, high, 1.0 / all, coarser as f32 / all, self.radius, self.strength, self.gain, 0.0]
    }
}

fn value<'a>(node: &'a GraphNode, name: &str) -> Option<&'a Value> {
    node.values.get(node.kind.param(name)?.0)
}

fn number(node: &GraphNode, name: &str) -> Option<f32> {
    match value(node, name)? {
        Value::Float(number) => Some(*number as f32),
        Value::Int(number) => Some(*number as f32),
        _ => None,
    }
}

/// Times the rivals and ours on the same scene, and compares the pictures. Returns the time of ours too.
pub(super) fn measure(
    stopwatch: &Stopwatch<'_>,
    gpu: &Gpu,
    chain: &Chain,
    scene: &TextureView,
    frames: u32,
    ours: &mut Runner<'_>,
) -> Result<(f64, PeerReport), Failure> {
    let half = TextureFormat::Rgba16Float;
    let mut ways = vec![(Way::Draw, half), (Way::Dispatch, half)];
    if gpu.caps.storage.contains(&Format::Rg11b10Ufloat) {
        ways.push((Way::Dispatch, TextureFormat::Rg11b10Ufloat));
    }
    let of = |work| ways.iter().map(move |(way, format)| Peer::new(gpu, chain, scene, work, *way, *format));
    let peers: Vec<Peer> = of(Work::Light).chain(of(Work::Same)).collect();
    let mut records: Vec<Record<'_>> = vec![Box::new(|encoder| ours.encode(encoder))];
    for peer in &peers {
        records.push(Box::new(|encoder| {
            peer.record(encoder);
            Ok(())
        }));
    }
    let times = stopwatch.medians(frames, &mut records)?;
    drop(records);
    wait(gpu)?;
    let picture = ours.picture()?.to_floats();
    let (light, same) = peers.split_at(ways.len());
    let report = |peers: &[Peer], times: &[f64]| -> Result<Times, Failure> {
        let theirs = download(&gpu.device, &gpu.queue, peers[1].display.texture())?;
        let (max_difference, mean_difference) = difference(&picture, &theirs.to_floats());
        let compute_rg11b10_ms = times.get(2).copied();
        Ok(Times { fragment_ms: times[0], compute_ms: times[1], compute_rg11b10_ms, max_difference, mean_difference })
    };
    let (first, second) = times[1..].split_at(ways.len());
    Ok((times[0], PeerReport { light: report(light, first)?, same: report(same, second)? }))
}

/// The largest and the mean difference of a channel.
fn difference(ours: &[[f32; 4]], theirs: &[[f32; 4]]) -> (f32, f32) {
    let differences = ours.iter().zip(theirs).flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs()));
    let (largest, sum) = differences.fold((0.0_f32, 0.0), |(largest, sum), d| (largest.max(d), sum + f64::from(d)));
    (largest, (sum / (3 * ours.len().max(1)) as f64) as f32)
}

/// How much of the pipeline's work a rival does.
#[derive(Clone, Copy, PartialEq)]
enum Work {
    Light,
    Same,
}

#[derive(Clone, Copy, PartialEq)]
enum Way {
    Draw,
    Dispatch,
}

/// The chain with everything that a frame needs, made once.
struct Peer {
    dispatches: Vec<(wgpu::ComputePipeline, wgpu::BindGroup, [u32; 2])>,
    draws: Vec<(wgpu::RenderPipeline, wgpu::BindGroup, TextureView)>,
    display: TextureView,
}

/// One pass: which function, how many levels are coarser than its result, what it reads and writes.
struct Step<'a> {
    name: &'static str,
    coarser: usize,
    first: &'a TextureView,
    second: Option<&'a TextureView>,
    to: &'a TextureView,
}

impl Peer {
    fn new(gpu: &Gpu, chain: &Chain, scene: &TextureView, work: Work, way: Way, format: TextureFormat) -> Self {
        let usage = match way {
            Way::Draw => TextureUsages::RENDER_ATTACHMENT,
            Way::Dispatch => TextureUsages::STORAGE_BINDING,
        } | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC;
        let full = Size::new(scene.texture().width(), scene.texture().height());
        let halved = |size: &Size| Some(Size::new(size.width / 2, size.height / 2));
        let sizes: Vec<Size> = std::iter::successors(halved(&full), halved).take(chain.levels).collect();
        let level = |size: &Size| target(gpu, *size, format, usage);
        let down: Vec<TextureView> = sizes.iter().map(level).collect();
        let up: Vec<TextureView> = sizes[..sizes.len() - 1].iter().map(level).collect();
        let display = target(gpu, full, TextureFormat::Rgba8Unorm, usage);
        let mut peer = Self { dispatches: Vec::new(), draws: Vec::new(), display: display.clone() };
        let storage = if format == TextureFormat::Rg11b10Ufloat { "rg11b10ufloat" } else { "rgba16float" };
        let glow = if chain.tent { "tent(uv, 1.0)" } else { "near(uv)" };
        let same = (work == Work::Same).to_string();
        let source = include_str!("peer.wgsl").replace("LEVEL", storage).replace("GLOW", glow);
        let module = module(gpu, &source.replace("SAME_WORK", &same));
        let picked = (work == Work::Same).then(|| level(&full));
        for step in steps(scene, picked.as_ref(), &down, &up, &display) {
            peer.add(gpu, chain, &module, way, &step);
        }
        peer
    }

    fn add(&mut self, gpu: &Gpu, chain: &Chain, module: &wgpu::ShaderModule, way: Way, step: &Step<'_>) {
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let uniform = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("settings"),
            contents: bytemuck::bytes_of(&chain.uniform(step.coarser)),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let mut entries = Vec::new();
        let mut bind = |binding, resource| entries.push(BindGroupEntry { binding, resource });
        if !matches!(step.name, "extract" | "pick") {
            bind(0, BindingResource::Sampler(&sampler));
        }
        if !matches!(step.name, "halve" | "tame") {
            bind(1, uniform.as_entire_binding());
        }
        bind(2, BindingResource::TextureView(step.first));
        if let Some(second) = step.second {
            bind(3, BindingResource::TextureView(second));
        }
        let texture = step.to.texture();
        if way == Way::Draw {
            let pipeline = draw_pipeline(gpu, module, &format!("{}_draw", step.name), texture.format());
            let group = group(gpu, &pipeline.get_bind_group_layout(0), &entries);
            self.draws.push((pipeline, group, step.to.clone()));
            return;
        }
        bind(if step.name == "finish" { 5 } else { 4 }, BindingResource::TextureView(step.to));
        let pipeline = compute_pipeline(gpu, module, &format!("{}_dispatch", step.name));
        let group = group(gpu, &pipeline.get_bind_group_layout(0), &entries);
        self.dispatches.push((pipeline, group, groups(Size::new(texture.width(), texture.height()))));
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        for (pipeline, group, to) in &self.draws {
            draw(encoder, pipeline, group, to);
        }
        if self.dispatches.is_empty() {
            return;
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (pipeline, group, [x, y]) in &self.dispatches {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.dispatch_workgroups(*x, *y, 1);
        }
    }
}

fn steps<'a>(
    scene: &'a TextureView,
    picked: Option<&'a TextureView>,
    down: &'a [TextureView],
    up: &'a [TextureView],
    display: &'a TextureView,
) -> Vec<Step<'a>> {
    let last = down.len() - 1;
    let mut steps = match picked {
        None => vec![Step { name: "extract", coarser: 0, first: scene, second: None, to: &down[0] }],
        Some(picked) => vec![
            Step { name: "pick", coarser: 0, first: scene, second: None, to: picked },
            Step { name: "tame", coarser: 0, first: picked, second: None, to: &down[0] },
        ],
    };
    for at in 1..down.len() {
        steps.push(Step { name: "halve", coarser: 0, first: &down[at - 1], second: None, to: &down[at] });
    }
    for at in (0..last).rev() {
        let second = up.get(at + 1).unwrap_or(&down[last]);
        steps.push(Step { name: "enlarge", coarser: last - at, first: &down[at], second: Some(second), to: &up[at] });
    }
    steps.push(Step { name: "finish", coarser: 0, first: scene, second: Some(&up[0]), to: display });
    steps
}

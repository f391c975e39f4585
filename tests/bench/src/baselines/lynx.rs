//! The baseline of `lynx.ron`: the same chain written by hand with wgpu, with draws or with dispatches.

use afterimage_gpu::wgpu::util::DeviceExt as _;
use afterimage_gpu::wgpu::{self, BindGroupEntry, BindingResource, TextureFormat, TextureUsages, TextureView};
use afterimage_gpu::{FrameTime, Gpu, TimedCommands, download};
use afterimage_graph::check::{Graph, GraphNode};
use afterimage_graph::image::{Format, Size};
use afterimage_graph::value::Value;
use afterimage_lab::LabError;
use serde::Serialize;

use super::number;
use crate::raw::{compute_pipeline, dispatch, draw, draw_pipeline, group, groups, module, target};

/// The times of the chains in milliseconds, and the differences of their images from that of the pipeline.
#[derive(Debug, Serialize)]
pub(crate) struct BaselineReport {
    /// The usual hand-written chain: light from half the pixels, four loads each, and no dither.
    #[serde(flatten)]
    pub(crate) light: BaselineTimes,
    /// All the work of the pipeline: filters, weights, sanitizing and dither.
    pub(crate) same: BaselineTimes,
}

/// One chain in its variants.
#[derive(Debug, Serialize)]
pub(crate) struct BaselineTimes {
    /// Draws, half-float levels.
    pub(crate) fragment_ms: f64,
    /// Dispatches in one compute pass, half-float levels.
    pub(crate) compute_ms: f64,
    /// Dispatches with levels of 11, 11 and 10 bits; `None` if the device cannot store them.
    pub(crate) compute_rg11b10_ms: Option<f64>,
    /// The largest difference of a channel, whose range is 1.
    pub(crate) max_difference: f32,
    /// The mean difference of a channel.
    pub(crate) mean_difference: f32,
}

/// The parameters of the pipeline that the chain uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chain {
    levels: usize,
    threshold: f32,
    knee: f32,
    radius: f32,
    strength: f32,
    /// True if the bloom is added through a tent filter instead of bilinearly.
    tent: bool,
    gain: f32,
}

impl Chain {
    /// The parameters, if the graph is the chain that is implemented here.
    pub(crate) fn of(graph: &Graph) -> Option<Self> {
        let wanted = ["Exposure", "Extract", "Downsample", "Upsample", "Composite", "ToneMap", "Encode"];
        // A final dither is optional.
        let nodes = match graph.nodes.as_slice() {
            [nodes @ .., last] if last.kind().name() == "Dither" => nodes,
            nodes => nodes,
        };
        let kinds: Vec<&str> = nodes.iter().map(|node| node.kind().name()).collect();
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
            // The curve as published.
            (tone_map, "curve", "AcesNarkowicz"),
            (tone_map, "space", "Rec709"),
            (tone_map, "middle_gray", "Native"),
            (tone_map, "gamut", "Clip"),
            (encode, "transfer", "Srgb"),
        ];
        let differs = |(node, name, choice): &(&GraphNode, &str, &'static str)| {
            node.instance.value(name) != Some(&Value::Choice(choice))
        };
        if choices.iter().any(differs) || number(tone_map, "keep_hue") != Some(0.0) {
            return None;
        }
        Some(Self {
            levels: number(downsample, "levels")?.max(2.0) as usize,
            threshold: number(extract, "threshold")?,
            knee: number(extract, "knee")?,
            radius: number(upsample, "radius")?,
            strength: number(composite, "strength")?,
            tent: composite.instance.value("filter") == Some(&Value::Choice("Tent")),
            gain: number(exposure, "stops")?.exp2(),
        })
    }

    /// The uniform of a pass whose result has `coarser` levels below it.
    fn uniform(&self, coarser: usize) -> [f32; 8] {
        let all = (coarser + 1) as f32;
        let (low, high) = (self.threshold - self.knee, self.threshold + self.knee.max(1e-4));
        [low, high, 1.0 / all, coarser as f32 / all, self.radius, self.strength, self.gain, 0.0]
    }
}

/// The chains for a scene: with less work and with the same work, each in all its variants.
pub(crate) fn chains(gpu: &Gpu, settings: &Chain, scene: &TextureView) -> [Vec<HandWritten>; 2] {
    let half = TextureFormat::Rgba16Float;
    let mut variants = vec![(Stage::Draw, half), (Stage::Dispatch, half)];
    if gpu.caps.storage.contains(&Format::Rg11b10Ufloat) {
        variants.push((Stage::Dispatch, TextureFormat::Rg11b10Ufloat));
    }
    [Amount::Less, Amount::Same].map(|amount| {
        let chain =
            |(stage, format): &(Stage, TextureFormat)| HandWritten::new(gpu, settings, scene, amount, *stage, *format);
        variants.iter().map(chain).collect()
    })
}

/// All chains, to be recorded.
pub(crate) fn recordings(chains: &[Vec<HandWritten>; 2]) -> Vec<TimedCommands<'_>> {
    chains.iter().flatten().map(HandWritten::recording).collect()
}

/// The times of the chains, and the differences of their last images from `picture`.
pub(crate) fn report(
    gpu: &Gpu,
    [less, same]: &[Vec<HandWritten>; 2],
    times: &[FrameTime],
    picture: &[[f32; 4]],
) -> Result<BaselineReport, LabError> {
    gpu.wait()?;
    let report = |chains: &[HandWritten], times: &[FrameTime]| -> Result<BaselineTimes, LabError> {
        let image = download(&gpu.device, &gpu.queue, chains[1].display.texture())?;
        let (max_difference, mean_difference) = difference(picture, &image.to_floats());
        Ok(BaselineTimes {
            fragment_ms: times[0].ms(),
            compute_ms: times[1].ms(),
            compute_rg11b10_ms: times.get(2).map(FrameTime::ms),
            max_difference,
            mean_difference,
        })
    };
    let (first, second) = times.split_at(less.len());
    Ok(BaselineReport { light: report(less, first)?, same: report(same, second)? })
}

/// The largest and the mean difference of a channel.
fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> (f32, f32) {
    let differences = a.iter().zip(b).flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs()));
    let (largest, sum) = differences.fold((0.0_f32, 0.0), |(largest, sum), d| (largest.max(d), sum + f64::from(d)));
    (largest, (sum / (3 * a.len().max(1)) as f64) as f32)
}

/// The amount of work compared with the pipeline.
#[derive(Clone, Copy, PartialEq)]
enum Amount {
    Less,
    Same,
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Draw,
    Dispatch,
}

/// A chain with all its GPU objects.
pub(crate) struct HandWritten {
    dispatches: Vec<(wgpu::ComputePipeline, wgpu::BindGroup, [u32; 2])>,
    draws: Vec<(wgpu::RenderPipeline, wgpu::BindGroup, TextureView)>,
    display: TextureView,
}

/// One pass: its function, the number of levels below its result, its inputs and its result.
struct Step<'a> {
    name: &'static str,
    coarser: usize,
    first: &'a TextureView,
    second: Option<&'a TextureView>,
    to: &'a TextureView,
}

impl HandWritten {
    fn new(gpu: &Gpu, chain: &Chain, scene: &TextureView, amount: Amount, stage: Stage, format: TextureFormat) -> Self {
        let usage = match stage {
            Stage::Draw => TextureUsages::RENDER_ATTACHMENT,
            Stage::Dispatch => TextureUsages::STORAGE_BINDING,
        } | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC;
        let full = Size::new(scene.texture().width(), scene.texture().height());
        let halved = |size: &Size| Some(Size::new(size.width / 2, size.height / 2));
        let sizes: Vec<Size> = std::iter::successors(halved(&full), halved).take(chain.levels).collect();
        let level = |size: &Size| target(gpu, *size, format, usage);
        let down: Vec<TextureView> = sizes.iter().map(level).collect();
        let up: Vec<TextureView> = sizes[..sizes.len() - 1].iter().map(level).collect();
        let display = target(gpu, full, TextureFormat::Rgba8Unorm, usage);
        let mut this = Self { dispatches: Vec::new(), draws: Vec::new(), display: display.clone() };
        let storage = if format == TextureFormat::Rg11b10Ufloat { "rg11b10ufloat" } else { "rgba16float" };
        let glow = if chain.tent { "tent(uv, 1.0)" } else { "near(uv)" };
        let same = (amount == Amount::Same).to_string();
        let source = include_str!("lynx.wgsl").replace("LEVEL", storage).replace("GLOW", glow);
        let module = module(gpu, &source.replace("SAME_WORK", &same));
        let picked = (amount == Amount::Same).then(|| level(&full));
        for step in steps(scene, picked.as_ref(), &down, &up, &display) {
            this.add(gpu, chain, &module, stage, &step);
        }
        this
    }

    fn add(&mut self, gpu: &Gpu, chain: &Chain, module: &wgpu::ShaderModule, stage: Stage, step: &Step<'_>) {
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
        if step.name != "halve" {
            bind(1, uniform.as_entire_binding());
        }
        bind(2, BindingResource::TextureView(step.first));
        if let Some(second) = step.second {
            bind(3, BindingResource::TextureView(second));
        }
        let texture = step.to.texture();
        if stage == Stage::Draw {
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

    fn recording(&self) -> TimedCommands<'_> {
        Box::new(|encoder| {
            self.record(encoder);
            Ok(())
        })
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        for (pipeline, group, to) in &self.draws {
            draw(encoder, pipeline, group, to);
        }
        if self.dispatches.is_empty() {
            return;
        }
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (pipeline, group, groups) in &self.dispatches {
            dispatch(&mut pass, pipeline, group, *groups);
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
            Step { name: "halve", coarser: 0, first: picked, second: None, to: &down[0] },
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

//! Frames on the GPU: many small ones at once.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use afterimage_gpu::{Executor, Frame, Gpu, Texels, texture_format, upload};
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::image::{ColorState, Format, ImageDesc, Size};
use afterimage_graph::node::{BufferLife, Origin, OutputState};
use afterimage_graph::value::Value;
use afterimage_plan::{Caps, GivenImage, Options, Plan, PlanRequest, plan};
use wgpu::{Buffer, CommandEncoder, TextureView};

use super::images::{Extreme, guarded};
use super::subject::Subject;
use afterimage_media::catch_panic;

/// A frame to render.
#[derive(Clone, Copy)]
pub(crate) struct Shot {
    pub(crate) image: Extreme,
    /// Whether the guard's work is done before the image is given.
    pub(crate) guarded: bool,
    pub(crate) dt: f32,
    pub(crate) reset: bool,
}

impl Shot {
    /// A first frame.
    pub(crate) fn still(image: Extreme) -> Self {
        Self { image, guarded: false, dt: 0.0, reset: true }
    }
}

/// An output of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shown {
    pub(crate) name: String,
    pub(crate) state: ColorState,
    /// The largest colour that its maker promises; `None` if it promises no more than a finite half float.
    pub(crate) limit: Option<f64>,
    pub(crate) size: Size,
    pub(crate) pixels: Vec<[f32; 4]>,
}

/// The device and the images on it.
pub(crate) struct Lab<'g> {
    pub(crate) gpu: &'g Gpu,
    images: BTreeMap<Key, TextureView>,
    refusals: Arc<Mutex<Vec<String>>>,
    /// Whether images are promised to be finite, whatever is in them: then nothing guards them.
    unguarded: bool,
    /// What plans are made with before a way of making them changes it.
    options: Options,
}

/// A view that differs from others of its image in size, guard and format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    image: (&'static str, [u32; 4]),
    size: Size,
    guarded: bool,
    signed: bool,
    half: bool,
}

/// One way of running plans.
pub(crate) struct Bench {
    executor: Executor,
    caps: Caps,
    options: Options,
    /// Whether images are given in half floats.
    half: bool,
    unguarded: bool,
}

/// What a graph makes of some frames.
pub(crate) struct Ran {
    /// For each frame its outputs.
    pub(crate) frames: Vec<Vec<Shown>>,
    /// Nodes that the plan leaves out because they change nothing.
    pub(crate) skipped: Vec<String>,
}

impl<'g> Lab<'g> {
    pub(crate) fn new(gpu: &'g Gpu, unguarded: bool, options: Options) -> Self {
        let refusals = Arc::new(Mutex::new(Vec::new()));
        let told = refusals.clone();
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            told.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(error.to_string());
        }));
        Self { gpu, images: BTreeMap::new(), refusals, unguarded, options }
    }

    /// A way of running: with changed capabilities and options.
    pub(crate) fn bench(&self, change: impl FnOnce(&mut Caps, &mut Options), half: bool) -> Bench {
        let (mut caps, mut options) = (self.gpu.caps.clone(), self.options);
        change(&mut caps, &mut options);
        let executor = Executor::with_caps(&self.gpu.device, &self.gpu.queue, caps.clone());
        Bench { executor, caps, options, half, unguarded: self.unguarded }
    }

    fn view(&mut self, shot: Shot, size: Size, signed: bool, half: bool) -> TextureView {
        let signed = signed && shot.guarded;
        let key = Key { image: shot.image.key(), size, guarded: shot.guarded, signed, half };
        let gpu = self.gpu;
        let made = self.images.entry(key).or_insert_with(|| {
            let mut pixels = shot.image.pixels(size);
            if shot.guarded {
                pixels.iter_mut().for_each(|pixel| *pixel = guarded(*pixel, signed));
            }
            let make = if half { Texels::from_floats_as_half } else { Texels::from_floats };
            let texels = make(size.width, size.height, &pixels);
            upload(&gpu.device, &gpu.queue, &texels).create_view(&Default::default())
        });
        made.clone()
    }

    fn refused(&self) -> Option<String> {
        let mut told = self.refusals.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let first = told.first().cloned();
        told.clear();
        first
    }

    /// Renders frames, in one submission if `together`: then all have the time of the last. An error is a sentence for the report.
    pub(crate) fn run(
        &mut self,
        bench: &mut Bench,
        (subject, graph): (&Subject, &Graph),
        size: Size,
        shots: &[Shot],
        together: bool,
    ) -> Result<Ran, String> {
        let ran = catch_panic(|| self.run_unguarded(bench, subject, graph, size, shots, together));
        let ran = ran.unwrap_or_else(|panic| Err(format!("panics: {panic}")));
        let ran = self.refused().map_or(ran, |refused| Err(format!("the device refuses it: {}", one_line(&refused))));
        if ran.is_err() {
            // What went wrong here must not colour the cases that follow.
            bench.executor = Executor::with_caps(&self.gpu.device, &self.gpu.queue, bench.caps.clone());
        }
        ran
    }

    fn run_unguarded(
        &mut self,
        bench: &mut Bench,
        subject: &Subject,
        graph: &Graph,
        size: Size,
        shots: &[Shot],
        together: bool,
    ) -> Result<Ran, String> {
        let plan = Arc::new(bench.plan(subject, graph, size)?);
        bench.executor.load(plan.clone()).map_err(|error| one_line(&error.to_string()))?;
        let outputs: Vec<ImageDesc> =
            plan.outputs.iter().map(|output| plan.recording.image(output.image).desc).collect();
        let frame_bytes: u64 = outputs.iter().map(pitched).sum();
        let buffer = self.readback(frame_bytes * shots.len() as u64);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (index, shot) in shots.iter().enumerate() {
            let views: Vec<(&str, TextureView)> = plan
                .inputs
                .iter()
                .map(|(name, image)| {
                    (name.as_str(), self.view(*shot, size, plan.recording.image(*image).signed, bench.half))
                })
                .collect();
            let inputs: Vec<(&str, &TextureView)> = views.iter().map(|(name, view)| (*name, view)).collect();
            let frame = Frame { inputs: &inputs, outputs: &[], time: 0.0, dt: shot.dt, reset: shot.reset };
            if shot.reset {
                // What begins anew has the grain of a first frame, so that it can be compared with another beginning.
                bench.executor.count_from(0);
            }
            bench.executor.encode(&mut encoder, &frame).map_err(|error| one_line(&error.to_string()))?;
            copy_outputs(&bench.executor, &plan, &mut encoder, &buffer, frame_bytes * index as u64);
            if !together {
                let full = std::mem::replace(&mut encoder, self.gpu.device.create_command_encoder(&Default::default()));
                self.gpu.queue.submit([full.finish()]);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        let bytes = self.read(&buffer)?;
        let frames = bytes.chunks_exact(frame_bytes as usize).map(|bytes| shown(&plan, graph, bytes)).collect();
        let skipped = plan.skipped.iter().map(|left| left.node.clone()).collect();
        Ok(Ran { frames, skipped })
    }

    fn readback(&self, size: u64) -> Buffer {
        self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stress"),
            size: size.max(4),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    fn read(&self, buffer: &Buffer) -> Result<Vec<u8>, String> {
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
        let mapped = buffer.slice(..).get_mapped_range().map_err(|error| error.to_string())?;
        Ok(mapped.to_vec())
    }
}

impl Bench {
    /// The longest side that an image can have.
    pub(crate) fn longest_side(&self) -> u32 {
        self.caps.max_side
    }

    /// Texels of all images that a frame of this size needs.
    pub(crate) fn texels(&self, subject: &Subject, graph: &Graph, size: Size) -> u64 {
        let all = |plan: Plan| plan.recording.images.iter().map(|image| image.desc.size.texels()).sum();
        self.plan(subject, graph, size).map_or(0, all)
    }

    /// Whether anything outlives a frame.
    pub(crate) fn remembers(&self, subject: &Subject, graph: &Graph, size: Size) -> bool {
        self.plan(subject, graph, size).is_ok_and(|plan| remembers(&plan))
    }

    fn plan(&self, subject: &Subject, graph: &Graph, size: Size) -> Result<Plan, String> {
        let format = if self.half { Format::Rgba16Float } else { Format::Rgba32Float };
        let given = GivenImage { desc: ImageDesc::new(size).format(format), finite: self.unguarded };
        let wanted = graph.inputs.iter().filter(|input| !(input.optional && subject.bare));
        let inputs = wanted.map(|input| (input.name.clone(), given)).collect();
        let executor = &self.executor;
        let requirement = |desc: &ImageDesc| executor.requirement(desc);
        let setting = PlanRequest {
            size,
            inputs,
            facts: subject.facts.clone(),
            caps: self.caps.clone(),
            options: self.options,
            requirement: &requirement,
        };
        plan(graph, &setting).map_err(|error| error.to_string())
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Bytes of a row in a copy to a buffer.
fn pitch(desc: &ImageDesc) -> u64 {
    let row = u64::from(desc.size.width) * desc.format.bytes();
    row.next_multiple_of(u64::from(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT))
}

fn pitched(desc: &ImageDesc) -> u64 {
    pitch(desc) * u64::from(desc.size.height)
}

fn copy_outputs(executor: &Executor, plan: &Plan, encoder: &mut CommandEncoder, buffer: &Buffer, mut offset: u64) {
    for output in &plan.outputs {
        let desc = plan.recording.image(output.image).desc;
        let texture = executor.output(&output.name).expect("the executor keeps a texture for each output");
        debug_assert_eq!(texture.format(), texture_format(desc.format));
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset,
                    bytes_per_row: Some(pitch(&desc) as u32),
                    rows_per_image: Some(desc.size.height),
                },
            },
            texture.size(),
        );
        offset += pitched(&desc);
    }
}

fn shown(plan: &Plan, graph: &Graph, mut bytes: &[u8]) -> Vec<Shown> {
    let mut all = Vec::new();
    for (output, wanted) in plan.outputs.iter().zip(&graph.outputs) {
        let desc = plan.recording.image(output.image).desc;
        let (mine, rest) = bytes.split_at(pitched(&desc) as usize);
        bytes = rest;
        let row = (u64::from(desc.size.width) * desc.format.bytes()) as usize;
        let packed = mine.chunks_exact(pitch(&desc) as usize).flat_map(|line| &line[..row]).copied().collect();
        let pixels = Texels { desc, bytes: packed }.to_floats();
        let limit = limit(plan, graph, wanted.source);
        all.push(Shown { name: output.name.clone(), state: output.state, limit, size: desc.size, pixels });
    }
    all
}

/// The largest colour of an image after the tone curve, if the node that makes it always gives that state: its `peak`, or else 1.
fn limit(plan: &Plan, graph: &Graph, source: Source) -> Option<f64> {
    let Source::Node { node, output, .. } = source else { return None };
    let node = &graph.nodes[node];
    let gives = &node.kind.outputs()[output].state;
    let is_limited = matches!(gives, OutputState::Always(ColorState::DisplayLinear | ColorState::Encoded));
    let runs = !plan.skipped.iter().any(|left| left.node == node.name);
    let peak = node.kind.param("peak").map(|(index, _)| &node.values[index]);
    match peak {
        _ if !(is_limited && runs) => None,
        Some(Value::Float(peak)) => Some(*peak),
        _ => Some(1.0),
    }
}

fn remembers(plan: &Plan) -> bool {
    let images = plan.recording.images.iter().any(|image| matches!(image.origin, Origin::Previous { .. }));
    images || plan.recording.buffers.iter().any(|buffer| buffer.life == BufferLife::Persistent)
}

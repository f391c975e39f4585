//! The pictures that a pipeline is measured on: images, sequences, a walk through the built-in scene.

use std::path::Path;
use std::sync::Arc;

use afterimage_gpu::{Executor, Frame, Gpu, download, upload};
use afterimage_graph::check::{Facts, Graph, GraphInput};
use afterimage_graph::image::{ColorState, ImageDesc, Size};
use afterimage_graph::node::Registry;
use afterimage_graph::value::Value;
use afterimage_plan::{Requirement, plan};

use super::args::Material;
use crate::args::PipelineOptions;
use crate::failure::Failure;
use crate::pipeline::{check_text, setting, split};
use crate::session::{Clock, upload_picture};
use afterimage_media::sequence;

/// An image for one of the pipeline's inputs, on the GPU.
pub(crate) struct Given {
    pub(crate) input: String,
    pub(crate) texture: wgpu::Texture,
    pub(crate) desc: ImageDesc,
}

/// Frames that belong together.
pub(crate) struct Clip {
    pub(crate) name: String,
    pub(crate) size: Size,
    /// The images of all frames.
    images: Vec<Vec<Given>>,
    clocks: Vec<Clock>,
}

impl Clip {
    /// How many frames there are; at least one.
    pub(crate) fn len(&self) -> usize {
        self.clocks.len()
    }

    /// The images of a frame; a still stands for all frames.
    pub(crate) fn images(&self, frame: usize) -> &[Given] {
        &self.images[frame.min(self.images.len() - 1)]
    }

    /// The clip with its image standing for as many frames as the command line says.
    pub(crate) fn standing(mut self, material: &Material) -> Self {
        self.clocks = clocks(material.walk as usize, material.fps);
        self
    }

    /// The time of a frame.
    pub(crate) fn clock(&self, frame: usize) -> Clock {
        self.clocks[frame]
    }
}

/// A clip that is not loaded yet.
pub(crate) enum ClipSource {
    /// Files for inputs.
    Files { name: String, inputs: Vec<(String, sequence::Input)> },
    /// A walk through the built-in scene.
    Scene,
}

/// The clips that the command line asks for.
pub(crate) fn sources(material: &Material, graph: &Graph) -> Result<Vec<ClipSource>, Failure> {
    let mut others = Vec::new();
    for input in &material.inputs {
        let (name, file) = split(input, "--input")?;
        if !graph.inputs.iter().any(|known| known.name == name) {
            return Err(no_such_input(&name, &graph.inputs));
        }
        others.push((name, sequence::Input::find(&file, None)?));
    }
    let mut clips = Vec::new();
    for image in &material.images {
        clips.push(file_clip(material, graph, image, &others)?);
    }
    if material.scene || clips.is_empty() {
        clips.push(ClipSource::Scene);
    }
    Ok(clips)
}

fn no_such_input(name: &str, inputs: &[GraphInput]) -> Failure {
    let known: Vec<String> = inputs.iter().map(|input| format!("`{}`", input.name)).collect();
    let hint = if known.is_empty() { "it has none".into() } else { format!("it has {}", known.join(", ")) };
    Failure::user(format!("the pipeline has no input `{name}`")).hint(hint)
}

fn file_clip(
    material: &Material,
    graph: &Graph,
    image: &str,
    others: &[(String, sequence::Input)],
) -> Result<ClipSource, Failure> {
    let is_free = |input: &&GraphInput| others.iter().all(|(name, _)| *name != input.name);
    let Some(first) = graph.inputs.iter().find(is_free) else {
        return Err(Failure::user(format!("the pipeline has no input for `{image}`")).hint("leave the images out"));
    };
    let found = sequence::Input::find(image, None);
    let found = if material.frames.is_some() && !matches!(found, Ok(sequence::Input::Single(_))) {
        sequence::Input::find(image, material.frames.as_deref())
    } else {
        found
    };
    let mut inputs = vec![(first.name.clone(), found?)];
    inputs.extend(others.iter().cloned());
    let lacks = |input: &&GraphInput| !input.optional && inputs.iter().all(|(name, _)| *name != input.name);
    if let Some(input) = graph.inputs.iter().find(lacks) {
        return Err(Failure::user(format!("the pipeline needs an image for its input `{}`", input.name))
            .hint(format!("name it with `--input {}=FILE`", input.name)));
    }
    Ok(ClipSource::Files { name: short_name(image), inputs })
}

/// The file's name without its folder and ending.
fn short_name(image: &str) -> String {
    let file = Path::new(image).file_name().map_or(image.into(), |name| name.to_string_lossy());
    let stem = file.rsplit_once('.').map_or(file.as_ref(), |(stem, _)| stem);
    stem.trim_end_matches(['#', '.', '_', '-']).to_owned()
}

impl ClipSource {
    /// A name for progress and messages.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Files { name, .. } => name,
            Self::Scene => "built-in scene",
        }
    }

    /// Brings the images to the GPU.
    pub(crate) fn load(
        &self,
        gpu: &Gpu,
        registry: &Registry,
        graph: &Graph,
        material: &Material,
    ) -> Result<Clip, Failure> {
        let (name, images) = match self {
            Self::Files { name, inputs } => (name.clone(), file_images(gpu, inputs)?),
            Self::Scene => (self.name().to_owned(), scene_images(gpu, registry, graph, material)?),
        };
        let (width, height) = material.size;
        let size = images[0].first().map_or(Size::new(width, height), |given| given.desc.size);
        let clocks = clocks(images.len(), material.fps);
        Ok(Clip { name, size, images, clocks })
    }
}

fn clocks(frames: usize, fps: f32) -> Vec<Clock> {
    let clock = |frame: usize| Clock {
        time: frame as f32 / fps,
        dt: if frame == 0 { 0.0 } else { 1.0 / fps },
        reset: frame == 0,
    };
    (0..frames).map(clock).collect()
}

fn file_images(gpu: &Gpu, inputs: &[(String, sequence::Input)]) -> Result<Vec<Vec<Given>>, Failure> {
    let frames = inputs.iter().map(|(_, input)| input.sources().len()).max().unwrap_or(1);
    (0..frames).map(|frame| inputs.iter().map(|(name, input)| file_image(gpu, name, input, frame)).collect()).collect()
}

fn file_image(gpu: &Gpu, name: &str, input: &sequence::Input, frame: usize) -> Result<Given, Failure> {
    let sources = input.sources();
    let source = match sources.as_slice() {
        [(_, still)] => still,
        frames => {
            &frames
                .get(frame)
                .ok_or_else(|| {
                    Failure::user(format!("input `{name}` has only {} frames", frames.len()))
                        .hint("shorten the others with `--frames`")
                })?
                .1
        }
    };
    let (texture, desc) = upload_picture(gpu, &afterimage_media::read(source)?)?;
    Ok(Given { input: name.to_owned(), texture, desc })
}

/// How much of the walk through the scene a second takes.
const PACE: f64 = 0.2;

fn scene_images(
    gpu: &Gpu,
    registry: &Registry,
    graph: &Graph,
    material: &Material,
) -> Result<Vec<Vec<Given>>, Failure> {
    let ports = scene_ports(&graph.inputs)?;
    if ports.is_empty() {
        return Ok(vec![Vec::new()]);
    }
    let mut scene = scene_graph(registry, &ports)?;
    let mut executor = Executor::with_caps(&gpu.device, &gpu.queue, gpu.caps.clone());
    let (width, height) = material.size;
    let mut frames = Vec::new();
    for frame in 0..material.walk {
        let seconds = f64::from(frame) / f64::from(material.fps);
        set(&mut scene, "time", seconds);
        set(&mut scene, "walk", (seconds * PACE).min(1.0));
        let setting = setting(
            &scene,
            Size::new(width, height),
            Facts::default(),
            Default::default(),
            gpu.caps.clone(),
            &Requirement::typical,
        );
        executor.load(Arc::new(plan(&scene, &setting)?))?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        executor.encode(&mut encoder, &Frame { reset: true, ..Frame::default() })?;
        gpu.queue.submit([encoder.finish()]);
        frames.push(ports.iter().map(|(input, port)| kept(gpu, &executor, input, port)).collect::<Result<_, _>>()?);
    }
    Ok(frames)
}

/// A copy of an output that outlives the next frame.
fn kept(gpu: &Gpu, executor: &Executor, input: &str, port: &str) -> Result<Given, Failure> {
    let texture = executor.output(port).expect("the scene has an output for each port");
    let texels = download(&gpu.device, &gpu.queue, texture)?;
    Ok(Given { input: input.to_owned(), texture: upload(&gpu.device, &gpu.queue, &texels), desc: texels.desc })
}

fn set(scene: &mut Graph, name: &str, value: f64) {
    let node = &mut scene.nodes[0];
    let (at, _) = node.kind.param(name).expect("the scene has a time and a walk");
    node.values[at] = Value::Float(value);
}

fn scene_graph(registry: &Registry, ports: &[(String, &str)]) -> Result<Graph, Failure> {
    let mut outputs: Vec<String> = ports.iter().map(|(_, port)| format!("\"{port}\": \"scene.{port}\"")).collect();
    outputs.dedup();
    let text =
        format!("Pipeline(inputs: {{}}, nodes: {{ \"scene\": DemoScene() }}, outputs: {{ {} }})", outputs.join(", "));
    let options = PipelineOptions { sets: Vec::new(), facts: Vec::new(), tier: None, nodes: Vec::new() };
    Ok(check_text("the built-in scene", &text, registry, &options)?.0)
}

/// Which output of the scene goes to each input of the pipeline: light to the first image of light, the others by name.
fn scene_ports(inputs: &[GraphInput]) -> Result<Vec<(String, &'static str)>, Failure> {
    let mut ports = Vec::new();
    for input in inputs {
        let named = ["depth", "normal", "albedo"].into_iter().find(|port| input.name.contains(port));
        let is_light = matches!(input.state, ColorState::Scene | ColorState::Exposed | ColorState::DisplayLinear);
        match named.or((is_light && ports.iter().all(|(_, port)| *port != "result")).then_some("result")) {
            Some(port) => ports.push((input.name.clone(), port)),
            None if input.optional => {}
            None => {
                let message = format!("the built-in scene has nothing for the input `{}`", input.name);
                return Err(Failure::user(message).hint("give images, and this one by `--input`"));
            }
        }
    }
    Ok(ports)
}

//! The images that the inputs of a pipeline get: the built-in scene, a file, or the frames of a sequence.

use std::collections::BTreeSet;

use afterimage::Post;
use afterimage::host::Parameter;
use afterimage_gpu::wgpu::{self, TextureView};
use afterimage_gpu::{Frame, FrameKind, Gpu, texture_format};
use afterimage_graph::check::{CheckOptions, Graph, GraphInput, check};
use afterimage_graph::document::parse;
use afterimage_graph::image::{ColorState, Format, Size};
use afterimage_graph::node::{CAMERA, Registry};
use afterimage_media::Repairs;
use afterimage_nodes::DemoScene;

use super::{Files, FrameImages, InputFile, Moment};
use crate::Problem;
use crate::render::device::image;

/// The source of the images of a pipeline's inputs.
pub enum Images {
    Scene(Box<Scene>),
    /// Images from files, one for each named input.
    Files(Box<Files>),
}

impl Images {
    /// The size of the images.
    pub fn size(&self) -> Size {
        match self {
            Self::Scene(scene) => scene.size,
            Self::Files(files) => files.size(),
        }
    }

    /// The images at a moment. Records what makes them.
    ///
    /// # Errors
    /// An input gets no image, or the device fails.
    pub fn at(
        &mut self,
        moment: Moment,
        inputs: &[GraphInput],
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<FrameImages, Problem> {
        match self {
            Self::Scene(scene) => scene.at(moment, inputs, encoder),
            Self::Files(files) => files.at(moment.time, inputs),
        }
    }

    /// The images of the last time again, for another pipeline.
    ///
    /// # Errors
    /// An input gets no image.
    pub fn again(&mut self, inputs: &[GraphInput]) -> Result<FrameImages, Problem> {
        match self {
            Self::Scene(scene) => scene.again(inputs),
            Self::Files(files) => files.again(inputs),
        }
    }

    /// Makes sure that [`at`](Self::at) renders the images of these inputs, too, for a second pipeline.
    ///
    /// # Errors
    /// The device fails.
    pub fn require(&mut self, inputs: &[GraphInput]) -> Result<(), Problem> {
        match self {
            Self::Scene(scene) => scene.require(inputs),
            Self::Files(_) => Ok(()),
        }
    }

    /// Makes the images again on another device.
    ///
    /// # Errors
    /// A file cannot be read any more, or the device cannot hold the images.
    pub fn rebuild(&mut self, gpu: &Gpu) -> Result<(), Problem> {
        match self {
            Self::Scene(scene) => **scene = Scene::new(gpu, scene.size)?,
            Self::Files(files) => files.rebuild(gpu),
        }
        Ok(())
    }

    /// Reads files again that have changed. Returns whether one has.
    ///
    /// # Errors
    /// It cannot be read. The image before stays.
    pub fn follow(&mut self) -> Result<bool, Problem> {
        match self {
            Self::Scene(_) => Ok(false),
            Self::Files(files) => files.follow(),
        }
    }

    /// Gives an input a file, or takes it away; `None` is the first image that a pipeline needs. Without any file the
    /// built-in scene is shown. `inputs` are those of the pipeline.
    ///
    /// # Errors
    /// The file cannot be read, or the device cannot hold it. Nothing has changed then.
    pub(super) fn set(
        &mut self,
        gpu: &Gpu,
        input: Option<&str>,
        file: Option<InputFile>,
        inputs: &[GraphInput],
    ) -> Result<(), Problem> {
        match (&mut *self, file) {
            (Self::Files(files), Some(file)) => files.set(input, file, inputs)?,
            (Self::Files(files), None) => {
                files.remove(input, inputs);
                if files.is_empty() {
                    *self = Self::Scene(Box::new(Scene::new(gpu, files.size())?));
                }
            }
            (Self::Scene(scene), Some(file)) => {
                let mut files = Files::new(gpu, scene.size);
                files.set(input, file, inputs)?;
                *self = Self::Files(Box::new(files));
            }
            (Self::Scene(_), None) => {}
        }
        Ok(())
    }

    /// What an input gets, for people; `None` for nothing.
    pub fn name(&self, input: &GraphInput, inputs: &[GraphInput]) -> Option<&str> {
        match self {
            Self::Scene(_) if input.block.is_some() => is_camera(input).then_some(SCENE_NAME),
            Self::Scene(_) => output_for(input, false).map(|_| SCENE_NAME),
            Self::Files(files) => files.file(input, inputs).map(|file| &*file.name),
        }
    }

    /// The layers that can be chosen in the file of an input.
    pub fn layers(&self, input: &GraphInput, inputs: &[GraphInput]) -> &[String] {
        match self {
            Self::Scene(_) => &[],
            Self::Files(files) => files.file(input, inputs).map_or(&[], |file| &file.layers),
        }
    }

    /// The name and the size of what is shown, for people, and the number of the frame of a sequence.
    pub fn title(&self) -> String {
        let (name, size) = match self {
            Self::Scene(scene) => (SCENE_NAME, scene.size),
            Self::Files(files) => (files.first_name().unwrap_or("no file"), files.size()),
        };
        let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let frame = self.frame_number().map_or(String::new(), |number| format!(" frame {number}"));
        format!("{name} {}x{}{frame}", size.width, size.height)
    }

    /// The number of the shown frame of a sequence, as its file states it.
    pub fn frame_number(&self) -> Option<u32> {
        match self {
            Self::Scene(_) => None,
            Self::Files(files) => files.number(),
        }
    }

    /// The pixels that no image can show, for each input with a file.
    pub fn repairs(&self) -> Vec<(&str, Repairs)> {
        match self {
            Self::Scene(_) => Vec::new(),
            Self::Files(files) => files.repairs().filter(|(_, repairs)| !repairs.is_none()).collect(),
        }
    }

    /// The number of frames and how many there are in a second, for a sequence.
    pub fn length(&self) -> Option<(usize, f64)> {
        match self {
            Self::Scene(_) => None,
            Self::Files(files) => files.length(),
        }
    }
}

const SCENE: &str = r#"Pipeline(
    inputs: {},
    nodes: { "scene": DemoScene() },
    outputs: {
        "result": "scene", "depth": "scene.depth", "projected": "scene.projected", "normal": "scene.normal",
        "albedo": "scene.albedo", "motion": "scene.motion",
    },
)"#;
/// The name of the scene for people.
pub(crate) const SCENE_NAME: &str = "built-in scene";
/// The outputs of the scene that are data.
const DATA: [&str; 4] = ["depth", "normal", "albedo", "motion"];
/// The output that a pipeline with a camera gets for its depth.
const PROJECTED: &str = "projected";
/// The part of the camera's way that it moves in a second.
const SPEED: f64 = 0.05;
/// Period of the scene in seconds, whole turns of all that moves in it: its parameter is a float.
const DEMO_PERIOD: f64 = 5040.0;

/// The built-in scene, at any size.
pub struct Scene {
    post: Post,
    time: Parameter<f32>,
    walk: Parameter<f32>,
    step: Parameter<f32>,
    dt: Parameter<f32>,
    /// The scene with all its outputs.
    whole: Graph,
    /// The outputs that are rendered: those that a pipeline has needed so far.
    required: BTreeSet<&'static str>,
    /// An output is required that was not rendered yet.
    is_stale: bool,
    /// Time and camera of the last frame.
    seen: DemoScene,
    size: Size,
    targets: Vec<(&'static str, TextureView)>,
}

impl Scene {
    /// The scene on a device.
    ///
    /// # Errors
    /// The device refuses it.
    pub fn new(gpu: &Gpu, size: Size) -> Result<Self, Problem> {
        let registry = Registry::new(&[afterimage_nodes::ALL]).expect("built-in kinds have different names");
        let document = parse("scene.ron", SCENE).map_err(Problem::Pipeline)?;
        let (graph, _) = check(&document, &registry, &CheckOptions::default()).map_err(Problem::Pipeline)?;
        let mut post = Post::with_executor(gpu.executor(), graph.clone());
        let (time, walk) = (post.parameter("scene.time")?, post.parameter("scene.walk")?);
        let (step, dt) = (post.parameter("scene.step")?, post.parameter("scene.dt")?);
        let target = |name| {
            let format = if DEPTHS.contains(&name) { Format::R32Float } else { Format::Rgba16Float };
            (name, target(&gpu.device, name, size, format))
        };
        let targets = ["result", PROJECTED].into_iter().chain(DATA).map(target).collect();
        let (whole, required, seen) = (graph, BTreeSet::new(), DemoScene::default());
        Ok(Self { post, time, walk, step, dt, whole, required, is_stale: true, seen, size, targets })
    }

    fn at(
        &mut self,
        moment: Moment,
        inputs: &[GraphInput],
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<FrameImages, Problem> {
        self.require(inputs)?;
        if moment.kind == FrameKind::Redraw && !self.is_stale {
            return self.again(inputs);
        }
        let Moment { time, dt, .. } = moment;
        let (here, before) = (walked(time), walked((time - dt).max(0.0)));
        let step = (here - before) as f32;
        self.seen = DemoScene {
            time: (time % DEMO_PERIOD) as f32,
            walk: here as f32,
            step,
            dt: dt as f32,
            ..DemoScene::default()
        };
        self.post.set(self.time, self.seen.time)?;
        self.post.set(self.walk, self.seen.walk)?;
        self.post.set(self.step, self.seen.step)?;
        self.post.set(self.dt, self.seen.dt)?;
        let required = self.targets.iter().filter(|(name, _)| self.required.contains(name));
        let outputs: Vec<(&str, &TextureView)> = required.map(|(name, view)| (*name, view)).collect();
        if !outputs.is_empty() {
            self.post.encode(encoder, &Frame { outputs: &outputs, time, ..Frame::default() })?;
        }
        self.is_stale = false;
        self.again(inputs)
    }

    /// Renders what these inputs need from now on, and what others needed before.
    fn require(&mut self, inputs: &[GraphInput]) -> Result<(), Problem> {
        let has_camera = inputs.iter().any(is_camera);
        let needed: BTreeSet<&str> = inputs.iter().filter_map(|input| output_for(input, has_camera)).collect();
        if needed.is_subset(&self.required) {
            return Ok(());
        }
        self.required.extend(needed);
        self.is_stale = true;
        let mut graph = self.whole.clone();
        graph.outputs.retain(|output| self.required.contains(output.name.as_str()));
        self.post.change(graph);
        Ok(self.post.finish_changes()?)
    }

    /// The images of the last rendered frame, for the inputs of a pipeline.
    fn again(&self, inputs: &[GraphInput]) -> Result<FrameImages, Problem> {
        let cameras = inputs.iter().filter(|input| is_camera(input));
        let camera = self.seen.camera(self.size).data().map_err(Problem::message)?;
        let blocks: Vec<_> = cameras.map(|input| (input.name.clone(), camera.clone())).collect();
        Ok(FrameImages { images: images_of(inputs, &self.targets, !blocks.is_empty())?, blocks })
    }
}

/// The outputs of the scene with one number.
const DEPTHS: [&str; 2] = ["depth", PROJECTED];

/// The position of the camera on its way to the window and back.
fn walked(time: f64) -> f64 {
    let part = (time * SPEED).rem_euclid(2.0);
    let there_and_back = if part > 1.0 { 2.0 - part } else { part };
    // Slow at both ends.
    there_and_back * there_and_back * (3.0 - 2.0 * there_and_back)
}

fn target(device: &wgpu::Device, label: &str, size: Size, format: Format) -> TextureView {
    let usages = wgpu::TextureUsages::TEXTURE_BINDING
        | wgpu::TextureUsages::STORAGE_BINDING
        | wgpu::TextureUsages::RENDER_ATTACHMENT
        | wgpu::TextureUsages::COPY_SRC;
    let texture = image(device, label, [size.width, size.height], texture_format(format), usages);
    texture.create_view(&Default::default())
}

/// True if an input gets the scene's camera: that of the eye, and not that of a light.
fn is_camera(input: &GraphInput) -> bool {
    input.block.is_some_and(|block| *block == CAMERA) && input.name == "camera"
}

/// The output of the scene for an input: data by name, the picture for inputs of linear color.
fn output_for(input: &GraphInput, has_camera: bool) -> Option<&'static str> {
    if input.block.is_some() || input.volume {
        return None;
    }
    let data = DATA.into_iter().find(|output| input.name.contains(output));
    let data = data.map(|output| if has_camera && output == "depth" { PROJECTED } else { output });
    let is_color = matches!(input.state, ColorState::Scene | ColorState::Exposed | ColorState::DisplayLinear);
    data.or((is_color && !input.optional).then_some("result"))
}

/// The output of the scene for each input: data by name, the picture for inputs of linear color. Optional inputs of
/// linear color get none, because they are masks and second pictures.
fn images_of(
    inputs: &[GraphInput],
    targets: &[(&'static str, TextureView)],
    has_camera: bool,
) -> Result<Vec<(String, TextureView)>, Problem> {
    let mut images = Vec::new();
    for input in inputs.iter().filter(|input| input.block.is_none()) {
        let output = output_for(input, has_camera);
        match output.and_then(|output| targets.iter().find(|(name, _)| *name == output)) {
            Some((_, view)) => images.push((input.name.clone(), view.clone())),
            None if input.optional => {}
            None => return Err(Problem::no_file(input)),
        }
    }
    Ok(images)
}

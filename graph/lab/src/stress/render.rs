//! Frames on the GPU: many small ones in one submission.

use std::collections::BTreeMap;
use std::sync::Arc;

use afterimage::offline::{FrameInputs, Session, faults};
use afterimage_gpu::{ErrorLog, FrameKind, FrameStep, Gpu, GpuError, InputImage, KernelFaults, Texels, input_image};
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::image::{ColorState, Format, ImageDesc, Signedness, Size};
use afterimage_graph::node::{BlockData, CAMERA, Camera, HostBlock, OutputState};
use afterimage_graph::value::Value;
use afterimage_media::catch_panic;
use afterimage_plan::{Caps, HostImageDesc, HostInputs, Options, Plan};

use super::images::{Extreme, sanitized, sanitized_samples};
use super::target::Target;
use crate::LabError;
use crate::measure::sequence_runner::has_histories;

/// A frame to render.
#[derive(Clone, Copy)]
pub(crate) struct StressFrame {
    pub(crate) image: Extreme,
    /// The image is sanitized before it is uploaded.
    pub(crate) sanitized: bool,
    pub(crate) dt: f32,
    pub(crate) reset: bool,
    /// Its time in seconds. Where it is not 0, its number is that of 60 frames a second.
    pub(crate) time: f64,
}

impl StressFrame {
    /// A first frame.
    pub(crate) fn still(image: Extreme) -> Self {
        Self { image, sanitized: false, dt: 0.0, reset: true, time: 0.0 }
    }
}

/// An output of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OutputPixels {
    pub(crate) name: String,
    pub(crate) state: ColorState,
    /// The largest color that its node promises; `None` for any finite half float.
    pub(crate) limit: Option<f64>,
    pub(crate) size: Size,
    pub(crate) pixels: Vec<[f32; 4]>,
}

/// The device and the images on it.
pub(crate) struct Renderer {
    gpu: Gpu,
    images: BTreeMap<ImageKey, InputImage>,
    errors: ErrorLog,
    /// Images are declared finite whatever is in them, so that plans do not sanitize them.
    unsanitized: bool,
    /// The planner's options, before a variant changes them.
    options: Options,
    /// The device's own filter weights texels coarsely. Until it is measured, it is assumed not to.
    pub(crate) filters_coarsely: bool,
}

/// The identity of an uploaded image.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct ImageKey {
    image: &'static str,
    desc: ImageDesc,
    signedness: Option<Signedness>,
}

/// A configuration that plans are made for.
pub(crate) struct Configuration {
    /// The device with the configured capabilities.
    gpu: Gpu,
    session: Option<Session>,
    options: Options,
    /// Images are half floats.
    half: bool,
    unsanitized: bool,
}

/// Frames to render.
#[derive(Clone, Copy)]
pub(crate) struct RenderRequest<'a> {
    pub(crate) target: &'a Target,
    /// The graph of the target, with the parameters of the case.
    pub(crate) graph: &'a Graph,
    pub(crate) size: Size,
    pub(crate) inputs: &'a [StressFrame],
    /// All frames are in one submission, with the time of the last.
    pub(crate) together: bool,
}

/// The outputs of some frames.
pub(crate) struct Rendered {
    /// The outputs of each frame.
    pub(crate) frames: Vec<Vec<OutputPixels>>,
    /// Nodes that the plan skips because they change nothing.
    pub(crate) skipped: Vec<String>,
}

impl Renderer {
    pub(crate) fn new(gpu: &Gpu, unsanitized: bool, options: Options) -> Self {
        let (gpu, errors) = (gpu.clone(), gpu.log_errors());
        Self { gpu, images: BTreeMap::new(), errors, unsanitized, options, filters_coarsely: false }
    }

    /// A configuration with changed capabilities and options.
    pub(crate) fn configure(&self, change: impl FnOnce(&mut Caps, &mut Options), half: bool) -> Configuration {
        let (mut gpu, mut options) = (self.gpu.clone(), self.options);
        change(&mut gpu.caps, &mut options);
        Configuration { gpu, session: None, options, half, unsanitized: self.unsanitized }
    }

    /// Renders frames. An error is a sentence for the report.
    pub(crate) fn run(
        &mut self,
        configuration: &mut Configuration,
        request: RenderRequest<'_>,
    ) -> Result<Rendered, String> {
        self.guarded(configuration, |renderer, configuration| renderer.render(configuration, request))
    }

    /// Adds to `found` what functions of kinds in folders do wrong in each of these frames. An error is a sentence for
    /// the report, and ends the search.
    pub(crate) fn kernel_faults(
        &mut self,
        configuration: &mut Configuration,
        request: RenderRequest<'_>,
        found: &mut Vec<KernelFaults>,
    ) -> Result<(), String> {
        let RenderRequest { target, graph, size, .. } = request;
        self.guarded(configuration, |renderer, configuration| {
            let plan = configuration.plan(target, graph, size)?;
            for (images, _) in renderer.frames(configuration, &plan, request)? {
                for faults in faults::kernel_faults(configuration.session(target, graph), size, &images)? {
                    faults.add_to(found);
                }
            }
            Ok(())
        })
    }

    /// Calls `call`. Its error, its panic, and an error of the device are a sentence for the report.
    fn guarded<T>(
        &mut self,
        configuration: &mut Configuration,
        call: impl FnOnce(&mut Self, &mut Configuration) -> Result<T, LabError>,
    ) -> Result<T, String> {
        let called = catch_panic(|| call(self, configuration));
        let result = match (self.errors.take_first(), called) {
            (Some(error), _) => Err(format!("the device refuses it: {}", one_line(&error))),
            (None, Err(panic)) => Err(format!("panics: {panic}")),
            (None, Ok(result)) => result.map_err(|error| one_line(&error.to_string())),
        };
        if result.is_err() {
            // The next cases get a new executor, so that this error cannot affect them.
            configuration.session = None;
        }
        result
    }

    fn render(&mut self, configuration: &mut Configuration, request: RenderRequest<'_>) -> Result<Rendered, LabError> {
        let RenderRequest { target, graph, size, together, .. } = request;
        let plan = configuration.plan(target, graph, size)?;
        let frames = self.frames(configuration, &plan, request)?;
        let session = configuration.session(target, graph);
        session.load(size, &frames[0].0)?;
        // Noise depends on the number of the frame.
        session.restart();
        let texels = match request.inputs.iter().any(|input| input.time != 0.0) {
            true => numbered(session, &frames)?,
            false => session.render_all(&frames, together)?,
        };
        let frames = texels.into_iter().map(|texels| outputs(&plan, graph, texels)).collect();
        Ok(Rendered { frames, skipped: plan.savings.skipped.iter().map(|skipped| skipped.node.clone()).collect() })
    }

    /// The images of the frames.
    fn frames(
        &mut self,
        configuration: &Configuration,
        plan: &Plan,
        request: RenderRequest<'_>,
    ) -> Result<Vec<FrameInputs>, LabError> {
        let RenderRequest { size, inputs, .. } = request;
        let mut frames: Vec<FrameInputs> = Vec::new();
        for frame in inputs {
            let mut images = Vec::new();
            for (name, image) in &plan.inputs {
                let planned = plan.image(*image);
                // The planned format may be another one than that of the image.
                let mut desc = planned.desc.format(configuration.format());
                if !desc.volume {
                    desc = desc.sized(size);
                }
                let image = self.image(*frame, desc, planned.signedness)?;
                images.push(InputImage { finite: configuration.unsanitized, ..image.named(name) });
            }
            frames.push((images, FrameStep { time: frame.time, dt: frame.dt, kind: FrameKind::cut_if(frame.reset) }));
        }
        Ok(frames)
    }

    /// The image of a frame. Each sample of a multisampled one, and each slice of a volume, shows another part of a
    /// higher image.
    fn image(&mut self, frame: StressFrame, desc: ImageDesc, signedness: Signedness) -> Result<InputImage, GpuError> {
        let signedness = frame.sanitized.then_some(signedness);
        let key = ImageKey { image: frame.image.name, desc, signedness };
        if let Some(made) = self.images.get(&key) {
            return Ok(made.clone());
        }
        let ImageDesc { size, samples, format, .. } = desc;
        let half = format == Format::Rgba16Float;
        let rows = Size::new(size.width, size.height * samples * size.depth);
        let mut pixels = frame.image.pixels(rows);
        if let Some(signedness) = signedness {
            if half {
                pixels.iter_mut().flatten().for_each(|x| *x = half::f16::from_f32(*x).to_f32());
            }
            let slice = Size::new(size.width, size.height);
            let slices = pixels.chunks(slice.texels() as usize);
            pixels = match samples {
                1 => slices.flat_map(|pixels| sanitized(pixels, slice, signedness)).collect(),
                _ => sanitized_samples(&pixels, signedness),
            };
        }
        let make = if half { Texels::from_floats_as_half } else { Texels::from_floats };
        let texels = make(rows.width, rows.height, &pixels);
        let made = input_image(&self.gpu, "", desc, &texels.bytes)?;
        Ok(self.images.entry(key).or_insert(made).clone())
    }
}

impl Configuration {
    /// The same, with filters in the shader and all images in 32 bits.
    pub(crate) fn exact(&self) -> Self {
        let options = Options { exact: true, ..self.options };
        Self { gpu: self.gpu.clone(), session: None, options, half: self.half, unsanitized: self.unsanitized }
    }

    /// The longest side that an image can have.
    pub(crate) fn longest_side(&self) -> u32 {
        self.gpu.caps.max_side
    }

    fn format(&self) -> Format {
        if self.half { Format::Rgba16Float } else { Format::Rgba32Float }
    }

    /// Texels of all images that a frame of this size needs, without tables of colors, which no size changes; 0 if it
    /// cannot be planned.
    pub(crate) fn texels(&mut self, target: &Target, graph: &Graph, size: Size) -> u64 {
        let Ok(plan) = self.plan(target, graph, size) else { return 0 };
        let fills = plan.passes.iter().enumerate().filter(|(index, _)| plan.runs_on_change(*index));
        let tables: Vec<usize> =
            fills.flat_map(|(_, planned)| &planned.pass.results).map(|result| result.image.0 as usize).collect();
        let images = plan.images.iter().enumerate().filter(|(index, _)| !tables.contains(index));
        images.map(|(_, image)| image.desc.size.texels()).sum()
    }

    /// True if frames depend on earlier frames.
    pub(crate) fn has_histories(&mut self, target: &Target, graph: &Graph, size: Size) -> bool {
        self.plan(target, graph, size).is_ok_and(|plan| has_histories(&plan))
    }

    /// The session, with this graph.
    fn session(&mut self, target: &Target, graph: &Graph) -> &mut Session {
        let (gpu, options) = (&self.gpu, self.options);
        self.session.get_or_insert_with(|| Session::new(gpu, graph.clone(), target.facts.clone(), options))
    }

    fn plan(&mut self, target: &Target, graph: &Graph, size: Size) -> Result<Arc<Plan>, LabError> {
        let given = HostImageDesc { desc: ImageDesc::new(size).format(self.format()), finite: self.unsanitized };
        let inputs = || graph.inputs.iter().filter(|input| !(input.optional && target.bare));
        let options = self.options;
        let session = self.session(target, graph);
        for input in inputs() {
            if let Some(block) = input.block {
                session.set_block(&input.name, plausible(block));
            }
        }
        session.change(graph.clone(), options);
        Ok(session.post().plan_for(HostInputs::all(size, inputs(), given))?)
    }
}

/// Numbers for a host block: a camera that has moved, or the defaults.
fn plausible(block: &'static HostBlock) -> BlockData {
    if *block != CAMERA {
        return BlockData::new(block);
    }
    let view = |x: f32| glam::Mat4::from_translation(glam::vec3(x, -1.5, -6.0)).to_cols_array_2d();
    // The near plane at depth 1, the far plane infinitely far.
    let projection =
        glam::camera::rh::proj::directx::perspective_infinite_reverse(1.0, 16.0 / 9.0, 0.1).to_cols_array_2d();
    let camera = Camera { previous_view: view(0.2), jitter: [0.25, -0.25], ..Camera::still(view(0.25), projection) };
    camera.data().expect("its matrices have inverses")
}

/// Renders frames one by one, each with the number that belongs to its time.
fn numbered(session: &mut Session, frames: &[FrameInputs]) -> Result<Vec<Vec<Texels>>, GpuError> {
    let render = |(images, step): &FrameInputs| {
        if step.kind == FrameKind::Cut {
            session.restart();
        }
        session.post().executor().number_next((60.0 * step.time).round() as u32);
        session.submit(images, *step)?;
        session.outputs()
    };
    frames.iter().map(render).collect()
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn outputs(plan: &Plan, graph: &Graph, texels: Vec<Texels>) -> Vec<OutputPixels> {
    let mut all = Vec::new();
    for ((output, declared), texels) in plan.outputs.iter().zip(&graph.outputs).zip(texels) {
        all.push(OutputPixels {
            name: output.name.clone(),
            state: output.state,
            limit: limit(plan, graph, declared.source),
            size: texels.desc.size,
            pixels: texels.to_floats(),
        });
    }
    all
}

/// The largest color of an image after the tone curve, if the node that makes it always gives that state: its
/// `peak`, or else 1.
fn limit(plan: &Plan, graph: &Graph, source: Source) -> Option<f64> {
    let Source::Node { node, output, .. } = source else { return None };
    let node = &graph.nodes[node];
    let gives = &node.kind().outputs()[output].state;
    let is_limited = matches!(gives, OutputState::Always(ColorState::DisplayLinear | ColorState::Encoded));
    if !is_limited || plan.savings.skipped.iter().any(|skipped| skipped.node == node.name) {
        return None;
    }
    match node.instance.value("peak") {
        Some(Value::Float(peak)) => Some(*peak),
        _ => Some(1.0),
    }
}

//! Recording: every node that runs records its passes, and with them the virtual images and buffers.

use std::collections::BTreeMap;

use crate::builder::{PlanBuilder, copy_pass, finite_image, float_format, scale_pass};
use crate::crop::crop_pass;
use crate::decoding::{Decoding, decoded_desc};
use crate::error::{NodeShaderError, PlanError};
use crate::plan::{CachedResults, PlanOutput, Refresh, Savings};
use crate::record_context::{FrameContext, NodeContext};
use crate::recording_limits::RecordingLimits;
use crate::refresh;
use crate::request::{Part, PlanRequest};
use crate::specialize::{SpecializedGraph, WireSource};
use afterimage_base::image::{ImageDesc, Signedness};
use afterimage_graph::check::{Graph, GraphInput, ImageColors, Source};
use afterimage_graph::node::{
    Arg, BlockId, ImageColor, ImageId, InputValue, KernelOrigin, NodeColors, NodeInstance, Origin, Pass, Recorder,
    RecorderContext, Recording, Replay, Resource, VirtualImage,
};
use afterimage_wgsl::ShaderError;

/// Attempts at inferring sizes of histories before they count as unstable.
const ROUNDS: usize = 8;

/// Lets every live node record its passes, and sizes the images that depend on earlier frames. Tables of more than
/// `max_computed_bytes` are zeros.
pub(crate) fn record(
    graph: &Graph,
    request: &PlanRequest<'_>,
    specialized: &SpecializedGraph,
    max_computed_bytes: u64,
) -> Result<PlanBuilder, PlanError> {
    let default = ImageDesc::new(request.given.size);
    let mut guesses: Vec<Vec<ImageDesc>> =
        graph.nodes.iter().map(|n| vec![default; n.kind().outputs().len()]).collect();
    let colors = graph.colors_along(&|wire| specialized.source(wire));
    let mut unstable = String::new();
    let mut computed = BTreeMap::new();
    for _ in 0..ROUNDS {
        let mut round = RecordAttempt::new(graph, request, specialized, &guesses, &colors);
        round.builder.recording.computed = computed;
        // What exceeds the limits of a plan is refused by `RecordingLimits`.
        round.builder.recording.max_computed = Some(max_computed_bytes);
        round.run()?;
        let wrong = round.wrong_guesses();
        let Some((node, ..)) = wrong.first() else {
            check_pixels(&round.builder.recording)?;
            return Ok(round.builder);
        };
        unstable.clone_from(&graph.nodes[*node].name);
        computed = std::mem::take(&mut round.builder.recording.computed);
        for (node, output, desc) in wrong {
            guesses[node][output] = desc;
        }
    }
    Err(PlanError::UnstableHistory(unstable))
}

/// One attempt at recording, with guessed descriptions of what earlier frames left.
struct RecordAttempt<'a> {
    graph: &'a Graph,
    request: &'a PlanRequest<'a>,
    specialized: &'a SpecializedGraph,
    guesses: &'a [Vec<ImageDesc>],
    colors: &'a ImageColors,
    frame: FrameContext,
    builder: PlanBuilder,
    made: Vec<Vec<InputValue>>,
    given: Vec<Option<ImageId>>,
    /// Histories that are read, in the order of their images: node, output, frames ago, image.
    histories: Vec<(usize, usize, u32, ImageId)>,
    /// The image of each history.
    known: BTreeMap<(usize, usize, u32), ImageId>,
    amounts: RecordingLimits,
    errors: Vec<NodeShaderError>,
}

impl<'a> RecordAttempt<'a> {
    fn new(
        graph: &'a Graph,
        request: &'a PlanRequest<'a>,
        specialized: &'a SpecializedGraph,
        guesses: &'a [Vec<ImageDesc>],
        colors: &'a ImageColors,
    ) -> Self {
        let savings = Savings { skipped: specialized.skipped.clone(), ..Savings::default() };
        let builder = PlanBuilder { savings, ..PlanBuilder::default() };
        let made = vec![Vec::new(); graph.nodes.len()];
        let given = vec![None; graph.inputs.len()];
        let (histories, known) = (Vec::new(), BTreeMap::new());
        let amounts = RecordingLimits::default();
        let frame = FrameContext::new(request);
        Self {
            graph,
            request,
            specialized,
            guesses,
            colors,
            frame,
            builder,
            made,
            given,
            histories,
            known,
            amounts,
            errors: Vec::new(),
        }
    }

    fn run(&mut self) -> Result<(), PlanError> {
        self.add_inputs()?;
        for &index in &self.specialized.order {
            if self.specialized.is_live(index) {
                self.node(index);
                self.amounts.check(&self.graph.nodes[index].name, &self.builder.recording)?;
            }
        }
        if !self.errors.is_empty() {
            return Err(PlanError::Shaders(std::mem::take(&mut self.errors)));
        }
        // Outputs may ask for histories too, and must know all of them: an image that is remembered is not theirs.
        let outputs = self.graph.outputs.iter();
        let shown = outputs.map(|output| self.input_value(Some(output.source))).collect();
        self.link_histories();
        refresh::exclude_histories(&mut self.builder);
        self.add_outputs(shown);
        Ok(())
    }

    fn add_inputs(&mut self) -> Result<(), PlanError> {
        for (index, input) in self.graph.inputs.iter().enumerate() {
            if !input.optional && !self.request.given.has(input) {
                return Err(PlanError::MissingInput(input.name.clone()));
            }
            let Some(given) = self.request.given.inputs.get(&input.name) else { continue };
            self.check_samples(input, given.desc.samples)?;
            self.check_volume(input, given.desc.volume)?;
            let image = self.builder.recording.add_image(VirtualImage {
                label: input.name.clone(),
                desc: given.desc,
                origin: Origin::Input(input.name.clone()),
                finite: given.finite,
                signedness: input.state.signedness(),
            });
            self.given[index] = Some(match self.request.given.parts.get(&input.name) {
                Some(part) => self.cropped(index, input, *part, image),
                None => self.scaled(input, image),
            });
            self.builder.inputs.push((input.name.clone(), image));
        }
        Ok(())
    }

    /// The samples of an image fit the type of its input.
    fn check_samples(&self, input: &GraphInput, given: u32) -> Result<(), PlanError> {
        let is_part = self.request.given.parts.contains_key(&input.name);
        match (input.multisampled, given > 1) {
            (true, true) if is_part => Err(PlanError::PartOfSamples(input.name.clone())),
            (true, true) | (false, false) => Ok(()),
            _ => Err(PlanError::WrongSamples { input: input.name.clone(), given }),
        }
    }

    /// A volume is given where the pipeline states one, and nowhere else.
    fn check_volume(&self, input: &GraphInput, given: bool) -> Result<(), PlanError> {
        let is_part = self.request.given.parts.contains_key(&input.name);
        match (input.volume, given) {
            (true, true) if is_part => Err(PlanError::PartOfVolume(input.name.clone())),
            (true, true) | (false, false) => Ok(()),
            _ => Err(PlanError::WrongDimension { input: input.name.clone(), given }),
        }
    }

    /// The image of an input as a frame crops it.
    fn cropped(&mut self, index: usize, input: &GraphInput, part: Part, image: ImageId) -> ImageId {
        let cropped = finite_image(format!("{}.cropped", input.name), self.builder.recording.image(image));
        let result = self.builder.recording.add_image(cropped);
        self.builder.recording.passes.push(crop_pass(index, input, part, image, result));
        result
    }

    /// The image of an input with its factor; the image itself if the factor is 1.
    fn scaled(&mut self, input: &GraphInput, image: ImageId) -> ImageId {
        if input.scale == 1.0 {
            return image;
        }
        let scaled = finite_image(format!("{}.scaled", input.name), self.builder.recording.image(image));
        let result = self.builder.recording.add_image(scaled);
        self.builder.recording.passes.push(scale_pass(&input.name, image, input.scale as f32, result));
        result
    }

    fn input_value(&mut self, wire: Option<Source>) -> InputValue {
        match self.specialized.resolve(wire) {
            WireSource::Zero => InputValue::Zero,
            WireSource::Absent => InputValue::Absent,
            WireSource::From(Source::Input(input)) => match (self.given[input], self.graph.inputs[input].block) {
                (Some(image), _) => InputValue::Image(image),
                (None, Some(_)) => InputValue::Block(BlockId(input as u32)),
                (None, None) => InputValue::Absent,
            },
            WireSource::From(Source::Node { node, output, previous: 0 }) => self.made[node][output].clone(),
            WireSource::From(Source::Node { node, output, previous }) => {
                InputValue::Image(self.history(node, output, previous))
            }
        }
    }

    fn history(&mut self, node: usize, output: usize, frames: u32) -> ImageId {
        if let Some(image) = self.known.get(&(node, output, frames)) {
            return *image;
        }
        let image = self.builder.recording.add_image(VirtualImage {
            label: format!("{}@previous:{frames}", self.graph.nodes[node].name),
            desc: self.guesses[node][output],
            // The image that it is the past of is not recorded yet; `link_histories` fills it in.
            origin: Origin::Previous { of: ImageId(u32::MAX), frames },
            finite: true,
            signedness: Signedness::Unsigned,
        });
        self.histories.push((node, output, frames, image));
        self.known.insert((node, output, frames), image);
        image
    }

    fn node(&mut self, index: usize) {
        let node = &self.graph.nodes[index];
        let values: Vec<InputValue> = node.wires.iter().map(|wire| self.input_value(*wire)).collect();
        let sources = node.wires.iter().map(|wire| self.specialized.source((*wire)?));
        let inputs: Vec<Option<ImageColor>> = sources.map(|source| self.colors.at(source?)).collect();
        let context = NodeContext {
            name: node.name.clone(),
            dynamic: self.request.dynamic_of(index),
            format: node.format,
            values,
            inputs,
            outputs: self.colors.of_node(index).to_vec(),
            used_outputs: self.specialized.used_outputs[index].clone(),
        };
        let first_image = self.builder.recording.images.len();
        let first_buffer = self.builder.recording.buffers.len();
        let first_pass = self.builder.recording.passes.len();
        let (made, errors) = record_node(&self.frame, &node.instance, &context, &mut self.builder.recording);
        let seldom = match self.builder.recording.settled.contains(&node.name) {
            true => Some(Refresh::Once),
            false => (node.every > 1).then_some(Refresh::Every { every: node.every, phase: 0 }),
        };
        if let Some(refresh) = seldom.filter(|_| !self.request.options.exact) {
            let results = refresh::results(&self.builder.recording, &made, [first_image, first_buffer], refresh);
            self.builder.savings.cached.push(CachedResults { node: node.name.clone(), refresh, results });
        }
        self.made[index] = made;
        for error in errors {
            if !self.errors.iter().any(|known| known.error == error) {
                self.errors.push(NodeShaderError { node: node.name.clone(), error });
            }
        }
        if !context.dynamic.is_empty() {
            self.builder.dynamic.insert(index, context);
        }
        let signedness = node.states.iter().flatten().map(|state| state.signedness()).max();
        let signedness = signedness.unwrap_or(Signedness::Unsigned);
        let images = self.builder.recording.images[first_image..].iter_mut();
        images.for_each(|image| image.signedness = image.signedness.max(signedness));
        let kernels = self.builder.recording.passes[first_pass..].iter_mut().flat_map(|pass| &mut pass.kernels);
        for (number, kernel) in kernels.enumerate() {
            kernel.origin = Some(KernelOrigin::Node { node: index, kernel: number });
            kernel.limited = kernel.shader.is_untrusted().then_some(signedness);
        }
    }

    fn link_histories(&mut self) {
        for (node, output, frames, image) in &self.histories {
            let made = self.made[*node].get(*output);
            let of = match made {
                Some(InputValue::Image(of)) => *of,
                // The node is off: its past is what it was when it last ran, or black.
                _ => *image,
            };
            let finite = self.builder.recording.image(of).finite;
            let past = &mut self.builder.recording.images[image.0 as usize];
            (past.origin, past.finite) = (Origin::Previous { of, frames: *frames }, finite);
        }
    }

    fn wrong_guesses(&self) -> Vec<(usize, usize, ImageDesc)> {
        let wrong = self.histories.iter().filter_map(|(node, output, _, image)| {
            let Some(InputValue::Image(of)) = self.made[*node].get(*output) else { return None };
            let desc = self.builder.recording.image(*of).desc;
            (self.builder.recording.image(*image).desc != desc).then_some((*node, *output, desc))
        });
        wrong.collect()
    }

    fn add_outputs(&mut self, shown: Vec<InputValue>) {
        let mut kept = self.builder.kept();
        for (output, value) in self.graph.outputs.iter().zip(shown) {
            let color = self.specialized.source(output.source).and_then(|source| self.colors.at(source));
            let color = color.unwrap_or(ImageColor::of(output.state));
            let is_linear = self.request.given.linear.contains(&output.name);
            let decoding = Decoding::of(color).filter(|_| is_linear);
            let in_rectangle = self.request.given.rectangles.contains(&output.name);
            // An image that later frames read, that is cached, or that is an output already, cannot be the host's: it
            // gets a copy. So does an attachment, whose format pipelines depend on.
            let is_cached = |image: &ImageId| {
                self.builder.savings.cached.iter().any(|cached| cached.results.contains(&Resource::Image(*image)))
            };
            let taken = |image: &ImageId| {
                kept.contains(image)
                    || is_cached(image)
                    || in_rectangle && !self.can_go_elsewhere(*image)
                    || self.is_drawn_into(*image)
            };
            let (image, ImageColor { state, colorimetry }) = match (value, decoding) {
                (InputValue::Image(image), Some(decoding)) => {
                    (self.decode(&output.name, image, decoding), Decoding::decoded(color))
                }
                (InputValue::Image(image), None)
                    if self.builder.recording.image(image).origin == Origin::Transient && !taken(&image) =>
                {
                    (image, ImageColor { state: output.state, ..color })
                }
                (other, _) => (self.copy(&output.name, &other), ImageColor { state: output.state, ..color }),
            };
            kept.insert(image);
            self.builder.outputs.push(PlanOutput {
                name: output.name.clone(),
                image,
                state,
                colorimetry,
                in_rectangle,
            });
        }
    }

    /// Returns whether the texels of an image can lie at other places in the host's texture: only kernel functions can
    /// be moved, and nothing may read it.
    fn can_go_elsewhere(&self, image: ImageId) -> bool {
        let passes = &self.builder.recording.passes;
        passes.iter().any(|pass| pass.function_result() == Some(image))
            && !passes.iter().any(|pass| pass.reads().contains(&Resource::Image(image)))
    }

    /// Returns whether a drawing pass draws into an image.
    fn is_drawn_into(&self, image: ImageId) -> bool {
        let mut drawings = self.builder.recording.passes.iter().filter_map(Pass::drawing);
        drawings.any(|drawing| drawing.images().contains(&image))
    }

    /// The image of an output that holds linear light.
    fn decode(&mut self, name: &str, source: ImageId, decoding: Decoding) -> ImageId {
        let recording = &mut self.builder.recording;
        let image = recording.add_image(VirtualImage {
            label: format!("{name}.decoded"),
            desc: decoded_desc(recording.image(source).desc),
            origin: Origin::Transient,
            finite: true,
            signedness: recording.image(source).signedness,
        });
        recording.passes.push(decoding.pass(name, source, image));
        image
    }

    /// A pass that writes an output which no node writes.
    fn copy(&mut self, name: &str, what: &InputValue) -> ImageId {
        let (arg, desc) = match what {
            InputValue::Image(image) => (Arg::Pixel(*image), self.builder.recording.image(*image).desc),
            _ => (Arg::Zero(4), ImageDesc::new(self.request.given.size)),
        };
        let recording = &mut self.builder.recording;
        let image = recording.add_image(VirtualImage {
            label: name.to_owned(),
            desc: desc.format(float_format(desc.format)),
            origin: Origin::Transient,
            finite: true,
            signedness: Signedness::Unsigned,
        });
        recording.passes.push(copy_pass(name, arg, image));
        image
    }
}

/// An error if a function takes a pixel of an image that has another size than its result.
fn check_pixels(recording: &Recording) -> Result<(), PlanError> {
    let mut misfits = recording.passes.iter().flat_map(|pass| recording.misfit_pixels(pass));
    let Some(misfit) = misfits.next() else { return Ok(()) };
    let image = recording.image(misfit.image);
    Err(PlanError::MisfitPixel {
        node: misfit.kernel.node.as_str().into(),
        argument: misfit.argument.into(),
        image: image.label.as_str().into(),
        size: image.desc.size,
        result: recording.image(misfit.result).desc.size,
        shader: misfit.kernel.shader.file().into(),
    })
}

/// Lets a node record its passes; what its outputs hold, and what is wrong with its shaders.
pub(crate) fn record_node(
    frame: &FrameContext,
    instance: &NodeInstance,
    context: &NodeContext,
    recording: &mut Recording,
) -> (Vec<InputValue>, Vec<ShaderError>) {
    let mut recorder = Recorder::new(recorder_context(frame, context, instance), recording);
    instance.record(&mut recorder);
    recorder.finish()
}

/// Lets a node record its passes again at other values.
pub(crate) fn replay_node(
    frame: &FrameContext,
    instance: &NodeInstance,
    context: &NodeContext,
    recording: &mut Recording,
    replay: &mut Replay,
) {
    instance.record(&mut Recorder::again(recorder_context(frame, context, instance), recording, replay));
}

fn recorder_context<'a>(
    frame: &'a FrameContext,
    context: &'a NodeContext,
    instance: &'a NodeInstance,
) -> RecorderContext<'a> {
    RecorderContext {
        node: &context.name,
        kind: instance.kind().signature(),
        parameters: instance.uniform_values(),
        dynamic: &context.dynamic,
        inputs: &context.values,
        format: context.format,
        frame_size: frame.size,
        caps: &frame.caps,
        exact: frame.exact,
        used_outputs: &context.used_outputs,
        colors: NodeColors { inputs: &context.inputs, outputs: &context.outputs },
    }
}

//! Step 3: every node that runs records its passes; the virtual images and buffers come to be.

use crate::cull::LiveNodes;
use crate::specialize::{SpecializedGraph, WireSource};
use crate::{Caps, PlanBuilder, PlanError, PlanOutput, PlanRequest, Stage};
use afterimage_base::image::{ColorState, Format, ImageDesc};
use afterimage_graph::check::{Graph, Source};
use afterimage_graph::node::{
    Arg, Arrival, ImageId, Origin, Pass, Recorder, RecorderContext, Recording, Step, VirtualImage, Work,
};
use afterimage_wgsl::Shader;

/// What a node without work of its own needs: an output that is an input of the host must still be written.
#[allow(unsafe_code, reason = "the shader was unchecked")]
// SAFETY: it reads nothing.
static COPY: Shader = unsafe { Shader::unchecked("copy.wgsl", "fn copy(source: vec4f) -> vec4f { return source; }") };

/// How often sizes of histories may be inferred anew before they are said not to settle.
const ROUNDS: usize = 8;

pub(crate) fn record(
    graph: &Graph,
    setting: &PlanRequest<'_>,
    special: &SpecializedGraph,
    needed: &LiveNodes,
) -> Result<PlanBuilder, PlanError> {
    let default = ImageDesc::new(setting.size);
    let mut guesses: Vec<Vec<ImageDesc>> = graph.nodes.iter().map(|n| vec![default; n.kind.outputs().len()]).collect();
    let mut unstable = String::new();
    for _ in 0..ROUNDS {
        let mut round = Round::new(graph, setting, special, needed, &guesses);
        round.run()?;
        let wrong = round.wrong_guesses();
        let Some((node, ..)) = wrong.first() else { return Ok(round.draft) };
        unstable.clone_from(&graph.nodes[*node].name);
        for (node, output, desc) in wrong {
            guesses[node][output] = desc;
        }
    }
    Err(PlanError::UnstableHistory(unstable))
}

/// One attempt at recording, with guessed descriptions of what earlier frames left.
struct Round<'a> {
    graph: &'a Graph,
    setting: &'a PlanRequest<'a>,
    special: &'a SpecializedGraph,
    needed: &'a LiveNodes,
    guesses: &'a [Vec<ImageDesc>],
    draft: PlanBuilder,
    made: Vec<Vec<Arrival>>,
    given: Vec<Option<ImageId>>,
    /// Histories that were asked for: node, output, frames ago, image.
    histories: Vec<(usize, usize, u32, ImageId)>,
}

impl<'a> Round<'a> {
    fn new(
        graph: &'a Graph,
        setting: &'a PlanRequest<'a>,
        special: &'a SpecializedGraph,
        needed: &'a LiveNodes,
        guesses: &'a [Vec<ImageDesc>],
    ) -> Self {
        let draft = PlanBuilder { recording: Recording::default(), inputs: Vec::new(), outputs: Vec::new() };
        let made = vec![Vec::new(); graph.nodes.len()];
        let given = vec![None; graph.inputs.len()];
        Self { graph, setting, special, needed, guesses, draft, made, given, histories: Vec::new() }
    }

    fn run(&mut self) -> Result<(), PlanError> {
        self.add_inputs()?;
        for &index in &self.special.order {
            if self.special.runs[index] && self.needed.node(index) {
                self.node(index);
            }
        }
        // Outputs may ask for histories too, and must know all of them: an image that is remembered is not theirs.
        let outputs = self.graph.outputs.iter();
        let shown = outputs.map(|output| self.arrival(Some(output.source))).collect();
        self.link_histories();
        self.add_outputs(shown);
        Ok(())
    }

    fn add_inputs(&mut self) -> Result<(), PlanError> {
        for (index, input) in self.graph.inputs.iter().enumerate() {
            let Some(given) = self.setting.inputs.get(&input.name) else {
                if input.optional {
                    continue;
                }
                return Err(PlanError::MissingInput(input.name.clone()));
            };
            let image = self.draft.recording.add_image(VirtualImage {
                label: input.name.clone(),
                desc: given.desc,
                origin: Origin::Input(input.name.clone()),
                finite: given.finite,
                signed: input.signed || input.state == ColorState::Data,
            });
            self.given[index] = Some(image);
            self.draft.inputs.push((input.name.clone(), image));
        }
        Ok(())
    }

    fn arrival(&mut self, wire: Option<Source>) -> Arrival {
        match self.special.resolve(wire) {
            WireSource::Zero => Arrival::Zero,
            WireSource::Absent => Arrival::Absent,
            WireSource::From(Source::Input(input)) => self.given[input].map_or(Arrival::Absent, Arrival::Image),
            WireSource::From(Source::Node { node, output, previous: 0 }) => self.made[node][output].clone(),
            WireSource::From(Source::Node { node, output, previous }) => {
                Arrival::Image(self.history(node, output, previous))
            }
        }
    }

    fn history(&mut self, node: usize, output: usize, frames: u32) -> ImageId {
        let known = self.histories.iter().find(|(n, o, f, _)| (*n, *o, *f) == (node, output, frames));
        if let Some((.., image)) = known {
            return *image;
        }
        let image = self.draft.recording.add_image(VirtualImage {
            label: format!("{}@previous:{frames}", self.graph.nodes[node].name),
            desc: self.guesses[node][output],
            // The image that it is the past of is not recorded yet; `link_histories` fills it in.
            origin: Origin::Previous { of: ImageId(u32::MAX), frames },
            finite: true,
            signed: false,
        });
        self.histories.push((node, output, frames, image));
        image
    }

    fn node(&mut self, index: usize) {
        let node = &self.graph.nodes[index];
        let arrivals: Vec<Arrival> = node.wires.iter().map(|wire| self.arrival(*wire)).collect();
        let context = RecorderContext {
            node: &node.name,
            kind: node.kind.signature(),
            values: &node.values,
            arrivals: &arrivals,
            format: node.format,
            frame_size: self.setting.size,
            caps: &self.setting.caps,
            exact: self.setting.options.exact,
            wanted: &self.needed.wanted[index],
        };
        let first_image = self.draft.recording.images.len();
        let mut recorder = Recorder::new(context, &mut self.draft.recording);
        node.kind.record(&node.values, &mut recorder);
        self.made[index] = recorder.finish();
        let signed = node.states.iter().flatten().any(|s| matches!(s, ColorState::Data | ColorState::LogLuminance));
        self.draft.recording.images[first_image..].iter_mut().for_each(|image| image.signed = signed);
    }

    fn link_histories(&mut self) {
        for (node, output, frames, image) in &self.histories {
            let made = self.made[*node].get(*output);
            let of = match made {
                Some(Arrival::Image(of)) => *of,
                // The node is off: its past is what it was when it last ran, or black.
                _ => *image,
            };
            self.draft.recording.images[image.0 as usize].origin = Origin::Previous { of, frames: *frames };
        }
    }

    fn wrong_guesses(&self) -> Vec<(usize, usize, ImageDesc)> {
        let wrong = self.histories.iter().filter_map(|(node, output, _, image)| {
            let Some(Arrival::Image(of)) = self.made[*node].get(*output) else { return None };
            let desc = self.draft.recording.image(*of).desc;
            (self.draft.recording.image(*image).desc != desc).then_some((*node, *output, desc))
        });
        wrong.collect()
    }

    fn add_outputs(&mut self, shown: Vec<Arrival>) {
        for (output, arrival) in self.graph.outputs.iter().zip(shown) {
            // An image that is remembered, or that is an output already, cannot be the host's: it gets a copy.
            let taken = |image: ImageId| self.draft.is_kept(image);
            let image = match arrival {
                Arrival::Image(image)
                    if self.draft.recording.image(image).origin == Origin::Transient && !taken(image) =>
                {
                    image
                }
                other => self.copy(&output.name, &other),
            };
            self.draft.outputs.push(PlanOutput { name: output.name.clone(), image, state: output.state });
        }
    }

    /// A pass that writes an output which no node writes.
    fn copy(&mut self, name: &str, what: &Arrival) -> ImageId {
        let (arg, desc) = match what {
            Arrival::Image(image) => (Arg::Pixel(*image), self.draft.recording.image(*image).desc),
            _ => (Arg::Zero(4), ImageDesc::new(self.setting.size)),
        };
        let format = if desc.format.is_32_bit() { desc.format } else { Format::Rgba16Float };
        let recording = &mut self.draft.recording;
        let image = recording.add_image(VirtualImage {
            label: name.to_owned(),
            desc: desc.format(format),
            origin: Origin::Transient,
            finite: true,
            signed: false,
        });
        recording.passes.push(copy_pass(name, Step::new(name, &COPY, "copy", vec![arg]), image));
        image
    }
}

pub(crate) fn copy_pass(node: &str, step: Step, result: ImageId) -> Pass {
    Pass { nodes: vec![node.to_owned()], label: "copy".into(), work: Work::Steps { steps: vec![step], result } }
}

/// A step that copies a pixel of `source`.
pub(crate) fn copy_step(node: &str, source: ImageId) -> Step {
    Step::new(node, &COPY, "copy", vec![Arg::Pixel(source)])
}

/// How each pass runs. Formats that a device can neither store nor draw become wider.
pub(crate) fn stages(recording: &mut Recording, caps: &Caps) -> Vec<Stage> {
    let mut stages = Vec::with_capacity(recording.passes.len());
    for index in 0..recording.passes.len() {
        let drawable = matches!(recording.passes[index].work, Work::Steps { .. });
        let images: Vec<ImageId> = recording.passes[index]
            .writes()
            .into_iter()
            .filter_map(|r| match r {
                afterimage_graph::node::Resource::Image(image) => Some(image),
                afterimage_graph::node::Resource::Buffer(_) => None,
            })
            .collect();
        let mut stage = Stage::Compute;
        for image in images {
            let format = &mut recording.images[image.0 as usize].desc.format;
            stage = choose(format, drawable, caps);
        }
        stages.push(stage);
    }
    stages
}

fn choose(format: &mut Format, drawable: bool, caps: &Caps) -> Stage {
    loop {
        let (stores, draws) = (caps.storage.contains(format), drawable && caps.renderable.contains(format));
        match (stores, draws) {
            (_, true) if caps.prefer_fragment => return Stage::Fragment,
            (true, _) => return Stage::Compute,
            (false, true) => return Stage::Fragment,
            (false, false) if format.wider() == *format => return Stage::Compute,
            (false, false) => *format = format.wider(),
        }
    }
}

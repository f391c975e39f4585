//! The recorder: what a node uses to describe its passes as data. It cannot reach a device.

mod bindings;
mod compute;
mod details;
mod draw;
mod draw_rules;
mod function;
mod recording;
mod replay;
mod resources;
mod warp;

use std::borrow::Cow;
use std::cell::RefCell;
use std::fmt::Display;

pub use compute::ComputePass;
pub use draw::{AttachmentPass, DrawPass};
pub use function::FunctionPass;
pub use recording::{MisfitPixel, Recording};
pub use replay::Replay;
pub use warp::WarpPass;

use super::color::ImageColor;
use super::drawing::Subresource;
use super::pass::Pass;
use super::ports::{OutputState, OutputUse, PortType, Signature};
use super::resource::{BlockId, BufferId, ImageId};
use super::values::UniformValues;
use afterimage_base::caps::Caps;
use afterimage_base::image::{ColorState, Format, ImageDesc, Size};
use afterimage_wgsl::{Reflection, Shader, ShaderError};
use details::Label;

/// What is wired to an input port of a node that runs.
#[derive(Clone, Debug, PartialEq)]
pub enum InputValue {
    /// An image or a volume.
    Image(ImageId),
    /// A pyramid, finest level first.
    Pyramid(Vec<ImageId>),
    /// A table or a value.
    Buffer(BufferId),
    /// A struct of numbers from the host.
    Block(BlockId),
    /// An image that is zero everywhere.
    Zero,
    /// Nothing.
    Absent,
}

/// What a node gets: its parameters and inputs, and the recording to which it adds passes.
pub struct Recorder<'a> {
    node: &'a str,
    kind: Signature<'a>,
    parameters: UniformValues<'a>,
    dynamic: &'a [usize],
    inputs: &'a [InputValue],
    format: Option<Format>,
    frame_size: Size,
    caps: &'a Caps,
    exact: bool,
    used_outputs: &'a [OutputUse],
    colors: NodeColors<'a>,
    recording: &'a mut Recording,
    /// What the node has recorded before, if it is recorded again for its uniforms.
    replay: Option<&'a mut Replay>,
    /// None if it is recorded again: nobody reads them then.
    outputs: Vec<InputValue>,
    /// What is wrong with the shaders of the node.
    errors: RefCell<Vec<ShaderError>>,
}

/// What a [`Recorder`] knows of its node; the planner fills it in.
pub struct RecorderContext<'a> {
    /// The node's name.
    pub node: &'a str,
    /// What its kind declares.
    pub kind: Signature<'a>,
    /// The values of its parameters, for uniforms.
    pub parameters: UniformValues<'a>,
    /// The parameters that the host changes while the plan runs, by their indices in the kind's table.
    pub dynamic: &'a [usize],
    /// What arrives at its inputs, in the order of the kind's ports.
    pub inputs: &'a [InputValue],
    /// The format that the file asks for.
    pub format: Option<Format>,
    /// The size of the frame, for nodes without an image input.
    pub frame_size: Size,
    /// What the device can do.
    pub caps: &'a Caps,
    /// Whether every intermediate is stored in 32 bits.
    pub exact: bool,
    /// How much of each output is read, in the order of the kind's ports.
    pub used_outputs: &'a [OutputUse],
    /// What the images at its ports mean.
    pub colors: NodeColors<'a>,
}

/// What the images at the ports of a node mean, in the order of the kind's ports. `None`, or a port without an entry,
/// is an image about which nothing is known.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeColors<'a> {
    /// Of the inputs.
    pub inputs: &'a [Option<ImageColor>],
    /// Of the outputs.
    pub outputs: &'a [Option<ImageColor>],
}

impl<'a> Recorder<'a> {
    /// A recorder that adds to `recording`.
    pub fn new(context: RecorderContext<'a>, recording: &'a mut Recording) -> Self {
        let outputs = vec![InputValue::Absent; context.kind.outputs.len()];
        Self::with(context, recording, None, outputs)
    }

    /// A recorder for a node that is recorded again at other values: passes are compared with those of before, and only
    /// their uniforms are made.
    pub fn again(context: RecorderContext<'a>, recording: &'a mut Recording, replay: &'a mut Replay) -> Self {
        replay.begin(recording);
        Self::with(context, recording, Some(replay), Vec::new())
    }

    fn with(
        context: RecorderContext<'a>,
        recording: &'a mut Recording,
        replay: Option<&'a mut Replay>,
        outputs: Vec<InputValue>,
    ) -> Self {
        let RecorderContext { node, kind, parameters, dynamic, inputs, .. } = context;
        let RecorderContext { format, frame_size, caps, exact, used_outputs, colors, .. } = context;
        Self {
            node,
            kind,
            parameters,
            dynamic,
            inputs,
            format,
            frame_size,
            caps,
            exact,
            used_outputs,
            colors,
            recording,
            replay,
            outputs,
            errors: RefCell::default(),
        }
    }

    fn add_pass(&mut self, pass: Pass) {
        match &mut self.replay {
            Some(replay) => replay.compare(pass),
            None => self.recording.passes.push(pass),
        }
    }

    /// What each output port holds, in the order of the kind's ports; and the errors in the shaders of the node, with
    /// which its passes must not run.
    pub fn finish(self) -> (Vec<InputValue>, Vec<ShaderError>) {
        (self.outputs, self.errors.into_inner())
    }

    fn input_value(&self, port: &str) -> &'a InputValue {
        let index = self.kind.inputs.iter().position(|input| input.name == port);
        &self.inputs[index.unwrap_or_else(|| panic!("`{}` has no input `{port}`", self.kind.name))]
    }

    /// Whether something arrives at an optional input.
    pub fn wired(&self, port: &str) -> bool {
        !matches!(self.input_value(port), InputValue::Absent)
    }

    /// Whether the input is known to be zero everywhere.
    pub fn is_zero(&self, port: &str) -> bool {
        matches!(self.input_value(port), InputValue::Zero)
    }

    /// Whether the output is read.
    pub fn is_output_used(&self, port: &str) -> bool {
        self.use_of(port) != OutputUse::Unused
    }

    /// Whether more of a value than its x is read.
    pub fn is_whole_output_used(&self, port: &str) -> bool {
        self.use_of(port) == OutputUse::Whole
    }

    fn use_of(&self, port: &str) -> OutputUse {
        let index = self.kind.outputs.iter().position(|output| output.name == port);
        index.map_or(OutputUse::Unused, |index| self.used_outputs[index])
    }

    /// Declares that the state of this node stays as the first frame of a sequence makes it: in other frames its
    /// passes, and those that nobody else needs, do not run.
    pub fn settle_state(&mut self) {
        self.recording.settled.insert(self.node.to_owned());
    }

    /// Whether the host changes the parameter while the plan runs. Then the passes must be the same at all its values,
    /// but for their uniforms.
    pub fn is_dynamic(&self, parameter: &str) -> bool {
        let index = self.kind.params.iter().position(|param| param.name == parameter);
        self.dynamic.contains(&index.unwrap_or_else(|| panic!("`{}` has no parameter `{parameter}`", self.kind.name)))
    }

    /// The image or volume at an input; one black texel where the input is zero.
    pub fn image(&mut self, port: &str) -> ImageId {
        match self.input_value(port).clone() {
            InputValue::Image(image) => image,
            InputValue::Zero => self.black(),
            other => panic!("input `{port}` of `{}` is {other:?}, not an image", self.node),
        }
    }

    /// The levels of the pyramid at an input, finest first; one black texel where the input is zero.
    pub fn pyramid(&mut self, port: &str) -> Cow<'a, [ImageId]> {
        match self.input_value(port) {
            InputValue::Pyramid(levels) => levels.as_slice().into(),
            InputValue::Zero => vec![self.black()].into(),
            other => panic!("input `{port}` of `{}` is {other:?}, not a pyramid", self.node),
        }
    }

    /// The buffer of the table or value at an input.
    pub fn buffer(&self, port: &str) -> BufferId {
        match self.input_value(port) {
            InputValue::Buffer(buffer) => *buffer,
            other => panic!("input `{port}` of `{}` is {other:?}, not a buffer", self.node),
        }
    }

    /// The size of a buffer.
    pub fn buffer_bytes(&self, buffer: BufferId) -> u64 {
        self.recording.buffer(buffer).bytes
    }

    /// The description of an image.
    pub fn desc(&self, image: ImageId) -> ImageDesc {
        self.recording.image(image).desc
    }

    /// The size of the frame: for nodes without an image input.
    pub fn frame_size(&self) -> Size {
        self.frame_size
    }

    /// What the device can do.
    pub fn caps(&self) -> &Caps {
        self.caps
    }

    /// Whether the reference is recorded, with every intermediate in 32 bits. Quality switches are set by the caller.
    pub fn exact(&self) -> bool {
        self.exact
    }

    /// The format that the file asks for this node's results.
    pub fn format(&self) -> Option<Format> {
        self.format
    }

    /// What the image at an input means. Linear Rec.709, or sRGB for a port that accepts encoded images only, if
    /// nothing is known about it.
    pub fn color(&self, input: &str) -> ImageColor {
        let index = self.kind.inputs.iter().position(|port| port.name == input);
        let index = index.unwrap_or_else(|| panic!("`{}` has no input `{input}`", self.kind.name));
        let state = self.kind.inputs[index].states.first().copied().unwrap_or(ColorState::Scene);
        self.colors.inputs.get(index).copied().flatten().unwrap_or(ImageColor::of(state))
    }

    /// What the image at an output means: for a node that maps light to a display, with the primaries of that display.
    pub fn output_color(&self, output: &str) -> ImageColor {
        let index = self.kind.outputs.iter().position(|port| port.name == output);
        let index = index.unwrap_or_else(|| panic!("`{}` has no output `{output}`", self.kind.name));
        let otherwise = || match &self.kind.outputs[index].state {
            OutputState::Always(state) => ImageColor::of(*state),
            OutputState::Same(input) => self.color(input),
            OutputState::Chosen(_) => self.color(&self.kind.inputs[0].name),
            OutputState::Nothing => ImageColor::of(ColorState::Data),
        };
        self.colors.outputs.get(index).copied().flatten().unwrap_or_else(otherwise)
    }

    /// Gives something to an output port.
    pub fn give(&mut self, port: &str, what: InputValue) {
        let index = self.kind.outputs.iter().position(|output| output.name == port);
        let index = index.unwrap_or_else(|| panic!("`{}` has no output `{port}`", self.kind.name));
        if let InputValue::Image(image) = what {
            let (desc, ty) = (self.desc(image), self.kind.outputs[index].ty);
            let fits = match ty {
                PortType::Multisampled => desc.samples > 1,
                _ => desc.is_plain(),
            };
            assert!(fits, "the output `{port}` of `{}` is a {}: {}", self.kind.name, ty.name(), shape(desc));
        }
        if let Some(output) = self.outputs.get_mut(index) {
            *output = what;
        }
    }

    /// Gives the next level of the pyramid of an output port, finest first.
    pub fn give_level(&mut self, port: &str, level: ImageId) {
        let index = self.kind.outputs.iter().position(|output| output.name == port);
        let index = index.unwrap_or_else(|| panic!("`{}` has no output `{port}`", self.kind.name));
        match self.outputs.get_mut(index) {
            Some(InputValue::Pyramid(levels)) => levels.push(level),
            Some(output) => *output = InputValue::Pyramid(vec![level]),
            None => {}
        }
    }

    /// A pass reads or draws a level and a layer that there is.
    fn require_part(&self, part: Subresource, place: &str) {
        let image = self.recording.image(part.image);
        let ImageDesc { levels, layers, .. } = image.desc;
        assert!(
            part.level < levels && part.layer < layers,
            "`{place}` names level {} of layer {} of `{}`: {}",
            part.level,
            part.layer,
            image.label,
            shape(image.desc)
        );
    }

    /// What a module declares: nothing, if it is wrong.
    fn reflection<'s>(&self, shader: &'s Shader) -> &'s Reflection {
        shader.reflect().unwrap_or_else(|error| {
            self.add_error(error);
            &NOTHING
        })
    }

    /// Adds an error in a shader of the node. `record` of a kind cannot fail, so it goes on with passes that never run.
    fn add_error(&self, error: ShaderError) {
        let mut errors = self.errors.borrow_mut();
        if !errors.contains(&error) {
            errors.push(error);
        }
    }

    /// What a pass does, for people.
    fn pass_label(&self, label: impl Display) -> Label {
        match &self.replay {
            Some(replay) => replay.compared(label),
            None => Label::Own(label.to_string()),
        }
    }
}

/// What a wrong module declares.
static NOTHING: Reflection = Reflection {
    functions: Vec::new(),
    entries: Vec::new(),
    structs: Vec::new(),
    globals: Vec::new(),
    direct_reads: Vec::new(),
    filtering: Vec::new(),
    sharing: Vec::new(),
    works: Vec::new(),
    costs: Vec::new(),
};

/// Samples, levels and layers of an image, for messages.
fn shape(desc: ImageDesc) -> String {
    let count = |count: u32, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let [samples, levels, layers] = [(desc.samples, "sample"), (desc.levels, "level"), (desc.layers, "layer")]
        .map(|(number, what)| count(number, what));
    format!("its image has {samples}, {levels} and {layers}")
}

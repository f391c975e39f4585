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

/// Value of an input port of a node that runs.
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

/// Interface of a node's `record`: its parameters and inputs, and the recording to which it adds passes.
pub struct Recorder<'a> {
    context: RecorderContext<'a>,
    recording: &'a mut Recording,
    /// The node's recording of before, if it is recorded again for its uniforms.
    replay: Option<&'a mut Replay>,
    /// None if it is recorded again: nobody reads them then.
    outputs: Vec<InputValue>,
    /// Errors in the shaders of the node.
    errors: RefCell<Vec<ShaderError>>,
}

/// Context of a [`Recorder`], from the planner.
pub struct RecorderContext<'a> {
    /// The node's name.
    pub node: &'a str,
    /// Declaration of its kind.
    pub kind: Signature<'a>,
    /// The values of its parameters, for uniforms.
    pub parameters: UniformValues<'a>,
    /// The parameters that the host changes while the plan runs, by their indices in the kind's table.
    pub dynamic: &'a [usize],
    /// Values of its inputs, in the order of the kind's ports.
    pub inputs: &'a [InputValue],
    /// The format that the file asks for.
    pub format: Option<Format>,
    /// The size of the frame, for nodes without an image input.
    pub frame_size: Size,
    /// Capabilities of the device.
    pub caps: &'a Caps,
    /// True if every intermediate is stored in 32 bits.
    pub exact: bool,
    /// Part of each output that is read, in the order of the kind's ports.
    pub used_outputs: &'a [OutputUse],
    /// Colors of the images at its ports.
    pub colors: NodeColors<'a>,
}

/// Colors of the images at the ports of a node, in the order of the kind's ports. `None`, or a port without an entry,
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
        Self { context, recording, replay: None, outputs, errors: RefCell::default() }
    }

    /// A recorder for a node that is recorded again at other values: passes are compared with those of before, and only
    /// their uniforms are made.
    pub fn again(context: RecorderContext<'a>, recording: &'a mut Recording, replay: &'a mut Replay) -> Self {
        replay.begin(recording);
        Self { context, recording, replay: Some(replay), outputs: Vec::new(), errors: RefCell::default() }
    }

    fn add_pass(&mut self, pass: Pass) {
        match &mut self.replay {
            Some(replay) => replay.compare(pass),
            None => self.recording.passes.push(pass),
        }
    }

    /// Values of the output ports, in the order of the kind's ports; and the errors in the shaders of the node, with
    /// which its passes must not run.
    pub fn finish(self) -> (Vec<InputValue>, Vec<ShaderError>) {
        (self.outputs, self.errors.into_inner())
    }

    fn input_value(&self, port: &str) -> &'a InputValue {
        &self.context.inputs[self.context.kind.input_index(port)]
    }

    /// Returns whether something arrives at an optional input.
    pub fn wired(&self, port: &str) -> bool {
        !matches!(self.input_value(port), InputValue::Absent)
    }

    /// Returns whether the input is known to be zero everywhere.
    pub fn is_zero(&self, port: &str) -> bool {
        matches!(self.input_value(port), InputValue::Zero)
    }

    /// Returns whether the output is read.
    pub fn is_output_used(&self, port: &str) -> bool {
        self.use_of(port) != OutputUse::Unused
    }

    /// Returns whether more of a value than its x is read.
    pub fn is_whole_output_used(&self, port: &str) -> bool {
        self.use_of(port) == OutputUse::Whole
    }

    fn use_of(&self, port: &str) -> OutputUse {
        let index = self.context.kind.outputs.iter().position(|output| output.name == port);
        index.map_or(OutputUse::Unused, |index| self.context.used_outputs[index])
    }

    /// Declares that the state of this node stays as the first frame of a sequence makes it: in other frames its
    /// passes, and those that nobody else needs, do not run.
    pub fn initialize_once(&mut self) {
        self.recording.settled.insert(self.context.node.to_owned());
    }

    /// Returns whether the host changes the parameter while the plan runs. Then the passes must be the same at all its
    /// values, but for their uniforms.
    pub fn is_dynamic(&self, parameter: &str) -> bool {
        self.context.dynamic.contains(&self.context.kind.param_index(parameter))
    }

    /// The image or volume at an input; one black texel where the input is zero.
    pub fn image(&mut self, port: &str) -> ImageId {
        match self.input_value(port).clone() {
            InputValue::Image(image) => image,
            InputValue::Zero => self.black(),
            other => panic!("input `{port}` of `{}` is {other:?}, not an image", self.context.node),
        }
    }

    /// The levels of the pyramid at an input, finest first; one black texel where the input is zero.
    pub fn pyramid(&mut self, port: &str) -> Cow<'a, [ImageId]> {
        match self.input_value(port) {
            InputValue::Pyramid(levels) => levels.as_slice().into(),
            InputValue::Zero => vec![self.black()].into(),
            other => panic!("input `{port}` of `{}` is {other:?}, not a pyramid", self.context.node),
        }
    }

    /// The buffer of the table or value at an input.
    pub fn buffer(&self, port: &str) -> BufferId {
        match self.input_value(port) {
            InputValue::Buffer(buffer) => *buffer,
            other => panic!("input `{port}` of `{}` is {other:?}, not a buffer", self.context.node),
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
        self.context.frame_size
    }

    /// Capabilities of the device.
    pub fn caps(&self) -> &Caps {
        self.context.caps
    }

    /// Returns whether the reference is recorded, with every intermediate in 32 bits. Quality switches are set by the
    /// caller.
    pub fn exact(&self) -> bool {
        self.context.exact
    }

    /// The format that the file asks for this node's results.
    pub fn format(&self) -> Option<Format> {
        self.context.format
    }

    /// Color of the image at an input. Linear Rec.709, or sRGB for a port that accepts encoded images only, if nothing
    /// is known about it.
    pub fn color(&self, input: &str) -> ImageColor {
        let index = self.context.kind.input_index(input);
        let state = self.context.kind.inputs[index].states.first().copied().unwrap_or(ColorState::Scene);
        self.context.colors.inputs.get(index).copied().flatten().unwrap_or(ImageColor::of(state))
    }

    /// Color of the image at an output: for a node that maps light to a display, with the primaries of that display.
    pub fn output_color(&self, output: &str) -> ImageColor {
        let index = self.context.kind.output_index(output);
        let otherwise = || match &self.context.kind.outputs[index].state {
            OutputState::Always(state) => ImageColor::of(*state),
            OutputState::Same(input) => self.color(input),
            OutputState::Chosen(_) => self.color(&self.context.kind.inputs[0].name),
            OutputState::Nothing => ImageColor::of(ColorState::Data),
        };
        self.context.colors.outputs.get(index).copied().flatten().unwrap_or_else(otherwise)
    }

    /// Gives something to an output port.
    pub fn set_output(&mut self, port: &str, what: InputValue) {
        let index = self.context.kind.output_index(port);
        if let InputValue::Image(image) = what {
            let (desc, ty) = (self.desc(image), self.context.kind.outputs[index].ty);
            let fits = match ty {
                PortType::Multisampled => desc.samples > 1,
                _ => desc.is_plain(),
            };
            assert!(fits, "the output `{port}` of `{}` is a {}: {}", self.context.kind.name, ty.name(), shape(desc));
        }
        if let Some(output) = self.outputs.get_mut(index) {
            *output = what;
        }
    }

    /// Gives the next level of the pyramid of an output port, finest first.
    pub fn add_output_level(&mut self, port: &str, level: ImageId) {
        let index = self.context.kind.output_index(port);
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

    /// Reflection of a module; empty if it is wrong.
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

    fn pass_label(&self, label: impl Display) -> Label {
        match &self.replay {
            Some(replay) => replay.compared(label),
            None => Label::Own(label.to_string()),
        }
    }
}

/// Reflection of a wrong module.
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

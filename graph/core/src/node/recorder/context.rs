//! Context of a node that is recorded: its parameters and inputs, and what the planner knows of it.

use std::borrow::Cow;

use crate::node::color::ImageColor;
use crate::node::ports::{OutputState, OutputUse, Signature};
use crate::node::resource::{BlockId, BufferId, ImageId};
use crate::node::values::UniformValues;
use afterimage_base::caps::Caps;
use afterimage_base::image::{ColorState, Format, Size};
use afterimage_wgsl::UniformValue;

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

/// Context of a [`Recorder`](super::Recorder), from the planner.
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

impl<'a> RecorderContext<'a> {
    pub(super) fn input_value(&self, port: &str) -> &'a InputValue {
        &self.inputs[self.kind.input_index(port)]
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
        self.use_of(port) >= OutputUse::Whole
    }

    /// Returns whether the output is read as a mean of the picture: see
    /// [`Node::averages`](super::super::Node::averages).
    pub fn is_output_averaged(&self, port: &str) -> bool {
        self.use_of(port) == OutputUse::Mean
    }

    fn use_of(&self, port: &str) -> OutputUse {
        let index = self.kind.outputs.iter().position(|output| output.name == port);
        index.map_or(OutputUse::Unused, |index| self.used_outputs[index])
    }

    /// Returns whether the host changes the parameter while the plan runs. Then the passes must be the same at all its
    /// values, but for their uniforms.
    pub fn is_dynamic(&self, parameter: &str) -> bool {
        self.dynamic.contains(&self.kind.param_index(parameter))
    }

    /// The buffer of the table or value at an input.
    pub fn buffer(&self, port: &str) -> BufferId {
        match self.input_value(port) {
            InputValue::Buffer(buffer) => *buffer,
            other => panic!("input `{port}` of `{}` is {other:?}, not a buffer", self.node),
        }
    }

    /// Color of the image at an input. Linear Rec.709, or sRGB for a port that accepts encoded images only, if nothing
    /// is known about it.
    pub fn color(&self, input: &str) -> ImageColor {
        let index = self.kind.input_index(input);
        let state = self.kind.inputs[index].states.first().copied().unwrap_or(ColorState::Scene);
        self.colors.inputs.get(index).copied().flatten().unwrap_or(ImageColor::of(state))
    }

    /// Color of the image at an output: for a tone curve, with the primaries of the display.
    pub fn output_color(&self, output: &str) -> ImageColor {
        let index = self.kind.output_index(output);
        let otherwise = || match &self.kind.outputs[index].state {
            OutputState::Always(state) => ImageColor::of(*state),
            OutputState::Same(input) => self.color(input),
            OutputState::Chosen(_) => self.color(&self.kind.inputs[0].name),
            OutputState::Nothing => ImageColor::of(ColorState::Data),
        };
        self.colors.outputs.get(index).copied().flatten().unwrap_or_else(otherwise)
    }

    /// A number for a uniform: what the node computes, or else its parameter of that name.
    pub(super) fn number<'v>(&self, computed: &'v [(&str, UniformValue)], name: &str) -> Option<Cow<'v, UniformValue>> {
        let own = computed.iter().rev().find(|(known, _)| *known == name);
        own.map(|(_, value)| Cow::Borrowed(value)).or_else(|| self.parameters.get(name).map(Cow::Owned))
    }
}

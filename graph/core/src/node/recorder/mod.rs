//! The recorder: what a node uses to describe its passes as data. It cannot reach a device.

mod bindings;
mod compute;
mod context;
mod details;
mod draw;
mod draw_rules;
mod function;
mod recording;
mod replay;
mod resources;
mod shaders;
mod warp;

use std::borrow::Cow;
use std::fmt::Display;
use std::sync::Arc;

pub use compute::ComputePass;
pub use context::{InputValue, NodeColors, RecorderContext};
pub use draw::{AttachmentPass, DrawPass};
pub use function::FunctionPass;
pub use recording::{MisfitPixel, Recording};
pub use replay::Replay;
pub use warp::WarpPass;

use super::ports::PortType;
use super::resource::{BufferId, BufferLife, ImageId};
use afterimage_base::image::{Format, ImageDesc, Signedness};
use afterimage_wgsl::ShaderError;
use resources::{NodeResources, shape};
use shaders::NodeShaders;

/// Interface of a node's `record`: its parameters and inputs, and the recording to which it adds passes.
pub struct Recorder<'a> {
    context: RecorderContext<'a>,
    resources: NodeResources<'a>,
    /// None if it is recorded again: nobody reads them then.
    outputs: Vec<InputValue>,
    shaders: NodeShaders,
}

impl<'a> Recorder<'a> {
    /// A recorder that adds to `recording`.
    pub fn new(context: RecorderContext<'a>, recording: &'a mut Recording) -> Self {
        let outputs = vec![InputValue::Absent; context.kind.outputs.len()];
        let resources = NodeResources { node: context.node, recording, replay: None };
        Self { context, resources, outputs, shaders: NodeShaders::default() }
    }

    /// A recorder for a node that is recorded again at other values: passes are compared with those of before, and only
    /// their uniforms are made.
    pub fn again(context: RecorderContext<'a>, recording: &'a mut Recording, replay: &'a mut Replay) -> Self {
        replay.begin(recording);
        let resources = NodeResources { node: context.node, recording, replay: Some(replay) };
        Self { context, resources, outputs: Vec::new(), shaders: NodeShaders::default() }
    }

    /// Values of the output ports, in the order of the kind's ports; and the errors in the shaders of the node, with
    /// which its passes must not run.
    pub fn finish(self) -> (Vec<InputValue>, Vec<ShaderError>) {
        (self.outputs, self.shaders.into_errors())
    }

    /// Declares that the state of this node stays as the first frame of a sequence makes it: in other frames its
    /// passes, and those that nobody else needs, do not run.
    pub fn initialize_once(&mut self) {
        self.resources.recording.settled.insert(self.context.node.to_owned());
    }

    /// The image or volume at an input; one black texel where the input is zero.
    pub fn image(&mut self, port: &str) -> ImageId {
        match self.input_value(port).clone() {
            InputValue::Image(image) => image,
            InputValue::Zero => self.resources.black(),
            other => panic!("input `{port}` of `{}` is {other:?}, not an image", self.context.node),
        }
    }

    /// The levels of the pyramid at an input, finest first; one black texel where the input is zero.
    pub fn pyramid(&mut self, port: &str) -> Cow<'a, [ImageId]> {
        match self.input_value(port) {
            InputValue::Pyramid(levels) => levels.as_slice().into(),
            InputValue::Zero => vec![self.resources.black()].into(),
            other => panic!("input `{port}` of `{}` is {other:?}, not a pyramid", self.context.node),
        }
    }

    /// The size of a buffer.
    pub fn buffer_bytes(&self, buffer: BufferId) -> u64 {
        self.resources.recording.buffer(buffer).bytes
    }

    /// The description of an image.
    pub fn desc(&self, image: ImageId) -> ImageDesc {
        self.resources.recording.image(image).desc
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

    fn stored(&self, desc: ImageDesc, is_output: bool) -> ImageDesc {
        let asked = if is_output { self.context.format.unwrap_or(desc.format) } else { desc.format };
        // No device draws samples of four floats.
        let is_exact = self.context.exact && (desc.samples == 1 || asked.exact() != Format::Rgba32Float);
        desc.format(if is_exact { asked.exact() } else { asked })
    }

    /// An image between two passes of this node.
    pub fn transient(&mut self, name: impl Display, desc: ImageDesc) -> ImageId {
        let desc = self.stored(desc, false);
        self.resources.transient(name, desc, Signedness::Unsigned)
    }

    /// The same for numbers that may be negative, whatever the color states of the node's outputs are: such as motion.
    pub fn transient_signed(&mut self, name: impl Display, desc: ImageDesc) -> ImageId {
        let desc = self.stored(desc, false);
        self.resources.transient(name, desc, Signedness::Signed)
    }

    /// An image of this node that is made in the first frame, and again after a change of the uniforms of the passes that
    /// write it. They may read constants and images of this sort alone, and not the frame.
    pub fn retained(&mut self, name: impl Display, desc: ImageDesc) -> ImageId {
        let desc = self.stored(desc, false);
        self.resources.retained(name, desc)
    }

    /// An image that becomes a level of an output pyramid, or that is given to an output later.
    pub fn level(&mut self, name: impl Display, desc: ImageDesc) -> ImageId {
        let desc = self.stored(desc, true);
        self.resources.transient(name, desc, Signedness::Unsigned)
    }

    /// An image of an output port, to be written by a pass of this node.
    pub fn output(&mut self, port: &str, desc: ImageDesc) -> ImageId {
        let image = self.level(port, desc);
        self.set_output(port, InputValue::Image(image));
        image
    }

    /// An image whose texels are known now, in the format of `desc`.
    pub fn constant(&mut self, name: &str, desc: ImageDesc, bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>) -> ImageId {
        self.resources.constant(name, desc, bytes)
    }

    /// The same for texels that take long to compute. A plan may have a few such images, and it computes each once,
    /// also where a node is recorded several times until the sizes of histories settle: the bytes must not depend on
    /// sizes.
    pub fn computed(&mut self, name: &str, desc: ImageDesc, compute: impl FnOnce() -> Vec<u8>) -> ImageId {
        self.resources.computed(name, desc, compute)
    }

    /// A buffer of this node.
    pub fn add_buffer(&mut self, name: &str, bytes: u64, life: BufferLife) -> BufferId {
        self.resources.add_buffer(name, bytes, life)
    }

    /// A buffer whose contents are known now.
    pub fn constant_buffer(&mut self, name: &str, bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>) -> BufferId {
        self.resources.constant_buffer(name, bytes)
    }

    /// The table of an output port.
    pub fn output_table(&mut self, port: &str, bytes: u64, life: BufferLife) -> BufferId {
        let buffer = self.add_buffer(port, bytes, life);
        self.set_output(port, InputValue::Buffer(buffer));
        buffer
    }

    /// The value of an output port: one `vec4f`.
    pub fn output_value(&mut self, port: &str, life: BufferLife) -> BufferId {
        self.output_table(port, 16, life)
    }
}

impl<'a> std::ops::Deref for Recorder<'a> {
    type Target = RecorderContext<'a>;
    fn deref(&self) -> &Self::Target {
        &self.context
    }
}

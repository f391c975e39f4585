//! The images and buffers of a node.

use std::fmt::Display;
use std::sync::Arc;

use super::replay::is_label;
use super::{InputValue, Recorder};
use crate::node::resource::{BufferId, BufferLife, ImageId, Origin, VirtualBuffer, VirtualImage};
use afterimage_base::image::{Format, ImageDesc, Signedness, Size};

impl Recorder<'_> {
    pub(super) fn black(&mut self) -> ImageId {
        self.add_constant("black", ImageDesc::new(Size::new(1, 1)), [0; 8])
    }

    /// Returns whether the image stands for an input that is zero: it has one texel, whatever the size of the result
    /// is.
    pub(super) fn is_black(&self, image: ImageId) -> bool {
        let image = self.recording.image(image);
        let Origin::Constant(bytes) = &image.origin else { return false };
        image.desc.size.texels() == 1 && bytes.iter().all(|byte| *byte == 0)
    }

    fn stored(&self, desc: ImageDesc, is_output: bool) -> ImageDesc {
        let asked = if is_output { self.context.format.unwrap_or(desc.format) } else { desc.format };
        // No device draws samples of four floats.
        let is_exact = self.context.exact && (desc.samples == 1 || asked.exact() != Format::Rgba32Float);
        desc.format(if is_exact { asked.exact() } else { asked })
    }

    fn label(&self, what: impl Display) -> String {
        format!("{}.{what}", self.context.node)
    }

    fn add_transient(&mut self, name: impl Display, desc: ImageDesc, signedness: Signedness) -> ImageId {
        let node = self.context.node;
        let is_same = |known: &VirtualImage| {
            (known.desc, known.signedness) == (desc, signedness)
                && known.origin == Origin::Transient
                && is_label(&known.label, node, &name)
        };
        if let Some(known) = self.replay.as_mut().and_then(|replay| replay.image(self.recording, is_same)) {
            return known;
        }
        let (label, origin) = (self.label(name), Origin::Transient);
        self.recording.add_image(VirtualImage { label, desc, origin, finite: true, signedness })
    }

    fn add_constant(&mut self, name: &str, desc: ImageDesc, bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>) -> ImageId {
        let (node, given) = (self.context.node, bytes.as_ref());
        let is_same = |known: &VirtualImage| {
            known.desc == desc
                && matches!(&known.origin, Origin::Constant(old) if is_equal(old, given))
                && is_label(&known.label, node, name)
        };
        if let Some(known) = self.replay.as_mut().and_then(|replay| replay.image(self.recording, is_same)) {
            return known;
        }
        let (label, origin) = (self.label(name), Origin::Constant(bytes.into()));
        self.recording.add_image(VirtualImage { label, desc, origin, finite: true, signedness: Signedness::Unsigned })
    }

    /// An image between two passes of this node.
    pub fn transient(&mut self, name: impl Display, desc: ImageDesc) -> ImageId {
        let desc = self.stored(desc, false);
        self.add_transient(name, desc, Signedness::Unsigned)
    }

    /// The same for numbers that may be negative, whatever the color states of the node's outputs are: such as motion.
    pub fn transient_signed(&mut self, name: impl Display, desc: ImageDesc) -> ImageId {
        let desc = self.stored(desc, false);
        self.add_transient(name, desc, Signedness::Signed)
    }

    /// An image that becomes a level of an output pyramid, or that is given to an output later.
    pub fn level(&mut self, name: impl Display, desc: ImageDesc) -> ImageId {
        let desc = self.stored(desc, true);
        self.add_transient(name, desc, Signedness::Unsigned)
    }

    /// An image of an output port, to be written by a pass of this node.
    pub fn output(&mut self, port: &str, desc: ImageDesc) -> ImageId {
        let image = self.level(port, desc);
        self.set_output(port, InputValue::Image(image));
        image
    }

    /// An image whose texels are known now, in the format of `desc`.
    pub fn constant(&mut self, name: &str, desc: ImageDesc, bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>) -> ImageId {
        assert_eq!(
            bytes.as_ref().len() as u64,
            desc.bytes(),
            "`{}.{name}` has the bytes of its description",
            self.context.node
        );
        self.add_constant(name, desc, bytes)
    }

    /// The same for texels that take long to compute. A plan may have a few such images, and it computes each once,
    /// also where a node is recorded several times until the sizes of histories settle: the bytes must not depend on
    /// sizes.
    pub fn computed(&mut self, name: &str, desc: ImageDesc, compute: impl FnOnce() -> Vec<u8>) -> ImageId {
        let label = self.label(name);
        let computed: u64 = self.recording.computed.values().map(|bytes| bytes.len() as u64).sum();
        let has_room = self.recording.max_computed.is_none_or(|max| computed.saturating_add(desc.bytes()) <= max);
        let make = || if has_room { compute() } else { vec![0; desc.bytes() as usize] };
        let bytes = self.recording.computed.entry(label.clone()).or_insert_with(|| make().into()).clone();
        assert_eq!(bytes.len() as u64, desc.bytes(), "`{label}` has the bytes of its description");
        self.add_constant(name, desc, bytes)
    }

    /// A buffer of this node.
    pub fn add_buffer(&mut self, name: &str, bytes: u64, life: BufferLife) -> BufferId {
        let known = self.known_buffer(name, bytes, |known| *known == life);
        known.unwrap_or_else(|| self.new_buffer(name, bytes, life))
    }

    /// The buffer that is the same in the recording before.
    fn known_buffer(&mut self, name: &str, bytes: u64, lives: impl Fn(&BufferLife) -> bool) -> Option<BufferId> {
        let node = self.context.node;
        let is_same =
            |known: &VirtualBuffer| known.bytes == bytes && lives(&known.life) && is_label(&known.label, node, name);
        self.replay.as_mut().and_then(|replay| replay.buffer(self.recording, is_same))
    }

    fn new_buffer(&mut self, name: &str, bytes: u64, life: BufferLife) -> BufferId {
        let label = self.label(name);
        self.recording.add_buffer(VirtualBuffer { label, bytes, life })
    }

    /// A buffer whose contents are known now.
    pub fn constant_buffer(&mut self, name: &str, bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>) -> BufferId {
        let (given, length) = (bytes.as_ref(), bytes.as_ref().len() as u64);
        let same = |life: &BufferLife| matches!(life, BufferLife::Constant(old) if is_equal(old, given));
        let known = self.known_buffer(name, length, same);
        known.unwrap_or_else(|| self.new_buffer(name, length, BufferLife::Constant(bytes.into())))
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

/// Returns whether both have the same bytes. Large tables are often the same memory.
fn is_equal(old: &[u8], given: &[u8]) -> bool {
    std::ptr::eq(old, given) || old == given
}

//! The images and buffers of a node.

use std::fmt::Display;
use std::sync::Arc;

use super::details::Label;
use super::recording::Recording;
use super::replay::{Replay, is_label};
use crate::node::drawing::Subresource;
use crate::node::pass::Pass;
use crate::node::resource::{BufferId, BufferLife, ImageId, Origin, VirtualBuffer, VirtualImage};
use afterimage_base::image::{ImageDesc, Signedness, Size};

/// The images, buffers and passes of a node: those that it adds to a recording, or those of its recording before, as
/// long as they are equal.
pub(super) struct NodeResources<'a> {
    /// The node's name, with which their labels begin.
    pub(super) node: &'a str,
    pub(super) recording: &'a mut Recording,
    /// The node's recording of before, if it is recorded again for its uniforms.
    pub(super) replay: Option<&'a mut Replay>,
}

impl NodeResources<'_> {
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

    fn label(&self, what: impl Display) -> String {
        format!("{}.{what}", self.node)
    }

    pub(super) fn transient(&mut self, name: impl Display, desc: ImageDesc, signedness: Signedness) -> ImageId {
        self.add_image(name, desc, signedness, Origin::Transient)
    }

    /// An image that is made after a change of uniforms.
    pub(super) fn retained(&mut self, name: impl Display, desc: ImageDesc) -> ImageId {
        self.add_image(name, desc, Signedness::Unsigned, Origin::Retained)
    }

    fn add_image(&mut self, name: impl Display, desc: ImageDesc, signedness: Signedness, origin: Origin) -> ImageId {
        let node = self.node;
        let is_same = |known: &VirtualImage| {
            (known.desc, known.signedness) == (desc, signedness)
                && known.origin == origin
                && is_label(&known.label, node, &name)
        };
        if let Some(known) = self.replay.as_mut().and_then(|replay| replay.image(self.recording, is_same)) {
            return known;
        }
        let label = self.label(name);
        self.recording.add_image(VirtualImage { label, desc, origin, finite: true, signedness })
    }

    fn add_constant(&mut self, name: &str, desc: ImageDesc, bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>) -> ImageId {
        let (node, given) = (self.node, bytes.as_ref());
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

    pub(super) fn constant(
        &mut self,
        name: &str,
        desc: ImageDesc,
        bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>,
    ) -> ImageId {
        assert_eq!(
            bytes.as_ref().len() as u64,
            desc.bytes(),
            "`{}.{name}` has the bytes of its description",
            self.node
        );
        self.add_constant(name, desc, bytes)
    }

    pub(super) fn computed(&mut self, name: &str, desc: ImageDesc, compute: impl FnOnce() -> Vec<u8>) -> ImageId {
        let label = self.label(name);
        let computed: u64 = self.recording.computed.values().map(|bytes| bytes.len() as u64).sum();
        let has_room = self.recording.max_computed.is_none_or(|max| computed.saturating_add(desc.bytes()) <= max);
        let make = || if has_room { compute() } else { vec![0; desc.bytes() as usize] };
        let bytes = self.recording.computed.entry(label.clone()).or_insert_with(|| make().into()).clone();
        assert_eq!(bytes.len() as u64, desc.bytes(), "`{label}` has the bytes of its description");
        self.add_constant(name, desc, bytes)
    }

    pub(super) fn add_buffer(&mut self, name: &str, bytes: u64, life: BufferLife) -> BufferId {
        let known = self.known_buffer(name, bytes, |known| *known == life);
        known.unwrap_or_else(|| self.new_buffer(name, bytes, life))
    }

    /// The buffer that is the same in the recording before.
    fn known_buffer(&mut self, name: &str, bytes: u64, lives: impl Fn(&BufferLife) -> bool) -> Option<BufferId> {
        let node = self.node;
        let is_same =
            |known: &VirtualBuffer| known.bytes == bytes && lives(&known.life) && is_label(&known.label, node, name);
        self.replay.as_mut().and_then(|replay| replay.buffer(self.recording, is_same))
    }

    fn new_buffer(&mut self, name: &str, bytes: u64, life: BufferLife) -> BufferId {
        let label = self.label(name);
        self.recording.add_buffer(VirtualBuffer { label, bytes, life })
    }

    pub(super) fn constant_buffer(&mut self, name: &str, bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>) -> BufferId {
        let (given, length) = (bytes.as_ref(), bytes.as_ref().len() as u64);
        let same = |life: &BufferLife| matches!(life, BufferLife::Constant(old) if is_equal(old, given));
        let known = self.known_buffer(name, length, same);
        known.unwrap_or_else(|| self.new_buffer(name, length, BufferLife::Constant(bytes.into())))
    }

    /// A pass reads or draws a level and a layer that there is.
    pub(super) fn require_part(&self, part: Subresource, place: &str) {
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

    pub(super) fn add_pass(&mut self, pass: Pass) {
        match &mut self.replay {
            Some(replay) => replay.compare(pass),
            None => self.recording.passes.push(pass),
        }
    }

    pub(super) fn pass_label(&self, label: impl Display) -> Label {
        match &self.replay {
            Some(replay) => replay.compared(label),
            None => Label::Own(label.to_string()),
        }
    }
}

/// Samples, levels and layers of an image, for messages.
pub(super) fn shape(desc: ImageDesc) -> String {
    let count = |count: u32, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let [samples, levels, layers] = [(desc.samples, "sample"), (desc.levels, "level"), (desc.layers, "layer")]
        .map(|(number, what)| count(number, what));
    format!("its image has {samples}, {levels} and {layers}")
}

/// Returns whether both have the same bytes. Large tables are often the same memory.
fn is_equal(old: &[u8], given: &[u8]) -> bool {
    std::ptr::eq(old, given) || old == given
}

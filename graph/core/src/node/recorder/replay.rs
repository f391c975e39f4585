//! Replays of a recording at other parameter values.

use std::fmt::{self, Display, Write};
use std::ops::Range;

use super::details::{Bindings, FunctionDetails, Label};
use super::recording::Recording;
use crate::node::pass::Pass;
use crate::node::resource::{BufferId, ImageId, VirtualBuffer, VirtualImage};

/// Recording of a node. At other values of dynamic parameters it records the same but for its uniforms, so that a
/// second recording compares what it would build: where nothing differs, passes of functions and of compute kernels
/// allocate nothing.
#[derive(Clone, Debug)]
pub struct Replay {
    /// Its images and buffers, which the recording keeps.
    images: Range<usize>,
    buffers: Range<usize>,
    /// The passes without their uniforms.
    passes: Vec<Pass>,
    /// The uniforms of all kernels, in order: of the last recording.
    uniforms: Vec<Vec<u8>>,
    /// Number of images and buffers in the recording, with those of others.
    recorded: [usize; 2],
    next: Next,
    is_equal: bool,
    /// Vectors for what the next passes are described with.
    pub(super) function: FunctionDetails,
    pub(super) bindings: Bindings,
}

/// Index of the next one, counted from the node's first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Next {
    image: usize,
    buffer: usize,
    pass: usize,
    kernel: usize,
}

impl Replay {
    /// Takes the passes of a node out of a recording that has its passes alone. Its images and buffers, which come
    /// after these numbers of others, stay.
    pub fn new(recording: &mut Recording, [images, buffers]: [usize; 2]) -> Self {
        let mut passes = std::mem::take(&mut recording.passes);
        let uniforms: Vec<_> = take_uniforms(&mut passes).collect();
        Self {
            images: images..recording.images.len(),
            buffers: buffers..recording.buffers.len(),
            passes,
            uniforms,
            recorded: [0, 0],
            next: Next::default(),
            is_equal: true,
            function: FunctionDetails::default(),
            bindings: Bindings::default(),
        }
    }

    /// The number of kernels, each of which has a uniform, be it empty.
    pub fn kernels(&self) -> usize {
        self.uniforms.len()
    }

    /// The uniforms of the second recording, which is taken out of the recording again; `None` if it differs in
    /// anything else.
    pub fn finish(&mut self, recording: &mut Recording) -> Option<&[Vec<u8>]> {
        let [images, buffers] = self.recorded;
        recording.images.truncate(images);
        recording.buffers.truncate(buffers);
        let all = Next {
            image: self.images.len(),
            buffer: self.buffers.len(),
            pass: self.passes.len(),
            kernel: self.uniforms.len(),
        };
        (self.is_equal && self.next == all).then_some(self.uniforms.as_slice())
    }

    pub(super) fn begin(&mut self, recording: &Recording) {
        self.recorded = [recording.images.len(), recording.buffers.len()];
        self.next = Next::default();
        self.is_equal = true;
    }

    /// The image that comes next, if it is the same.
    pub(super) fn image(
        &mut self,
        recording: &Recording,
        is_same: impl FnOnce(&VirtualImage) -> bool,
    ) -> Option<ImageId> {
        let at = self.images.start + self.next.image;
        self.next.image += 1;
        let is_known = self.images.contains(&at) && is_same(&recording.images[at]);
        self.is_equal &= is_known;
        is_known.then_some(ImageId(at as u32))
    }

    /// The buffer that comes next, if it is the same.
    pub(super) fn buffer(
        &mut self,
        recording: &Recording,
        is_same: impl FnOnce(&VirtualBuffer) -> bool,
    ) -> Option<BufferId> {
        let at = self.buffers.start + self.next.buffer;
        self.next.buffer += 1;
        let is_known = self.buffers.contains(&at) && is_same(&recording.buffers[at]);
        self.is_equal &= is_known;
        is_known.then_some(BufferId(at as u32))
    }

    /// The pass that comes next, if it is as before.
    pub(super) fn expected(&self) -> Option<&Pass> {
        self.passes.get(self.next.pass)
    }

    /// The label of the pass that comes next, compared with this one.
    pub(super) fn compared(&self, label: impl Display) -> Label {
        Label::Compared(self.expected().is_some_and(|pass| is_text(&pass.label, label)))
    }

    /// Continues after a pass of one kernel. If the pass `is_same`, `write` overwrites its uniform and returns whether
    /// the length is the same.
    pub(super) fn step(&mut self, is_same: bool, write: impl FnOnce(&mut [u8]) -> bool) {
        let uniform = self.uniforms.get_mut(self.next.kernel);
        self.is_equal &= is_same && uniform.is_some_and(|uniform| write(uniform));
        self.next.pass += 1;
        self.next.kernel += 1;
    }

    /// Compares a pass that was built with the one that comes next, and continues after it.
    pub(super) fn compare(&mut self, pass: Pass) {
        let mut passes = [pass];
        let uniforms: Vec<Vec<u8>> = take_uniforms(&mut passes).collect();
        self.is_equal &= self.expected() == passes.first();
        for (uniform, before) in uniforms.into_iter().zip(self.uniforms.iter_mut().skip(self.next.kernel)) {
            self.is_equal &= uniform.len() == before.len();
            *before = uniform;
        }
        self.next.pass += 1;
        self.next.kernel += passes[0].kernels.len();
    }
}

fn take_uniforms(passes: &mut [Pass]) -> impl Iterator<Item = Vec<u8>> {
    let kernels = passes.iter_mut().flat_map(|pass| &mut pass.kernels);
    kernels.map(|kernel| std::mem::take(&mut kernel.uniform))
}

/// Returns whether something prints as this text, without a copy of it.
pub(super) fn is_text(text: &str, printed: impl Display) -> bool {
    let mut rest = Rest(text);
    write!(rest, "{printed}").is_ok() && rest.0.is_empty()
}

/// Returns whether something of a node has this label: `node.name`.
pub(super) fn is_label(label: &str, node: &str, name: impl Display) -> bool {
    let rest = label.strip_prefix(node).and_then(|rest| rest.strip_prefix('.'));
    rest.is_some_and(|rest| is_text(rest, name))
}

/// Remainder of a text to be printed.
struct Rest<'a>(&'a str);

impl Write for Rest<'_> {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        self.0 = self.0.strip_prefix(part).ok_or(fmt::Error)?;
        Ok(())
    }
}

//! What a node has recorded, to record it again at other values.

use super::recording::Recording;
use crate::node::pass::Pass;
use crate::node::resource::{VirtualBuffer, VirtualImage};

/// What a node has recorded. At other values of dynamic parameters it records the same but for its uniforms, so that a
/// second recording compares what it would build, and allocates little.
#[derive(Clone, Debug)]
pub struct Replay {
    images: Vec<VirtualImage>,
    buffers: Vec<VirtualBuffer>,
    /// The passes without their uniforms.
    passes: Vec<Pass>,
    /// The uniforms of all kernels, in order: of the last recording.
    uniforms: Vec<Vec<u8>>,
    /// How many images and buffers others had recorded before.
    before: [usize; 2],
    /// The next pass, and the next kernel.
    next: [usize; 2],
    is_equal: bool,
}

impl Replay {
    /// Takes a node out of a recording that has its passes alone, and these numbers of images and buffers of others.
    pub fn new(recording: &mut Recording, [images, buffers]: [usize; 2]) -> Self {
        let mut passes = std::mem::take(&mut recording.passes);
        let uniforms = take_uniforms(&mut passes).collect();
        Self {
            images: recording.images.split_off(images),
            buffers: recording.buffers.split_off(buffers),
            passes,
            uniforms,
            before: [images, buffers],
            next: [0, 0],
            is_equal: true,
        }
    }

    /// The number of kernels, each of which has a uniform, be it empty.
    pub fn kernels(&self) -> usize {
        self.uniforms.len()
    }

    /// The uniforms of the second recording, which is taken out of the recording again; `None` if it differs in
    /// anything else.
    pub fn finish(&mut self, recording: &mut Recording) -> Option<&[Vec<u8>]> {
        let [images, buffers] = self.before;
        let is_equal = self.is_equal
            && self.next == [self.passes.len(), self.uniforms.len()]
            && recording.images[images..] == self.images
            && recording.buffers[buffers..] == self.buffers;
        recording.images.truncate(images);
        recording.buffers.truncate(buffers);
        is_equal.then_some(self.uniforms.as_slice())
    }

    pub(super) fn begin(&mut self, recording: &Recording) {
        self.before = [recording.images.len(), recording.buffers.len()];
        self.next = [0, 0];
        self.is_equal = true;
    }

    /// The pass that comes next, if it is as before.
    pub(super) fn expected(&self) -> Option<&Pass> {
        self.passes.get(self.next[0])
    }

    /// Goes on behind a pass of one kernel: `pack` writes the uniform over the one of before, and says whether it has
    /// the same length. `None` stands for a pass that is another one.
    pub(super) fn step(&mut self, pack: Option<impl FnOnce(&mut [u8]) -> bool>) {
        let [pass, kernel] = self.next;
        self.is_equal &= match (pack, self.uniforms.get_mut(kernel)) {
            (Some(pack), Some(uniform)) => pack(uniform),
            _ => false,
        };
        self.next = [pass + 1, kernel + 1];
    }

    /// Goes on behind a pass that was built.
    pub(super) fn compare(&mut self, pass: Pass) {
        let mut passes = [pass];
        let uniforms: Vec<Vec<u8>> = take_uniforms(&mut passes).collect();
        let [at, kernel] = self.next;
        self.is_equal &= self.expected() == passes.first();
        for (uniform, before) in uniforms.into_iter().zip(self.uniforms.iter_mut().skip(kernel)) {
            self.is_equal &= uniform.len() == before.len();
            *before = uniform;
        }
        self.next = [at + 1, kernel + passes[0].kernels.len()];
    }
}

fn take_uniforms(passes: &mut [Pass]) -> impl Iterator<Item = Vec<u8>> {
    let kernels = passes.iter_mut().flat_map(|pass| &mut pass.kernels);
    kernels.map(|kernel| std::mem::take(&mut kernel.uniform))
}

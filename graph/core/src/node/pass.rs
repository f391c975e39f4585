//! Passes as data: kernels, the images that take their values, and how they run together.
//!
//! What a pass reads and writes, its shaders and its uniforms follow from its kernels and results alone. The kind is
//! for code generation, which writes the entry point, and for the stage of the planner that made it.

use afterimage_wgsl::Shader;
use afterimage_wgsl::limits::CompileCost;
use serde::Serialize;

use super::drawing::Drawing;
use super::kernel::{Arg, KernelCall, uniform_buffers};
use super::resource::{ImageId, Resource};

/// One dispatch or draw.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pass {
    /// The nodes it works for; more than one after fusion.
    pub nodes: Vec<String>,
    /// Label for people.
    pub label: String,
    /// Kernels in order.
    pub kernels: Vec<KernelCall>,
    /// The images that take the values of kernel functions. Compute entry points write through their arguments, and
    /// drawing passes into their attachments.
    pub results: Vec<PassResult>,
    /// Kind of the pass.
    pub kind: PassKind,
}

/// An image that takes the value of a kernel function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PassResult {
    /// The kernel, by its place in [`Pass::kernels`].
    pub kernel: usize,
    /// The image.
    pub image: ImageId,
}

/// Kind of a pass: the way in which its kernels run together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum PassKind {
    /// Functions of one pixel, each of which may use the values of those before it.
    Point,
    /// The same, but at least one function reads an image around the pixel.
    Gather,
    /// An image at half the size of its source, row by row.
    RowDownsample(RowDownsample),
    /// A function of one pixel whose invocations share the memory of workgroups with that many across and down.
    Workgroup([u32; 2]),
    /// A compute entry point that its author has written.
    Compute,
    /// A drawing pass: geometry, or what the host records, into attachments.
    Drawing(Box<Drawing>),
}

/// A halving by workgroups of one row of invocations that walk down the source.
///
/// At each step an invocation makes the four texels under one texel of the result with the kernels before the halving,
/// and gives them to the halving, the kernel of the first result, which shares what its neighbors need through
/// workgroup memory. So each texel of the source is made about once and never stored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RowDownsample {
    /// The struct in which an invocation keeps what it needs of the rows before, all zero at first.
    pub state: &'static str,
    /// Rows of the result that a workgroup makes.
    pub rows: u32,
    /// Columns and rows of the source beyond twice those of the result: 0 or 1. Where it is 1, the halving is given the
    /// means over halves of a texel of the result.
    pub odd: [u32; 2],
    /// The kernel that looks at the texels around its own, by its place in the pass, if one does: it is called in its
    /// form [by neighbors](super::ByNeighbors), and those before it make a texel.
    pub around: Option<usize>,
    /// True if the source is half of its nearest texel beyond its border, and not all of it.
    pub is_open: bool,
}

impl Pass {
    /// A pass of kernel functions, the last of which gives the texel of `image`.
    pub fn of_functions(nodes: Vec<String>, label: String, kernels: Vec<KernelCall>, image: ImageId) -> Self {
        let is_gather = kernels.iter().any(KernelCall::reads_texture);
        let kind = if is_gather { PassKind::Gather } else { PassKind::Point };
        let results = vec![PassResult { kernel: kernels.len().saturating_sub(1), image }];
        Self { nodes, label, kernels, results, kind }
    }

    /// The image of a pass of kernel functions that make it texel by texel; `None` for other kinds.
    pub fn function_result(&self) -> Option<ImageId> {
        let result = self.results.first().filter(|_| self.kind.is_drawable());
        result.map(|result| result.image)
    }

    /// Draws of a drawing pass.
    pub fn drawing(&self) -> Option<&Drawing> {
        match &self.kind {
            PassKind::Drawing(drawing) => Some(drawing),
            _ => None,
        }
    }

    /// The arguments of all kernels.
    pub fn args(&self) -> impl Iterator<Item = Arg> + '_ {
        self.kernels.iter().flat_map(|kernel| &kernel.args).map(|arg| arg.value)
    }

    /// Everything it reads, each once, in order of first mention.
    pub fn reads(&self) -> Vec<Resource> {
        let mut found = Vec::new();
        let drawn = self.drawing().into_iter().flat_map(Drawing::reads);
        for resource in self.args().filter_map(Arg::read).chain(drawn) {
            if !found.contains(&resource) {
                found.push(resource);
            }
        }
        found
    }

    /// Everything it writes.
    pub fn writes(&self) -> Vec<Resource> {
        let results = self.results.iter().map(|result| Resource::Image(result.image));
        let drawn = self.drawing().map(Drawing::images).unwrap_or_default().into_iter().map(Resource::Image);
        results.chain(drawn).chain(self.args().filter_map(Arg::written)).collect()
    }

    /// The first image that it writes.
    pub fn written_image(&self) -> Option<ImageId> {
        self.writes().into_iter().find_map(Resource::image)
    }

    /// Everything it reads and everything it writes; what it does both with is named twice.
    pub fn resources(&self) -> impl Iterator<Item = Resource> + use<> {
        self.reads().into_iter().chain(self.writes())
    }

    /// The modules that it is made of.
    pub fn shaders(&self) -> impl Iterator<Item = &Shader> + '_ {
        self.kernels.iter().map(|kernel| &*kernel.shader)
    }

    /// Cost of the compilation of its kernels.
    pub fn compile_cost(&self) -> CompileCost {
        self.kernels.iter().map(KernelCall::compile_cost).sum()
    }

    /// Uniform buffers that it binds, besides that of the frame's time and number.
    pub fn uniform_buffers(&self) -> usize {
        let has_own_entry = matches!(self.kind, PassKind::Compute | PassKind::Drawing(_));
        if has_own_entry { uniform_buffers(self.kernels.iter()) } else { Self::joined_uniform_buffers([self]) }
    }

    /// The same of passes of functions, after they have become one: its size is in a uniform buffer, too.
    pub fn joined_uniform_buffers<'a>(passes: impl IntoIterator<Item = &'a Self, IntoIter: Clone>) -> usize {
        1 + uniform_buffers(passes.into_iter().flat_map(|pass| &pass.kernels))
    }

    /// Its override constants.
    pub fn constants(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        self.kernels.iter().flat_map(|kernel| &kernel.constants).copied()
    }
}

impl PassKind {
    /// Returns whether a full-screen draw can make the result as well as a dispatch.
    pub fn is_drawable(&self) -> bool {
        matches!(self, Self::Point | Self::Gather)
    }

    /// Rows of a source that the pass reads, at least, above and below those that correspond to its result.
    pub fn min_halo(&self) -> u32 {
        if matches!(self, Self::RowDownsample(_)) { 2 } else { 1 }
    }
}

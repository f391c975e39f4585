//! A kernel in a pass: a function or a compute entry point, with what its arguments hold.

use std::collections::BTreeSet;

use afterimage_base::Shared;
use afterimage_base::image::Signedness;
use afterimage_wgsl::limits::CompileCost;
use afterimage_wgsl::{RegisterPressure, Shader};
use serde::{Serialize, Serializer};

use super::drawing::Subresource;
use super::resource::{BlockId, BufferId, ImageId, Resource};

/// A kernel function or a compute entry point, and what it is called with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KernelCall {
    /// The node it works for.
    pub node: String,
    /// The module.
    #[serde(serialize_with = "file_of")]
    pub shader: Shared<Shader>,
    /// The name of the function or of the entry point; of a drawing pass, the vertex entry point.
    pub function: Shared<str>,
    /// The arguments of a function in order, or the bindings of an entry point.
    pub args: Vec<Argument>,
    /// Bytes of its `params`; empty if it has none.
    #[serde(skip)]
    pub uniform: Vec<u8>,
    /// Workgroups of an entry point; `None` for a function, whose entry point the framework writes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub workgroups: Option<[u32; 3]>,
    /// Constants of the module that hold here: see [`FunctionPass::define`](super::FunctionPass::define).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub defines: Vec<&'static str>,
    /// Override constants of an entry point's module.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub constants: Vec<(&'static str, f64)>,
    /// The stride of the pixels that it reads, along each axis: 1 if it reads all.
    #[serde(skip)]
    pub stride: u32,
    /// The form by rows of a function, if it has one.
    #[serde(skip)]
    pub by_rows: Option<ByRows>,
    /// The form of a function that shares texels with the neighbors of its pixel, if it has one.
    #[serde(skip)]
    pub by_neighbors: Option<ByNeighbors>,
    /// The form of a function that needs no more than the four texels under its own: a function of the same module,
    /// `fn name(square: Square) -> vec4f`. The result has half the size of the only image that it reads.
    #[serde(skip)]
    pub quad_variant: Option<&'static str>,
    /// The limits of a function's result, if it may make numbers that are not finite: those of untrusted shaders may.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limited: Option<Signedness>,
    /// Identity of a kernel whose uniform gets new values while a plan runs.
    #[serde(skip)]
    pub origin: Option<KernelOrigin>,
    /// Its part in a warp, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warp: Option<WarpPart>,
}

fn file_of<S: Serializer>(shader: &Shared<Shader>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(shader.file())
}

/// The part of a function in a warp: a pass that reads an image at places that functions compute. A warp makes the
/// value at any place of its result, also between pixels, so two warps become one that reads the image once for each
/// place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum WarpPart {
    /// Computes the uv of a place in x and y, from a place and what textures show there.
    Place,
    /// Reads an image at a place.
    Tap,
    /// Combines taps.
    Join,
}

/// Identity of a kernel, which fusion keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum KernelOrigin {
    /// A kernel of a node.
    Node {
        /// The index of the node in the graph.
        node: usize,
        /// Number of kernels that the node records before it.
        kernel: usize,
    },
    /// The one that crops the host's image of an input, by the index of the input in the graph.
    Input(usize),
}

/// An argument of a kernel function or a binding of an entry point.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Argument {
    /// The name in the module.
    pub name: String,
    /// Its value.
    pub value: Arg,
}

/// Value of an argument of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Arg {
    /// The value of an earlier kernel of the same pass, by its place in the pass.
    Kernel(usize),
    /// Of an earlier kernel of the same pass, by its place in the pass: 1 if its value is not finite, and 1 if a loop
    /// was ended in it.
    Faults(usize),
    /// This pixel of an image of the result's size.
    Pixel(ImageId),
    /// An image, read anywhere.
    Texture(ImageId),
    /// One mip level of one layer of an image, read anywhere.
    Level(Subresource),
    /// The four texels under one texel of the result of a [`RowDownsample`](super::RowDownsample), from the kernels
    /// before.
    Square,
    /// The same four texels as an earlier kernel of the same pass makes them, by its place in the pass.
    SquareOf(usize),
    /// Values of the texels around one in a pass by rows: see [`ByNeighbors`].
    Around,
    /// An image that the kernel writes.
    Storage(ImageId),
    /// A storage buffer, and whether the kernel writes it, too.
    Buffer(BufferId, bool),
    /// The linear, clamping sampler of the argument before.
    Sampler,
    /// The first components of a value.
    Value(BufferId, u8),
    /// Zero, with this many components.
    Zero(u8),
    /// The pixel's place.
    Point,
    /// The place that an earlier kernel of the same pass computes, by its place in the pass: see [`WarpPart::Place`].
    PointOf(usize),
    /// The frame's time.
    Frame,
    /// The place in a workgroup, in a pass of the kind [`Workgroup`](super::PassKind::Workgroup).
    Invocation,
    /// A struct of numbers from the host.
    Block(BlockId),
    /// The kernel's uniform.
    Params,
}

/// The form by rows of a function that halves an image.
///
/// It is called by all invocations of the workgroup, once for the row above its first and then for each row and the one
/// below its last, with the texels under one texel of that row; the result of a call is the texel of the row before. It
/// may wait for the others (`workgroupBarrier`), and takes no parameters:
/// `fn name(state: ptr<function, State>, square: Square, invocation: u32) -> vec4f`.
///
/// Where a side of the source is odd, 2m + 1 texels for m of the result, it is given the means over 2m equal parts in
/// the place of texels: so the filter must be a sum of boxes that begin and end at halves of a texel of the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByRows {
    /// The module.
    pub shader: &'static Shader,
    /// The function's name.
    pub function: &'static str,
    /// The struct in which an invocation keeps what it needs of the rows before, all zero at first.
    pub state: &'static str,
    /// Distance of the outermost taps from the center, in texels of the source.
    pub reach: f32,
    /// True if the source is half of its nearest texel beyond its border, and not all of it.
    pub is_open: bool,
}

/// The form of a function that reads one image of the size of its result no further than one texel from its pixel, of
/// the eight texels there not more than a number each, and changes few texels: with it a pass by rows makes each texel
/// once, and those around it again only where it may change.
///
/// The functions are in the module of the function, which imports `neighbors`:
///
/// - `fn NUMBER(texel: vec4f) -> f32`, of any texel;
/// - `fn CHANGES(source: vec4f, around: Around) -> bool`, false only if the function does not change a texel with these
///   numbers around it, and does not with other numbers in place of those that are 0, either;
/// - `fn FUNCTION(source: vec4f, around: Around, ...) -> vec4f`, whose other arguments are those of the function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ByNeighbors {
    /// The argument that is the image, and the texel in this form.
    pub source: &'static str,
    /// The number of a texel.
    pub number: &'static str,
    /// True if the function may change a texel.
    pub changes: &'static str,
    /// The function of a texel and of the numbers around it.
    pub function: &'static str,
}

impl KernelCall {
    /// A call of a function without a uniform, defines or other forms.
    pub fn function(
        node: &str,
        shader: impl Into<Shared<Shader>>,
        function: impl Into<Shared<str>>,
        args: &[(&str, Arg)],
    ) -> Self {
        let argument = |(name, value): &(&str, Arg)| Argument { name: (*name).to_owned(), value: *value };
        Self {
            node: node.to_owned(),
            shader: shader.into(),
            function: function.into(),
            args: args.iter().map(argument).collect(),
            uniform: Vec::new(),
            workgroups: None,
            defines: Vec::new(),
            constants: Vec::new(),
            stride: 1,
            by_rows: None,
            by_neighbors: None,
            quad_variant: None,
            limited: None,
            origin: None,
            warp: None,
        }
    }

    /// Returns whether an argument holds this.
    pub fn accepts(&self, value: Arg) -> bool {
        self.args.iter().any(|arg| arg.value == value)
    }

    /// Returns whether to compute its result again takes longer than to store it and to read it again.
    pub fn is_heavy(&self) -> bool {
        self.shader.is_heavy(&self.function)
    }

    /// Register pressure of the function.
    pub fn register_pressure(&self) -> RegisterPressure {
        self.shader.register_pressure(&self.function)
    }

    /// Cost of its compilation.
    pub fn compile_cost(&self) -> CompileCost {
        self.shader.compile_cost(&self.function)
    }

    /// The images that it reads as textures.
    pub fn textures(&self) -> impl Iterator<Item = ImageId> + '_ {
        self.args.iter().filter_map(|arg| match arg.value {
            Arg::Texture(image) | Arg::Level(Subresource { image, .. }) => Some(image),
            _ => None,
        })
    }

    /// Returns whether it reads an image around the pixel.
    pub fn reads_texture(&self) -> bool {
        self.textures().next().is_some()
    }

    /// The kernel in a pass where `earlier` kernels stand before the ones that it knows, with `new` in the place of
    /// every argument that holds `old`.
    pub fn moved(mut self, earlier: usize, old: Option<Arg>, new: Arg) -> Self {
        for arg in &mut self.args {
            arg.value = match arg.value {
                value if old == Some(value) => new,
                Arg::Kernel(kernel) => Arg::Kernel(earlier + kernel),
                Arg::PointOf(kernel) => Arg::PointOf(earlier + kernel),
                Arg::Faults(kernel) => Arg::Faults(earlier + kernel),
                Arg::SquareOf(kernel) => Arg::SquareOf(earlier + kernel),
                value => value,
            };
        }
        self
    }

    /// Value of the argument of that name.
    pub fn arg(&self, name: &str) -> Option<Arg> {
        self.args.iter().find(|arg| arg.name == name).map(|arg| arg.value)
    }
}

/// Uniform buffers that a pass of these kernels binds for their parameters and host blocks. A block is bound once for
/// each struct that it is read as: files that are not trusted have structs of their own.
pub(super) fn uniform_buffers<'a>(kernels: impl Iterator<Item = &'a KernelCall> + Clone) -> usize {
    let file = |kernel: &'a KernelCall| kernel.shader.is_untrusted().then(|| kernel.shader.file());
    let reads =
        |kernel: &'a KernelCall| kernel.args.iter().filter_map(move |arg| Some((arg.value.block()?, file(kernel))));
    let blocks: BTreeSet<_> = kernels.clone().flat_map(reads).collect();
    let has_params = kernels.into_iter().any(|kernel| !kernel.uniform.is_empty());
    usize::from(has_params) + blocks.len()
}

impl Arg {
    /// Resources that it reads.
    pub fn read(self) -> Option<Resource> {
        match self {
            Self::Pixel(image) | Self::Texture(image) | Self::Level(Subresource { image, .. }) => {
                Some(Resource::Image(image))
            }
            Self::Value(buffer, _) | Self::Buffer(buffer, _) => Some(Resource::Buffer(buffer)),
            _ => None,
        }
    }

    /// The host block that it reads.
    pub fn block(self) -> Option<BlockId> {
        match self {
            Self::Block(block) => Some(block),
            _ => None,
        }
    }

    /// Resources that it writes.
    pub fn written(self) -> Option<Resource> {
        match self {
            Self::Storage(image) => Some(Resource::Image(image)),
            Self::Buffer(buffer, true) => Some(Resource::Buffer(buffer)),
            _ => None,
        }
    }
}

//! Drawing passes: geometry, or what the host records.

use super::Recorder;
use super::details::{Bindings, Bound};
use super::draw_rules::check;
use crate::node::blend::{Blend, WriteMask};
use crate::node::drawing::{ColorAttachment, DepthAttachment, DepthTest, DrawContents, Drawing, Load, Subresource};
use crate::node::geometry::{DrawRange, Draws, Geometry, IndirectDraws, Raster, VertexBuffer, VertexFormat};
use crate::node::kernel::KernelCall;
use crate::node::pass::{Pass, PassKind};
use crate::node::resource::{BufferId, ImageId, Resource};
use afterimage_base::Shared;
use afterimage_wgsl::{Shader, UniformValue};

/// A pass that draws geometry, while it is being described.
pub struct DrawPass<'r, 'a> {
    recorder: &'r mut Recorder<'a>,
    shader: Shared<Shader>,
    vertex: Shared<str>,
    label: String,
    bindings: Bindings,
    targets: Targets,
    fragment: Option<Shared<str>>,
    vertices: Vec<VertexBuffer>,
    indices: Option<BufferId>,
    raster: Raster,
}

/// A pass that only clears its attachments, or that the host fills with draws, while it is being described.
pub struct AttachmentPass<'r, 'a> {
    recorder: &'r mut Recorder<'a>,
    label: String,
    targets: Targets,
    contents: DrawContents,
}

/// The attachments of a pass.
#[derive(Default)]
struct Targets {
    colors: Vec<ColorAttachment>,
    depth: Option<DepthAttachment>,
}

impl Targets {
    fn add_color(&mut self, target: Subresource, load: Load<[f64; 4]>) {
        self.colors.push(ColorAttachment { target, load, blend: Blend::REPLACE, writes: WriteMask::ALL });
    }
}

impl<'a> Recorder<'a> {
    /// A pass that draws geometry: a vertex entry point of a module, and usually a fragment entry point of the same
    /// module. Its bindings are the inputs of the same names, unless `bind` gives something else.
    pub fn draw(&mut self, shader: impl Into<Shared<Shader>>, vertex: impl Into<Shared<str>>) -> DrawPass<'_, 'a> {
        let (shader, vertex) = (shader.into(), vertex.into());
        let (label, bindings) = (vertex.to_string(), Bindings::default());
        DrawPass {
            recorder: self,
            shader,
            vertex,
            label,
            bindings,
            targets: Targets::default(),
            fragment: None,
            vertices: Vec::new(),
            indices: None,
            raster: Raster::default(),
        }
    }

    /// A pass that clears its attachments and draws nothing.
    pub fn clear(&mut self, label: impl Into<String>) -> AttachmentPass<'_, 'a> {
        self.attachments(label.into(), DrawContents::Nothing)
    }

    /// A pass whose draws the host records, by the name of the node: what it draws with is opaque. A node has one such
    /// pass at most.
    pub fn host_draw(&mut self, label: impl Into<String>) -> AttachmentPass<'_, 'a> {
        self.attachments(label.into(), DrawContents::Host)
    }

    fn attachments(&mut self, label: String, contents: DrawContents) -> AttachmentPass<'_, 'a> {
        AttachmentPass { recorder: self, label, targets: Targets::default(), contents }
    }

    fn record_drawing(&mut self, label: String, kernel: Option<KernelCall>, drawing: Drawing) {
        let nodes = vec![self.context.node.to_owned()];
        let kernels = kernel.into_iter().collect();
        let pass = Pass { nodes, label, kernels, results: Vec::new(), kind: PassKind::Drawing(Box::new(drawing)) };
        // What is recorded again equals a pass that was checked, or is dropped.
        if self.resources.replay.is_none() {
            if !self.shaders.has_errors() {
                check(&pass, self.resources.recording);
            }
            for image in pass.drawing().into_iter().flat_map(Drawing::unbounded) {
                self.resources.recording.images[image.0 as usize].finite = false;
            }
        }
        self.resources.add_pass(pass);
    }
}

impl DrawPass<'_, '_> {
    /// Label for people; the vertex entry point's name by default.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// The fragment entry point. Without one, only depth is drawn.
    pub fn fragment(mut self, entry: impl Into<Shared<str>>) -> Self {
        self.fragment = Some(entry.into());
        self
    }

    /// The next attachment for color: an image, or one of its levels and layers. The fragment entry point's
    /// `@location`s count the attachments.
    pub fn color(mut self, target: impl Into<Subresource>, load: Load<[f64; 4]>) -> Self {
        self.targets.add_color(target.into(), load);
        self
    }

    /// Blending into the attachment that was added last; [`Blend::REPLACE`] by default.
    ///
    /// # Panics
    /// Before the first attachment for color.
    pub fn blend(mut self, blend: Blend) -> Self {
        self.last_color().blend = blend;
        self
    }

    /// The channels that are written of the attachment that was added last; all by default.
    ///
    /// # Panics
    /// Before the first attachment for color.
    pub fn writes(mut self, mask: WriteMask) -> Self {
        self.last_color().writes = mask;
        self
    }

    fn last_color(&mut self) -> &mut ColorAttachment {
        let label = &self.label;
        let last = self.targets.colors.last_mut();
        last.unwrap_or_else(|| panic!("the drawing pass `{label}` has no attachment for color yet"))
    }

    /// The attachment for depth.
    pub fn depth(mut self, target: impl Into<Subresource>, test: DepthTest) -> Self {
        self.targets.depth = Some(DepthAttachment { target: target.into(), test });
        self
    }

    /// A buffer with the next arguments of the vertex entry point, of each vertex: 32 bits a number (but
    /// [`VertexFormat::Unorm8x4`]), without gaps, at successive `@location`s.
    pub fn vertices(self, buffer: BufferId, formats: &[VertexFormat]) -> Self {
        self.attributes(buffer, formats, false)
    }

    /// The same for arguments of each instance.
    pub fn instances(self, buffer: BufferId, formats: &[VertexFormat]) -> Self {
        self.attributes(buffer, formats, true)
    }

    fn attributes(mut self, buffer: BufferId, formats: &[VertexFormat], per_instance: bool) -> Self {
        self.vertices.push(VertexBuffer { buffer, per_instance, formats: formats.to_vec() });
        self
    }

    /// A buffer with the numbers of the vertices, 32 bits each.
    pub fn indices(mut self, buffer: BufferId) -> Self {
        self.indices = Some(buffer);
        self
    }

    /// Rasterization state.
    pub fn raster(mut self, raster: Raster) -> Self {
        self.raster = raster;
        self
    }

    /// An image for a variable.
    pub fn image(mut self, variable: &'static str, image: ImageId) -> Self {
        self.bindings.bound.push((variable, Bound::Resource(Resource::Image(image))));
        self
    }

    /// A mip level of a layer of an image for a variable.
    pub fn level(mut self, variable: &'static str, part: Subresource) -> Self {
        self.bindings.bound.push((variable, Bound::Level(part)));
        self
    }

    /// A buffer for a variable, which only reads it.
    pub fn buffer(mut self, variable: &'static str, buffer: BufferId) -> Self {
        self.bindings.bound.push((variable, Bound::Resource(Resource::Buffer(buffer))));
        self
    }

    /// A number that the node computes for its uniform; replaces a parameter of the same name.
    pub fn set(mut self, name: &'static str, value: impl Into<UniformValue>) -> Self {
        self.bindings.computed.push((name, value.into()));
        self
    }

    /// Records the pass with these numbers of vertices (of indices, if it has some) and of instances.
    ///
    /// # Panics
    /// Where attachments, entry points and buffers do not fit together; the message states which.
    pub fn record(self, count: u32, instances: u32) {
        self.record_draws(Draws::Ranges(vec![DrawRange::new(count, instances)]));
    }

    /// Records the pass with several ranges of vertices (of indices, if it has some), drawn one after the other.
    ///
    /// # Panics
    /// As [`record`](Self::record).
    pub fn record_ranges(self, ranges: impl Into<Vec<DrawRange>>) {
        self.record_draws(Draws::Ranges(ranges.into()));
    }

    /// Records the pass with ranges that a buffer holds, which a pass before writes. A kernel must keep its numbers
    /// within the buffers of vertices and indices; the first instance is 0 unless the device has
    /// [`indirect_first_instance`](afterimage_base::caps::Caps::indirect_first_instance).
    ///
    /// # Panics
    /// As [`record`](Self::record).
    pub fn record_indirect(self, draws: IndirectDraws) {
        self.record_draws(Draws::Indirect(draws));
    }

    fn record_draws(self, draws: Draws) {
        let Self { recorder, shader, vertex, label, bindings, targets, fragment, vertices, indices, raster } = self;
        let kernel = bindings.call(recorder, shader, vertex);
        let geometry = Geometry { fragment, vertices, indices, draws, raster };
        let contents = DrawContents::Geometry(Box::new(geometry));
        let Targets { colors, depth } = targets;
        recorder.record_drawing(label, Some(kernel), Drawing { colors, depth, contents });
    }
}

impl AttachmentPass<'_, '_> {
    /// The next attachment for color.
    pub fn color(mut self, target: impl Into<Subresource>, load: Load<[f64; 4]>) -> Self {
        self.targets.add_color(target.into(), load);
        self
    }

    /// The attachment for depth.
    pub fn depth(mut self, target: impl Into<Subresource>, test: DepthTest) -> Self {
        self.targets.depth = Some(DepthAttachment { target: target.into(), test });
        self
    }

    /// Records the pass. Nobody knows what numbers a host draws, so its images are sanitized where they are read.
    ///
    /// # Panics
    /// Where the attachments do not fit together; the message states which.
    pub fn record(self) {
        let Self { recorder, label, targets: Targets { colors, depth }, contents } = self;
        recorder.record_drawing(label, None, Drawing { colors, depth, contents });
    }
}

//! A pass around a compute entry point.

use super::Recorder;
use super::bindings::{Bindings, Bound};
use crate::node::drawing::Subresource;
use crate::node::kernel::{ByCells, KernelCall};
use crate::node::pass::{Pass, PassKind};
use crate::node::resource::{BufferId, ImageId, Resource};
use afterimage_base::Shared;
use afterimage_wgsl::{Shader, UniformValue};

/// A pass around a compute entry point that is being described.
pub struct ComputePass<'r, 'a> {
    recorder: &'r mut Recorder<'a>,
    shader: Shared<Shader>,
    entry: Shared<str>,
    label: String,
    bindings: Bindings<'a>,
    constants: Vec<(&'static str, f64)>,
    by_cells: Option<ByCells>,
}

impl<'a> Recorder<'a> {
    /// A pass around a compute entry point. Its bindings are the inputs of the same names, unless `bind` gives
    /// something else.
    pub fn compute(&mut self, shader: impl Into<Shared<Shader>>, entry: impl Into<Shared<str>>) -> ComputePass<'_, 'a> {
        let (shader, entry) = (shader.into(), entry.into());
        let (label, bindings) = (entry.to_string(), Bindings::new(self));
        ComputePass { recorder: self, shader, entry, label, bindings, constants: Vec::new(), by_cells: None }
    }
}

impl ComputePass<'_, '_> {
    /// What the pass does, for people; the entry point's name by default.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    /// What a variable of the module holds when it is not an input of the same name.
    pub fn bind(mut self, variable: &'static str, resource: Resource) -> Self {
        self.bindings.bind(variable, Bound::Resource(resource));
        self
    }

    /// An image for a variable.
    pub fn image(self, variable: &'static str, image: ImageId) -> Self {
        self.bind(variable, Resource::Image(image))
    }

    /// A mip level of a layer of an image for a variable.
    pub fn level(mut self, variable: &'static str, part: Subresource) -> Self {
        self.bindings.bind(variable, Bound::Level(part));
        self
    }

    /// A buffer for a variable.
    pub fn buffer(self, variable: &'static str, buffer: BufferId) -> Self {
        self.bind(variable, Resource::Buffer(buffer))
    }

    /// A number that the node computes for its uniform; replaces a parameter of the same name.
    pub fn set(mut self, name: &'static str, value: impl Into<UniformValue>) -> Self {
        self.bindings.set(name, value.into());
        self
    }

    /// An override constant of the module.
    pub fn constant(mut self, name: &'static str, value: f64) -> Self {
        self.constants.push((name, value));
        self
    }

    /// A second form of a kernel that reduces an image over the cells of a lattice, for passes that read the image for
    /// several such kernels: see [`ByCells`]. Its results must be those of the kernel, to rounding. A kernel with
    /// override constants stays alone.
    pub fn by_cells(mut self, form: Option<ByCells>) -> Self {
        self.by_cells = form;
        self
    }

    /// Records the pass with this number of workgroups.
    pub fn dispatch(self, groups: [u32; 3]) {
        let Self { recorder, shader, entry, label, bindings, constants, by_cells } = self;
        let (args, uniform) = bindings.arguments(recorder, &shader, &entry);
        let kernel = KernelCall {
            args,
            uniform,
            workgroups: Some(groups),
            constants,
            by_cells,
            ..KernelCall::function(recorder.node, shader, entry, &[])
        };
        let nodes = vec![recorder.node.to_owned()];
        recorder.add_pass(Pass { nodes, label, kernels: vec![kernel], results: Vec::new(), kind: PassKind::Compute });
    }
}

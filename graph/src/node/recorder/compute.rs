//! A pass around a compute entry point.

use super::{Arrival, Recorder};
use crate::node::kernel::{Arg, Argument, ByCells, KernelCall};
use crate::node::pass::{Pass, PassKind};
use crate::node::resource::{BufferId, ImageId, Resource};
use afterimage_base::Shared;
use afterimage_wgsl::{GlobalKind, Shader, UniformValue};

/// A pass around a compute entry point that is being described.
pub struct ComputePass<'r, 'a> {
    pub(super) recorder: &'r mut Recorder<'a>,
    pub(super) shader: Shared<Shader>,
    pub(super) entry: Shared<str>,
    pub(super) label: String,
    pub(super) bound: Vec<(&'static str, Resource)>,
    /// The parameters, and after them what the node computes.
    pub(super) uniform: Vec<(&'a str, UniformValue)>,
    pub(super) constants: Vec<(&'static str, f64)>,
    pub(super) by_cells: Option<ByCells>,
}

impl<'a> Recorder<'a> {
    /// A pass around a compute entry point. Its bindings are the inputs of the same names, unless `bind` gives
    /// something else.
    pub fn compute(&mut self, shader: impl Into<Shared<Shader>>, entry: impl Into<Shared<str>>) -> ComputePass<'_, 'a> {
        let (shader, entry) = (shader.into(), entry.into());
        let (label, uniform) = (entry.to_string(), self.parameters.clone());
        ComputePass {
            recorder: self,
            shader,
            entry,
            label,
            bound: Vec::new(),
            uniform,
            constants: Vec::new(),
            by_cells: None,
        }
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
        self.bound.push((variable, resource));
        self
    }

    /// An image for a variable.
    pub fn image(self, variable: &'static str, image: ImageId) -> Self {
        self.bind(variable, Resource::Image(image))
    }

    /// A buffer for a variable.
    pub fn buffer(self, variable: &'static str, buffer: BufferId) -> Self {
        self.bind(variable, Resource::Buffer(buffer))
    }

    /// A number that the node computes for its uniform; replaces a parameter of the same name.
    pub fn set(mut self, name: &'static str, value: impl Into<UniformValue>) -> Self {
        self.uniform.push((name, value.into()));
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
        let reflection = self.recorder.reflection(&self.shader);
        let mut args = Vec::new();
        let mut uniform = Ok(Vec::new());
        for global in &reflection.globals {
            if let Some(value) = self.block(&global.name) {
                args.push(Argument { name: global.name.clone(), value });
                continue;
            }
            match &global.kind {
                GlobalKind::Uniform(ty) => uniform = reflection.pack(ty, &self.uniform),
                kind => args.extend(self.resource(&global.name).map(|held| {
                    self.require_one_sample(&global.name, held);
                    argument(&global.name, kind, held)
                })),
            }
        }
        let uniform = uniform.unwrap_or_else(|why| panic!("{:?}: {why}", self.shader));
        let Self { recorder, shader, entry, label, constants, by_cells, .. } = self;
        let kernel = KernelCall {
            args,
            uniform,
            workgroups: Some(groups),
            constants,
            by_cells,
            ..KernelCall::function(recorder.node, shader, entry, &[])
        };
        let nodes = vec![recorder.node.to_owned()];
        recorder.recording.passes.push(Pass {
            nodes,
            label,
            kernels: vec![kernel],
            results: Vec::new(),
            kind: PassKind::Compute,
        });
    }

    /// The host block at the input of that name.
    fn block(&self, name: &str) -> Option<Arg> {
        let index = self.recorder.kind.inputs.iter().position(|input| input.name == name)?;
        match self.recorder.arrivals[index] {
            Arrival::Block(block) => Some(Arg::Block(block)),
            _ => None,
        }
    }

    fn require_one_sample(&self, name: &str, held: Resource) {
        let samples = held.image().map_or(1, |image| self.recorder.desc(image).samples);
        assert!(samples == 1, "`{name}` of `{}` has {samples} samples: functions alone read these", self.entry);
    }

    fn resource(&self, name: &str) -> Option<Resource> {
        let bound = self.bound.iter().find(|(variable, _)| *variable == name).map(|(_, resource)| *resource);
        bound.or_else(|| {
            let index = self.recorder.kind.inputs.iter().position(|input| input.name == name)?;
            match &self.recorder.arrivals[index] {
                Arrival::Image(image) => Some(Resource::Image(*image)),
                Arrival::Buffer(buffer) => Some(Resource::Buffer(*buffer)),
                _ => None,
            }
        })
    }
}

fn argument(name: &str, kind: &GlobalKind, held: Resource) -> Argument {
    let value = match (held, kind) {
        (Resource::Image(image), GlobalKind::StorageTexture(_)) => Arg::Storage(image),
        (Resource::Image(image), _) => Arg::Texture(image),
        (Resource::Buffer(buffer), kind) => Arg::Buffer(buffer, matches!(kind, GlobalKind::Buffer(true))),
    };
    Argument { name: name.to_owned(), value }
}

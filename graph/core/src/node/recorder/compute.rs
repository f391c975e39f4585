//! A pass around a compute entry point.

use std::fmt::Display;

use super::Recorder;
use super::bindings::params;
use super::details::{Bindings, Bound, Label};
use crate::node::drawing::Subresource;
use crate::node::kernel::KernelCall;
use crate::node::pass::{Pass, PassKind};
use crate::node::resource::{BufferId, ImageId, Resource};
use afterimage_base::Shared;
use afterimage_wgsl::{Shader, UniformValue};

/// A pass around a compute entry point that is being described.
pub struct ComputePass<'r, 'a> {
    recorder: &'r mut Recorder<'a>,
    shader: Shared<Shader>,
    entry: Shared<str>,
    label: Label,
    bindings: Bindings,
    stride: u32,
}

impl<'a> Recorder<'a> {
    /// A pass around a compute entry point. Its bindings are the inputs of the same names, unless `bind` gives
    /// something else.
    pub fn compute(&mut self, shader: impl Into<Shared<Shader>>, entry: impl Into<Shared<str>>) -> ComputePass<'_, 'a> {
        let (shader, entry) = (shader.into(), entry.into());
        let bindings =
            self.resources.replay.as_mut().map(|replay| std::mem::take(&mut replay.bindings)).unwrap_or_default();
        ComputePass { recorder: self, shader, entry, label: Label::OfKernel, bindings, stride: 1 }
    }
}

impl ComputePass<'_, '_> {
    /// Label for people; the entry point's name by default.
    pub fn label(mut self, label: impl Display) -> Self {
        self.label = self.recorder.resources.pass_label(label);
        self
    }

    /// Binds a resource that is not an input of the same name.
    pub fn bind(mut self, variable: &'static str, resource: Resource) -> Self {
        self.bindings.bound.push((variable, Bound::Resource(resource)));
        self
    }

    /// An image for a variable.
    pub fn image(self, variable: &'static str, image: ImageId) -> Self {
        self.bind(variable, Resource::Image(image))
    }

    /// A mip level of a layer of an image for a variable.
    pub fn level(mut self, variable: &'static str, part: Subresource) -> Self {
        self.bindings.bound.push((variable, Bound::Level(part)));
        self
    }

    /// A buffer for a variable.
    pub fn buffer(self, variable: &'static str, buffer: BufferId) -> Self {
        self.bind(variable, Resource::Buffer(buffer))
    }

    /// A number that the node computes for its uniform; replaces a parameter of the same name.
    pub fn set(mut self, name: &'static str, value: impl Into<UniformValue>) -> Self {
        self.bindings.computed.push((name, value.into()));
        self
    }

    /// An override constant of the module.
    pub fn constant(mut self, name: &'static str, value: f64) -> Self {
        self.bindings.constants.push((name, value));
        self
    }

    /// Reads only the pixels of a stride along each axis, of all of its images. Reports and prices count those alone.
    pub fn stride(mut self, stride: u32) -> Self {
        self.stride = stride;
        self
    }

    /// Records the pass with this number of workgroups.
    pub fn dispatch(self, groups: [u32; 3]) {
        if let Some(replay) = self.recorder.resources.replay.take() {
            let is_equal = replay.expected().is_some_and(|expected| self.is_as(expected, groups));
            replay.step(is_equal, |uniform| {
                let params = params(self.recorder, &self.shader);
                self.recorder.write_uniform(&self.shader, params, &self.bindings.computed, uniform)
            });
            replay.bindings = self.bindings;
            replay.bindings.clear();
            self.recorder.resources.replay = Some(replay);
            return;
        }
        let Self { recorder, shader, entry, label, bindings, stride } = self;
        let (nodes, label) = (vec![recorder.context.node.to_owned()], label.text(&entry));
        if recorder.shaders.reflection(&shader).entry(&entry).is_none() && shader.reflect().is_ok() {
            recorder.shaders.add_error(shader.error_at(&entry, format!("there is no entry point `{entry}`")));
        }
        let call = bindings.call(recorder, shader, entry);
        let kernel = KernelCall { workgroups: Some(groups), constants: bindings.constants, stride, ..call };
        recorder.resources.add_pass(Pass {
            nodes,
            label,
            kernels: vec![kernel],
            results: Vec::new(),
            kind: PassKind::Compute,
        });
    }

    /// Returns whether the pass is this one, but for its uniform.
    fn is_as(&self, expected: &Pass, groups: [u32; 3]) -> bool {
        let ([kernel], [], PassKind::Compute) = (&*expected.kernels, &*expected.results, &expected.kind) else {
            return false;
        };
        // All fields are named: a new one is to be compared here, too, if compute passes set it.
        let KernelCall {
            shader,
            function,
            args,
            workgroups,
            constants,
            stride,
            node: _,
            uniform: _,
            defines: _,
            by_rows: _,
            by_neighbors: _,
            quad_variant: _,
            limited: _,
            origin: _,
            warp: _,
        } = kernel;
        let expected_args = args.iter().map(|arg| (arg.name.as_str(), arg.value));
        *shader == self.shader
            && *function == self.entry
            && self.label.is(&expected.label, &self.entry)
            && *workgroups == Some(groups)
            && *constants == self.bindings.constants
            && *stride == self.stride
            && self.bindings.arguments(self.recorder, &self.shader, &self.entry).eq(expected_args)
    }
}

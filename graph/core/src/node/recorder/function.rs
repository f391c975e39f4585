//! A pass around one kernel function.

use std::fmt::Display;
use std::sync::Arc;

use super::details::{FunctionDetails, Label};
use super::resources::shape;
use super::{InputValue, Recorder};
use crate::node::drawing::Subresource;
use crate::node::kernel::{Arg, Argument, ByNeighbors, ByRows, KernelCall};
use crate::node::pass::{Pass, PassKind, PassResult};
use crate::node::resource::{BlockId, ImageId};
use afterimage_base::Shared;
use afterimage_base::diagnostic::did_you_mean;
use afterimage_base::image::ImageDesc;
use afterimage_wgsl::{ArgType, Function, Shader, ShaderError, UniformValue};

/// A pass around one kernel function that is being described.
pub struct FunctionPass<'r, 'a> {
    pub(super) recorder: &'r mut Recorder<'a>,
    shader: Shared<Shader>,
    function: Shared<str>,
    label: Label,
    pub(super) details: FunctionDetails,
    by_rows: Option<ByRows>,
    by_neighbors: Option<ByNeighbors>,
    quad_variant: Option<&'static str>,
    workgroup: Option<[u32; 2]>,
}

impl<'a> Recorder<'a> {
    /// A pass around one kernel function. Its image and value arguments are the inputs of the same names, unless `read`
    /// gives another image.
    pub fn function(
        &mut self,
        shader: impl Into<Shared<Shader>>,
        function: impl Into<Shared<str>>,
    ) -> FunctionPass<'_, 'a> {
        let (shader, function, label) = (shader.into(), function.into(), Label::OfKernel);
        let details =
            self.resources.replay.as_mut().map(|replay| std::mem::take(&mut replay.function)).unwrap_or_default();
        let (by_rows, by_neighbors, quad_variant) = (None, None, None);
        FunctionPass {
            recorder: self,
            shader,
            function,
            label,
            details,
            by_rows,
            by_neighbors,
            quad_variant,
            workgroup: None,
        }
    }
}

impl FunctionPass<'_, '_> {
    /// Label for people; the function's name by default.
    pub fn label(mut self, label: impl Display) -> Self {
        self.label = self.recorder.resources.pass_label(label);
        self
    }

    /// The image of an argument that is not an input's.
    pub fn read(mut self, arg: impl Into<Shared<str>>, image: ImageId) -> Self {
        self.details.reads.push((arg.into(), image));
        self
    }

    /// An image whose texels are known now, as [`Recorder::constant`] makes it, for an argument.
    pub fn read_constant(
        self,
        arg: impl Into<Shared<str>>,
        name: &str,
        desc: ImageDesc,
        bytes: impl AsRef<[u8]> + Into<Arc<[u8]>>,
    ) -> Self {
        let image = self.recorder.constant(name, desc, bytes);
        self.read(arg, image)
    }

    /// One mip level of one layer of an image, for a texture argument. Its functions `tap` and `texel` read it like any
    /// image.
    pub fn read_level(mut self, arg: &'static str, part: Subresource) -> Self {
        self.recorder.resources.require_part(part, &self.function);
        self.details.levels.push((arg, part));
        self
    }

    /// A number that the node computes for its uniform; replaces a parameter of the same name.
    pub fn set(mut self, name: &'static str, value: impl Into<UniformValue>) -> Self {
        self.details.computed.push((name, value.into()));
        self
    }

    /// A second form of a function that halves an image, without parameters, for workgroups that walk down it: see
    /// [`ByRows`].
    pub fn by_rows(mut self, form: Option<ByRows>) -> Self {
        self.by_rows = form;
        self
    }

    /// A second form of a function that looks at the texels around its pixel: see [`ByNeighbors`].
    pub fn by_neighbors(mut self, form: ByNeighbors) -> Self {
        self.by_neighbors = Some(form);
        self
    }

    /// A second form of a function that halves an image: `fn name(square: Square) -> vec4f`, of the four texels under
    /// one, for sides that are exactly halved. The first form must be able to do without it.
    pub fn quad_variant(mut self, form: &'static str) -> Self {
        self.quad_variant = Some(form);
        self
    }

    /// Lets the invocations of a workgroup, that many across and down and at most 256, share its memory
    /// (`var<workgroup>`) and wait for each other. The function may take `invocation: Invocation` of the library's
    /// `workgroup`.
    ///
    /// Workgroups that reach over the border call it for places beyond, too, whose results are not stored: all
    /// invocations must arrive at each barrier. There a pixel argument is the nearest pixel of its image, and `at` the
    /// place itself. Such a pass is dispatched on its own, never drawn and never fused.
    pub fn workgroup(mut self, invocations: [u32; 2]) -> Self {
        self.workgroup = Some(invocations);
        self
    }

    /// Defines a shader constant, if a condition holds under which the function needs fewer operations. `constant` is a
    /// line `const NAME: bool = false;` of the module; it becomes true where every function of the module in a pass
    /// defines it. The result must not depend on it.
    pub fn define(mut self, constant: &'static str, holds: bool) -> Self {
        self.details.defines.extend(holds.then_some(constant));
        self
    }

    /// Records the pass; the result is the image of an output port.
    pub fn write(self, port: &str, desc: ImageDesc) -> ImageId {
        let image = self.recorder.output(port, desc);
        self.write_to(image);
        image
    }

    /// Records the pass; the result goes to an image made before.
    pub fn write_to(self, result: ImageId) {
        let desc = self.recorder.desc(result);
        assert!(desc.is_plain(), "`{}` writes an image of one sample, level and layer: {}", self.function, shape(desc));
        if let Some(replay) = self.recorder.resources.replay.take() {
            let is_equal = replay.expected().is_some_and(|expected| self.is_as(expected, result));
            replay.step(is_equal, |uniform| {
                let params = params(self.declaration());
                self.recorder.write_uniform(&self.shader, params, &self.details.computed, uniform)
            });
            replay.function = self.details;
            replay.function.clear();
            self.recorder.resources.replay = Some(replay);
            return;
        }
        let kernel = self.call();
        let nodes = vec![self.recorder.context.node.to_owned()];
        let mut pass = Pass::of_functions(nodes, self.label.text(&self.function), vec![kernel], result);
        if let Some(invocations) = self.workgroup {
            pass.kind = PassKind::Workgroup(invocations);
        }
        self.recorder.resources.add_pass(pass);
    }

    /// Returns whether the pass is this one, but for its uniform.
    fn is_as(&self, expected: &Pass, result: ImageId) -> bool {
        let ([kernel], [PassResult { kernel: 0, image }]) = (expected.kernels.as_slice(), expected.results.as_slice())
        else {
            return false;
        };
        // All fields are named: a new one is to be compared here, too, if function passes set it.
        let KernelCall {
            shader,
            function,
            defines,
            by_rows,
            by_neighbors,
            quad_variant,
            warp,
            args,
            node: _,
            uniform: _,
            stride: _,
            workgroups: _,
            constants: _,
            limited: _,
            origin: _,
        } = kernel;
        let is_kind = match (self.workgroup, &expected.kind) {
            (Some(invocations), PassKind::Workgroup(expected)) => invocations == *expected,
            (None, PassKind::Point | PassKind::Gather) => true,
            _ => false,
        };
        is_kind
            && *image == result
            && *function == self.function
            && *shader == self.shader
            && self.label.is(&expected.label, &self.function)
            && (*by_rows, *warp) == (self.by_rows, None)
            && (*by_neighbors, *quad_variant) == (self.by_neighbors, self.quad_variant)
            && *defines == self.details.defines
            && self.has_args(args)
    }

    fn has_args(&self, expected: &[Argument]) -> bool {
        let declaration = self.declaration();
        expected.iter().enumerate().all(|(index, arg)| arg.value == self.arg(declaration, index))
    }

    fn declaration(&self) -> &Function {
        let reflection = self.recorder.shaders.reflection(&self.shader);
        reflection.function(&self.function).unwrap_or_else(|| {
            if self.shader.reflect().is_ok() {
                let known = reflection.functions.iter().map(|function| function.name.as_str());
                let mut error = self.error(format!("there is no kernel function `{}`", self.function));
                error.help = did_you_mean(&self.function, known).map(String::into_boxed_str);
                self.recorder.shaders.add_error(error);
            }
            &NO_FUNCTION
        })
    }

    /// An error at the function.
    fn error(&self, message: String) -> ShaderError {
        self.shader.error_at(&format!("fn {}", self.function), message)
    }

    /// The call of the function.
    pub(super) fn call(&self) -> KernelCall {
        let function = self.declaration();
        let arg = |(index, (name, _)): (usize, &(String, _))| Argument {
            name: name.clone(),
            value: self.arg(function, index),
        };
        let args = function.args.iter().enumerate().map(arg).collect();
        let call = KernelCall::function(self.recorder.context.node, self.shader.clone(), self.function.clone(), &[]);
        KernelCall {
            args,
            uniform: self.recorder.uniform(&self.shader, params(function), &self.details.computed),
            defines: self.details.defines.clone(),
            by_rows: self.by_rows,
            by_neighbors: self.by_neighbors,
            quad_variant: self.quad_variant,
            ..call
        }
    }

    fn arg(&self, function: &Function, index: usize) -> Arg {
        let (name, ty) = &function.args[index];
        let is_port = match ty {
            ArgType::Struct(_) => name != "params",
            ArgType::Texture | ArgType::Volume | ArgType::Multisampled | ArgType::Floats(_) => true,
            _ => false,
        };
        if is_port && !self.has_source(name) {
            self.recorder
                .shaders
                .add_error(self.error(format!("`{}` has no input `{name}`", self.recorder.context.kind.name)));
            return Arg::Zero(1);
        }
        match ty {
            ArgType::Struct(_) if name == "params" => Arg::Params,
            ArgType::Struct(_) => Arg::Block(self.block(name)),
            ArgType::Point => Arg::Point,
            ArgType::Frame => Arg::Frame,
            ArgType::Invocation => Arg::Invocation,
            ArgType::Sampler => Arg::Sampler,
            ArgType::Texture | ArgType::Volume => {
                let level = self.details.levels.iter().find(|(arg, _)| arg == name).map(|(_, part)| Arg::Level(*part));
                level.unwrap_or_else(|| Arg::Texture(self.image(name, false)))
            }
            ArgType::Multisampled => Arg::Texture(self.image(name, true)),
            ArgType::Floats(n) => self.numbers(name, *n),
            ArgType::Other(ty) => {
                let message =
                    format!("the argument `{name}` of `{}` has the type `{ty}`, which none has", self.function);
                self.recorder.shaders.add_error(self.error(message));
                Arg::Zero(1)
            }
        }
    }

    /// Returns whether the argument has an image of its own, or that of an input.
    fn has_source(&self, name: &str) -> bool {
        let inputs = self.recorder.context.kind.inputs;
        self.chosen(name).is_some()
            || self.details.levels.iter().any(|(arg, _)| *arg == name)
            || inputs.iter().any(|input| input.name == name)
    }

    fn chosen(&self, name: &str) -> Option<ImageId> {
        self.details.reads.iter().find(|(arg, _)| *arg == name).map(|(_, image)| *image)
    }

    fn image(&self, name: &str, has_samples: bool) -> ImageId {
        let image = self.chosen(name).unwrap_or_else(|| match self.recorder.input_value(name) {
            InputValue::Image(image) => *image,
            other => panic!("input `{name}` of `{}` is {other:?}: `read` an image for it", self.recorder.context.node),
        });
        self.require_samples(name, image, has_samples);
        let layers = self.recorder.desc(image).layers;
        assert!(layers == 1, "the image of `{name}` in `{}` has {layers} layers: use `read_level`", self.function);
        image
    }

    /// A shader's type states whether a texture has samples, and so does the type of a port.
    fn require_samples(&self, name: &str, image: ImageId, has_samples: bool) {
        let samples = self.recorder.desc(image).samples;
        assert!(
            (samples > 1) == has_samples,
            "the image of `{name}` in `{}` has {samples} samples: `texture_multisampled_2d<f32>` is for ports that are \
             `Input::multisampled`, and only for these",
            self.function
        );
    }

    fn block(&self, name: &str) -> BlockId {
        match self.recorder.input_value(name) {
            InputValue::Block(block) => *block,
            other => panic!("input `{name}` of `{}` is {other:?}, not a host block", self.recorder.context.node),
        }
    }

    fn numbers(&self, name: &str, components: u8) -> Arg {
        let pixel = |image: ImageId| {
            self.require_samples(name, image, false);
            Arg::Pixel(image)
        };
        if let Some(image) = self.chosen(name) {
            return if self.recorder.resources.is_black(image) { Arg::Zero(components) } else { pixel(image) };
        }
        match self.recorder.input_value(name) {
            InputValue::Image(image) => pixel(*image),
            InputValue::Buffer(buffer) => Arg::Value(*buffer, components),
            InputValue::Zero | InputValue::Absent => Arg::Zero(components),
            other @ (InputValue::Pyramid(_) | InputValue::Block(_)) => {
                panic!("input `{name}` of `{}` is {other:?}, not a pixel", self.recorder.context.node)
            }
        }
    }
}

// The bytes of uniforms, also of entry points.
impl Recorder<'_> {
    /// The bytes of a uniform struct of a module; none without a struct.
    pub(super) fn uniform(&self, shader: &Shader, ty: Option<&str>, computed: &[(&str, UniformValue)]) -> Vec<u8> {
        let Some(ty) = ty else { return Vec::new() };
        self.shaders.reflection(shader).pack_with(ty, |name| self.number(computed, name)).unwrap_or_else(|why| {
            self.shaders.add_error(shader.error_at(&format!("struct {ty}"), why));
            Vec::new()
        })
    }

    /// Writes a uniform over one of the same length; whether it has that length.
    pub(super) fn write_uniform(
        &self,
        shader: &Shader,
        ty: Option<&str>,
        computed: &[(&str, UniformValue)],
        uniform: &mut [u8],
    ) -> bool {
        let Some(ty) = ty else { return uniform.is_empty() };
        let reflection = self.shaders.reflection(shader);
        if reflection.size(ty) != Some(uniform.len()) {
            return false;
        }
        reflection.pack_into(ty, |name| self.number(computed, name), uniform).is_ok()
    }
}

/// Placeholder for a function that does not exist.
static NO_FUNCTION: Function = Function { name: String::new(), args: Vec::new() };

/// The struct of a function's `params`, if it has some.
fn params(function: &Function) -> Option<&str> {
    function.args.iter().find_map(|(name, ty)| match ty {
        ArgType::Struct(ty) if name == "params" => Some(ty.as_str()),
        _ => None,
    })
}

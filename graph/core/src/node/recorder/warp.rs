//! A pass that reads an image at places that functions compute.

use super::Recorder;
use crate::node::kernel::{Arg, KernelCall, WarpPart};
use crate::node::pass::Pass;
use crate::node::resource::ImageId;
use afterimage_base::Shared;
use afterimage_base::image::ImageDesc;
use afterimage_wgsl::{Shader, UniformValue};

/// Reads an image at a place, and joins the channels of three reads. A place within a thousandth of a texel from the
/// middle of one is that texel: a warp that moves nothing changes nothing. Channels of three places may have a negative
/// luminance together. The mean of their alphas lets through as much of a background as the three would, in all.
static WARP: Shader = Shader::new(
    "warp.wgsl",
    "import afterimage::color::extended_light;
fn warp_tap(source: texture_2d<f32>, source_sampler: sampler, at: Point) -> vec4f {
    let place = at.uv * vec2f(textureDimensions(source));
    let off = abs(fract(place) - 0.5);
    if max(off.x, off.y) < 0.0009765625 { return texel(source, vec2i(floor(place))); }
    return tap(source, source_sampler, at.uv);
}
fn warp_channels(red: vec4f, green: vec4f, blue: vec4f) -> vec4f {
    let alpha = green.a + (red.a - green.a) / 3.0 + (blue.a - green.a) / 3.0;
    return vec4f(extended_light(vec3f(red.r, green.g, blue.b)), alpha);
}",
);

/// A pass that reads an image at places that functions compute, while it is being described.
pub struct WarpPass<'r, 'a> {
    recorder: &'r mut Recorder<'a>,
    shader: Shared<Shader>,
    functions: Vec<&'static str>,
    source: ImageId,
    label: &'static str,
    set: Vec<(&'static str, UniformValue)>,
}

impl<'a> Recorder<'a> {
    /// A pass that reads an image at the places that a function computes: from the place of a pixel, its parameters and
    /// values to the uv of a place in x and y. The function is also called between pixels: it must not use
    /// `at.pixel`, and reads images, such as masks, as textures at `at.uv`. Places beyond the border are moved to it.
    ///
    /// Neighboring warps become one pass, in which the image between them is neither stored nor filtered.
    pub fn warp(
        &mut self,
        shader: impl Into<Shared<Shader>>,
        function: &'static str,
        source: ImageId,
    ) -> WarpPass<'_, 'a> {
        self.warp_of(shader.into(), vec![function], source)
    }

    /// The same with a place for each of red, green and blue. Alpha is the mean of those of the three places.
    pub fn warp_channels(
        &mut self,
        shader: impl Into<Shared<Shader>>,
        functions: [&'static str; 3],
        source: ImageId,
    ) -> WarpPass<'_, 'a> {
        self.warp_of(shader.into(), functions.to_vec(), source)
    }

    fn warp_of(&mut self, shader: Shared<Shader>, functions: Vec<&'static str>, source: ImageId) -> WarpPass<'_, 'a> {
        let label = functions[0];
        WarpPass { recorder: self, shader, functions, source, label, set: Vec::new() }
    }
}

impl WarpPass<'_, '_> {
    /// Label for people; the first function's name by default.
    pub fn label(mut self, label: &'static str) -> Self {
        self.label = label;
        self
    }

    /// A number that the node computes for the uniform of its functions.
    pub fn set(mut self, name: &'static str, value: impl Into<UniformValue>) -> Self {
        self.set.push((name, value.into()));
        self
    }

    /// Records the pass; the result is the image of an output port.
    pub fn write(mut self, port: &str, desc: ImageDesc) -> ImageId {
        let places: Vec<KernelCall> = self.functions.clone().into_iter().map(|name| self.place(name)).collect();
        let image = self.recorder.output(port, desc);
        let node = self.recorder.context.node;
        let part = |warp, function: &'static str, args: &[(&str, Arg)]| KernelCall {
            warp: Some(warp),
            ..KernelCall::function(node, &WARP, function, args)
        };
        let count = places.len();
        let source = [("source", Arg::Texture(self.source)), ("source_sampler", Arg::Sampler)];
        let tap = |place: usize| part(WarpPart::Tap, "warp_tap", &[source[0], source[1], ("at", Arg::PointOf(place))]);
        let mut kernels: Vec<KernelCall> = places.into_iter().chain((0..count).map(tap)).collect();
        if count == 3 {
            let channels = [("red", Arg::Kernel(3)), ("green", Arg::Kernel(4)), ("blue", Arg::Kernel(5))];
            kernels.push(part(WarpPart::Join, "warp_channels", &channels));
        }
        let pass = Pass::of_functions(vec![node.to_owned()], self.label.to_owned(), kernels, image);
        self.recorder.resources.add_pass(pass);
        image
    }

    fn place(&mut self, function: &'static str) -> KernelCall {
        let mut pass = self.recorder.function(self.shader.clone(), function);
        pass.details.computed.extend(self.set.iter().cloned());
        let call = pass.call();
        let is_free = call.args.iter().all(|arg| !matches!(arg.value, Arg::Pixel(_)));
        assert!(is_free, "`{function}` reads a pixel: a warp is also called between pixels, so it takes a texture");
        KernelCall { warp: Some(WarpPart::Place), ..call }
    }
}

//! Ports and last passes of the kinds of ambient occlusion: denoising, enlarging, and shading by the visibility.

use afterimage_graph::node::CAMERA;
use afterimage_graph::prelude::*;

use crate::surface::{self, NormalSpace};

static SHADER: Shader = shader!("visibility");

choices! {
    /// The size at which occlusion is computed.
    pub enum OcclusionSize {
        /// That of the image.
        Full,
        /// Half of each side; it is enlarged along the edges of surfaces.
        Half,
    }
}

impl OcclusionSize {
    /// Pixels from one texel of visibilities to the next.
    fn stride(self) -> f64 {
        if self == Self::Half { 2.0 } else { 1.0 }
    }

    /// The size of visibilities for an image of this size.
    fn of(self, size: Size) -> Size {
        if self == Self::Half { size.div_up(2) } else { size }
    }
}

pub(crate) const INPUTS: &[Input] = &[
    Input::image("source", "The light of the scene.").accepts(&[ColorState::Scene, ColorState::Exposed]),
    Input::image("depth", "Distance along the view axis, in x.").accepts(&[ColorState::Data]),
    Input::block("camera", &CAMERA, "The camera."),
    Input::image("normal", "Normals of any length, in x, y and z; without them, they are made from the depth.")
        .accepts(&[ColorState::Data])
        .optional(),
    Input::image("albedo", "The share of light that surfaces reflect.").accepts(&[ColorState::Data]).optional(),
];
pub(crate) const OUTPUTS: &[Output] = &[
    Output::image("result", OutputState::same("source"), "The light that reaches the camera.").or_input("source"),
    Output::image("occlusion", OutputState::Always(ColorState::Data), "1 minus the visibility, in x; 0 in the others."),
];

/// The first pass of a kind, which computes the visibility of each pixel, and its options.
pub(crate) struct Occlusion {
    pub(crate) shader: &'static Shader,
    /// Without and with the input `normal`.
    pub(crate) functions: [&'static str; 2],
    pub(crate) size: OcclusionSize,
    /// Means over four by four texels of a surface, one after the other.
    pub(crate) denoise: u32,
    pub(crate) space: NormalSpace,
}

impl Occlusion {
    /// Records all passes of the kind; `uniforms` are those that are neither parameters nor known here.
    pub(crate) fn record(&self, pass: &mut Recorder<'_>, uniforms: &[(&'static str, f64)]) {
        let size = surface::size_of(pass, "source");
        let depth = surface::at_size(pass, "depth", size);
        let normal = pass.wired("normal").then(|| surface::at_size(pass, "normal", size));
        let [plain, with_normals] = self.functions;
        let found = image(pass, plain, self.size.of(size));
        let mut call = pass.function(self.shader, if normal.is_some() { with_normals } else { plain });
        call = call.read("depth", depth).set("is_world", self.space.is_world()).set("stride", self.size.stride());
        for (name, value) in uniforms {
            call = call.set(name, *value);
        }
        if let Some(normal) = normal {
            call = call.read("normal", normal);
        }
        call.write_to(found);
        let visibility = self.smoothed(pass, found, depth);
        show(pass, visibility, size);
    }

    /// The visibilities after the means, in the size of the depth.
    fn smoothed(&self, pass: &mut Recorder<'_>, mut found: ImageId, depth: ImageId) -> ImageId {
        let searched = pass.desc(found).size;
        for _ in 0..self.denoise {
            for axis in [[1.0, 0.0], [0.0, 1.0]] {
                let mean = image(pass, "visibility_denoise", searched);
                pass.function(&SHADER, "visibility_denoise").set("axis", axis).read("noisy", found).write_to(mean);
                found = mean;
            }
        }
        if self.size == OcclusionSize::Full {
            return found;
        }
        let whole = image(pass, "visibility_enlarge", pass.desc(depth).size);
        let call = pass.function(&SHADER, "visibility_enlarge").set("stride", self.size.stride());
        call.read("small", found).read("depth", depth).write_to(whole);
        whole
    }
}

/// An image of visibilities in x and inverse distances in y.
fn image(pass: &mut Recorder<'_>, name: &'static str, size: Size) -> ImageId {
    pass.transient(name, ImageDesc::new(size).format(Format::Rg16Float))
}

/// Writes the outputs `result`, with the input `albedo` if it is wired, and `occlusion`.
fn show(pass: &mut Recorder<'_>, visibility: ImageId, size: Size) {
    if pass.is_output_used("result") {
        let albedo = pass.wired("albedo").then(|| surface::at_size(pass, "albedo", size));
        let name = if albedo.is_some() { "visibility_lit_albedo" } else { "visibility_lit" };
        let mut call = pass.function(&SHADER, name).read("visibility", visibility);
        if let Some(albedo) = albedo {
            call = call.read("albedo", albedo);
        }
        call.write("result", ImageDesc::new(size));
    }
    if pass.is_output_used("occlusion") {
        let call = pass.function(&SHADER, "visibility_occlusion").read("visibility", visibility);
        call.write("occlusion", ImageDesc::new(size));
    }
}

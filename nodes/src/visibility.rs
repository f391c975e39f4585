//! What is made of the visibility of each pixel: means on a surface, a larger image, and the light that is left.

use afterimage_graph::prelude::*;

use crate::surface;

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
    pub(crate) fn stride(self) -> f64 {
        if self == Self::Half { 2.0 } else { 1.0 }
    }

    /// The size of visibilities for an image of this size.
    pub(crate) fn of(self, size: Size) -> Size {
        if self == Self::Half { size.div_up(2) } else { size }
    }
}

/// An image of visibilities in x and inverse distances in y.
pub(crate) fn image(pass: &mut Recorder<'_>, name: &'static str, size: Size) -> ImageId {
    pass.transient(name, ImageDesc::new(size).format(Format::Rg16Float))
}

/// Visibilities after means over four by four texels of a surface, in the size of the depth.
pub(crate) fn smoothed(
    pass: &mut Recorder<'_>,
    mut found: ImageId,
    depth: ImageId,
    (times, size): (u32, OcclusionSize),
) -> ImageId {
    let searched = pass.desc(found).size;
    for _ in 0..times {
        for axis in [[1.0, 0.0], [0.0, 1.0]] {
            let mean = image(pass, "visibility_denoise", searched);
            pass.function(&SHADER, "visibility_denoise").set("axis", axis).read("noisy", found).write_to(mean);
            found = mean;
        }
    }
    if size == OcclusionSize::Full {
        return found;
    }
    let whole = image(pass, "visibility_enlarge", pass.desc(depth).size);
    let call = pass.function(&SHADER, "visibility_enlarge").set("stride", size.stride());
    call.read("small", found).read("depth", depth).write_to(whole);
    whole
}

/// Writes the outputs `result`, with the input `albedo` if it is wired, and `occlusion`.
pub(crate) fn show(pass: &mut Recorder<'_>, visibility: ImageId, size: Size) {
    if pass.is_output_used("result") {
        let albedo = pass.wired("albedo").then(|| surface::at_size(pass, "albedo", size));
        let name = if albedo.is_some() { "visibility_lit_albedo" } else { "visibility_lit" };
        let call = pass.function(&SHADER, name).read("visibility", visibility);
        match albedo {
            Some(albedo) => call.read("albedo", albedo).write("result", ImageDesc::new(size)),
            None => call.write("result", ImageDesc::new(size)),
        };
    }
    if pass.is_output_used("occlusion") {
        let call = pass.function(&SHADER, "visibility_occlusion").read("visibility", visibility);
        call.write("occlusion", ImageDesc::new(size));
    }
}

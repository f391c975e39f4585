//! Images about the surfaces in a frame: depth, motion, normals.

use afterimage_graph::prelude::*;

choices! {
    /// The space that normals are in.
    pub enum NormalSpace {
        /// The camera's: x right, y up, z toward the camera.
        View,
        /// The world's.
        World,
    }
}

impl NormalSpace {
    /// The flag of shaders: 1 for the world's.
    pub(crate) fn is_world(self) -> f64 {
        f64::from(u8::from(self == Self::World))
    }
}

static NEAREST: Shader = shader!("nearest");

/// The image of an input at this size: itself, or its nearest texels, because a mean of two depths is at neither
/// surface.
pub(crate) fn at_size(pass: &mut Recorder<'_>, port: &'static str, size: Size) -> ImageId {
    let image = pass.image(port);
    let desc = pass.desc(image);
    if desc.size == size {
        return image;
    }
    let result = pass.transient_signed(port, ImageDesc { size, ..desc });
    pass.function(&NEAREST, "nearest").label(format_args!("nearest {port}")).read("source", image).write_to(result);
    result
}

/// The size of the image at an input; that of the frame where the input is black.
pub(crate) fn size_of(pass: &mut Recorder<'_>, port: &str) -> Size {
    if pass.is_zero(port) {
        return pass.frame_size;
    }
    let image = pass.image(port);
    pass.desc(image).size
}

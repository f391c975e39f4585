//! Images for the inputs of a pipeline, and positions in time.

use afterimage_graph::image::ImageDesc;
use wgpu::TextureView;

use crate::{FrameKind, Gpu, GpuError, upload_bytes};

/// An image on the GPU for an input of a pipeline.
#[derive(Clone)]
pub struct InputImage {
    /// The name of the input.
    pub input: String,
    /// The texels.
    pub view: TextureView,
    /// Size and format.
    pub desc: ImageDesc,
    /// Whether all texels are known to be finite. Then the plan does not sanitize them.
    pub finite: bool,
}

impl InputImage {
    /// The same image for another input.
    pub fn named(&self, input: &str) -> Self {
        Self { input: input.to_owned(), ..self.clone() }
    }
}

/// The position of a frame in time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameStep {
    /// Seconds since the start. Shaders see it as evenly after days as in the first second.
    pub time: f64,
    /// Seconds since the previous frame.
    pub dt: f32,
    /// How it follows the previous frame.
    pub kind: FrameKind,
}

impl FrameStep {
    /// A first frame.
    pub const FIRST: Self = Self { time: 0.0, dt: 0.0, kind: FrameKind::Cut };
}

/// An image with these texels for an input, in a texture of its own. `bytes` are rows without gaps.
///
/// # Errors
/// As [`upload`](crate::upload).
pub fn input_image(gpu: &Gpu, input: &str, desc: ImageDesc, bytes: &[u8]) -> Result<InputImage, GpuError> {
    let view = upload_bytes(&gpu.device, &gpu.queue, desc, bytes)?.create_view(&Default::default());
    Ok(InputImage { input: input.to_owned(), view, desc, finite: false })
}

//! BilateralBlur: a blur that stops at the edges of surfaces.

use afterimage_graph::prelude::*;

use crate::surface;

static SHADER: Shader = shader!("bilateral_blur");

node_kind! {
    /// Blurs an image within surfaces, and not over their edges: for occlusion, shadows and other noisy light.
    ///
    /// A Gaussian along one axis and then along the other. A neighbor counts less the farther it lies off the plane of
    /// the pixel's own surface, which the inverse of the depth shows at any slope in perspective, and, with normals,
    /// the more it faces another way. Alpha is blurred, too. After Tomasi and Manduchi, "Bilateral Filtering for Gray
    /// and Color Images", ICCV 1998; separated, so that corners of surfaces are blurred less than by the whole kernel.
    pub struct BilateralBlur {
        /// The reach to each side: twice the standard deviation of the Gaussian. 0 changes nothing.
        pub radius: u32 = 4 => within(0.0..=32.0), usually(1.0..=16.0), unit("pixels"), neutral(0u32);
        /// The distance off the plane, as a share of the depth, beyond which nothing counts.
        pub depth_threshold: f32 = 0.02 => within(0.001..=1.0), usually(0.005..=0.1);
        /// 1 minus the cosine between two normals beyond which nothing counts.
        pub normal_threshold: f32 = 0.3 => within(0.001..=2.0), usually(0.05..=1.0), when_wired("normal", true);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The image.").accepts(STATES),
        Input::image("depth", "Distance along the view axis, in x.").accepts(&[ColorState::Data]),
        Input::image("normal", "Normals of any length, in x, y and z.").accepts(&[ColorState::Data]).optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The blurred image.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { symmetric: false, keeps_constant: true, ..Invariants::DEFAULT };
}

const STATES: &[ColorState] =
    &[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear, ColorState::LogLuminance, ColorState::Data];

impl BilateralBlur {
    /// One axis, from an image to another or to the result.
    fn along(&self, pass: &mut Recorder<'_>, reads: Reads, axis: [f64; 2]) -> ImageId {
        let desc = ImageDesc::new(pass.desc(reads.source).size);
        let is_first = axis[0] == 1.0;
        let result = if is_first { pass.transient("across", desc) } else { pass.output("result", desc) };
        let sigma = 0.5 * f64::from(self.radius.max(1));
        let name = if reads.normal.is_some() { "bilateral_blur_normals" } else { "bilateral_blur" };
        let call = pass.function(&SHADER, name).read("source", reads.source).read("depth", reads.depth);
        let call = call.set("axis", axis).set("sharpness", 0.5 / (sigma * sigma));
        match reads.normal {
            Some(normal) => call.read("normal", normal).write_to(result),
            None => call.write_to(result),
        }
        result
    }
}

/// The images that a pass reads.
#[derive(Clone, Copy)]
struct Reads {
    source: ImageId,
    depth: ImageId,
    normal: Option<ImageId>,
}

impl Node for BilateralBlur {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        self.radius == 0 || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let size = pass.desc(source).size;
        let depth = surface::at_size(pass, "depth", size);
        let normal = pass.wired("normal").then(|| surface::at_size(pass, "normal", size));
        let across = self.along(pass, Reads { source, depth, normal }, [1.0, 0.0]);
        self.along(pass, Reads { source: across, depth, normal }, [0.0, 1.0]);
    }
}

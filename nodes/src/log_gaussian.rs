//! LogGaussian: a small, widely blurred image of log2 luminance.

use afterimage_graph::prelude::*;

use crate::gaussian_weights::GaussianWeights;
use crate::metering::EXPOSED_OR_METERED;
use crate::metering::stride;

static SHADER: Shader = shader!("log_gaussian");

node_kind! {
    /// Averages log2 luminance to a small image and blurs it widely.
    ///
    /// The result is the brightness of the surroundings, without regard to edges.
    ///
    /// Each pixel counts once, by its area, at any size. The blur is a circle in the image. `source` is an exposed
    /// image, or the scene with `meter` and `stops` set as for the `Exposure`.
    pub struct LogGaussian {
        /// Width of the result.
        pub width: u32 = 256 => within(4.0..=1024.0), usually(64.0..=512.0), unit("texels"), quality(256u32, [128]);
        /// Height of the result.
        pub height: u32 = 128 => within(4.0..=1024.0), usually(32.0..=256.0), unit("texels"), quality(128u32, [64]);
        /// Standard deviation of the blur.
        pub sigma: f32 = 0.06 => within(0.0..=0.25), usually(0.02..=0.12), unit("image widths"), neutral(0.0);
        /// Darker pixels count as this.
        pub lo: f32 = -10.5 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Brighter pixels count as this.
        pub hi: f32 = 5.5 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Stops added to the luminance of the image. 0 for an exposed image.
        pub stops: f32 = 0.0 => within(-24.0..=24.0), unit("stops"), neutral(0.0);
        /// Sampling stride, as of `Histogram`.
        pub step: u32 = 1 => within(1.0..=8.0), quality(1u32, [2, 4]);
    }

    const INPUTS: &'static [Input] = &EXPOSED_OR_METERED;
    const OUTPUTS: &'static [Output] = &[Output::image(
        "result",
        OutputState::Always(ColorState::LogLuminance),
        "The blurred log2 luminance, equal in red, green and blue.",
    )
    .or(Fallback::Absent)];
}

const REACH: f32 = 3.0;
/// Texels that a workgroup blurs, along x and y.
const GROUP: [u32; 2] = [16, 4];

impl LogGaussian {
    /// The sigmas along x and y in texels of the small image, which need not be square in the source. Limited to the
    /// height of the image: with two rows and thousands of columns, the circle would be thousands of rows high.
    fn sigmas(&self, picture: Size) -> [f32; 2] {
        let (width, height) = (self.width as f32, self.height as f32);
        [self.sigma * width, (self.sigma * height * picture.aspect() as f32).min(height)]
    }

    fn average(&self, pass: &mut Recorder<'_>, picture: ImageId, result: ImageId) {
        let exposure =
            if pass.wired("meter") { pass.buffer("meter") } else { pass.constant_buffer("unmetered", [0; 16]) };
        let step = stride(pass.desc(picture).size, self.step);
        pass.compute(&SHADER, "log_gaussian_average")
            .image("picture", picture)
            .buffer("exposure", exposure)
            .image("result", result)
            .set("step", step)
            .set("axis", [0_u32; 2])
            .set("radius", 0_u32)
            .set("falloff", 0.0)
            .set("scale", 0.0)
            .dispatch([self.width, self.height, 1]);
    }

    fn blur(pass: &mut Recorder<'_>, axis: usize, weights: &GaussianWeights, picture: ImageId, result: ImageId) {
        let size = pass.desc(result).size;
        let mut along = [0_u32; 2];
        along[axis] = 1;
        pass.compute(&SHADER, "log_gaussian_blur")
            .label(format_args!("log_gaussian_blur {}", ["x", "y"][axis]))
            .image("picture", picture)
            .image("result", result)
            .set("axis", along)
            .set("radius", weights.radius)
            .set("falloff", weights.falloff)
            .set("scale", weights.scale)
            .dispatch([size.width.div_ceil(GROUP[0]), size.height.div_ceil(GROUP[1]), 1]);
    }
}

impl Node for LogGaussian {
    fn verify(&self) -> Result<(), String> {
        if self.lo < self.hi { Ok(()) } else { Err("`hi` must be above `lo`".into()) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let picture = pass.image("source");
        let sigmas = self.sigmas(pass.desc(picture).size);
        let may_change = pass.is_dynamic("sigma");
        let kernels = || GaussianWeights::of_axes(&sigmas, REACH, |_| may_change);
        let desc = ImageDesc::new(Size::new(self.width, self.height));
        let mut blurred = [None; 2];
        blurred.iter_mut().zip(kernels()).for_each(|(image, _)| *image = Some(pass.transient("small", desc)));
        let result = pass.output("result", desc);
        let images = blurred.into_iter().flatten().chain([result]);
        self.average(pass, picture, images.clone().next().expect("the last is the result"));
        for ((axis, weights), (from, to)) in kernels().zip(images.clone().zip(images.skip(1))) {
            Self::blur(pass, axis, &weights, from, to);
        }
    }
}

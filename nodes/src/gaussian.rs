//! Gaussian: a separable blur of an image, or of every level of a pyramid.

use afterimage_graph::prelude::*;

use crate::downsample::{self, octaves};

static SHADER: Shader = shader!("gaussian");

choices! {
    /// The weights of a blur.
    pub enum GaussianKernel {
        /// A Gaussian with the given `sigma` and `reach`.
        Sigma,
        /// The nine taps of the Caracal document. Their sigma is 1.69 texels, not 2 as the document states.
        Caracal9,
        /// 33 taps: a Gaussian with a sigma of 3.5119 texels, equal to the published weights in all printed digits.
        Course33,
    }
}

choices! {
    /// Texture reads of a kernel.
    pub enum GaussianTaps {
        /// One read per texel.
        Exact,
        /// One read per two texels, weighted by the sampler: half of the reads. The error is up to 3e-4 of the range
        /// where the sampler has 8-bit weights.
        Linear,
        /// In images of twice `lines` or more: one read per texel of the image at a half of its size, or less, so that
        /// the cost does not grow with the kernel. At a `sigma` of 1.5, 2 and 3 the error is up to 2.8, 1.4 and 0.5 %
        /// of a light of one pixel, and 0.4, 0.12 and 0.03 % of an edge; below 1.2 the blur is wider. In other images
        /// and in pyramids as `Linear`.
        Halved,
    }
}

/// Declares a kind with the parameters of a blur.
macro_rules! blur {
    ($(#[doc = $doc:literal])* $kind:ident { $($own:tt)* } $($ports:tt)*) => {
        node_kind! {
            $(#[doc = $doc])*
            pub struct $kind {
                /// The weights.
                pub kernel: GaussianKernel = GaussianKernel::Sigma;
                /// For `kernel: Sigma`: the standard deviation. The cost grows with it: for a wider blur, blur a
                /// smaller image. At 0.2 and below the blur changes nothing.
                pub sigma: f32 = 2.0
                    => within(0.0..=64.0), usually(0.0..=16.0), neutral(0.0), unit("texels"),
                       when("kernel", [GaussianKernel::Sigma]);
                /// How the weights are applied.
                pub taps: GaussianTaps = GaussianTaps::Exact
                    => quality(GaussianTaps::Exact, [GaussianTaps::Linear, GaussianTaps::Halved]);
                /// For `kernel: Sigma`: the distance at which the kernel ends. The weight beyond it is lost: 3e-3 of
                /// all light at 3, 6e-5 at 4.
                pub reach: f32 = 3.0
                    => within(1.0..=4.0), unit("sigmas"), quality(4.0f32, [3.0, 2.5, 2.0]),
                       when("kernel", [GaussianKernel::Sigma]);
                $($own)*
            }

            $($ports)*
        }

        impl $kind {
            /// The standard deviation of the kernel, and at how many of them it ends.
            fn sigma_and_reach(&self) -> (f32, f32) {
                match self.kernel {
                    GaussianKernel::Course33 => COURSE,
                    GaussianKernel::Caracal9 => CARACAL,
                    GaussianKernel::Sigma => (self.sigma, self.reach),
                }
            }

            /// The blur with a kernel that is so many times as wide, together with what has this variance beside it.
            fn blur(&self, scale: f32, filtered: f32) -> Blur {
                let (sigma, reach) = self.sigma_and_reach();
                let kernel = if scale == 1.0 { self.kernel } else { GaussianKernel::Sigma };
                let variance = scale * scale * (sigma * sigma + filtered) - filtered;
                let sigma = if scale == 1.0 { sigma } else { variance.max(0.0).sqrt() };
                Blur::new(kernel, self.taps, sigma.min(MAX_SIGMA), reach)
            }
        }
    };
}

blur! {
    /// Blurs an image by a Gaussian, first along x, then along y.
    ///
    /// The weights sum to 1, so a constant image stays the same. Reads beyond the border return the border. Alpha is
    /// blurred like color.
    Gaussian {
        /// Height of the source for which the kernel is meant: others get one of the same share of the picture, of a
        /// sigma of 64 texels at most. With 0, it is meant for every source.
        pub lines: u32 = 0 => within(0.0..=16384.0), logarithmic(), unit("pixels");
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The image to blur.").accepts(&[
        ColorState::Scene,
        ColorState::Exposed,
        ColorState::LogLuminance,
        ColorState::DisplayLinear,
        ColorState::Data,
    ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The blurred image.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { keeps_constant: true, keeps_sum: true, ..Invariants::DEFAULT };
}

blur! {
    /// Blurs every level of a pyramid with the same sigma in its own texels.
    ///
    /// Each level is blurred twice as wide as the previous one.
    ///
    /// The weights sum to 1, so a constant image stays the same. Reads beyond the border return the border. Alpha is
    /// blurred like color.
    GaussianPyramid {
        /// Height of the frame for which the sigma is meant, as the `lines` of the pyramid: in frames between its
        /// halvings, levels are blurred by less, so that each keeps its share of the picture. With 0, it is meant for
        /// every frame.
        pub lines: u32 = 0 => within(0.0..=16384.0), logarithmic(), unit("pixels");
    }

    const INPUTS: &'static [Input] = &[Input::new("source", PortType::Pyramid, "The levels to blur.")];
    const OUTPUTS: &'static [Output] =
        &[Output::new("result", PortType::Pyramid, OutputState::same("source"), "The blurred levels, finest first.")
            .or_input("source")];
    const INVARIANTS: Invariants = Invariants { keeps_constant: true, ..Invariants::DEFAULT };
}

/// At this sigma and below, all but 4e-6 of the weight is at the center.
const NO_BLUR: f32 = 0.2;
/// The widest blur of one pass.
const MAX_SIGMA: f32 = 64.0;
/// Sigma of the kernel `Course33`, and the sigmas at which it ends: 16 texels.
const COURSE: (f32, f32) = (3.5119, 4.555);

/// The same of `Caracal9`: 4 texels.
const CARACAL: (f32, f32) = (1.69, 2.36);

/// The variance of what `Tap4` halvings and bilinear enlargements blur, in texels of a level: 0.31 + 0.17, and a
/// quarter of that for each finer level.
const FILTERED: f32 = 0.64;

/// The variance of the blur of a side that is scaled by halvings, in its texels, for a blur of `sigma` pixels. A
/// halving by `Tap13` has the variance 7/4 in texels of its source, so all of them together have 7/12 (1 - scale^2) in
/// texels of the result. The tent that enlarges has 2/3 + scale^2 / 12 at the pixels.
fn variance(sigma: f32, side: u32, whole: u32) -> f64 {
    let scale = f64::from(side) / f64::from(whole);
    let filters = if side == whole { 0.0 } else { 1.25 - 0.5 * scale * scale };
    ((f64::from(sigma) * scale).powi(2) - filters).max(0.0)
}

/// The falloff of taps up to a radius whose weights 2^(falloff i^2) have this variance, by bisection.
fn falloff_of_variance(variance: f64, radius: u32) -> f64 {
    let found = |falloff: f64| {
        let weights = (1..=radius).map(|i| f64::from(i).powi(2)).map(|square| (square, (falloff * square).exp2()));
        let [sum, moment] = weights.fold([0.0; 2], |[sum, moment], (square, w)| [sum + w, moment + square * w]);
        2.0 * moment / (1.0 + 2.0 * sum)
    };
    let (mut steep, mut flat) = (-100.0, 0.0);
    for _ in 0..50 {
        let middle = 0.5 * (steep + flat);
        if found(middle) < variance { steep = middle } else { flat = middle }
    }
    steep
}

/// The shader's parameters for one blur.
pub(crate) struct Blur {
    function: &'static str,
    radius: u32,
    falloff: f32,
}

impl Blur {
    pub(crate) fn new(kernel: GaussianKernel, taps: GaussianTaps, sigma: f32, reach: f32) -> Self {
        let function = match (kernel, taps) {
            (GaussianKernel::Caracal9, GaussianTaps::Exact) => "gaussian_caracal_exact",
            (GaussianKernel::Caracal9, _) => "gaussian_caracal_linear",
            (_, GaussianTaps::Exact) => "gaussian_exact",
            _ => "gaussian_linear",
        };
        let (sigma, radius) = if sigma <= NO_BLUR { (1.0, 0) } else { (sigma, (reach * sigma).ceil() as u32) };
        let falloff = -std::f64::consts::LOG2_E / (2.0 * f64::from(sigma).powi(2));
        Self { function, radius, falloff: falloff as f32 }
    }

    /// The blur whose taps have this variance, up to `reach` standard deviations. Unlike that of [`Self::new`], which
    /// loses what lies beyond its last tap, its width has no steps.
    pub(crate) fn of_variance(variance: f64, reach: f32) -> Self {
        let radius = (f64::from(reach) * variance.sqrt()).ceil() as u32;
        let falloff = falloff_of_variance(variance, radius);
        Self { function: "gaussian_exact", radius, falloff: falloff as f32 }
    }

    /// Records the blur of an image that is halved so many times, to be enlarged by a tent of radius 1 if it is smaller
    /// than the source. The blur is as much narrower as halvings and the enlargement widen it, and ends at `reach`
    /// standard deviations.
    pub(crate) fn reduced(pass: &mut Recorder<'_>, source: ImageId, halvings: u32, sigma: f32, reach: f32) -> ImageId {
        let whole = pass.desc(source).size;
        let (mut image, mut desc) = (source, ImageDesc::new(whole));
        for _ in 0..halvings {
            if desc.size.levels() == 0 {
                break;
            }
            desc = desc.half();
            let half = pass.transient(format_args!("half {}", desc.size), desc);
            downsample::halve(pass, image, half);
            image = half;
        }
        let (across, blurred) = (pass.transient("across", desc), pass.transient("blurred", desc));
        let blur = |side, whole| Self::of_variance(variance(sigma, side, whole), reach);
        blur(desc.size.width, whole.width).along(pass, [1, 0], image, across);
        blur(desc.size.height, whole.height).along(pass, [0, 1], across, blurred);
        blurred
    }

    fn changes_nothing(&self) -> bool {
        self.radius == 0 && !self.function.starts_with("gaussian_caracal")
    }

    /// Blurs along x, then along y.
    pub(crate) fn record(&self, pass: &mut Recorder<'_>, source: ImageId, result: ImageId) {
        let between = pass.transient("across", pass.desc(result));
        self.along(pass, [1, 0], source, between);
        self.along(pass, [0, 1], between, result);
    }

    pub(crate) fn along(&self, pass: &mut Recorder<'_>, axis: [u32; 2], source: ImageId, result: ImageId) {
        let direction = if axis[0] == 1 { "across" } else { "down" };
        let size = pass.desc(result).size;
        pass.function(&SHADER, self.function)
            .label(format_args!("{} {direction} {size}", self.function))
            .read("source", source)
            .set("axis", axis)
            .set("radius", self.radius)
            .set("falloff", self.falloff)
            .write_to(result);
    }
}

impl Node for Gaussian {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        inputs.is_zero("source") || self.blur(1.0, 0.0).changes_nothing()
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let result = pass.output("result", desc);
        let scale = if self.lines == 0 { 1.0 } else { desc.size.height as f32 / self.lines as f32 };
        let halvings = match self.taps {
            GaussianTaps::Exact | GaussianTaps::Linear => 0,
            GaussianTaps::Halved => scale.log2().max(0.0) as u32,
        };
        if halvings == 0 {
            self.blur(scale, 0.0).record(pass, source, result);
            return;
        }
        let (sigma, reach) = self.sigma_and_reach();
        let small = Blur::reduced(pass, source, halvings, scale * sigma, reach);
        pass.function(&SHADER, "gaussian_enlarged").read("small", small).write_to(result);
    }
}

impl Node for GaussianPyramid {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        inputs.is_zero("source") || self.blur(1.0, 0.0).changes_nothing()
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let octaves = octaves(pass.frame_size, self.lines);
        let scale = (octaves - octaves.ceil()).exp2() as f32;
        for (index, source) in pass.pyramid("source").iter().enumerate() {
            let desc = ImageDesc::new(pass.desc(*source).size);
            let level = pass.level(format_args!("result.{index}"), desc);
            self.blur(scale, FILTERED).record(pass, *source, level);
            pass.add_output_level("result", level);
        }
    }
}

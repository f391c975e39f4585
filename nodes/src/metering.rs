//! Shared by the metering kinds.

use afterimage_graph::prelude::*;

static FIXED: Shader = shader!("fixed_exposure");

/// EV100 of a luminance of 1 cd/m2: log2(100 / 12.5), a reflected-light meter with K = 12.5 (ISO 2720).
pub const EV100_OF_LUMINANCE: f32 = 3.0;

/// The lower end of the metering range, in EV100: 1.2e-4 cd/m2, a landscape under stars. All metering kinds have this
/// default, so that none of them ends before another.
pub(crate) const LOWEST_EV: f32 = -10.0;
/// The upper end of the metering range, in EV100: 65536 cd/m2. The largest half float is 65504.
pub(crate) const HIGHEST_EV: f32 = 19.0;

/// The lower end of the metering range in log2 of luminance.
pub(crate) const LOWEST_LOG2: f32 = LOWEST_EV - EV100_OF_LUMINANCE;
/// The upper end of the metering range in log2 of luminance.
pub(crate) const HIGHEST_LOG2: f32 = HIGHEST_EV - EV100_OF_LUMINANCE;

/// The fewest pixels that a kind with a sampling stride reads. With fewer, a meter between the percentiles 0.4 and 0.95
/// varies by more than 0.05 stops while a pattern of two brightnesses, 8.6 stops apart, moves by a pixel.
const MIN_SAMPLES: u64 = 900_000;

/// The sampling stride of an image: `step`, or less in a small image.
pub(crate) fn stride(size: Size, step: u32) -> u32 {
    (2..=step).rev().find(|step| sampled(size, *step).texels() >= MIN_SAMPLES).unwrap_or(1)
}

/// The size of the image of the pixels that are read: `stride_size` in `shaders/lib/stride.wgsl`.
pub(crate) fn sampled(size: Size, step: u32) -> Size {
    const SQUARE: u32 = 4;
    let side = |length: u32| if step == 1 { length } else { length.div_ceil(SQUARE * step) * SQUARE };
    Size { width: side(size.width), height: side(size.height), ..size }
}

/// The target of the previous frame, in stops. Between two frames the target is taken to move on a straight line.
pub(crate) fn wanted_before(pass: &mut Recorder<'_>) -> BufferId {
    pass.add_buffer("wanted_before", 4, BufferLife::Persistent)
}

/// Gives the exposure of one brightness, if both limits fix it to that, and nobody reads more than its stops. Whether
/// it did: then nothing is metered, and nothing depends on earlier frames. The named parameters decide it.
pub(crate) fn give_fixed(pass: &mut Recorder<'_>, limits: [f32; 2], key: f32, parameters: &[&str]) -> bool {
    let is_live = parameters.iter().any(|name| pass.is_dynamic(name));
    if limits[0] != limits[1] || is_live || pass.is_whole_output_used("result") {
        return false;
    }
    let result = pass.output_value("result", BufferLife::Frame);
    pass.compute(&FIXED, "fixed_exposure")
        .buffer("result", result)
        .set("key_log2", key.log2())
        .set("mean", limits[0] - EV100_OF_LUMINANCE)
        .dispatch([1, 1, 1]);
    true
}

/// True if the exposure stays as the first frame sets it, and nobody reads what is metered beside it, with these rates.
pub(crate) fn is_settled(pass: &Recorder<'_>, hold: bool, rates: [f32; 2]) -> bool {
    let stands = rates == [0.0; 2] && !pass.is_dynamic("rate_dark") && !pass.is_dynamic("rate_bright");
    (hold || stands) && !pass.is_whole_output_used("result")
}

/// The image of an optional input; one black texel if nothing is wired.
pub(crate) fn image_or_nothing(pass: &mut Recorder<'_>, port: &str) -> ImageId {
    if pass.wired(port) {
        return pass.image(port);
    }
    pass.constant("nothing", ImageDesc::new(Size::new(1, 1)), [0; 8])
}

choices! {
    /// How an exposure approaches its target.
    pub enum Adaptation {
        /// By the same share of the remaining distance per unit of time: fast at first, then slower. Rates in 1/s.
        Exponential,
        /// At a constant speed. Rates in stops per second.
        Linear,
    }
}

choices! {
    /// The weight of each pixel.
    pub enum MeteringWeight {
        /// Equal weights.
        Uniform,
        /// A Gaussian of the distance from `center`: center-weighted metering.
        Center,
        /// 1 within `radius` of `center`, 0 beyond: spot metering.
        Spot,
    }
}

impl MeteringWeight {
    /// The value of the shader's constant: see `metering_weight` in `shaders/lib/metering_weight.wgsl`.
    pub(crate) fn constant(self) -> f64 {
        match self {
            Self::Uniform => 0.0,
            Self::Center => 1.0,
            Self::Spot => 2.0,
        }
    }
}

/// The inputs of kinds that read exposed luminance: an exposed image, or the scene and the stops of a meter.
pub(crate) const EXPOSED_OR_METERED: [Input; 2] = [
    Input::image("source", "The exposed image, or the scene with `meter`.")
        .accepts(&[ColorState::Exposed, ColorState::Scene]),
    Input::new("meter", PortType::Value, "Stops to add, in x: the result of a metering node.")
        .content("exposure")
        .only_x()
        .optional(),
];

//! The built-in node kinds: one file per kind, and the table [`ALL`] that lists them.
//!
//! A host passes the table to the registry, alone or together with tables of other crates:
//!
//! ```
//! use afterimage_graph::node::Registry;
//!
//! let kinds = Registry::new(&[afterimage_nodes::ALL])?;
//! assert!(kinds.get("ToneMap").is_some());
//! # Ok::<(), afterimage_graph::node::RegistryError>(())
//! ```
//!
//! `afterimage nodes` prints the manual of all kinds, from their declarations. To add a kind, write
//! `nodes/src/<kind>.rs` and `shaders/<kind>.wgsl`, and add it to `mod`, `pub use` and [`ALL`] below, in alphabetical
//! order; for one without Rust write `nodes/folders/<kind>`, and add it to `nodes/src/folders.rs` and [`ALL`].

/// The shader of that name.
macro_rules! shader {
    ($name:literal) => {{
        let (file, source) = (concat!("shaders/", $name, ".wgsl"), afterimage_shaders::kind($name));
        // SAFETY: all of `shaders/` keeps these rules: texels are loaded through `texel`, which clamps, or at the
        // position of a result of equal size; indices are invocation indices or clamped to the last element; loops are
        // bounded by constants or by parameters within their domains; workgroup memory is written before it is read.
        #[allow(unsafe_code, reason = "the shaders of this workspace are reviewed")]
        unsafe {
            Shader::unchecked(file, source)
        }
    }};
}

mod aces2_output;
mod adapt;
mod antialiasing;
mod auto_exposure;
mod bilateral_blur;
mod brightness;
mod cas;
mod cdl;
mod chromatic_aberration;
mod color_balance;
mod color_lut;
mod composite;
mod contrast;
mod curves;
mod demo_scene;
mod depth_of_field;
mod dither;
mod downsample;
mod eetf;
mod encode;
mod exposure;
mod extract;
mod film_grain;
mod fog;
mod folders;
mod fxaa;
mod gaussian;
mod gaussian_weights;
mod grid_blur;
mod grid_build;
mod gtao;
mod halation;
mod heat_haze;
mod histogram;
mod host_draw;
mod lens_dirt;
mod lens_distortion;
mod lens_flare;
mod lift_gamma_gain;
mod linear_depth;
mod local_tone_map;
mod log_gaussian;
mod mean_luminance;
mod metering;
mod motion_blur;
mod outline;
mod purkinje;
mod purkinje_simple;
mod reference_gamut_compress;
mod resolve;
mod saturation;
mod shadow_mask;
mod sharpen;
mod smaa;
mod ssao;
mod streaks;
mod surface;
mod taa;
mod tiles;
mod tone_map;
mod upsample;
mod vignette;
mod visibility;
mod volumetric_composite;
mod white_balance;

use afterimage_graph::node::NodeKind;

pub use afterimage_color::adaptation::Cones;
pub use afterimage_color::lut::{Interpolation, PngLayout};
pub use afterimage_color::process::{LutSpace, LutState};
pub use afterimage_color::shaper::Shaper;

pub use aces2_output::{Aces2Gamut, Aces2Output};
pub use adapt::Adapt;
pub use auto_exposure::{AutoExposure, AutoExposureHighlights};
pub use bilateral_blur::BilateralBlur;
pub use brightness::Brightness as BrightnessKind;
pub use cas::Cas;
pub use cdl::Cdl;
pub use chromatic_aberration::ChromaticAberration;
pub use color_balance::ColorBalance;
pub use color_lut::{ColorLut, LutPrecision};
pub use composite::{Composite, CompositeBlend};
pub use contrast::{Contrast, ContrastForm};
pub use demo_scene::DemoScene;
pub use depth_of_field::DepthOfField;
pub use dither::Dither;
pub use downsample::{Border, Downsample, DownsampleFilter, Firefly};
pub use eetf::{Eetf, EetfOn};
pub use encode::{Encode, Primaries, Transfer};
pub use exposure::Exposure;
pub use extract::{Brightness, Extract, ExtractMethod, Fireflies};
pub use film_grain::FilmGrain;
pub use fog::Fog;
pub use fxaa::{Fxaa, FxaaSearch};
pub use gaussian::{Gaussian, GaussianKernel, GaussianPyramid, GaussianTaps};
pub use grid_blur::GridBlur;
pub use grid_build::{GridBuild, GridBuildMethod};
pub use gtao::Gtao;
pub use halation::Halation;
pub use heat_haze::HeatHaze;
pub use histogram::Histogram;
pub use host_draw::{DepthFormat, Draw, DrawDepth, DrawSamples};
pub use lens_dirt::LensDirt;
pub use lens_distortion::{LensDirection, LensDistortion, LensModel};
pub use lens_flare::LensFlare;
pub use lift_gamma_gain::{LiftBy, LiftGammaGain};
pub use linear_depth::{DepthEncoding, LinearDepth};
pub use local_tone_map::LocalToneMap;
pub use log_gaussian::LogGaussian;
pub use mean_luminance::{MeanLuminance, MeanLuminanceOf};
pub use metering::{Adaptation, EV100_OF_LUMINANCE, MeteringWeight};
pub use motion_blur::{MotionBlur, MotionUnit};
pub use outline::Outline;
pub use purkinje::Purkinje;
pub use purkinje_simple::PurkinjeSimple;
pub use reference_gamut_compress::ReferenceGamutCompress;
pub use resolve::{Resolve, ResolveFilter};
pub use saturation::Saturation;
pub use shadow_mask::{ShadowMask, ShadowTaps};
pub use sharpen::Sharpen;
pub use smaa::{Smaa, SmaaSearch};
pub use ssao::Ssao;
pub use streaks::Streaks;
pub use surface::NormalSpace;
pub use taa::{HistoryFilter, Taa};
pub use tone_map::{AgxLook, Curve, Gamut, MiddleGray, Sigmoid, ToneMap, WorkingSpace};
pub use upsample::{Upsample, UpsampleBlend, UpsampleFilter};
pub use vignette::Vignette;
pub use visibility::OcclusionSize;
pub use volumetric_composite::{VolumetricComposite, VolumetricSlices, VolumetricTexels};
pub use white_balance::{WhiteBalance, WhiteBalanceMode};

/// Kinds whose passes a host fills with its own draws: `Post::encode_drawing` of `afterimage-gpu` takes these. Programs
/// without a renderer, such as `afterimage`, do not have them.
///
/// ```
/// use afterimage_graph::node::Registry;
///
/// let kinds = Registry::new(&[afterimage_nodes::ALL, afterimage_nodes::HOST])?;
/// assert!(kinds.get("DrawSamples").is_some());
/// # Ok::<(), afterimage_graph::node::RegistryError>(())
/// ```
pub const HOST: &[NodeKind] = &[NodeKind::of::<Draw>(), NodeKind::of::<DrawDepth>(), NodeKind::of::<DrawSamples>()];

/// Every built-in kind.
pub const ALL: &[NodeKind] = &[
    NodeKind::of::<Aces2Output>(),
    NodeKind::of::<Adapt>(),
    NodeKind::of::<AutoExposure>(),
    NodeKind::of::<BilateralBlur>(),
    NodeKind::of::<BrightnessKind>(),
    NodeKind::of::<Cas>(),
    NodeKind::of::<Cdl>(),
    NodeKind::embedded(&folders::CHANNEL_MIXER),
    NodeKind::of::<ChromaticAberration>(),
    NodeKind::of::<ColorBalance>(),
    NodeKind::embedded(&folders::COLOR_KEY),
    NodeKind::of::<ColorLut>(),
    NodeKind::of::<Composite>(),
    NodeKind::of::<Contrast>(),
    NodeKind::embedded(&folders::CRT),
    NodeKind::embedded(&folders::CURVES),
    NodeKind::of::<DemoScene>(),
    NodeKind::embedded(&folders::DENOISE),
    NodeKind::of::<DepthOfField>(),
    NodeKind::embedded(&folders::DIRECTIONAL_BLUR),
    NodeKind::of::<Dither>(),
    NodeKind::of::<Downsample>(),
    NodeKind::of::<Eetf>(),
    NodeKind::of::<Encode>(),
    NodeKind::of::<Exposure>(),
    NodeKind::of::<Extract>(),
    NodeKind::of::<FilmGrain>(),
    NodeKind::of::<Fog>(),
    NodeKind::embedded(&folders::FSR1),
    NodeKind::of::<Fxaa>(),
    NodeKind::of::<Gaussian>(),
    NodeKind::of::<GaussianPyramid>(),
    NodeKind::embedded(&folders::GLITCH),
    NodeKind::embedded(&folders::GOD_RAYS),
    NodeKind::embedded(&folders::GRADIENT_MAP),
    NodeKind::embedded(&folders::GRADIENT_MASK),
    NodeKind::of::<GridBlur>(),
    NodeKind::of::<GridBuild>(),
    NodeKind::of::<Gtao>(),
    NodeKind::of::<Halation>(),
    NodeKind::of::<HeatHaze>(),
    NodeKind::of::<Histogram>(),
    NodeKind::embedded(&folders::HUE_CURVES),
    NodeKind::embedded(&folders::KUWAHARA),
    NodeKind::of::<LensDirt>(),
    NodeKind::of::<LensDistortion>(),
    NodeKind::of::<LensFlare>(),
    NodeKind::embedded(&folders::LENS_PROFILE),
    NodeKind::embedded(&folders::LETTERBOX),
    NodeKind::of::<LiftGammaGain>(),
    NodeKind::of::<LinearDepth>(),
    NodeKind::of::<LocalToneMap>(),
    NodeKind::of::<LogGaussian>(),
    NodeKind::embedded(&folders::LOG_WHEELS),
    NodeKind::embedded(&folders::LUMA_KEY),
    NodeKind::of::<MeanLuminance>(),
    NodeKind::embedded(&folders::MIX),
    NodeKind::of::<MotionBlur>(),
    NodeKind::embedded(&folders::NEWSPRINT),
    NodeKind::embedded(&folders::ORDERED_DITHER),
    NodeKind::of::<Outline>(),
    NodeKind::embedded(&folders::OVER),
    NodeKind::embedded(&folders::PALETTE),
    NodeKind::embedded(&folders::PIXELATE),
    NodeKind::embedded(&folders::POLYGON_MASK),
    NodeKind::embedded(&folders::PREMULTIPLY),
    NodeKind::of::<Purkinje>(),
    NodeKind::of::<PurkinjeSimple>(),
    NodeKind::embedded(&folders::RADIAL_BLUR),
    NodeKind::embedded(&folders::RCAS),
    NodeKind::of::<ReferenceGamutCompress>(),
    NodeKind::of::<Resolve>(),
    NodeKind::of::<Saturation>(),
    NodeKind::embedded(&folders::SATURATION_CURVES),
    NodeKind::of::<ShadowMask>(),
    NodeKind::embedded(&folders::SHAPE_MASK),
    NodeKind::of::<Sharpen>(),
    NodeKind::of::<Smaa>(),
    NodeKind::embedded(&folders::SPLIT_TONING),
    NodeKind::of::<Ssao>(),
    NodeKind::embedded(&folders::SSGI),
    NodeKind::embedded(&folders::SSR),
    NodeKind::of::<Streaks>(),
    NodeKind::of::<Taa>(),
    NodeKind::of::<ToneMap>(),
    NodeKind::embedded(&folders::TRANSFORM),
    NodeKind::embedded(&folders::UNPREMULTIPLY),
    NodeKind::of::<Upsample>(),
    NodeKind::embedded(&folders::VARIABLE_BLUR),
    NodeKind::of::<Vignette>(),
    NodeKind::of::<VolumetricComposite>(),
    NodeKind::of::<WhiteBalance>(),
];

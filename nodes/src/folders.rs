//! The kinds of `nodes/folders`: folders without Rust that are part of the program.

use afterimage_graph::node::EmbeddedKind;

/// A kind of `nodes/folders`, by its name and that of its folder and shader.
macro_rules! folder {
    ($static:ident, $kind:literal, $folder:literal) => {
        pub(crate) static $static: EmbeddedKind = EmbeddedKind::new(
            $kind,
            (concat!($folder, "/node.ron"), include_str!(concat!("../folders/", $folder, "/node.ron"))),
            &[(
                concat!($folder, "/", $folder, ".wgsl"),
                include_str!(concat!("../folders/", $folder, "/", $folder, ".wgsl")),
            )],
            LIBRARY,
        );
    };
}

/// Shader files for the imports of several kinds.
const LIBRARY: &[(&str, &str)] = &[
    ("lib/bayer.wgsl", include_str!("../folders/lib/bayer.wgsl")),
    ("lib/monotone.wgsl", include_str!("../folders/lib/monotone.wgsl")),
    ("lib/oklab_rgb.wgsl", include_str!("../folders/lib/oklab_rgb.wgsl")),
    ("lib/srgb.wgsl", include_str!("../folders/lib/srgb.wgsl")),
];

folder!(CHANNEL_MIXER, "ChannelMixer", "channel_mixer");
folder!(COLOR_KEY, "ColorKey", "color_key");
folder!(CRT, "Crt", "crt");
folder!(CURVES, "Curves", "curves");
folder!(DENOISE, "Denoise", "denoise");
folder!(DIRECTIONAL_BLUR, "DirectionalBlur", "directional_blur");
folder!(FSR1, "Fsr1", "fsr1");
folder!(GLITCH, "Glitch", "glitch");
folder!(GOD_RAYS, "GodRays", "god_rays");
folder!(GRADIENT_MAP, "GradientMap", "gradient_map");
folder!(GRADIENT_MASK, "GradientMask", "gradient_mask");
folder!(HUE_CURVES, "HueCurves", "hue_curves");
folder!(KUWAHARA, "Kuwahara", "kuwahara");
folder!(LENS_PROFILE, "LensProfile", "lens_profile");
folder!(LETTERBOX, "Letterbox", "letterbox");
folder!(LOG_WHEELS, "LogWheels", "log_wheels");
folder!(LUMA_KEY, "LumaKey", "luma_key");
folder!(MIX, "Mix", "mix");
folder!(NEWSPRINT, "Newsprint", "newsprint");
folder!(ORDERED_DITHER, "OrderedDither", "ordered_dither");
folder!(OVER, "Over", "over");
folder!(PALETTE, "Palette", "palette");
folder!(PIXELATE, "Pixelate", "pixelate");
folder!(POLYGON_MASK, "PolygonMask", "polygon_mask");
folder!(PREMULTIPLY, "Premultiply", "premultiply");
folder!(RADIAL_BLUR, "RadialBlur", "radial_blur");
folder!(RCAS, "Rcas", "rcas");
folder!(SATURATION_CURVES, "SaturationCurves", "saturation_curves");
folder!(SHAPE_MASK, "ShapeMask", "shape_mask");
folder!(SPLIT_TONING, "SplitToning", "split_toning");
folder!(SSGI, "Ssgi", "ssgi");
folder!(SSR, "Ssr", "ssr");
folder!(TRANSFORM, "Transform", "transform");
folder!(UNPREMULTIPLY, "Unpremultiply", "unpremultiply");
folder!(VARIABLE_BLUR, "VariableBlur", "variable_blur");

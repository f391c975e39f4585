//! LocalToneMap: reduces contrast between regions and keeps contrast within them.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("local_tone_map");

node_kind! {
    /// Compresses the contrast between dark and bright regions and keeps the detail within them.
    ///
    /// A room and the view through its window then both fit into the range of the display.
    ///
    /// In stops: o = midpoint + contrast (base - midpoint) + detail (l - base). l is the log2 luminance of the pixel,
    /// of its channels above 0 alone: negative ones of a saturated blue or cyan cancel the luminance, not the light.
    /// The base is the log2 luminance of its surroundings: a share of the bilateral grid, which respects edges, plus a
    /// share of the wide Gaussian, which does not (the hybrid of Ghost of Tsushima has 0.4 and 0.6).
    /// The color is multiplied by 2^(o - l), so its chromaticity stays the same. The factor is limited to 16 stops
    /// either way and the result to 65504.
    ///
    /// Where the grid has no samples near a pixel, the base is the Gaussian, or the pixel's own luminance if the
    /// Gaussian is not read. If only one of them is wired, it is the base. With neither, or with equal contrast and
    /// detail, the base cancels out and each pixel is scaled by its own luminance.
    ///
    /// With `range` wired, the contrast follows the scene: it is `span` over the stops of that value, from `contrast`
    /// to 1. A scene with a small range then stays as it is, and one with a large range is compressed to `span`.
    pub struct LocalToneMap {
        /// Contrast between regions: 1 keeps it, 0.5 halves it in stops, 0 makes all regions equally bright.
        pub contrast: f32 = 0.5 => within(0.0..=2.0), usually(0.3..=1.0), neutral(1.0);
        /// With `range` wired, the stops that need no compression.
        pub span: f32 = 6.0 => within(0.5..=32.0), usually(3.0..=10.0), unit("stops"), when_wired("range", true);
        /// Contrast within regions: 1 keeps it, more sharpens.
        pub detail: f32 = 1.0 => within(0.0..=4.0), usually(0.8..=1.5), neutral(1.0);
        /// The exposed luminance that does not change. The default is middle gray, log2 of 0.18.
        pub midpoint: f32 = -2.4739312 => within(-16.0..=16.0), usually(-6.0..=2.0), unit("log2 of luminance");
        /// The grid's share of the base. The rest is the wide Gaussian's. At an edge of nine stops with contrast 0.5,
        /// the halo is 2.2 stops at 0, 1.3 at 0.4 and none at 1. A smooth ramp of 12 stops has a ripple of at most
        /// 0.0003 stops. At 1 the Gaussian is not read, so the nodes that make it are skipped; at 0 those that make
        /// the grid.
        pub share: f32 = 1.0 => within(0.0..=1.0), replans(), when_wired("grid", true), when_wired("gaussian", true);
        /// Darker pixels get the factor of this luminance.
        pub lo: f32 = -10.5 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Brighter pixels get the factor of this luminance.
        pub hi: f32 = 5.5 => within(-32.0..=32.0), unit("log2 of luminance");
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The exposed image.").accepts(&[ColorState::Exposed]),
        Input::new("grid", PortType::Volume, "The blurred bilateral grid of the image.")
            .content("bilateral-grid")
            .optional(),
        Input::image("gaussian", "The wide Gaussian of the image's log2 luminance.")
            .accepts(&[ColorState::LogLuminance])
            .optional(),
        Input::new("range", PortType::Value, "The range of the scene in stops, in x: that of an `AutoExposure`.")
            .content("luminance-range")
            .optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image with compressed local contrast.")
            .or_input("source")];
}

impl LocalToneMap {
    /// The cheapest kernel for the wired inputs. Without local contrast it needs no base.
    fn function(&self, has_local_contrast: bool, grid: bool, gaussian: bool, range: bool) -> &'static str {
        let grid = has_local_contrast && grid && (self.share > 0.0 || !gaussian);
        let gaussian = has_local_contrast && gaussian && (self.share < 1.0 || !grid);
        match (grid, gaussian, range) {
            (true, true, false) => "local_tone_map",
            (true, true, true) => "local_tone_map_ranged",
            (true, false, false) => "local_tone_map_grid",
            (true, false, true) => "local_tone_map_grid_ranged",
            (false, true, false) => "local_tone_map_gaussian",
            (false, true, true) => "local_tone_map_gaussian_ranged",
            (false, false, false) => "local_tone_map_global",
            (false, false, true) => "local_tone_map_global_ranged",
        }
    }
}

impl Node for LocalToneMap {
    fn verify(&self) -> Result<(), String> {
        if self.lo < self.hi { Ok(()) } else { Err("`hi` must be above `lo`".into()) }
    }

    fn is_identity(&self, inputs: &InputValues) -> bool {
        let identity = self.contrast == 1.0 && self.detail == 1.0;
        identity || inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let may_change = pass.is_dynamic("contrast") || pass.is_dynamic("detail");
        let ranged = pass.wired("range");
        let has_local_contrast = self.contrast != self.detail || may_change || ranged;
        let function = self.function(has_local_contrast, pass.wired("grid"), pass.wired("gaussian"), ranged);
        pass.function(&SHADER, function).write("result", desc);
    }
}

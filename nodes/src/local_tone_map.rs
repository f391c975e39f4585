//! LocalToneMap: less contrast between places, all of it inside them.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("local_tone_map");

params! {
    /// Compresses the contrast between dark and bright places while the detail inside them stays, so that a room and what is seen
    /// through its window both have a place in the picture.
    ///
    /// In stops: o = midpoint + contrast (base - midpoint) + detail (l - base), where l is the pixel's log2 luminance and the base that
    /// of its surroundings: a share of the bilateral grid, which respects edges, and the rest of the wide Gaussian, which keeps the grid
    /// from ringing on smooth gradients (after the hybrid of Ghost of Tsushima). The colour is multiplied by 2^(o - l), so its
    /// chromaticity stays; the multiplier is at most 16 stops either way, the result at most 65504.
    ///
    /// Where the grid knows nothing near a pixel, the Gaussian takes its place. With only one of them wired that one is the base; with
    /// neither, or with contrast and detail equal, the base cancels out and the picture is scaled pixel by pixel.
    pub struct LocalToneMap {
        /// Contrast between places: 1 keeps it, 0.5 halves it in stops, 0 makes all places equally bright.
        pub contrast: f32 = 0.5 => within(0.0..=2.0), usually(0.3..=1.0), neutral(1.0);
        /// Contrast inside places: 1 keeps it, more sharpens.
        pub detail: f32 = 1.0 => within(0.0..=4.0), usually(0.8..=1.5), neutral(1.0);
        /// The exposed luminance that stays where it is. The default is that of middle grey, log2 of 0.18.
        pub midpoint: f32 = -2.4739312 => within(-16.0..=16.0), usually(-6.0..=2.0), unit("log2 of luminance");
        /// The bilateral grid's share of the base; the rest is the wide Gaussian's. Beside an edge of nine stops, at contrast 0.5, the
        /// picture is shaded by 2.2 stops at 0, by 1.3 at 0.4 and not at all at 1; a smooth ramp of 12 stops, which 0 leaves
        /// smooth, ripples by 0.0013 stops at 0.4 and 0.003 at 1.
        pub share: f32 = 0.4 => within(0.0..=1.0), replans();
        /// Pixels darker than this are scaled like this.
        pub lo: f32 = -10.5 => within(-32.0..=32.0), unit("log2 of luminance");
        /// Pixels brighter than this are scaled like this.
        pub hi: f32 = 5.5 => within(-32.0..=32.0), unit("log2 of luminance");
    }
}

impl LocalToneMap {
    /// The kernel that needs the least.
    fn function(&self, grid: bool, gaussian: bool) -> &'static str {
        let grid = grid && (self.share > 0.0 || !gaussian);
        match (grid, gaussian) {
            _ if self.contrast == self.detail => "local_tone_map_global",
            (true, true) => "local_tone_map",
            (true, false) => "local_tone_map_grid",
            (false, true) => "local_tone_map_gaussian",
            (false, false) => "local_tone_map_global",
        }
    }
}

impl Node for LocalToneMap {
    const INPUTS: &'static [Input] = &[
        Input::image("source", "The exposed picture.").accepts(&[ColorState::Exposed]),
        Input::new("grid", PortType::Volume, "The picture's bilateral grid, blurred.").optional(),
        Input::image("gaussian", "The picture's wide Gaussian.").accepts(&[ColorState::LogLuminance]).optional(),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Same("source"), "The picture with its places brought together.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn verify(&self) -> Result<(), String> {
        if self.lo < self.hi { Ok(()) } else { Err("`hi` must be above `lo`".into()) }
    }

    fn identity(&self, arrivals: &Arrivals) -> Option<Fallback> {
        let identity = self.contrast == 1.0 && self.detail == 1.0;
        (identity || arrivals.is_zero("source")).then_some(Self::FALLBACK)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let function = self.function(pass.wired("grid"), pass.wired("gaussian"));
        pass.function(&SHADER, function).write("result", desc);
    }
}

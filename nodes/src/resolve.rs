//! Resolve: an image of one sample in each pixel from a multisampled one.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("resolve");

choices! {
    /// Resolve filter.
    pub enum ResolveFilter {
        /// The mean of the samples of the pixel.
        Box,
        /// A Blackman-Harris window of radius 1.5 pixels: softer edges with fewer steps, from 9 pixels.
        BlackmanHarris15,
        /// A Blackman-Harris window of radius 2 pixels, from 25 pixels.
        BlackmanHarris20,
        /// The sample with the smallest x, for depths.
        Smallest,
        /// The sample with the largest x, for depths.
        Largest,
    }
}

node_kind! {
    /// Makes an image of one sample in each pixel from a multisampled image, before its light is bent by a tone curve.
    ///
    /// A plain mean of the samples at an edge against bright light is nearly as bright as that light, and the curve
    /// then shows a hard edge. So each sample is weighted by 1 / (1 + `gain` times its largest component), which gives
    /// the pixel that tone-mapped samples would have on average: Karis, "Tone Mapping", 2013. With a `gain` of 0 light
    /// is kept, as a resolve by the device keeps it. The windows reach into neighbors and count each sample by its
    /// distance from the pixel's center, for the standard places of 2, 4, 8 or 16 samples. Alpha has the window's
    /// weights alone. A depth needs `Smallest` or `Largest`, whichever is nearer: the mean of two depths is at neither
    /// surface.
    ///
    /// A sample with NaN or negative infinity counts nowhere: the others of its pixel decide, and without one it is
    /// black. Infinity is light, and limited. Place it first, for each multisampled input; the host gives these, and
    /// files have none. A pipeline for both declares an input
    /// `"samples": Color(multisampled: true, optional: true)` and wires the plain image to `otherwise`.
    pub struct Resolve {
        /// How the samples become one pixel.
        pub filter: ResolveFilter = ResolveFilter::Box;
        /// The exposure that weights are made for: the factor from the source to the light that the tone curve sees.
        /// 0 is the plain mean. Unused by `Smallest` and `Largest`.
        pub gain: f32 = 1.0
            => within(0.0..=65504.0), usually(0.0..=16.0), neutral(0.0),
               unless("filter", [ResolveFilter::Smallest, ResolveFilter::Largest]);
    }

    const INPUTS: &'static [Input] = &[
        // A node without its first input gives nothing; without another one it gives its fallback.
        Input::image("otherwise", "The result if no multisampled image is given.").accepts(STATES).optional(),
        Input::multisampled("source", "The multisampled image.").accepts(STATES),
    ];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image of one sample in each pixel.")
            .or_input("otherwise")];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
}

impl ResolveFilter {
    /// The radius of the window in pixels, 0 for the samples of the pixel alone, and how far the pixels lie whose
    /// samples are in it.
    fn window(self) -> (f64, i32) {
        match self {
            Self::BlackmanHarris15 => (1.5, 1),
            Self::BlackmanHarris20 => (2.0, 2),
            Self::Box | Self::Smallest | Self::Largest => (0.0, 0),
        }
    }
}

const STATES: &[ColorState] = &[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear, ColorState::Data];

impl Node for Resolve {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source).multisampled(1);
        if matches!(self.filter, ResolveFilter::Smallest | ResolveFilter::Largest) {
            // Half floats would move a depth by as much as surfaces lie apart.
            let format = if desc.format.is_32_bit() { desc.format } else { Format::Rgba16Float };
            let is_largest = f64::from(u8::from(self.filter == ResolveFilter::Largest));
            let call = pass.function(&SHADER, "resolve_chosen").set("is_largest", is_largest);
            call.write("result", desc.format(format));
            return;
        }
        let (radius, reach) = self.filter.window();
        let call = pass.function(&SHADER, "resolve").set("radius", radius).set("reach", reach);
        call.write("result", ImageDesc::new(desc.size));
    }
}

//! Eetf: the tone mapping of BT.2390 between displays.

use afterimage_graph::color::Colorimetry;
use afterimage_graph::prelude::*;

use afterimage_color::adaptation::rows;
use afterimage_color::display_range::DisplayRange;
use afterimage_color::oklab;
use afterimage_color::process::transfer::pq_encode;

static SHADER: Shader = shader!("eetf");

choices! {
    /// Signals that the curve is applied to.
    pub enum EetfOn {
        /// The largest channel, and all channels are scaled alike: chromaticities stay the same, and no channel exceeds
        /// the peak.
        Largest,
        /// The largest and the smallest channel: colors keep their hue of Oklab (Ottosson 2020) and lose the share of
        /// their saturation that the curve takes from the difference of the two, so that the brightest become white.
        /// From 1000 to 203 cd/m2, hues of Rec.709 stay within 2.8 degrees of JzAzBz. The curve on each channel would
        /// turn skin and fire yellow, by up to 40 degrees. Costs three cube roots.
        Extremes,
    }
}

node_kind! {
    /// Maps HDR light that was made for one peak to a display with a lower one.
    ///
    /// The electrical-electrical transfer function of ITU-R BT.2390 (section 5.4): in PQ, light below a knee stays the
    /// same and a Hermite spline brings the rest below the peak of the display. A black above 0 is lifted smoothly. Use
    /// it between a picture that was tone mapped for `source_nits` and `Encode`, for displays with a lower peak; `peak`
    /// of `ToneMap` is better where the pipeline starts from scene light. An `Encode` after it with another
    /// `white_nits` or a lower peak is an error.
    pub struct Eetf {
        /// The peak that the light was made for.
        pub source_nits: f32 = 1000.0 => within(100.0..=10000.0), usually(400.0..=4000.0), unit("cd/m2");
        /// The peak of the display. At `source_nits` and above, nothing changes above the black.
        pub peak_nits: f32 = 600.0 => within(80.0..=10000.0), usually(100.0..=2000.0), unit("cd/m2");
        /// The black of the display.
        pub black_nits: f32 = 0.0 => within(0.0..=5.0), usually(0.0..=0.1), neutral(0.0), unit("cd/m2");
        /// The luminance of display-linear 1. `Encode` has the same default.
        pub white_nits: f32 = 203.0 => within(1.0..=10000.0), usually(80.0..=400.0), unit("cd/m2");
        /// What the curve is applied to.
        pub on: EetfOn = EetfOn::Largest;
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "Display-linear light up to `source_nits`.").accepts(&[ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "Display-linear light up to `peak_nits`.")
            .or_input("source")];
    const INVARIANTS: Invariants = Invariants::OF_COLOR;
}

impl Node for Eetf {
    fn verify_display(&self, display: &Colorimetry) -> Result<(), String> {
        let peak_nits = self.peak_nits.min(self.source_nits).into();
        DisplayRange { white_nits: self.white_nits.into(), peak_nits }.suits(display)
    }

    fn color(&self) -> ColorChange {
        ColorChange::Refit { white_nits: self.white_nits.into(), peak_nits: self.source_nits.into() }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let range = pq_encode(f64::from(self.source_nits));
        let share = |nits: f32| (pq_encode(f64::from(nits)) - pq_encode(0.0)) / (range - pq_encode(0.0));
        let top = share(self.peak_nits.min(self.source_nits));
        let kernel = match self.on {
            EetfOn::Largest => "eetf_largest",
            EetfOn::Extremes => "eetf_extremes",
        };
        let primaries = pass.color("source").colorimetry.primaries;
        let (to_lms, from_lms) = (rows(oklab::lms_from_rgb(&primaries)), rows(oklab::rgb_from_lms(&primaries)));
        pass.function(&SHADER, kernel)
            .set("range", range)
            .set("top", top)
            .set("bottom", share(self.black_nits))
            .set("knee", 1.5 * top - 0.5)
            .set("to_lms0", to_lms[0])
            .set("to_lms1", to_lms[1])
            .set("to_lms2", to_lms[2])
            .set("from_lms0", from_lms[0])
            .set("from_lms1", from_lms[1])
            .set("from_lms2", from_lms[2])
            .write("result", desc);
    }
}

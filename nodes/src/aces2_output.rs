//! Aces2Output: the output transform of ACES 2.0 for SDR and HDR displays.

use afterimage_graph::color::{Chromaticities, Colorimetry};
use afterimage_graph::prelude::*;
use glam::DVec3;

use crate::tone_map::MiddleGray;
use afterimage_color::aces2::{OutputTransform, SEGMENTS};
use afterimage_color::adaptation::rows;
use afterimage_color::bisection::bisected;
use afterimage_color::display_range::DisplayRange;

static SHADER: Shader = shader!("aces2_output");

choices! {
    /// The gamut that limits the colors of the result.
    pub enum Aces2Gamut {
        /// That of the `Encode` after it, the widest of several, or Rec.709 without one.
        Display,
        /// sRGB and HDTV.
        Rec709,
        /// P3 with D65 white.
        P3,
        /// ITU-R BT.2020.
        Rec2020,
    }
}

node_kind! {
    /// The output transform of ACES 2.0: tone scale, chroma compression and gamut compression in one operator.
    ///
    /// After the Academy's reference (the CTL of aces-output): the light is limited to AP1, a color appearance model
    /// separates lightness, colorfulness and hue, the tone scale of the peak changes the lightness, and the
    /// colorfulness follows it into the gamut of the display. The tables of the gamut are computed in double precision
    /// when the plan is made. measurements/color.md has the largest differences from OpenColorIO's built-in transforms.
    /// A pixel takes 17 powers and four reads of a table, where `ToneMap` takes nine powers.
    ///
    /// The result is display-linear in the primaries of `gamut`, from 0 to `peak`. An `Encode` for other primaries
    /// converts it: with `gamut: P3` and `Encode(primaries: Rec2020)` the file has the primaries of Rec.2020 and the
    /// colors of P3, and for narrower primaries `gamut` of `Encode` fits the colors. Light that the display after it
    /// cannot show is an error: a `peak` above 1 needs `transfer: Pq` or `Hlg` in `Encode`, the same `white_nits`, and
    /// a `peak_nits` of at least `peak` times that.
    pub struct Aces2Output {
        /// The gamut that limits the colors.
        pub gamut: Aces2Gamut = Aces2Gamut::Display;
        /// The peak of the display, as in `ToneMap`: 4.926 for 1000 cd/m2 at a white of 203. With 1 the transform is
        /// that for SDR, 100 cd/m2.
        pub peak: f32 = 1.0 => within(1.0..=100.0), usually(1.0..=20.0), unit("of SDR white"), replans();
        /// For a `peak` above 1: the luminance of display-linear 1. `Encode` has the same default.
        pub white_nits: f32 = 203.0
            => within(1.0..=10000.0), usually(80.0..=400.0), unit("cd/m2"), replans(), unless("peak", [1.0f32]);
        /// Which light becomes middle gray. `Native` is the exposure of ACES: 10 cd/m2 for SDR, 14.7 for a peak of
        /// 1000 cd/m2.
        pub middle_gray: MiddleGray = MiddleGray::Matched;
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "Exposed light.").accepts(&[ColorState::Exposed])];
    const OUTPUTS: &'static [Output] = &[Output::image(
        "result",
        OutputState::Always(ColorState::DisplayLinear),
        "Display-linear light in the primaries of `gamut`, 0 to `peak`.",
    )
    .or_input("source")];
    const INVARIANTS: Invariants = Invariants::OF_COLOR;
}

impl Node for Aces2Output {
    fn verify_display(&self, display: &Colorimetry) -> Result<(), String> {
        if self.peak <= 1.0 {
            return Ok(());
        }
        DisplayRange { white_nits: self.unit(), peak_nits: self.peak_nits() }.suits(display)
    }

    fn color(&self) -> ColorChange {
        self.limit().map_or(ColorChange::ToDisplay, ColorChange::Display)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let display = self.limit().unwrap_or(pass.output_color("result").colorimetry.primaries);
        let transform = OutputTransform::of(display, self.peak_nits());
        let enter = rows(Chromaticities::REC709.conversion(&Chromaticities::ACES_CG) * self.light_scale(&transform));
        let hulls = hull_texture(pass, &transform);
        let [cones, opponents, back, display] = transform.matrices().map(rows);
        let chroma = transform.chroma();
        let gamut = transform.gamut();
        let [level, white, exponent] = transform.model();
        pass.function(&SHADER, "aces2_output")
            .set("enter0", enter[0])
            .set("enter1", enter[1])
            .set("enter2", enter[2])
            .set("cones0", cones[0])
            .set("cones1", cones[1])
            .set("cones2", cones[2])
            .set("opponents0", opponents[0])
            .set("opponents1", opponents[1])
            .set("opponents2", opponents[2])
            .set("back0", back[0])
            .set("back1", back[1])
            .set("back2", back[2])
            .set("display0", display[0])
            .set("display1", display[1])
            .set("display2", display[2])
            .set("unit", 100.0 / self.unit())
            .set("brightest", transform.brightest())
            .set("top", self.top())
            .set("level", level)
            .set("white", white)
            .set("exponent", exponent)
            .set("tone", [transform.tone().factor, transform.tone().offset])
            .set("chroma", [chroma.saturation, chroma.threshold, chroma.compression, chroma.scale])
            .set("limit_j", gamut.limit_j)
            .set("mid_j", gamut.mid_j)
            .set("focus_distance", gamut.focus_distance)
            .set("lower_gamma_inv", gamut.lower_gamma_inv)
            .read("hulls", hulls)
            .write("result", desc);
    }
}

impl Aces2Output {
    /// The primaries of `gamut`; `None` for those of the display.
    fn limit(&self) -> Option<Chromaticities> {
        match self.gamut {
            Aces2Gamut::Display => None,
            Aces2Gamut::Rec709 => Some(Chromaticities::REC709),
            Aces2Gamut::P3 => Some(Chromaticities::DISPLAY_P3),
            Aces2Gamut::Rec2020 => Some(Chromaticities::REC2020),
        }
    }

    /// The transform in double precision: exposed light of Rec.709 to display-linear light in the primaries of `gamut`,
    /// as the shader computes it on the GPU. `Display` counts as Rec.709. A color takes some microseconds.
    pub fn evaluator(&self) -> impl Fn([f64; 3]) -> [f64; 3] + use<> {
        let transform = OutputTransform::of(self.limit().unwrap_or(Chromaticities::REC709), self.peak_nits());
        let enter = Chromaticities::REC709.conversion(&Chromaticities::ACES_CG) * self.light_scale(&transform);
        let unit = 100.0 / self.unit();
        move |exposed| (unit * transform.apply(enter * DVec3::from(exposed))).to_array()
    }

    /// The peak in cd/m².
    fn peak_nits(&self) -> f64 {
        (f64::from(self.peak) * self.unit()).clamp(100.0, 10000.0)
    }

    /// The brightest channel of the display, in units of 100 cd/m².
    fn top(&self) -> f64 {
        self.peak_nits().min(f64::from(self.peak) * self.unit()) / 100.0
    }

    /// The luminance of display-linear 1 in cd/m².
    fn unit(&self) -> f64 {
        if self.peak > 1.0 { f64::from(self.white_nits) } else { 100.0 }
    }

    /// The factor of exposed light before the transform. The tone scale alone determines grays.
    fn light_scale(&self, transform: &OutputTransform) -> f64 {
        match self.middle_gray {
            MiddleGray::Native => 1.0,
            MiddleGray::Matched => {
                let is_below = |scale: f64| 100.0 * transform.tone().apply(0.18 * scale) < 0.18 * self.unit();
                bisected(1.0 / 16.0, 16.0, is_below)
            }
        }
    }
}

/// Texels of a row of the table. A segment has four texels: three with the hulls, one with the bend.
const ROW: usize = 512;

fn hull_texture(pass: &mut Recorder<'_>, transform: &OutputTransform) -> ImageId {
    let size = Size::new(ROW as u32, (4 * SEGMENTS / ROW) as u32);
    pass.computed("hulls", ImageDesc::new(size).format(Format::Rgba32Float), || {
        let segments = transform.segments();
        let texels = segments.iter().flat_map(|segment| {
            let [first, bent, last] = segment.values;
            [first, bent, last, [segment.bend, 0.0, 0.0, 0.0]]
        });
        texels.flatten().flat_map(|number| (number as f32).to_le_bytes()).collect()
    })
}

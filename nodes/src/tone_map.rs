//! ToneMap: maps exposed light to the range of a display by a curve, in a working space with selectable primaries.

use afterimage_graph::color::{Chromaticities, Xy};
use afterimage_graph::prelude::*;
use glam::DMat3;

use afterimage_color::adaptation::{TSUSHIMA, rows};
use afterimage_color::curve_constants::{
    AGX_IN_2020, AGX_OUT_2020, Aces2Tone, Agx, AgxHdr, GT7_WHITE, Gt7, HILL_IN, HILL_OUT, Shoulder,
};
use afterimage_color::oklab;

static SHADER: Shader = shader!("tone_map");

choices! {
    /// The tone curves.
    pub enum Curve {
        /// Clips above the peak.
        None,
        /// x / (1 + x) per channel (Reinhard et al. 2002, equation 3): soft, never reaches white.
        Reinhard,
        /// `Reinhard` with a white point: `white_level` becomes 1 (equation 4), per channel.
        ReinhardExtended,
        /// `ReinhardExtended` on luminance: hues stay the same, saturated lights are clipped.
        ReinhardLuminance,
        /// 1 - exp(-exposure * x): a simple model of film.
        Exponential,
        /// The tone scale of ACES 2.0 (Siragusano's curve) per channel: keeps highlights up to 16
        /// times white. With `peak` above 1 also for HDR displays. `Aces2Output` is the whole transform.
        Aces2ToneScale,
        /// Narkowicz's fit of ACES 1 (2016): high contrast.
        AcesNarkowicz,
        /// Hill's fit of the RRT and ODT of ACES 1: desaturates highlights. Light below 0.0033 becomes black.
        AcesHill,
        /// Hable's curve of Uncharted 2 (2010), exposure bias 2, white 11.2: a long toe, low contrast.
        Hable,
        /// Uchimura's curve (CEDEC 2017): a toe, a linear part and a shoulder with parameters.
        Uchimura,
        /// Khronos PBR Neutral, for product images: with the three switches of the published operators, colors below
        /// 0.8 are exact.
        KhronosNeutral,
        /// AgX (Sobotka): a wide range; bright lights become white as on film. With `peak` above 1 the curve and the
        /// matrices are those of Godot for HDR displays (Pestaluky 2025), in Rec.2020.
        AgX,
        /// The curve of Gran Turismo 7 (Uchimura 2025), also for HDR displays. Works in Rec.2020, in units of 100 cd/m2
        /// with an SDR white of 250.
        Gt7,
    }
}

/// Curves whose results end at 1.
const FIXED_PEAK: [Curve; 6] =
    [Curve::Reinhard, Curve::Exponential, Curve::AcesNarkowicz, Curve::AcesHill, Curve::Hable, Curve::KhronosNeutral];

impl Curve {
    /// True if the curve defines its own working space.
    pub(crate) fn has_own_space(self) -> bool {
        matches!(self, Self::ReinhardLuminance | Self::AcesHill | Self::KhronosNeutral | Self::AgX | Self::Gt7)
    }
}

choices! {
    /// The primaries in which a curve works per channel. Wider primaries keep bright saturated lights from clipping to
    /// one primary.
    pub enum WorkingSpace {
        /// `AcesCg` for a curve that works per channel. `None` needs no space, and the other curves define their own.
        Auto,
        /// The primaries of the scene.
        Rec709,
        /// ACEScg, primaries AP1.
        AcesCg,
        /// AP1 with a more saturated red, after the talk on Ghost of Tsushima.
        Tsushima,
        /// ITU-R BT.2020.
        Rec2020,
        /// The parameters `red`, `green`, `blue` and `white`.
        Custom,
    }
}

choices! {
    /// Gamut mapping of colors outside of the display's gamut.
    pub enum Gamut {
        /// Colors move toward gray at one hue of Oklab, smoothly from `gamut_knee` on, and what they lose in chroma
        /// makes them brighter. Bright light of every color becomes white.
        Compress,
        /// Each channel is clipped: cheap, saturated colors lose gradients and may change their hue. Primaries of the
        /// working space never become white.
        Clip,
    }
}

choices! {
    /// The scene value that a curve shows as middle gray.
    pub enum MiddleGray {
        /// Exposed 0.18 becomes display-linear 0.18: the light is scaled before the curve, within 1/16 to 16.
        Matched,
        /// The published exposure of the curve, which differs from curve to curve.
        Native,
    }
}

choices! {
    /// A grade inside of AgX.
    pub enum AgxLook {
        /// None.
        Base,
        /// More contrast and saturation.
        Punchy,
        /// Warmer and lighter.
        Golden,
    }
}

choices! {
    /// Precision of AgX's sigmoid.
    pub enum Sigmoid {
        /// By its definition.
        Exact,
        /// A polynomial of degree 6: an error of at most 1.35 codes of 8 bits, 0.45 on average. It saves two powers per
        /// channel.
        Polynomial,
    }
}

node_kind! {
    /// Maps exposed light to the range of a display by a tone curve.
    ///
    /// The light is converted to the working space, scaled, mapped by the curve, and converted to the primaries of the
    /// display: those of the `Encode` after it, the widest of several, or Rec.709 without one. Then it gets its own hue
    /// again, and colors outside of the gamut are fitted into it. The result is display-linear, from 0 to
    /// `peak`; 1 is SDR white, which `Encode` shows at 203 cd/m2 in HDR. No curve includes a transfer function: use
    /// `Encode`.
    ///
    /// All curves show the exposed light 0.18 as 0.18, so that another curve is not another exposure. As published they
    /// differ by 1.9 stops; a table and a plot are in graph/docs/color.md. For the published operator, set
    /// `middle_gray: Native, keep_hue: 0.0, gamut: Clip`, and `space: Rec709` for a curve that works per channel.
    ///
    /// A curve per channel turns hues: fire becomes yellow and, in wide primaries, a bright blue becomes purple. The
    /// default keeps the hue of the light in Oklab (Ottosson 2020), that of deep blue nearly; where its negative
    /// channels outweigh the others, which no color of AP1 has, that of the curve. It costs six cube roots a pixel, and
    /// `gamut: Compress` eight halvings of an interval for colors near the border of the gamut.
    pub struct ToneMap {
        /// The tone curve.
        pub curve: Curve = Curve::Aces2ToneScale;
        /// The working space: the primaries in which the curve works per channel. `AcesHill`, `KhronosNeutral`, `AgX`,
        /// `Gt7` and `ReinhardLuminance` define their own: with them `space` must be `Auto`.
        pub space: WorkingSpace = WorkingSpace::Auto
            => when("curve", Curve::ALL.iter().copied().filter(|curve| !curve.has_own_space()));
        /// Which light becomes middle gray.
        pub middle_gray: MiddleGray = MiddleGray::Matched => unless("curve", [Curve::None]);
        /// Share of the light's own hue in the result, in Oklab: 0 is the hue that the curve makes. A `look` turns hues
        /// on purpose, so that this is 0 with one.
        pub keep_hue: f32 = 1.0 => within(0.0..=1.0);
        /// How colors outside of the display's gamut are fitted into it.
        pub gamut: Gamut = Gamut::Compress;
        /// For `gamut: Compress`: colors stay unchanged up to this share of the distance from gray (0) to the gamut's
        /// border (1). 1 is the hardest.
        pub gamut_knee: f32 = 0.8 => within(0.0..=1.0), when("gamut", [Gamut::Compress]);
        /// The largest value of the result, in units of SDR white: 1 for SDR, 4.93 for 1000 cd/m2 at a white of 203.
        /// Only `None`, `ReinhardExtended`, `Aces2ToneScale`, `Uchimura` (with a `maximum` above 1), `AgX` and `Gt7`
        /// use more.
        pub peak: f32 = 1.0 => within(1.0..=100.0), unit("of SDR white"), replans(), unless("curve", FIXED_PEAK);
        /// For `ReinhardExtended` and `ReinhardLuminance`: the light that maps to 1.
        pub white_level: f32 = 4.0
            => within(1e-3..=65504.0), usually(1.0..=16.0),
               when("curve", [Curve::ReinhardExtended, Curve::ReinhardLuminance]);
        /// For `Exponential` with `middle_gray: Native`: factor of the light.
        pub exposure: f32 = 1.0 => within(0.0..=64.0), usually(0.25..=4.0), when("curve", [Curve::Exponential]);
        /// For `Uchimura`: P, the limit for bright light.
        pub maximum: f32 = 1.0
            => within(0.1..=100.0), logarithmic(), unit("of SDR white"), when("curve", [Curve::Uchimura]);
        /// For `Uchimura`: a, the slope of the linear part.
        pub contrast: f32 = 1.0 => within(0.1..=4.0), usually(0.5..=2.0), when("curve", [Curve::Uchimura]);
        /// For `Uchimura`: m, where the linear part begins.
        pub linear_start: f32 = 0.22 => within(0.0..=0.99), usually(0.1..=0.5), when("curve", [Curve::Uchimura]);
        /// For `Uchimura`: l, the linear share of the range above `linear_start`.
        pub linear_length: f32 = 0.4 => within(0.0..=1.0), when("curve", [Curve::Uchimura]);
        /// For `Uchimura`: c, the exponent of the toe. 1 is linear, more darkens shadows.
        pub toe: f32 = 1.33 => within(1.0..=4.0), usually(1.0..=3.0), when("curve", [Curve::Uchimura]);
        /// For `Uchimura`: b, added to the toe.
        pub pedestal: f32 = 0.0 => within(0.0..=0.5), neutral(0.0), when("curve", [Curve::Uchimura]);
        /// For `AgX` with a `peak` of 1: the look.
        pub look: AgxLook = AgxLook::Base => when("curve", [Curve::AgX]);
        /// For `AgX`: how its sigmoid is computed.
        pub sigmoid: Sigmoid = Sigmoid::Exact
            => quality(Sigmoid::Exact, [Sigmoid::Polynomial]), when("curve", [Curve::AgX]);
        /// For `space: Custom`: the red primary. The default primaries and white are those of `Tsushima`.
        pub red: [f32; 2] = [0.750, 0.270] => within(-1.0..=2.0), unit("xy"), when("space", [WorkingSpace::Custom]);
        /// For `space: Custom`: the green primary.
        pub green: [f32; 2] = [0.165, 0.830] => within(-1.0..=2.0), unit("xy"), when("space", [WorkingSpace::Custom]);
        /// For `space: Custom`: the blue primary.
        pub blue: [f32; 2] = [0.128, 0.044] => within(-1.0..=2.0), unit("xy"), when("space", [WorkingSpace::Custom]);
        /// For `space: Custom`: the white, adapted to D65 by Bradford.
        pub white: [f32; 2] = [0.32168, 0.33767]
            => within(1e-3..=1.0), unit("xy"), when("space", [WorkingSpace::Custom]);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "Exposed light.").accepts(&[ColorState::Exposed])];
    const OUTPUTS: &'static [Output] = &[Output::image(
        "result",
        OutputState::Always(ColorState::DisplayLinear),
        "Display-linear light in the primaries of the display, 0 to `peak`.",
    )
    .or_input("source")];
    const INVARIANTS: Invariants = Invariants { monotone: true, ..Invariants::OF_COLOR };
}

impl Node for ToneMap {
    fn invariants(&self, declared: Invariants) -> Invariants {
        // Clipping steps at the borders of the gamut, which a table would blur.
        Invariants { of_color: self.gamut != Gamut::Clip, ..declared }
    }

    fn verify(&self) -> Result<(), String> {
        if self.curve.has_own_space() && self.space != WorkingSpace::Auto {
            let curve = self.curve.name();
            return Err(format!(
                "`{curve}` brings its own working space: remove `space`, or choose a curve that works per channel"
            ));
        }
        if self.space == WorkingSpace::Custom && !self.custom().is_usable() {
            return Err("`red`, `green` and `blue` lie on a line: three primaries must span a triangle".into());
        }
        if self.curve == Curve::Uchimura && self.maximum <= self.linear_start {
            return Err("`maximum` must be above `linear_start`, where the linear part begins".into());
        }
        if self.is_agx_hdr() && self.look != AgxLook::Base {
            return Err("a `look` of AgX needs a `peak` of 1: grade with `Cdl` for HDR".into());
        }
        Ok(())
    }

    fn color(&self) -> ColorChange {
        ColorChange::ToDisplay
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let display = pass.output_color("result").colorimetry.primaries;
        let conversions = self.space_conversions(&display);
        let [enter, leave] = conversions.map(rows);
        let from_lms = rows(oklab::rgb_from_lms(&display));
        let [light_lms, to_lms] = [&Chromaticities::REC709, &display].map(|space| rows(oklab::lms_from_rgb(space)));
        let (shoulder, agx, gt7, aces2) = (self.shoulder(), self.agx(), self.gt7(), self.aces2());
        let agx_hdr = self.agx_hdr();
        let scale = self.light_scale();
        pass.function(&SHADER, self.kernel())
            .set("enter0", enter[0])
            .set("enter1", enter[1])
            .set("enter2", enter[2])
            .set("leave0", leave[0])
            .set("leave1", leave[1])
            .set("leave2", leave[2])
            .set("light_lms0", light_lms[0])
            .set("light_lms1", light_lms[1])
            .set("light_lms2", light_lms[2])
            .set("to_lms0", to_lms[0])
            .set("to_lms1", to_lms[1])
            .set("to_lms2", to_lms[2])
            .set("from_lms0", from_lms[0])
            .set("from_lms1", from_lms[1])
            .set("from_lms2", from_lms[2])
            .set("light_scale", scale)
            .set("path_to_white", self.path_to_white())
            .set("keep_hue", self.hue_share())
            .set("compress", if self.gamut == Gamut::Compress { 1.0 } else { 0.0 })
            .set("peak", self.top())
            .set("peak_lightness", self.top().cbrt())
            .set("white_level", scale * f64::from(self.white_level))
            .set("linear_start", shoulder.line_from)
            .set("shoulder", [shoulder.from, shoulder.limit, shoulder.gap, shoulder.steepness])
            .set("look", agx.slope.extend(agx.power).to_array())
            .set("saturation", agx.saturation)
            .set("gt7", [gt7.peak, gt7.offset, gt7.scale, gt7.rate])
            .set("gt7_intensity", gt7.intensity)
            .set("aces2", [aces2.factor, aces2.offset])
            .set("agx_hdr", [agx_hdr.toe, agx_hdr.slope, agx_hdr.rise, agx_hdr.white])
            .define("TONE_MAP_SAME_SPACE", conversions == [DMat3::IDENTITY; 2])
            .define("TONE_MAP_CLIPS", self.gamut == Gamut::Clip)
            .write("result", desc);
    }
}

/// With it, blue of AP1 at four stops above white is as bright as in ACES 2.0.
const PATH_TO_WHITE: f64 = 0.1;

impl ToneMap {
    fn kernel(&self) -> &'static str {
        match self.curve {
            Curve::None => "tone_map_none",
            Curve::Reinhard => "tone_map_reinhard",
            Curve::ReinhardExtended => "tone_map_reinhard_extended",
            Curve::ReinhardLuminance => "tone_map_reinhard_luminance",
            Curve::Exponential => "tone_map_exponential",
            Curve::Aces2ToneScale => "tone_map_aces2",
            Curve::AcesNarkowicz => "tone_map_narkowicz",
            Curve::AcesHill => "tone_map_hill",
            Curve::Hable => "tone_map_hable",
            Curve::Uchimura => "tone_map_uchimura",
            Curve::KhronosNeutral => "tone_map_khronos_neutral",
            Curve::AgX if self.is_agx_hdr() => "tone_map_agx_hdr",
            Curve::AgX => self.agx_kernel(),
            Curve::Gt7 => "tone_map_gt7",
        }
    }

    fn agx_kernel(&self) -> &'static str {
        match (self.sigmoid, self.look) {
            (Sigmoid::Exact, AgxLook::Base) => "tone_map_agx",
            (Sigmoid::Exact, _) => "tone_map_agx_looked",
            (Sigmoid::Polynomial, AgxLook::Base) => "tone_map_agx_fast",
            (Sigmoid::Polynomial, _) => "tone_map_agx_fast_looked",
        }
    }

    /// True if AgX has its curve for HDR displays.
    pub(crate) fn is_agx_hdr(&self) -> bool {
        self.curve == Curve::AgX && self.peak > 1.0
    }

    /// The share of the light's own hue in the result.
    pub(crate) fn hue_share(&self) -> f64 {
        let is_graded = self.curve == Curve::AgX && self.look != AgxLook::Base;
        if is_graded { 0.0 } else { f64::from(self.keep_hue) }
    }

    /// The largest result of the curve.
    fn top(&self) -> f64 {
        let peak = f64::from(self.peak);
        match self.curve {
            Curve::None
            | Curve::ReinhardExtended
            | Curve::ReinhardLuminance
            | Curve::Aces2ToneScale
            | Curve::AgX
            | Curve::Gt7 => peak,
            Curve::Uchimura => peak.min(f64::from(self.maximum)),
            _ => 1.0,
        }
    }

    /// The share of the mean that bright light gets in every channel.
    fn path_to_white(&self) -> f64 {
        if self.gamut == Gamut::Clip || self.curve == Curve::None { 0.0 } else { PATH_TO_WHITE }
    }

    fn custom(&self) -> Chromaticities {
        let [red, green, blue, white] = [self.red, self.green, self.blue, self.white].map(Xy::from);
        Chromaticities { red, green, blue, white }
    }

    /// The matrices from Rec.709 to the working space, and from there to the primaries of the display.
    pub(crate) fn space_conversions(&self, display: &Chromaticities) -> [DMat3; 2] {
        let space = match (self.curve, self.space) {
            (Curve::AgX, _) if self.is_agx_hdr() => return agx_hdr_conversions(display),
            (Curve::AcesHill, _) => return [HILL_IN, Chromaticities::REC709.conversion(display) * HILL_OUT],
            (Curve::Gt7, _) | (_, WorkingSpace::Rec2020) => Chromaticities::REC2020,
            (curve, _) if curve.has_own_space() => Chromaticities::REC709,
            (_, WorkingSpace::Rec709) | (Curve::None, WorkingSpace::Auto) => Chromaticities::REC709,
            (_, WorkingSpace::AcesCg | WorkingSpace::Auto) => Chromaticities::ACES_CG,
            (_, WorkingSpace::Tsushima) => TSUSHIMA,
            (_, WorkingSpace::Custom) => self.custom(),
        };
        [Chromaticities::REC709.conversion(&space), space.conversion(display)]
    }

    pub(crate) fn shoulder(&self) -> Shoulder {
        let [maximum, contrast, start, length] =
            [self.maximum, self.contrast, self.linear_start, self.linear_length].map(f64::from);
        Shoulder::new(maximum, contrast, start, length)
    }

    pub(crate) fn agx(&self) -> Agx {
        match self.look {
            AgxLook::Base => Agx::BASE,
            AgxLook::Punchy => Agx::PUNCHY,
            AgxLook::Golden => Agx::GOLDEN,
        }
    }

    pub(crate) fn gt7(&self) -> Gt7 {
        Gt7::new(GT7_WHITE * f64::from(self.peak))
    }

    pub(crate) fn aces2(&self) -> Aces2Tone {
        Aces2Tone::new(100.0 * f64::from(self.peak))
    }

    pub(crate) fn agx_hdr(&self) -> AgxHdr {
        AgxHdr::new(f64::from(self.peak))
    }
}

fn agx_hdr_conversions(display: &Chromaticities) -> [DMat3; 2] {
    let (rec709, rec2020) = (Chromaticities::REC709, Chromaticities::REC2020);
    [AGX_IN_2020 * rec709.conversion(&rec2020), rec2020.conversion(display) * AGX_OUT_2020]
}

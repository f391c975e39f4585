//! ToneMap: maps exposed light to the range of a display by a curve, in a working space with selectable primaries.

use afterimage_graph::color::{Chromaticities, Xy};
use afterimage_graph::prelude::*;
use glam::DMat3;

use crate::color::{TSUSHIMA, rows};
use crate::curve_constants::{Agx, Gt7, HILL_IN, HILL_OUT, Shoulder};

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
        /// Narkowicz's fit of ACES (2016): high contrast, hue shifts in highlights. It is brighter than ACES: 1 becomes
        /// 0.8.
        Aces,
        /// Hill's fit of the ACES RRT and ODT: desaturates highlights. Light below 0.0033 becomes black.
        AcesHill,
        /// Hable's curve of Uncharted 2 (2010), exposure bias 2, white 11.2: a long toe, low contrast.
        Hable,
        /// Uchimura's curve (CEDEC 2017): a toe, a linear part and a shoulder with parameters.
        Uchimura,
        /// Khronos PBR Neutral: exact colours below 0.8, for product images.
        KhronosNeutral,
        /// AgX (Sobotka): a wide range; bright lights become white as on film.
        AgX,
        /// The curve of Gran Turismo 7 (Uchimura 2025): keeps hues. Works in Rec.2020, also for HDR displays.
        Gt7,
    }
}

impl Curve {
    /// Whether the curve defines its own working space.
    pub(crate) fn has_own_space(self) -> bool {
        matches!(self, Self::ReinhardLuminance | Self::AcesHill | Self::KhronosNeutral | Self::AgX | Self::Gt7)
    }
}

choices! {
    /// The primaries in which a curve works per channel. Wider primaries keep bright saturated lights from clipping to
    /// one primary.
    pub enum WorkingSpace {
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
    /// What happens to colours outside of the display's gamut.
    pub enum Gamut {
        /// Each channel is clipped: bright and simple, hues may shift.
        Clip,
        /// Colours move towards the grey of their luminance, smoothly from `gamut_knee` on: hues and gradients are
        /// kept.
        Compress,
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
    /// How AgX's sigmoid is computed.
    pub enum Sigmoid {
        /// By its definition.
        Exact,
        /// A polynomial of degree 6: an error of at most 1.35 codes of 8 bits, 0.45 on average. It saves two powers per
        /// channel.
        Polynomial,
    }
}

params! {
    /// Maps exposed light to the range of a display by a tone curve.
    ///
    /// The light is converted to the working space, mapped by the curve, converted back to Rec.709 and fitted into the
    /// gamut. Both conversions keep grey, so the curve alone determines a grey ramp. The result is display-linear, from
    /// 0 to `peak`. `AcesHill`, `KhronosNeutral`, `AgX`, `Gt7` and `ReinhardLuminance` define their own working space:
    /// with them `space` must be `Rec709`. No curve includes a transfer function: use `Encode`.
    pub struct ToneMap {
        /// The tone curve.
        pub curve: Curve = Curve::Aces;
        /// The working space: the primaries in which the curve works per channel.
        pub space: WorkingSpace = WorkingSpace::Rec709;
        /// How colours outside of the display's gamut are fitted into it.
        pub gamut: Gamut = Gamut::Clip;
        /// For `gamut: Compress`: colours stay unchanged up to this share of the distance from grey (0) to the gamut's
        /// border (1). 1 is the hardest.
        pub gamut_knee: f32 = 0.8 => within(0.0..=1.0);
        /// The largest value of the result, in units of SDR white: 1 for SDR. Only `None`, `ReinhardExtended`,
        /// `Uchimura` (with a `maximum` above 1) and `Gt7` use more.
        pub peak: f32 = 1.0 => within(1.0..=100.0), unit("of SDR white");
        /// For `ReinhardExtended` and `ReinhardLuminance`: the light that maps to 1.
        pub white_level: f32 = 4.0 => within(1e-3..=65504.0), usually(1.0..=16.0);
        /// For `Exponential`: factor of the light.
        pub exposure: f32 = 1.0 => within(0.0..=64.0), usually(0.25..=4.0);
        /// For `Uchimura`: P, the limit for bright light.
        pub maximum: f32 = 1.0 => within(0.1..=100.0), unit("of SDR white");
        /// For `Uchimura`: a, the slope of the linear part.
        pub contrast: f32 = 1.0 => within(0.1..=4.0), usually(0.5..=2.0);
        /// For `Uchimura`: m, where the linear part begins.
        pub linear_start: f32 = 0.22 => within(0.0..=0.99), usually(0.1..=0.5);
        /// For `Uchimura`: l, the linear share of the range above `linear_start`.
        pub linear_length: f32 = 0.4 => within(0.0..=1.0);
        /// For `Uchimura`: c, the exponent of the toe. 1 is linear, more darkens shadows.
        pub toe: f32 = 1.33 => within(1.0..=4.0), usually(1.0..=3.0);
        /// For `Uchimura`: b, added to the toe.
        pub pedestal: f32 = 0.0 => within(0.0..=0.5), neutral(0.0);
        /// For `AgX`: the look.
        pub look: AgxLook = AgxLook::Base;
        /// For `AgX`: how its sigmoid is computed.
        pub sigmoid: Sigmoid = Sigmoid::Exact => quality(Sigmoid::Exact, [Sigmoid::Polynomial]);
        /// For `space: Custom`: the red primary. The default primaries and white are those of `Tsushima`.
        pub red: [f32; 2] = [0.750, 0.270] => within(-1.0..=2.0), unit("xy");
        /// For `space: Custom`: the green primary.
        pub green: [f32; 2] = [0.165, 0.830] => within(-1.0..=2.0), unit("xy");
        /// For `space: Custom`: the blue primary.
        pub blue: [f32; 2] = [0.128, 0.044] => within(-1.0..=2.0), unit("xy");
        /// For `space: Custom`: the white, adapted to D65 by Bradford.
        pub white: [f32; 2] = [0.32168, 0.33767] => within(1e-3..=1.0), unit("xy");
    }
}

impl Node for ToneMap {
    const INPUTS: &'static [Input] = &[Input::image("source", "Exposed light.").accepts(&[ColorState::Exposed])];
    const OUTPUTS: &'static [Output] = &[Output::image(
        "result",
        OutputState::Always(ColorState::DisplayLinear),
        "Display-linear light, 0 to `peak`.",
    )];
    const FALLBACK: Fallback = Fallback::input("source");

    fn verify(&self) -> Result<(), String> {
        if self.curve.has_own_space() && self.space != WorkingSpace::Rec709 {
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
        Ok(())
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let conversions = self.space_conversions();
        let is_same_space = conversions == [DMat3::IDENTITY; 2];
        let [enter, leave] = conversions.map(rows);
        let (shoulder, agx, gt7) = (self.shoulder(), self.agx(), self.gt7());
        pass.function(&SHADER, self.kernel())
            .set("enter0", enter[0])
            .set("enter1", enter[1])
            .set("enter2", enter[2])
            .set("leave0", leave[0])
            .set("leave1", leave[1])
            .set("leave2", leave[2])
            .set("linear_start", shoulder.line_from)
            .set("shoulder", [shoulder.from, shoulder.limit, shoulder.gap, shoulder.steepness])
            .set("look", agx.slope.extend(agx.power).to_array())
            .set("saturation", agx.saturation)
            .set("gt7", [gt7.peak, gt7.offset, gt7.scale, gt7.rate])
            .set("gt7_intensity", gt7.intensity)
            .promise("TONE_MAP_SAME_SPACE", is_same_space)
            .write("result", desc);
    }
}

impl ToneMap {
    fn kernel(&self) -> &'static str {
        let [clip, compress] = match self.curve {
            Curve::None => ["tone_map_none", "tone_map_none_compressed"],
            Curve::Reinhard => ["tone_map_reinhard", "tone_map_reinhard_compressed"],
            Curve::ReinhardExtended => ["tone_map_reinhard_extended", "tone_map_reinhard_extended_compressed"],
            Curve::ReinhardLuminance => ["tone_map_reinhard_luminance", "tone_map_reinhard_luminance_compressed"],
            Curve::Exponential => ["tone_map_exponential", "tone_map_exponential_compressed"],
            Curve::Aces => ["tone_map_aces", "tone_map_aces_compressed"],
            Curve::AcesHill => ["tone_map_aces_hill", "tone_map_aces_hill_compressed"],
            Curve::Hable => ["tone_map_hable", "tone_map_hable_compressed"],
            Curve::Uchimura => ["tone_map_uchimura", "tone_map_uchimura_compressed"],
            Curve::KhronosNeutral => ["tone_map_khronos_neutral", "tone_map_khronos_neutral_compressed"],
            Curve::AgX => self.agx_kernels(),
            Curve::Gt7 => ["tone_map_gt7", "tone_map_gt7_compressed"],
        };
        if self.gamut == Gamut::Compress { compress } else { clip }
    }

    fn agx_kernels(&self) -> [&'static str; 2] {
        match (self.sigmoid, self.look) {
            (Sigmoid::Exact, AgxLook::Base) => ["tone_map_agx", "tone_map_agx_compressed"],
            (Sigmoid::Exact, _) => ["tone_map_agx_looked", "tone_map_agx_looked_compressed"],
            (Sigmoid::Polynomial, AgxLook::Base) => ["tone_map_agx_fast", "tone_map_agx_fast_compressed"],
            (Sigmoid::Polynomial, _) => ["tone_map_agx_fast_looked", "tone_map_agx_fast_looked_compressed"],
        }
    }

    fn custom(&self) -> Chromaticities {
        let [red, green, blue, white] = [self.red, self.green, self.blue, self.white].map(Xy::from);
        Chromaticities { red, green, blue, white }
    }

    /// The matrices from Rec.709 to the working space and back.
    pub(crate) fn space_conversions(&self) -> [DMat3; 2] {
        let space = match (self.curve, self.space) {
            (Curve::AcesHill, _) => return [HILL_IN, HILL_OUT],
            (Curve::Gt7, _) | (_, WorkingSpace::Rec2020) => Chromaticities::REC2020,
            (curve, _) if curve.has_own_space() => Chromaticities::REC709,
            (_, WorkingSpace::Rec709) => Chromaticities::REC709,
            (_, WorkingSpace::AcesCg) => Chromaticities::ACES_CG,
            (_, WorkingSpace::Tsushima) => TSUSHIMA,
            (_, WorkingSpace::Custom) => self.custom(),
        };
        [Chromaticities::REC709.conversion(&space), space.conversion(&Chromaticities::REC709)]
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
        Gt7::new(2.5 * f64::from(self.peak))
    }
}

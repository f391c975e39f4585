//! Encode: the transfer function and the primaries of a display or a file.

use afterimage_graph::color::{self, Chromaticities, Colorimetry, hlg_gamma};
use afterimage_graph::prelude::*;

use crate::tone_map::Gamut;
use afterimage_color::adaptation::{luminance_weights, rows};

static SHADER: Shader = shader!("encode");

choices! {
    /// Transfer functions.
    pub enum Transfer {
        /// sRGB by its exact definition (IEC 61966-2-1).
        Srgb,
        /// x^(1/gamma). With 2.2 it differs from sRGB by up to 8.6 codes of 8 bits, in the shadows.
        Gamma,
        /// None: for files that hold linear light.
        Linear,
        /// Perceptual quantizer (SMPTE ST 2084): absolute luminance, for HDR10.
        Pq,
        /// Hybrid log-gamma (ITU-R BT.2100): HDR relative to the peak of the display.
        Hlg,
    }
}

choices! {
    /// The primaries of the display.
    pub enum Primaries {
        /// sRGB and HDTV.
        Rec709,
        /// Display P3, white D65.
        DisplayP3,
        /// UHDTV and HDR. `Hlg` and `Pq` are defined with these primaries.
        Rec2020,
    }
}

impl Primaries {
    pub(crate) fn space(self) -> Chromaticities {
        match self {
            Self::Rec709 => Chromaticities::REC709,
            Self::DisplayP3 => Chromaticities::DISPLAY_P3,
            Self::Rec2020 => Chromaticities::REC2020,
        }
    }
}

node_kind! {
    /// Encodes display-linear light for a file or a display. A pipeline needs exactly one of these nodes.
    ///
    /// The result is stored in half floats unless `format` says otherwise, so that a `Dither` after it reads unrounded
    /// values. Both usually run in one dispatch, and the file writer rounds. To write to an `-srgb` texture, use
    /// `transfer: Linear`: the device encodes. `Srgb`, `Gamma` and `Linear` clip to 0 to 1; `Pq` and `Hlg` accept more,
    /// up to `peak_nits`. A `ToneMap` before it maps the light into these primaries, or into wider ones if the same
    /// light is also encoded for those: then `gamut` fits the colors into these primaries.
    pub struct Encode {
        /// The transfer function.
        pub transfer: Transfer = Transfer::Srgb;
        /// The primaries of the result.
        pub primaries: Primaries = Primaries::Rec709;
        /// How colors outside of these primaries are fitted into them. Without effect where the source has these
        /// primaries or narrower ones.
        pub gamut: Gamut = Gamut::Compress;
        /// For `Gamma`: the gamma of the display. 1 is linear.
        pub gamma: f32 = 2.2
            => within(0.1..=10.0), usually(1.8..=2.6), neutral(1.0), replans(), when("transfer", [Transfer::Gamma]);
        /// For `Pq` and `Hlg`: the luminance of display-linear 1, which is SDR white. 203 is the reference white of
        /// ITU-R BT.2408.
        pub white_nits: f32 = 203.0
            => within(1.0..=10000.0), usually(80.0..=400.0), unit("cd/m2"), replans(),
               when("transfer", [Transfer::Pq, Transfer::Hlg]);
        /// For `Pq`: light above is clipped. For `Hlg`: the peak of the display, which is signal 1.
        pub peak_nits: f32 = 1000.0
            => within(100.0..=10000.0), usually(400.0..=4000.0), unit("cd/m2"), replans(),
               when("transfer", [Transfer::Pq, Transfer::Hlg]);
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "Display-linear light.").accepts(&[ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Encoded), "The signal, 0 to 1.").or_input("source")];
    const INVARIANTS: Invariants = Invariants { monotone: true, ..Invariants::OF_COLOR };
}

impl Node for Encode {
    fn color(&self) -> ColorChange {
        let primaries = self.primaries.space();
        let (white, peak) = (f64::from(self.white_nits), f64::from(self.peak_nits));
        ColorChange::Encode(match self.transfer {
            Transfer::Srgb => Colorimetry::new(primaries, color::Transfer::Srgb),
            Transfer::Gamma => Colorimetry::new(primaries, color::Transfer::Gamma(self.gamma.into())),
            Transfer::Linear => Colorimetry::linear(primaries),
            Transfer::Pq => Colorimetry::new(primaries, color::Transfer::Pq).nits(white, peak),
            Transfer::Hlg => Colorimetry::new(primaries, color::Transfer::Hlg).nits(white, peak),
        })
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let (from, to) = (pass.color("source").colorimetry.primaries, self.primaries.space());
        let to_display = rows(from.conversion(&to));
        pass.function(&SHADER, self.kernel())
            .set("row0", to_display[0])
            .set("row1", to_display[1])
            .set("row2", to_display[2])
            .set("system_power", hlg_power(f64::from(self.peak_nits)))
            .set("luminance_weights", luminance_weights(&to).to_array())
            .set("limit", self.limit())
            .set("compresses", if self.gamut == Gamut::Compress && !is_within(&from, &to) { 1.0 } else { 0.0 })
            .define("ENCODE_SAME_PRIMARIES", from == to)
            .write("result", desc);
    }
}

impl Encode {
    /// The brightest light of the result, in units of SDR white.
    fn limit(&self) -> f32 {
        match self.transfer {
            Transfer::Srgb | Transfer::Gamma | Transfer::Linear => 1.0,
            Transfer::Pq | Transfer::Hlg => self.peak_nits / self.white_nits,
        }
    }

    fn kernel(&self) -> &'static str {
        match self.transfer {
            Transfer::Srgb => "encode_srgb",
            Transfer::Gamma => "encode_gamma",
            Transfer::Linear => "encode_linear",
            Transfer::Pq => "encode_pq",
            Transfer::Hlg => "encode_hlg",
        }
    }
}

/// True if no color of the first primaries is outside of the others, up to the rounding of published coordinates.
fn is_within(from: &Chromaticities, to: &Chromaticities) -> bool {
    from.conversion(to).to_cols_array().into_iter().all(|share| share >= -0.005)
}

/// The power of luminance that inverts the system gamma of an HLG display.
fn hlg_power(peak: f64) -> f64 {
    let gamma = hlg_gamma(peak);
    (1.0 - gamma) / gamma
}

//! ReferenceGamutCompress: the reference gamut compression of ACES 1.3.

use afterimage_graph::color::Chromaticities;
use afterimage_graph::prelude::*;

use afterimage_color::adaptation::rows;

static SHADER: Shader = shader!("reference_gamut_compress");

node_kind! {
    /// Brings colors of cameras and wide gamuts into AP1, before the tone curve.
    ///
    /// The reference gamut compression of ACES 1.3 (LMT.Academy.ReferenceGamutCompress). In AP1, the distance of each
    /// channel from the largest one is compressed, so that negative channels become positive, and colors up to 80 %
    /// of the gamut stay the same. Use it where saturated lights of wide-gamut sources become flat patches. It is
    /// scene light before and after: colors outside of Rec.709 keep negative channels.
    pub struct ReferenceGamutCompress {
    }

    const INPUTS: &'static [Input] =
        &[Input::image("source", "Scene light.").accepts(&[ColorState::Scene, ColorState::Exposed])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The light, with no color outside of AP1.")
            .or_input("source")];
    const INVARIANTS: Invariants = Invariants::OF_COLOR;
}

/// Where the compression of red, green and blue begins, and the distance that becomes 1: as published, for cyan,
/// magenta and yellow.
const THRESHOLD: [f64; 3] = [0.815, 0.803, 0.880];
const LIMIT: [f64; 3] = [1.147, 1.264, 1.312];

/// The exponent of the compression.
const POWER: f64 = 1.2;

/// The scale with which the distance `limit` becomes 1.
fn scale(threshold: f64, limit: f64) -> f64 {
    let room = (1.0 - threshold) / (limit - threshold);
    (limit - threshold) / (room.powf(-POWER) - 1.0).powf(1.0 / POWER)
}

impl Node for ReferenceGamutCompress {
    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let (rec709, ap1) = (Chromaticities::REC709, Chromaticities::ACES_CG);
        let [enter, leave] = [rec709.conversion(&ap1), ap1.conversion(&rec709)].map(rows);
        let [r, g, b] = [0, 1, 2].map(|channel| scale(THRESHOLD[channel], LIMIT[channel]));
        pass.function(&SHADER, "reference_gamut_compress")
            .set("enter0", enter[0])
            .set("enter1", enter[1])
            .set("enter2", enter[2])
            .set("leave0", leave[0])
            .set("leave1", leave[1])
            .set("leave2", leave[2])
            .set("threshold", THRESHOLD)
            .set("distance_scale", [r, g, b])
            .write("result", desc);
    }
}

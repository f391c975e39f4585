//! Purkinje: color vision in dim light.

use afterimage_graph::prelude::*;
use glam::{DMat3, DVec3};

static SHADER: Shader = shader!("purkinje");

node_kind! {
    /// Simulates night vision by a model of rods and cones: the Purkinje shift.
    ///
    /// In dim light the rods add to the signals of the cones: the image turns blue, dark reds disappear and differences
    /// of hue fade.
    ///
    /// The model is that of Cao, Pokorny and Smith (2008) with the regulation of Kirk and O'Brien (2011), as used in
    /// games by Patry (2021). Cone responses are those of linear Rec.709 under D65. It is the identity at 10 lux and
    /// above and has full effect at 0.01 lux and below, with a Hermite step of log10 of lux between. Black stays black.
    /// It expects exposed light before any tone curve.
    pub struct Purkinje {
        /// Illuminance of the scene, if `meter` is not wired. 10 and more changes nothing.
        pub illuminance: f32 = 0.1
            => within(0.0..=100000.0), usually(0.0..=10.0), unit("lux"), neutral(10.0), when_wired("meter", false);
        /// Share of the effect. 0 changes nothing, 1 is the full model.
        pub strength: f32 = 1.0 => within(0.0..=1.0), neutral(0.0);
        /// Factor from exposed luminance to the range of the model's receptors. More reduces the effect of the rods.
        pub scale: f32 = 380.0 => within(1.0..=10000.0), usually(50.0..=2000.0), logarithmic();
    }

    const INPUTS: &'static [Input] = INPUTS;
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The image as seen in dim light.").or_input("source")];
}

/// Illuminance in lux at which the effect ends, and at which it is full.
pub(crate) const PHOTOPIC_LUX: f32 = 10.0;
const SCOTOPIC_LUX: f32 = 0.01;

/// Linear Rec.709 to the responses of the L, M and S cones under D65, row by row (spectral integration published with
/// Filament).
const LMS: [[f64; 3]; 3] =
    [[7.696847, 18.424824, 2.068096], [2.431137, 18.697937, 3.012463], [0.289117, 1.401833, 13.792292]];
/// Linear Rec.709 to the response of the rods.
const RODS: [f64; 3] = [0.466386, 15.564362, 10.059963];
/// Maximum sensitivities of the cones, and the strength of the rods in each cone's pathway (Cao et al.).
const SENSITIVITY: DVec3 = DVec3::new(0.63721, 0.39242, 1.6064);
const ROD_STRENGTH: DVec3 = DVec3::new(0.2, 0.2, 0.3);
/// The opponent channels M - L, S - (L + M) and L + M, row by row.
const OPPONENT: [[f64; 3]; 3] = [[-1.0, 1.0, 0.0], [-1.0, -1.0, 1.0], [1.0, 1.0, 0.0]];
/// Contribution of rods to the opponent channels (Cao et al.): overall gain K over S, then k3, rw and p.
const GAIN: f64 = 45.0;
const SURROUND: f64 = 10.0;
const K3: f64 = 0.6;
const RW: f64 = 0.139;
const P: f64 = 0.6189;

fn rows(rows: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(&rows).transpose()
}

/// The model as two matrices and a row: the input of each cone's gain, the effect of gains times rods on Rec.709, and
/// the response of the rods.
struct Folded {
    drive: DMat3,
    effect: DMat3,
    rods: DVec3,
}

impl Folded {
    fn new(scale: f64) -> Self {
        let rods = DVec3::from(RODS);
        let from_rods = DMat3::from_cols(ROD_STRENGTH * rods.x, ROD_STRENGTH * rods.y, ROD_STRENGTH * rods.z);
        let regulation = DMat3::from_diagonal(0.33 / SENSITIVITY * scale);
        let to_opponent = rows([
            [-(K3 + RW), 1.0 + K3 * RW, 0.0],
            [P * K3, (1.0 - P) * K3, 1.0],
            [P * SURROUND, (1.0 - P) * SURROUND, 0.0],
        ]) * (GAIN / SURROUND);
        let strengths = DMat3::from_diagonal(ROD_STRENGTH / SENSITIVITY);
        let effect = rows(LMS).inverse() * rows(OPPONENT).inverse() * to_opponent * strengths;
        Self { drive: regulation * (rows(LMS) + from_rods), effect, rods }
    }
}

fn row(matrix: DMat3, index: usize) -> [f64; 3] {
    matrix.row(index).to_array()
}

/// Share of dark adaptation: 1 at 0.01 lux, 0 at 10, by a Hermite step of the logarithm.
fn darkness(lux: f32) -> f64 {
    let lux = f64::from(lux.clamp(SCOTOPIC_LUX, PHOTOPIC_LUX));
    let t = ((1.0 - lux.log10()) / 3.0).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// True if a kind that acts only in dim light is the identity.
pub(crate) fn has_no_effect(strength: f32, illuminance: f32, inputs: &InputValues) -> bool {
    let bright = illuminance >= PHOTOPIC_LUX && inputs.is_absent("meter");
    strength == 0.0 || bright || inputs.is_zero("source")
}

/// The input ports of the kinds that act in dim light.
pub(crate) const INPUTS: &[Input] = &[
    Input::image("source", "The exposed image.").accepts(&[ColorState::Exposed]),
    Input::new("meter", PortType::Value, "Lux in z: the result of a metering node. It replaces `illuminance`.")
        .content("exposure")
        .optional(),
];

impl Node for Purkinje {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        has_no_effect(self.strength, self.illuminance, inputs)
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = pass.desc(source);
        let folded = Folded::new(f64::from(self.scale));
        let metered = pass.wired("meter");
        let function = if metered { "purkinje_metered" } else { "purkinje" };
        let darkness = if metered { 1.0 } else { darkness(self.illuminance) };
        pass.function(&SHADER, function)
            .set("drive0", row(folded.drive, 0))
            .set("drive1", row(folded.drive, 1))
            .set("drive2", row(folded.drive, 2))
            .set("rods", folded.rods.to_array())
            .set("effect0", row(folded.effect, 0))
            .set("effect1", row(folded.effect, 1))
            .set("effect2", row(folded.effect, 2))
            .set("strength", f64::from(self.strength) * darkness)
            .write("result", desc);
    }
}

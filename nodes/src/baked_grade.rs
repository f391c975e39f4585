//! BakedGrade: white balance, tone curve, lift-gamma-gain and transfer function as one fetch from a table.

use afterimage_graph::color::{Colorimetry, Transfer};
use afterimage_graph::prelude::*;

use crate::bake::{Chain, Signal};
use crate::encode::Primaries;
use crate::lift_gamma_gain::LiftGammaGain;
use crate::tone_map::{Curve, ToneMap, WorkingSpace};
use crate::white_balance::{WhiteBalance, WhiteBalanceMode};
use afterimage_color::adaptation::{Cones, rows};
use afterimage_color::lut::Interpolation;
use afterimage_color::shaper::Shape;

static SHADER: Shader = shader!("baked_grade");

choices! {
    /// How the axes of the table are spaced.
    pub enum BakedShaper {
        /// A camera's logarithm with a linear part near black: finest near black, exact at black.
        LogC,
        /// Equal steps in stops, from 2^-13 up. Darker light counts as 2^-13.
        Log2,
    }
}

choices! {
    /// The transfer function of the table.
    pub enum BakedTransfer {
        /// sRGB.
        Srgb,
        /// x^(1/gamma).
        Gamma,
        /// None: for an `-srgb` texture, where the device encodes.
        Linear,
    }
}

/// The darkest light of the `Log2` axes, in stops from 1.
const LOG2_LOW: f64 = -13.0;

params! {
    /// `WhiteBalance`, `ToneMap`, `LiftGammaGain` and `Encode` as one fetch from a table: fast, not exact.
    ///
    /// The table is computed in double precision when the plan is made, so a change of any parameter needs a new plan.
    /// With `size` 64 and `LogC`, the error against the four nodes is, for 99 % of all channels, below 0.6 codes of 8
    /// bits with `Aces2ToneScale` and `AgX`, 0.7 with `AcesNarkowicz`, 1.0 with `Uchimura` in the Tsushima space and
    /// 1.5 with `KhronosNeutral`, measured over light from 0.0001 to 60 of any saturation with a warm balance. Where
    /// the hue or the gamut bends within a cell of the table, single saturated colors have larger errors: 6 codes
    /// with `AgX`, 8 with `Aces2ToneScale`, 11 with `AcesNarkowicz` and 17 with `Uchimura`. A larger table does not
    /// remove these. `size` 32 has three to four times the error. Light above 2^`high` counts as 2^`high`.
    ///
    /// The axes of the table are light in `primaries`, without negative channels: before and after the white balance,
    /// colors outside of these primaries are clipped to them, which the four nodes do not do. For a source of wide
    /// colors and a Rec.709 display, use the four nodes.
    pub struct BakedGrade {
        /// Entries per side of the table.
        pub size: u32 = 64 => within(8.0..=96.0), usually(16.0..=64.0), quality(64, [48, 32, 16]);
        /// How the axes of the table are spaced.
        pub shaper: BakedShaper = BakedShaper::LogC;
        /// The brightest light of the table. Brighter light counts as this.
        pub high: f32 = 6.0 => within(5.0..=16.0), usually(5.0..=10.0), unit("stops from 1"), replans();
        /// How the table is interpolated. `Tetrahedral` takes four reads instead of one and halves the error of
        /// `KhronosNeutral`; the other curves gain little.
        pub interpolation: Interpolation = Interpolation::Trilinear;
        /// The color that white becomes, as in `WhiteBalance` with Bradford and `keep_luminance`.
        pub target: [f32; 3] = [1.0, 1.0, 1.0]
            => within(0.0..=16.0), usually(0.0..=1.0), neutral([1.0, 1.0, 1.0]), replans();
        /// The tone curve, as in `ToneMap` with default parameters.
        pub curve: Curve = Curve::Aces2ToneScale;
        /// The working space of the curve, as in `ToneMap`.
        pub space: WorkingSpace = WorkingSpace::Auto;
        /// Added to black, as in `LiftGammaGain` with `lift_by: Luminance`.
        pub lift: [f32; 3] = [0.0, 0.0, 0.0]
            => within(-1.0..=1.0), usually(-0.1..=0.1), neutral([0.0, 0.0, 0.0]), replans();
        /// Exponent 1/gamma, as in `LiftGammaGain`.
        pub gamma: [f32; 3] = [1.0, 1.0, 1.0]
            => within(0.05..=20.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]), replans();
        /// Factor of each channel, as in `LiftGammaGain`.
        pub gain: [f32; 3] = [1.0, 1.0, 1.0]
            => within(0.0..=16.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]), replans();
        /// The transfer function, as in `Encode`.
        pub transfer: BakedTransfer = BakedTransfer::Srgb;
        /// The primaries of the result, as in `Encode`. Those of the table's axes, too.
        pub primaries: Primaries = Primaries::Rec709;
        /// For `transfer: Gamma`: the gamma of the display.
        pub display_gamma: f32 = 2.2 => within(0.1..=10.0), usually(1.8..=2.6), replans();
    }
}

impl Node for BakedGrade {
    const INPUTS: &'static [Input] = &[Input::image("source", "Exposed light.").accepts(&[ColorState::Exposed])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Encoded), "The signal, 0 to 1.").or_input("source")];

    fn verify(&self) -> Result<(), String> {
        self.tone_map().verify()
    }

    fn color(&self) -> ColorChange {
        let transfer = match self.transfer {
            BakedTransfer::Srgb => Transfer::Srgb,
            BakedTransfer::Gamma => Transfer::Gamma(self.display_gamma.into()),
            BakedTransfer::Linear => Transfer::Linear,
        };
        ColorChange::Encode(Colorimetry::new(self.primaries.space(), transfer))
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let (from, to) = (pass.color("source").colorimetry.primaries, self.primaries.space());
        let to_axes = rows(from.conversion(&to));
        let table = self.table(pass);
        let shape = self.shape();
        let kernel = match self.interpolation {
            Interpolation::Trilinear => "baked_grade",
            Interpolation::Tetrahedral => "baked_grade_tetrahedral",
        };
        pass.function(&SHADER, kernel)
            .set("row0", to_axes[0])
            .set("row1", to_axes[1])
            .set("row2", to_axes[2])
            .set("line", shape.line)
            .set("shaper_curve", shape.curve)
            .promise("BAKED_GRADE_SAME_PRIMARIES", from == to)
            .read("table", table)
            .write("result", desc);
    }
}

impl BakedGrade {
    fn tone_map(&self) -> ToneMap {
        ToneMap { curve: self.curve, space: self.space, ..ToneMap::default() }
    }

    fn chain(&self) -> Chain {
        let mode = WhiteBalanceMode::Target;
        Chain {
            balance: WhiteBalance { mode, adaptation: Cones::Bradford, target: self.target, ..WhiteBalance::default() },
            curve: self.tone_map(),
            grade: LiftGammaGain { lift: self.lift, gamma: self.gamma, gain: self.gain, ..LiftGammaGain::default() },
            signal: match self.transfer {
                BakedTransfer::Srgb => Signal::Srgb,
                BakedTransfer::Gamma => Signal::Gamma(f64::from(self.display_gamma)),
                BakedTransfer::Linear => Signal::Linear,
            },
            display: self.primaries.space(),
        }
    }

    fn shape(&self) -> Shape {
        match self.shaper {
            BakedShaper::LogC => Shape::log_c(f64::from(self.high)),
            BakedShaper::Log2 => Shape::log2(LOG2_LOW, f64::from(self.high)),
        }
    }

    fn table(&self, pass: &mut Recorder<'_>) -> ImageId {
        let desc = ImageDesc::volume(Size::volume(self.size, self.size, self.size));
        pass.computed("table", desc, || {
            let lut = self.chain().bake(self.size as usize, self.shape());
            let cube = lut.cube.expect("a baked table is a cube");
            cube.bytes(true, cube.entries.len())
        })
    }
}

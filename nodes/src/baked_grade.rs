//! BakedGrade: white balance, tone curve, lift-gamma-gain and transfer function as one fetch from a table.

use afterimage_graph::prelude::*;

use crate::bake::{Chain, Signal};
use crate::color::Cones;
use crate::color_lut::Interpolation;
use crate::lift_gamma_gain::LiftGammaGain;
use crate::shaper::Shape;
use crate::tone_map::{Curve, ToneMap, WorkingSpace};
use crate::white_balance::{WhiteBalance, WhiteBalanceMode};

static SHADER: Shader = shader!("baked_grade");

choices! {
    /// How the axes of a baked table are spaced.
    pub enum BakedShaper {
        /// A camera's logarithm with a straight foot: finest near black, exact at black.
        LogC,
        /// Even in stops from 2^-13 on; what is darker counts as that.
        Log2,
    }
}

choices! {
    /// The transfer function in a baked table.
    pub enum BakedTransfer {
        /// sRGB.
        Srgb,
        /// x^(1/gamma).
        Gamma,
        /// None: an `-srgb` texture encodes.
        Linear,
    }
}

/// The darkest light of the log2 shaper, in stops.
const LOG2_LOW: f64 = -13.0;

params! {
    /// `WhiteBalance`, `ToneMap`, `LiftGammaGain` and `Encode` as one fetch from a table: fast, and not exact.
    ///
    /// The table is computed in double precision when the plan is made, so every parameter needs a new plan. With 64 nodes and `LogC` the
    /// error against the nodes themselves is, for 99 of 100 channels, below 0.4 codes of 8 bits with `Aces`, 0.5 with `AgX`, 0.7 with
    /// `Uchimura` in the Tsushima space and 1.4 with `KhronosNeutral`, measured over light from 0.0001 to 60 of any saturation with a warm
    /// balance. Where a channel is cut off within a cell of the table, single saturated colours are further off: 2 codes with `AgX`, 9 with
    /// `Uchimura`, 20 with `Aces` in a channel that is nearly black; no size removes that. 32 nodes have three to four times the error. Light
    /// above 2^`high` counts as 2^`high`. The gamut is clipped.
    pub struct BakedGrade {
        /// Nodes of a side of the table.
        pub size: u32 = 64 => within(8.0..=96.0), usually(16.0..=64.0), quality(64, [48, 32, 16]);
        /// How its axes are spaced.
        pub shaper: BakedShaper = BakedShaper::LogC;
        /// The brightest light that the table tells apart.
        pub high: f32 = 6.0 => within(5.0..=16.0), usually(5.0..=10.0), unit("stops from 1"), replans();
        /// How it is read. Tetrahedral takes four reads for one and halves the error of `KhronosNeutral`; others gain little.
        pub interpolation: Interpolation = Interpolation::Trilinear;
        /// What white becomes, as in `WhiteBalance`: by Bradford, as bright as before.
        pub target: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.0..=1.0), neutral([1.0, 1.0, 1.0]), replans();
        /// The curve, as in `ToneMap` at the defaults of its parameters.
        pub curve: Curve = Curve::Aces;
        /// The space in which the curve works.
        pub space: WorkingSpace = WorkingSpace::Rec709;
        /// As in `LiftGammaGain`, by luminance.
        pub lift: [f32; 3] = [0.0, 0.0, 0.0] => within(-1.0..=1.0), usually(-0.1..=0.1), neutral([0.0, 0.0, 0.0]), replans();
        /// As in `LiftGammaGain`.
        pub gamma: [f32; 3] = [1.0, 1.0, 1.0] => within(0.05..=20.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]), replans();
        /// As in `LiftGammaGain`.
        pub gain: [f32; 3] = [1.0, 1.0, 1.0] => within(0.0..=16.0), usually(0.5..=2.0), neutral([1.0, 1.0, 1.0]), replans();
        /// The transfer function, as in `Encode`.
        pub transfer: BakedTransfer = BakedTransfer::Srgb;
        /// For `transfer: Gamma`: the display's gamma.
        pub display_gamma: f32 = 2.2 => within(0.1..=10.0), usually(1.8..=2.6), replans();
    }
}

impl Node for BakedGrade {
    const INPUTS: &'static [Input] = &[Input::image("source", "Exposed light.").accepts(&[ColorState::Exposed])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Always(ColorState::Encoded), "The signal, Rec.709, 0 to 1.")];
    const FALLBACK: Fallback = Fallback::Input("source");

    fn verify(&self) -> Result<(), String> {
        self.tone_map().verify()
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let table = self.table(pass);
        let shape = self.shape();
        let kernel = match self.interpolation {
            Interpolation::Trilinear => "baked_grade",
            Interpolation::Tetrahedral => "baked_grade_tetrahedral",
        };
        pass.function(&SHADER, kernel)
            .set("line", shape.line)
            .set("shaper_curve", shape.curve)
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
        }
    }

    fn shape(&self) -> Shape {
        match self.shaper {
            BakedShaper::LogC => Shape::log_c(f64::from(self.high)),
            BakedShaper::Log2 => Shape::log2(LOG2_LOW, f64::from(self.high)),
        }
    }

    fn table(&self, pass: &mut Recorder<'_>) -> ImageId {
        let lut = self.chain().bake(self.size as usize, self.shape());
        let cube = lut.cube.expect("a baked table is a cube");
        let desc = ImageDesc::volume(Size::volume(self.size, self.size, self.size));
        pass.constant("table", desc, cube.bytes(true, cube.entries.len()))
    }
}

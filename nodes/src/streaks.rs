//! Streaks: light drawn out to both sides, as anamorphic lenses do.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("streaks");

choices! {
    /// The direction of streaks.
    pub enum StreaksAxis {
        /// To the left and to the right, as anamorphic lenses make them.
        Across,
        /// Upwards and downwards.
        Down,
    }
}

node_kind! {
    /// Draws light out into lines to both sides, as anamorphic lenses do: light for a `Composite`.
    ///
    /// Wire the light of an `Extract` to it, at half or a quarter of the resolution. Each side is an exponential tail,
    /// exact up to `length` times 5, where 0.7 % of the light is left. It is made in passes of four reads, each four
    /// times as far apart as those of the pass before: Kawase, "Frame Buffer Postprocessing Effects in
    /// DOUBLE-S.T.E.A.L", GDC 2003. A constant keeps its value but near the border, outside of which there is no light.
    /// Alpha is that of the source.
    pub struct Streaks {
        /// The distance at which the light has fallen to 1/e, in widths of the image for `Across`, in heights for
        /// `Down`.
        pub length: f32 = 0.08 => within(0.0..=1.0), usually(0.0..=0.3), replans();
        /// The direction.
        pub axis: StreaksAxis = StreaksAxis::Across;
        /// The color that the lens gives the streaks.
        pub tint: [f32; 3] = [0.35, 0.6, 1.0] => within(0.0..=4.0);
        /// Factor of the result.
        pub intensity: f32 = 1.0 => within(0.0..=64.0), usually(0.0..=8.0), neutral(1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The light that makes streaks, black elsewhere.")
        .accepts(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The streaks, of the size of the source.")];
    const INVARIANTS: Invariants = Invariants { constant: false, ..Invariants::DEFAULT };
}

/// A tail ends at this many lengths.
const REACH: f32 = 5.0;
const TAPS: u32 = 4;
/// The most passes of one side: a tail of 16384 texels.
const MAX_PASSES: u32 = 7;

impl Streaks {
    /// The distances between the taps of each pass, for a length in texels.
    fn steps(length: f32) -> impl Iterator<Item = i32> {
        let is_enough = |passes: &u32| TAPS.pow(*passes) as f32 >= REACH * length;
        let passes = (1..MAX_PASSES).find(is_enough).unwrap_or(MAX_PASSES);
        (0..passes).map(|pass| TAPS.pow(pass) as i32)
    }

    fn tail(&self, pass: &mut Recorder<'_>, source: ImageId, side: i32) -> ImageId {
        let desc = ImageDesc::new(pass.desc(source).size);
        let (axis, extent) = match self.axis {
            StreaksAxis::Across => ([1, 0], desc.size.width),
            StreaksAxis::Down => ([0, 1], desc.size.height),
        };
        let length = (self.length * extent as f32).max(1e-3);
        let name = if side < 0 { "before" } else { "after" };
        let mut image = source;
        for step in Self::steps(length) {
            let result = pass.transient(format_args!("{name} {step}"), desc);
            let decay = (-f64::from(step) / f64::from(length)).exp();
            pass.function(&SHADER, "streaks_tail")
                .label(format_args!("streaks_tail {name} by {step}"))
                .read("source", image)
                .set("axis", axis)
                .set("step", side * step)
                .set("decay", decay)
                .set("scale", 1.0 / (1.0 + decay + decay.powi(2) + decay.powi(3)))
                .write_to(result);
            image = result;
        }
        image
    }
}

impl Node for Streaks {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let desc = ImageDesc::new(pass.desc(source).size);
        let [before, after] = [-1, 1].map(|side| self.tail(pass, source, side));
        pass.function(&SHADER, "streaks")
            .read("before", before)
            .read("after", after)
            .set("axis", [0, 0])
            .set("step", 0)
            .set("decay", 0.0)
            .set("scale", 0.0)
            .write("result", desc);
    }
}

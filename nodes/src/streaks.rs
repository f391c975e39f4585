//! Streaks: light drawn out to several sides, as anamorphic lenses and stars do.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("streaks");

node_kind! {
    /// Draws light out into lines: to both sides, as anamorphic lenses do, or into stars. Light for a `Composite`.
    ///
    /// Wire the light of an `Extract` to it, at half or a quarter of the resolution. Each line is an exponential tail,
    /// exact up to `length` times 5, where 0.7 % of the light is left. It is made in passes of four reads, each four
    /// times as far apart as those of the pass before: Kawase, "Frame Buffer Postprocessing Effects in
    /// DOUBLE-S.T.E.A.L", GDC 2003. A lens with an even number of blades makes a star of as many points, one with an
    /// odd number twice as many. A constant keeps its value but near the border, outside of which there is no light.
    /// Alpha is that of the source.
    pub struct Streaks {
        /// The distance at which the light has fallen to 1/e.
        pub length: f32 = 0.14 => within(0.0..=2.0), usually(0.0..=0.5), unit("heights"), replans();
        /// Lines of a light, at equal angles.
        pub points: u32 = 2 => within(1.0..=16.0), usually(2.0..=8.0);
        /// The direction of the first line, clockwise; 0 is to the right.
        pub rotation: f32 = 0.0 => within(-360.0..=360.0), unit("degrees");
        /// The color that the lens gives the streaks.
        pub tint: [f32; 3] = [0.35, 0.6, 1.0] => within(0.0..=4.0);
        /// Factor of the result.
        pub intensity: f32 = 1.0 => within(0.0..=64.0), usually(0.0..=8.0), neutral(1.0);
    }

    const INPUTS: &'static [Input] = &[Input::image("source", "The light that makes streaks, black elsewhere.")
        .accepts(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The streaks, of the size of the source.")];
    const INVARIANTS: Invariants = Invariants { constant: false, symmetric: false, ..Invariants::DEFAULT };
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

    /// The tail in a direction.
    fn tail(&self, pass: &mut Recorder<'_>, source: ImageId, point: u32) -> ImageId {
        let desc = ImageDesc::new(pass.desc(source).size);
        let length = (self.length * desc.size.height as f32).max(1e-3);
        let turn = 360.0 * f64::from(point) / f64::from(self.points) + f64::from(self.rotation);
        let (sin, cos) = turn.to_radians().sin_cos();
        let mut image = source;
        for step in Self::steps(length) {
            let result = pass.transient(format_args!("tail {point} by {step}"), desc);
            let decay = (-f64::from(step) / f64::from(length)).exp();
            pass.function(&SHADER, "streaks_tail")
                .label(format_args!("streaks_tail {point} by {step}"))
                .read("source", image)
                .set("step", [cos, sin].map(|along| f64::from(step) * along))
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
        let mut tails = self.tail(pass, source, 0);
        for point in 1..self.points {
            let tail = self.tail(pass, source, point);
            let both = pass.transient(format_args!("tails to {point}"), desc);
            pass.function(&SHADER, "streaks_both").read("before", tails).read("after", tail).write_to(both);
            tails = both;
        }
        pass.function(&SHADER, "streaks")
            .read("tails", tails)
            .set("share", 1.0 / f64::from(self.points))
            .write("result", desc);
    }
}

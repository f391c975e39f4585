//! Extract: keeps the light that bloom spreads.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("extract");

const STATES: &[ColorState] = &[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear];

choices! {
    /// Selection method.
    pub enum ExtractMethod {
        /// The part above the threshold, with a quadratic knee: the subtractive threshold of Jimenez, Unity and
        /// Tsushima.
        Knee,
        /// All of the light of a pixel above the threshold, with a smooth step between: the threshold of Lynx.
        Gate,
        /// A luminance clamp for an image after the exponential curve: twice the color, through a smooth step from
        /// luminance 0.8 to 1. Ignores `threshold`, `knee` and `brightness`.
        Clamp,
        /// Alpha is the emissive strength, up to 1. The result is color times alpha where alpha is at least the
        /// threshold: Caracal's selective bloom. A mask of 0 and 1 selects at each threshold from 0 to 1.
        Emissive,
        /// All light: for a `Composite` with `blend: Mix`.
        All,
    }
}

choices! {
    /// The quantity that the threshold applies to.
    pub enum Brightness {
        /// The largest channel, which does not miss saturated lights.
        Max,
        /// Luminance of Rec.709: a pure blue light counts as 7 % of its value.
        Luminance,
    }
}

choices! {
    /// Limit of single bright pixels, which would flicker in the bloom, before the selection.
    pub enum Fireflies {
        /// They are not.
        Keep,
        /// A pixel more than four times as bright as the brightest of the eight around it is dimmed to that limit. A
        /// light that covers two pixels or more keeps all of its energy wherever it moves.
        Limit,
    }
}

node_kind! {
    /// Selects the light that bloom spreads: the color of the source times a weight.
    ///
    /// Place it after the exposure, so that the threshold is a display brightness and does not depend on the units of
    /// the scene. Black stays black, and no result is brighter than the source times `intensity`, or for `Clamp` twice
    /// that. Results are limited to 65504. Alpha passes unchanged.
    ///
    /// `fireflies: Limit` compares each pixel with the eight around it and, with `before` wired to the own output
    /// `peaks` of the previous frame (`before: "bright.peaks@previous"`), with what was near in that frame: a light
    /// stays that is at most twice as bright as the brightest within seven pixels. So most outliers of one frame go,
    /// and rain, stars and sparks stay that move by up to seven pixels per frame, or are drawn with their share of each
    /// pixel at any speed. Sparks that are drawn on whole pixels keep 82 % of their glow at eight pixels per frame and
    /// 15 % at twelve: renderers whose light has no fireflies set `Keep`. Without a previous frame, as in the first of
    /// a sequence, after a cut and in a single image, nothing shows that a light was not there, and all stay. Without
    /// `before`, only the neighbors count, and lights of one pixel get little bloom.
    pub struct Extract {
        /// How light is selected.
        pub method: ExtractMethod = ExtractMethod::Knee;
        /// For `Knee` and `Gate`: the quantity that the threshold applies to.
        pub brightness: Brightness = Brightness::Max => when("method", [ExtractMethod::Knee, ExtractMethod::Gate]);
        /// Where the selection begins, in the units of the source. For `Emissive`: the least alpha that is selected;
        /// 0 selects every pixel by its alpha.
        pub threshold: f32 = 1.0
            => within(0.0..=65504.0), usually(0.0..=4.0),
               when("method", [ExtractMethod::Knee, ExtractMethod::Gate, ExtractMethod::Emissive]);
        /// For `Knee` and `Gate`: half of the width of the transition around the threshold, which begins at black if it
        /// is as wide as the threshold or wider. 0 is a hard edge, which flickers in motion.
        pub knee: f32 = 0.1
            => within(0.0..=65504.0), usually(0.0..=1.0), when("method", [ExtractMethod::Knee, ExtractMethod::Gate]);
        /// How single bright pixels are limited.
        pub fireflies: Fireflies = Fireflies::Keep => neutral(Fireflies::Keep);
        /// Factor of the result. 1 changes nothing.
        pub intensity: f32 = 1.0 => within(0.0..=64.0), usually(0.0..=4.0), neutral(1.0);
    }

    const INPUTS: &'static [Input] = &[
        Input::image("source", "The image, exposed if the threshold is a display brightness.").accepts(STATES),
        Input::image("before", "For `fireflies: Limit`: `peaks` of the previous frame.").accepts(STATES).optional(),
    ];
    const OUTPUTS: &'static [Output] = &[
        Output::image("result", OutputState::same("source"), "The selected light, black elsewhere."),
        Output::image(
            "peaks",
            OutputState::same("source"),
            "The largest channel of each 2x2 pixels of the source, in red: for `before` of the next frame. Its size is \
             rounded up.",
        ),
    ];
}

/// Values of the shader's parameters: threshold, knee and intensity.
struct Numbers(f32, f32, f32);

impl Extract {
    fn function(&self) -> &'static str {
        match (self.method, self.brightness) {
            (ExtractMethod::Knee, Brightness::Max) => "extract_knee_max",
            (ExtractMethod::Knee, Brightness::Luminance) => "extract_knee_luminance",
            (ExtractMethod::Gate, Brightness::Max) => "extract_gate_max",
            (ExtractMethod::Gate, Brightness::Luminance) | (ExtractMethod::Clamp, _) => "extract_gate_luminance",
            (ExtractMethod::Emissive, _) => "extract_emissive",
            (ExtractMethod::All, _) => "extract_all",
        }
    }

    /// `Clamp` is a gate from 0.8 to 1 with a factor of 2. A transition never begins below black: it would select light
    /// that is not there.
    fn numbers(&self) -> Numbers {
        match self.method {
            ExtractMethod::Clamp => Numbers(0.9, 0.1, 2.0 * self.intensity),
            _ => Numbers(self.threshold, self.knee.min(self.threshold), self.intensity),
        }
    }
}

impl Extract {
    /// The image with single bright pixels limited.
    fn without_fireflies(pass: &mut Recorder<'_>, source: ImageId) -> ImageId {
        if pass.is_zero("before") {
            return source;
        }
        let result = pass.transient("limited", ImageDesc::new(pass.desc(source).size));
        let (function, by_neighbors) = match pass.wired("before") {
            true => ("extract_limited_since", "extract_limited_around_since"),
            false => ("extract_limited", "extract_limited_around"),
        };
        let form = ByNeighbors {
            source: "source",
            number: "extract_number",
            changes: "extract_stands_out",
            function: by_neighbors,
        };
        pass.function(&SHADER, function).by_neighbors(form).write_to(result);
        result
    }
}

impl Node for Extract {
    fn is_identity(&self, inputs: &InputValues) -> bool {
        // With `method: All` it still has peaks, so the source does not replace it.
        inputs.is_zero("source")
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let result = ImageDesc::new(pass.desc(source).size);
        if pass.is_output_used("peaks") {
            let peaks = ImageDesc::new(result.size.div_up(2)).format(Format::R16Float);
            pass.function(&SHADER, "extract_peaks").quad_variant("extract_peaks_of_square").write("peaks", peaks);
        }
        let light = match self.fireflies {
            Fireflies::Keep => source,
            Fireflies::Limit => Self::without_fireflies(pass, source),
        };
        let Numbers(threshold, knee, intensity) = self.numbers();
        pass.function(&SHADER, self.function())
            .read("source", light)
            .set("threshold", threshold)
            .set("knee", knee)
            .set("intensity", intensity)
            .write("result", result);
    }
}

//! Extract: keeps the light that bloom spreads.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("extract");

choices! {
    /// How light is selected.
    pub enum ExtractMethod {
        /// The part above the threshold, with a quadratic knee: the subtractive threshold of Jimenez, Unity and
        /// Tsushima.
        Knee,
        /// All of the light of a pixel above the threshold, with a smooth step between: the threshold of Lynx.
        Gate,
        /// A luminance clamp for an image after the exponential curve: twice the colour, through a smooth step from
        /// luminance 0.8 to 1. Ignores `threshold`, `knee` and `brightness`.
        Clamp,
        /// Alpha is the emissive strength. The result is colour times alpha where alpha is above the threshold:
        /// Caracal's selective bloom.
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

params! {
    /// Selects the light that bloom spreads: the colour of the source times a weight.
    ///
    /// Place it after the exposure, so that the threshold is a display brightness and does not depend on the units of
    /// the scene. Black stays black. Results are limited to 65504. Alpha passes unchanged.
    pub struct Extract {
        /// How light is selected.
        pub method: ExtractMethod = ExtractMethod::Knee;
        /// For `Knee` and `Gate`: the quantity that the threshold applies to.
        pub brightness: Brightness = Brightness::Max;
        /// Where the selection begins, in the units of the source. For `Emissive`: in alpha.
        pub threshold: f32 = 1.0 => within(0.0..=65504.0), usually(0.0..=4.0);
        /// For `Knee` and `Gate`: half of the width of the transition around the threshold. 0 is a hard edge, which
        /// flickers in motion.
        pub knee: f32 = 0.1 => within(0.0..=65504.0), usually(0.0..=1.0);
        /// Factor of the result. 1 changes nothing.
        pub intensity: f32 = 1.0 => within(0.0..=64.0), usually(0.0..=4.0), neutral(1.0);
    }
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

    /// `Clamp` is a gate from 0.8 to 1 with a factor of 2.
    fn numbers(&self) -> Numbers {
        match self.method {
            ExtractMethod::Clamp => Numbers(0.9, 0.1, 2.0 * self.intensity),
            _ => Numbers(self.threshold, self.knee, self.intensity),
        }
    }
}

impl Node for Extract {
    const INPUTS: &'static [Input] =
        &[Input::image("source", "The image, exposed if the threshold is a display brightness.").accepts(&[
            ColorState::Scene,
            ColorState::Exposed,
            ColorState::DisplayLinear,
        ])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::same("source"), "The selected light, black elsewhere.")];
    const FALLBACK: Fallback = Fallback::Zero;

    fn identity(&self, arrivals: &Arrivals) -> Option<Fallback> {
        let keeps_all = self.method == ExtractMethod::All && self.intensity == 1.0;
        match arrivals.is_zero("source") {
            true => Some(Fallback::Zero),
            false => keeps_all.then_some(Fallback::input("source")),
        }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let source = pass.image("source");
        let result = ImageDesc::new(pass.desc(source).size);
        let Numbers(threshold, knee, intensity) = self.numbers();
        pass.function(&SHADER, self.function())
            .set("threshold", threshold)
            .set("knee", knee)
            .set("intensity", intensity)
            .write("result", result);
    }
}

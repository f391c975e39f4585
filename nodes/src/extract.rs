//! Extract: keeps what glows.

use afterimage_graph::prelude::*;

static SHADER: Shader = shader!("extract");

choices! {
    /// How the light that glows is told from the rest.
    pub enum ExtractMethod {
        /// Only the part above the threshold glows, with a quadratic knee: the subtractive threshold of Jimenez, Unity and Tsushima.
        Knee,
        /// A light that passes the threshold glows in full, with a smooth step between: what Lynx means.
        Gate,
        /// The course deck's luminance clamp, for a picture after the exponential curve: twice the colour, through a gate that opens
        /// from luminance 0.8 to 1. Threshold, knee and brightness are not read.
        Clamp,
        /// Alpha is emissive strength, and the colour times alpha glows where alpha is above the threshold: Caracal's selective bloom.
        Emissive,
        /// Everything glows: for a composite that mixes.
        All,
    }
}

choices! {
    /// What a threshold is compared with.
    pub enum Brightness {
        /// The largest channel, which does not overlook saturated lights.
        Max,
        /// Luminance of Rec.709: a pure blue light counts for 7 per cent of its value.
        Luminance,
    }
}

params! {
    /// Keeps what glows: the source's colours, each times a weight.
    ///
    /// Put it after the exposure, so that the threshold means what the viewer will see as bright and does not move with the units of the
    /// scene. Black stays black. Results are limited to 65504. Alpha passes through.
    pub struct Extract {
        /// How the light that glows is told from the rest.
        pub method: ExtractMethod = ExtractMethod::Knee;
        /// What the threshold is compared with, for Knee and Gate.
        pub brightness: Brightness = Brightness::Max;
        /// Where glowing begins, in the light of the source; for Emissive, in alpha.
        pub threshold: f32 = 1.0 => within(0.0..=65504.0), usually(0.0..=4.0);
        /// Half the width of the transition around the threshold, for Knee and Gate; 0 is a hard edge, which flickers in motion.
        pub knee: f32 = 0.1 => within(0.0..=65504.0), usually(0.0..=1.0);
        /// Factor of the result; 1 changes nothing.
        pub intensity: f32 = 1.0 => within(0.0..=64.0), usually(0.0..=4.0), neutral(1.0);
    }
}

/// The numbers of the shader: threshold, knee and intensity.
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

    /// The deck's clamp is a gate from 0.8 to 1 with a factor of 2.
    fn numbers(&self) -> Numbers {
        match self.method {
            ExtractMethod::Clamp => Numbers(0.9, 0.1, 2.0 * self.intensity),
            _ => Numbers(self.threshold, self.knee, self.intensity),
        }
    }
}

impl Node for Extract {
    const INPUTS: &'static [Input] =
        &[Input::image("source", "The picture, exposed if its threshold is to mean a brightness on the screen.")
            .accepts(&[ColorState::Scene, ColorState::Exposed, ColorState::DisplayLinear])];
    const OUTPUTS: &'static [Output] =
        &[Output::image("result", OutputState::Same("source"), "The light that glows, black elsewhere.")];
    const FALLBACK: Fallback = Fallback::Zero;

    fn identity(&self, arrivals: &Arrivals) -> Option<Fallback> {
        let keeps_all = self.method == ExtractMethod::All && self.intensity == 1.0;
        match arrivals.is_zero("source") {
            true => Some(Fallback::Zero),
            false => keeps_all.then_some(Fallback::Input("source")),
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

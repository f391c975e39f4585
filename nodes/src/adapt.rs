//! Adapt: an exposure that follows a mean luminance.

use afterimage_graph::prelude::*;

use crate::metering::{Adaptation, EV100_OF_LUMINANCE, wanted_before};

static SHADER: Shader = shader!("adapt");

params! {
    /// Finds the exposure that brings a mean luminance to the key, and follows it over time, in stops.
    ///
    /// It behaves in time as AutoExposure does and gives the same four numbers, so that either can feed an Exposure: (stops, mean of log2
    /// luminance, lux, 1), all 0 before anything was metered. A picture that is dark all over holds the last exposure.
    pub struct Adapt {
        /// The luminance that the mean is brought to; 0.18 is middle grey.
        pub key: f32 = 0.18 => within(0.0001..=10.0), usually(0.05..=0.5), unit("luminance");
        /// A scene darker than this is exposed as if it were this bright.
        pub min_ev: f32 = -4.0 => within(-24.0..=24.0), unit("EV100");
        /// A scene brighter than this is exposed as if it were this dark.
        pub max_ev: f32 = 16.0 => within(-24.0..=24.0), unit("EV100");
        /// Added to the exposure; 0 changes nothing, 1 doubles the light.
        pub compensation: f32 = 0.0 => within(-16.0..=16.0), usually(-4.0..=4.0), unit("stops"), neutral(0.0);
        /// How the exposure follows.
        pub adaptation: Adaptation = Adaptation::Exponential;
        /// How fast when the scene got darker: per second for Exponential, stops per second for Linear.
        pub rate_dark: f32 = 1.0 => within(0.0..=1000.0), usually(0.1..=10.0), unit("1/s");
        /// How fast when the scene got brighter; eyes are faster this way.
        pub rate_bright: f32 = 3.0 => within(0.0..=1000.0), usually(0.1..=10.0), unit("1/s");
    }
}

impl Node for Adapt {
    const INPUTS: &'static [Input] = &[Input::new("mean", PortType::Value, "The result of a MeanLuminance.")];
    const OUTPUTS: &'static [Output] =
        &[Output::new("result", PortType::Value, OutputState::Nothing, "Stops, mean, lux, and 1 once they are known.")];
    const FALLBACK: Fallback = Fallback::Absent;

    fn verify(&self) -> Result<(), String> {
        if self.min_ev <= self.max_ev { Ok(()) } else { Err("`max_ev` must not be below `min_ev`".into()) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let result = pass.output_value("result", BufferLife::Persistent);
        let before = wanted_before(pass);
        let entry = match self.adaptation {
            Adaptation::Exponential => "adapt_exponential",
            Adaptation::Linear => "adapt_linear",
        };
        pass.compute(&SHADER, entry)
            .buffer("result", result)
            .buffer("wanted_before", before)
            .set("key_log2", self.key.log2())
            .set("lowest_mean", self.min_ev - EV100_OF_LUMINANCE)
            .set("highest_mean", self.max_ev - EV100_OF_LUMINANCE)
            .dispatch([1, 1, 1]);
    }
}

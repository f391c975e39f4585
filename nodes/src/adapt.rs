//! Adapt: an exposure that follows a mean luminance.

use afterimage_graph::prelude::*;

use crate::metering::{Adaptation, EV100_OF_LUMINANCE, HIGHEST_EV, LOWEST_EV, give_fixed, is_settled, wanted_before};

static SHADER: Shader = shader!("adapt");

node_kind! {
    /// Computes the exposure that maps a mean luminance to `key`, and adapts it over time. The result is in stops.
    ///
    /// The adaptation in time and the four numbers of the result are those of `AutoExposure`, so that either kind can
    /// feed an `Exposure`: (stops, mean of log2 luminance, lux, 1). All four are 0 before the first metered frame. If
    /// the whole image is dark, the last exposure is kept. With equal limits the exposure is fixed, and if nobody reads
    /// what is metered, nothing is.
    pub struct Adapt {
        /// Target of the mean, in exposed luminance. 0.18 is middle gray.
        pub key: f32 = 0.18 => within(0.0001..=10.0), usually(0.05..=0.5), unit("luminance");
        /// Lower limit of the metered brightness. A darker scene is exposed as if it had this brightness.
        pub min_ev: f32 = LOWEST_EV => within(-24.0..=24.0), unit("EV100");
        /// Upper limit of the metered brightness. A brighter scene is exposed as if it had this brightness.
        pub max_ev: f32 = HIGHEST_EV => within(-24.0..=24.0), unit("EV100");
        /// Stops added to the exposure. 0 changes nothing, 1 doubles the light.
        pub compensation: f32 = 0.0 => within(-16.0..=16.0), usually(-4.0..=4.0), unit("stops"), neutral(0.0);
        /// How the exposure approaches its target.
        pub adaptation: Adaptation = Adaptation::Exponential;
        /// Adaptation speed when the scene gets darker: 1/s for `Exponential`, stops per second for `Linear`.
        pub rate_dark: f32 = 1.0 => within(0.0..=1000.0), usually(0.1..=10.0), logarithmic(), unit("1/s");
        /// Adaptation speed when the scene gets brighter. The eye is faster in this direction.
        pub rate_bright: f32 = 3.0 => within(0.0..=1000.0), usually(0.1..=10.0), logarithmic(), unit("1/s");
        /// Holds the exposure: it stays as it is, or as the first frame sets it. Where mean and lux are read, they
        /// still follow the scene; otherwise nothing is metered, and with rates of 0 neither.
        pub hold: bool = false => neutral(false);
    }

    const INPUTS: &'static [Input] =
        &[Input::new("mean", PortType::Value, "The result of a `MeanLuminance`.").content("mean-luminance")];
    const OUTPUTS: &'static [Output] =
        &[Output::new("result", PortType::Value, OutputState::Nothing, "Stops, mean, lux, and 1 once they are valid.")
            .content("exposure")];
    const INVARIANTS: Invariants = Invariants { is_exposure: true, ..Invariants::DEFAULT };
}

impl Node for Adapt {
    fn verify(&self) -> Result<(), String> {
        if self.min_ev <= self.max_ev { Ok(()) } else { Err("`max_ev` must not be below `min_ev`".into()) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        if give_fixed(pass, [self.min_ev, self.max_ev], self.key, &["min_ev", "max_ev"]) {
            return;
        }
        if is_settled(pass, self.hold, [self.rate_dark, self.rate_bright]) {
            pass.initialize_once();
        }
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

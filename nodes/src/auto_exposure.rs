//! AutoExposure: the exposure that a histogram asks for, followed as an eye would.

use afterimage_graph::prelude::*;

use crate::metering::{Adaptation, EV100_OF_LUMINANCE, wanted_before};

static SHADER: Shader = shader!("auto_exposure");

choices! {
    /// What bright lights may do to the exposure.
    pub enum AutoExposureHighlights {
        /// Nothing: only the mean counts.
        Ignore,
        /// Hold it back, so that the bright end of the percentiles does not pass `highlight_threshold` once exposed.
        Protect,
    }
}

params! {
    /// Finds the exposure that brings the mean of log2 luminance between two percentiles to the key, and follows it over time.
    ///
    /// The mean is taken over the counted pixels only and cut exactly at the percentiles, with parts of a bin where they fall inside
    /// one; equal or swapped percentiles meter the quantile `low`. Where nothing was counted the last exposure is held, 0 stops if there
    /// is none. The first frame and the first after a cut snap to what they ask for, and so does an exposure within 1/1024 stop
    /// of an aim that rests. A step of zero, negative or unknown time changes nothing; a very long one arrives and never overshoots.
    /// Nothing is read back from the device, and sums have a fixed order: the same frames give the same bits.
    ///
    /// Between two frames the aim is taken to move in a straight line, from what the frame before asked for to what this one does, and
    /// `Exponential` follows that line exactly: e + (a - e) s + (b - a) (1 - s / (r dt)), s = 1 - exp(-r dt), for an aim from a to b. So
    /// the same walk is exposed alike at 24 and at 144 frames in a second, which an aim held for a frame is not. The rate r goes by
    /// whether this frame asks for more or less than the exposure has, and the result stays between the two.
    ///
    /// The result is (stops, metered mean of log2 luminance, lux, 1), all 0 before anything was metered. Lux is the illuminance of a
    /// grey card of 18 % with the metered luminance, pi L / 0.18: right where luminance is in cd/m2 and the histogram had an albedo,
    /// an estimate otherwise. It follows the picture at once.
    pub struct AutoExposure {
        /// Share of the counted pixels, from the darkest, that the mean leaves out.
        pub low: f32 = 0.4 => within(0.0..=1.0);
        /// Share at which the mean ends: 0.95 leaves out the brightest twentieth.
        pub high: f32 = 0.95 => within(0.0..=1.0);
        /// The luminance that the metered mean is brought to; 0.18 is middle grey.
        pub key: f32 = 0.18 => within(0.0001..=10.0), usually(0.05..=0.5), unit("luminance");
        /// A scene darker than this is exposed as if it were this bright: a night stays dark. -4 is moonlight.
        pub min_ev: f32 = -4.0 => within(-24.0..=24.0), unit("EV100");
        /// A scene brighter than this is exposed as if it were this dark. 16 is snow in the sun.
        pub max_ev: f32 = 16.0 => within(-24.0..=24.0), unit("EV100");
        /// Added to the exposure; 0 changes nothing, 1 doubles the light.
        pub compensation: f32 = 0.0 => within(-16.0..=16.0), usually(-4.0..=4.0), unit("stops"), neutral(0.0);
        /// Brightness of the scene at the four points of the compensation curve, rising.
        pub curve_ev: [f32; 4] = [-4.0, 2.0, 8.0, 14.0] => within(-24.0..=24.0), unit("EV100");
        /// What the curve adds to the exposure at its points; straight lines between them, level beyond. 0 changes nothing.
        pub curve_stops: [f32; 4] = [0.0; 4] => within(-16.0..=16.0), usually(-4.0..=4.0), unit("stops"), neutral([0.0f32; 4]);
        /// How the exposure follows.
        pub adaptation: Adaptation = Adaptation::Exponential;
        /// How fast when the scene got darker: per second for Exponential, stops per second for Linear.
        pub rate_dark: f32 = 1.0 => within(0.0..=1000.0), usually(0.1..=10.0), unit("1/s");
        /// How fast when the scene got brighter; eyes are faster this way.
        pub rate_bright: f32 = 3.0 => within(0.0..=1000.0), usually(0.1..=10.0), unit("1/s");
        /// What bright lights may do to the exposure.
        pub highlights: AutoExposureHighlights = AutoExposureHighlights::Ignore;
        /// The exposed luminance that the percentile `high` may reach in highlight mode Protect; 1 is white without a tone curve.
        pub highlight_threshold: f32 = 10.0 => within(0.01..=65504.0), usually(0.5..=20.0), unit("luminance");
    }
}

/// More stops than any exposure has: highlights never hold it back.
const NO_LIMIT: f32 = 256.0;

impl Node for AutoExposure {
    const INPUTS: &'static [Input] =
        &[Input::new("histogram", PortType::Table, "The result of a Histogram, with its range.")];
    const OUTPUTS: &'static [Output] = &[Output::new(
        "result",
        PortType::Value,
        OutputState::Nothing,
        "Stops, metered mean, lux, and 1 once they are known.",
    )];
    const FALLBACK: Fallback = Fallback::Absent;

    fn verify(&self) -> Result<(), String> {
        if self.min_ev > self.max_ev {
            return Err("`max_ev` must not be below `min_ev`".into());
        }
        if self.curve_ev.is_sorted() { Ok(()) } else { Err("the numbers of `curve_ev` must rise".into()) }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        let result = pass.output_value("result", BufferLife::Persistent);
        let before = wanted_before(pass);
        let entry = match self.adaptation {
            Adaptation::Exponential => "auto_exposure_exponential",
            Adaptation::Linear => "auto_exposure_linear",
        };
        let limit = match self.highlights {
            AutoExposureHighlights::Ignore => NO_LIMIT,
            AutoExposureHighlights::Protect => self.highlight_threshold.log2(),
        };
        pass.compute(&SHADER, entry)
            .buffer("result", result)
            .buffer("wanted_before", before)
            .set("key_log2", self.key.log2())
            .set("lowest_mean", self.min_ev - EV100_OF_LUMINANCE)
            .set("highest_mean", self.max_ev - EV100_OF_LUMINANCE)
            .set("highlight_log2", limit)
            .dispatch([1, 1, 1]);
    }
}

//! AutoExposure: an exposure computed from a histogram, with adaptation over time.

use afterimage_graph::prelude::*;

use crate::metering::{Adaptation, EV100_OF_LUMINANCE, HIGHEST_EV, LOWEST_EV, give_fixed, is_settled, wanted_before};

static SHADER: Shader = shader!("auto_exposure");

choices! {
    /// Effect of bright lights on the exposure.
    pub enum AutoExposureHighlights {
        /// They do not: only the mean counts.
        Ignore,
        /// They limit it: the percentile `high` stays at or below `highlight_threshold` after exposure.
        Protect,
    }
}

node_kind! {
    /// Computes the exposure that maps the mean log2 luminance to `key`, and adapts it over time.
    ///
    /// The mean is that of the counted pixels between two percentiles. It is cut exactly at the percentiles: a bin that
    /// a percentile divides counts in part. Equal or swapped percentiles give the quantile `low`. If no pixel was
    /// counted, the last exposure is kept, or 0 stops if there is none. The first frame, and the first frame after a
    /// reset, use the target at once. An exposure within 1/1024 stop of a constant target becomes equal to it. A time
    /// step that is zero, negative or NaN changes nothing. A very long time step reaches the target and never
    /// overshoots. Nothing is read back from the device, and sums have a fixed order, so equal frames give equal bits.
    ///
    /// Between two frames the target is taken to move on a straight line, from the target of the previous frame to that
    /// of this frame. `Exponential` follows this line exactly: e + (a - e) s + (b - a) (1 - s / (r dt)), s = 1 - exp(-r
    /// dt), for a target that moves from a to b. The result is therefore the same at 24 and at 144 frames per second,
    /// which it is not if the target is constant within a frame. The rate r is that of the direction from the current
    /// exposure to the target of this frame. The result lies between these two.
    ///
    /// The result is (stops, metered mean of log2 luminance, lux, 1). All four are 0 before the first metered frame.
    /// Lux is the illuminance of a gray card of 18 % with the metered luminance L: pi L / 0.18. It is exact where
    /// luminance is in cd/m2 and the histogram has an albedo, and an estimate otherwise. It is not adapted over time.
    ///
    /// With equal limits and neither highlights nor a curve the exposure is fixed. If nobody reads what is metered, no
    /// histogram is made, mean and lux are those of the limits, and the exposure does not depend on earlier frames.
    ///
    /// `range` is (stops between the dark and the bright part, log2 luminance of the dark part, of the bright part, 1),
    /// all 0 before the first metered frame. The stops approach those of each frame exponentially, at `rate_dark`. A
    /// part is a mean of log2 luminance around a percentile p: from p - q to p + q, q = min(p, 1 - p), pixels have
    /// the weight 6 x (1 - x), with x from 0 to 1. So the range changes as a lamp grows, and does not jump when it
    /// reaches a percentile. With the defaults, light on a hundredth of the image counts 3 %, and on a tenth whole.
    pub struct AutoExposure {
        /// Lower percentile: the share of the counted pixels, from the darkest, that the mean ignores.
        pub low: f32 = 0.4 => within(0.0..=1.0);
        /// Upper percentile: the share at which the mean ends. 0.95 ignores the brightest 5 %.
        pub high: f32 = 0.95 => within(0.0..=1.0);
        /// The percentile around which `range` begins. At 0.05 it is a mean of the darkest tenth.
        pub dark: f32 = 0.05 => within(0.0..=1.0);
        /// The percentile around which `range` ends. At 0.95 it is a mean of the brightest tenth.
        pub bright: f32 = 0.95 => within(0.0..=1.0);
        /// Target of the metered mean, in exposed luminance. 0.18 is middle gray.
        pub key: f32 = 0.18 => within(0.0001..=10.0), usually(0.05..=0.5), unit("luminance");
        /// Lower limit of the metered brightness. A darker scene is exposed as if it had this brightness, so that night
        /// stays dark. -4 is moonlight. The default is the lower end of the range of `Histogram`.
        pub min_ev: f32 = LOWEST_EV => within(-24.0..=24.0), unit("EV100");
        /// Upper limit of the metered brightness. A brighter scene is exposed as if it had this brightness. 16 is snow
        /// in sunlight. The default is the upper end of the range of `Histogram`.
        pub max_ev: f32 = HIGHEST_EV => within(-24.0..=24.0), unit("EV100");
        /// Stops added to the exposure. 0 changes nothing, 1 doubles the light.
        pub compensation: f32 = 0.0 => within(-16.0..=16.0), usually(-4.0..=4.0), unit("stops"), neutral(0.0);
        /// Scene brightness at the four points of the compensation curve, in ascending order.
        pub curve_ev: [f32; 4] = [-4.0, 2.0, 8.0, 14.0] => within(-24.0..=24.0), unit("EV100");
        /// Stops that the compensation curve adds at its four points. The curve is linear between them and constant
        /// beyond the first and the last. 0 changes nothing.
        pub curve_stops: [f32; 4] = [0.0; 4]
            => within(-16.0..=16.0), usually(-4.0..=4.0), unit("stops"), neutral([0.0f32; 4]);
        /// How the exposure approaches its target.
        pub adaptation: Adaptation = Adaptation::Exponential;
        /// Adaptation speed when the scene gets darker: 1/s for `Exponential`, stops per second for `Linear`.
        pub rate_dark: f32 = 1.0 => within(0.0..=1000.0), usually(0.1..=10.0), logarithmic(), unit("1/s");
        /// Adaptation speed when the scene gets brighter. The eye is faster in this direction.
        pub rate_bright: f32 = 3.0 => within(0.0..=1000.0), usually(0.1..=10.0), logarithmic(), unit("1/s");
        /// Holds the exposure: it stays as it is, or as the first frame sets it. Where mean and lux are read, they
        /// still follow the scene; otherwise nothing is metered, and with rates of 0 neither.
        pub hold: bool = false => neutral(false);
        /// How bright lights affect the exposure.
        pub highlights: AutoExposureHighlights = AutoExposureHighlights::Ignore;
        /// For `highlights: Protect`: the exposed luminance that the percentile `high` must not exceed. 1 is display
        /// white without a tone curve.
        pub highlight_threshold: f32 = 10.0
            => within(0.01..=65504.0), usually(0.5..=20.0), logarithmic(), unit("luminance"),
               when("highlights", [AutoExposureHighlights::Protect]);
    }

    const INPUTS: &'static [Input] =
        &[Input::new("histogram", PortType::Table, "The result of a `Histogram`, with its range.")
            .content("histogram")];
    const OUTPUTS: &'static [Output] = &[
        Output::new(
            "result",
            PortType::Value,
            OutputState::Nothing,
            "Stops, metered mean, lux, and 1 once they are valid.",
        )
        .content("exposure"),
        Output::new("range", PortType::Value, OutputState::Nothing, "The range of luminance: stops, from, to, and 1.")
            .content("luminance-range"),
    ];
    const INVARIANTS: Invariants = Invariants { is_exposure: true, ..Invariants::DEFAULT };
}

/// Larger than any exposure in stops: with it, highlights never limit the exposure.
const NO_LIMIT: f32 = 256.0;

impl Node for AutoExposure {
    fn verify(&self) -> Result<(), String> {
        if self.min_ev > self.max_ev {
            return Err("`max_ev` must not be below `min_ev`".into());
        }
        if self.curve_ev.is_sorted() {
            Ok(())
        } else {
            Err("the numbers of `curve_ev` must be in ascending order".into())
        }
    }

    fn record(&self, pass: &mut Recorder<'_>) {
        // Only then the exposure does not depend on the histogram.
        let is_plain = self.curve_stops == [0.0; 4] && self.highlights == AutoExposureHighlights::Ignore;
        let decisive = ["min_ev", "max_ev", "curve_stops", "highlights"];
        if is_plain
            && !pass.is_output_used("range")
            && give_fixed(pass, [self.min_ev, self.max_ev], self.key, &decisive)
        {
            return;
        }
        if is_settled(pass, self.hold, [self.rate_dark, self.rate_bright]) {
            pass.initialize_once();
        }
        let result = pass.output_value("result", BufferLife::Persistent);
        let range = pass.output_value("range", BufferLife::Persistent);
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
            .buffer("range", range)
            .set("key_log2", self.key.log2())
            .set("lowest_mean", self.min_ev - EV100_OF_LUMINANCE)
            .set("highest_mean", self.max_ev - EV100_OF_LUMINANCE)
            .set("highlight_log2", limit)
            .dispatch([1, 1, 1]);
    }
}

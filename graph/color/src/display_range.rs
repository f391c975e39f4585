//! The range of display-linear color that a node makes, compared with that of the display after it.

use afterimage_graph::color::{Colorimetry, Decimal};

/// The range of display-linear color, from 0 to a peak.
#[derive(Clone, Copy, Debug)]
pub struct DisplayRange {
    /// The luminance of display-linear 1 in cd/m2.
    pub white_nits: f64,
    /// The highest luminance in cd/m2.
    pub peak_nits: f64,
}

/// Luminances that differ by less than this share are equal: `peak` is a quotient that people round.
const TOLERANCE: f64 = 0.01;

impl DisplayRange {
    /// Checks that a display shows this range without clipping it, and with the same luminance. The error is one
    /// sentence.
    pub fn suits(&self, display: &Colorimetry) -> Result<(), String> {
        let Self { white_nits: white, peak_nits: peak } = *self;
        let exceeds = |limit: f64| peak > limit * (1.0 + TOLERANCE);
        if !display.is_hdr() {
            return match exceeds(white) {
                true => Err(format!(
                    "light up to {peak:.0} cd/m2 is above SDR white ({white:.0} cd/m2), where an SDR signal ends"
                )),
                false => Ok(()),
            };
        }
        let stated = |nits: Option<Decimal>, otherwise: f64| nits.map_or(otherwise, Decimal::get);
        let (display_white, display_peak) = (stated(display.white_nits, white), stated(display.peak_nits, peak));
        if (display_white / white - 1.0).abs() > TOLERANCE {
            return Err(format!("SDR white is {white:.0} cd/m2 here and {display_white:.0} cd/m2 there"));
        }
        match exceeds(display_peak) {
            true => Err(format!("light up to {peak:.0} cd/m2 is above its peak of {display_peak:.0} cd/m2")),
            false => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use afterimage_graph::color::{Chromaticities, Transfer};

    fn display(transfer: Transfer) -> Colorimetry {
        Colorimetry::new(Chromaticities::REC2020, transfer)
    }

    #[test]
    fn light_suits_a_display_with_its_white_and_at_least_its_peak() {
        let light = DisplayRange { white_nits: 203.0, peak_nits: 999.98 };
        let hdr = |white, peak| light.suits(&display(Transfer::Pq).nits(white, peak));
        assert!([hdr(203.0, 1000.0), hdr(203.0, 4000.0), hdr(203.0, 995.0)].iter().all(Result::is_ok));
        assert!(light.suits(&display(Transfer::Hlg)).is_ok(), "a display that states nothing");
        assert!(
            hdr(100.0, 1000.0)
                .expect_err("it does not suit")
                .contains("SDR white is 203 cd/m2 here and 100 cd/m2 there")
        );
        assert!(hdr(203.0, 500.0).expect_err("it does not suit").contains("above its peak of 500 cd/m2"));
        assert!(
            light.suits(&display(Transfer::Srgb)).expect_err("it does not suit").contains("where an SDR signal ends")
        );
        let sdr = DisplayRange { white_nits: 203.0, peak_nits: 203.0 };
        assert!(sdr.suits(&display(Transfer::Srgb)).is_ok());
    }
}
